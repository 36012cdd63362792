//! Flickering and strobing of a view in motion.

use glam::DVec3;
use splatvol::{Camera, Image};

use super::view::View;
use super::window::Window;
use crate::LabError;

/// Motion of a camera, and the window of its pictures that is measured.
pub(super) struct Flight<'a> {
    /// Displacement from frame to frame, world.
    pub(super) step: DVec3,
    pub(super) frames: u32,
    pub(super) window: &'a Window,
}

/// Flicker of pixels: the root mean square of the second difference of their luminance in time, levels of 255. It is
/// small for features that glide by in small steps, and large for those that appear or vanish between two frames.
pub(super) fn flicker(
    view: &View,
    flight: &Flight<'_>,
    mut render: impl FnMut(&View) -> Result<Image, LabError>,
) -> Result<f64, LabError> {
    let camera = &view.camera;
    let mut frames = Vec::new();
    for frame in 0..flight.frames {
        let moved = f64::from(frame) * flight.step;
        let [position, target] = [camera.position(), camera.target()].map(|point| point + moved);
        let moved = view.seen_from(Camera::new(position, target, camera.up(), camera.projection())?);
        frames.push(flight.window.luminance(&render(&moved)?));
    }
    let (mut sum, mut count) = (0.0, 0);
    for three in frames.windows(3) {
        for ((before, now), after) in three[0].iter().zip(&three[1]).zip(&three[2]) {
            sum += (before - 2.0 * now + after).powi(2);
            count += 1;
        }
    }
    Ok(255.0 * (sum / f64::from(count.max(1))).sqrt())
}
