//! Chunks that were read last, kept in memory.

use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::region::copy_box;
use super::{ChunkBuffer, ChunkContent, ChunkSource, LevelLayout, Reservation, SourceError, SourceIdentity};
use crate::{Samples, VoxelBox};

/// Level and number of a chunk.
type Key = (usize, [usize; 3]);

/// Bytes that a kept chunk takes beside its samples.
const OVERHEAD: u64 = 256;

/// A source that keeps the chunks read last, within a reservation.
#[derive(Debug)]
pub struct CachedSource {
    source: Arc<dyn ChunkSource>,
    memory: Reservation,
    kept: Mutex<Kept>,
}

/// Chunks, and the order in which they were used.
#[derive(Debug, Default)]
struct Kept {
    chunks: HashMap<Key, (Chunk, u64)>,
    by_use: BTreeMap<u64, Key>,
    uses: u64,
    bytes: u64,
}

#[derive(Debug, Clone)]
enum Chunk {
    Samples(Arc<Samples>),
    Constant(f64),
}

impl Chunk {
    fn bytes(&self) -> u64 {
        match self {
            Self::Samples(samples) => (samples.len() * samples.bytes_per_sample()) as u64 + OVERHEAD,
            Self::Constant(_) => OVERHEAD,
        }
    }
}

impl Kept {
    fn get(&mut self, key: Key) -> Option<Chunk> {
        let (chunk, used) = self.chunks.get_mut(&key)?;
        self.by_use.remove(used);
        self.uses += 1;
        *used = self.uses;
        self.by_use.insert(self.uses, key);
        Some(chunk.clone())
    }

    fn insert(&mut self, key: Key, chunk: Chunk, limit: u64) {
        let bytes = chunk.bytes();
        if bytes > limit || self.chunks.contains_key(&key) {
            return;
        }
        while self.bytes + bytes > limit {
            let Some((_, oldest)) = self.by_use.pop_first() else {
                return;
            };
            if let Some((chunk, _)) = self.chunks.remove(&oldest) {
                self.bytes -= chunk.bytes();
            }
        }
        self.uses += 1;
        self.bytes += bytes;
        self.by_use.insert(self.uses, key);
        self.chunks.insert(key, (chunk, self.uses));
    }
}

impl CachedSource {
    /// Keeps as many chunks of `source` as fit `memory`.
    pub fn new(source: Arc<dyn ChunkSource>, memory: Reservation) -> Self {
        Self {
            source,
            memory,
            kept: Mutex::default(),
        }
    }

    fn kept(&self) -> MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn chunk(&self, key: Key, buffer: &mut ChunkBuffer) -> Result<Chunk, SourceError> {
        if let Some(chunk) = self.kept().get(key) {
            return Ok(chunk);
        }
        let chunk = match self.source.read(key.0, key.1, buffer)? {
            ChunkContent::Constant(value) => Chunk::Constant(value),
            ChunkContent::Samples => {
                let empty = buffer.samples.element_type().filled(0, 0.0);
                Chunk::Samples(Arc::new(std::mem::replace(&mut buffer.samples, empty)))
            }
        };
        self.kept().insert(key, chunk.clone(), self.memory.bytes());
        Ok(chunk)
    }
}

impl ChunkSource for CachedSource {
    fn levels(&self) -> &[LevelLayout] {
        self.source.levels()
    }

    fn read(
        &self,
        level: usize,
        chunk: [usize; 3],
        into: &mut ChunkBuffer,
    ) -> Result<ChunkContent, SourceError> {
        Ok(match self.chunk((level, chunk), into)? {
            Chunk::Constant(value) => ChunkContent::Constant(value),
            Chunk::Samples(samples) => {
                into.samples.clone_from(&samples);
                ChunkContent::Samples
            }
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
        into.refill(layout.element, region.len(), layout.fill);
        for chunk in layout.chunks_of(region) {
            let samples = match self.chunk((level, chunk), buffer)? {
                Chunk::Constant(value) if value.to_bits() == layout.fill.to_bits() => continue,
                Chunk::Constant(value) => Arc::new(layout.element.filled(layout.region(chunk).len(), value)),
                Chunk::Samples(samples) => samples,
            };
            copy_box(&samples, layout.region(chunk), into, region);
        }
        Ok(())
    }

    fn bounds(&self, level: usize, chunk: [usize; 3]) -> Option<[f64; 2]> {
        self.source.bounds(level, chunk)
    }

    fn will_need(&self, chunks: &[(usize, [usize; 3])]) {
        self.source.will_need(chunks);
    }

    fn identity(&self) -> SourceIdentity {
        self.source.identity()
    }
}
