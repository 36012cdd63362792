//! One report of many experiments: a self-contained HTML page, and the same as Markdown beside files.

mod html;
mod index;
mod machine;
mod markdown;
mod summary;
#[cfg(test)]
mod tests;

use std::path::Path;

use crate::{LabError, Run, folder};

/// Writes `index.html`, which holds everything, and `lab.md` with the files of [`folder::write`], which it shows.
///
/// # Errors
/// A file cannot be written.
pub fn write(runs: &[Run], folder: &Path) -> Result<(), LabError> {
    std::fs::create_dir_all(folder).map_err(|source| LabError::Write {
        path: folder.to_owned(),
        source,
    })?;
    for run in runs {
        folder::write(run, folder)?;
    }
    folder::put(&folder.join("index.html"), html::page(runs)?.as_bytes())?;
    folder::put(&folder.join("lab.md"), markdown::page(runs).as_bytes())
}
