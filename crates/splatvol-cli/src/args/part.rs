//! `splatvol part` and `splatvol assemble`.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use splatvol::ImageSize;
use splatvol_io::PictureBlock;

use super::help::{GENERAL, INPUT, OUTPUT};
use super::{ChunkArgs, WriteArgs};

/// A block of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PartKey {
    /// Pixels.
    Block(PictureBlock),
    /// One of so many blocks.
    Share { index: u32, count: u32 },
}

impl FromStr for PartKey {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let Some((index, count)) = text.split_once('/') else {
            return text.parse().map(Self::Block);
        };
        match (index.parse(), count.parse()) {
            (Ok(index), Ok(count)) if index < count => Ok(Self::Share { index, count }),
            _ => Err(format!(
                "{text:?}: expected I/N with I from 0 to N - 1, or X,Y,WIDTHxHEIGHT"
            )),
        }
    }
}

impl PartKey {
    /// The pixels that it stands for.
    pub(crate) fn block(self, size: ImageSize) -> Option<PictureBlock> {
        match self {
            Self::Block(block) => Some(block),
            Self::Share { index, count } => PictureBlock::of(size, index, count),
        }
    }
}

#[derive(Debug, Args)]
#[command(
    after_help = "A recipe is a scene with nothing left open (splatvol render ... --recipe FILE). Parts may be made by any
number of processes, on any machines, in any order and more than once: together they are the
picture, bit for bit. docs/cluster.md has a script for Slurm.

Examples:
  splatvol render big.ome.zarr --size 4096 --recipe big.json
  splatvol part big.json 0/16 -o parts/0.part
  splatvol part big.json 512,0,512x512 -o parts/b.part
  splatvol assemble parts -o big.png"
)]
pub(crate) struct PartArgs {
    /// Recipe: a scene's file with nothing left open
    pub(crate) recipe: PathBuf,
    /// Block of the picture: I/N, the I-th of N blocks, from 0; or its pixels, X,Y,WIDTHxHEIGHT
    pub(crate) key: PartKey,
    /// Part to write, - for stdout; one that is there and complete is left as it is
    #[arg(short, long, value_name = "FILE", help_heading = OUTPUT)]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) write: WriteArgs,
    #[command(flatten)]
    pub(crate) chunks: ChunkArgs,
    /// Follow links that lead out of the folder of an input
    #[arg(long, help_heading = INPUT)]
    pub(crate) allow_outside: bool,
    /// Number of threads; 0 is one per processor [default: 0]
    #[arg(long, value_name = "N", help_heading = GENERAL)]
    pub(crate) threads: Option<usize>,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  splatvol assemble parts -o big.png
  splatvol assemble a.part b.part c.part d.part -o big.exr")]
pub(crate) struct AssembleArgs {
    /// Parts, or folders of parts (files that end in .part)
    #[arg(required = true)]
    pub(crate) parts: Vec<PathBuf>,
    /// PNG or EXR to write
    #[arg(short, long, value_name = "FILE", help_heading = OUTPUT)]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) write: WriteArgs,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_blocks_or_shares() {
        let size = ImageSize::new(64, 32).unwrap();
        let block = |text: &str| text.parse::<PartKey>().unwrap().block(size).unwrap().to_string();
        assert_eq!(block("4,2,8x6"), "4,2,8x6");
        assert_eq!([block("0/2"), block("1/2")], ["0,0,32x32", "32,0,32x32"]);
        for wrong in ["2/2", "a/2", "1/", "-1/3", "1,2,3"] {
            assert!(wrong.parse::<PartKey>().is_err(), "{wrong}");
        }
    }
}
