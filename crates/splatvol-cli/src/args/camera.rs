//! Flags about the camera.

use clap::{Args, ValueEnum};

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
    pub(crate) fit: Option<Fit>,
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

impl CameraArgs {
    /// These flags, and where they are silent those of `other`. Flags that exclude each other do not mix.
    pub(crate) fn or(&self, other: &Self) -> Self {
        let placed = self.view.is_some() || self.camera_pos.is_some();
        let projected = self.camera_fov.is_some() || self.orthographic.is_some();
        Self {
            view: self.view.or(other.view.filter(|_| !placed)),
            fit: self.fit.or(other.fit),
            camera_pos: self.camera_pos.or(other.camera_pos.filter(|_| !placed)),
            camera_target: self.camera_target.or(other.camera_target),
            camera_up: self.camera_up.or(other.camera_up),
            camera_fov: self.camera_fov.or(other.camera_fov.filter(|_| !projected)),
            orthographic: self.orthographic.or(other.orthographic.filter(|_| !projected)),
            azimuth: self.azimuth.or(other.azimuth),
            elevation: self.elevation.or(other.elevation),
            zoom: self.zoom.or(other.zoom),
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
pub(crate) enum Fit {
    /// The voxels with some opacity, but for specks
    #[default]
    Visible,
    /// The whole grid
    Volume,
}
