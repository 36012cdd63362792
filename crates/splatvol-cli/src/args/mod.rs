//! The raw arguments, exactly as typed: what was left out is `None`. [`document`] turns them into a document.
#![expect(
    clippy::doc_markdown,
    reason = "doc comments of arguments are the help's text, where backticks would show"
)]
#![allow(
    rustdoc::broken_intra_doc_links,
    reason = "likewise: brackets are optional parts, not links"
)]

mod animate;
mod bench;
mod camera;
mod chunks;
mod document;
mod effects;
mod export;
mod fastsplats;
mod footprint;
pub(crate) mod help;
mod input;
mod item;
mod kernel;
#[cfg(feature = "lab")]
mod lab;
mod look;
mod method;
mod motion;
mod page;
mod part;
mod picture;
mod pyramid;
mod render;
mod serve;
pub(crate) mod values;
#[cfg(feature = "view")]
mod view;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use help::{GENERAL, INPUT, LOOK, OUTPUT};

pub(crate) use animate::AnimateArgs;
pub(crate) use bench::{BenchArgs, LookName, ProjectionName};
pub(crate) use camera::CameraArgs;
pub(crate) use chunks::ChunkArgs;
pub(crate) use document::of_input;
pub(crate) use effects::{BoxSides, EffectArgs, GradientCurve};
pub(crate) use export::ExportArgs;
pub(crate) use fastsplats::FastSplatsArgs;
pub(crate) use footprint::FootprintArgs;
pub(crate) use input::InputArgs;
pub(crate) use item::ItemArgs;
pub(crate) use kernel::KernelArgs;
#[cfg(feature = "lab")]
pub(crate) use lab::LabArgs;
pub(crate) use look::LookArgs;
pub(crate) use method::MethodArgs;
pub(crate) use motion::MotionArgs;
pub(crate) use page::PageArgs;
pub(crate) use part::{AssembleArgs, PartArgs};
pub(crate) use picture::PictureArgs;
pub(crate) use pyramid::PyramidArgs;
pub(crate) use render::{EngineName, RenderArgs};
pub(crate) use serve::ServeArgs;
#[cfg(feature = "view")]
pub(crate) use view::ViewArgs;

/// Volume rendering by splatting.
#[derive(Debug, Parser)]
#[command(
    name = "splatvol",
    version,
    arg_required_else_help = true,
    propagate_version = true
)]
#[command(after_help = "Examples:
  splatvol render scan.nii.gz                     makes scan.png
  splatvol render sample:head --view front -o head.png
  splatvol render capture.spz                     3-D Gaussians; likewise points, meshes, scene.toml
  splatvol animate sample:head --view front -o spin.gif
  splatvol info scan.nii.gz
  splatvol sample                                 lists the built-in volumes

Exit codes: 0 success, 2 usage, 3 unreadable input, 4 rendering, 5 output.")]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
    #[command(flatten)]
    pub(crate) verbosity: Verbosity,
}

/// How much is said on stderr.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct Verbosity {
    /// Print errors only
    #[arg(short, long, global = true, hide_short_help = true, conflicts_with = "verbose", help_heading = GENERAL)]
    pub(crate) quiet: bool,
    /// Say what was chosen, and how long it took
    #[arg(short, long, global = true, hide_short_help = true, help_heading = GENERAL)]
    pub(crate) verbose: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Make a picture (PNG, EXR) of a volume, points, Gaussians, a mesh or a scene
    Render(Box<RenderArgs>),
    /// Make an animation (GIF, animated PNG, film, frames): a turntable or a path of the camera
    Animate(Box<AnimateArgs>),
    /// Say what a file contains and how it would be shown, or what a kernel does
    Info(InfoArgs),
    /// Write a built-in volume to a file, or list them
    Sample(SampleArgs),
    /// Convert volumes, transfer functions and pictures
    Convert(ConvertArgs),
    /// Write one HTML file that turns, zooms, changes look and cut, without a network
    Export(Box<ExportArgs>),
    /// Show a volume in browsers, with pictures from this machine
    Serve(Box<ServeArgs>),
    /// Make a part of a picture, for whoever puts all of them together: one process of many
    Part(PartArgs),
    /// Put the parts of a picture together
    Assemble(AssembleArgs),
    /// Measure how two pictures or volumes differ
    Compare(CompareArgs),
    /// Measure how long pictures take, and check that they are as recorded
    Bench(Box<BenchArgs>),
    /// Print the JSON schema of scene files, for editors that check and complete them
    Schema,
    /// Repeat the experiments of the papers: numbers, plots and pictures
    #[cfg(feature = "lab")]
    Lab(LabArgs),
    /// Open a window: turn, cut, give a look, save pictures
    #[cfg(feature = "view")]
    View(ViewArgs),
}

/// Flags of every command that writes a file.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct WriteArgs {
    /// Overwrite an existing output
    #[arg(short = 'w', long, help_heading = OUTPUT)]
    pub(crate) overwrite: bool,
}

