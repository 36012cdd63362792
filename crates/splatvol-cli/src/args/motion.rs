//! Flags about motion while the shutter is open, and how it is blurred.

use clap::Args;
use splatvol_document::keys::names::MotionBlurName;

use super::help::BLUR;
use super::values::{self, Triple};

/// Motion while the shutter is open, and its blur.
#[derive(Debug, Clone, Default, PartialEq, Args)]
pub(crate) struct MotionArgs {
    /// Spin the volume by this angle while the shutter is open
    ///
    /// Around the camera's up axis, through the volume's centre.
    #[arg(long, value_name = "DEGREES", value_parser = values::finite, help_heading = BLUR,
          allow_negative_numbers = true)]
    pub(crate) spin: Option<f64>,
    /// Axis of --spin, in world coordinates [default: the camera's up]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::triple, help_heading = BLUR,
          allow_hyphen_values = true, requires = "spin")]
    pub(crate) spin_axis: Option<Triple>,
    /// Centre of --spin, in world coordinates [default: that of what is shown]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::triple, help_heading = BLUR,
          allow_hyphen_values = true, requires = "spin")]
    pub(crate) spin_centre: Option<Triple>,
    /// Move the volume by this while the shutter is open, in world lengths
    #[arg(long, value_name = "X,Y,Z", value_parser = values::triple, help_heading = BLUR,
          allow_hyphen_values = true, conflicts_with = "spin")]
    pub(crate) velocity: Option<Triple>,
    /// How motion is blurred [default: exact or subframes]
    ///
    /// The default is exact where colours or X-rays are splatted, and subframes elsewhere and with --shutter.
    #[arg(long, value_name = "NAME", help_heading = BLUR)]
    pub(crate) motion_blur: Option<MotionBlurName>,
    /// Number of pictures averaged by --motion-blur subframes [default: 16]
    #[arg(long, value_name = "N", help_heading = BLUR, value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub(crate) subframes: Option<u32>,
}
