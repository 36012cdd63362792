//! What an automatic camera shows of the items of a composition.
//!
//! Scans and captures have strays far from everything else, which would shrink the picture: what lies further from the
//! innermost 99 % than a share of its size is left out of the outline (not out of the picture).

use glam::{DAffine3, DVec3};
use splatvol::{Content, Gaussians, Item};

use super::visible::visible_outline;
use crate::args::Fit;

/// Places looked at per item.
const MOST: usize = 50_000;
/// Share of places on either side of each axis that may be strays...
const STRAYS: f64 = 0.005;
/// ...where they lie further out than this share of the others' size.
const REACH: f64 = 0.1;
/// Radius of Gaussians, standard deviations.
const SIGMAS: f64 = 2.0;

/// World positions that bound an item.
pub(crate) fn outline(item: &Item, fit: Fit) -> Vec<DVec3> {
    let world = |frame: &DAffine3, places: &[[f32; 3]]| {
        let frame = item.world_from_item * *frame;
        let places: Vec<DVec3> = sampled(places)
            .map(|place| frame.transform_point3(place.map(f64::from).into()))
            .collect();
        match fit {
            Fit::Visible => without_strays(places),
            Fit::Volume => item.bounds().corners().to_vec(),
        }
    };
    match &item.content {
        Content::Volume {
            volume,
            transfer_function,
        } => {
            let own = match fit {
                Fit::Visible => visible_outline(volume, transfer_function),
                Fit::Volume => volume.grid().corners().to_vec(),
            };
            own.into_iter()
                .map(|place| item.world_from_item.transform_point3(place))
                .collect()
        }
        Content::Mesh { .. } => item.bounds().corners().to_vec(),
        Content::Points { points, .. } => world(points.world_from_local(), points.positions()),
        Content::Gaussians(gaussians) => {
            let means = world(gaussians.world_from_local(), &gaussians.attributes().means);
            let radius = SIGMAS * middle_scale(gaussians, &item.world_from_item);
            let around = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * radius);
            means
                .into_iter()
                .flat_map(|mean| around.into_iter().flat_map(move |r| [mean - r, mean + r]))
                .collect()
        }
    }
}

fn sampled(places: &[[f32; 3]]) -> impl Iterator<Item = [f32; 3]> {
    places.iter().copied().step_by(places.len().div_ceil(MOST).max(1))
}

/// The median of the Gaussians' largest standard deviations, world.
fn middle_scale(gaussians: &Gaussians, world_from_item: &DAffine3) -> f64 {
    let mut scales: Vec<f32> = sampled(&gaussians.attributes().scales)
        .map(|scales| scales.into_iter().fold(0.0, f32::max))
        .collect();
    let middle = scales.len() / 2;
    let frame = *world_from_item * *gaussians.world_from_local();
    f64::from(*scales.select_nth_unstable_by(middle, f32::total_cmp).1)
        * frame.matrix3.determinant().abs().cbrt()
}

/// The places that are no strays.
fn without_strays(places: Vec<DVec3>) -> Vec<DVec3> {
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
    let (low, high) = (low - reach, high + reach);
    places
        .into_iter()
        .filter(|place| place.cmpge(low).all() && place.cmple(high).all())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use splatvol::{PointAttributes, PointLook, Points};
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
        assert_eq!(last(&item(positions.clone()), Fit::Visible), 199.0);
        positions.push([5000.0, 0.0, 0.0]);
        let mut strayed = item(positions);
        assert_eq!(last(&strayed, Fit::Visible), 199.0);
        assert_eq!(last(&strayed, Fit::Volume), 5000.0);
        strayed.world_from_item = DAffine3::from_translation(DVec3::X);
        assert_eq!(last(&strayed, Fit::Visible), 200.0);
        assert_eq!(outline(&item(vec![[1.0; 3]]), Fit::Visible), [DVec3::ONE]);
    }
}
