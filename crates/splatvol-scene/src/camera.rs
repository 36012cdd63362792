//! Cameras: `camera_from_world` (x right, y down, z forward) and the projection to pixels.
//!
//! Perspective: `screen = f (x/z, y/z) + c`; orthographic: `screen = m (x, y) + c`; f and m in pixels (per unit of
//! world length for m), c the centre of the picture.

use glam::{DAffine3, DMat3, DVec2, DVec3};
use serde::{Deserialize, Serialize};

use crate::{Bounds, ImageSize, SceneError};

/// Projection from camera space to the picture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Projection {
    /// Central projection with a vertical field of view.
    Perspective {
        /// Full vertical angle, degrees, in (0, 180).
        fov_degrees: f64,
    },
    /// Parallel projection showing `height` world units from top to bottom.
    Orthographic {
        /// World length that fills the picture's height.
        height: f64,
    },
}

/// From the target to a camera in front, on one side and above: it shows three faces of a box, none of which looks
/// like another.
const ISO: DVec3 = DVec3::new(-0.62, 0.70, 0.36);
/// Sine of the least angle between the view and the up direction; below it, the picture's turn would be rounding.
const LEAST_TILT: f64 = 1e-9;

impl Default for Projection {
    /// Perspective with a field of view of 30 degrees.
    fn default() -> Self {
        Self::Perspective { fov_degrees: 30.0 }
    }
}

/// Named directions to look from. In RAS+ data `Front` faces the patient, whose right is then on the left.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum View {
    /// From +y: anterior.
    Front,
    /// From -y: posterior.
    Back,
    /// From -x: left in RAS+ data.
    Left,
    /// From +x: right in RAS+ data.
    Right,
    /// From +z: superior, with +y upwards.
    Top,
    /// From -z: inferior, with +y upwards.
    Bottom,
    /// Three quarters from the front, from above.
    #[default]
    Iso,
}

impl View {
    /// All views, for listings.
    pub const ALL: [Self; 7] = [
        Self::Front,
        Self::Back,
        Self::Left,
        Self::Right,
        Self::Top,
        Self::Bottom,
        Self::Iso,
    ];

    /// World direction from the target to the camera (unit), and up.
    fn towards_camera_and_up(self) -> (DVec3, DVec3) {
        match self {
            Self::Front => (DVec3::Y, DVec3::Z),
            Self::Back => (-DVec3::Y, DVec3::Z),
            Self::Left => (-DVec3::X, DVec3::Z),
            Self::Right => (DVec3::X, DVec3::Z),
            Self::Top => (DVec3::Z, DVec3::Y),
            Self::Bottom => (-DVec3::Z, DVec3::Y),
            Self::Iso => (ISO.normalize(), DVec3::Z),
        }
    }
}

/// A validated camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    position: DVec3,
    target: DVec3,
    up: DVec3,
    projection: Projection,
    camera_from_world: DAffine3,
}

impl Camera {
    /// Camera at `position` looking at `target`, with `up` upwards in the picture (all world, vectors or arrays).
    ///
    /// # Errors
    /// Values that are not finite, a target at the position, an up along the view, a field of view outside
    /// (0, 180) degrees, or a height that is not positive.
    pub fn new(
        position: impl Into<DVec3>,
        target: impl Into<DVec3>,
        up: impl Into<DVec3>,
        projection: Projection,
    ) -> Result<Self, SceneError> {
        Self::looking(position.into(), target.into(), up.into(), projection)
    }

    fn looking(
        position: DVec3,
        target: DVec3,
        up: DVec3,
        projection: Projection,
    ) -> Result<Self, SceneError> {
        if !position.is_finite() {
            return Err(SceneError::invalid(
                "camera position",
                position.to_array(),
                "finite numbers",
            ));
        }
        let forward = (target - position).try_normalize();
        let forward = forward.ok_or_else(|| {
            SceneError::invalid(
                "camera target",
                target.to_array(),
                "finite, and not the camera's position",
            )
        })?;
        let right = forward.cross(up).try_normalize();
        let right = right
            .filter(|_| forward.cross(up).length() > LEAST_TILT * up.length())
            .ok_or_else(|| {
                SceneError::invalid(
                    "camera up",
                    up.to_array(),
                    "finite, and not along the view direction",
                )
            })?;
        match projection {
            Projection::Perspective { fov_degrees } if !(fov_degrees > 0.0 && fov_degrees < 180.0) => {
                return Err(SceneError::invalid(
                    "camera fov",
                    fov_degrees,
                    "degrees between 0 and 180",
                ));
            }
            Projection::Orthographic { height } if !(height > 0.0 && height.is_finite()) => {
                return Err(SceneError::invalid(
                    "camera height",
                    height,
                    "positive and finite",
                ));
            }
            _ => {}
        }
        let down = forward.cross(right);
        let rotation = DMat3::from_cols(right, down, forward).transpose();
        let camera_from_world = DAffine3::from_mat3_translation(rotation, rotation * -position);
        Ok(Self {
            position,
            target,
            up,
            projection,
            camera_from_world,
        })
    }

