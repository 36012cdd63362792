//! Small valid files of every format, written by the library, by generators of its tests, or here.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "valid files are made of constants: a failure is a mistake here, and ends the program"
)]

pub(crate) mod gaussians;
pub(crate) mod looks;
pub(crate) mod meshes;
pub(crate) mod points;
pub(crate) mod terrain;
pub(crate) mod volumes;
pub(crate) mod zarr;

use crate::input::Input;

/// The files whose names end in one of these.
fn ending(files: Vec<(&'static str, Vec<u8>)>, ends: &[&str]) -> Vec<Input> {
    let fits = |name: &str| ends.iter().any(|end| name.ends_with(end));
    let files = files.into_iter().filter(|(name, _)| fits(name));
    files.map(|(name, bytes)| Input::file(name, bytes)).collect()
}

/// What a writer makes of a file's name.
fn written(name: &str, write: impl FnOnce(&std::path::Path)) -> Input {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    write(&path);
    Input::file(name, std::fs::read(path).unwrap())
}
