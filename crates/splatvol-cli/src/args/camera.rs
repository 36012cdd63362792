//! Flags about the camera.

use clap::{Args, ValueEnum};
use splatvol::View;
use splatvol_document::{CameraKeys, Fit, Lens};

use super::values::{self, Triple};

const HEADING: &str = "Camera";

/// Where the picture is taken from.
#[derive(Debug, Clone, Default, PartialEq, Args)]
pub(crate) struct CameraArgs {
    /// Look from this side; the data's +y is front, +z is top [default: iso]
    #[arg(long, help_heading = HEADING)]
    pub(crate) view: Option<ViewName>,
    /// What fills the picture: the voxels that can be seen, or the whole grid [default: visible]
    #[arg(long, value_name = "WHAT", help_heading = HEADING)]
    pub(crate) fit: Option<FitName>,
    /// Camera position, world
    #[arg(long, value_name = "X,Y,Z", value_parser = values::triple, help_heading = HEADING,
          allow_hyphen_values = true, conflicts_with = "view")]
    pub(crate) camera_pos: Option<Triple>,
    /// Point looked at, world [default: the middle of what is shown]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::triple, help_heading = HEADING,
          allow_hyphen_values = true)]
    pub(crate) camera_target: Option<Triple>,
    /// Direction that is up in the picture, world [default: 0,0,1]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::triple, help_heading = HEADING,
          allow_hyphen_values = true)]
    pub(crate) camera_up: Option<Triple>,
    /// Vertical field of view, degrees [default: 30]
    #[arg(long, value_name = "DEGREES", help_heading = HEADING, conflicts_with = "orthographic")]
    pub(crate) camera_fov: Option<f64>,
    /// Parallel projection, showing HEIGHT world units from top to bottom [default: fits]
    #[arg(long, value_name = "HEIGHT", num_args = 0..=1, require_equals = true, help_heading = HEADING)]
    pub(crate) orthographic: Option<Option<f64>>,
    /// Turn the camera around the target, to its right, degrees
    #[arg(long, value_name = "DEGREES", help_heading = HEADING, allow_negative_numbers = true)]
    pub(crate) azimuth: Option<f64>,
    /// Turn the camera over the target, upwards, degrees
    #[arg(long, value_name = "DEGREES", help_heading = HEADING, allow_negative_numbers = true)]
    pub(crate) elevation: Option<f64>,
    /// Enlarge the picture's middle by this factor
    #[arg(long, value_name = "FACTOR", help_heading = HEADING)]
    pub(crate) zoom: Option<f64>,
}

impl From<&CameraArgs> for CameraKeys {
    fn from(args: &CameraArgs) -> Self {
        Self {
            view: args.view.map(View::from),
            fit: args.fit.map(|fit| match fit {
                FitName::Visible => Fit::Visible,
                FitName::Volume => Fit::Volume,
            }),
            position: args.camera_pos,
            target: args.camera_target,
            up: args.camera_up,
            lens: match (args.camera_fov, args.orthographic) {
                (Some(degrees), _) => Some(Lens::FieldOfView(degrees)),
                (None, height) => height.map(Lens::Parallel),
            },
            azimuth: args.azimuth,
            elevation: args.elevation,
            zoom: args.zoom,
        }
    }
}

/// Sides to look from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ViewName {
    Front,
    Back,
    Left,
    Right,
    Top,
    Bottom,
    Iso,
}

/// What an automatic camera shows.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum FitName {
    /// The voxels with some opacity, but for specks
    #[default]
    Visible,
    /// The whole grid
    Volume,
}

impl From<ViewName> for View {
    fn from(name: ViewName) -> Self {
        match name {
            ViewName::Front => Self::Front,
            ViewName::Back => Self::Back,
            ViewName::Left => Self::Left,
            ViewName::Right => Self::Right,
            ViewName::Top => Self::Top,
            ViewName::Bottom => Self::Bottom,
            ViewName::Iso => Self::Iso,
        }
    }
}
