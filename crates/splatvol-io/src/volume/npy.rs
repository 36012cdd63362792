//! NumPy arrays (.npy) and archives of them (.npz).

use std::path::Path;

use splatvol_scene::Volume;

use super::{Loaded, ReadOptions};
use crate::IoError;
use crate::error::Context;

/// Reads a file of this format.
///
/// # Errors
/// See [`IoError`].
pub fn read(path: &Path, _options: &ReadOptions) -> Result<Loaded, IoError> {
    Err(Context::new("npy", path).unsupported("this format is not read yet"))
}

/// Reads an archive.
///
/// # Errors
/// See [`IoError`].
pub fn read_npz(path: &Path, _options: &ReadOptions) -> Result<Loaded, IoError> {
    Err(Context::new("npz", path).unsupported("this format is not read yet"))
}

/// Writes the samples.
///
/// # Errors
/// See [`IoError`].
pub fn write(path: &Path, _volume: &Volume) -> Result<(), IoError> {
    Err(Context::new("npy", path).unsupported("this format is not written yet"))
}
