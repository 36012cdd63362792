//! Data of an item in memory: read from its file, or held by the program that asks.
//!
//! A program that shows the same data again and again, a notebook or a viewer, holds them: they are read once, and
//! renderers recognise what they have derived from them. Arrays that never were files are held as well.

use std::sync::{Arc, Mutex, PoisonError};

use splatvol_io::{Data, DataKind, Description, LoadedData, Opened};
use splatvol_samples::Sample;
use splatvol_scene::{Content, Gaussians, Mesh, Points, Volume};

use crate::input::{self, ChunkRules, Reading};
use crate::keys::ItemKeys;
use crate::keys::names::UpAxis;
use crate::{DocumentError, chunked, files, items, meaning, upright};

/// Data of an item, and what is known about them. Clones share them.
#[derive(Debug, Clone)]
pub struct Held(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    content: HeldContent,
    kind: DataKind,
    description: Description,
    sample: Option<Sample>,
    /// The volume as it was turned last, so that renderers meet the same one again.
    turned: Mutex<Option<(UpAxis, Arc<Volume>)>>,
}

/// The data.
#[derive(Debug, Clone)]
pub enum HeldContent {
    /// Samples on a regular grid.
    Volume(Arc<Volume>),
    /// Samples on an irregular grid.
    Mesh(Arc<Mesh>),
    /// Samples of surfaces.
    Points(Arc<Points>),
    /// 3-D Gaussians.
    Gaussians(Arc<Gaussians>),
}

impl HeldContent {
    /// Its kind: what a file of such data has, unless it is read in another way.
    fn kind(&self) -> DataKind {
        match self {
            Self::Volume(_) => DataKind::Volume,
            Self::Mesh(_) => DataKind::Mesh,
            Self::Points(_) => DataKind::Points,
            Self::Gaussians(_) => DataKind::Gaussians,
        }
    }
}

impl From<Data> for HeldContent {
    fn from(data: Data) -> Self {
        match data {
            Data::Volume(volume) => Self::Volume(Arc::new(volume.into_shared())),
            Data::Points(points) => Self::Points(Arc::new(points)),
            Data::Gaussians(gaussians) => Self::Gaussians(Arc::new(gaussians)),
            Data::Mesh(mesh) => Self::Mesh(Arc::new(mesh)),
        }
    }
}

impl From<&Content> for HeldContent {
    fn from(content: &Content) -> Self {
        match content {
            Content::Volume { volume, .. } => Self::Volume(Arc::clone(volume)),
            Content::Mesh { mesh, .. } => Self::Mesh(Arc::clone(mesh)),
            Content::Points { points, .. } => Self::Points(Arc::clone(points)),
            Content::Gaussians(gaussians) => Self::Gaussians(Arc::clone(gaussians)),
        }
    }
}

impl Held {
    /// Data as a reader, or a program, has them.
    pub fn new(data: Data, description: Description) -> Self {
        Self::sharing(data.into(), description)
    }

    /// Reads or generates the data of an item, as they are stored.
    ///
    /// # Errors
    /// Files that cannot be read, samples that do not exist, keys that have no meaning for data of that kind.
    pub fn read(keys: &ItemKeys, reading: Reading<'_>) -> Result<Self, DocumentError> {
        // If the file cannot be recognised, the reader of volumes reports the error in its own words.
        let (kind, path) = match items::kind(keys, reading) {
            Err(DocumentError::Input { .. }) => (DataKind::Volume, reading.locate(&keys.file)),
            known => known?,
        };
        meaning::check(keys, kind)?;
        if kind == DataKind::Volume {
            return Ok(input::load(keys, reading)?.into());
        }
        let loaded = {
            let _busy = reading.listener.reading(&keys.file);
            let mut options = items::options(keys, reading.rules)?;
            options.kind = Some(kind);
            options.drape = options.drape.map(|drape| reading.locate(drape));
            options.read.solution = options.read.solution.map(|solution| reading.locate(solution));
            files::read_data(&path, &options).map_err(input::refused)?
        };
        for warning in &loaded.description.warnings {
            reading.listener.warn(&format!("{}: {warning}", keys.file));
        }
        let LoadedData {
            data, description, ..
        } = loaded;
        Ok(Self::of_kind(kind, data.into(), description))
    }

    /// A volume whose chunks are read when they are drawn, within some memory; an overview of it is read here.
    ///
    /// # Errors
    /// Chunks that cannot be read, memory that is too small for the overview, missing samples, which are drawn from memory
    /// alone.
    pub fn in_chunks(opened: Opened, rules: ChunkRules) -> Result<Self, DocumentError> {
        let input = chunked::of_source(opened, rules)?;
        match input.volume.statistics().non_finite {
            0 => Ok(input.into()),
            missing => Err(DocumentError::usage(format!(
                "{missing} samples of the overview are missing (NaN), and such volumes are read whole"
            ))),
        }
    }

    /// Data that others have, too.
    pub fn sharing(content: HeldContent, description: Description) -> Self {
        Self::of_kind(content.kind(), content, description)
    }

    fn of_kind(kind: DataKind, content: HeldContent, description: Description) -> Self {
        Self(Arc::new(Inner {
            content,
            kind,
            description,
            sample: None,
            turned: Mutex::default(),
        }))
    }

    /// The data.
    pub fn content(&self) -> &HeldContent {
        &self.0.content
    }

    /// Their kind.
    pub fn kind(&self) -> DataKind {
        self.0.kind
    }

    /// A description of their file, or anything else that is known about them.
    pub fn description(&self) -> &Description {
        &self.0.description
    }

    /// The built-in sample, if they are one.
    pub fn sample(&self) -> Option<Sample> {
        self.0.sample
    }

    /// The volume turned so that this axis becomes z. Its samples are not copied.
    pub(crate) fn turned(&self, volume: &Arc<Volume>, axis: UpAxis) -> Result<Arc<Volume>, DocumentError> {
        let mut last = self.0.turned.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, turned)) = last.as_ref().filter(|(of, _)| *of == axis) {
            return Ok(Arc::clone(turned));
        }
        let mut turned = Volume::clone(volume);
        turned.transform(upright::rotation(axis))?;
        let turned = Arc::new(turned);
        *last = Some((axis, Arc::clone(&turned)));
        Ok(turned)
    }
}

impl From<input::Input> for Held {
    fn from(input: input::Input) -> Self {
        let volume = Arc::unwrap_or_clone(input.volume).into_shared();
        Self(Arc::new(Inner {
            content: HeldContent::Volume(Arc::new(volume)),
            kind: DataKind::Volume,
            description: input.description,
            sample: input.sample,
            turned: Mutex::default(),
        }))
    }
}
