//! All samples of an array at once: a loop over its chunks.

use std::path::Path;

use splatvol_scene::{ChunkBuffer, ChunkContent, Samples, VoxelBox, chunks::copy_box};

use super::array::Array;
use super::files::{Failure, INDEX_ENTRY};
use super::level::{ArrayLevel, RATIO, SPARSE};
use crate::IoError;
use crate::error::Context;
use crate::files;

/// Chunks that are looked for, per file that exists; and those that always are.
const CHUNKS_PER_FILE: usize = 64;
const FEW_CHUNKS: usize = 10_000;
/// Chunks of a level that are believed without a look at its files.
const BELIEVED: usize = 1 << 20;

/// Most bytes of samples that are read whole from a store.
const STORED: u64 = 256 << 20;

/// Reads all samples; `level` is named in errors.
pub(super) fn read(source: &ArrayLevel, level: usize, context: &Context<'_>) -> Result<Samples, IoError> {
    check_files(source, context)?;
    let layout = &source.layout;
    let all = VoxelBox::whole(&layout.grid);
    let mut samples = layout.element.filled(all.len(), layout.fill);
    let mut buffer = ChunkBuffer::default();
    for chunk in layout.chunks_of(all) {
        let content = source
            .read(chunk, &mut buffer)
            .map_err(|failure| error(failure, level, chunk, context))?;
        if content == ChunkContent::Samples {
            copy_box(&buffer.samples, layout.region(chunk), &mut samples, all);
        }
    }
    Ok(samples)
}

fn error(failure: Failure, level: usize, chunk: [usize; 3], context: &Context<'_>) -> IoError {
    match failure {
        Failure::Outside(error) => *error,
        failure => context.chunk(failure.at(level, chunk)),
    }
}

/// Checks the claims of the metadata against the files present, of which no more are looked at than the claims need.
fn check_files(source: &ArrayLevel, context: &Context<'_>) -> Result<(), IoError> {
    let (array, part) = (&source.array, &source.part);
    let product = |size: &dyn Fn(usize) -> usize| {
        let mut axes = part.spatial.iter();
        axes.try_fold(1usize, |product, &axis| product.checked_mul(size(axis)))
    };
    let chunk = array.samples_of_chunk() as u64 * array.sample_type.size() as u64;
    let wanted = product(&|axis| array.shape[axis]).unwrap_or(usize::MAX);
    let wanted = array.sample_type.byte_count(wanted).max(chunk);
    if array.folder.stored("").is_some() {
        // Nothing is known of a store but what it answers.
        return match wanted <= STORED {
            true => Ok(()),
            false => Err(context.limit(wanted, STORED)),
        };
    }
    let chunks = count_chunks(source);
    let mut found = Found::default();
    found.count(array.folder.path(), array.shape.len() + 1, &|found| {
        found.bytes_allow(wanted) && found.files_allow(chunks, array)
    });
    if !found.bytes_allow(wanted) {
        let most = if found.files == 0 { 0 } else { found.most() };
        return Err(context.too_small("chunks", wanted, most));
    }
    found.check_files_allow(chunks, array, context)
}

/// Checks that a level that is read in chunks has no more of them than its files justify: whoever draws it makes lists of
/// them. Of a store nothing is known but what it answers; there, the coarsest level has no more than an overview may read.
pub(super) fn check_chunks(
    source: &ArrayLevel,
    is_coarsest: bool,
    context: &Context<'_>,
) -> Result<(), IoError> {
    let array = &source.array;
    let chunks = count_chunks(source);
    if chunks.is_some_and(|chunks| chunks <= BELIEVED) {
        return Ok(());
    }
    if array.folder.stored("").is_some() {
        return match is_coarsest {
            true => {
                let expected = format!("at most {BELIEVED} chunks, or coarser levels");
                Err(too_many_chunks(array, &expected, context))
            }
            false => Ok(()),
        };
    }
    let mut found = Found::default();
    found.count(array.folder.path(), array.shape.len() + 1, &|found| {
        found.files_allow(chunks, array)
    });
    found.check_files_allow(chunks, array, context)
}

/// Chunks of a level, where they can be counted.
fn count_chunks(source: &ArrayLevel) -> Option<usize> {
    let (array, mut axes) = (&source.array, source.part.spatial.iter());
    axes.try_fold(1usize, |product, &axis| {
        product.checked_mul(array.shape[axis].div_ceil(array.chunks[axis]))
    })
}

fn too_many_chunks(array: &Array, expected: &str, context: &Context<'_>) -> IoError {
    let shown = format!("{:?} in chunks of {:?}", array.shape, array.chunks);
    context.field("shape", shown, None, expected)
}

/// Files below a folder and their bytes, as far as they were looked at.
#[derive(Debug, Default)]
struct Found {
    files: usize,
    bytes: u64,
}

impl Found {
    /// Most bytes of samples that the files justify.
    fn most(&self) -> u64 {
        SPARSE.max(RATIO.saturating_mul(self.bytes))
    }

    fn bytes_allow(&self, wanted: u64) -> bool {
        self.files > 0 && wanted <= self.most()
    }

    /// Whether so many chunks may be looked for.
    fn files_allow(&self, chunks: Option<usize>, array: &Array) -> bool {
        // A shard lists its chunks at its end.
        let listed = usize::try_from(self.bytes / INDEX_ENTRY).unwrap_or(usize::MAX);
        let per_file = array.shard.as_ref().map_or(1, |shard| {
            let inner = shard.chunks_along(&array.chunks);
            inner.into_iter().fold(1usize, usize::saturating_mul).min(listed)
        });
        let looked_for = CHUNKS_PER_FILE
            .saturating_mul(self.files)
            .saturating_mul(per_file);
        chunks.is_some_and(|chunks| chunks <= looked_for.saturating_add(FEW_CHUNKS))
    }

    /// Refuses more chunks than the files allow.
    fn check_files_allow(
        &self,
        chunks: Option<usize>,
        array: &Array,
        context: &Context<'_>,
    ) -> Result<(), IoError> {
        match self.files_allow(chunks, array) {
            true => Ok(()),
            false => {
                let expected = format!("chunks in {} files", self.files);
                Err(too_many_chunks(array, &expected, context))
            }
        }
    }

    /// Counts until there are enough; links are not followed.
    fn count(&mut self, folder: &Path, depth: usize, enough: &dyn Fn(&Self) -> bool) {
        let Ok(entries) = files::read_dir(folder) else {
            return;
        };
        for entry in entries.flatten() {
            let Ok(metadata) = entry.metadata() else { continue };
            let name = entry.file_name();
            let hidden = name.to_string_lossy().starts_with('.') || name == "zarr.json";
            if metadata.is_dir() && depth > 0 {
                self.count(&entry.path(), depth - 1, enough);
            } else if metadata.is_file() && !hidden {
                self.files += 1;
                self.bytes += metadata.len();
            }
            if enough(self) {
                return;
            }
        }
    }
}
