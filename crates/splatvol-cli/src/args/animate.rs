//! `splatvol animate`.

use std::path::PathBuf;

use clap::Args;

use super::help::{MOTION, OUTPUT};
use super::{RenderArgs, values};

/// Raw arguments of `animate`: those of `render`, which say what every frame shows, and those of the motion.
#[derive(Debug, Clone, Args)]
#[command(
    mut_arg("output", |arg| arg.required_unless_present("list_methods").help(
        "Animation: .gif .apng .mp4 .webm .mov .mkv, or frames: NAME-####.png"
    ).long_help(
        "Animation: .gif, .apng, with ffmpeg .mp4 .webm .mov .mkv, or one file per frame: NAME-####.png, NAME-####.exr"
    )),
    mut_arg("stats", |arg| arg.help("Write times of all frames as JSON to this file, or to stdout (-)")),
    after_help = "Examples:
  splatvol animate sample:head --view front -o spin.gif --size 400 --frames 60 --fps 20
  splatvol animate scan.nii.gz --frames 180 --shutter 0.5 -o spin.mp4",
    after_long_help = "All flags of render are taken too, and say what a frame shows. The animation repeats without a jump
where its path is closed: a turntable by whole turns, or key frames of which the last is the first.
On a turntable, a camera that is placed automatically keeps all sides in the picture.

--path FILE names key frames, as TOML or JSON; the camera flags say what a key leaves out:
  [[key]]
  time = 0.0                 # seconds, in all keys or none; gives the duration without --frames
  position = [0, 400, 0]     # world; the path between keys is a Catmull-Rom spline
  target = [0, 0, 0]
  up = [0, 0, 1]
  fov = 30                   # degrees; or height, in world units, with --orthographic

Every frame carries the settings that made it: render --like spin-0007.png makes it again.

Examples:
  splatvol animate sample:head --view front -o spin.gif --size 400 --frames 60 --fps 20
  splatvol animate scan.nii.gz --turntable 90 --ease -o quarter.apng
  splatvol animate scan.nii.gz --frames 180 --shutter 0.5 -o spin.mp4
  splatvol animate scan.nii.gz --shutter 0.5 --classification pre --motion-blur exact -o fast.mp4
  splatvol animate scan.nii.gz --path flight.toml -o 'flight-####.png'
  splatvol animate scan.nii.gz --path flight.toml -o 'flight-####.png' --resume"
)]
pub(crate) struct AnimateArgs {
    #[command(flatten)]
    pub(crate) render: RenderArgs,
    /// Turn the camera around the target by this angle in all [default: 360]
    ///
    /// To its right, about the axis that is up.
    #[arg(long, value_name = "DEGREES", value_parser = values::finite, help_heading = MOTION,
          allow_negative_numbers = true, conflicts_with = "path")]
    pub(crate) turntable: Option<f64>,
    /// Move the camera through the key frames of this file (.toml, .json)
    #[arg(long, value_name = "FILE", help_heading = MOTION)]
    pub(crate) path: Option<PathBuf>,
    /// Number of frames [default: 90, or what the times of --path ask for]
    #[arg(long, value_name = "N", help_heading = MOTION, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) frames: Option<u32>,
    /// Frames per second [default: 30]
    #[arg(long, value_name = "RATE", help_heading = MOTION, value_parser = frame_rate)]
    pub(crate) fps: Option<f64>,
    /// Start and stop gently
    ///
    /// At time t, from 0 to 1, the camera has gone 3t² - 2t³ of its way.
    #[arg(long, help_heading = MOTION)]
    pub(crate) ease: bool,
    /// Motion blur: share of a frame's time that the shutter is open [default: 0]
    #[arg(long, value_name = "SHARE", help_heading = MOTION, value_parser = share)]
    pub(crate) shutter: Option<f64>,
    /// Continue an interrupted animation: keep the frames that are there and up to date, make the others
    #[arg(long, help_heading = OUTPUT, conflicts_with_all = ["overwrite", "no_metadata"])]
    pub(crate) resume: bool,
}

fn frame_rate(text: &str) -> Result<f64, String> {
    let rate = text.parse().ok();
    rate.filter(|rate| (0.01..=1000.0).contains(rate))
        .ok_or_else(|| "expected frames per second, 0.01 to 1000".to_owned())
}

fn share(text: &str) -> Result<f64, String> {
    let share = text.parse().ok();
    share
        .filter(|share| (0.0..=1.0).contains(share))
        .ok_or_else(|| "expected a share from 0 to 1".to_owned())
}
