//! Which format a file has: by its first bytes, else by its extension.

use std::path::Path;

use crate::IoError;
use crate::error::Context;
use crate::source::{Codec, Source};

/// Bytes looked at; a NIfTI-1 header ends with its magic number here.
const PROBE: usize = 348;

/// The readable formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    Nrrd,
    MetaImage,
    Nifti,
    Vti,
    LegacyVtk,
    Npy,
    Npz,
    Raw,
}

/// Lower-case extension, with `.nii.gz` and `.raw.gz` as one; empty where there is none.
pub(super) fn extension(path: &Path) -> String {
    let name = path
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .to_ascii_lowercase();
    for compressed in ["nii.gz", "raw.gz"] {
        if name
            .strip_suffix(compressed)
            .is_some_and(|stem| stem.ends_with('.'))
        {
            return compressed.to_owned();
        }
    }
    name.rsplit_once('.')
        .map_or_else(String::new, |(_, extension)| extension.to_owned())
}

/// The format of the file at `path`.
pub(super) fn format(path: &Path) -> Result<Format, IoError> {
    let context = Context::new("volume", path);
    let mut source = Source::open(path)?;
    let mut start = vec![0; PROBE];
    let length = source.fill(&mut start, &context)?;
    start.truncate(length);
    if start.starts_with(&[0x1f, 0x8b]) {
        start = inflated_start(path, &context)?;
    }
    if let Some(format) = by_magic(&start) {
        return Ok(format);
    }
    let extension = extension(path);
    match extension.as_str() {
        "nrrd" | "nhdr" => Ok(Format::Nrrd),
        "mhd" | "mha" => Ok(Format::MetaImage),
        "nii" | "nii.gz" | "hdr" | "img" => Ok(Format::Nifti),
        "vti" => Ok(Format::Vti),
        "vtk" => Ok(Format::LegacyVtk),
        "npy" => Ok(Format::Npy),
        "npz" => Ok(Format::Npz),
        "raw" | "raw.gz" | "bin" => Ok(Format::Raw),
        _ if looks_like_metaimage(&start) => Ok(Format::MetaImage),
        _ => Err(context.unsupported(format!(
            "neither the first bytes nor the extension \"{extension}\" belong to a known format \
             (NRRD, MetaImage, NIfTI, VTI, legacy VTK, NPY, NPZ; raw needs its layout)"
        ))),
    }
}

/// The decompressed start, or nothing where the stream is corrupt: the format's own reader then says so.
fn inflated_start(path: &Path, context: &Context<'_>) -> Result<Vec<u8>, IoError> {
    let mut start = vec![0; PROBE];
    let length = Source::open(path)?
        .inflate(Codec::Gzip)
        .fill(&mut start, context)
        .unwrap_or(0);
    start.truncate(length);
    Ok(start)
}

fn by_magic(start: &[u8]) -> Option<Format> {
    let text = start.trim_ascii_start();
    let nifti_size =
        |size: u32| start.starts_with(&size.to_le_bytes()) || start.starts_with(&size.to_be_bytes());
    let nifti_1 = nifti_size(348) && matches!(start.get(344..348), Some(b"n+1\0" | b"ni1\0"));
    let nifti_2 = nifti_size(540) && matches!(start.get(4..8), Some(b"n+2\0" | b"ni2\0"));
    if start.starts_with(b"NRRD00") {
        Some(Format::Nrrd)
    } else if start.starts_with(b"# vtk DataFile") {
        Some(Format::LegacyVtk)
    } else if start.starts_with(b"\x93NUMPY") {
        Some(Format::Npy)
    } else if start.starts_with(b"PK\x03\x04") {
        Some(Format::Npz)
    } else if nifti_1 || nifti_2 {
        Some(Format::Nifti)
    } else if text.starts_with(b"<VTKFile") || (text.starts_with(b"<?xml") && contains(text, b"<VTKFile")) {
        Some(Format::Vti)
    } else {
        None
    }
}

fn looks_like_metaimage(start: &[u8]) -> bool {
    let text = start.trim_ascii_start();
    [&b"ObjectType"[..], b"NDims"]
        .iter()
        .any(|key| text.starts_with(key))
        && contains(text, b"=")
}

fn contains(text: &[u8], part: &[u8]) -> bool {
    text.windows(part.len()).any(|window| window == part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extensions_are_lower_case_and_nii_gz_is_one() {
        assert_eq!(extension(Path::new("/a.b/C.NII.GZ")), "nii.gz");
        assert_eq!(extension(Path::new("/a.b/c.d.Nrrd")), "nrrd");
        assert_eq!(extension(Path::new("/a.b/c")), "");
    }

    #[test]
    fn magic_needs_its_place() {
        assert_eq!(by_magic(b"NRRD0004\n"), Some(Format::Nrrd));
        assert_eq!(
            by_magic(b"<?xml version=\"1.0\"?>\n<VTKFile type="),
            Some(Format::Vti)
        );
        assert_eq!(by_magic(&348u32.to_le_bytes()), None);
        assert_eq!(by_magic(b""), None);
    }
}
