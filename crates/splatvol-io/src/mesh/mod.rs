//! Meshes: one module per format, and the choice between them by the first bytes.
//!
//! | module | formats |
//! |---|---|
//! | [`legacy_vtk`] | `RECTILINEAR_GRID`, `STRUCTURED_GRID` and `UNSTRUCTURED_GRID` of legacy VTK |
//! | [`vtk_xml`] | .vtr, .vts and .vtu |
//! | [`plot3d`] | a PLOT3D grid and its solution |

mod assemble;
pub mod legacy_vtk;
pub mod plot3d;
pub(crate) mod poly;
pub mod vtk_xml;

use std::path::Path;

use splatvol_scene::Mesh;

use crate::IoError;
use crate::error::Context;
use crate::source::Source;
use crate::volume::{Description, ReadOptions};

/// Bytes examined to detect a format.
const PROBE: usize = 4096;

/// A mesh and where it came from.
#[derive(Debug, Clone)]
pub struct LoadedMesh {
    /// The mesh.
    pub mesh: Mesh,
    /// Description of the file.
    pub description: Description,
    /// The arrays that the file holds, one line each; any of them can be named as [`ReadOptions::array`].
    pub arrays: Vec<String>,
    /// Names of the arrays that could be shown instead, the likeliest first.
    others: Vec<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    LegacyVtk,
    VtkXml,
    Plot3d,
}

/// True if [`read_mesh`] and not [`crate::read_volume`] reads the file: a VTK file whose data set is not a regular
/// grid, or a PLOT3D file.
///
/// # Errors
/// [`IoError::Open`] where the file cannot be read.
pub fn is_mesh(path: impl AsRef<Path>) -> Result<bool, IoError> {
    Ok(format(path.as_ref())?.is_some())
}

/// Reads a mesh of any supported format, and of its arrays the one that [`ReadOptions::array`] names: `NAME`,
/// `NAME:component`, `NAME:magnitude`. A vector without a component gives its magnitude. Without a name: the array that
/// the file marks, else the first scalar of the points, else of the cells, else the magnitude of the first vector. An
/// array with one value everywhere shows nothing: then the next one that varies is read, if there is one.
///
/// # Errors
/// See [`IoError`]; with [`ReadOptions::strict`] also where a warning would be given.
pub fn read_mesh(path: impl AsRef<Path>, options: &ReadOptions) -> Result<LoadedMesh, IoError> {
    let path = path.as_ref();
    let first = read_array(path, options)?;
    let loaded = match options.array {
        None if is_constant(&first.mesh) => varying(path, options, &first.others).unwrap_or(first),
        _ => first,
    };
    if options.strict && !loaded.description.warnings.is_empty() {
        return Err(IoError::Strict {
            warning: loaded.description.warnings.join("; "),
            path: path.to_owned(),
        });
    }
    Ok(loaded)
}

/// Reads the array that the options name, or the one that their absence means.
fn read_array(path: &Path, options: &ReadOptions) -> Result<LoadedMesh, IoError> {
    match format(path)? {
        Some(Format::LegacyVtk) => legacy_vtk::read(path, options),
        Some(Format::VtkXml) => vtk_xml::read(path, options),
        Some(Format::Plot3d) => plot3d::read(path, options),
        None if options.solution.is_some() => plot3d::read(path, options),
        None => {
            let what = "no mesh: neither a VTK grid (legacy or XML) that is not regular nor PLOT3D";
            Err(Context::new("mesh", path).unsupported(what))
        }
    }
}

fn is_constant(mesh: &Mesh) -> bool {
    let [low, high] = mesh.value_range();
    low == high
}

/// The first of these arrays that varies. Arrays that cannot be read are skipped, because nobody asked for
/// them.
fn varying(path: &Path, options: &ReadOptions, names: &[String]) -> Option<LoadedMesh> {
    let read = |name: &String| {
        let options = ReadOptions {
            array: Some(name.clone()),
            ..options.clone()
        };
        read_array(path, &options).ok()
    };
    names
        .iter()
        .filter_map(read)
        .find(|loaded| !is_constant(&loaded.mesh))
}

/// The reader of a file of polygonal data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PolyFormat {
    LegacyVtk,
    VtkXml,
}

/// The kind of polygonal data that a file begins like, if it does.
fn poly_format(start: &[u8]) -> Option<PolyFormat> {
    let text = String::from_utf8_lossy(start).to_ascii_uppercase();
    if data_set(&text) == Some("POLYDATA") {
        return Some(PolyFormat::LegacyVtk);
    }
    let xml =
        text.trim_start().starts_with('<') && text.contains("<VTKFILE") && text.contains("\"POLYDATA\"");
    xml.then_some(PolyFormat::VtkXml)
}

/// The reader of a file's surface: polygonal data, or an unstructured grid of flat cells.
pub(crate) fn surface_format(path: &Path, start: &[u8]) -> Option<PolyFormat> {
    let text = String::from_utf8_lossy(start).to_ascii_uppercase();
    if data_set(&text) == Some("UNSTRUCTURED_GRID") {
        return legacy_vtk::has_flat_cells(path).then_some(PolyFormat::LegacyVtk);
    }
    let is_xml = text.trim_start().starts_with('<') && text.contains("<VTKFILE");
    if is_xml && text.contains("\"UNSTRUCTUREDGRID\"") {
        return vtk_xml::has_flat_cells(path).then_some(PolyFormat::VtkXml);
    }
    poly_format(start)
}

/// The data set of a legacy VTK file, in capitals.
fn data_set(text: &str) -> Option<&str> {
    if !text.starts_with("# VTK DATAFILE") {
        return None;
    }
    let mut lines = text.lines().take(20);
    let found = lines.find_map(|line| line.trim_start().strip_prefix("DATASET"));
    Some(found.map(str::trim).unwrap_or_default())
}

fn format(path: &Path) -> Result<Option<Format>, IoError> {
    let context = Context::new("mesh", path);
    let mut source = Source::open(path)?;
    let mut start = vec![0; PROBE];
    let length = source.fill(&mut start, &context)?;
    start.truncate(length);
    let text = String::from_utf8_lossy(&start).to_ascii_uppercase();
    let holds = |words: &[&str]| words.iter().any(|word| text.contains(word));
    if let Some(kind) = data_set(&text) {
        let kinds = ["RECTILINEAR_GRID", "STRUCTURED_GRID", "UNSTRUCTURED_GRID"];
        return Ok(kinds.contains(&kind).then_some(Format::LegacyVtk));
    }
    if text.trim_start().starts_with('<') && text.contains("<VTKFILE") {
        let kinds = [
            "\"RECTILINEARGRID\"",
            "\"STRUCTUREDGRID\"",
            "\"UNSTRUCTUREDGRID\"",
        ];
        return Ok(holds(&kinds).then_some(Format::VtkXml));
    }
    Ok(plot3d::recognises(path, &start, length as u64 + source.at_most()).then_some(Format::Plot3d))
}
