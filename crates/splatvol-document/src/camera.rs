//! The camera: explicit, framed automatically, or moved from an earlier one.

use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use splatvol_scene::rotation::about;
use splatvol_scene::{Camera, Projection, SceneError, View};

use crate::DocumentError;
use crate::framing::framing;
use crate::keys::{CameraKeys, Parallel};
use crate::turning::{aimed_at, middle, turned_outline};

/// Vertical field of view unless asked otherwise, degrees: about that of a portrait lens.
const FOV_DEGREES: f64 = 30.0;

/// A camera as it was, world: position, target, up and projection.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct CameraPose {
    /// Position of the eye, world.
    pub position: [f64; 3],
    /// Point looked at, world.
    pub target: [f64; 3],
    /// Direction that is up in the picture, world.
    pub up: [f64; 3],
    /// Perspective or parallel.
    #[schemars(schema_with = "crate::schema::projection")]
    pub projection: Projection,
}

impl From<&Camera> for CameraPose {
    fn from(camera: &Camera) -> Self {
        Self {
            position: camera.position().to_array(),
            target: camera.target().to_array(),
            up: camera.up().to_array(),
            projection: camera.projection(),
        }
    }
}

impl CameraPose {
    /// The camera.
    ///
    /// # Errors
    /// See [`Camera::new`].
    pub fn camera(&self) -> Result<Camera, SceneError> {
        Camera::new(
            DVec3::from_array(self.position),
            DVec3::from_array(self.target),
            DVec3::from_array(self.up),
            self.projection,
        )
    }
}

/// A requested projection.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Lens {
    /// Perspective, with a vertical field of view in degrees.
    FieldOfView(f64),
    /// Parallel, showing this world height; by default a height that fits.
    Parallel(Option<f64>),
}

/// Surroundings of an automatic camera.
pub struct Surroundings<'a> {
    /// World positions that bound what is to be shown.
    outline: Box<dyn Fn() -> Vec<DVec3> + 'a>,
    /// Width over height of the picture.
    aspect: f64,
    /// Side to look from unless asked otherwise.
    preferred: View,
    /// Whether all sides are to fit, as on a turntable.
    turns: bool,
}

impl<'a> Surroundings<'a> {
    /// Things with an outline (world), in a picture `aspect` as wide as high.
    pub fn of_outline(outline: impl Fn() -> Vec<DVec3> + 'a, aspect: f64) -> Self {
        Self {
            outline: Box::new(outline),
            aspect,
            preferred: View::Iso,
            turns: false,
        }
    }

    /// The same, seen from this side unless asked otherwise.
    #[must_use]
    pub fn preferring(self, preferred: Option<View>) -> Self {
        Self {
            preferred: preferred.unwrap_or(self.preferred),
            ..self
        }
    }

    /// The same, for a camera that may turn around its target.
    #[must_use]
    pub fn turning(self, turns: bool) -> Self {
        Self { turns, ..self }
    }
}

impl CameraKeys {
    /// The camera: where it is placed, or where everything is in view; then turned and zoomed.
    ///
    /// # Errors
    /// Keys that exclude each other or are outside their domain, by name; cameras that see nothing.
    pub fn resolve(&self, surroundings: &Surroundings<'_>) -> Result<Camera, DocumentError> {
        self.check()?;
        let base = match self.placed()? {
            Some(placed) => placed,
            None => self.framed(surroundings)?,
        };
        let turned = orbited(base, self.azimuth.unwrap_or(0.0), self.elevation.unwrap_or(0.0))?;
        Ok(self.zoomed(turned)?)
    }

    fn check(&self) -> Result<(), DocumentError> {
        let both = [
            (
                self.view.is_some() && self.position.is_some(),
                "`camera.view` and `camera.position`",
            ),
            (
                self.fov.is_some() && self.orthographic.is_some(),
                "`camera.fov` and `camera.orthographic`",
            ),
        ];
        if let Some((_, keys)) = both.into_iter().find(|(both, _)| *both) {
            return Err(DocumentError::usage(format!("{keys} exclude each other")));
        }
        let triples = [self.position, self.target, self.up];
        let height = match self.orthographic {
            Some(Parallel::Height(height)) => Some(height),
            _ => None,
        };
        let numbers = [self.fov, height, self.azimuth, self.elevation, self.zoom];
        let mut all = triples.iter().flatten().flatten().chain(numbers.iter().flatten());
        match all.all(|number| number.is_finite()) {
            true => Ok(()),
            false => Err(DocumentError::usage("`camera`: numbers have to be finite")),
        }
    }

