//! Volumes that are read in chunks, or whole where a method needs all samples.

use pyo3::prelude::*;
use splatvol_document::{ChunkRules, Picture};

use crate::error::Raise;

/// How volumes are read in chunks; within so many bytes, or half of the machine's memory.
pub(crate) fn chunk_rules(memory: Option<u64>) -> ChunkRules {
    ChunkRules {
        memory: memory.unwrap_or_else(|| splatvol_io::memory::granted() / 2),
        holes: false,
        whole_if_it_fits: false,
    }
}

/// The picture with its volumes in memory, where they are read in chunks and the method needs all samples.
pub(crate) fn whole_where_needed(mut picture: Picture) -> PyResult<Picture> {
    let check = |picture: &Picture| splatvol::check(&picture.scene, &picture.camera, &picture.settings);
    if picture.scene.reads_chunks() && check(&picture).is_err() {
        picture.scene = picture.scene.in_memory().map_err(Raise::raised)?;
    }
    check(&picture).map_err(Raise::raised)?;
    Ok(picture)
}
