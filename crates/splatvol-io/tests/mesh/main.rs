//! Meshes: real files against the figures of other readers (VTK's own, six digits), and small files made by hand.

mod malformed;
mod real;
mod written;

use std::path::{Path, PathBuf};

use splatvol_io::{LoadedMesh, ReadOptions, read_mesh};

/// Options that name an array.
fn array(name: &str) -> ReadOptions {
    ReadOptions {
        array: Some(name.to_owned()),
        ..ReadOptions::default()
    }
}

/// Folder of the real files; none outside the project's own workplace.
fn real_files() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/meshes");
    if folder.is_dir() {
        return Some(folder);
    }
    println!(
        "skipped: {}: no ../shared/data",
        std::thread::current().name().unwrap_or("a test")
    );
    None
}

fn read(path: &Path, name: Option<&str>) -> LoadedMesh {
    let options = name.map_or_else(ReadOptions::default, array);
    read_mesh(path, &options).unwrap_or_else(|error| panic!("{error}"))
}