/// Flags that make `info` describe a kernel.
const KERNEL_FLAGS: [&str; 4] = ["kernel", "kernel_sigma", "kernel_radius", "kernel_alpha"];

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:
  splatvol info scan.nii.gz
  splatvol info sample:head --json
  splatvol info --kernel kaiser-bessel --kernel-radius 2.5",
    after_long_help = "Examples:
  splatvol info scan.nii.gz
  splatvol info scan.raw --dims 256x256x109 --type u16 --endian big
  splatvol info sample:head --json
  splatvol info lidar.laz
  splatvol info scene.toml
  splatvol info --kernel kaiser-bessel --kernel-radius 2.5"
)]
pub(crate) struct InfoArgs {
    /// File or folder (volume, points, Gaussians, mesh, scene.toml), or sample:NAME[:SIZE]
    #[arg(required_unless_present_any = KERNEL_FLAGS, conflicts_with_all = KERNEL_FLAGS)]
    pub(crate) input: Option<String>,
    /// Describe a kernel instead of a volume
    #[command(flatten)]
    pub(crate) kernel: KernelArgs,
    #[command(flatten)]
    pub(crate) read: InputArgs,
    /// Kind of the input: volume, points, terrain, depth-images, gaussians or mesh [default: decided by its contents]
    #[arg(long, value_name = "KIND", value_parser = values::kind, help_heading = INPUT)]
    pub(crate) kind: Option<splatvol_io::DataKind>,
    /// Print JSON
    #[arg(long, help_heading = OUTPUT)]
    pub(crate) json: bool,
    /// Number of bins of the histogram, or of rows of a kernel's profile
    #[arg(long, value_name = "N", help_heading = OUTPUT, default_value_t = 16, value_parser = clap::value_parser!(u16).range(1..=4096))]
    pub(crate) bins: u16,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  splatvol sample
  splatvol sample head -o head.nrrd
  splatvol sample marschner-lobb --size 81 -o lobb.npy")]
pub(crate) struct SampleArgs {
    /// Name of the sample; without it, all are listed
    #[arg(requires = "output")]
    pub(crate) name: Option<String>,
    /// Volume file to write: .nrrd or .npy
    #[arg(short, long, value_name = "FILE", requires = "name", help_heading = OUTPUT)]
    pub(crate) output: Option<PathBuf>,
    /// Samples along the longest axis (N), or along each (XxYxZ)
    #[arg(long, value_parser = values::sample_size, requires = "name", help_heading = OUTPUT)]
    pub(crate) size: Option<splatvol_samples::SampleSize>,
    #[command(flatten)]
    pub(crate) write: WriteArgs,
}

#[derive(Debug, Args)]
#[command(after_help = "The output's extension says what is converted:
  .nrrd .npy    volumes
  .ome.zarr     volumes of any size, with levels of detail; a stopped conversion is continued
  .vp.json      transfer functions for 3D Slicer; .json for ParaView
  .png .exr     pictures

Examples:
  splatvol convert scan.nii.gz scan.nrrd
  splatvol convert scan.nrrd scan.ome.zarr --memory 1G
  splatvol convert bone.json bone.vp.json --unit-distance 1
  splatvol convert frame.exr frame.png")]
pub(crate) struct ConvertArgs {
    /// File to read (volumes: also sample:NAME[:SIZE])
    pub(crate) input: String,
    /// File to write
    pub(crate) output: PathBuf,
    /// Data values that 0..1 of a transfer function stand for [default: its file's, or 0,1]
    #[arg(long, value_name = "LO,HI", help_heading = LOOK, value_parser = values::range, allow_hyphen_values = true)]
    pub(crate) clim: Option<[f64; 2]>,
    /// World length over which a transfer function's opacities act [default: its file's]
    #[arg(long, value_name = "LENGTH", help_heading = LOOK)]
    pub(crate) unit_distance: Option<f64>,
    #[command(flatten)]
    pub(crate) pyramid: PyramidArgs,
    #[command(flatten)]
    pub(crate) read: InputArgs,
    #[command(flatten)]
    pub(crate) write: WriteArgs,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Pictures (.png, .exr) are compared as 8-bit sRGB over black by PSNR and SSIM, and as linear light by
the largest difference; everything else is compared as volumes.

Examples:
  splatvol compare before.png after.png -o difference.png
  splatvol compare a.nrrd b.nii.gz --json"
)]
pub(crate) struct CompareArgs {
    /// First picture or volume
    pub(crate) a: String,
    /// Second picture or volume
    pub(crate) b: String,
    /// Picture of the absolute differences (pictures only)
    #[arg(short, long, value_name = "FILE", help_heading = OUTPUT)]
    pub(crate) output: Option<PathBuf>,
    /// Print JSON
    #[arg(long, help_heading = OUTPUT)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) write: WriteArgs,
}
