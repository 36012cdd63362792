//! Three-dimensional Gaussians: one module per format, and the choice between them.
//!
//! | format | frame of the file | stores |
//! |---|---|---|
//! | `.ply` (Kerbl 2023) | RDF | `f_dc`, `f_rest` by colour, logit of opacity, logarithms of scales, quaternion w x y z |
//! | compressed `.ply` (`PlayCanvas`) | RDF | chunks of 256 with bounds, 11-10-11 bits, largest component left out |
//! | `.splat` (Kwok 2023) | RDF | 32 bytes each, no harmonics |
//! | `.ksplat` (Kellogg), version 0.1 | RDF | sections and buckets, three levels of compression |
//! | `.spz` (Niantic), versions 1 to 4 | RUB, or as an extension says | fixed-point means, 8-bit harmonics; gzip or zstd |
//! | `.sog` (`PlayCanvas`), versions 1 and 2 | RDF | lossless WebP pictures, codebooks; a zip or a folder |
//! | `.gltf`, `.glb` with `KHR_gaussian_splatting` | y up | accessors, or SPZ inside |
//!
//! Frames are named by the directions of x, y and z: right or left, up or down, forward or back. World is right-handed,
//! z up: `world_from_local` takes RDF's (x, y, z) to (x, z, -y) and RUB's to (x, -z, y). Attributes, harmonics
//! included, stay in the file's own frame, in which the harmonics are evaluated. So the same Gaussians stored in two
//! formats lie at the same world places and have the same colours from the same world directions. Yet SPZ's
//! coefficients differ from those of a `.ply`: every harmonic that is odd in y and z together has the opposite sign.
//!
//! Like viewers on the web, this reader does not know which way is up: the frame is a convention, and a capture may
//! still stand askew in it.

mod collect;
mod compressed_ply;
mod detect;
mod fields;
mod frame;
mod gltf;
mod harmonics;
mod inria_ply;
mod ksplat;
mod sog;
mod splat;
mod spz;
mod transform;
mod write;

use std::path::{Path, PathBuf};

use splatvol_scene::Gaussians;

use crate::{IoError, ReadOptions};
use detect::Format;

/// Gaussians and where they came from.
#[derive(Debug, Clone)]
pub struct LoadedGaussians {
    /// The Gaussians.
    pub gaussians: Gaussians,
    /// Description of the file.
    pub description: GaussiansDescription,
}

/// Description of a Gaussian file, for people.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct GaussiansDescription {
    /// Format and version: `SPZ 4`, `PLY (3-D Gaussians)`.
    pub format: String,
    /// Storage of the numbers: `binary_little_endian, 62 properties`.
    pub stored_type: String,
    /// The file's frame and how it became world space.
    pub orientation: String,
    /// Number of Gaussians.
    pub count: usize,
    /// Degree of the harmonics, 0 to 3.
    pub degree: u32,
    /// Rendering modes that the Gaussians were trained for: `antialiased`, `mip`, `flat`, `linear`.
    pub tags: Vec<String>,
    /// The file, followed by the files that it names.
    pub files: Vec<PathBuf>,
    /// Oddities that did not prevent reading.
    pub warnings: Vec<String>,
}

/// True where the file holds 3-D Gaussians of a format that [`read_gaussians`] knows; false for anything else, such as
/// points in a `.ply`, and for files that cannot be read at all.
pub fn is_gaussians(path: impl AsRef<Path>) -> bool {
    matches!(detect::format(path.as_ref()), Ok(Some(_)))
}

/// Reads 3-D Gaussians of any supported format. The contents decide; the extension decides only for `.splat` and
/// `.ksplat`, which have no signature.
///
/// # Errors
/// See [`IoError`]; with [`ReadOptions::strict`] also where a warning would be given.
pub fn read_gaussians(path: impl AsRef<Path>, options: &ReadOptions) -> Result<LoadedGaussians, IoError> {
    let path = path.as_ref();
    let loaded = match detect::format(path)? {
        Some(Format::InriaPly) => inria_ply::read(path, options),
        Some(Format::CompressedPly) => compressed_ply::read(path, options),
        Some(Format::Splat) => splat::read(path, options),
        Some(Format::Ksplat) => ksplat::read(path, options),
        Some(Format::Spz) => spz::read(path, options),
        Some(Format::Sog) => sog::read(path, options),
        Some(Format::Gltf) => gltf::read(path, options),
        None => Err(detect::unknown(path)),
    }?;
    if options.strict && !loaded.description.warnings.is_empty() {
        return Err(IoError::Strict {
            warning: loaded.description.warnings.join("; "),
            path: path.to_owned(),
        });
    }
    Ok(loaded)
}

/// Writes Gaussians in the frame of the format that the extension names: `.ply` (as trained, exact), `.splat` (8-bit
/// colours and rotations, no harmonics) or `.spz` (version 3).
///
/// # Errors
/// [`IoError::Unsupported`] for other extensions and for Gaussians whose `world_from_local` is not a similarity,
/// [`IoError::Write`] where the file cannot be written.
pub fn write_gaussians(path: impl AsRef<Path>, gaussians: &Gaussians) -> Result<(), IoError> {
    write::write(path.as_ref(), gaussians)
}
