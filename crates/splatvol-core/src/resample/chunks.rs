//! A level that is made chunk by chunk, as pictures need it, of one that is itself read in chunks. Its samples are those
//! of a level in memory, to the bit.

use std::sync::Arc;

use splatvol_scene::{
    ChunkBuffer, ChunkContent, ChunkFault, ChunkSource, ChunkedVolume, ElementType, LengthUnit, LevelLayout,
    MinMaxIndex, Samples, SceneError, SourceError, SourceIdentity, VoxelBox,
};

use super::Resampling;

/// Samples made of those of another level.
#[derive(Debug)]
struct Made {
    resampling: Resampling,
    /// Number of the level, counted from the volume itself, and what it is of the one that it is made of.
    number: usize,
    what: &'static str,
    layout: [LevelLayout; 1],
    index: Option<Arc<MinMaxIndex>>,
}

impl Resampling {
    /// The new samples in chunks of so many, within the budget of those of which they are made. `number`: of the level, counted
    /// from the volume itself, for messages; `index`: smallest and largest samples of blocks, where they are known.
    ///
    /// # Errors
    /// A budget of which nothing is left.
    pub(crate) fn in_chunks(
        self,
        (number, what): (usize, &'static str),
        (chunk, index): ([usize; 3], Option<MinMaxIndex>),
        of: &ChunkedVolume,
    ) -> Result<Arc<ChunkedVolume>, SceneError> {
        let layout = LevelLayout {
            grid: self.grid.clone(),
            chunk,
            element: match self.steps {
                Some(_) => ElementType::U16,
                None => ElementType::F32,
            },
            rescale: self.rescale(),
            fill: 0.0,
        };
        let made = Made {
            resampling: self,
            number,
            what,
            layout: [layout],
            index: index.map(Arc::new),
        };
        let budget = (Arc::clone(of.budget()), false);
        let made = ChunkedVolume::new(Arc::new(made), LengthUnit::Unknown, budget);
        let made = made.map_err(|over| SceneError::Source {
            name: "memory".to_owned(),
            level: number,
            first: [0; 3],
            reason: over.to_string(),
        })?;
        Ok(Arc::new(made))
    }
}

impl ChunkSource for Made {
    fn levels(&self) -> &[LevelLayout] {
        &self.layout
    }

    fn read(
        &self,
        level: usize,
        chunk: [usize; 3],
        into: &mut ChunkBuffer,
    ) -> Result<ChunkContent, SourceError> {
        let layout = &self.layout[level];
        let region: VoxelBox = layout.region(chunk);
        into.samples.refill(layout.element, region.len(), 0.0);
        let mut memory = None;
        let made = match &mut into.samples {
            Samples::U16(data) => self.resampling.region(region, data.to_mut(), &mut memory),
            Samples::F32(data) => self.resampling.region(region, data.to_mut(), &mut memory),
            _ => Ok(()),
        };
        let failed = |error: SceneError| {
            SourceError::Corrupt(Box::new(ChunkFault {
                level: self.number,
                chunk,
                key: self.identity().name,
                codec: None,
                offset: 0,
                reason: format!("it is made of another level: {error}"),
            }))
        };
        made.map_err(failed).map(|()| ChunkContent::Samples)
    }

    fn index(&self, _level: usize) -> Option<Arc<MinMaxIndex>> {
        self.index.clone()
    }

    fn set_hole(&self, stored: f64) -> bool {
        self.resampling
            .source
            .set_hole(self.layout[0].rescale.apply(stored))
    }

    fn identity(&self) -> SourceIdentity {
        let (source, level) = self.resampling.source.of();
        let name = |chunks: &ChunkedVolume| chunks.source().identity().name;
        SourceIdentity {
            name: source.chunks().map_or_else(String::new, name),
            state: format!("{} of level {level}", self.what),
        }
    }
}
