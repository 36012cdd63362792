//! Flat files: samples as they are, x fastest, in one file. Regions are read at their positions, row by row or, where they
//! are as wide as the volume, slice by slice, so that no file is too large.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::UNIX_EPOCH;

use splatvol_scene::{
    ChunkBuffer, ChunkContent, ChunkFault, ChunkSource, ElementType, LevelLayout, Samples, SourceError,
    SourceIdentity, VoxelBox,
};

use super::planes;
use super::vtk_array::{Component, pick};
use super::{Description, Draft, Opened};
use crate::error::Context;
use crate::files::{self, File, read_at};
use crate::samples::{sample_bytes_mut, swap_bytes_of, widen_samples};
use crate::{Endian, IoError, SampleType};

/// Samples of a chunk: few rows, since each takes a read of its own. Regions of any other size are read as well.
const CHUNK: [usize; 3] = [256, 32, 32];

/// Warning about 64-bit integers.
pub(super) const ROUNDED: &str = "64-bit integers become 64-bit floats: those beyond 2^53 are rounded";

/// Whether a file's 64-bit integers may be rounded.
pub(super) fn may_round(description: &Description) -> bool {
    description.warnings.iter().any(|warning| warning == ROUNDED)
}

/// Numbers that lie at each sample, and the one that is read.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tuple {
    pub(super) components: usize,
    pub(super) component: Component,
}

impl Tuple {
    /// One number.
    pub(super) const ONE: Self = Self {
        components: 1,
        component: Component::Index(0),
    };

    /// One of so many.
    pub(super) fn of(components: usize, component: usize) -> Self {
        Self {
            components,
            component: Component::Index(component),
        }
    }
}

/// Place and type of a volume's samples.
#[derive(Debug)]
pub(super) struct Flat {
    pub(super) path: PathBuf,
    /// Byte of the first sample.
    pub(super) position: u64,
    pub(super) sample_type: SampleType,
    /// Whether 16 bits are a float.
    pub(super) half: bool,
    pub(super) tuple: Tuple,
    pub(super) endian: Endian,
}

/// A file whose regions are read when they are asked for.
#[derive(Debug)]
struct FlatSource {
    flat: Flat,
    file: File,
    levels: [LevelLayout; 1],
    identity: SourceIdentity,
}

impl Flat {
    /// The type of the file's numbers in memory.
    fn element(&self) -> ElementType {
        match self.sample_type {
            _ if self.half => ElementType::F32,
            sample_type => sample_type.element(),
        }
    }

    /// The type of what is read of them.
    fn picked(&self) -> ElementType {
        match (self.tuple.component, self.element()) {
            (Component::Index(_), element) => element,
            (Component::Magnitude, ElementType::F64) => ElementType::F64,
            (Component::Magnitude, _) => ElementType::F32,
        }
    }

    /// Whether samples are 64-bit integers, which become floats.
    fn is_rounded(&self) -> bool {
        matches!(self.sample_type, SampleType::U64 | SampleType::I64)
    }

    /// The volume of a header.
    ///
    /// # Errors
    /// Files that cannot be opened, or are too short.
    pub(super) fn open(self, draft: Draft, context: &Context<'_>) -> Result<Opened, IoError> {
        let failed = |source| IoError::Open {
            source,
            path: self.path.clone(),
        };
        let file = File::open(&self.path).map_err(failed)?;
        let length = file.metadata().map_err(failed)?.len();
        let samples = draft.grid(context)?.sample_count();
        let of_one = self.sample_type.byte_count(samples);
        let wanted = of_one.saturating_mul(self.tuple.components as u64);
        let there = length.saturating_sub(self.position);
        if there < wanted {
            return Err(context.truncated("samples", wanted, there));
        }
        self.of_file(file, draft, context)
    }

    /// The same of a file that is long enough, which may be another than that of its path: that one unpacked.
    ///
    /// # Errors
    /// Files that cannot be opened.
    pub(super) fn of_file(
        self,
        file: File,
        mut draft: Draft,
        context: &Context<'_>,
    ) -> Result<Opened, IoError> {
        if self.is_rounded() {
            // How many, only a volume in memory can tell.
            draft.warn(ROUNDED);
        }
        let metadata = files::metadata(&self.path).map_err(|source| IoError::Open {
            source,
            path: self.path.clone(),
        })?;
        let layout = LevelLayout {
            grid: draft.grid(context)?,
            chunk: std::array::from_fn(|axis| draft.dims[axis].min(CHUNK[axis])),
            element: self.picked(),
            rescale: draft.rescale,
            fill: 0.0,
        };
        let changed = metadata
            .modified()
            .ok()
            .and_then(|time| time.duration_since(UNIX_EPOCH).ok());
        let identity = SourceIdentity {
            name: self.path.display().to_string(),
            state: format!("{} bytes, changed at {changed:?}, {self:?}", metadata.len()),
        };
        Ok(Opened {
            unit: draft.unit,
            description: draft.description,
            is_divided: false,
            source: Arc::new(FlatSource {
                flat: self,
                file,
                levels: [layout],
                identity,
            }),
        })
    }
}

