//! OME-Zarr 0.1 to 0.5 and bare Zarr arrays, of versions 2 and 3, in a local folder or a store.
//!
//! Read: chunks and shards, plain or compressed by Blosc, gzip, zlib, zstd or LZ4; level, channel and time by the
//! options. The reader is our own: the crate for Zarr brings compressors in C and about a hundred other crates. Not
//! read: plates, label images except by their own folder, data types other than real numbers.
//!
//! | module | holds |
//! |---|---|
//! | `folder` | folders of keys, on a disk or in a store |
//! | `store` | metadata of an image: levels, axes, channels |
//! | `array`, `fill`, `ome`, `own` | metadata of arrays, OME's, and ours |
//! | `geometry` | axes and places |
//! | `files` | stored bytes of a chunk, from files and shards |
//! | `codec`, `blosc`, `shuffle` | what becomes of them |
//! | `level` | samples of a chunk |
//! | `source`, `bounds`, `spread` | chunks of all levels, and what is known of them without reading |
//! | `whole` | all chunks of a level |
//! | `write` | images with levels of detail, from any source of chunks |

mod array;
mod blosc;
mod bounds;
mod codec;
mod files;
mod fill;
mod folder;
mod geometry;
mod level;
mod ome;
mod own;
mod shuffle;
mod source;
mod spread;
mod store;
mod whole;
mod write;

use std::path::Path;
use std::sync::Arc;

use super::{Loaded, Opened, ReadOptions, sample_count};
use crate::error::Context;
use crate::key_store::KeyStore;
use crate::samples::rounded;
use crate::{IoError, remote};
use folder::Folder;
use store::Store;

pub use write::{Compression, OmeVersion, Pyramid, PyramidOptions, write_pyramid};

/// True for the folder of a group or an array.
pub(super) fn is_zarr(folder: &Path) -> bool {
    [".zgroup", ".zarray", ".zattrs", "zarr.json"]
        .iter()
        .any(|name| crate::files::is_file(&folder.join(name)))
}

/// Reads an image or an array.
///
/// # Errors
/// See [`IoError`].
pub fn read(folder: &Path, options: &ReadOptions) -> Result<Loaded, IoError> {
    let store = Store::open(&folder_of(folder)?, options)?;
    let chosen = store.check_level(options)?;
    let (mut draft, part) = store.draft(chosen, options)?;
    let array = &store.arrays[chosen];
    let context = &Context::new("Zarr array", array.folder.path()).following(options);
    sample_count(draft.dims, 1, array.sample_type, options, context)?;
    let level = store.level(chosen, (&draft, part), options)?;
    let samples = whole::read(&level, chosen, context)?;
    if let Some(warning) = rounded(level.inexact()) {
        draft.warn(warning);
    }
    draft.finish(samples, context)
}

/// Opens an image or an array; only its metadata are read. The levels are those from the chosen one on.
///
/// # Errors
/// See [`IoError`].
pub(super) fn open(folder: &Path, options: &ReadOptions) -> Result<Opened, IoError> {
    source::open(&Store::open(&folder_of(folder)?, options)?, options)
}

/// Opens the image or the array at the root of a store; see [`open`].
///
/// # Errors
/// See [`IoError`].
pub(super) fn open_store(store: Arc<dyn KeyStore>, options: &ReadOptions) -> Result<Opened, IoError> {
    source::open(&Store::open(&Folder::of_store(store), options)?, options)
}

/// The folder on a disk, or at an address.
fn folder_of(path: &Path) -> Result<Folder, IoError> {
    match remote::address(path) {
        Some(address) => remote::open(address).map(Folder::of_store),
        None => Ok(Folder::on_disk(path)),
    }
}
