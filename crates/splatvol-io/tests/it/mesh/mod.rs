//! Meshes: real files against the figures of other readers (VTK's own, six digits), and small files made by hand.

mod malformed;
mod plot3d_text;
mod real;
mod surfaces;
mod written;

use std::path::{Path, PathBuf};

use splatvol_io::{LoadedMesh, ReadOptions, read_mesh};
use splatvol_recorded::recorded;

/// Options that name an array.
fn array(name: &str) -> ReadOptions {
    ReadOptions {
        array: Some(name.to_owned()),
        ..ReadOptions::default()
    }
}

/// Folder of the real files; none outside the project's own workplace.
fn real_files() -> Option<PathBuf> {
    recorded("meshes")
}

fn read(path: &Path, name: Option<&str>) -> LoadedMesh {
    let options = name.map_or_else(ReadOptions::default, array);
    read_mesh(path, &options).unwrap_or_else(|error| panic!("{error}"))
}
