//! `splatvol render`.

use std::path::PathBuf;

use clap::Args;
use splatvol::ImageSize;

use super::{
    CameraArgs, EffectArgs, InputArgs, ItemArgs, LookArgs, MethodArgs, MotionArgs, WriteArgs, values,
};

const OUTPUT: &str = "Output";

/// Raw arguments of `render`.
#[derive(Debug, Clone, Args)]
#[command(
    after_help = "Colours of --background and transfer functions are sRGB. PNG is straight alpha in sRGB; EXR is linear,
premultiplied, without the background. A PNG carries the settings that made it: --like takes them all as defaults.

A scene is a TOML file of several things; flags go over what it says (docs/scenes.md):
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
    /// Volume, points, Gaussians, mesh or scene: a file, a folder, or sample:NAME[:SIZE] (see splatvol sample)
    #[arg(required_unless_present_any = ["like", "list_methods"])]
    pub(crate) input: Option<String>,
    /// Picture: .png, .exr, or - for a PNG on stdout [default: INPUT's name with .png]
    #[arg(short, long, value_name = "FILE", help_heading = OUTPUT)]
    pub(crate) output: Option<PathBuf>,
    /// Picture size, pixels: WxH, W,H or N [default: 1024x1024]
    #[arg(long, value_name = "WxH", value_parser = values::image_size, help_heading = OUTPUT)]
    pub(crate) size: Option<ImageSize>,
    /// Behind the volume: r,g,b[,a] in 0..1, #rrggbb, black, white, gray, charcoal, or none [default: charcoal]
    #[arg(long, value_name = "COLOUR", value_parser = values::background, help_heading = OUTPUT)]
    pub(crate) background: Option<Background>,
    /// Bits per channel of a PNG: 8 or 16 [default: 8]
    #[arg(long, value_parser = values::bits, help_heading = OUTPUT)]
    pub(crate) bits: Option<u8>,
    /// Camera depths in world lengths too: .exr or .npy (floats), or .png (16 bits, its range in its text)
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub(crate) depth: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) write: WriteArgs,
    /// Take everything that is not given from the PNG that splatvol wrote here
    #[arg(long, value_name = "PICTURE", help_heading = OUTPUT)]
    pub(crate) like: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) camera: CameraArgs,
    #[command(flatten)]
    pub(crate) look: LookArgs,
    #[command(flatten)]
    pub(crate) effects: EffectArgs,
    #[command(flatten)]
    pub(crate) method: MethodArgs,
    #[command(flatten)]
    pub(crate) motion: MotionArgs,
    #[command(flatten)]
    pub(crate) read: InputArgs,
    #[command(flatten)]
    pub(crate) item: ItemArgs,
    /// List every method that a picture can be made by, with the flag that selects it
    #[arg(long)]
    pub(crate) list_methods: bool,
    /// Threads; 0 takes one per processor. The picture does not depend on it [default: 0]
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<usize>,
    /// Write times and counts as JSON to this file, or to stdout (-)
    #[arg(long, value_name = "FILE")]
    pub(crate) stats: Option<PathBuf>,
}

/// What is behind the volume.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Background {
    /// Nothing: the picture keeps its alpha.
    None,
    /// sRGB and straight alpha.
    Color([f64; 4]),
}
