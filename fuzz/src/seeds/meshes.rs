//! Meshes: legacy VTK, VTK XML and PLOT3D.

use super::ending;
use crate::common::small_meshes;
use crate::input::Input;

pub(crate) fn legacy() -> Vec<Input> {
    ending(small_meshes::files(), &[".vtk"])
}

pub(crate) fn xml() -> Vec<Input> {
    ending(small_meshes::files(), &[".vtu", ".vtr", ".vts", ".vtp"])
}

pub(crate) fn plot3d() -> Vec<Input> {
    let input = |files: [(&str, Vec<u8>); 2]| {
        Input::files(
            "a.xyz",
            files.map(|(name, bytes)| (name.to_owned(), bytes)).to_vec(),
        )
    };
    small_meshes::plot3d().into_iter().map(input).collect()
}
