//! Flags about motion while the shutter is open, and how it is blurred.

use clap::{Args, ValueEnum};

use super::values::{self, Triple};

const MOTION: &str = "Motion blur";

/// What moves while the shutter is open, and what the picture shows of it.
#[derive(Debug, Clone, Default, PartialEq, Args)]
pub(crate) struct MotionArgs {
    /// Spin the volume by this angle while the shutter is open, around the camera's up axis through the volume's centre
    #[arg(long, value_name = "DEGREES", value_parser = values::finite, help_heading = MOTION,
          allow_negative_numbers = true)]
    pub(crate) spin: Option<f64>,
    /// Move the volume by this while the shutter is open, world
    #[arg(long, value_name = "X,Y,Z", value_parser = values::triple, help_heading = MOTION,
          allow_hyphen_values = true, conflicts_with = "spin")]
    pub(crate) velocity: Option<Triple>,
    /// How motion is blurred [default: exact where colours or X-rays are splatted, else subframes; --shutter: subframes]
    #[arg(long, value_name = "METHOD", help_heading = MOTION)]
    pub(crate) motion_blur: Option<MotionBlurName>,
    /// Pictures averaged with --motion-blur subframes [default: 16]
    #[arg(long, value_name = "N", help_heading = MOTION, value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub(crate) subframes: Option<u32>,
}

/// How motion is blurred.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum MotionBlurName {
    /// Not at all: the picture is that of the shutter's middle
    None,
    /// Footprints cut in half and drawn apart along their motion (Mueller 1998); too bright
    Capsule,
    /// Footprints integrated along their motion; what hides what is that of the shutter's middle
    Exact,
    /// Mean of pictures taken while the shutter is open: right for all scenes, at the cost of all pictures
    Subframes,
}
