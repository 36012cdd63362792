//! Writing results: never over an existing file unasked, never half a file.

use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;

use crate::failure::{During, Failure, Step};

/// Where a result goes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Target {
    /// Standard output.
    Stdout,
    /// A file.
    File(PathBuf),
}

impl Target {
    /// `-` is standard output.
    pub(crate) fn new(path: &Path) -> Self {
        if path == Path::new("-") {
            Self::Stdout
        } else {
            Self::File(path.to_owned())
        }
    }

    /// Refuses early what [`Target::write`] would refuse after all the work.
    pub(crate) fn check(&self, overwrite: bool) -> Result<(), Failure> {
        let Self::File(path) = self else {
            return Ok(());
        };
        if path.is_dir() {
            return Err(anyhow::anyhow!("output {} is a folder", path.display())).during(Step::Output);
        }
        if path.exists() && !overwrite {
            return Err(exists(path));
        }
        match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
                Err(anyhow::anyhow!("folder {} does not exist", folder.display())).during(Step::Output)
            }
            _ => Ok(()),
        }
    }

    /// Writes all bytes, or leaves what was there.
    pub(crate) fn write(&self, bytes: &[u8], overwrite: bool) -> Result<(), Failure> {
        match self {
            Self::Stdout => {
                let mut stdout = std::io::stdout().lock();
                stdout
                    .write_all(bytes)
                    .and_then(|()| stdout.flush())
                    .context("cannot write to stdout")
                    .during(Step::Output)
            }
            Self::File(path) => replace(path, overwrite, |scratch| {
                let mut file = File::create(scratch)?;
                file.write_all(bytes)?;
                Ok(file.sync_all()?)
            }),
        }
    }
}

fn exists(path: &Path) -> Failure {
    Err::<(), _>(anyhow::anyhow!("{} already exists", path.display()))
        .during(Step::Output)
        .expect_err("is an error")
        .hint("-w overwrites it, -o names another file")
}

/// Lets `write` fill a scratch file beside `path`, with the same extension, and moves it there when it is complete.
pub(crate) fn replace(
    path: &Path,
    overwrite: bool,
    write: impl FnOnce(&Path) -> anyhow::Result<()>,
) -> Result<(), Failure> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let scratch = path.with_file_name(format!(".{}.{name}", std::process::id()));
    let moved = write(&scratch).and_then(|()| {
        if !overwrite {
            // Claims the name, so that a file that appeared meanwhile survives.
            OpenOptions::new().write(true).create_new(true).open(path)?;
        }
        Ok(fs::rename(&scratch, path)?)
    });
    if moved.is_err() {
        // The scratch file may never have come to be.
        let _ = fs::remove_file(&scratch);
    }
    moved
        .with_context(|| format!("cannot write {}", path.display()))
        .during(Step::Output)
}
