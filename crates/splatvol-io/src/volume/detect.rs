//! Detection of a file's format: by its first bytes, else by its extension.

use std::cmp::Ordering;
use std::fmt::{self, Display, Formatter};
use std::path::{Path, PathBuf};

use super::{dicom, slc, slices, zarr};
use crate::error::Context;
use crate::files;
use crate::source::{Codec, Source, check_inside};
use crate::{IoError, remote};

/// Bytes examined; a NIfTI-1 header ends with its magic number here.
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
    Dicom,
    Tiff,
    Slices,
    Mgh,
    Slc,
    Zarr,
    Raw,
}

impl Display for Format {
    /// Its name, for people.
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Nrrd => "NRRD",
            Self::MetaImage => "MetaImage",
            Self::Nifti => "NIfTI",
            Self::Vti => "VTI",
            Self::LegacyVtk => "legacy VTK",
            Self::Npy => "NPY",
            Self::Npz => "NPZ",
            Self::Dicom => "DICOM",
            Self::Tiff => "TIFF",
            Self::Slices => "a folder of slices",
            Self::Mgh => "MGH",
            Self::Slc => "SLC",
            Self::Zarr => "OME-Zarr",
            Self::Raw => "raw",
        })
    }
}

/// Lower-case extension, with `.nii.gz` and `.raw.gz` as one; empty if there is none.
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
    if remote::address(path).is_some() {
        // Servers list nothing, and have folders of keys only.
        return Ok(Format::Zarr);
    }
    if files::is_dir(path) {
        return folder_format(path, &context);
    }
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
        "mgh" | "mgz" => Ok(Format::Mgh),
        "slc" => Ok(Format::Slc),
        "tif" | "tiff" => Ok(Format::Tiff),
        "dcm" | "dicom" | "ima" => Ok(Format::Dicom),
        "raw" | "raw.gz" | "bin" => Ok(Format::Raw),
        _ if looks_like_metaimage(&start) => Ok(Format::MetaImage),
        "png" | "jpg" | "jpeg" => Err(context.unsupported(format!(
            "a single picture (.{extension}) is no volume; name a folder of such files, which are its slices"
        ))),
        _ => Err(context.unsupported(format!(
            "neither the first bytes nor the extension \"{extension}\" belong to a known format \
             (NRRD, MetaImage, NIfTI, VTI, legacy VTK, NPY, NPZ, DICOM, TIFF, OME-Zarr, MGH, SLC; raw needs its layout)"
        ))),
    }
}

/// The format of a folder's contents.
fn folder_format(folder: &Path, context: &Context<'_>) -> Result<Format, IoError> {
    if zarr::is_zarr(folder) {
        return Ok(Format::Zarr);
    }
    // The reader decides about links.
    let context_of_names = Context {
        allow_outside: true,
        ..*context
    };
    let files = files_of(folder, &context_of_names)?;
    if files.iter().any(|file| dicom::is_dicom(file)) {
        return Ok(Format::Dicom);
    }
    if files.iter().any(|file| slices::is_slice(file)) {
        return Ok(Format::Slices);
    }
    let inside = counted(files.len(), "file");
    let what = match folders_of(folder) {
        0 => format!("a folder of {inside}"),
        count => format!(
            "a folder of {inside} and {}, which are not looked into,",
            counted(count, "folder")
        ),
    };
    Err(context.unsupported(format!(
        "{what} none of which belongs to a known format (DICOM; OME-Zarr; TIFF, PNG or JPEG slices)"
    )))
}

/// `1 file`, `2 files`.
fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// The number of folders in a folder.
fn folders_of(folder: &Path) -> usize {
    let entries = files::read_dir(folder).into_iter().flatten().flatten();
    entries.filter(|entry| files::is_dir(&entry.path())).count()
}

/// The regular files of a folder, in natural order: `I9` before `I10`.
///
/// # Errors
/// A folder that cannot be read; links that lead out of it, unless the context allows them.
pub(super) fn files_of(folder: &Path, context: &Context<'_>) -> Result<Vec<PathBuf>, IoError> {
    let open = |source| IoError::Open {
        source,
        path: folder.to_owned(),
    };
    let mut files = Vec::new();
    for entry in files::read_dir(folder).map_err(open)? {
        let path = entry.map_err(open)?.path();
        if files::is_file(&path) {
            if files::is_symlink(&path) {
                check_inside(&path, folder, context)?;
            }
            files.push(path);
        }
    }
    files.sort_by(|a, b| natural_order(&a.to_string_lossy(), &b.to_string_lossy()));
    Ok(files)
}

/// Compares names with their numbers taken as numbers; names that differ only in leading zeros by their text.
pub(super) fn natural_order(a: &str, b: &str) -> Ordering {
    let (mut rest_a, mut rest_b) = (a, b);
    while let (Some(first_a), Some(first_b)) = (rest_a.chars().next(), rest_b.chars().next()) {
        let order = if first_a.is_ascii_digit() && first_b.is_ascii_digit() {
            let (number_a, number_b) = (take_digits(&mut rest_a), take_digits(&mut rest_b));
            number_a.len().cmp(&number_b.len()).then(number_a.cmp(number_b))
        } else {
            rest_a = &rest_a[first_a.len_utf8()..];
            rest_b = &rest_b[first_b.len_utf8()..];
            first_a.cmp(&first_b)
        };
        if order != Ordering::Equal {
            return order;
        }
    }
    rest_a.len().cmp(&rest_b.len()).then(a.cmp(b))
}

/// Removes and returns the digits at the start of `rest`, without leading zeros.
fn take_digits<'a>(rest: &mut &'a str) -> &'a str {
    let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
    let (digits, after) = rest.split_at(end);
    *rest = after;
    digits.trim_start_matches('0')
}

/// The decompressed start, or nothing if the stream is corrupt: the format's own reader then reports it.
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
    if dicom::says_dicm(start) {
        Some(Format::Dicom)
    } else if start.starts_with(b"NRRD00") {
        Some(Format::Nrrd)
    } else if start.starts_with(b"# vtk DataFile") {
        Some(Format::LegacyVtk)
    } else if start.starts_with(b"\x93NUMPY") {
        Some(Format::Npy)
    } else if start.starts_with(b"PK\x03\x04") {
        Some(Format::Npz)
    } else if nifti_1 || nifti_2 {
        Some(Format::Nifti)
    } else if [&b"II*\0"[..], b"MM\0*", b"II+\0\x08\0\0\0", b"MM\0+\0\x08\0\0"]
        .iter()
        .any(|magic| start.starts_with(magic))
    {
        Some(Format::Tiff)
    } else if start.starts_with(slc::MAGIC) && start.get(5).is_some_and(u8::is_ascii_whitespace) {
        Some(Format::Slc)
    } else if dicom::starts_dicom(start) {
        Some(Format::Dicom)
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
    fn numbers_in_names_are_numbers() {
        let mut names = ["I10", "I9", "I1", "I010", "a2b10", "a2b9", "I", "I9x"];
        names.sort_by(|a, b| natural_order(a, b));
        assert_eq!(names, ["I", "I1", "I9", "I9x", "I010", "I10", "a2b9", "a2b10"]);
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

    #[test]
    fn the_preamble_of_dicom_may_be_the_header_of_a_tiff() {
        let mut start = [0; 140];
        start[..4].copy_from_slice(b"II*\0");
        assert_eq!(by_magic(&start), Some(Format::Tiff));
        start[128..132].copy_from_slice(b"DICM");
        assert_eq!(by_magic(&start), Some(Format::Dicom));
    }
}
