//! The camera that shows given points as large as the picture allows.
//!
//! In camera axes a perspective camera at `c` shows a point `p` where `|p.x - c.x| <= s (p.z - c.z)`, s the slope of
//! the picture's edge. Over all points that is `max(p.x - s p.z) + s c.z <= c.x <= min(p.x + s p.z) - s c.z`, and
//! likewise for y: the nearest camera has the largest `c.z` for which both intervals are not empty.

use glam::DVec3;
use splatvol_scene::{Bounds, Camera, Projection, SceneError, View};

/// Space around the shown points.
const MARGIN: f64 = 1.06;

/// Camera from a named side that shows all `points` (world) in a picture `aspect` times as wide as high. A
/// perspective camera keeps its field of view; an orthographic one fits its height.
pub(crate) fn framing(
    points: &[DVec3],
    view: View,
    projection: Projection,
    aspect: f64,
) -> Result<Camera, SceneError> {
    let bounds = Bounds {
        min: points.iter().copied().reduce(DVec3::min).unwrap_or_default(),
        max: points.iter().copied().reduce(DVec3::max).unwrap_or_default(),
    };
    // Its axes are those of the view, its distance is that of a box.
    let loose = Camera::framing(&bounds, view, projection, aspect)?;
    let camera_from_world = loose.camera_from_world().matrix3;
    let centre = bounds.centre();
    let local: Vec<DVec3> = points
        .iter()
        .map(|&point| camera_from_world * (point - centre))
        .collect();
    let most = |value: &dyn Fn(&DVec3) -> f64| local.iter().map(value).fold(f64::NEG_INFINITY, f64::max);
    let (position, projection) = match projection {
        Projection::Orthographic { .. } => {
            let [left, right] = [-most(&|p| -p.x), most(&|p| p.x)];
            let [top, bottom] = [-most(&|p| -p.y), most(&|p| p.y)];
            let height = MARGIN * (bottom - top).max((right - left) / aspect).max(f64::MIN_POSITIVE);
            let middle = DVec3::new(0.5 * (left + right), 0.5 * (top + bottom), -bounds.diagonal());
            (middle, Projection::Orthographic { height })
        }
        Projection::Perspective { fov_degrees } => {
            let slope = libm::tan((0.5 * fov_degrees).to_radians()) / MARGIN;
            // Ends of the interval for x at depth 0, and the largest depth at which it is not empty.
            let interval = |slope: f64, axis: fn(&DVec3) -> f64| {
                let low = most(&|p| axis(p) - slope * p.z);
                let high = -most(&|p| -axis(p) - slope * p.z);
                (0.5 * (low + high), 0.5 * (high - low) / slope)
            };
            let (x, x_depth) = interval(slope * aspect, |p| p.x);
            let (y, y_depth) = interval(slope, |p| p.y);
            (DVec3::new(x, y, x_depth.min(y_depth)), projection)
        }
    };
    if !position.is_finite() || position.z >= 0.0 {
        return Ok(loose);
    }
    let world_from_camera = camera_from_world.transpose();
    let target = centre + world_from_camera * DVec3::new(position.x, position.y, 0.0);
    Camera::new(
        centre + world_from_camera * position,
        target,
        loose.up(),
        projection,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use splatvol_scene::ImageSize;

    /// A lopsided cloud.
    fn points() -> Vec<DVec3> {
        (0..200)
            .map(|i| {
                let t = f64::from(i);
                DVec3::new(
                    t.sin() * 3.0 + 40.0,
                    (1.7 * t).cos() * t * 0.05,
                    (0.3 * t).sin() * 2.0 - 7.0,
                )
            })
            .collect()
    }

    #[test]
    fn every_point_is_shown_and_one_pair_of_edges_is_reached() {
        let size = ImageSize::new(300, 200).unwrap();
        for projection in [
            Projection::Perspective { fov_degrees: 40.0 },
            Projection::Orthographic { height: 1.0 },
        ] {
            for view in View::ALL {
                let camera = framing(&points(), view, projection, size.aspect()).unwrap();
                let screen = camera.screen_from_camera(size);
                let pixels: Vec<_> = points()
                    .into_iter()
                    .map(|p| screen.project(camera.camera_from_world().transform_point3(p)))
                    .collect();
                let reach =
                    |value: &dyn Fn(&glam::DVec2) -> f64| pixels.iter().map(value).fold(0.0, f64::max);
                let [right, left] = [reach(&|p| p.x / 150.0 - 1.0), reach(&|p| 1.0 - p.x / 150.0)];
                let [down, up] = [reach(&|p| p.y / 100.0 - 1.0), reach(&|p| 1.0 - p.y / 100.0)];
                let most = [right, left, down, up].into_iter().fold(0.0, f64::max);
                assert!((most - 1.0 / MARGIN).abs() < 1e-9, "{view:?} {most}");
                assert!((right - left).abs().min((down - up).abs()) < 1e-9, "{view:?}");
            }
        }
    }
}
