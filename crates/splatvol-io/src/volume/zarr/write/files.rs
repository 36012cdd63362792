//! Files that are written whole or not at all.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::IoError;

/// Ending of files that are being written.
const UNFINISHED: &str = ".unfinished";

/// Maps an error of the system to one of a path.
pub(super) fn at(path: &Path) -> impl FnOnce(io::Error) -> IoError {
    let path = path.to_owned();
    move |source| IoError::Write { source, path }
}

/// A file that gets its name when it is complete.
pub(super) struct NewFile {
    path: PathBuf,
    unfinished: PathBuf,
    writer: BufWriter<File>,
    length: u64,
}

impl NewFile {
    /// Creates a file, and its folders.
    pub(super) fn create(path: &Path) -> Result<Self, IoError> {
        let mut name = path.as_os_str().to_owned();
        name.push(UNFINISHED);
        let unfinished = PathBuf::from(name);
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(at(folder))?;
        }
        let file = File::create(&unfinished).map_err(at(&unfinished))?;
        Ok(Self {
            path: path.to_owned(),
            unfinished,
            writer: BufWriter::with_capacity(1 << 18, file),
            length: 0,
        })
    }

    /// Bytes written so far.
    pub(super) fn length(&self) -> u64 {
        self.length
    }

    pub(super) fn write(&mut self, bytes: &[u8]) -> Result<(), IoError> {
        self.length += bytes.len() as u64;
        self.writer.write_all(bytes).map_err(at(&self.path))
    }

    /// Gives the file its name.
    pub(super) fn finish(mut self) -> Result<(), IoError> {
        self.writer.flush().map_err(at(&self.path))?;
        fs::rename(&self.unfinished, &self.path).map_err(at(&self.path))
    }
}

/// Writes a file of these bytes.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<(), IoError> {
    let mut file = NewFile::create(path)?;
    file.write(bytes)?;
    file.finish()
}

/// Removes a folder, if there is one.
pub(super) fn remove(folder: &Path) -> Result<(), IoError> {
    match fs::remove_dir_all(folder) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(at(folder)(error)),
        _ => Ok(()),
    }
}
