//! NRRD.

use std::path::Path;

use splatvol_scene::Volume;

use super::{Loaded, ReadOptions, WriteOptions};
use crate::IoError;
use crate::error::Context;

/// Reads a file of this format.
///
/// # Errors
/// See [`IoError`].
pub fn read(path: &Path, _options: &ReadOptions) -> Result<Loaded, IoError> {
    Err(Context::new("NRRD", path).unsupported("this format is not read yet"))
}

/// Writes the samples.
///
/// # Errors
/// See [`IoError`].
pub fn write(path: &Path, _volume: &Volume, _options: &WriteOptions) -> Result<(), IoError> {
    Err(Context::new("NRRD", path).unsupported("this format is not written yet"))
}
