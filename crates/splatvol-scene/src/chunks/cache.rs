//! Chunks that were read last, kept in memory.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use super::MinMaxIndex;
use super::recent::Recent;
use super::region::copy_box;
use super::{
    ChunkBuffer, ChunkContent, ChunkSource, LevelLayout, OverBudget, Reservation, SourceError, SourceIdentity,
};
use crate::{Samples, VoxelBox};

/// Level and number of a chunk.
type Key = (usize, [usize; 3]);

/// Chunks of a region that are announced together.
const AHEAD: usize = 32;

/// Bytes that a kept chunk takes beside its samples.
const OVERHEAD: u64 = 256;

/// A source that keeps the chunks read last, within a reservation, and counts what it reads.
#[derive(Debug)]
pub struct CachedSource {
    source: Arc<dyn ChunkSource>,
    kept: Recent<Key, Chunk>,
    /// Whether lost chunks are holes, not errors.
    holes: bool,
    /// Bits of the stored value that fills holes.
    hole: AtomicU64,
    counts: Mutex<Counts>,
}

/// What was read.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ChunkCounts {
    /// Chunks read, each as often as it was.
    pub reads: u64,
    /// Their bytes, as they are stored.
    pub bytes: u64,
    /// Different chunks that were read.
    pub chunks: u64,
    /// Times that the one which was read most often was.
    pub most: u64,
    /// Lost chunks that were taken for holes.
    pub holes: u64,
}

/// Counts, and how often each chunk of the levels was read.
#[derive(Debug, Default)]
struct Counts {
    sums: ChunkCounts,
    reads: Vec<Vec<u16>>,
}

#[derive(Debug, Clone)]
enum Chunk {
    Samples(Arc<Samples>),
    Constant(f64),
    Hole,
}

impl Chunk {
    fn bytes(&self) -> u64 {
        match self {
            Self::Samples(samples) => (samples.len() * samples.bytes_per_sample()) as u64 + OVERHEAD,
            Self::Constant(_) | Self::Hole => OVERHEAD,
        }
    }
}

impl CachedSource {
    /// Keeps as many chunks of `source` as fit `memory`.
    pub fn new(source: Arc<dyn ChunkSource>, memory: Reservation) -> Self {
        Self {
            hole: AtomicU64::new(source.levels()[0].fill.to_bits()),
            source,
            kept: Recent::new(memory),
            holes: false,
            counts: Mutex::default(),
        }
    }

    /// With lost chunks as holes, which have one value: the fill, until another is set.
    #[must_use]
    pub fn with_holes(self) -> Self {
        Self { holes: true, ..self }
    }

    /// Keeps so many bytes of chunks from now on.
    ///
    /// # Errors
    /// More than the budget has left.
    pub fn resize(&self, bytes: u64) -> Result<(), OverBudget> {
        self.kept.resize(bytes)
    }

    /// Bytes of the chunks in memory.
    pub fn kept_bytes(&self) -> u64 {
        self.kept.bytes()
    }

    /// What was read since the last call.
    pub fn take_counts(&self) -> ChunkCounts {
        let mut counts = self.counts.lock().unwrap_or_else(PoisonError::into_inner);
        counts.reads.clear();
        std::mem::take(&mut counts.sums)
    }

    fn count(&self, (level, chunk): Key, bytes: usize, is_hole: bool) {
        let mut counts = self.counts.lock().unwrap_or_else(PoisonError::into_inner);
        let Counts { sums, reads } = &mut *counts;
        let [nx, ny, nz] = self.levels()[level].counts();
        if reads.len() <= level {
            reads.resize_with(level + 1, Vec::new);
        }
        reads[level].resize(nx * ny * nz, 0);
        let own = &mut reads[level][(chunk[2] * ny + chunk[1]) * nx + chunk[0]];
        sums.chunks += u64::from(*own == 0);
        *own = own.saturating_add(1);
        sums.most = sums.most.max(u64::from(*own));
        sums.reads += 1;
        sums.bytes += bytes as u64;
        sums.holes += u64::from(is_hole);
    }

