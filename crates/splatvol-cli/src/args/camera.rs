//! Flags about the camera.

use clap::Args;
use splatvol_document::keys::names::{Fit, ViewName};

use super::help::CAMERA;
use super::values::{self, Triple};

/// Where the picture is taken from.
#[derive(Debug, Clone, Default, PartialEq, Args)]
pub(crate) struct CameraArgs {
    /// Side to look from; front is the data's +y, top its +z [default: iso]
    #[arg(long, value_name = "SIDE", help_heading = CAMERA)]
    pub(crate) view: Option<ViewName>,
    /// Subject that fills the picture [default: visible]
    #[arg(long, value_name = "WHAT", help_heading = CAMERA)]
    pub(crate) fit: Option<Fit>,
    /// Position of the camera, in world coordinates
    #[arg(long, value_name = "X,Y,Z", value_parser = values::triple, help_heading = CAMERA,
          allow_hyphen_values = true, conflicts_with = "view")]
    pub(crate) camera_pos: Option<Triple>,
    /// Point to look at, in world coordinates [default: the middle of what is shown]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::triple, help_heading = CAMERA,
          allow_hyphen_values = true)]
    pub(crate) camera_target: Option<Triple>,
    /// Direction that is up in the picture, in world coordinates [default: 0,0,1]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::triple, help_heading = CAMERA,
          allow_hyphen_values = true)]
    pub(crate) camera_up: Option<Triple>,
    /// Vertical field of view [default: 30]
    #[arg(long, value_name = "DEGREES", help_heading = CAMERA, conflicts_with = "orthographic")]
    pub(crate) camera_fov: Option<f64>,
    /// Parallel projection, with HEIGHT world units from top to bottom [default: what fits]
    #[arg(long, value_name = "HEIGHT", num_args = 0..=1, require_equals = true, help_heading = CAMERA)]
    pub(crate) orthographic: Option<Option<f64>>,
    /// Move the camera around the target, to its right
    #[arg(long, value_name = "DEGREES", help_heading = CAMERA, allow_negative_numbers = true)]
    pub(crate) azimuth: Option<f64>,
    /// Move the camera around the target, upwards
    #[arg(long, value_name = "DEGREES", help_heading = CAMERA, allow_negative_numbers = true)]
    pub(crate) elevation: Option<f64>,
    /// Enlarge the picture about its middle
    #[arg(long, value_name = "FACTOR", help_heading = CAMERA)]
    pub(crate) zoom: Option<f64>,
}
