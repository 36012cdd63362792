//! Clouds of points: one module per format, and the choice between them.
//!
//! | module | formats |
//! |---|---|
//! | `ply` | PLY: clouds, and meshes as surfels |
//! | `poly` | polygonal data and flat cells of VTK, legacy, .vtp and .vtu, as surfels |
//! | [`las`] | LAS 1.0 to 1.4, LAZ, COPC |
//! | [`pcd`] | PCD 0.5 to 0.7, ascii, binary, `binary_compressed` |
//! | [`text`] | XYZ, CSV, PTS and other tables of numbers |
//! | [`triangles`] | surfels of triangle meshes |
//! | [`height_field`] | terrain: USGS DEM, `GeoTIFF`, tables, raw |
//! | [`depth_image`] | frames of depth cameras |
//!
//! Positions are read in 64 bits. If they lie far from zero, they get a local origin before they become 32 bits.
//! Colours are sRGB, however many bits they were stored with. Points without a place (NaN) are left out and counted.

mod columns;
pub mod depth_image;
mod gather;
pub mod height_field;
pub mod las;
pub mod pcd;
pub mod ply;
mod poly;
mod scalar_colors;
pub mod text;
pub mod triangles;

pub use gather::around_local_origin;

use std::path::Path;

use glam::DVec3;
use splatvol_scene::Points;

use crate::error::Context;
use crate::mesh::{PolyFormat, surface_format};
use crate::source::Source;
use crate::{Description, IoError, ReadOptions};

/// Bytes examined to tell formats apart.
const PROBE: usize = 4096;

/// Points and where they came from.
#[derive(Debug, Clone)]
pub struct LoadedPoints {
    /// The points.
    pub points: Points,
    /// Description of the file.
    pub description: Description,
    /// Position of the scanner, world, if the file gives it: normals point to its side.
    pub viewpoint: Option<DVec3>,
}

impl LoadedPoints {
    /// Turns warnings into an error if reading is strict.
    fn checked(self, strict: bool, path: &Path) -> Result<Self, IoError> {
        if strict && !self.description.warnings.is_empty() {
            return Err(IoError::Strict {
                warning: self.description.warnings.join("; "),
                path: path.to_owned(),
            });
        }
        Ok(self)
    }
}

/// Reads points of any supported format. The first bytes of the file decide; its extension counts only if they do
/// not. Only the options `strict`, `max_bytes` and, for surfaces of VTK, `array` matter.
///
/// # Errors
/// See [`IoError`]; with [`ReadOptions::strict`] also where a warning would be given.
pub fn read_points(path: impl AsRef<Path>, options: &ReadOptions) -> Result<LoadedPoints, IoError> {
    let path = path.as_ref();
    let format = format(path)?;
    if let (Some(array), false) = (&options.array, matches!(format, Format::Poly(_))) {
        let expected = "no such choice: only surfaces of VTK have arrays to choose from";
        return Err(Context::new("points", path).field("array", array, None, expected));
    }
    let loaded = match format {
        Format::Poly(format) => poly::read(path, format, options),
        Format::Ply => ply::read(path, options),
        Format::Las => las::read(path, options),
        Format::Pcd => pcd::read(path, options),
        Format::Text => text::read(path, options),
    }?;
    loaded.checked(options.strict, path)
}

/// Whether [`read_points`] takes the file.
pub(crate) fn is_known(path: &Path) -> Result<bool, IoError> {
    match format(path) {
        Ok(_) => Ok(true),
        Err(IoError::Unsupported { .. }) => Ok(false),
        Err(error) => Err(error),
    }
}

/// The formats of clouds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Ply,
    Poly(PolyFormat),
    Las,
    Pcd,
    Text,
}

/// Whether the file holds a surface in one of VTK's formats.
pub(crate) fn is_poly_data(path: &Path) -> Result<bool, IoError> {
    Ok(surface_format(path, &start_of(path)?).is_some())
}

fn start_of(path: &Path) -> Result<Vec<u8>, IoError> {
    let mut start = vec![0; PROBE];
    let length = Source::open(path)?.fill(&mut start, &Context::new("points", path))?;
    start.truncate(length);
    Ok(start)
}

fn format(path: &Path) -> Result<Format, IoError> {
    let context = Context::new("points", path);
    let start = start_of(path)?;
    let extension = path
        .extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_ascii_lowercase();
    if start.starts_with(b"ply") && start.get(3).is_some_and(u8::is_ascii_whitespace) {
        return Ok(Format::Ply);
    }
    if let Some(format) = surface_format(path, &start) {
        return Ok(Format::Poly(format));
    }
    if start.starts_with(b"LASF") {
        return Ok(Format::Las);
    }
    if pcd::is_header(&start) {
        return Ok(Format::Pcd);
    }
    let textual = !start.is_empty()
        && start
            .iter()
            .all(|byte| !byte.is_ascii_control() || byte.is_ascii_whitespace());
    match extension.as_str() {
        "ply" => Ok(Format::Ply),
        "las" | "laz" => Ok(Format::Las),
        "pcd" => Ok(Format::Pcd),
        "xyz" | "csv" | "txt" | "asc" | "pts" | "xyzrgb" | "xyzn" | "tsv" => Ok(Format::Text),
        _ if textual => Ok(Format::Text),
        _ => Err(context.unsupported(format!(
            "neither the first bytes nor the extension \"{extension}\" belong to a known format of points \
             (PLY, VTK PolyData, LAS, LAZ, COPC, PCD, tables of text)"
        ))),
    }
}
