//! Chunks of samples: volumes of any size, of which boxes are read at a time.
//!
//! A [`ChunkSource`] has levels of detail, each a grid that is cut into boxes of equal size ([`LevelLayout`]). Any thread
//! reads any chunk at any time; nothing is kept but what the source says. [`ChunkedVolume`] lends such a source to
//! engines as a [`crate::SampleSource`], [`CachedSource`] keeps the chunks that were read last, and a [`Budget`] bounds
//! the bytes of all that work at once.

mod budget;
mod cache;
mod error;
mod layout;
mod min_max;
mod recent;
mod region;
mod thinned;
mod volume;

use std::fmt::Debug;
use std::sync::Arc;

use crate::{Samples, VoxelBox};

pub use budget::{Budget, OverBudget, Reservation};
pub use cache::{CachedSource, ChunkCounts};
pub use error::{ChunkFault, SourceError};
pub use layout::{ElementType, LevelLayout};
pub use min_max::{MinMaxIndex, block_ends};
pub use recent::Recent;
pub use region::{copy_box, read_by_chunks};
pub use volume::{ChunkedVolume, Survey, spread_step};

/// Memory in which a chunk is read. It may be used again for any chunk of any source, which saves allocations.
#[derive(Debug)]
pub struct ChunkBuffer {
    /// The samples read last, x fastest: those of [`LevelLayout::region`].
    pub samples: Samples,
    /// Bytes as they are stored; sources keep them here between reads.
    pub coded: Vec<u8>,
    /// Bytes on their way from there to samples.
    pub decoded: Vec<u8>,
}

impl Default for ChunkBuffer {
    fn default() -> Self {
        Self {
            samples: Samples::U8(Vec::new().into()),
            coded: Vec::new(),
            decoded: Vec::new(),
        }
    }
}

/// Contents of a chunk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ChunkContent {
    /// The samples in the [`ChunkBuffer`].
    Samples,
    /// All samples have this stored value; the buffer holds none of them.
    Constant(f64),
}

/// Name and state of a source, for records of pictures and for keys.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct SourceIdentity {
    /// Address or path, without secrets.
    pub name: String,
    /// Text that changes when the description of the data does, such as a hash of their metadata.
    pub state: String,
}

/// Samples in chunks, at levels of detail. Any thread may read at any time.
pub trait ChunkSource: Debug + Send + Sync {
    /// The levels, the finest first; at least one.
    fn levels(&self) -> &[LevelLayout];

    /// Reads a chunk, numbered along x, y, z.
    ///
    /// # Errors
    /// See [`SourceError`].
    fn read(
        &self,
        level: usize,
        chunk: [usize; 3],
        into: &mut ChunkBuffer,
    ) -> Result<ChunkContent, SourceError>;

    /// Reads the samples of a region, which lies within the grid, into `into`.
    ///
    /// # Errors
    /// See [`SourceError`].
    fn read_region(
        &self,
        level: usize,
        region: VoxelBox,
        into: &mut Samples,
        buffer: &mut ChunkBuffer,
    ) -> Result<(), SourceError> {
        read_by_chunks(self, level, region, into, buffer)
    }

    /// Whether a region costs no more than its own samples, so that nothing is gained by keeping chunks.
    fn reads_regions(&self) -> bool {
        false
    }

    /// Smallest and largest stored values of the blocks of a level, if they are known without reading it.
    fn index(&self, _level: usize) -> Option<Arc<MinMaxIndex>> {
        None
    }

    /// Every n-th stored sample of a level, n by [`spread_step`], from the first on, x fastest, if that is known without
    /// reading through the level. All of its samples are finite then.
    fn spread(&self, _level: usize) -> Option<Vec<f64>> {
        None
    }

    /// Whether values are labels, and those of coarser levels labels of the finest, not means.
    fn is_of_labels(&self) -> bool {
        false
    }

    /// A hint which chunks are read next, in this order, each with its level. Sources may fetch them ahead.
    fn will_need(&self, _chunks: &[(usize, [usize; 3])]) {}

    /// Sets the stored value of lost chunks that are taken for holes, in what the source is made of, too. Whether any
    /// chunk may have changed.
    fn set_hole(&self, _stored: f64) -> bool {
        false
    }

    /// Name and state.
    fn identity(&self) -> SourceIdentity;
}
