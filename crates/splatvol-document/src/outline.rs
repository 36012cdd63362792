//! Outlines of items: the world positions that an automatic camera brings into the picture.
//!
//! Scans and captures have strays far from everything else, which would shrink the picture. Places farther from the
//! innermost 99 % than a share of its size are left out of the outline (not out of the picture).

use glam::{DAffine3, DVec3};
use splatvol_scene::{Content, Gaussians, Item, Points};

use crate::keys::names::Fit;
use crate::mesh_outline::visible_cells;
use crate::visible::visible_outline;

/// Maximum number of places examined per item.
const MOST: usize = 50_000;
/// Share of places on either side of each axis that may be strays...
const STRAYS: f64 = 0.005;
/// ...if they lie farther out than this share of the others' size.
const REACH: f64 = 0.1;
/// Radius of Gaussians, standard deviations.
const SIGMAS: f64 = 2.0;
/// Share of Gaussians that keep their own radius; larger ones get that of the last of these.
const USUAL: f64 = 0.95;

/// Least radius of the framed part of Gaussians, in their own lengths: as published, none nearer to the camera than 0.2
/// is drawn, and a camera with the usual field of view is four radii away.
const LEAST: f64 = 0.08;

/// Most points of a cloud that is sparse: its discs reach visibly beyond their middles.
const SPARSE: usize = 20_000;
/// A number of Gaussians that are few...
const FEW: usize = 100;
/// ...and the share of the square of their cloud's size below which they look like specks.
const SPECKS: f64 = 1e-3;

/// World positions that bound an item. Points at one place are bounded by their largest disc.
pub fn outline(item: &Item, fit: Fit) -> Vec<DVec3> {
    let places = places(item, fit);
    match (&item.content, places.first().copied()) {
        (Content::Points { points, look }, Some(place)) if places.iter().all(|&other| other == place) => {
            let frame = item.world_from_item * *points.world_from_local();
            around(place, look.radius.unwrap_or(disc(points, &frame))).collect()
        }
        _ => places,
    }
}

/// The radius with which points at one place are drawn, world: their own, or 1.
fn disc(points: &Points, world_from_local: &DAffine3) -> f64 {
    let radii = points.attributes().radii.iter().copied();
    let own = radii.reduce(f32::max).map_or(1.0, f64::from);
    own * libm::cbrt(world_from_local.matrix3.determinant().abs())
}

fn places(item: &Item, fit: Fit) -> Vec<DVec3> {
    let world = |frame: &DAffine3, places: &[[f32; 3]]| -> Vec<DVec3> {
        let frame = item.world_from_item * *frame;
        sampled(places)
            .map(|place| frame.transform_point3(place.map(f64::from).into()))
            .collect()
    };
    if fit == Fit::Volume && !matches!(item.content, Content::Volume { .. }) {
        return item.bounds().corners().to_vec();
    }
    match &item.content {
        Content::Volume {
            volume,
            transfer_function,
            ..
        } => {
            let own = match fit {
                Fit::Visible => visible_outline(volume, transfer_function),
                Fit::Volume => volume.grid().corners().to_vec(),
            };
            own.into_iter()
                .map(|place| item.world_from_item.transform_point3(place))
                .collect()
        }
        Content::Mesh {
            mesh,
            transfer_function,
            isosurfaces,
        } => {
            let seen = match isosurfaces.is_empty() {
                true => visible_cells(mesh, transfer_function),
                false => Vec::new(),
            };
            if seen.is_empty() {
                return item.bounds().corners().to_vec();
            }
            seen.into_iter()
                .map(|place| item.world_from_item.transform_point3(place))
                .collect()
        }
        Content::Points { points, look } => {
            let places = without_strays(world(points.world_from_local(), points.positions()));
            match points.len() {
                count if count > SPARSE => places,
                _ => with_discs(places, look.radius),
            }
        }
        Content::Gaussians(gaussians) => {
            let means = world(gaussians.world_from_local(), &gaussians.attributes().means);
            let radii = radii(gaussians, &item.world_from_item);
            let frame = item.world_from_item * gaussians.world_from_local();
            let least = LEAST * libm::cbrt(frame.matrix3.determinant().abs());
            if let Some(index) = alone(gaussians, &means, &radii) {
                return held_off(around(means[index], radii[index]).collect(), least);
            }
            let [low, high] = reach(&means);
            let inside = |mean: DVec3| mean.cmpge(low).all() && mean.cmple(high).all();
            let all = means
                .into_iter()
                .zip(radii)
                .filter(|(mean, _)| inside(*mean))
                .flat_map(|(mean, radius)| around(mean, radius));
            held_off(all.collect(), least)
        }
    }
}

