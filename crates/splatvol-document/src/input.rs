//! A volume to be shown: a file or a built-in sample.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;
use splatvol_io::{Description, Endian, IoError, RawLayout, ReadOptions};
use splatvol_samples::Sample;
use splatvol_scene::{Mesh, Volume};

use crate::keys::ItemKeys;
use crate::{DocumentError, Listener, chunked, files, spelling};

/// A volume, and what is known about it.
pub struct Input {
    /// Its samples.
    pub volume: Arc<Volume>,
    /// Its file.
    pub description: Description,
    /// Which sample it is, if it is one.
    pub sample: Option<Sample>,
    /// The mesh whose values the samples are, if there is one.
    pub mesh: Option<Arc<Mesh>>,
}

/// What is refused when files are read.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ReadRules {
    /// Whether warnings are errors.
    pub strict: bool,
    /// Whether links are followed that lead out of the folder of the file that is read, and whether a picture's record
    /// may name files elsewhere.
    pub allow_outside: bool,
    /// Most bytes that an item's samples may take; if absent, half of the memory that the machine or container grants.
    pub max_bytes: Option<u64>,
    /// How volumes are read that need not be in memory; if absent, all are read whole.
    pub chunks: Option<ChunkRules>,
}

/// How volumes are read in chunks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ChunkRules {
    /// Bytes that all volumes in chunks may take together, and what is derived from them.
    pub memory: u64,
    /// Whether lost chunks are holes, not errors.
    pub holes: bool,
    /// Whether volumes are read whole whose samples that memory has room for, since pictures of them are faster.
    pub whole_if_it_fits: bool,
}

impl ChunkRules {
    /// Bytes that a program takes beside volumes and their picture.
    pub const PROGRAM: u64 = 24 << 20;
}

/// Where and how files are read.
#[derive(Clone, Copy)]
pub struct Reading<'a> {
    /// What is refused.
    pub rules: ReadRules,
    /// Folder in which relative paths are tried next.
    pub folder: Option<&'a Path>,
    /// Listener to warnings and choices.
    pub listener: &'a dyn Listener,
}

impl Reading<'_> {
    /// The path, or, if it does not exist but a path in the folder does, that one.
    pub fn locate(&self, path: impl AsRef<Path>) -> PathBuf {
        locate(path.as_ref(), self.folder)
    }
}

/// The path, or, if it does not exist but a path in the folder does, that one.
pub(crate) fn locate(path: &Path, folder: Option<&Path>) -> PathBuf {
    let there = folder.map(|folder| folder.join(path));
    match there.filter(|there| there.exists()) {
        Some(there) if !path.exists() => there,
        _ => path.to_owned(),
    }
}

/// Reads or generates a volume as it is stored, with its file's axes.
///
/// # Errors
/// Files that cannot be read, samples that do not exist.
pub fn load(item: &ItemKeys, reading: Reading<'_>) -> Result<Input, DocumentError> {
    let _busy = reading.listener.reading(&item.file);
    if let Some(name) = item.file.strip_prefix("sample:") {
        return generate(name);
    }
    let path = reading.locate(&item.file);
    if let Some(input) = chunked::open(item, &path, reading)? {
        return Ok(input);
    }
    let loaded = files::read_volume(&path, &options(item, reading.rules)?);
    let loaded = loaded.map_err(|error| hinting(refused(error), item, &path))?;
    for warning in &loaded.description.warnings {
        reading.listener.warn(&format!("{}: {warning}", item.file));
    }
    Ok(Input {
        volume: Arc::new(loaded.volume),
        description: loaded.description,
        sample: None,
        mesh: None,
    })
}

/// An error of a reader, with a hint where a rule can be changed.
pub(crate) fn refused(error: IoError) -> DocumentError {
    let hint = match error {
        IoError::Outside { .. } => Some("--allow-outside follows such links"),
        IoError::Limit { .. } => Some(
            "--max-memory sets the limit, by default half of the machine's; \
             volumes of any size are drawn from OME-Zarr, which `splatvol convert` writes",
        ),
        _ => None,
    };
    let error = DocumentError::from(error);
    match hint {
        Some(hint) => error.hinting(hint),
        None => error,
    }
}

fn hinting(error: DocumentError, item: &ItemKeys, path: &Path) -> DocumentError {
    let is_sample = Sample::ALL.iter().any(|sample| sample.name() == item.file);
    if !path.exists() && is_sample {
        error.hinting(format!("built-in volumes are written sample:{}", item.file))
    } else if path.extension().is_some_and(|ext| ext == "raw" || ext == "bin") && item.dims.is_none() {
        error.hinting("files without a header need --dims and --type")
    } else {
        error
    }
}

/// Generates `NAME` or `NAME:SIZE`.
fn generate(text: &str) -> Result<Input, DocumentError> {
    let (name, size) = match text.split_once(':') {
        Some((name, size)) => (name, Some(size)),
        None => (text, None),
    };
    let size = size
        .map(spelling::sample_size)
        .transpose()
        .map_err(|expected| DocumentError::usage(format!("sample:{text}: {expected}")))?;
    let sample = Sample::from_name(name)?;
    let volume = sample.generate(size)?;
    let description = Description {
        format: "built-in sample".to_owned(),
        stored_type: volume.samples().type_name().to_owned(),
        orientation: match sample {
            Sample::Head => "RAS+ by construction".to_owned(),
            _ => "none: world axes are the grid's".to_owned(),
        },
        oriented: true,
        ..Description::default()
    };
    Ok(Input {
        volume: Arc::new(volume),
        description,
        sample: Some(sample),
        mesh: None,
    })
}

/// Options for the readers of volumes.
///
/// # Errors
/// Keys that do not make a layout, by name.
pub fn options(item: &ItemKeys, rules: ReadRules) -> Result<ReadOptions, DocumentError> {
    let automatic = ReadOptions::default();
    Ok(ReadOptions {
        raw: layout(item)?,
        array: item.array.clone(),
        component: item.component,
        time: item.time,
        channel: item.channel,
        level: item.level.unwrap_or(0),
        series: item.series.clone(),
        solution: item.solution.as_ref().map(PathBuf::from),
        strict: rules.strict,
        allow_outside: rules.allow_outside,
        max_bytes: rules.max_bytes.unwrap_or(automatic.max_bytes),
        unpack_in: None,
    })
}

/// Layout of a headerless file.
fn layout(item: &ItemKeys) -> Result<Option<RawLayout>, DocumentError> {
    let refused = |key: &str, why: String| {
        DocumentError::refused(&format!("item.{key}"), format!(": {why}")).of_item(&item.file)
    };
    let endian = item.endian.as_deref().map(spelling::endian).transpose();
    let endian = endian.map_err(|why| refused("endian", why))?;
    let sample_type = item.sample_type.as_deref().map(spelling::sample_type).transpose();
    let sample_type = sample_type.map_err(|why| refused("type", why))?;
    match (item.dims, sample_type) {
        (Some(dims), Some(sample_type)) => Ok(Some(RawLayout {
            dims,
            sample_type,
            spacing: DVec3::from_array(item.spacing.unwrap_or([1.0; 3])),
            endian: endian.unwrap_or(Endian::Little),
            offset: item.offset.unwrap_or(0),
        })),
        (None, None) => Ok(None),
        (Some(_), None) => Err(refused("dims", "needs type too".to_owned())),
        (None, Some(_)) => Err(refused("type", "needs dims too".to_owned())),
    }
}
