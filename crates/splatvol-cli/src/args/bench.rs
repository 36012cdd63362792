//! `splatvol bench`.

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum};
use serde::Serialize;
use splatvol::Projection;
use splatvol_document::Document;
use splatvol_document::keys::{PictureSize, SettingKeys};

use super::help::{CASES, MEASUREMENT, OUTPUT};
use super::{EngineName, PictureArgs, WriteArgs, values};
use crate::commands::bench::scenes::FIXED_SCENES;

/// Raw arguments of `bench`.
#[derive(Debug, Clone, Args)]
#[command(
    after_help = "Examples:
  splatvol bench --quick
  splatvol bench scan.nii.gz --preset fast --threads 1,4",
    after_long_help = "Without INPUT, fixed scenes are rendered in all combinations of look, classification, projection
and threads, and the pictures are compared with recorded ones. Pictures of a given INPUT, and those
that other flags change, are not compared. INPUT and all flags about the picture are those of
render: scenes, points, Gaussians and meshes are measured, too, and --like measures an earlier
picture. Unless camera flags say otherwise, the camera sees the whole box of what is shown from
0.90,0.25,0.35, with 0,1,0 up. One renderer makes all frames of a case, and keeps between frames
what it can.

Exit codes: those of splatvol; 4 also where a picture differs from the recorded one.

