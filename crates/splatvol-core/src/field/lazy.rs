//! Fields of volumes that are read in chunks: nothing is read or solved before a picture opens a brick.
//!
//! | when | is done | and kept |
//! |---|---|---|
//! | the transfer function is set | an index is asked whether anything in chunks and their bricks, or around them, can be visible | 24 bytes per chunk that may be |
//! | a picture is planned | bricks of these that the wanted pixels can show ([`FieldStore::restrict`]) | 8 bytes per brick |
//! | a brick is opened | its chunk's visible cells, needed voxels and coefficients, from the samples | the chunks used last |
//!
//! A picture opens bricks front to back, and none that finished pixels hide: their chunks are never read. A chunk solved
//! here has the bits of one that is solved in memory, as both are functions of the samples around it, of the kernel and
//! of the transfer function. Bricks without needed voxels are part of the plan here; they decode to nothing.
//! Only interpolating coefficients of volumes without missing samples: visibility of the others depends on bricks further
//! away.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use splatvol_scene::{ChunkedVolume, OverBudget, Recent, Samples, VoxelBox};

use super::around::BrickRanges;
use super::cells::CellBits;
use super::chunk::{CHUNK, Scratch, StoredBrick};
use super::reader::Reader;
use super::{AROUND, Block, Chunk, FieldStore, Surroundings, place};
use crate::brick::BRICK;
use crate::visibility::{BRICK_VOXELS, LEVELS, VisibleLevels, level_of};

/// Lattice points around a chunk from which the needs of its voxels are found: a brick of cells, and their last points.
const MARGIN: usize = BRICK + 1;
/// Points around a voxel of which none can be visible where no reconstruction needs the voxel ([`super::Needs`]).
const NEAR: usize = 3;

/// Chunks that were solved last, and what may be solved.
#[derive(Debug)]
pub(super) struct Lazy {
    solved: Recent<u32, Arc<Chunk>>,
    /// Chunks that may hold needed voxels, ascending.
    candidates: Vec<Candidate>,
    /// Memory of threads that solve.
    scratch: Mutex<Vec<(Scratch, Option<Samples>)>>,
    /// Bricks solved since the last call.
    work: AtomicUsize,
}

/// A chunk that may hold needed voxels, and which of its bricks may.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    chunk: u32,
    bricks: [u64; 2],
}

impl Candidate {
    /// Places of the bricks, ascending.
    fn places(&self) -> impl Iterator<Item = u32> + use<> {
        let [low, high] = self.bricks;
        set_bits(low).chain(set_bits(high).map(|at| at + u64::BITS))
    }
}

fn set_bits(mut bits: u64) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let at = (bits != 0).then(|| bits.trailing_zeros());
        bits &= bits.wrapping_sub(1);
        at
    })
}

impl Clone for Lazy {
    /// Without what was solved; it shares the budget.
    fn clone(&self) -> Self {
        Self {
            solved: self.solved.emptied(),
            candidates: self.candidates.clone(),
            scratch: Mutex::default(),
            work: AtomicUsize::new(0),
        }
    }
}

impl Lazy {
    /// Nothing solved yet, within the budget of a volume.
    pub(super) fn new(volume: &ChunkedVolume) -> Option<Self> {
        Some(Self {
            solved: Recent::new(volume.budget().try_reserve(0)?),
            candidates: Vec::new(),
            scratch: Mutex::default(),
            work: AtomicUsize::new(0),
        })
    }

    pub(super) fn bytes(&self) -> usize {
        self.solved.bytes() as usize
    }
}

impl FieldStore {
    /// Whether bricks are solved when they are opened.
    pub fn is_lazy(&self) -> bool {
        self.lazy.is_some()
    }

    /// Keeps so many bytes of solved chunks from now on, where bricks are solved when they are opened.
    ///
    /// # Errors
    /// More than the volume's budget has left.
    pub fn keep(&self, bytes: u64) -> Result<(), OverBudget> {
        self.lazy
            .as_ref()
            .map_or(Ok(()), |lazy| lazy.solved.resize(bytes))
    }

    /// Keeps at most so many bytes of what was solved, and no room for more; the bytes that are kept.
    pub(crate) fn keep_at_most(&self, bytes: u64) -> u64 {
        let Some(lazy) = &self.lazy else { return 0 };
        let kept = bytes.min(lazy.solved.bytes());
        // No more than is held already.
        let _ = lazy.solved.resize(kept);
        kept
    }

    /// Bricks solved by decoding since the last call.
    pub fn take_solved(&self) -> usize {
        self.lazy
            .as_ref()
            .map_or(0, |lazy| lazy.work.swap(0, Ordering::Relaxed))
    }

    /// The largest number of bricks that a picture may have to plan: those of chunks that may hold something visible.
    pub fn candidates(&self) -> usize {
        let lazy = self.lazy.as_ref();
        lazy.map_or(self.needed.len(), |lazy| match self.levels {
            Some(_) => {
                let bricks = |of: &Candidate| of.bricks.map(u64::count_ones);
                lazy.candidates.iter().flat_map(bricks).sum::<u32>() as usize
            }
            // Voxels that are classified are found when a picture is planned.
            None => self.bricks.iter().product(),
        })
    }

