//! Writes OME-Zarr with levels of detail, in bounded memory, from any source of chunks.
//!
//! Work goes to a folder beside the output, `NAME.partial`, which becomes the output when all is complete:
//!
//! | in it | what |
//! |---|---|
//! | `store` | the image so far |
//! | `done/LEVEL/TASK` | bounds of the chunks of a task, and samples for histograms; that it exists says that the task is done |
//! | `state.json` | what is being written; work is taken up again only for the same |
//!
//! Every file is written under another name and renamed, so that a killed process leaves nothing that is half written,
//! and its files are those of a process that was not killed. Bytes do not depend on threads, memory or time.

mod bounds;
mod chunks;
mod files;
mod halve;
mod metadata;
mod plan;
mod work;

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::{Map, json};
use splatvol_scene::{Budget, CachedSource, ChunkBuffer, ChunkContent, ChunkSource, LengthUnit, LevelLayout};
use splatvol_scene::{Rescale, Reservation, SourceError, SourceIdentity};

use super::array::Array;
use super::folder::Folder;
use super::is_zarr;
use super::level::{ArrayLevel, Part};
use super::own;
use crate::IoError;
use crate::error::Context;
use crate::volume::Opened;
use bounds::Done;
use plan::Plan;
use work::{LevelWork, Progress};

/// Ending of the folder beside the output in which it is made.
const PARTIAL: &str = ".partial";

/// Version of OME-Zarr.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum OmeVersion {
    /// 0.4: Zarr 2, a file per chunk, no checksums.
    V04,
    /// 0.5: Zarr 3, shards, checksums.
    #[default]
    V05,
}

/// Compression of chunks.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Compression {
    /// None.
    None,
    /// Blosc: LZ4 of shuffled bits. The fastest.
    #[default]
    Lz4,
    /// Blosc: zlib of shuffled bits. Smaller, and much slower.
    Zlib,
}

impl Compression {
    fn blosc_name(self) -> Option<&'static str> {
        match self {
            Self::None => None,
            Self::Lz4 => Some("lz4"),
            Self::Zlib => Some("zlib"),
        }
    }
}

/// How levels of detail are written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PyramidOptions {
    /// Version of OME-Zarr.
    pub version: OmeVersion,
    /// Compression of chunks.
    pub compression: Compression,
    /// Edge of a chunk, samples; from 8 to 512.
    pub chunk: usize,
    /// Number of levels, the finest included; if absent, until the coarsest is one chunk.
    pub levels: Option<usize>,
    /// Whether values are labels: samples of the next level are those that most of their box have, not means.
    pub labels: bool,
    /// Bytes that all buffers together may take.
    pub memory: u64,
    /// Threads; fewer work where there is no memory for all.
    pub threads: usize,
    /// Replace an image that is there already, and start again where another one is half written.
    pub overwrite: bool,
}

impl PyramidOptions {
    /// Edges of chunks.
    pub const CHUNK: std::ops::RangeInclusive<usize> = 8..=512;
}

impl Default for PyramidOptions {
    fn default() -> Self {
        Self {
            version: OmeVersion::default(),
            compression: Compression::default(),
            chunk: 64,
            levels: None,
            labels: false,
            memory: crate::memory::granted() / 2,
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            overwrite: false,
        }
    }
}

/// Result of writing an image.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pyramid {
    /// Samples along x, y, z of every level.
    pub levels: Vec<[usize; 3]>,
    /// Whether work of an earlier process was taken up.
    pub resumed: bool,
    /// Losses for other programs.
    pub warnings: Vec<String>,
}

/// Writes the finest level of a source, and means of it as further levels, as OME-Zarr; of labels those that most samples have. The folder appears when it is
/// complete; where an earlier process was stopped, its work is continued. `progress` is told the finished share.
///
/// # Errors
/// Samples that cannot be read, files that cannot be written, [`IoError::Limit`] where the memory is not enough for one
/// thread, an output that exists, or one that is half written from other data.
pub fn write_pyramid(
    volume: &Opened,
    path: impl AsRef<Path>,
    options: &PyramidOptions,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Pyramid, IoError> {
    let writer = Writer::new(volume, path.as_ref(), options)?;
    let resumed = writer.begin()?;
    let lock = writer.lock()?;
    let written = writer.run(&Progress::new(progress, &writer.plan));
    if written.is_err() && !writer.done().exists() {
        // There is nothing that could be continued.
        drop(lock);
        files::remove(&writer.partial)?;
    }
    written?;
    Ok(Pyramid {
        levels: writer.plan.levels.iter().map(|level| level.dims).collect(),
        resumed,
        warnings: writer.warnings(),
    })
}

struct Writer<'a> {
    volume: &'a Opened,
    path: &'a Path,
    partial: PathBuf,
    options: &'a PyramidOptions,
    plan: Plan,
}

