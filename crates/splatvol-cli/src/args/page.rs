//! What pages show, whether they are files or served.

use clap::Args;
use splatvol_document::keys::PictureSize;

use super::help::{GENERAL, OUTPUT};
use super::{PictureArgs, values};

/// Arguments of `export` and `serve`.
#[derive(Debug, Clone, Args)]
pub(crate) struct PageArgs {
    /// File or folder (volume, points, Gaussians, mesh, scene.toml), or sample:NAME[:SIZE]
    #[arg(required_unless_present = "like")]
    pub(crate) input: Option<String>,
    /// Size of the picture that is saved from the page, and of its first one: WxH, or N [default: 1024x1024]
    ///
    /// On the page the picture has the size of the window.
    #[arg(long, value_name = "WxH", value_parser = values::picture_size, help_heading = OUTPUT)]
    pub(crate) size: Option<PictureSize>,
    #[command(flatten)]
    pub(crate) picture: PictureArgs,
    /// Largest size of the page, with the data that browsers draw: bytes, or 4M, 1G [default: 15M]
    #[arg(long, value_name = "SIZE", value_parser = values::bytes, help_heading = OUTPUT)]
    pub(crate) max_size: Option<u64>,
    /// Title of the page [default: INPUT's name]
    #[arg(long, value_name = "TEXT", help_heading = OUTPUT)]
    pub(crate) title: Option<String>,
    /// Leave out the engine for WebGPU: a smaller page, whose drafts are drawn by processors only
    ///
    /// Without this flag a page has it if the program was built with it and the page stays within --max-size: data come first.
    /// Browsers with a GPU then draw what moves in the resolution of the window. Final pictures are the same.
    #[arg(long, help_heading = OUTPUT)]
    pub(crate) no_webgpu: bool,
    /// Number of threads; 0 is one per processor [default: 0]
    #[arg(long, value_name = "N", help_heading = GENERAL)]
    pub(crate) threads: Option<usize>,
}