/// An outline that is no smaller than a ball of this radius, so that the camera keeps its distance.
fn held_off(mut outline: Vec<DVec3>, least: f64) -> Vec<DVec3> {
    let low = outline.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = outline.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    if !outline.is_empty() && (high - low).max_element() < 2.0 * least {
        outline.extend(around(0.5 * (low + high), least));
    }
    outline
}

/// The ends of a ball along the axes.
fn around(mean: DVec3, radius: f64) -> impl Iterator<Item = DVec3> {
    DVec3::AXES
        .into_iter()
        .flat_map(move |axis| [mean - axis * radius, mean + axis * radius])
}

/// If a few Gaussians are so small that a picture of all would be black but for specks, the one that shows most.
fn alone(gaussians: &Gaussians, means: &[DVec3], radii: &[f64]) -> Option<usize> {
    if gaussians.len() > FEW {
        return None;
    }
    let attributes = gaussians.attributes();
    let shown = |(index, scales): (usize, &[f32; 3])| {
        let [a, b, c] = scales.map(f64::from);
        let area = (a * b).max(b * c).max(a * c);
        let share = area / f64::from(scales.iter().copied().fold(f32::MIN_POSITIVE, f32::max)).powi(2);
        share * radii[index].powi(2) * f64::from(attributes.opacities[index])
    };
    let shown: Vec<f64> = attributes.scales.iter().enumerate().map(shown).collect();
    let low = means.iter().copied().reduce(DVec3::min)?;
    let high = means.iter().copied().reduce(DVec3::max)?;
    let empty = shown.iter().sum::<f64>() < SPECKS * (high - low).length_squared();
    let most = (0..shown.len()).max_by(|&a, &b| shown[a].total_cmp(&shown[b]))?;
    empty.then_some(most)
}

/// Places of a few points, and what their discs cover around them: with a known radius, or where each has its share of
/// a surface as large as they reach.
fn with_discs(places: Vec<DVec3>, radius: Option<f64>) -> Vec<DVec3> {
    let low = places.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = places.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let share = 0.5 * (high - low).length() / (places.len().max(1) as f64).sqrt();
    let radius = radius.unwrap_or(share);
    places
        .into_iter()
        .flat_map(|place| around(place, radius))
        .collect()
}

fn sampled(places: &[[f32; 3]]) -> impl Iterator<Item = [f32; 3]> {
    places.iter().copied().step_by(places.len().div_ceil(MOST).max(1))
}

/// Radii of the sampled Gaussians, world; huge ones, such as those of a sky, are limited.
fn radii(gaussians: &Gaussians, world_from_item: &DAffine3) -> Vec<f64> {
    let frame = *world_from_item * *gaussians.world_from_local();
    let factor = SIGMAS * libm::cbrt(frame.matrix3.determinant().abs());
    let radii: Vec<f64> = sampled(&gaussians.attributes().scales)
        .map(|scales| factor * f64::from(scales.into_iter().fold(0.0, f32::max)))
        .collect();
    let mut sorted = radii.clone();
    sorted.sort_unstable_by(f64::total_cmp);
    let most = sorted[(USUAL * (sorted.len() - 1) as f64) as usize];
    radii.into_iter().map(|radius| radius.min(most)).collect()
}

/// The places that are not strays.
fn without_strays(places: Vec<DVec3>) -> Vec<DVec3> {
    let [low, high] = reach(&places);
    places
        .into_iter()
        .filter(|place| place.cmpge(low).all() && place.cmple(high).all())
        .collect()
}

/// Box beyond which places are strays.
fn reach(places: &[DVec3]) -> [DVec3; 2] {
    let mut low = DVec3::ZERO;
    let mut high = DVec3::ZERO;
    for axis in 0..3 {
        let mut along: Vec<f64> = places.iter().map(|place| place[axis]).collect();
        along.sort_unstable_by(f64::total_cmp);
        let skipped = (STRAYS * along.len() as f64) as usize;
        (low[axis], high[axis]) = (along[skipped], along[along.len() - 1 - skipped]);
    }
    // One length for all axes: a flat thing is not full of strays.
    let reach = DVec3::splat(REACH * (high - low).max_element());
    [low - reach, high + reach]
}

#[cfg(test)]
mod tests {
    use super::*;
    use splatvol_scene::{GaussianAttributes, PointAttributes, PointLook};
    use std::sync::Arc;

    fn item(positions: Vec<[f32; 3]>) -> Item {
        let points = Points::new(positions, PointAttributes::default(), DAffine3::IDENTITY).unwrap();
        Item::new(Content::Points {
            points: Arc::new(points),
            look: PointLook::default(),
        })
    }

