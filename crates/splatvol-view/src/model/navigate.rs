//! Gestures that move the camera: each is a function from a camera to a camera.
//!
//! `fraction` is a length in the picture over its height, x to the right and y downwards; the middle is at (0, 0).

use splatvol::glam::{DMat3, DVec2, DVec3};
use splatvol::rotation::about;
use splatvol::{Camera, Projection, SceneError};

/// Field of view that a parallel camera gets in perspective, degrees.
const FOV_DEGREES: f64 = 30.0;
/// Largest angle of an eye that looks around to the horizon, degrees.
const STEEPEST: f64 = 89.0;
/// Factors of one step of zooming.
const ZOOMS: std::ops::RangeInclusive<f64> = 0.05..=20.0;

/// The camera's axes in the world: right, down, forward.
fn axes(camera: &Camera) -> [DVec3; 3] {
    let rows: DMat3 = camera.camera_from_world().matrix3;
    [rows.row(0), rows.row(1), rows.row(2)]
}

fn distance(camera: &Camera) -> f64 {
    camera.position().distance(camera.target())
}

/// World height of the picture at the target's distance.
pub fn height_at_target(camera: &Camera) -> f64 {
    match camera.projection() {
        Projection::Orthographic { height } => height,
        Projection::Perspective { fov_degrees } => {
            2.0 * distance(camera) * libm::tan((0.5 * fov_degrees).to_radians())
        }
    }
}

/// Turns around the target as if a ball was dragged: azimuth to the camera's right and elevation upwards, degrees.
///
/// # Errors
/// See [`Camera::new`].
pub fn orbit(camera: &Camera, azimuth: f64, elevation: f64) -> Result<Camera, SceneError> {
    splatvol_document::orbited(*camera, azimuth, elevation)
}

/// Turns the picture clockwise, degrees.
///
/// # Errors
/// See [`Camera::new`].
pub fn roll(camera: &Camera, degrees: f64) -> Result<Camera, SceneError> {
    let [_, down, forward] = axes(camera);
    let up = about(forward, -degrees.to_radians()) * -down;
    Camera::new(camera.position(), camera.target(), up, camera.projection())
}

/// Moves what is seen by a way in the picture.
///
/// # Errors
/// See [`Camera::new`].
pub fn pan(camera: &Camera, fraction: DVec2) -> Result<Camera, SceneError> {
    let [right, down, _] = axes(camera);
    let way = height_at_target(camera) * (right * fraction.x + down * fraction.y);
    Camera::new(
        camera.position() - way,
        camera.target() - way,
        camera.up(),
        camera.projection(),
    )
}

/// Enlarges by a factor; what lies under `fraction` at the target's distance stays there.
///
/// # Errors
/// See [`Camera::new`].
pub fn zoom(camera: &Camera, factor: f64, fraction: DVec2) -> Result<Camera, SceneError> {
    let factor = factor.clamp(*ZOOMS.start(), *ZOOMS.end());
    let [right, down, _] = axes(camera);
    let shift = height_at_target(camera) * (1.0 - 1.0 / factor) * (right * fraction.x + down * fraction.y);
    let target = camera.target() + shift;
    let offset = camera.position() - camera.target();
    let (offset, projection) = match camera.projection() {
        Projection::Orthographic { height } => (
            offset,
            Projection::Orthographic {
                height: height / factor,
            },
        ),
        perspective @ Projection::Perspective { .. } => (offset / factor, perspective),
    };
    Camera::new(target + offset, target, camera.up(), projection)
}

/// Changes between perspective and parallel projection; what lies at the target's distance keeps its size.
///
/// # Errors
/// See [`Camera::new`].
pub fn other_projection(camera: &Camera) -> Result<Camera, SceneError> {
    let height = height_at_target(camera);
    match camera.projection() {
        Projection::Perspective { .. } => Camera::new(
            camera.position(),
            camera.target(),
            camera.up(),
            Projection::Orthographic { height },
        ),
        Projection::Orthographic { .. } => {
            let [_, _, forward] = axes(camera);
            let away = 0.5 * height / libm::tan((0.5 * FOV_DEGREES).to_radians());
            Camera::new(
                camera.target() - forward * away,
                camera.target(),
                camera.up(),
                Projection::Perspective {
                    fov_degrees: FOV_DEGREES,
                },
            )
        }
    }
}

/// Moves the target, and the eye with it, to a point: later turns are around it.
///
/// # Errors
/// See [`Camera::new`].
pub fn look_at(camera: &Camera, point: DVec3) -> Result<Camera, SceneError> {
    let offset = camera.position() - camera.target();
    Camera::new(point + offset, point, camera.up(), camera.projection())
}

/// Moves the eye: to the right, up and forward, in heights of the picture at the target's distance. A parallel eye sees no way
/// forward, so the picture is enlarged instead.
///
/// # Errors
/// See [`Camera::new`].
pub fn fly(camera: &Camera, way: DVec3) -> Result<Camera, SceneError> {
    let [right, down, forward] = axes(camera);
    let height = height_at_target(camera);
    match camera.projection() {
        Projection::Orthographic { .. } => {
            let moved = pan(camera, DVec2::new(-way.x, way.y))?;
            zoom(&moved, libm::exp(way.z), DVec2::ZERO)
        }
        projection @ Projection::Perspective { .. } => {
            let way = height * (right * way.x - down * way.y + forward * way.z);
            Camera::new(
                camera.position() + way,
                camera.target() + way,
                camera.up(),
                projection,
            )
        }
    }
}

