//! `splatvol part` and `splatvol assemble`.

use std::path::PathBuf;

use clap::Args;
use splatvol_io::PartKey;

use super::help::{GENERAL, INPUT, OUTPUT};
use super::{ChunkArgs, WriteArgs, values};

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
    /// Most memory for the picture: bytes, or 500M, 1GiB; larger ones go to a PNG in bands of rows [default: half of the
    /// machine's]
    #[arg(long, value_name = "SIZE", value_parser = values::bytes, help_heading = GENERAL)]
    pub(crate) memory: Option<u64>,
}
