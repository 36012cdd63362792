//! One level of a source of samples, from which a field is built.

use std::sync::{Arc, Mutex, PoisonError};

use splatvol_scene::volume::Statistics;
use splatvol_scene::{
    Block, ChunkSource, ChunkedVolume, Grid, Rescale, SampleSource, Samples, SceneError, Survey, Volume,
    VoxelBox,
};

/// Samples on one grid.
#[derive(Debug, Clone)]
pub struct SourceLevel {
    source: Arc<dyn SampleSource>,
    level: usize,
}

impl SourceLevel {
    /// A level of a source.
    pub fn new(source: Arc<dyn SampleSource>, level: usize) -> Self {
        Self { source, level }
    }

    /// The source, and the level's index.
    pub fn of(&self) -> (&Arc<dyn SampleSource>, usize) {
        (&self.source, self.level)
    }

    /// Grid of the samples.
    pub fn grid(&self) -> &Grid {
        self.source.grid(self.level)
    }

    /// Mapping from stored samples to real values.
    pub fn rescale(&self) -> Rescale {
        self.source.rescale(self.level)
    }

    /// Range, mean and missing samples, in real values.
    pub fn statistics(&self) -> Statistics {
        self.source.statistics(self.level)
    }

    /// Smallest and largest real value.
    pub fn value_range(&self) -> [f64; 2] {
        let Statistics { min, max, .. } = self.statistics();
        [min, max]
    }

    /// The chunks from which the samples are read, where they are not in memory.
    pub fn chunks(&self) -> Option<&ChunkedVolume> {
        self.source.chunks()
    }

    /// What is known of the level, if it was surveyed.
    pub fn known(&self) -> Option<&Survey> {
        self.source.survey(self.level)
    }

    /// Sets the real value of lost chunks that are taken for holes. Whether any sample may have changed.
    pub(crate) fn set_hole(&self, real: f64) -> bool {
        let rescale = self.rescale();
        let stored = (real - rescale.intercept) / rescale.slope;
        self.chunks().is_some_and(|chunks| {
            let is_float = chunks.layout(self.level).element.is_float();
            chunks
                .source()
                .set_hole(if is_float { stored } else { stored.round() })
        })
    }

    /// The samples of a region, or of a larger one.
    ///
    /// # Errors
    /// Samples that cannot be read.
    pub fn read<'a>(
        &'a self,
        region: VoxelBox,
        memory: &'a mut Option<Samples>,
    ) -> Result<Block<'a>, SceneError> {
        self.source.read(self.level, region, memory)
    }
}

impl From<Arc<Volume>> for SourceLevel {
    fn from(volume: Arc<Volume>) -> Self {
        Self::new(volume, 0)
    }
}

/// First error of reading samples. Readers continue without these samples; the caller that asks for the error
/// cancels the picture.
#[derive(Debug, Clone, Default)]
pub(super) struct Failure(Arc<Mutex<Option<SceneError>>>);

impl Failure {
    /// The samples read, or `None` after a failure.
    pub(super) fn catch<T>(&self, read: Result<T, SceneError>) -> Option<T> {
        match read {
            Ok(read) => Some(read),
            Err(error) => {
                let mut first = self.0.lock().unwrap_or_else(PoisonError::into_inner);
                first.get_or_insert(error);
                None
            }
        }
    }

    pub(super) fn get(&self) -> Option<SceneError> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}
