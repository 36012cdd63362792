//! An image as a source of chunks: metadata are read when it is opened, and each chunk when it is asked for.

use std::sync::{Arc, OnceLock};

use sha2::{Digest, Sha256};
use splatvol_scene::{
    ChunkBuffer, ChunkContent, ChunkSource, LevelLayout, MinMaxIndex, SourceError, SourceIdentity,
};

use super::bounds;
use super::folder::Folder;
use super::level::ArrayLevel;
use super::spread;
use super::store::Store;
use super::whole;
use crate::IoError;
use crate::error::Context;
use crate::volume::{Opened, ReadOptions};

/// Levels of an image, chunk by chunk.
#[derive(Debug)]
pub(super) struct ZarrSource {
    layouts: Vec<LevelLayout>,
    levels: Vec<ArrayLevel>,
    /// Smallest and largest samples of blocks of each level, read when they are asked for.
    indices: Vec<OnceLock<Option<Arc<MinMaxIndex>>>>,
    /// Samples that stand for each level, read when they are asked for.
    spread: Vec<OnceLock<Option<Vec<f64>>>>,
    /// Folder, number of the first level, and how it is read.
    place: (Folder, usize, ReadOptions),
    identity: SourceIdentity,
    is_of_labels: bool,
}

/// Opens all levels from the chosen one on.
pub(super) fn open(store: &Store, options: &ReadOptions) -> Result<Opened, IoError> {
    let first = store.check_level(options)?;
    let (finest, _) = store.draft(first, options)?;
    let mut levels = Vec::new();
    for level in first..store.arrays.len() {
        let (draft, part) = store.draft(level, options)?;
        let opened = store.level(level, (&draft, part), options)?;
        let context = &Context::new("Zarr array", opened.array.folder.path()).following(options);
        whole::check_chunks(&opened, level + 1 == store.arrays.len(), context)?;
        levels.push(opened);
    }
    let source = ZarrSource {
        layouts: levels.iter().map(|level| level.layout.clone()).collect(),
        identity: identity(store, &levels),
        is_of_labels: finest.description.is_labels,
        spread: levels.iter().map(|_| OnceLock::new()).collect(),
        place: (store.folder.clone(), first, options.clone()),
        indices: levels.iter().map(|_| OnceLock::new()).collect(),
        levels,
    };
    Ok(Opened {
        source: Arc::new(source),
        unit: finest.unit,
        is_divided: true,
        description: finest.description,
    })
}

fn identity(store: &Store, levels: &[ArrayLevel]) -> SourceIdentity {
    let mut hash = Sha256::new();
    for level in levels {
        hash.update(format!("{:?}{:?}{:?}", level.array, level.part, level.layout));
    }
    let state: String = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    SourceIdentity {
        name: store.folder.path().display().to_string(),
        state,
    }
}

impl ChunkSource for ZarrSource {
    fn levels(&self) -> &[LevelLayout] {
        &self.layouts
    }

    fn read(
        &self,
        level: usize,
        chunk: [usize; 3],
        into: &mut ChunkBuffer,
    ) -> Result<ChunkContent, SourceError> {
        self.levels[level]
            .read(chunk, into)
            .map_err(|failure| failure.at(level, chunk))
    }

    fn will_need(&self, chunks: &[(usize, [usize; 3])]) {
        for (number, level) in self.levels.iter().enumerate() {
            let own = chunks.iter().filter(|(level, _)| *level == number);
            level.will_need(own.map(|&(_, chunk)| chunk));
        }
    }

    fn index(&self, level: usize) -> Option<Arc<MinMaxIndex>> {
        let (folder, first, options) = &self.place;
        let read = || bounds::read(folder, first + level, &self.levels[level], options).map(Arc::new);
        self.indices[level].get_or_init(read).clone()
    }

    fn spread(&self, level: usize) -> Option<Vec<f64>> {
        let (folder, first, options) = &self.place;
        let read = || spread::read(folder, first + level, &self.levels[level], options);
        self.spread[level].get_or_init(read).clone()
    }

    fn is_of_labels(&self) -> bool {
        self.is_of_labels
    }

    fn identity(&self) -> SourceIdentity {
        self.identity.clone()
    }
}