    /// Where bricks are solved when they are opened, leaves those that a picture needs, given their first lattice
    /// points.
    pub fn restrict(&mut self, keep: &(dyn Fn([u32; 3]) -> bool + Sync)) {
        use rayon::prelude::*;

        let Some(lazy) = &self.lazy else { return };
        let bricks = |candidate: &Candidate| {
            let wanted = |at: &u32| keep(self.brick_at(candidate.chunk, *at).map(|b| (b * BRICK) as u32));
            let own = candidate.places().filter(wanted);
            own.map(|at| [candidate.chunk, at]).collect::<Vec<_>>()
        };
        let kept: Vec<Vec<[u32; 2]>> = lazy.candidates.par_iter().map(bricks).collect();
        self.needed = kept.concat();
    }

    /// Finds the chunks that may hold needed voxels; all their bricks are needed until [`FieldStore::restrict`].
    pub(super) fn find_candidates(&mut self) {
        let Some(levels) = &self.levels else { return };
        let found = self.chunks_with(levels, NEAR);
        self.voxels = 0;
        self.needed.clear();
        self.set_hole(self.background);
        if let Some(lazy) = &mut self.lazy {
            lazy.solved.clear();
            lazy.candidates = found;
        }
    }

    /// Lost chunks have a normalised value, that of the background, which is invisible.
    fn set_hole(&self, background: f32) {
        let [low, high] = self.source.value_range();
        self.source.set_hole(low + f64::from(background) * (high - low));
    }

    /// Replaces `bricks` by those of chunks that may hold a visible sample, ascending.
    pub(super) fn candidate_bricks(&self, levels: &VisibleLevels, bricks: &mut Vec<u32>) {
        let [nx, ny, _] = self.bricks;
        self.set_hole(self.histogram.background(levels));
        for candidate in self.chunks_with(levels, 1) {
            let number = |at| {
                let [x, y, z] = self.brick_at(candidate.chunk, at);
                ((z * ny + y) * nx + x) as u32
            };
            bricks.extend(candidate.places().map(number));
        }
        bricks.sort_unstable();
    }

    /// Chunks with bricks of which a sample, or one within so many points around them, may be visible as far as an
    /// index tells.
    fn chunks_with(&self, levels: &VisibleLevels, margin: usize) -> Vec<Candidate> {
        use rayon::prelude::*;

        let counts: [usize; 3] = std::array::from_fn(|a| self.bricks[a].div_ceil(CHUNK[a]));
        let (source, level) = self.source.of();
        let index = source.chunks().and_then(|chunks| chunks.index(level));
        let may_show = |region: VoxelBox| {
            let ends = index.as_ref().and_then(|index| index.within(region));
            ends.is_none_or(|[low, high]| {
                let [a, b] = [low, high].map(|end| level_of(self.lattice.normalised(f64::from(end))));
                let (low, high) = (a.min(b), a.max(b));
                // A level more: the ends were rounded by another way here.
                let [low, high] =
                    super::cells::widened([(low - 1).max(0), (high + 1).min(LEVELS as i16 - 1)]);
                levels.any_of([low, high])
            })
        };
        let candidate = |chunk: u32| {
            let around = self.region_around(self.chunk_first(chunk as usize), CHUNK, margin);
            let mut bricks = [0; 2];
            if may_show(around) {
                for at in 0..CHUNK.iter().product::<usize>() {
                    let brick = self.brick_at(chunk, at as u32);
                    if (0..3).all(|a| brick[a] < self.bricks[a])
                        && may_show(self.region_around(brick, [1; 3], margin))
                    {
                        bricks[at / 64] |= 1u64 << (at % 64);
                    }
                }
            }
            (bricks != [0; 2]).then_some(Candidate { chunk, bricks })
        };
        let count = counts.iter().product::<usize>() as u32;
        (0..count).into_par_iter().filter_map(candidate).collect()
    }

    /// Number along each axis of the brick at a place of a chunk.
    fn brick_at(&self, chunk: u32, at: u32) -> [usize; 3] {
        let (first, offset) = (self.chunk_first(chunk as usize), place(at as usize));
        std::array::from_fn(|a| first[a] + offset[a])
    }

    /// Samples of a box of bricks, and so many points around it.
    fn region_around(&self, first: [usize; 3], bricks: [usize; 3], margin: usize) -> VoxelBox {
        let from = first.map(|brick| (brick * BRICK).saturating_sub(margin));
        let to = std::array::from_fn(|a| (first[a] + bricks[a]) * BRICK + margin);
        self.lattice.region(from, to)
    }

