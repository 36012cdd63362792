//! VTK XML image data (.vti).

use std::path::Path;

use super::{Loaded, ReadOptions};
use crate::IoError;
use crate::error::Context;

/// Reads a file of this format.
///
/// # Errors
/// See [`IoError`].
pub fn read(path: &Path, _options: &ReadOptions) -> Result<Loaded, IoError> {
    Err(Context::new("vti", path).unsupported("this format is not read yet"))
}
