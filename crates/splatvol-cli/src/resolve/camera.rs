//! The camera: explicit, framed automatically, or an earlier picture's.

use glam::{DQuat, DVec3};
use splatvol::{Camera, Projection, TransferFunction, View};

use super::framing::framing;
use super::input::Input;
use super::turning::{aimed_at, middle, turned_outline};
use super::visible;
use crate::args::{CameraArgs, Fit, ViewName};
use crate::failure::{During, Failure, Step};
use crate::recipe::CameraRecipe;

/// Vertical field of view unless asked otherwise, degrees: about that of a portrait lens.
const FOV_DEGREES: f64 = 30.0;

/// What an automatic camera goes by.
pub(crate) struct Surroundings<'a> {
    /// World positions that bound what is to be shown.
    outline: Box<dyn Fn() -> Vec<DVec3> + 'a>,
    /// Width over height of the picture.
    aspect: f64,
    /// Where to look from unless asked otherwise.
    preferred: View,
    /// Whether all sides are to fit, as on a turntable.
    turns: bool,
}

impl<'a> Surroundings<'a> {
    /// Those of a volume as it looks.
    pub(crate) fn new(
        args: &CameraArgs,
        input: &'a Input,
        transfer_function: &'a TransferFunction,
        aspect: f64,
    ) -> Self {
        let fit = args.fit.unwrap_or_default();
        Self {
            outline: Box::new(move || match fit {
                Fit::Visible => visible::visible_outline(&input.volume, transfer_function),
                Fit::Volume => input.volume.grid().corners().to_vec(),
            }),
            aspect,
            preferred: input
                .sample
                .and_then(|sample| sample.preferred_view())
                .unwrap_or(View::Iso),
            turns: false,
        }
    }

    /// Those of things with an outline.
    pub(crate) fn of_outline(outline: impl Fn() -> Vec<DVec3> + 'a, aspect: f64) -> Self {
        Self {
            outline: Box::new(outline),
            aspect,
            preferred: View::Iso,
            turns: false,
        }
    }

    /// The same, seen from there unless asked otherwise.
    pub(crate) fn preferring(self, preferred: Option<View>) -> Self {
        Self {
            preferred: preferred.unwrap_or(self.preferred),
            ..self
        }
    }

    /// The same, for a camera that turns around its target if so said.
    pub(crate) fn turning(self, turns: bool) -> Self {
        Self { turns, ..self }
    }
}

/// The camera that the flags ask for. Offsets (azimuth, elevation, zoom) and projection apply to an earlier picture's
/// camera; a view or a position replaces it.
pub(crate) fn resolve(
    args: &CameraArgs,
    surroundings: &Surroundings<'_>,
    like: Option<&CameraRecipe>,
) -> Result<Camera, Failure> {
    let replaced = args.view.is_some() || args.camera_pos.is_some() || args.fit.is_some();
    let base = match like.filter(|_| !replaced) {
        Some(like) => from_recipe(args, like)?,
        None => framed(args, surroundings, like.map(|like| like.projection))?,
    };
    let turned = orbited(base, args.azimuth.unwrap_or(0.0), args.elevation.unwrap_or(0.0))?;
    zoomed(args, turned)
}

fn from_recipe(args: &CameraArgs, like: &CameraRecipe) -> Result<Camera, Failure> {
    let target = args.camera_target.unwrap_or(like.target);
    let position = DVec3::from_array(like.position);
    let projection = match (args.camera_fov, args.orthographic) {
        (Some(fov_degrees), _) => Projection::Perspective { fov_degrees },
        (None, Some(Some(height))) => Projection::Orthographic { height },
        // What the perspective picture showed at the target's distance.
        (None, Some(None)) => match like.projection {
            Projection::Perspective { fov_degrees } => {
                let distance = position.distance(DVec3::from_array(target));
                let height = 2.0 * distance * (0.5 * fov_degrees).to_radians().tan();
                Projection::Orthographic { height }
            }
            orthographic @ Projection::Orthographic { .. } => orthographic,
        },
        (None, None) => like.projection,
    };
    let up = args.camera_up.unwrap_or(like.up);
    Camera::new(
        position,
        DVec3::from_array(target),
        DVec3::from_array(up),
        projection,
    )
    .during(Step::Usage)
}