Examples:
  splatvol bench
  splatvol bench --quick
  splatvol bench --scenes shells:256 --looks opaque --projection perspective --threads 2
  splatvol bench scan.nii.gz --preset fast --threads 1,4 --counts
  splatvol bench engine.vti --tf engine.json --size 512x512 --no-shade --frames 21 --json -
  splatvol bench scan.raw --dims 256x256x109 --type u16 --up -y --view front
  splatvol bench scan.nii.gz --orbit 0 --slide 1 --counts
  splatvol bench garden.spz --engine gpu --threads 1
  splatvol bench scene.toml --orbit 2 --picture first.png
  splatvol bench --like head.png --preset fast"
)]
pub(crate) struct BenchArgs {
    /// Files or folders (as render takes them), or sample:NAME[:SIZE] [default: the fixed scenes]
    #[arg(value_name = "INPUT")]
    pub(crate) inputs: Vec<String>,
    /// Fixed scenes to run [default: shells:256,head:256,head:512]
    #[arg(long, value_name = "NAMES", value_delimiter = ',', help_heading = CASES, conflicts_with_all = ["inputs", "like"],
          value_parser = PossibleValuesParser::new(FIXED_SCENES.map(|scene| scene.name)))]
    pub(crate) scenes: Vec<String>,
    /// Run the small fixed scenes only, in small pictures
    #[arg(long, help_heading = CASES, conflicts_with_all = ["inputs", "like", "scenes"])]
    pub(crate) quick: bool,
    /// Transfer functions [default: all for fixed scenes; for INPUT as render]
    #[arg(long, value_name = "NAMES", value_delimiter = ',', help_heading = CASES,
          conflicts_with_all = ["tf", "cmap", "opacity", "iso", "tf2d", "labels"])]
    pub(crate) looks: Vec<LookName>,
    /// Projections [default: both for fixed scenes, perspective for INPUT]
    #[arg(long, value_name = "NAMES", value_delimiter = ',', help_heading = CASES,
          conflicts_with_all = ["camera_fov", "orthographic"])]
    pub(crate) projection: Vec<ProjectionName>,
    /// Numbers of threads; 0 takes one per processor [default: 1,0]
    #[arg(long, value_name = "N", value_delimiter = ',', help_heading = CASES)]
    pub(crate) threads: Vec<usize>,
    /// Engine: cpu, gpu, or auto, as render takes it
    ///
    /// Only the CPU's pictures are compared with recorded ones. The counts are the CPU's.
    #[arg(long, value_enum, value_name = "ENGINE", default_value_t, help_heading = CASES)]
    pub(crate) engine: EngineName,
    /// Number of frames that are measured
    #[arg(long, value_name = "N", default_value_t = 9, help_heading = MEASUREMENT,
          value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) frames: u32,
    /// Number of frames before them that are not measured
    #[arg(long, value_name = "N", default_value_t = 2, help_heading = MEASUREMENT)]
    pub(crate) warm_up: u32,
    /// Angle by which the camera turns from frame to frame
    #[arg(long, value_name = "DEGREES", default_value_t = 1.0, help_heading = MEASUREMENT,
          allow_negative_numbers = true, value_parser = values::finite)]
    pub(crate) orbit: f64,
    /// Distance by which opacities slide along the data values from frame to frame, percent of their range
    ///
    /// An edit of the transfer function per frame, of all volumes that are not label maps. The first measured frame shows the
    /// look that was asked for.
    #[arg(long, value_name = "PERCENT", default_value_t = 0.0, help_heading = MEASUREMENT,
          allow_negative_numbers = true, value_parser = values::finite)]
    pub(crate) slide: f64,
    /// Print what each case's frame counts, too: bricks, voxels, vectors
    ///
    /// Of the median frame, summed over tiles. A vector has sixteen lanes: voxels where they are looked at, four sheets by
    /// two by two pixels where they are splatted, pixels where they are shaded. Reused is what the frame before had found and
    /// computed. Zero where an engine does not count.
    #[arg(long, help_heading = MEASUREMENT)]
    pub(crate) counts: bool,
    /// Picture size, pixels: WxH, W,H or N [default: 512x512; 128x128 for the small scenes]
    #[arg(long, value_name = "WxH", value_parser = values::picture_size, help_heading = OUTPUT)]
    pub(crate) size: Option<PictureSize>,
    /// Write settings, times and checksums as JSON to this file, or to stdout (-)
    ///
    /// Settings, times, counts and checksums of all cases. On stdout, JSON takes the place of the table.
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub(crate) json: Option<PathBuf>,
    /// Write the first measured frame of the first case: .png or .exr
    #[arg(long = "picture", value_name = "FILE", help_heading = OUTPUT)]
    pub(crate) first_frame: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) write: WriteArgs,
    #[command(flatten)]
    pub(crate) picture: PictureArgs,
    /// Compare the fixed scenes' pictures with those recorded in this file, instead of with those built in
    #[arg(long, value_name = "FILE", hide = true, conflicts_with_all = ["inputs", "like"])]
    pub(crate) expected: Option<PathBuf>,
    /// Record the pictures of all fixed scenes, or of those selected, as expected from now on, in this file
    #[arg(long, value_name = "FILE", hide = true, conflicts_with_all = ["inputs", "like", "quick"])]
    pub(crate) update_expected: Option<PathBuf>,
}

impl BenchArgs {
    /// Whether flags neither name other volumes than the fixed scenes or another engine nor change their pictures.
    pub(crate) fn keeps_fixed_pictures(&self) -> bool {
        let asked = self.picture.document(self.size, None);
        let settings = SettingKeys {
            // Selects among the fixed cases.
            classification: None,
            ..asked.settings.clone()
        };
        self.engine == EngineName::Cpu
            && self.is_fixed()
            && Document { settings, ..asked } == Document::default()
    }

    /// Whether the fixed scenes are rendered.
    pub(crate) fn is_fixed(&self) -> bool {
        self.inputs.is_empty() && self.picture.like.is_none()
    }
}

/// Transfer functions of benchmarks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum LookName {
    /// A surface: from clear to opaque over 4 % of the data's window
    Opaque,
    /// Fog: opacity rises linearly over nearly all of the window
    Translucent,
    /// The look that splatvol render chooses
    #[value(skip)]
    AsRender,
}

/// Kinds of projection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProjectionName {
    Perspective,
    Orthographic,
}

impl From<Projection> for ProjectionName {
    fn from(projection: Projection) -> Self {
        match projection {
            Projection::Perspective { .. } => Self::Perspective,
            Projection::Orthographic { .. } => Self::Orthographic,
        }
    }
}