/// Turns the eye around itself: to the right and up, degrees. What is up stays up, so it never looks quite up or down.
///
/// # Errors
/// See [`Camera::new`].
pub fn look_around(camera: &Camera, to_right: f64, upwards: f64) -> Result<Camera, SceneError> {
    let [_, _, forward] = axes(camera);
    let up = camera.up().normalize();
    let height = forward.dot(up).clamp(-1.0, 1.0);
    let steep = libm::asin(height).to_degrees();
    let level = (forward - height * up).normalize_or(forward);
    let steep = (steep + upwards).clamp(-STEEPEST, STEEPEST).to_radians();
    let level = about(up, -to_right.to_radians()) * level;
    let forward = libm::cos(steep) * level + libm::sin(steep) * up;
    let target = camera.position() + distance(camera) * forward;
    Camera::new(camera.position(), target, camera.up(), camera.projection())
}

#[cfg(test)]
mod tests {
    use splatvol::ImageSize;

    use super::*;

    fn cameras() -> [Camera; 2] {
        let new = |projection| Camera::new([3.0, -40.0, 9.0], [1.0, 2.0, 3.0], [0.1, 0.0, 1.0], projection);
        [
            new(Projection::Perspective { fov_degrees: 40.0 }).unwrap(),
            new(Projection::Orthographic { height: 25.0 }).unwrap(),
        ]
    }

    /// Place in the picture over its height, from the middle.
    fn seen(camera: &Camera, point: DVec3) -> DVec2 {
        let size = ImageSize::new(1000, 1000).unwrap();
        let pixel = camera
            .screen_from_camera(size)
            .project(camera.camera_from_world().transform_point3(point));
        (pixel - 500.0) / 1000.0
    }

    #[test]
    fn what_lies_under_the_pointer_moves_along_and_stays_when_zoomed() {
        for camera in cameras() {
            let way = DVec2::new(0.2, -0.1);
            let moved = pan(&camera, way).unwrap();
            assert!((seen(&moved, camera.target()) - way).length() < 1e-9);
            let at = DVec2::new(0.3, 0.1);
            let [right, down, _] = axes(&camera);
            let under = camera.target() + height_at_target(&camera) * (right * at.x + down * at.y);
            assert!((seen(&camera, under) - at).length() < 1e-9);
            let larger = zoom(&camera, 2.0, at).unwrap();
            assert!((seen(&larger, under) - at).length() < 1e-9);
            let ratio = height_at_target(&camera) / height_at_target(&larger);
            assert!((ratio - 2.0).abs() < 1e-9, "{ratio}");
        }
    }

    #[test]
    fn projections_change_to_and_fro() {
        let [camera, parallel] = cameras();
        for camera in [camera, parallel] {
            let there = other_projection(&camera).unwrap();
            assert!((height_at_target(&there) - height_at_target(&camera)).abs() < 1e-9);
            let back = other_projection(&there).unwrap();
            assert!((height_at_target(&back) - height_at_target(&camera)).abs() < 1e-9);
            assert_eq!(back.target(), camera.target());
        }
    }

    #[test]
    fn a_roll_turns_the_picture_clockwise() {
        for camera in cameras() {
            let [right, ..] = axes(&camera);
            let beside = camera.target() + right;
            let rolled = roll(&camera, 90.0).unwrap();
            let at = seen(&rolled, beside);
            assert!(at.x.abs() < 1e-9 && at.y > 0.0, "{at}");
        }
    }

    #[test]
    fn an_eye_flies_where_it_looks_and_turns_where_it_is() {
        for camera in cameras() {
            let height = height_at_target(&camera);
            let [right, down, forward] = axes(&camera);
            let flown = fly(&camera, DVec3::new(0.5, 0.25, 0.0)).unwrap();
            let way = height * (0.5 * right - 0.25 * down);
            assert!((flown.position() - camera.position() - way).length() < 1e-9);
            let nearer = fly(&camera, DVec3::new(0.0, 0.0, 0.5)).unwrap();
            match camera.projection() {
                Projection::Orthographic { .. } => {
                    assert!((height_at_target(&nearer) - height * libm::exp(-0.5)).abs() < 1e-9);
                }
                Projection::Perspective { .. } => {
                    let way = nearer.position() - camera.position();
                    assert!((way - 0.5 * height * forward).length() < 1e-9);
                }
            }
            let turned = look_around(&camera, 90.0, 0.0).unwrap();
            assert!((turned.position() - camera.position()).length() < 1e-12);
            assert!((axes(&turned)[2].dot(camera.up()) - forward.dot(camera.up())).abs() < 1e-9);
            let [new_right, _, new_forward] = axes(&turned);
            assert!(new_forward.dot(right) > 0.9 && new_right.dot(forward) < -0.9);
            let above = look_around(&camera, 0.0, 400.0).unwrap();
            let up = camera.up().normalize();
            assert!((axes(&above)[2].dot(up) - libm::sin(STEEPEST.to_radians())).abs() < 1e-9);
            let back = look_around(&above, 0.0, -400.0).unwrap();
            assert!(axes(&back)[2].dot(up) < -0.99 && axes(&back)[0].dot(right) > 0.99);
        }
    }
}