    pub(super) fn decode_lazily(&self, index: usize, out: &mut [f32; BRICK_VOXELS]) {
        self.solve_brick(index, |solved| match solved {
            Some((stored, mask)) => stored.decode(mask, self.background, out),
            None => out.fill(f32::NAN),
        });
    }

    /// Solves the chunk of a brick, unless it is at hand, and takes the brick from it, with its needed voxels; `None` if it
    /// has none, and after a failure.
    pub(super) fn solve_brick<R>(
        &self,
        index: usize,
        take: impl FnOnce(Option<(&StoredBrick, &CellBits)>) -> R,
    ) -> R {
        let [chunk, at] = self.needed[index];
        let solved = self.lazy.as_ref().and_then(|lazy| {
            let make = || {
                let chunk = Arc::new(self.solve_lazily(lazy, chunk as usize).ok_or(())?);
                let bytes = chunk.bytes() as u64;
                Ok::<_, ()>((chunk, bytes))
            };
            lazy.solved.get_or_make(chunk, make).ok()
        });
        take(solved.as_ref().and_then(|chunk| {
            let found = chunk.needed.binary_search_by_key(&at, |brick| brick.place).ok()?;
            Some((chunk.stored(at), &chunk.needed[found].mask))
        }))
    }

    /// Reads and solves a chunk; `None` after a failure.
    fn solve_lazily(&self, lazy: &Lazy, index: usize) -> Option<Chunk> {
        let pool = || lazy.scratch.lock().unwrap_or_else(PoisonError::into_inner);
        let (mut scratch, memory) = pool().pop().unwrap_or_default();
        self.failure.get().is_none().then_some(())?;
        let mut reader = Reader::with_memory(&self.source, &self.failure, memory);
        let first = self.chunk_first(index);
        let origin = first.map(|brick| brick * BRICK);
        let around = self.region_around(first, CHUNK, MARGIN);
        reader.hold(joined(self.solver.region(&self.lattice, origin), around))?;
        let mut chunk = Chunk::default();
        with_block!(reader, around, data => {
            let found = self.needs_within(data, first);
            if !found.is_empty() {
                let solved = self.solver.solve(&self.lattice, data, origin, &mut scratch);
                for (at, _) in &found {
                    let from = (place(*at as usize).map(|brick| brick * BRICK), origin);
                    chunk.stored.push(solved.brick(&scratch, &self.lattice, data, from));
                    chunk.held |= 1 << at;
                }
                lazy.work.fetch_add(found.len(), Ordering::Relaxed);
                self.mask(first, found, &mut chunk);
            }
        })?;
        chunk.needed.shrink_to_fit();
        chunk.stored.shrink_to_fit();
        pool().push((scratch, reader.into_memory()));
        Some(chunk)
    }

    /// Bricks of a chunk with voxels that are needed, and these, from the samples in and around it.
    fn needs_within<T: super::StoredSample>(
        &self,
        data: &Block<'_, T>,
        first: [usize; 3],
    ) -> Vec<(u32, super::Needs)> {
        let Some(levels) = &self.levels else {
            return Vec::new();
        };
        let intervals = levels.intervals();
        let mut cells: Vec<CellBits> = vec![[0; BRICK]; AROUND.iter().product()];
        // Places around the chunk begin one brick before it; those outside wrap, and are left out.
        let number = |brick: [usize; 3]| {
            let [x, y, z]: [usize; 3] = std::array::from_fn(|a| (brick[a] + 1).wrapping_sub(first[a]));
            (z * AROUND[1] + y) * AROUND[0] + x
        };
        for (at, cells) in cells.iter_mut().enumerate() {
            let place = [
                at % AROUND[0],
                at / AROUND[0] % AROUND[1],
                at / (AROUND[0] * AROUND[1]),
            ];
            let brick: [usize; 3] = std::array::from_fn(|a| (first[a] + place[a]).wrapping_sub(1));
            if (0..3).all(|a| brick[a] < self.bricks[a]) {
                let origin = brick.map(|brick| brick * BRICK);
                *cells = BrickRanges::visible_within((&self.lattice, data), origin, (levels, &intervals));
            }
        }
        let around = Surroundings::new(self.bricks, first, |brick| (&cells[number(brick)], false));
        let mut found = Vec::new();
        for at in 0..u128::BITS {
            let offset = place(at as usize);
            if (0..3).any(|a| first[a] + offset[a] >= self.bricks[a]) {
                continue;
            }
            if let Some(needs) = self.needs(around.of(offset).map(|(cells, _)| cells)) {
                found.push((at, needs));
            }
        }
        found
    }
}

/// The smallest box that holds two.
fn joined(a: VoxelBox, b: VoxelBox) -> VoxelBox {
    let first: [usize; 3] = std::array::from_fn(|axis| a.first[axis].min(b.first[axis]));
    let end = |of: VoxelBox, axis: usize| of.first[axis] + of.size[axis];
    VoxelBox {
        first,
        size: std::array::from_fn(|axis| end(a, axis).max(end(b, axis)) - first[axis]),
    }
}
