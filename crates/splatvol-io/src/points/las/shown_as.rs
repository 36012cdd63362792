//! Colours of LAS points that have none: by class if the file tells classes apart, else by height if the cloud is a
//! survey of a landscape. Either is shaded by intensity, which tells roofs from roads. Other scans stay grey by
//! intensity.

use splatvol_scene::{ColorMap, PointAttributes, Points};

use crate::IoError;
use crate::error::Context;
use crate::points::LoadedPoints;

/// Least share of the points that a class must have to count.
const LEAST_SHARE: f64 = 0.01;
/// Greatest height of a landscape relative to its lesser width.
const FLAT: f32 = 0.5;
/// Share of the heights at either end that the colours do not tell apart.
const TAIL: f64 = 0.01;
/// Brightness of points with no intensity.
const DARKEST: f64 = 0.55;

/// Colours of the classes of ASPRS LAS 1.4 R15, table 17; grey for those that are not things of a landscape.
fn class_color(class: u8) -> Option<[u8; 3]> {
    Some(match class {
        2 => [172, 142, 108],
        3 => [168, 200, 120],
        4 => [112, 172, 84],
        5 => [62, 132, 66],
        6 => [214, 104, 82],
        9 => [78, 132, 204],
        10 => [128, 112, 140],
        11 => [142, 142, 150],
        13..=16 => [226, 204, 92],
        17 => [196, 186, 170],
        _ => return None,
    })
}
const OTHER: [u8; 3] = [190; 3];

/// The points with colours by their class or height.
pub(super) fn colored(
    mut loaded: LoadedPoints,
    classes: &[u8],
    context: &Context<'_>,
) -> Result<LoadedPoints, IoError> {
    let (hues, what) = if classes.len() == loaded.points.len() && tell_apart(classes) {
        let color = |&class: &u8| class_color(class).unwrap_or(OTHER);
        (classes.iter().map(color).collect(), "class")
    } else if let Some(hues) = by_height(&loaded.points) {
        (hues, "height")
    } else {
        return Ok(loaded);
    };
    let own = loaded.points.attributes();
    let shaded = |(index, rgb): (usize, &[u8; 3])| {
        // Intensities are greys.
        let light = own
            .colors
            .get(index)
            .map_or(1.0, |grey| f64::from(grey[0]) / 255.0);
        let [r, g, b] = rgb.map(|c| (f64::from(c) * (DARKEST + (1.0 - DARKEST) * light)).round() as u8);
        [r, g, b, 255]
    };
    let attributes = PointAttributes {
        colors: hues.iter().enumerate().map(shaded).collect(),
        ..own.clone()
    };
    loaded.points = loaded
        .points
        .with_attributes(attributes)
        .map_err(|error| context.scene(error))?;
    let stored = &mut loaded.description.stored_type;
    *stored = format!("{stored}; no colours: shown by {what}");
    Ok(loaded)
}

/// Whether the classes tell apart at least two kinds of things of a landscape.
fn tell_apart(classes: &[u8]) -> bool {
    let mut counts = [0usize; 256];
    for &class in classes {
        counts[usize::from(class)] += 1;
    }
    let least = (LEAST_SHARE * classes.len() as f64).max(1.0);
    let kinds = (0..=255u8)
        .filter(|&class| class_color(class).is_some() && counts[usize::from(class)] as f64 >= least);
    kinds.count() >= 2
}

/// Colours from low to high; `None` if the cloud is not a landscape.
fn by_height(points: &Points) -> Option<Vec<[u8; 3]>> {
    let positions = points.positions();
    let extent = |axis: usize| {
        let along = || positions.iter().map(|place| place[axis]);
        along().fold(f32::NEG_INFINITY, f32::max) - along().fold(f32::INFINITY, f32::min)
    };
    let mut heights: Vec<f32> = positions.iter().map(|place| place[2]).collect();
    heights.sort_unstable_by(f32::total_cmp);
    let last = (heights.len() - 1) as f64;
    let [low, high] = [TAIL, 1.0 - TAIL].map(|share| heights[(share * last).round() as usize]);
    if low >= high || high - low > FLAT * extent(0).min(extent(1)) {
        return None;
    }
    let map = ColorMap::from_name("viridis").ok()?;
    let color = |place: &[f32; 3]| {
        let t = ((place[2] - low) / (high - low)).clamp(0.0, 1.0);
        map.rgb(f64::from(t)).map(|c| (255.0 * c).round() as u8)
    };
    Some(positions.iter().map(color).collect())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use glam::DAffine3;

    use super::*;
    use crate::Description;

    /// A street between two rows of houses.
    fn town(grey: Option<u8>) -> LoadedPoints {
        let places: Vec<[f32; 3]> = (0..400)
            .map(|i| [i % 20, i / 20].map(|at| at as f32))
            .map(|[x, y]| [x, y, if (8.0..12.0).contains(&x) { 0.1 * y } else { 5.0 }])
            .collect();
        let attributes = PointAttributes {
            colors: grey.map(|g| vec![[g, g, g, 255]; 400]).unwrap_or_default(),
            ..PointAttributes::default()
        };
        LoadedPoints {
            points: Points::new(places, attributes, DAffine3::IDENTITY).unwrap(),
            description: Description::default(),
            viewpoint: None,
        }
    }

    fn show(loaded: LoadedPoints, classes: &[u8]) -> LoadedPoints {
        colored(loaded, classes, &Context::new("LAS", Path::new("town.las"))).unwrap()
    }

    #[test]
    fn classes_have_colors_and_intensity_shades_them() {
        let classes: Vec<u8> = (0..400)
            .map(|i| if (8..12).contains(&(i % 20)) { 2 } else { 6 })
            .collect();
        let bright = show(town(None), &classes);
        let colors = &bright.points.attributes().colors;
        assert_eq!(
            [colors[0], colors[9]],
            [[214, 104, 82, 255], [172, 142, 108, 255]]
        );
        assert!(bright.description.stored_type.ends_with("shown by class"));
        let dark = show(town(Some(0)), &classes);
        assert_eq!(dark.points.attributes().colors[0], [118, 57, 45, 255]);
    }

    #[test]
    fn heights_are_shown_where_classes_say_nothing() {
        let shown = show(town(None), &[1; 400]);
        let colors = &shown.points.attributes().colors;
        assert!(shown.description.stored_type.ends_with("shown by height"));
        // A roof is yellow, the low end of the street is blue.
        assert!(
            colors[0][0] > colors[0][2] && colors[9][2] > colors[9][0],
            "{:?} {:?}",
            colors[0],
            colors[9]
        );
    }

    #[test]
    fn what_is_no_landscape_stays_as_it_is() {
        let mut tower = town(Some(99));
        let places = tower.points.positions().iter().map(|&[x, y, z]| [x, y, 20.0 * z]);
        let attributes = tower.points.attributes().clone();
        tower.points = Points::new(places.collect(), attributes, DAffine3::IDENTITY).unwrap();
        assert_eq!(show(tower.clone(), &[0; 400]).points, tower.points);
    }
}
