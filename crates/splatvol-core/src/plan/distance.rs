//! Distance of sheets: how close planes lie, and how many of them a voxel then meets.
//!
//! A field can change within a kernel's width. Along a ray of direction d that is `1 / sqrt(d^T V^-1 d)`, V the kernel's
//! covariance: of a round one its standard deviation, of a long one that is tilted much less than its extent in depth,
//! `sqrt(V_zz)`.

use glam::DVec2;
use splatvol_scene::{ImageSize, ScreenFromCamera};

use crate::footprint::FootprintShape;

/// Share of a group of sheets by which a kernel may meet more than a whole number of groups: rounding, not a sheet.
const WHOLE: f64 = 1e-9;

/// Groups of sheets that hold so many.
pub(super) fn whole_groups(groups: f64) -> usize {
    (groups - WHOLE).ceil() as usize
}

/// Thickness of sheets relative to the settings: rays of slope t meet planes `sqrt(1 + t^2)` times as far apart,
/// which is compensated beyond a slope of [`THINNER_FROM`].
pub(super) fn thinner_where_steep(steepest: f64) -> f64 {
    let along = |slope: f64| (1.0 + slope * slope).sqrt();
    (along(THINNER_FROM) / along(steepest)).min(1.0)
}

/// Tangent of the angle between ray and axis, 45 degrees, up to which sheets have the settings' thickness along the
/// axis.
const THINNER_FROM: f64 = 1.0;

/// How much finer a field can be along rays half-way to the picture's corners than a voxel is deep, relative to that of round
/// kernels.
pub(super) fn finer_rays(shape: &FootprintShape, screen: &ScreenFromCamera, size: ImageSize) -> f64 {
    let size = DVec2::new(f64::from(size.width()), f64::from(size.height()));
    let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]];
    let rays = corners.map(|corner| match screen.perspective {
        true => (DVec2::from_array(corner) * size - screen.centre) * (0.5 / screen.scale),
        false => DVec2::ZERO,
    });
    let finer = |ray: DVec2| shape.depth_sigma / shape.ray_sigma(ray) / (1.0 + ray.length_squared()).sqrt();
    rays.into_iter().map(finer).fold(1.0, f64::max)
}

/// How much closer sheets lie where a field is finer along rays than a voxel is deep, and the groups that a voxel then meets. Groups
/// are whole ones, so sheets are as close as rays are fine within [`NEARLY_FINER`].
pub(super) fn finer_sheets(groups: f64, finer: f64) -> (f64, usize) {
    let usual = whole_groups(groups);
    let wanted = whole_groups(groups * (finer.min(MOST_FINER) - NEARLY_FINER));
    if wanted <= usual {
        return (1.0, usual);
    }
    (wanted as f64 / groups, wanted)
}

/// Share of the distance of sheets by which it may be too large.
const NEARLY_FINER: f64 = 0.35;

/// Most sheets per usual one: voxels a dozen times as long as wide.
const MOST_FINER: f64 = 6.0;