impl<'a> Writer<'a> {
    fn new(volume: &'a Opened, path: &'a Path, options: &'a PyramidOptions) -> Result<Self, IoError> {
        let context = &Context::new("OME-Zarr output", path);
        if !PyramidOptions::CHUNK.contains(&options.chunk) {
            return Err(context.field("chunk", options.chunk, None, "8 to 512 samples"));
        }
        let plan = Plan::new(finest(volume).grid.dims(), options.chunk, options.levels);
        if plan.levels.is_empty() || plan.levels.len() > 32 {
            return Err(context.field("levels", plan.levels.len(), None, "1 to 32"));
        }
        let mut partial = path.as_os_str().to_owned();
        partial.push(PARTIAL);
        Ok(Self {
            volume,
            path,
            partial: partial.into(),
            options,
            plan,
        })
    }

    fn store(&self) -> PathBuf {
        self.partial.join("store")
    }

    fn done(&self) -> PathBuf {
        self.partial.join("done")
    }

    fn state_file(&self) -> PathBuf {
        self.partial.join("state.json")
    }

    /// All that the bytes written depend on.
    fn state(&self) -> String {
        let SourceIdentity { name, state } = self.volume.source.identity();
        let layout = finest(self.volume);
        let map = layout.grid.world_from_voxel().to_cols_array();
        let state = json!({
            "program": concat!("splatvol ", env!("CARGO_PKG_VERSION")),
            "source": name,
            "source-state": state,
            "dims": layout.grid.dims(),
            "type": layout.element.name(),
            "place": map,
            "rescale": [layout.rescale.slope, layout.rescale.intercept],
            "unit": format!("{:?}", self.volume.unit),
            "version": format!("{:?}", self.options.version),
            "compression": format!("{:?}", self.options.compression),
            "chunk": self.options.chunk,
            "levels": self.plan.levels.len(),
            "labels": self.options.labels,
        });
        format!("{state:#}\n")
    }

    /// Makes or finds the folder of the work; true where it holds some.
    fn begin(&self) -> Result<bool, IoError> {
        let context = Context::new("OME-Zarr output", self.path);
        if self.path.exists() {
            if !self.options.overwrite {
                return Err(context.unsupported("the output exists already"));
            }
            // Nothing is removed that is not an image.
            if !is_zarr(self.path) {
                return Err(context.unsupported("what is to be overwritten is no Zarr folder"));
            }
        }
        match fs::read_to_string(self.state_file()) {
            Err(_) if !self.partial.exists() => {}
            found if self.options.overwrite => {
                // Not under the hands of a process that is writing it.
                let _lock = found.is_ok().then(|| self.lock()).transpose()?;
                files::remove(&self.partial)?;
            }
            Ok(found) if found == self.state() => return Ok(true),
            _ => {
                let what = "work on other data, or with other settings, was begun here; remove the folder, or overwrite it";
                return Err(Context::new("OME-Zarr output", &self.partial).unsupported(what));
            }
        }
        files::write(&self.state_file(), self.state().as_bytes())?;
        Ok(false)
    }

    /// Does all that is not done.
    fn run(&self, progress: &Progress<'_>) -> Result<(), IoError> {
        for level in 0..self.plan.levels.len() {
            self.level(level, progress)?;
        }
        self.finish()
    }

    /// Keeps other processes away.
    fn lock(&self) -> Result<File, IoError> {
        let path = self.state_file();
        let file = File::open(&path).map_err(files::at(&path))?;
        match file.try_lock() {
            Err(fs::TryLockError::WouldBlock) => {
                let context = Context::new("OME-Zarr output", &self.partial);
                Err(context.unsupported("another process is writing it"))
            }
            // Some file systems know no locks.
            _ => Ok(file),
        }
    }

    /// Writes the next level, bounds of this one and, if it is the first, the level itself.
    fn level(&self, level: usize, progress: &Progress<'_>) -> Result<(), IoError> {
        let store = self.store();
        let element = finest(self.volume).element;
        for next in (level..self.plan.levels.len()).take(2) {
            let sizes = metadata::slowest_first(&self.plan.levels[next]);
            let array = metadata::level_array(&sizes, element, self.options);
            array.write(&store.join(next.to_string()), self.options)?;
        }
        let own: Arc<dyn ChunkSource> = match level {
            0 => Arc::clone(&self.volume.source),
            _ => Arc::new(Written::open(&store, level, finest(self.volume))?),
        };
        let (source, threads, _memory) = self.within_budget(own)?;
        let work = LevelWork {
            source: (&*source, 0),
            plan: &self.plan,
            level,
            folder: &store,
            done: Done::new(&self.done(), level),
            copy: level == 0,
            options: self.options,
            progress,
        };
        work.run(threads)?;
        let index = store.join(own::BOUNDS).join(level.to_string());
        bounds::write_index(&index, (&self.plan, level), &work.done, element, self.options)?;
        let spread = store.join(own::SPREAD).join(level.to_string());
        bounds::write_spread(&spread, (&self.plan, level), &work.done, element, self.options)
    }

