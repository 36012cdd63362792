//! One-dimensional opacity of a two-dimensional transfer function, over all gradients: steps along the values, each at
//! least as opaque as its densest point.

use super::Region;
use super::picture::Picture;

/// Values that have at most some opacity.
pub(super) struct Step {
    pub range: [f64; 2],
    pub opacity: f64,
    pub rgb: [f64; 3],
}

/// Steps between the ends of regions.
pub(super) fn of_regions(regions: &[Region]) -> Vec<Step> {
    let mut ends: Vec<f64> = regions.iter().flat_map(|r| r.value).collect();
    ends.sort_by(f64::total_cmp);
    ends.dedup();
    let step = |pair: &[f64]| {
        let middle = 0.5 * (pair[0] + pair[1]);
        let over = regions
            .iter()
            .filter(|r| r.value[0] <= middle && middle <= r.value[1]);
        let densest = over.clone().max_by(|a, b| a.opacity.total_cmp(&b.opacity));
        // Opacities of regions that overlap add up as extinctions do.
        let clear: f64 = over.map(|r| 1.0 - r.opacity).product();
        Step {
            range: [pair[0], pair[1]],
            opacity: (1.0 - clear).clamp(0.0, 1.0),
            rgb: densest.map_or([0.0; 3], |r| r.rgb),
        }
    };
    ends.windows(2).map(step).collect()
}

/// A step per column.
pub(super) fn of_picture(picture: &Picture, [low, high]: [f64; 2]) -> Vec<Step> {
    let [columns, rows] = picture.size();
    let densest = |x: usize| (0..rows).fold(0.0f64, |most, y| most.max(f64::from(picture.pixel(x, y).w)));
    let opacities: Vec<f64> = (0..columns).map(densest).collect();
    let width = (high - low) / columns as f64;
    // A column reaches to the middles of its neighbours.
    let step = |x: usize| Step {
        range: [low + x as f64 * width, low + (x + 1) as f64 * width],
        opacity: opacities[x.saturating_sub(1)..(x + 2).min(columns)]
            .iter()
            .fold(0.0f64, |most, &opacity| most.max(opacity))
            .clamp(0.0, 1.0),
        rgb: [0.8; 3],
    };
    (0..columns).map(step).collect()
}
