//! Stacks: pages of TIFF files, or pictures in a folder, read slice by slice when they are asked for. A chunk is a slice.

use std::fmt::Debug;
use std::sync::Arc;

use splatvol_scene::{
    ChunkBuffer, ChunkContent, ChunkFault, ChunkSource, ElementType, LevelLayout, Samples, SourceError,
    SourceIdentity, chunks::copy_box,
};

use super::{Draft, Opened};
use crate::IoError;
use crate::error::Context;

/// Reader of the slices of a stack.
pub(super) trait Slices: Debug + Send + Sync {
    /// Samples of a slice, x fastest.
    fn slice(&self, index: usize) -> Result<Samples, IoError>;
}

/// A stack whose slices are read when they are asked for.
#[derive(Debug)]
struct Stack<S> {
    slices: S,
    levels: [LevelLayout; 1],
    name: String,
}

/// The volume of a stack of slices of this type.
///
/// # Errors
/// A grid that is none.
pub(super) fn open(
    slices: impl Slices + 'static,
    element: ElementType,
    (draft, context): (Draft, &Context<'_>),
) -> Result<Opened, IoError> {
    let layout = LevelLayout {
        grid: draft.grid(context)?,
        chunk: [draft.dims[0], draft.dims[1], 1],
        element,
        rescale: draft.rescale,
        fill: 0.0,
    };
    Ok(Opened {
        unit: draft.unit,
        description: draft.description,
        is_divided: false,
        source: Arc::new(Stack {
            slices,
            levels: [layout],
            name: context.path.display().to_string(),
        }),
    })
}

impl<S: Slices> ChunkSource for Stack<S> {
    fn levels(&self) -> &[LevelLayout] {
        &self.levels
    }

    fn read(
        &self,
        level: usize,
        chunk: [usize; 3],
        into: &mut ChunkBuffer,
    ) -> Result<ChunkContent, SourceError> {
        let layout = &self.levels[level];
        let fault = |reason: String| {
            Box::new(ChunkFault {
                level,
                chunk,
                key: format!("{}, slice {}", self.name, chunk[2]),
                codec: None,
                offset: 0,
                reason,
            })
        };
        let samples = self.slices.slice(chunk[2]);
        let samples = samples.map_err(|error| SourceError::Corrupt(fault(error.to_string())))?;
        let (found, wanted) = (samples.len(), layout.region(chunk).len());
        if samples.element_type() != layout.element || found != wanted {
            let reason = format!(
                "{found} samples of type {}; the first slice has {wanted} of type {}",
                samples.type_name(),
                layout.element.name()
            );
            return Err(SourceError::Corrupt(fault(reason)));
        }
        // Copied into memory that is used again: slices come and go in a cache, whose memory would be torn to pieces.
        let region = layout.region(chunk);
        into.samples.refill(layout.element, wanted, 0.0);
        copy_box(&samples, region, &mut into.samples, region);
        Ok(ChunkContent::Samples)
    }

    fn identity(&self) -> SourceIdentity {
        let [x, y, z] = self.levels[0].grid.dims();
        SourceIdentity {
            name: self.name.clone(),
            state: format!("{x}x{y}x{z} {}", self.levels[0].element.name()),
        }
    }
}
