//! Detection of the format of a Gaussian file.

use std::path::Path;

use super::{compressed_ply, gltf, inria_ply, sog};
use crate::IoError;
use crate::error::Context;
use crate::ply::Header;
use crate::source::{Codec, Source};

/// The readable formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    InriaPly,
    CompressedPly,
    Splat,
    Ksplat,
    Spz,
    Sog,
    Gltf,
}

/// First bytes of SPZ, after gzip where there is any.
pub(super) const SPZ_MAGIC: &[u8] = b"NGSP";

/// Lower-case extension, empty if there is none.
pub(super) fn extension(path: &Path) -> String {
    path.extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_ascii_lowercase()
}

/// The format of the file (or folder, for SOG) at `path`; `None` if it does not hold Gaussians.
pub(super) fn format(path: &Path) -> Result<Option<Format>, IoError> {
    if sog::is_folder_or_meta(path) {
        return Ok(Some(Format::Sog));
    }
    let context = Context::new("Gaussians", path);
    let mut start = [0; 4];
    let mut source = Source::open(path)?;
    let length = source.fill(&mut start, &context)?;
    let format = match (&start, extension(path).as_str()) {
        (b"NGSP", _) => Some(Format::Spz),
        (b"ply\n" | b"ply\r" | b"ply ", _) => ply(path)?,
        (b"PK\x03\x04", _) => sog::is_archive(path).then_some(Format::Sog),
        (b"glTF", _) => gltf::is_gaussians(path)?.then_some(Format::Gltf),
        ([0x1f, 0x8b, ..], _) => gzip(path, &context).then_some(Format::Spz),
        (_, "gltf") => gltf::is_gaussians(path)?.then_some(Format::Gltf),
        (_, "splat") if length > 0 => Some(Format::Splat),
        (_, "ksplat") => Some(Format::Ksplat),
        _ => None,
    };
    Ok(format)
}

/// Why nothing reads the file.
pub(super) fn unknown(path: &Path) -> IoError {
    Context::new("Gaussians", path).unsupported(format!(
        "neither the contents nor the extension \"{}\" belong to a known format (.ply with f_dc_0, scale_0, rot_0 and \
         opacity, compressed .ply, .splat, .ksplat, .spz, .sog, .gltf or .glb with KHR_gaussian_splatting)",
        extension(path)
    ))
}

fn ply(path: &Path) -> Result<Option<Format>, IoError> {
    let header = Header::read(&mut Source::open(path)?, &Context::new("PLY header", path))?;
    if compressed_ply::is_compressed(&header) {
        return Ok(Some(Format::CompressedPly));
    }
    Ok(inria_ply::is_trained(&header).then_some(Format::InriaPly))
}

/// Whether this is SPZ, or claims to be and has a corrupt stream: the SPZ reader then reports the error.
fn gzip(path: &Path, context: &Context<'_>) -> bool {
    let mut start = [0; 4];
    let Ok(source) = Source::open(path) else {
        return false;
    };
    match source.inflate(Codec::Gzip).fill(&mut start, context) {
        Ok(4) => start == *SPZ_MAGIC,
        _ => extension(path) == "spz",
    }
}