    /// Camera from a named view that shows all of `bounds` with a small margin. A perspective camera keeps its
    /// field of view and steps back; an orthographic one ignores its height and fits it.
    ///
    /// # Errors
    /// Same as [`Camera::new`].
    pub fn framing(
        bounds: &Bounds,
        view: View,
        projection: Projection,
        aspect: f64,
    ) -> Result<Self, SceneError> {
        const MARGIN: f64 = 1.04;
        let (towards_camera, up) = view.towards_camera_and_up();
        let distance_for_axes = bounds.diagonal().max(f64::MIN_POSITIVE);
        let target = bounds.centre();
        let axes = Self::new(
            target + towards_camera * distance_for_axes,
            target,
            up,
            projection,
        )?;
        let rotation = axes.camera_from_world.matrix3;
        let corners = bounds.corners().map(|corner| rotation * (corner - target));
        match projection {
            Projection::Orthographic { .. } => {
                let half = |corner: &DVec3| corner.y.abs().max(corner.x.abs() / aspect);
                let height = 2.0 * MARGIN * corners.iter().map(half).fold(0.0, f64::max);
                Self::new(axes.position, target, up, Projection::Orthographic { height })
            }
            Projection::Perspective { fov_degrees } => {
                let slope = libm::tan((0.5 * fov_degrees).to_radians()) / MARGIN;
                let needed = |corner: &DVec3| corner.y.abs().max(corner.x.abs() / aspect) / slope - corner.z;
                let distance = corners.iter().map(needed).fold(0.0, f64::max);
                Self::new(target + towards_camera * distance, target, up, projection)
            }
        }
    }

    /// Position, world.
    pub fn position(&self) -> DVec3 {
        self.position
    }

    /// Point looked at, world.
    pub fn target(&self) -> DVec3 {
        self.target
    }

    /// Up vector as given, world.
    pub fn up(&self) -> DVec3 {
        self.up
    }

    /// Kind of projection.
    pub fn projection(&self) -> Projection {
        self.projection
    }

    /// Rigid map from world to camera space.
    pub fn camera_from_world(&self) -> DAffine3 {
        self.camera_from_world
    }

    /// The map from camera space to the pixels of a picture of `size`.
    pub fn screen_from_camera(&self, size: ImageSize) -> ScreenFromCamera {
        let (width, height) = (f64::from(size.width()), f64::from(size.height()));
        let centre = DVec2::new(0.5 * width, 0.5 * height);
        match self.projection {
            Projection::Perspective { fov_degrees } => ScreenFromCamera {
                perspective: true,
                scale: 0.5 * height / libm::tan((0.5 * fov_degrees).to_radians()),
                centre,
            },
            Projection::Orthographic { height: world_height } => ScreenFromCamera {
                perspective: false,
                scale: height / world_height,
                centre,
            },
        }
    }
}

/// The projection in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScreenFromCamera {
    /// Central or parallel.
    pub perspective: bool,
    /// f in pixels (perspective) or m in pixels per world length (orthographic).
    pub scale: f64,
    /// Principal point, pixels.
    pub centre: DVec2,
}

impl ScreenFromCamera {
    /// Pixels per world length on the plane of camera depth `depth`.
    #[inline]
    pub fn scale_at(&self, depth: f64) -> f64 {
        if self.perspective {
            self.scale / depth
        } else {
            self.scale
        }
    }

    /// Screen position of a camera-space point; meaningless behind a perspective camera.
    pub fn project(&self, camera: DVec3) -> DVec2 {
        self.scale_at(camera.z) * camera.truncate() + self.centre
    }

    /// Camera-space ray of a screen position, `origin + t * direction`, with `direction.z = 1` so that t is depth.
    pub fn ray(&self, screen: DVec2) -> (DVec3, DVec3) {
        let plane = (screen - self.centre) / self.scale;
        if self.perspective {
            (DVec3::ZERO, plane.extend(1.0))
        } else {
            (plane.extend(0.0), DVec3::Z)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERSPECTIVE: Projection = Projection::Perspective { fov_degrees: 40.0 };

    #[test]
    fn axes_are_right_down_forward() {
        let camera = Camera::new(DVec3::new(0.0, 10.0, 0.0), DVec3::ZERO, DVec3::Z, PERSPECTIVE).unwrap();
        let map = camera.camera_from_world();
        assert!((map.transform_vector3(DVec3::Z) - DVec3::new(0.0, -1.0, 0.0)).length() < 1e-12);
        // Facing the patient: the patient's right (+x) is on the left of the picture.
        assert!((map.transform_vector3(DVec3::X) - DVec3::new(-1.0, 0.0, 0.0)).length() < 1e-12);
        assert!((map.transform_point3(DVec3::ZERO) - DVec3::new(0.0, 0.0, 10.0)).length() < 1e-12);
    }

    #[test]
    fn framing_shows_every_corner() {
        let bounds = Bounds {
            min: DVec3::new(-3.0, 1.0, -7.0),
            max: DVec3::new(4.0, 2.0, 9.0),
        };
        let size = ImageSize::new(320, 200).unwrap();
        for projection in [PERSPECTIVE, Projection::Orthographic { height: 1.0 }] {
            for view in View::ALL {
                let camera = Camera::framing(&bounds, view, projection, size.aspect()).unwrap();
                let screen = camera.screen_from_camera(size);
                for corner in bounds.corners() {
                    let pixel = screen.project(camera.camera_from_world().transform_point3(corner));
                    assert!(
                        pixel.cmpge(DVec2::ZERO).all() && pixel.x <= 320.0 && pixel.y <= 200.0,
                        "{view:?} {pixel}"
                    );
                }
            }
        }
    }

    #[test]
    fn nonsense_is_refused_by_name() {
        let origin = DVec3::ZERO;
        let error = |target, up, projection| {
            Camera::new(origin, target, up, projection)
                .unwrap_err()
                .to_string()
        };
        assert!(error(origin, DVec3::Z, PERSPECTIVE).starts_with("camera target"));
        assert!(error(DVec3::Z, DVec3::Z, PERSPECTIVE).starts_with("camera up"));
        let flat = Projection::Perspective { fov_degrees: 180.0 };
        assert!(error(DVec3::X, DVec3::Z, flat).starts_with("camera fov: 180.0"));
        assert!(
            error(DVec3::X, DVec3::Z, Projection::Orthographic { height: f64::NAN })
                .starts_with("camera height")
        );
    }
}