    #[test]
    fn strays_do_not_shrink_the_picture_but_parts_do() {
        let mut positions: Vec<_> = (0u8..200)
            .map(|i| [f32::from(i), f32::from(i % 7), 0.0])
            .collect();
        let last = |item: &Item, fit| {
            let places = outline(item, fit).into_iter().map(|place| place.x);
            places.fold(f64::NEG_INFINITY, f64::max)
        };
        // The last point, and the radius of a disc around it.
        let shown = last(&item(positions.clone()), Fit::Visible);
        assert!((206.0..206.1).contains(&shown), "{shown}");
        positions.push([5000.0, 0.0, 0.0]);
        let mut strayed = item(positions);
        assert_eq!(last(&strayed, Fit::Visible), shown);
        assert_eq!(last(&strayed, Fit::Volume), 5000.0);
        strayed.world_from_item = DAffine3::from_translation(DVec3::X);
        assert_eq!(last(&strayed, Fit::Visible), shown + 1.0);
    }

    #[test]
    fn points_at_one_place_are_bounded_by_their_disc() {
        let reach = |item: &Item, fit| {
            let places = outline(item, fit)
                .into_iter()
                .map(|place| (place - DVec3::ONE).length());
            places.fold(0.0, f64::max)
        };
        for fit in [Fit::Visible, Fit::Volume] {
            assert_eq!(reach(&item(vec![[1.0; 3]]), fit), 1.0);
            let mut several = item(vec![[1.0; 3]; 3]);
            assert_eq!(reach(&several, fit), 1.0);
            if let Content::Points { look, .. } = &mut several.content {
                look.radius = Some(0.25);
            }
            assert_eq!(reach(&several, fit), 0.25);
        }
        let attributes = PointAttributes {
            radii: vec![0.5, 2.0],
            ..PointAttributes::default()
        };
        let mut own = item(vec![[1.0; 3]; 2]);
        if let Content::Points { points, .. } = &mut own.content {
            let frame = DAffine3::from_translation(DVec3::ZERO);
            *points = Arc::new(Points::new(vec![[1.0; 3]; 2], attributes, frame).unwrap());
        }
        assert_eq!(reach(&own, Fit::Visible), 2.0);
    }

    #[test]
    fn discs_of_a_few_points_are_in_the_picture_and_those_of_many_are_points() {
        let corners = |count: usize| (0..count).map(|i| [(i % 2) as f32, (i / 2 % 2) as f32, 0.0]);
        let greatest = |item: &Item| {
            outline(item, Fit::Visible)
                .into_iter()
                .reduce(DVec3::max)
                .unwrap()
        };
        let mut few = item(corners(400).collect());
        assert!((greatest(&few).x - 1.0 - 0.5 * 2f64.sqrt() / 20.0).abs() < 1e-12);
        if let Content::Points { look, .. } = &mut few.content {
            look.radius = Some(0.25);
        }
        assert_eq!(greatest(&few), DVec3::new(1.25, 1.25, 0.25));
        assert_eq!(
            greatest(&item(corners(SPARSE + 1).collect())),
            DVec3::new(1.0, 1.0, 0.0)
        );
    }

    /// Gaussians on a line, of these standard deviations and opacities.
    fn gaussians(each: &[(f32, f32)]) -> Item {
        let count = each.len();
        let attributes = GaussianAttributes {
            means: (0..count).map(|i| [i as f32, 0.0, 0.0]).collect(),
            scales: each.iter().map(|&(scale, _)| [scale; 3]).collect(),
            rotations: vec![[1.0, 0.0, 0.0, 0.0]; count],
            opacities: each.iter().map(|&(_, opacity)| opacity).collect(),
            harmonics: vec![[1.0; 3]; count],
        };
        Item::gaussians(Gaussians::new(attributes, 0, DAffine3::IDENTITY).unwrap())
    }

    fn extent(item: &Item) -> [f64; 2] {
        let along = || outline(item, Fit::Visible).into_iter().map(|place| place.x);
        [
            along().fold(f64::INFINITY, f64::min),
            along().fold(f64::NEG_INFINITY, f64::max),
        ]
    }

    #[test]
    fn of_a_few_specks_the_one_that_shows_most_fills_the_picture() {
        let specks = [(0.01, 0.9), (0.01, 0.1), (0.012, 0.05)];
        let [low, high] = extent(&gaussians(&specks));
        // No nearer than Gaussians are drawn.
        assert!(
            (low + LEAST).abs() < 1e-6 && (high - LEAST).abs() < 1e-6,
            "{low} {high}"
        );
        // Larger ones make a picture together, and so do many.
        assert_eq!(
            extent(&gaussians(&[(0.2, 0.9); 3])).map(|x| (10.0 * x).round()),
            [-4.0, 24.0]
        );
        assert!(extent(&gaussians(&[(0.01, 0.5); 200]))[1] > 199.0);
    }
}
