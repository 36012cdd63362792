//! `splatvol export`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use splatvol_page::Bits;

use super::help::OUTPUT;
use super::{PageArgs, WriteArgs};

/// Raw arguments of `export`.
#[derive(Debug, Clone, Args)]
#[command(
    after_help = "Examples:
  splatvol export scan.nii.gz                    makes scan.html
  splatvol export sample:head --view front --max-size 4M -o head.html",
    after_long_help = "The page needs no server and no network, and makes no connection: engine, data and all are in it. It is
opened from disk, or sent as it is. It shows all that `render` does: volumes, points, Gaussians and
meshes, alone or in a scene. Data are kept as they are if they fit, else in fewer bits or at a coarser
level: half the resolution of volumes, a quarter of the points, harmonics of a lower degree. What was
chosen, and how far the page's picture is from that of all data (PSNR), is said, and stands in the page.
No text of a file goes into it but its name.

Examples:
  splatvol export scan.nii.gz
  splatvol export sample:head --view front --max-size 4M -o head.html
  splatvol export ct.nrrd --iso 300 --quantize 8 --title \"Specimen 12\"
  splatvol export biker.spz --title \"A photograph in 3-D\"
  splatvol export scene.toml --size 1200x900 --report - -o scene.html
  splatvol export sample:head --open-files --title Viewer -o viewer.html    a viewer in a file, for any data
  splatvol export --like head.png -o head.html"
)]
pub(crate) struct ExportArgs {
    #[command(flatten)]
    pub(crate) page: PageArgs,
    /// HTML file to write, - for stdout [default: INPUT's name with .html]
    #[arg(short, long, value_name = "FILE", help_heading = OUTPUT)]
    pub(crate) output: Option<PathBuf>,
    /// Bits per number: 8, 12 or 16 [default: as they are, or the most that fit]
    ///
    /// Integers that have no more stay as they are; coordinates of points, Gaussians and meshes have eight more.
    #[arg(long, value_name = "BITS", help_heading = OUTPUT)]
    pub(crate) quantize: Option<BitsArg>,
    /// Make a page that opens files, too: volumes, points, Gaussians and meshes that are dropped on it
    ///
    /// The readers of files are in the page then. What whoever has it drops on it or chooses, files or folders, is read and shown there,
    /// as `splatvol render` would, and is sent nowhere.
    #[arg(long, help_heading = OUTPUT)]
    pub(crate) open_files: bool,
    /// Write sizes, bits, level and error as JSON to this file, or to stdout (-)
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub(crate) report: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) write: WriteArgs,
}

/// Bits per number, by their number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum BitsArg {
    /// 256 values
    #[value(name = "8")]
    Eight,
    /// 4096 values
    #[value(name = "12")]
    Twelve,
    /// 65536 values
    #[value(name = "16")]
    Sixteen,
}

impl From<BitsArg> for Bits {
    fn from(bits: BitsArg) -> Self {
        match bits {
            BitsArg::Eight => Self::Eight,
            BitsArg::Twelve => Self::Twelve,
            BitsArg::Sixteen => Self::Sixteen,
        }
    }
}