fn framed(
    args: &CameraArgs,
    surroundings: &Surroundings<'_>,
    like: Option<Projection>,
) -> Result<Camera, Failure> {
    let projection = match (args.camera_fov, args.orthographic) {
        (Some(fov_degrees), _) => Projection::Perspective { fov_degrees },
        (None, Some(height)) => Projection::Orthographic {
            height: height.unwrap_or(1.0),
        },
        (None, None) => like.unwrap_or(Projection::Perspective {
            fov_degrees: FOV_DEGREES,
        }),
    };
    let outline = (surroundings.outline)();
    let view = args.view.map_or(surroundings.preferred, view);
    let framed = |outline: &[DVec3]| framing(outline, view, projection, surroundings.aspect);
    let still = framed(&outline).during(Step::Usage)?;
    let automatic = if surroundings.turns {
        let axis = args
            .camera_up
            .map_or(still.up(), DVec3::from_array)
            .normalize_or(DVec3::Z);
        let turned = turned_outline(&outline, axis);
        let framed = framed(&turned).during(Step::Usage)?;
        aimed_at(&framed, middle(&outline), axis).during(Step::Usage)?
    } else {
        still
    };
    let target = args.camera_target.map_or(automatic.target(), DVec3::from_array);
    // A target of its own moves the automatic camera along.
    let position = args.camera_pos.map_or(
        automatic.position() + target - automatic.target(),
        DVec3::from_array,
    );
    let up = match args.camera_up {
        Some(up) => DVec3::from_array(up),
        None if args.camera_pos.is_some() => upright(target - position),
        None => automatic.up(),
    };
    let projection = match args.orthographic {
        Some(Some(height)) => Projection::Orthographic { height },
        _ => automatic.projection(),
    };
    Camera::new(position, target, up, projection).during(Step::Usage)
}

/// +z, or +y where one looks along z.
fn upright(forward: DVec3) -> DVec3 {
    let along_z = forward.truncate().length() < 1e-6 * forward.length();
    if along_z { DVec3::Y } else { DVec3::Z }
}

/// The camera moved around its target: to its right and upwards, degrees.
pub(crate) fn orbited(camera: Camera, azimuth: f64, elevation: f64) -> Result<Camera, Failure> {
    if azimuth == 0.0 && elevation == 0.0 {
        return Ok(camera);
    }
    // The camera's own axes, not its up vector: a camera that passes over a pole keeps its head.
    let axes = camera.camera_from_world().matrix3;
    let (right, down) = (axes.row(0), axes.row(1));
    let turn = DQuat::from_axis_angle(camera.up().normalize(), azimuth.to_radians())
        * DQuat::from_axis_angle(right, -elevation.to_radians());
    let offset = turn * (camera.position() - camera.target());
    Camera::new(
        camera.target() + offset,
        camera.target(),
        turn * -down,
        camera.projection(),
    )
    .during(Step::Usage)
}

fn zoomed(args: &CameraArgs, camera: Camera) -> Result<Camera, Failure> {
    let Some(zoom) = args.zoom else {
        return Ok(camera);
    };
    if !(zoom > 0.0 && zoom.is_finite()) {
        return Err(Failure::usage(format!(
            "--zoom: {zoom} is not allowed (a positive factor)"
        )));
    }
    let projection = match camera.projection() {
        Projection::Orthographic { height } => Projection::Orthographic {
            height: height / zoom,
        },
        Projection::Perspective { fov_degrees } => {
            let slope = (0.5 * fov_degrees).to_radians().tan() / zoom;
            Projection::Perspective {
                fov_degrees: 2.0 * slope.atan().to_degrees(),
            }
        }
    };
    Camera::new(camera.position(), camera.target(), camera.up(), projection).during(Step::Usage)
}

