//! Flickering and strobing of a view in motion.

use glam::DVec3;
use splatvol::{Camera, Filter, Renderer};

use super::view::View;
use super::window::Window;
use crate::LabError;

/// The camera at steps of a flight.
///
/// # Errors
/// As [`Camera::new`].
pub(super) fn flight(camera: &Camera, step: DVec3, frames: usize) -> Result<Vec<Camera>, LabError> {
    (0..frames)
        .map(|frame| {
            let moved = frame as f64 * step;
            let [position, target] = [camera.position(), camera.target()].map(|point| point + moved);
            Ok(Camera::new(position, target, camera.up(), camera.projection())?)
        })
        .collect()
}

/// How far pixels jump: the root mean square of the second difference of their luminance in time, levels of 255. What glides
/// by in small steps has little of it, what comes and goes between two frames has much.
pub(super) fn flicker(
    renderer: &mut Renderer,
    view: &View,
    filter: Filter,
    (cameras, window): (&[Camera], &Window),
) -> Result<f64, LabError> {
    let frames = cameras
        .iter()
        .map(|&camera| Ok(window.luminance(&view.from(camera).frame(renderer, filter)?.image)))
        .collect::<Result<Vec<_>, LabError>>()?;
    let (mut sum, mut count) = (0.0, 0);
    for three in frames.windows(3) {
        for ((before, now), after) in three[0].iter().zip(&three[1]).zip(&three[2]) {
            sum += (before - 2.0 * now + after).powi(2);
            count += 1;
        }
    }
    Ok(255.0 * (sum / f64::from(count.max(1))).sqrt())
}