    /// The requested projection; a height of `None` is one that fits.
    fn lens(&self) -> Option<Lens> {
        match (self.fov, self.orthographic) {
            (Some(degrees), _) => Some(Lens::FieldOfView(degrees)),
            (None, Some(Parallel::Height(height))) => Some(Lens::Parallel(Some(height))),
            (None, Some(Parallel::Fits(true))) => Some(Lens::Parallel(None)),
            (None, Some(Parallel::Fits(false)) | None) => None,
        }
    }

    /// The camera, if everything about it is given.
    fn placed(&self) -> Result<Option<Camera>, SceneError> {
        let (Some(position), Some(target), Some(up)) = (self.position, self.target, self.up) else {
            return Ok(None);
        };
        let projection = match self.lens() {
            Some(Lens::FieldOfView(fov_degrees)) => Projection::Perspective { fov_degrees },
            Some(Lens::Parallel(Some(height))) => Projection::Orthographic { height },
            _ => return Ok(None),
        };
        let pose = CameraPose {
            position,
            target,
            up,
            projection,
        };
        pose.camera().map(Some)
    }

    fn framed(&self, surroundings: &Surroundings<'_>) -> Result<Camera, SceneError> {
        let projection = match self.lens() {
            Some(Lens::FieldOfView(fov_degrees)) => Projection::Perspective { fov_degrees },
            Some(Lens::Parallel(height)) => Projection::Orthographic {
                height: height.unwrap_or(1.0),
            },
            None => Projection::Perspective {
                fov_degrees: FOV_DEGREES,
            },
        };
        let outline = (surroundings.outline)();
        let view = self.view.map_or(surroundings.preferred, View::from);
        let framed = |outline: &[DVec3]| framing(outline, view, projection, surroundings.aspect);
        let still = framed(&outline)?;
        let automatic = if surroundings.turns {
            let axis = self
                .up
                .map_or(still.up(), DVec3::from_array)
                .normalize_or(DVec3::Z);
            let framed = framed(&turned_outline(&outline, axis))?;
            aimed_at(&framed, middle(&outline), axis)?
        } else {
            still
        };
        let target = self.target.map_or(automatic.target(), DVec3::from_array);
        // A target of its own moves the automatic camera along.
        let position = self.position.map_or(
            automatic.position() + target - automatic.target(),
            DVec3::from_array,
        );
        let up = match self.up {
            Some(up) => DVec3::from_array(up),
            None if self.position.is_some() => upright(target - position),
            None => automatic.up(),
        };
        let projection = match self.lens() {
            Some(Lens::Parallel(Some(height))) => Projection::Orthographic { height },
            _ => automatic.projection(),
        };
        Camera::new(position, target, up, projection)
    }

    fn zoomed(&self, camera: Camera) -> Result<Camera, SceneError> {
        let Some(zoom) = self.zoom else {
            return Ok(camera);
        };
        if !(zoom > 0.0 && zoom.is_finite()) {
            return Err(SceneError::invalid("zoom", zoom, "a positive factor"));
        }
        let projection = match camera.projection() {
            Projection::Orthographic { height } => Projection::Orthographic {
                height: height / zoom,
            },
            Projection::Perspective { fov_degrees } => {
                let slope = libm::tan((0.5 * fov_degrees).to_radians()) / zoom;
                Projection::Perspective {
                    fov_degrees: 2.0 * libm::atan(slope).to_degrees(),
                }
            }
        };
        Camera::new(camera.position(), camera.target(), camera.up(), projection)
    }
}

/// +z, or +y if the camera looks along z.
fn upright(forward: DVec3) -> DVec3 {
    let along_z = forward.truncate().length() < 1e-6 * forward.length();
    if along_z { DVec3::Y } else { DVec3::Z }
}

