//! Volumes: one module per format, and the choice between them.
//!
//! Data are never reordered: flips and permutations of axes are part of `world_from_voxel`, which maps to RAS+
//! wherever the file says how the data lie in the patient.

mod assemble;
mod choices;
mod data_files;
mod detect;
pub mod dicom;
mod fields;
mod flat;
pub mod legacy_vtk;
pub mod metaimage;
pub mod mgh;
pub mod nifti;
pub mod npy;
pub mod nrrd;
mod planes;
pub mod raw;
pub mod slc;
pub mod slices;
mod stack;
mod stored;
pub mod tiff;
#[cfg(not(target_family = "wasm"))]
mod unpack;
pub mod vti;
pub(crate) mod vtk_array;
pub mod zarr;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;
use splatvol_scene::{ChunkSource, LengthUnit, Volume};

pub use assemble::axis_codes;
pub(crate) use assemble::{
    Draft, checked_dims, choose_channel, choose_component, choose_time, complete_axes, length_unit,
    ras_from_lps, read_whole, sample_count,
};

use crate::error::Context;
use crate::key_store::KeyStore;
use crate::{Endian, IoError, SampleType, memory};
use detect::Format;

/// A volume and where it came from.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// The volume.
    pub volume: Volume,
    /// Description of the file.
    pub description: Description,
}

/// A volume that is read chunk by chunk, and where it comes from.
#[derive(Debug, Clone)]
pub struct Opened {
    /// Its samples, at all levels of detail.
    pub source: Arc<dyn ChunkSource>,
    /// Unit of world lengths.
    pub unit: LengthUnit,
    /// Whether it is stored in chunks, so that pictures of parts of it read parts of it.
    pub is_divided: bool,
    /// Description of the file.
    pub description: Description,
}

/// Description of a file, for people.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Description {
    /// Format and version: `NRRD0004`, `NIfTI-1`.
    pub format: String,
    /// Sample type as stored, with byte order and encoding: `i16, big-endian, gzip`.
    pub stored_type: String,
    /// The file's space convention and how it became world space.
    pub orientation: String,
    /// Whether the file orients the volume in the world: by patient axes, or a named space. Otherwise, world axes are
    /// those of the grid, and z need not be up.
    pub oriented: bool,
    /// The file, followed by the data files that its header names.
    pub files: Vec<PathBuf>,
    /// Names of the channels, where there are several to choose from ([`ReadOptions::channel`]).
    pub channels: Vec<String>,
    /// Number of time points to choose from ([`ReadOptions::time`]); 0 where the format knows no time.
    pub times: usize,
    /// Samples along x, y, z of every level of detail, the finest first ([`ReadOptions::level`]); empty where the
    /// format has no levels.
    pub levels: Vec<[usize; 3]>,
    /// Whether the file says that values are labels, those of coarser levels too.
    pub is_labels: bool,
    /// The series of a folder, where there are several to choose from ([`ReadOptions::series`]).
    pub series: Vec<String>,
    /// Oddities that did not prevent reading.
    pub warnings: Vec<String>,
}

/// Options for reading.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadOptions {
    /// Layout of a headerless file; if set, the file is read as raw.
    pub raw: Option<RawLayout>,
    /// Name of the array to read from a file that holds several.
    pub array: Option<String>,
    /// Component to take from vector-valued samples; without it they are refused.
    pub component: Option<usize>,
    /// Time point to read, from 0; if absent, the first one, with a warning if there are others.
    pub time: Option<usize>,
    /// Channel to read, from 0; if absent, the first one, with a warning if there are others.
    pub channel: Option<usize>,
    /// Level of detail to take from multi-scale images; 0 is the finest.
    pub level: usize,
    /// Series to take from a folder that holds several: its number, its UID or its description.
    pub series: Option<String>,
    /// The solution that belongs to a PLOT3D grid; if absent, the file of the matching name.
    pub solution: Option<PathBuf>,
    /// Turn warnings into errors.
    pub strict: bool,
    /// Follow links that lead out of the folder of the file; otherwise they are refused.
    pub allow_outside: bool,
    /// Most bytes that the samples may take in memory; by default half of what the machine or container grants
    /// ([`crate::memory::granted`]).
    pub max_bytes: u64,
    /// Folder in which [`open_volume`] may unpack samples that are compressed, in a file that has no name and goes with the
    /// volume; if absent, such files are not opened.
    pub unpack_in: Option<PathBuf>,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            raw: None,
            array: None,
            component: None,
            time: None,
            channel: None,
            level: 0,
            series: None,
            solution: None,
            strict: false,
            allow_outside: false,
            max_bytes: memory::granted() / 2,
            unpack_in: None,
        }
    }
}

/// Layout of a headerless file. Samples are x fastest.
#[derive(Debug, Clone, PartialEq)]
pub struct RawLayout {
    /// Samples along x, y, z.
    pub dims: [usize; 3],
    /// Type of one sample.
    pub sample_type: SampleType,
    /// World length per voxel, x y z.
    pub spacing: DVec3,
    /// Byte order.
    pub endian: Endian,
    /// Bytes before the first sample.
    pub offset: u64,
}

/// Options for writing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WriteOptions {
    /// Compress the samples if the format can.
    pub compress: bool,
}

