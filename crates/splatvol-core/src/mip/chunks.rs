//! A half that is made chunk by chunk, as pictures need it, of a level that is itself read in chunks. Its samples are those
//! of a half in memory, to the bit.

use std::sync::Arc;

use splatvol_scene::{
    ChunkBuffer, ChunkContent, ChunkFault, ChunkSource, ChunkedVolume, ElementType, LengthUnit, LevelLayout,
    Samples, SceneError, SourceError, SourceIdentity, VoxelBox,
};

use super::Reduction;
use crate::field::SourceLevel;

/// Means of a finer level.
#[derive(Debug)]
struct Halves {
    reduction: Reduction,
    /// Number of the level, counted from the volume itself.
    number: usize,
    layout: [LevelLayout; 1],
}

/// The half of a level in chunks, within the budget of these. `number`: of the half, counted from the volume itself.
///
/// # Errors
/// As [`half`](super::half).
pub(crate) fn half_in_chunks(
    (source, number): (&SourceLevel, usize),
    chunks: &ChunkedVolume,
) -> Result<SourceLevel, SceneError> {
    let reduction = Reduction::new(source)?;
    let (_, own) = source.of();
    let layout = LevelLayout {
        grid: reduction.grid().clone(),
        // So that a chunk is made of whole ones.
        chunk: chunks.layout(own).chunk.map(|edge| edge.div_ceil(2)),
        element: match reduction.is_narrow() {
            true => ElementType::U16,
            false => ElementType::F32,
        },
        rescale: reduction.rescale(),
        fill: 0.0,
    };
    let halves = Halves {
        reduction,
        number,
        layout: [layout],
    };
    let budget = (Arc::clone(chunks.budget()), false);
    let made = ChunkedVolume::new(Arc::new(halves), LengthUnit::Unknown, budget);
    let made = made.map_err(|over| SceneError::Source {
        name: "memory".to_owned(),
        level: number,
        first: [0; 3],
        reason: over.to_string(),
    })?;
    Ok(SourceLevel::new(Arc::new(made), 0))
}

impl ChunkSource for Halves {
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
            Samples::U16(data) => self.reduction.means(region, data.to_mut(), &mut memory),
            Samples::F32(data) => self.reduction.means(region, data.to_mut(), &mut memory),
            _ => Ok(()),
        };
        let failed = |error: SceneError| {
            SourceError::Corrupt(Box::new(ChunkFault {
                level: self.number,
                chunk,
                key: self.identity().name,
                codec: None,
                offset: 0,
                reason: format!("it is made of a finer level: {error}"),
            }))
        };
        made.map_err(failed).map(|()| ChunkContent::Samples)
    }

    fn identity(&self) -> SourceIdentity {
        let (source, level) = self.reduction.source().of();
        let name = |chunks: &ChunkedVolume| chunks.source().identity().name;
        SourceIdentity {
            name: source.chunks().map_or_else(String::new, name),
            state: format!("half of level {level}"),
        }
    }
}