impl FlatSource {
    /// Fills the bytes of a region.
    fn fill(&self, region: VoxelBox, bytes: &mut [u8]) -> Result<(), SourceError> {
        let [nx, ny, _] = self.levels[0].grid.dims();
        let [size_x, size_y, size_z] = region.size;
        // Samples that lie one behind the other.
        let run = match (size_x == nx, size_y == ny) {
            (true, true) => size_x * size_y * size_z,
            (true, false) => size_x * size_y,
            (false, _) => size_x,
        };
        let width = self.flat.sample_type.size() * self.flat.tuple.components;
        for (number, bytes) in bytes.chunks_exact_mut(run * width).enumerate() {
            let row = number * run / size_x;
            let [x, y, z] = region.first;
            let (y, z) = (y + row % size_y, z + row / size_y);
            let sample = (z as u64 * ny as u64 + y as u64) * nx as u64 + x as u64;
            let position = self.flat.position + sample * width as u64;
            read_at(&self.file, bytes, position).map_err(|error| self.fault(region, position, &error))?;
        }
        Ok(())
    }

    /// All numbers of a region's samples. `coded`: memory.
    fn read_numbers(
        &self,
        region: VoxelBox,
        into: &mut Samples,
        coded: &mut Vec<u8>,
    ) -> Result<(), SourceError> {
        let Flat {
            sample_type, endian, ..
        } = self.flat;
        let count = region.len() * self.flat.tuple.components;
        into.refill(self.flat.element(), count, 0.0);
        if self.flat.half || self.flat.is_rounded() {
            coded.clear();
            coded.resize(count * sample_type.size(), 0);
            self.fill(region, coded)?;
            widen_samples(coded, sample_type, endian, into);
            return Ok(());
        }
        let bytes = sample_bytes_mut(into);
        self.fill(region, bytes)?;
        if endian != Endian::NATIVE {
            swap_bytes_of(bytes, sample_type.size());
        }
        Ok(())
    }

    fn fault(&self, region: VoxelBox, offset: u64, error: &std::io::Error) -> SourceError {
        let chunk = self.levels[0].chunk;
        let is_short = error.kind() == std::io::ErrorKind::UnexpectedEof;
        let fault = Box::new(ChunkFault {
            level: 0,
            chunk: std::array::from_fn(|axis| region.first[axis] / chunk[axis]),
            key: self.identity.name.clone(),
            codec: None,
            offset,
            reason: match is_short {
                true => "the file ends before; it was longer when it was opened".to_owned(),
                false => error.to_string(),
            },
        });
        match is_short {
            true => SourceError::Corrupt(fault),
            false => SourceError::Transient(fault),
        }
    }
}

impl ChunkSource for FlatSource {
    fn levels(&self) -> &[LevelLayout] {
        &self.levels
    }

    fn read(
        &self,
        level: usize,
        chunk: [usize; 3],
        into: &mut ChunkBuffer,
    ) -> Result<ChunkContent, SourceError> {
        let region = self.levels[level].region(chunk);
        let mut samples = std::mem::replace(&mut into.samples, Samples::U8(Vec::new().into()));
        let read = self.read_region(level, region, &mut samples, into);
        into.samples = samples;
        read.map(|()| ChunkContent::Samples)
    }

    fn read_region(
        &self,
        level: usize,
        region: VoxelBox,
        into: &mut Samples,
        buffer: &mut ChunkBuffer,
    ) -> Result<(), SourceError> {
        let Tuple {
            components,
            component,
        } = self.flat.tuple;
        if (components, component) == (1, Component::Index(0)) {
            return self.read_numbers(region, into, &mut buffer.coded);
        }
        // Slice by slice, so that the numbers that nobody wants take little memory.
        into.refill(self.levels[level].element, 0, 0.0);
        let mut numbers = Samples::U8(Vec::new().into());
        for z in region.first[2]..region.first[2] + region.size[2] {
            let slice = VoxelBox {
                first: [region.first[0], region.first[1], z],
                size: [region.size[0], region.size[1], 1],
            };
            self.read_numbers(slice, &mut numbers, &mut buffer.coded)?;
            let all = std::mem::replace(&mut numbers, Samples::U8(Vec::new().into()));
            let is_same = planes::extend(into, pick(all, components, component));
            debug_assert!(is_same, "{component:?} of {:?}", self.flat);
        }
        Ok(())
    }

    fn reads_regions(&self) -> bool {
        true
    }

    fn identity(&self) -> SourceIdentity {
        self.identity.clone()
    }
}
