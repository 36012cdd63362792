//! One level of a source of samples: what a field is made of.

use std::sync::{Arc, Mutex, PoisonError};

use splatvol_scene::volume::Statistics;
use splatvol_scene::{Block, Grid, Rescale, SampleSource, Samples, SceneError, Volume, VoxelBox};

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

    /// Where they come from, and which level they are.
    pub fn of(&self) -> (&Arc<dyn SampleSource>, usize) {
        (&self.source, self.level)
    }

    /// Where the samples lie.
    pub fn grid(&self) -> &Grid {
        self.source.grid(self.level)
    }

    /// How stored samples become real values.
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

    /// The samples of a region, or of a larger one.
    ///
    /// # Errors
    /// Samples that cannot be had.
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

/// Why samples could not be read, the first time that it happened. Whoever reads goes on without them: a picture is given up
/// by who asks for this.
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
