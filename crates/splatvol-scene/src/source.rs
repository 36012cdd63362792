//! Sources of samples: a grid at one or several levels of detail, read region by region.
//!
//! A [`Volume`] has all its samples in memory, its own or shared ([`crate::Storage`]), and lends them without a copy.
//! Other sources (chunks of a file, a store on another machine) deliver a region on request. An engine's result depends
//! on the values of samples alone, never on the regions in which they arrive.

use std::fmt::Debug;

use crate::volume::Statistics;
use crate::{ChunkedVolume, Grid, Rescale, Samples, SceneError, Survey, Volume};

/// A box of samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VoxelBox {
    /// Its first sample along x, y, z.
    pub first: [usize; 3],
    /// Samples along x, y, z.
    pub size: [usize; 3],
}

impl VoxelBox {
    /// All samples of a grid.
    pub fn whole(grid: &Grid) -> Self {
        Self {
            first: [0; 3],
            size: grid.dims(),
        }
    }

    /// A row of it among its samples, x fastest; y and z are those of the grid.
    #[inline(always)]
    pub fn row<'a, T>(&self, samples: &'a [T], [y, z]: [usize; 2]) -> &'a [T] {
        let Self { first, size } = *self;
        let start = ((z - first[2]) * size[1] + y - first[1]) * size[0];
        &samples[start..start + size[0]]
    }

    /// Samples in it.
    pub fn len(&self) -> usize {
        self.size.iter().product()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Samples in memory, x fastest, and their region.
#[derive(Debug, Clone, Copy)]
pub struct Block<'a> {
    /// Samples of the region, as many as it has.
    pub samples: &'a Samples,
    /// The region.
    pub of: VoxelBox,
}

/// Samples on a grid, at levels of detail. Level 0 has them all; each further one covers the same box with about
/// half as many along each axis. Any thread may read at any time.
pub trait SampleSource: Debug + Send + Sync {
    /// Number of levels, at least one. Engines make further ones from the last.
    fn levels(&self) -> usize {
        1
    }

    /// Grid of the samples of a level.
    fn grid(&self, level: usize) -> &Grid;

    /// Conversion of the stored samples of a level to real values.
    fn rescale(&self, level: usize) -> Rescale;

    /// Range, mean and missing samples of a level, real values.
    fn statistics(&self, level: usize) -> Statistics;

    /// The samples of a region, or of a larger one that holds it. `memory` is for samples that are not in memory
    /// yet; those that an earlier call left there may be used again.
    ///
    /// # Errors
    /// Samples that cannot be read: [`SceneError::Source`].
    fn read<'a>(
        &'a self,
        level: usize,
        region: VoxelBox,
        memory: &'a mut Option<Samples>,
    ) -> Result<Block<'a>, SceneError>;

    /// What is known of a level, if its samples were surveyed.
    fn survey(&self, _level: usize) -> Option<&Survey> {
        None
    }

    /// Bytes in memory that belong to the source.
    fn bytes(&self) -> usize;

    /// The chunks from which the samples are read, where they are not all in memory.
    fn chunks(&self) -> Option<&ChunkedVolume> {
        None
    }
}

impl SampleSource for Volume {
    fn grid(&self, _: usize) -> &Grid {
        self.grid()
    }

    fn rescale(&self, _: usize) -> Rescale {
        self.rescale()
    }

    fn statistics(&self, _: usize) -> Statistics {
        self.statistics()
    }

    fn read<'a>(
        &'a self,
        _: usize,
        _: VoxelBox,
        _: &'a mut Option<Samples>,
    ) -> Result<Block<'a>, SceneError> {
        Ok(Block {
            samples: self.samples(),
            of: VoxelBox::whole(self.grid()),
        })
    }

    fn bytes(&self) -> usize {
        self.samples().len() * self.samples().bytes_per_sample()
    }
}
