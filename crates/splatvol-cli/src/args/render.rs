//! `splatvol render`.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::Args;
use splatvol_document::keys::PictureSize;

use super::help::{GENERAL, METHOD, OUTPUT};
use super::{ChunkArgs, PictureArgs, WriteArgs, values};

/// Raw arguments of `render`.
#[derive(Debug, Clone, Args)]
#[command(
    after_help = "Examples:
  splatvol render scan.nii.gz                                   makes scan.png
  splatvol render sample:head --view front --size 800x1000 -o head.png
  splatvol render --like head.png --azimuth 30 -o head-30.png   head.png from another side",
    after_long_help = "Colours of --background and of transfer functions are sRGB. A PNG is sRGB with straight alpha; an
EXR is linear and premultiplied, without the background. A PNG carries the settings that made it,
and --like takes them all as defaults. Effects, --tf2d and --gradient-opacity need pictures that are
classified after splatting, as is the default (--classification post).

A scene is a TOML file of several things (docs/scenes.md); flags go over what it says:
  background = \"black\"
  [[item]]
  file = \"scan.nii.gz\"
  iso = 300
  [[item]]
  file = \"electrodes.ply\"        # beside the scene
  color = [1, 0.8, 0.2]
  rotate = [\"z\", 30]
  translate = [10, 0, 5]
  [camera]
  view = \"front\"

Examples:
  splatvol render scan.nii.gz
  splatvol render sample:head --view front --size 800x1000 -o head.png
  splatvol render engine.vti --cmap viridis --opacity sigmoid --clim 40,220
  splatvol render large.nrrd --preset draft -o preview.png
  splatvol render scan.raw --dims 256x256x109 --type u16 --endian big --spacing 1,1,2 --up -y
  splatvol render ct.nrrd --iso 300 --light=-1,-1,-1 --background white
  splatvol render ct.nrrd --compositing mip --orthographic --view left
  splatvol render sample:tunnel --compositing axis-sheets --filter swan
  splatvol render --list-methods
  splatvol render sample:head --iso 300 --iso-exact --texture marble --depth head-depth.exr
  splatvol render sample:head --clip-plane 0,0,40:0,0,-1 --view iso
  splatvol render ct.nrrd --gradient-opacity 0:0,50:0.2,200:1
  splatvol render ct.nrrd --iso 300 --bump word.png --environment studio.exr --environment-share 0.3
  splatvol render sample:head --spin 20 --classification pre --motion-blur exact
  splatvol render lidar.laz --radius 0.4
  splatvol render capture.spz --gaussians volumetric --up y
  splatvol render dem.csv --drape dem.jpg --posts 512x512
  splatvol render scene.toml --view front
  splatvol render --like head.png --azimuth 30 -o head-30.png
  splatvol render sample:head:128 --background none -o - > head.png"
)]
pub(crate) struct RenderArgs {
    /// File or folder (volume, points, Gaussians, mesh, scene.toml), sample:NAME[:SIZE], or with the feature remote the
    /// address of a Zarr image (https://, s3://)
    #[arg(required_unless_present_any = ["like", "list_methods"])]
    pub(crate) input: Option<String>,
    /// Solution, where the input is a PLOT3D grid: the same as --solution
    #[arg(value_name = "SOLUTION", conflicts_with = "solution", requires = "input")]
    pub(crate) second_input: Option<String>,
    /// PNG or EXR to write, - for stdout [default: INPUT's name with .png]
    #[arg(short, long, value_name = "FILE", help_heading = OUTPUT)]
    pub(crate) output: Option<PathBuf>,
    /// Size of the picture in pixels: WxH, or N for both [default: 1024x1024]
    #[arg(long, value_name = "WxH", value_parser = values::picture_size, help_heading = OUTPUT)]
    pub(crate) size: Option<PictureSize>,
    #[command(flatten)]
    pub(crate) picture: PictureArgs,
    /// Write depths too, in world lengths: .exr, .npy or .png
    ///
    /// Along the camera's axis. A PNG has 16 bits, and says in its text which range they stand for.
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub(crate) depth: Option<PathBuf>,
    /// Write the picture after every N sheets, too: NAME.0004.png beside NAME.png, ...
    ///
    /// By the methods of the papers, which composite the whole picture sheet by sheet: front to back, or with --compositing
    /// per-splat-back-to-front the other way.
    #[arg(long, value_name = "N", conflicts_with = "recipe", help_heading = OUTPUT)]
    pub(crate) partial: Option<NonZeroUsize>,
    /// Write the picture's recipe, a scene with nothing left open, and no picture: for `splatvol part`
    #[arg(long, value_name = "FILE", conflicts_with_all = ["output", "depth", "stats"], help_heading = OUTPUT)]
    pub(crate) recipe: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) write: WriteArgs,
    /// Write no settings and no command line into the picture
    ///
    /// --like then cannot make it again. Without this flag, absolute paths are shortened.
    #[arg(long, help_heading = OUTPUT)]
    pub(crate) no_metadata: bool,
    /// List all methods, and the flags that select them
    #[arg(long, help_heading = METHOD)]
    pub(crate) list_methods: bool,
    /// Number of threads; 0 is one per processor [default: 0]
    ///
    /// The picture does not depend on it.
    #[arg(long, value_name = "N", help_heading = GENERAL)]
    pub(crate) threads: Option<usize>,
    #[command(flatten)]
    pub(crate) chunks: ChunkArgs,
    /// Engine: cpu, gpu, or auto
    ///
    /// The CPU draws everything, with the same bytes on every machine. gpu draws volumes, labels, meshes, points and
    /// volumetric Gaussians together, as material (with clips, isosurfaces or operators) or as an X-ray, maxima, minima or means of a
    /// volume or a mesh, or 3-D Gaussians as published among themselves, and refuses the rest by name (the papers' methods,
    /// operators written in Rust alone); its pictures differ by the last digits from device to device. auto takes the GPU where there
    /// is one that draws the scene, and says otherwise why not. Programs have the GPU's engine if they were built with `--features gpu`.
    #[arg(long, value_enum, value_name = "ENGINE", default_value_t, help_heading = GENERAL)]
    pub(crate) engine: EngineName,
    /// Write times and counts as JSON to this file, or to stdout (-)
    ///
    /// Of a picture in bands of rows (--memory), times and counts of all bands together.
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub(crate) stats: Option<PathBuf>,
}

/// Engines by name.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum EngineName {
    /// The processor's
    #[default]
    Cpu,
    /// A GPU's
    Gpu,
    /// A GPU's where it can, else the processor's
    Auto,
}

impl From<EngineName> for splatvol::EngineChoice {
    fn from(name: EngineName) -> Self {
        match name {
            EngineName::Cpu => Self::Cpu,
            EngineName::Gpu => Self::Gpu,
            EngineName::Auto => Self::Auto,
        }
    }
}
