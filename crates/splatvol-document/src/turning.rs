//! Turntables: the outline of a thing on all sides of the axis that the camera turns around.
//!
//! The axis goes through the middle of the outline. A picture that shows all the turned outlines shows every side, if
//! the target, around which the camera turns, lies on the axis.

use glam::DVec3;
use splatvol_scene::rotation::about;
use splatvol_scene::{Camera, SceneError};

/// Turns of [`turned_outline`]: points between them are at most 2 % farther out, less than the margin of a picture.
const TURNS: u32 = 16;

/// The outline on all sides of the axis through its middle.
pub(crate) fn turned_outline(outline: &[DVec3], axis: DVec3) -> Vec<DVec3> {
    let middle = middle(outline);
    (0..TURNS)
        .map(|i| about(axis, f64::from(i) * std::f64::consts::TAU / f64::from(TURNS)))
        .flat_map(|turn| outline.iter().map(move |&point| middle + turn * (point - middle)))
        .collect()
}

/// The middle of the box around points.
pub(crate) fn middle(points: &[DVec3]) -> DVec3 {
    let least = points.iter().copied().reduce(DVec3::min).unwrap_or_default();
    let most = points.iter().copied().reduce(DVec3::max).unwrap_or_default();
    0.5 * (least + most)
}

/// The same view with its target where it comes nearest to the axis through `middle`.
pub(crate) fn aimed_at(camera: &Camera, middle: DVec3, axis: DVec3) -> Result<Camera, SceneError> {
    let forward = (camera.target() - camera.position()).normalize();
    let (offset, along) = (middle - camera.position(), forward.dot(axis));
    let distance = (offset.dot(forward) - along * offset.dot(axis)) / (1.0 - along * along);
    let target = if along.abs() < 0.999 && distance > 0.0 {
        camera.position() + distance * forward
    } else {
        camera.target()
    };
    Camera::new(camera.position(), target, camera.up(), camera.projection())
}