/// The camera moved around its target: to its right and upwards, degrees.
///
/// # Errors
/// See [`Camera::new`].
pub fn orbited(camera: Camera, azimuth: f64, elevation: f64) -> Result<Camera, SceneError> {
    if azimuth == 0.0 && elevation == 0.0 {
        return Ok(camera);
    }
    // The camera's own axes, not its up vector: a camera that passes over a pole does not flip.
    let axes = camera.camera_from_world().matrix3;
    let (right, down) = (axes.row(0), axes.row(1));
    let turn = about(camera.up().normalize(), azimuth.to_radians()) * about(right, -elevation.to_radians());
    let offset = turn * (camera.position() - camera.target());
    Camera::new(
        camera.target() + offset,
        camera.target(),
        turn * -down,
        camera.projection(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use splatvol_scene::Bounds;

    use crate::keys::names::ViewName;

    fn camera(keys: &CameraKeys) -> Camera {
        let surroundings = Surroundings {
            outline: Box::new(|| {
                Bounds {
                    min: DVec3::NEG_ONE,
                    max: DVec3::ONE,
                }
                .corners()
                .to_vec()
            }),
            aspect: 1.0,
            preferred: View::Front,
            turns: false,
        };
        keys.resolve(&surroundings).unwrap()
    }

    #[test]
    fn azimuth_goes_to_the_cameras_right_and_elevation_up() {
        let front = camera(&CameraKeys::default());
        let distance = front.position().length();
        assert!((front.position() - DVec3::Y * distance).length() < 1e-9);
        // Facing the data from +y, the camera's right is -x.
        let turned = camera(&CameraKeys {
            azimuth: Some(90.0),
            ..CameraKeys::default()
        });
        assert!(
            (turned.position() + DVec3::X * distance).length() < 1e-9,
            "{}",
            turned.position()
        );
        let raised = camera(&CameraKeys {
            elevation: Some(90.0),
            ..CameraKeys::default()
        });
        assert!(
            (raised.position() - DVec3::Z * distance).length() < 1e-9,
            "{}",
            raised.position()
        );
        assert!((raised.camera_from_world().matrix3.row(1) - DVec3::Y).length() < 1e-9);
    }

    #[test]
    fn an_earlier_camera_is_kept_until_a_view_is_asked_for() {
        let old = camera(&CameraKeys {
            azimuth: Some(20.0),
            zoom: Some(2.0),
            ..CameraKeys::default()
        });
        let known = CameraKeys::from(&CameraPose::from(&old));
        assert_eq!(camera(&CameraKeys::default().over(&known)), old);
        let view = CameraKeys {
            view: Some(ViewName::Top),
            ..CameraKeys::default()
        };
        assert!((camera(&view.over(&known)).position().normalize() - DVec3::Z).length() < 1e-9);
    }

    #[test]
    fn zoom_doubles_the_scale_and_orthographic_height_is_kept() {
        let args = CameraKeys {
            orthographic: Some(Parallel::Height(10.0)),
            zoom: Some(2.0),
            ..CameraKeys::default()
        };
        assert_eq!(
            camera(&args).projection(),
            Projection::Orthographic { height: 5.0 }
        );
        let size = splatvol_scene::ImageSize::new(100, 100).unwrap();
        let scale = |zoom| {
            let args = CameraKeys {
                zoom,
                ..CameraKeys::default()
            };
            camera(&args).screen_from_camera(size).scale
        };
        assert!((scale(Some(2.0)) / scale(None) - 2.0).abs() < 1e-9);
    }

    #[test]
    fn all_sides_fit_a_picture_that_turns() {
        // Long from front to back, and beside the world's axis.
        let bounds = Bounds {
            min: DVec3::new(9.0, 1.0, -1.0),
            max: DVec3::new(11.0, 9.0, 2.0),
        };
        let size = splatvol_scene::ImageSize::new(200, 100).unwrap();
        let lenses = [Some(Parallel::Fits(true)), None];
        for (view, orthographic) in [ViewName::Front, ViewName::Iso]
            .into_iter()
            .flat_map(|view| lenses.map(|lens| (view, lens)))
        {
            let args = CameraKeys {
                view: Some(view),
                orthographic,
                ..CameraKeys::default()
            };
            let surroundings = Surroundings {
                outline: Box::new(|| bounds.corners().to_vec()),
                aspect: size.aspect(),
                preferred: View::Front,
                turns: true,
            };
            let start = args.resolve(&surroundings).unwrap();
            let path = splatvol_scene::CameraPath::turntable(start, 360.0).unwrap();
            let mut reach: f64 = 0.0;
            for i in 0..100 {
                let camera = path.camera(f64::from(i) / 100.0).unwrap();
                let screen = camera.screen_from_camera(size);
                for corner in bounds.corners() {
                    let pixel = screen.project(camera.camera_from_world().transform_point3(corner));
                    reach = reach
                        .max((pixel.x / 100.0 - 1.0).abs())
                        .max((pixel.y / 50.0 - 1.0).abs());
                }
            }
            assert!((0.9..1.0).contains(&reach), "{view:?}: {reach}");
        }
    }

    #[test]
    fn looking_straight_down_is_allowed() {
        let args = CameraKeys {
            position: Some([0.0, 0.0, 9.0]),
            ..CameraKeys::default()
        };
        assert_eq!(camera(&args).up(), DVec3::Y);
    }
}
