//! Arguments of `splatvol view`.

use clap::Args;
use splatvol_document::{ChunkRules, ReadRules};

use super::chunks::{ChunkArgs, MissingChunks};
use super::help::{GENERAL, INPUT};
use super::render::EngineName;
use super::values;

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  splatvol view scan.nii.gz
  splatvol view sample:head
  splatvol view ct.nrrd electrodes.ply            side by side, in one scene
  splatvol view head.png                          a picture that splatvol made: everything is as it was

F1 in the window shows all keys and gestures.")]
pub(crate) struct ViewArgs {
    /// Files to open (volumes, points, Gaussians, meshes, or sample:NAME), or one scene or picture
    #[arg(value_name = "FILE")]
    pub(crate) files: Vec<String>,
    /// Refuse files that break the rules of their format in any way
    #[arg(long, help_heading = INPUT)]
    strict: bool,
    /// Follow links that lead out of the folder of the input, and read files elsewhere that a picture names
    #[arg(long, help_heading = INPUT)]
    allow_outside: bool,
    /// Most memory for the samples of an input that is read whole: bytes, or 500M, 8G [default: half of the machine's]
    #[arg(long, value_name = "BYTES", value_parser = values::bytes, help_heading = INPUT)]
    max_memory: Option<u64>,
    /// Most memory for volumes of any size (OME-Zarr, Zarr arrays, flat files, TIFF, DICOM, folders of pictures): bytes, or 500M,
    /// 1GiB [default: half of the machine's]
    ///
    /// Half of it is for what the window shows, half for pictures that are saved meanwhile. Volumes whose samples fit into a half are
    /// read whole; of others, pictures read the chunks that they show.
    #[arg(long, value_name = "SIZE", value_parser = values::bytes, help_heading = GENERAL)]
    memory: Option<u64>,
    /// Chunks that are lost: refuse, or background [default: refuse]
    #[arg(long, value_name = "WHAT", value_enum, help_heading = INPUT)]
    missing_chunks: Option<MissingChunks>,
    /// Number of threads; 0 is one per processor [default: 0]
    #[arg(long, value_name = "N", help_heading = GENERAL)]
    pub(crate) threads: Option<usize>,
    /// Engine that draws what the window shows: cpu, gpu, or auto
    ///
    /// It can be changed in the window. Pictures are saved by the CPU, whose bytes are the same everywhere. Programs have the GPU's engine
    /// if they were built with `--features gpu`.
    #[arg(long, value_enum, value_name = "ENGINE", default_value_t = EngineName::Auto, help_heading = GENERAL)]
    pub(crate) engine: EngineName,
}

impl ViewArgs {
    fn chunk_rules(&self) -> ChunkRules {
        let rules = ChunkArgs {
            memory: self.memory,
            missing_chunks: self.missing_chunks,
        }
        .rules();
        ChunkRules {
            // A picture that is saved has another half.
            memory: rules.memory / 2,
            whole_if_it_fits: true,
            ..rules
        }
    }

    /// What is refused when files are read.
    pub(crate) fn rules(&self) -> ReadRules {
        ReadRules {
            strict: self.strict,
            allow_outside: self.allow_outside,
            max_bytes: self.max_memory,
            chunks: Some(self.chunk_rules()),
        }
    }
}
