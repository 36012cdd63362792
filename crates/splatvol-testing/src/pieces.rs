//! Volumes in memory as sources of chunks, with faults.

use std::sync::Arc;

use splatvol_scene::chunks::{MinMaxIndex, block_ends, spread_step};
use splatvol_scene::volume::widen;
use splatvol_scene::{
    ChunkBuffer, ChunkContent, ChunkFault, ChunkSource, LevelLayout, Samples, SourceError, SourceIdentity,
    Volume, VoxelBox, with_samples,
};

/// What is wrong with the chunk 2,2,2.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// Nothing.
    None,
    /// It is lost.
    Lost,
    /// It is lost, and may be.
    Hole,
}

/// A volume in chunks.
#[derive(Debug)]
pub struct Pieces {
    volume: Arc<Volume>,
    whole: Box<dyn ChunkSource>,
    levels: [LevelLayout; 1],
    index: bool,
    fault: Fault,
}

impl Pieces {
    /// Samples of a volume in chunks of this size; whether bounds and spread samples are known without reading.
    pub fn new(volume: Arc<Volume>, chunk: [usize; 3], index: bool, fault: Fault) -> Self {
        let whole: Box<dyn ChunkSource> = Arc::clone(&volume).into();
        let layout = LevelLayout {
            chunk,
            ..whole.levels()[0].clone()
        };
        Self {
            volume,
            whole,
            levels: [layout],
            index,
            fault,
        }
    }

    fn values(&self) -> Vec<f64> {
        with_samples!(self.volume.samples(), data => data.iter().map(|&sample| widen(sample)).collect())
    }
}

impl ChunkSource for Pieces {
    fn levels(&self) -> &[LevelLayout] {
        &self.levels
    }

    fn read(
        &self,
        level: usize,
        chunk: [usize; 3],
        into: &mut ChunkBuffer,
    ) -> Result<ChunkContent, SourceError> {
        if self.fault != Fault::None && chunk == [2; 3] {
            return Err(SourceError::Missing(Box::new(ChunkFault {
                level,
                chunk,
                key: "c/2/2/2".to_owned(),
                codec: Some("blosc".to_owned()),
                offset: 96,
                reason: "gone".to_owned(),
            })));
        }
        let region = self.levels[0].region(chunk);
        let mut samples = Samples::U8(Vec::new().into());
        self.whole.read_region(0, region, &mut samples, into)?;
        into.samples = samples;
        Ok(ChunkContent::Samples)
    }

    fn index(&self, _: usize) -> Option<Arc<MinMaxIndex>> {
        let whole = self.index.then(|| VoxelBox::whole(&self.levels[0].grid))?;
        let block = ([16; 3], 1);
        let mut index = MinMaxIndex::new(whole.size, block.0, block.1);
        with_samples!(self.volume.samples(), data => {
            block_ends((data, whole), whole, block, |at, ends| index.join(at, ends));
        });
        Some(Arc::new(index))
    }

    fn spread(&self, _: usize) -> Option<Vec<f64>> {
        let all = self.index.then(|| self.values())?;
        Some(all.iter().copied().step_by(spread_step(all.len())).collect())
    }

    fn identity(&self) -> SourceIdentity {
        SourceIdentity {
            name: "pieces".to_owned(),
            state: String::new(),
        }
    }
}
