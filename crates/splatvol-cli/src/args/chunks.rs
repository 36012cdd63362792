//! Flags about volumes that are read in chunks.

use clap::{Args, ValueEnum};
use splatvol_document::ChunkRules;

use super::help::{GENERAL, INPUT};
use super::values;

/// What lost chunks are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum MissingChunks {
    /// An error
    Refuse,
    /// Holes
    Background,
}

/// How volumes are read in chunks.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct ChunkArgs {
    /// Most memory for volumes of any size (OME-Zarr with levels, large Zarr arrays, flat files and TIFF that are larger)
    /// and their picture: bytes, or 500M, 1GiB [default: half of the machine's]
    ///
    /// A picture whose frame would take more than half of it is made in bands of rows, and written to a PNG as it becomes.
    /// Volumes are read chunk by chunk, those alone that the picture shows, and a picture that cannot fit fails before it
    /// reads. The picture does not depend on the memory, but for the automatic look of flat files. All other inputs are read
    /// whole (--max-memory), and so are these where a method needs all samples: the papers' methods, maxima of several
    /// volumes, missing samples, and on the GPU X-rays and what is classified first.
    #[arg(long, value_name = "SIZE", value_parser = values::bytes, help_heading = GENERAL)]
    pub(crate) memory: Option<u64>,
    /// Chunks that are lost: refuse, or background [default: refuse]
    ///
    /// With background they are holes; a warning and --stats count them.
    #[arg(long, value_name = "WHAT", value_enum, help_heading = INPUT)]
    pub(crate) missing_chunks: Option<MissingChunks>,
}

impl ChunkArgs {
    /// The rules.
    pub(crate) fn rules(&self) -> ChunkRules {
        let memory = self.memory.unwrap_or(splatvol_io::memory::granted() / 2);
        ChunkRules {
            memory: memory.saturating_sub(ChunkRules::PROGRAM),
            holes: self.missing_chunks == Some(MissingChunks::Background),
            whole_if_it_fits: false,
        }
    }
}
