//! The camera that benchmarks turn around a volume: its direction is parallel to no axis of the grid.
//!
//! It looks at the middle of the box of what is shown; its distance d is the smallest at which every corner (x, y, z) in camera
//! axes from that middle keeps `|x| <= f a s (d + z)` and `|y| <= f s (d + z)`: s the slope of the picture's upper
//! edge, a its aspect, f the share of it that the box may fill.

use glam::DVec3;
use splatvol::{Camera, Projection, SceneError};

use crate::args::ProjectionName;

/// From the middle to the camera, world.
const TOWARDS_CAMERA: DVec3 = DVec3::new(0.90, 0.25, 0.35);
/// Axis that the camera turns about, world.
const UP: DVec3 = DVec3::Y;
/// Vertical field of view, degrees.
const FOV_DEGREES: f64 = 30.0;
/// Share of the picture's width or height that the box fills.
const FILL: f64 = 0.85;

/// The camera for a picture `aspect` times as wide as high of what lies between corners, world.
pub(crate) fn around(
    corners: &[DVec3; 8],
    projection: ProjectionName,
    aspect: f64,
) -> Result<Camera, SceneError> {
    let [low, high] =
        [DVec3::min, DVec3::max].map(|pick| corners.iter().copied().reduce(pick).unwrap_or_default());
    let target = 0.5 * (low + high);
    let diagonal = (high - low).length();
    let direction = TOWARDS_CAMERA.normalize();
    let at = |distance: f64, projection| Camera::new(target + distance * direction, target, UP, projection);
    let perspective = Projection::Perspective {
        fov_degrees: FOV_DEGREES,
    };
    let axes = at(diagonal, perspective)?.camera_from_world().matrix3;
    let corners = corners.map(|corner| axes * (corner - target));
    let most = |value: &dyn Fn(&DVec3) -> f64| corners.iter().map(value).fold(0.0, f64::max);
    let extent = |corner: &DVec3| corner.y.abs().max(corner.x.abs() / aspect) / FILL;
    match projection {
        ProjectionName::Orthographic => {
            let height = 2.0 * most(&extent);
            at(diagonal, Projection::Orthographic { height })
        }
        ProjectionName::Perspective => {
            let slope = (0.5 * FOV_DEGREES).to_radians().tan();
            at(most(&|corner| extent(corner) / slope - corner.z), perspective)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use splatvol::{Grid, ImageSize};

    #[test]
    fn the_box_fills_its_share_of_the_picture() {
        let grid = Grid::centred([20, 30, 70], DVec3::new(1.0, 2.0, 0.5)).unwrap();
        for (width, height) in [(200, 200), (50, 400)] {
            let size = ImageSize::new(width, height).unwrap();
            for projection in [ProjectionName::Perspective, ProjectionName::Orthographic] {
                let camera = around(&grid.corners(), projection, size.aspect()).unwrap();
                let screen = camera.screen_from_camera(size);
                let reach = grid
                    .corners()
                    .map(|corner| {
                        let pixel = screen.project(camera.camera_from_world().transform_point3(corner));
                        let x = 2.0 * pixel.x / f64::from(width) - 1.0;
                        let y = 2.0 * pixel.y / f64::from(height) - 1.0;
                        x.abs().max(y.abs())
                    })
                    .into_iter()
                    .fold(0.0, f64::max);
                assert!((reach - FILL).abs() < 1e-9, "{projection:?}: {reach}");
            }
        }
    }
}
