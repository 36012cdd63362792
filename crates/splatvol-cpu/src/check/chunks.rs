//! Checks of volumes that are read in chunks: which pictures need all their samples in memory.

use splatvol_scene::{Content, Item, SceneError, SheetSettings};

use crate::route::own_layer;

const WHAT: &str = "a volume that is read in chunks";

/// Whether an item is read in chunks.
fn is_chunked(item: &Item) -> bool {
    matches!(&item.content, Content::Volume { volume, .. } if volume.chunks().is_some())
}

/// Rejects settings whose visible voxels depend on samples far away.
pub(super) fn on_sheets(item: &Item, sheets: &SheetSettings) -> Result<(), SceneError> {
    let own = own_layer(item).map(|single| sheets.of_labels(single.labels));
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