fn view(name: ViewName) -> View {
    match name {
        ViewName::Front => View::Front,
        ViewName::Back => View::Back,
        ViewName::Left => View::Left,
        ViewName::Right => View::Right,
        ViewName::Top => View::Top,
        ViewName::Bottom => View::Bottom,
        ViewName::Iso => View::Iso,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use splatvol::Bounds;

    fn camera(args: &CameraArgs, like: Option<&CameraRecipe>) -> Camera {
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
        resolve(args, &surroundings, like)
            .map_err(|failure| format!("{failure:?}"))
            .unwrap()
    }

    #[test]
    fn azimuth_goes_to_the_cameras_right_and_elevation_up() {
        let front = camera(&CameraArgs::default(), None);
        let distance = front.position().length();
        assert!((front.position() - DVec3::Y * distance).length() < 1e-9);
        // Facing the data from +y, the camera's right is -x.
        let turned = camera(
            &CameraArgs {
                azimuth: Some(90.0),
                ..CameraArgs::default()
            },
            None,
        );
        assert!(
            (turned.position() + DVec3::X * distance).length() < 1e-9,
            "{}",
            turned.position()
        );
        let raised = camera(
            &CameraArgs {
                elevation: Some(90.0),
                ..CameraArgs::default()
            },
            None,
        );
        assert!(
            (raised.position() - DVec3::Z * distance).length() < 1e-9,
            "{}",
            raised.position()
        );
        assert!((raised.camera_from_world().matrix3.row(1) - DVec3::Y).length() < 1e-9);
    }

    #[test]
    fn an_earlier_camera_is_kept_until_a_view_is_asked_for() {
        let old = camera(
            &CameraArgs {
                azimuth: Some(20.0),
                zoom: Some(2.0),
                ..CameraArgs::default()
            },
            None,
        );
        let recipe = CameraRecipe::from(&old);
        assert_eq!(camera(&CameraArgs::default(), Some(&recipe)), old);
        let view = CameraArgs {
            view: Some(ViewName::Top),
            ..CameraArgs::default()
        };
        assert!((camera(&view, Some(&recipe)).position().normalize() - DVec3::Z).length() < 1e-9);
    }

    #[test]
    fn zoom_doubles_the_scale_and_orthographic_height_is_kept() {
        let args = CameraArgs {
            orthographic: Some(Some(10.0)),
            zoom: Some(2.0),
            ..CameraArgs::default()
        };
        assert_eq!(
            camera(&args, None).projection(),
            Projection::Orthographic { height: 5.0 }
        );
        let size = splatvol::ImageSize::new(100, 100).unwrap();
        let scale = |zoom| {
            let args = CameraArgs {
                zoom,
                ..CameraArgs::default()
            };
            camera(&args, None).screen_from_camera(size).scale
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
        let size = splatvol::ImageSize::new(200, 100).unwrap();
        let projections = [Some(None), None];
        for (view, orthographic) in [ViewName::Front, ViewName::Iso]
            .into_iter()
            .flat_map(|view| projections.map(|projection| (view, projection)))
        {
            let args = CameraArgs {
                view: Some(view),
                orthographic,
                ..CameraArgs::default()
            };
            let surroundings = Surroundings {
                outline: Box::new(|| bounds.corners().to_vec()),
                aspect: size.aspect(),
                preferred: View::Front,
                turns: true,
            };
            let start = resolve(&args, &surroundings, None).ok().unwrap();
            let path = splatvol::CameraPath::turntable(start, 360.0).unwrap();
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
        let args = CameraArgs {
            camera_pos: Some([0.0, 0.0, 9.0]),
            ..CameraArgs::default()
        };
        assert_eq!(camera(&args, None).up(), DVec3::Y);
    }
}