    /// The source with a cache, the number of threads, and the memory of these.
    fn within_budget(
        &self,
        source: Arc<dyn ChunkSource>,
    ) -> Result<(Arc<dyn ChunkSource>, usize, Reservation), IoError> {
        let layout = &source.levels()[0];
        let chunk =
            layout.chunk.iter().map(|&edge| edge as u64).product::<u64>() * layout.element.size() as u64;
        let one = self.plan.bytes_of_thread(layout.element, chunk);
        let budget = Budget::new(self.options.memory);
        let threads = (self.options.memory / one).clamp(1, self.options.threads.max(1) as u64);
        let limit = |wanted| Context::new("OME-Zarr output", self.path).limit(wanted, self.options.memory);
        let memory = budget.reserve(one * threads).map_err(|over| limit(over.wanted))?;
        if source.reads_regions() {
            return Ok((source, threads as usize, memory));
        }
        let rest = self.options.memory - memory.bytes();
        let cache = budget
            .reserve(rest - rest / 8)
            .map_err(|over| limit(over.wanted))?;
        Ok((
            Arc::new(CachedSource::new(source, cache)),
            threads as usize,
            memory,
        ))
    }

    /// Writes the metadata of the image, and gives it its name.
    fn finish(&self) -> Result<(), IoError> {
        let store = self.store();
        let version = self.options.version;
        for group in [own::BOUNDS, own::SPREAD] {
            let mut folder = store.clone();
            for part in Path::new(group) {
                folder.push(part);
                metadata::write_group(&folder, Map::new(), version)?;
            }
        }
        let of_volume = (self.volume.unit, self.volume.description.oriented);
        let attributes = metadata::image(finest(self.volume), of_volume, &self.plan, self.options);
        metadata::write_group(&store, attributes, version)?;
        if self.path.exists() {
            let old = self.partial.join("old");
            fs::rename(self.path, &old).map_err(files::at(self.path))?;
        }
        fs::rename(&store, self.path).map_err(files::at(self.path))?;
        files::remove(&self.partial)
    }

    /// Facts of the volume that other programs do not find.
    fn warnings(&self) -> Vec<String> {
        let layout = finest(self.volume);
        let mut warnings = Vec::new();
        if layout.rescale != Rescale::default() {
            let Rescale { slope, intercept } = layout.rescale;
            warnings.push(format!(
                "OME-Zarr has no place for real values, {slope} * stored + {intercept}: other programs show stored ones"
            ));
        }
        if !metadata::is_plain(layout.grid.world_from_voxel()) {
            let warning =
                "OME-Zarr has no place for directions of axes: other programs show spacing and origin alone";
            warnings.push(warning.to_owned());
        }
        if self.volume.unit == LengthUnit::Unknown && layout.grid.spacing() != glam::DVec3::ONE {
            warnings.push("the unit of lengths is not known, and none is written".to_owned());
        }
        warnings
    }
}

fn finest(volume: &Opened) -> &LevelLayout {
    &volume.source.levels()[0]
}

/// A level that has been written, as the source of the next.
#[derive(Debug)]
struct Written {
    level: ArrayLevel,
    number: usize,
    layouts: [LevelLayout; 1],
    folder: PathBuf,
}

impl Written {
    fn open(store: &Path, number: usize, finest: &LevelLayout) -> Result<Self, IoError> {
        let folder = store.join(number.to_string());
        let context = &Context::new("Zarr array", &folder);
        let array = Array::open(&Folder::on_disk(&folder))?.ok_or_else(|| context.unsupported("no array"))?;
        let part = Part {
            place: vec![0; 3],
            spatial: vec![0, 1, 2],
        };
        let dims = part.volume(&array.shape);
        let layout = LevelLayout {
            grid: splatvol_scene::Grid::centred(dims, glam::DVec3::ONE)
                .map_err(|error| context.scene(error))?,
            ..finest.clone()
        };
        let level = ArrayLevel::new(array, part, layout, false);
        Ok(Self {
            layouts: [level.layout.clone()],
            level,
            number,
            folder,
        })
    }
}

impl ChunkSource for Written {
    fn levels(&self) -> &[LevelLayout] {
        &self.layouts
    }

    fn read(&self, _: usize, chunk: [usize; 3], into: &mut ChunkBuffer) -> Result<ChunkContent, SourceError> {
        self.level
            .read(chunk, into)
            .map_err(|failure| failure.at(self.number, chunk))
    }

    fn identity(&self) -> SourceIdentity {
        SourceIdentity {
            name: self.folder.display().to_string(),
            state: String::new(),
        }
    }
}