impl Default for WriteOptions {
    fn default() -> Self {
        Self { compress: true }
    }
}

/// Whether [`read_volume`] takes the file or folder, by its start or its extension.
///
/// # Errors
/// The errors of [`read_volume`].
pub(crate) fn known(path: &Path) -> Result<(), IoError> {
    detect::format(path).map(drop)
}

/// Reads a volume of any supported format. The first bytes of the file decide; its extension counts only if they do
/// not.
///
/// # Errors
/// See [`IoError`]; with [`ReadOptions::strict`] also where a warning would be given.
pub fn read_volume(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Loaded, IoError> {
    let path = path.as_ref();
    let format = match options.raw {
        Some(_) => Format::Raw,
        None => detect::format(path)?,
    };
    choices::check(format, options, &Context::new("volume", path))?;
    let loaded = match format {
        Format::Nrrd => nrrd::read(path, options),
        Format::MetaImage => metaimage::read(path, options),
        Format::Nifti => nifti::read(path, options),
        Format::Vti => vti::read(path, options),
        Format::LegacyVtk => legacy_vtk::read(path, options),
        Format::Npy => npy::read(path, options),
        Format::Npz => npy::read_npz(path, options),
        Format::Dicom => dicom::read(path, options),
        Format::Mgh => mgh::read(path, options),
        Format::Slc => slc::read(path, options),
        Format::Zarr => zarr::read(path, options),
        Format::Tiff => tiff::read(path, options),
        Format::Slices => slices::read(path, options),
        Format::Raw => raw::read(path, options),
    }?;
    refuse_warnings(&loaded.description, path, options)?;
    Ok(loaded)
}

/// Opens a volume whose samples can be read box by box, OME-Zarr and Zarr, and uncompressed samples in one file (raw, NRRD,
/// MetaImage, NIfTI, NPY, MGH, binary VTK, VTI with raw appended data), or slice by slice: TIFF, DICOM, and folders of pictures.
/// Only metadata are read, whatever their size, and the first slice. Compressed samples of NRRD, MetaImage, NIfTI, MGH, NPZ and VTI,
/// SLC, and numbers as text are unpacked first, where that is allowed ([`ReadOptions::unpack_in`]). `None` for all others.
///
/// # Errors
/// See [`IoError`]; with [`ReadOptions::strict`] also where a warning would be given.
pub fn open_volume(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Option<Opened>, IoError> {
    let path = path.as_ref();
    let format = match options.raw {
        Some(_) => Format::Raw,
        None => detect::format(path)?,
    };
    choices::check(format, options, &Context::new("volume", path))?;
    let opened = match format {
        Format::Zarr => Some(zarr::open(path, options)?),
        Format::Nrrd => nrrd::read(path, options)?,
        Format::MetaImage => metaimage::read(path, options)?,
        Format::Nifti => nifti::read(path, options)?,
        Format::Npy => npy::open(path)?,
        Format::Npz => npy::open_npz(path, options)?,
        Format::Raw => raw::open(path, options)?,
        Format::Tiff => tiff::open(path, options)?,
        Format::Slices => Some(slices::open(path, options)?),
        Format::Dicom => Some(dicom::open(path, options)?),
        Format::Vti => vti::open(path, options)?,
        Format::LegacyVtk => legacy_vtk::open(path, options)?,
        Format::Mgh => mgh::read(path, options)?,
        Format::Slc => slc::open(path, options)?,
    };
    // Only a volume in memory can tell whether an integer was rounded.
    let is_doubtful = |opened: &Opened| options.strict && flat::may_round(&opened.description);
    let Some(opened) = opened.filter(|opened| !is_doubtful(opened)) else {
        return Ok(None);
    };
    refuse_warnings(&opened.description, path, options)?;
    Ok(Some(opened))
}

/// Opens the OME-Zarr image or Zarr array at the root of a store, as [`open_volume`] does.
///
/// # Errors
/// See [`IoError`].
pub fn open_volume_in(store: Arc<dyn KeyStore>, options: &ReadOptions) -> Result<Opened, IoError> {
    let name = PathBuf::from(store.name());
    let opened = zarr::open_store(store, options)?;
    refuse_warnings(&opened.description, &name, options)?;
    Ok(opened)
}

fn refuse_warnings(description: &Description, path: &Path, options: &ReadOptions) -> Result<(), IoError> {
    match options.strict && !description.warnings.is_empty() {
        false => Ok(()),
        true => Err(IoError::Strict {
            warning: description.warnings.join("; "),
            path: path.to_owned(),
        }),
    }
}

/// Writes a volume; the extension chooses the format: `.nrrd`, or `.npy` (samples only).
///
/// # Errors
/// [`IoError::Unsupported`] for other extensions, [`IoError::Write`] where the file cannot be written.
pub fn write_volume(path: impl AsRef<Path>, volume: &Volume, options: &WriteOptions) -> Result<(), IoError> {
    let path = path.as_ref();
    match detect::extension(path).as_str() {
        "nrrd" => nrrd::write(path, volume, options),
        "npy" => npy::write(path, volume),
        other => Err(Context::new("volume output", path).unsupported(format!(
            "no writer for the extension \"{other}\" (.nrrd and .npy have one)"
        ))),
    }
}
