//! Volumes in memory as sources of chunks, with faults.

use std::sync::Arc;

use splatvol::chunks::spread_step;
use splatvol::volume::widen;
use splatvol::{
    ChunkBuffer, ChunkContent, ChunkFault, ChunkSource, LevelLayout, Samples, SourceError, SourceIdentity,
    Volume, VoxelBox, with_samples,
};

/// What is wrong with the chunk 2,2,2.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fault {
    None,
    /// It is lost.
    Lost,
    /// It is lost, and may be.
    Hole,
}

/// A volume in chunks.
#[derive(Debug)]
pub(crate) struct Pieces {
    volume: Arc<Volume>,
    whole: Box<dyn ChunkSource>,
    levels: [LevelLayout; 1],
    index: bool,
    fault: Fault,
}

impl Pieces {
    pub(crate) fn new(volume: Arc<Volume>, chunk: [usize; 3], index: bool, fault: Fault) -> Self {
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

    fn bounds(&self, _: usize, chunk: [usize; 3]) -> Option<[f64; 2]> {
        if !self.index {
            return None;
        }
        let region = self.levels[0].region(chunk);
        let [nx, ny, nz] = self.levels[0].grid.dims();
        let around = |axis: usize, n: usize| {
            region.first[axis].saturating_sub(1)..(region.first[axis] + region.size[axis] + 1).min(n)
        };
        let whole = VoxelBox::whole(&self.levels[0].grid);
        let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
        with_samples!(self.volume.samples(), data => for z in around(2, nz) {
            for y in around(1, ny) {
                for &sample in &whole.row(data, [y, z])[around(0, nx)] {
                    let value = widen(sample);
                    ends = [ends[0].min(value), ends[1].max(value)];
                }
            }
        });
        Some(ends)
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
