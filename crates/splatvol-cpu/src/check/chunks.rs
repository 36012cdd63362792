//! Checks of volumes that are read in chunks: which pictures need all their samples in memory.

use std::sync::Arc;

use splatvol_scene::{ChunkSource, ChunkedVolume, Content, Item, SceneError, SheetSettings};

use crate::route::own_layer;

const WHAT: &str = "a volume that is read in chunks";

/// Whether an item is read in chunks.
fn is_chunked(item: &Item) -> bool {
    matches!(&item.content, Content::Volume { volume, .. } if volume.chunks().is_some())
}

/// Rejects settings whose visible voxels depend on samples far away, and labels whose levels may be no labels.
pub(super) fn on_sheets(item: &Item, sheets: &SheetSettings) -> Result<(), SceneError> {
    let own = own_layer(item);
    let of_means = |chunks: &Arc<ChunkedVolume>| !chunks.source().is_of_labels();
    if own.is_some_and(|own| own.labels && own.volume.chunks().is_some_and(of_means)) {
        return Err(SceneError::Combination {
            what: "a label map that is read in chunks",
            why: "its levels of detail may be means, and means of labels are none; read it whole, or write levels of labels \
                  (splatvol convert --labels)",
        });
    }
    let own = own.map(|single| sheets.of_labels(single.labels));
    let needs_all = own.is_some_and(|own| !own.prefilter && !own.splats_colors());
    match is_chunked(item) && needs_all {
        true => Err(SceneError::Combination {
            what: WHAT,
            why: "without the prefilter all samples must be in memory; leave the prefilter on, or read the volume whole",
        }),
        false => Ok(()),
    }
}

/// Rejects volumes that are read in chunks: these methods need all samples in memory.
pub(super) fn whole(items: &[Item]) -> Result<(), SceneError> {
    match items.iter().any(is_chunked) {
        true => Err(SceneError::Combination {
            what: WHAT,
            why: "only image sheets are drawn from chunks, composited, as X-rays, or as values of one volume; read the volume whole",
        }),
        false => Ok(()),
    }
}