    fn read_chunk(&self, key: Key, buffer: &mut ChunkBuffer) -> Result<Chunk, SourceError> {
        buffer.coded.clear();
        let chunk = match self.source.read(key.0, key.1, buffer) {
            Ok(ChunkContent::Constant(value)) => Chunk::Constant(value),
            Ok(ChunkContent::Samples) => {
                let empty = buffer.samples.element_type().filled(0, 0.0);
                Chunk::Samples(Arc::new(std::mem::replace(&mut buffer.samples, empty)))
            }
            Err(SourceError::Missing(_)) if self.holes => Chunk::Hole,
            Err(error) => return Err(error),
        };
        self.count(key, buffer.coded.len(), matches!(chunk, Chunk::Hole));
        Ok(chunk)
    }

    /// Says which of these chunks will be read, where there are several.
    fn fetch_ahead(&self, keys: impl Iterator<Item = Key>) {
        let missing: Vec<Key> = keys.filter(|key| !self.kept.has(key)).collect();
        if missing.len() > 1 {
            self.source.will_need(&missing);
        }
    }

    fn chunk(&self, key: Key, buffer: &mut ChunkBuffer) -> Result<Chunk, SourceError> {
        let (chunk, freed) = self.kept.get_or_replace(key, || {
            let chunk = self.read_chunk(key, buffer)?;
            let bytes = chunk.bytes();
            Ok((chunk, bytes))
        })?;
        // The next chunk is read into the memory of one that had to go.
        if let Some(Chunk::Samples(samples)) = freed {
            buffer.samples =
                Arc::try_unwrap(samples).unwrap_or_else(|_| buffer.samples.element_type().filled(0, 0.0));
        }
        Ok(match chunk {
            Chunk::Hole => Chunk::Constant(f64::from_bits(self.hole.load(Ordering::Relaxed))),
            other => other,
        })
    }
}

impl ChunkSource for CachedSource {
    fn levels(&self) -> &[LevelLayout] {
        self.source.levels()
    }

    fn is_of_labels(&self) -> bool {
        self.source.is_of_labels()
    }

    fn read(
        &self,
        level: usize,
        chunk: [usize; 3],
        into: &mut ChunkBuffer,
    ) -> Result<ChunkContent, SourceError> {
        Ok(match self.chunk((level, chunk), into)? {
            Chunk::Samples(samples) => {
                into.samples.clone_from(&samples);
                ChunkContent::Samples
            }
            Chunk::Constant(value) => ChunkContent::Constant(value),
            Chunk::Hole => ChunkContent::Constant(self.levels()[level].fill),
        })
    }

    fn read_region(
        &self,
        level: usize,
        region: VoxelBox,
        into: &mut Samples,
        buffer: &mut ChunkBuffer,
    ) -> Result<(), SourceError> {
        let layout = &self.levels()[level];
        if self.reads_regions() && region.size[0] == layout.grid.dims()[0] {
            // Whole rows cost no more than their samples, and their chunks are not worth keeping.
            return self.source.read_region(level, region, into, buffer);
        }
        into.refill(layout.element, region.len(), layout.fill);
        for (number, chunk) in layout.chunks_of(region).enumerate() {
            if number % AHEAD == 0 {
                let next = layout.chunks_of(region).skip(number).take(AHEAD);
                self.fetch_ahead(next.map(|chunk| (level, chunk)));
            }
            let samples = match self.chunk((level, chunk), buffer)? {
                Chunk::Samples(samples) => samples,
                Chunk::Constant(value) if value.to_bits() != layout.fill.to_bits() => {
                    Arc::new(layout.element.filled(layout.region(chunk).len(), value))
                }
                Chunk::Constant(_) | Chunk::Hole => continue,
            };
            copy_box(&samples, layout.region(chunk), into, region);
        }
        Ok(())
    }

    fn reads_regions(&self) -> bool {
        self.source.reads_regions()
    }

    fn index(&self, level: usize) -> Option<Arc<MinMaxIndex>> {
        self.source.index(level)
    }

    fn spread(&self, level: usize) -> Option<Vec<f64>> {
        self.source.spread(level)
    }

    fn will_need(&self, chunks: &[(usize, [usize; 3])]) {
        self.source.will_need(chunks);
    }

    fn set_hole(&self, stored: f64) -> bool {
        let changes = self.hole.swap(stored.to_bits(), Ordering::Relaxed) != stored.to_bits();
        let made_anew = self.source.set_hole(stored);
        if made_anew {
            self.kept.clear();
        }
        made_anew || self.holes && changes
    }

    fn identity(&self) -> SourceIdentity {
        self.source.identity()
    }
}
