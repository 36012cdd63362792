//! The field of a volume in bricks: coefficients of the voxels that a transfer function needs, and no others.
//!
//! | once per | is done | and kept |
//! |---|---|---|
//! | volume | ranges of samples per brick, a histogram | 4 bytes per brick |
//! | transfer function | visible cells where visible levels changed, needed voxels around what changed | 1 bit per voxel |
//! | brick needed | its chunk's coefficients, from the samples | 2 bytes per voxel |
//!
//! Of a volume that is read in chunks (`lazy`) nothing is read before a picture opens a brick.
//!
//! A store depends only on the volume, the kernel and the last transfer function, to the bit, and not on earlier
//! transfer functions. [`crate::visibility`] defines which voxels are needed.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use rayon::prelude::*;
use splatvol_scene::SceneError;

use crate::brick::BRICK;
use crate::kernel::GaussianKernel;
use crate::visibility::{BRICK_VOXELS, Histogram, VisibleLevels};

/// Runs plain loops, all of them inlined, compiled for the processor's vectors.
macro_rules! vectorized {
    ($level:expr, $work:expr) => {
        fearless_simd::dispatch!($level, simd => fearless_simd::Simd::vectorize(
            simd,
            #[inline(always)]
            || $work,
        ))
    };
}

/// Runs a loop over the samples of a region, for any sample type; does nothing if they cannot be read.
macro_rules! with_block {
    ($reader:expr, $region:expr, $block:ident => $body:expr) => {
        $reader.read($region).map(|block| {
            splatvol_scene::with_samples!(block.samples, data => {
                let $block = &$crate::field::lattice::Block::new(data, block.of);
                $body
            })
        })
    };
}

mod around;
#[cfg(test)]
mod by_cell;
mod cells;
mod chunk;
mod lattice;
mod lazy;
mod level;
mod needs;
mod packed;
mod reader;
#[cfg(test)]
mod regions;
mod samples;
mod survey;
#[cfg(test)]
mod tests;

use around::BrickRanges;
use cells::CellBits;
pub use chunk::PACKED;
use chunk::{CHUNK, ChunkSolver, Scratch, StoredBrick};
use lattice::{Block, Lattice, StoredSample};
use lazy::Lazy;
use level::Failure;
pub use level::SourceLevel;
use needs::Needs;
use reader::Reader;
pub(crate) use reader::spread;
pub use samples::Neighbourhood;
pub use survey::survey;

/// A volume of up to so many bricks (128 MiB) keeps solved bricks that are not needed now for the next transfer
/// function.
const KEEP_ALL: usize = 1 << 17;

/// Bricks that hold needed voxels, and their coefficients.
#[derive(Debug, Clone)]
pub struct FieldStore {
    source: SourceLevel,
    failure: Failure,
    lattice: Lattice,
    solver: ChunkSolver,
    histogram: Histogram,
    /// Bricks along x, y, z.
    bricks: [usize; 3],
    ranges: BrickRanges,
    cells: Vec<CellBits>,
    /// Whether the kernel reaches three voxels, not two.
    is_wide: bool,
    /// Whether bricks that are not needed now stay.
    keep_all: bool,
    /// Visible levels for which the cells were found.
    levels: Option<VisibleLevels>,
    chunks: Vec<Chunk>,
    /// Chunk and place in it of each needed brick.
    needed: Vec<[u32; 2]>,
    background: f32,
    voxels: usize,
    work: FieldWork,
    /// Of a volume in chunks: what is solved when it is opened.
    lazy: Option<Lazy>,
}

/// Bricks on which an update worked; the others were kept as they were.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FieldWork {
    /// Bricks whose samples were searched for visible cells.
    pub searched: usize,
    /// Bricks whose coefficients were computed.
    pub solved: usize,
}

/// State of a chunk.
#[derive(Debug, Clone, Default)]
struct Chunk {
    /// Places of the bricks in `stored`, ascending.
    held: u128,
    stored: Vec<StoredBrick>,
    needed: Vec<NeededBrick>,
}

#[derive(Debug, Clone)]
struct NeededBrick {
    place: u32,
    mask: CellBits,
    voxels: u32,
}

impl FieldStore {
    /// Reads the samples through once, for coefficients that interpolate them; no brick is needed yet.
    pub fn new(source: impl Into<SourceLevel>, kernel: &GaussianKernel) -> Self {
        let source = source.into();
        let lattice = Lattice::new(&source);
        let solver = ChunkSolver::new(kernel, &lattice);
        Self::solved_by(solver, source, (lattice, kernel))
    }

    /// As [`Self::new`], with the samples themselves as coefficients: a field that the kernel smooths.
    pub fn of_samples(source: impl Into<SourceLevel>, kernel: &GaussianKernel) -> Self {
        let source = source.into();
        let lattice = Lattice::new(&source);
        Self::solved_by(ChunkSolver::of_samples(), source, (lattice, kernel))
    }

    fn solved_by(
        solver: ChunkSolver,
        source: SourceLevel,
        (lattice, kernel): (Lattice, &GaussianKernel),
    ) -> Self {
        let bricks = lattice.dims.map(|n| n.div_ceil(BRICK));
        let count = bricks.iter().product();
        let is_wide = kernel.radius > 2.0;
        let bounds = (solver.interpolates(), is_wide);
        let failure = Failure::default();
        let lazy = source.chunks().and_then(Lazy::new);
        let reads = (&lattice, &source, &failure);
        let (ranges, now) = match lazy {
            Some(_) => (BrickRanges::unknown(bounds), 0),
            None => (BrickRanges::new(reads, bricks, bounds), count),
        };
        let chunks: usize = (0..3).map(|a| bricks[a].div_ceil(CHUNK[a])).product();
        Self {
            is_wide,
            solver,
            histogram: reader::histogram(&source, &failure),
            bricks,
            ranges,
            cells: vec![[0; BRICK]; now],
            keep_all: count <= KEEP_ALL,
            levels: None,
            chunks: vec![Chunk::default(); if now > 0 { chunks } else { 0 }],
            lazy,
            needed: Vec::new(),
            background: 0.0,
            voxels: 0,
            work: FieldWork::default(),
            lattice,
            source,
            failure,
        }
    }

    /// Sets another transfer function: finds the needed voxels, and solves for the missing coefficients.
    pub fn update(&mut self, levels: &VisibleLevels) {
        self.update_unless(&AtomicBool::new(false), levels);
    }

    /// As [`Self::update`], cancelled if `stop` is set meanwhile; the store must not be used after that.
    pub fn update_unless(&mut self, stop: &AtomicBool, levels: &VisibleLevels) {
        let background = self.histogram.background(levels);
        let levels = &levels.beyond(background);
        self.work = FieldWork::default();
        let first_time = self.levels.is_none();
        if self.levels.as_ref() == Some(levels) && background == self.background {
            return;
        }
        if self.lazy.is_some() {
            self.background = background;
            self.levels = Some(levels.clone());
            return self.find_candidates();
        }
        let all_again = first_time || background != self.background;
        let changed = self.levels.as_ref().map(|old| old.difference(levels));
        let (touched, searched) = self.find_cells(levels, changed.as_ref());
        let solved = AtomicUsize::new(0);
        let mut chunks = std::mem::take(&mut self.chunks);
        self.background = background;
        self.levels = Some(levels.clone());
        let store = &*self;
        let memory = || (Scratch::default(), store.reader());
        chunks.par_iter_mut().enumerate().with_max_len(4).for_each_init(
            memory,
            |(scratch, reader), (index, chunk)| {
                if stop.load(Ordering::Relaxed) {
                    return;
                }
                let job = ChunkJob {
                    store,
                    touched: &touched,
                    all_again,
                    solved: &solved,
                };
                job.update(index, chunk, (reader, scratch));
            },
        );
        self.chunks = chunks;
        self.work = FieldWork {
            searched,
            solved: solved.into_inner(),
        };
        self.needed.clear();
        self.voxels = 0;
        for (index, chunk) in self.chunks.iter().enumerate() {
            self.needed
                .extend((0..chunk.needed.len()).map(|i| [index as u32, i as u32]));
            self.voxels += chunk
                .needed
                .iter()
                .map(|brick| brick.voxels as usize)
                .sum::<usize>();
        }
    }

    /// Work of the last update.
    pub fn work(&self) -> FieldWork {
        self.work
    }

    /// Number of bricks that hold needed voxels.
    pub fn len(&self) -> usize {
        self.needed.len()
    }

    /// Whether nothing is needed.
    pub fn is_empty(&self) -> bool {
        self.needed.is_empty()
    }

    /// First lattice point of a needed brick.
    #[inline]
    pub fn first(&self, index: usize) -> [u32; 3] {
        let [chunk, i] = self.needed[index].map(|n| n as usize);
        let first = self.chunk_first(chunk);
        let offset = place(match self.lazy {
            Some(_) => i,
            None => self.chunks[chunk].needed[i].place as usize,
        });
        std::array::from_fn(|a| ((first[a] + offset[a]) * BRICK) as u32)
    }

    /// Reads a little of every cache line of a brick. Touching several bricks in a row waits for memory once, and
    /// [`FieldStore::decode`] soon after finds them in the cache.
    #[inline(always)]
    pub fn touch(&self, index: usize) {
        if self.lazy.is_some() {
            return;
        }
        let [chunk, i] = self.needed[index].map(|n| n as usize);
        let chunk = &self.chunks[chunk];
        chunk.stored(chunk.needed[i].place).touch();
    }

    /// Coefficients of a needed brick less the background, x fastest; NaN for voxels that are not needed, infinite
    /// for needed ones with a missing sample.
    #[inline(always)]
    pub fn decode(&self, index: usize, out: &mut [f32; BRICK_VOXELS]) {
        if self.lazy.is_some() {
            return self.decode_lazily(index, out);
        }
        let [chunk, i] = self.needed[index].map(|n| n as usize);
        let chunk = &self.chunks[chunk];
        let brick = &chunk.needed[i];
        chunk
            .stored(brick.place)
            .decode(&brick.mask, self.background, out);
    }

    /// The background b, normalised: an invisible value, the most common one.
    pub fn background(&self) -> f32 {
        self.background
    }

    /// Whether samples are missing.
    pub fn any_missing(&self) -> bool {
        self.lattice.any_missing
    }

    /// Voxels that are needed.
    pub fn needed_voxels(&self) -> usize {
        self.voxels
    }

    /// Lattice points along x, y, z.
    pub fn dims(&self) -> [usize; 3] {
        self.lattice.dims
    }

    /// Lattice points before voxel 0 along x, y, z.
    pub fn margin(&self) -> [usize; 3] {
        self.lattice.margin
    }

    /// Samples from which the field is built.
    pub fn source(&self) -> &SourceLevel {
        &self.source
    }

    /// The error of reading samples, if any; the field is then incomplete.
    pub fn failure(&self) -> Option<SceneError> {
        self.failure.get()
    }

    fn reader(&self) -> Reader<'_> {
        Reader::new(&self.source, &self.failure)
    }

    /// Memory held, bytes, the volume's own not included.
    pub fn bytes(&self) -> usize {
        let lazy = self.lazy.as_ref().map_or(0, Lazy::bytes);
        lazy + self.ranges.bytes()
            + self.cells.len() * size_of::<CellBits>()
            + self.needed.capacity() * size_of::<[u32; 2]>()
            + self.chunks.iter().map(Chunk::bytes).sum::<usize>()
    }

    /// Updates the visible cells of the bricks whose levels changed. Marks the bricks whose cells changed, and counts the
    /// bricks that were searched.
    fn find_cells(&mut self, levels: &VisibleLevels, changed: Option<&VisibleLevels>) -> (Vec<bool>, usize) {
        let mut touched = vec![false; self.cells.len()];
        let searched = AtomicUsize::new(0);
        let intervals = levels.intervals();
        let (lattice, bricks, ranges) = (&self.lattice, self.bricks, &self.ranges);
        let memory = || Reader::new(&self.source, &self.failure);
        self.cells
            .par_iter_mut()
            .zip(&mut touched)
            .enumerate()
            .with_min_len(64)
            .for_each_init(memory, |reader, (brick, (cells, touched))| {
                let seen = cells::widened(ranges.all()[brick]);
                if changed.is_some_and(|changed| seen != cells::NO_LEVEL && !changed.any_of(seen)) {
                    return;
                }
                let first = [
                    brick % bricks[0],
                    brick / bricks[0] % bricks[1],
                    brick / (bricks[0] * bricks[1]),
                ]
                .map(|b| b * BRICK);
                let found = ranges.visible((lattice, reader), (brick, first), (levels, &intervals));
                searched.fetch_add(1, Ordering::Relaxed);
                *touched = found != *cells;
                *cells = found;
            });
        (touched, searched.into_inner())
    }

    /// Voxels of a brick that are needed, from the visible cells of the 27 around it.
    fn needs(&self, cells: [Option<&CellBits>; 27]) -> Option<Needs> {
        if cells.iter().all(Option::is_none) {
            return None;
        }
        vectorized!(
            self.lattice.simd,
            if self.is_wide {
                Needs::around::<true>(&cells)
            } else {
                Needs::around::<false>(&cells)
            }
        )
    }

    /// Adds the needed bricks among the stored ones of a chunk, whose first brick is given.
    fn mask(&self, first: [usize; 3], found: Vec<(u32, Needs)>, chunk: &mut Chunk) {
        for (at, needs) in found {
            let stored = chunk.stored(at);
            let offset = place(at as usize);
            let voxel = std::array::from_fn(|a| (first[a] + offset[a]) * BRICK);
            let existing = cells::within(self.lattice.dims, voxel);
            let mask = vectorized!(self.lattice.simd, stored.mask(&needs, self.background, &existing));
            let voxels = mask.iter().map(|bits| bits.count_ones()).sum();
            if voxels > 0 {
                let brick = NeededBrick {
                    place: at,
                    mask,
                    voxels,
                };
                chunk.needed.push(brick);
            }
        }
    }

    /// First brick of a chunk.
    fn chunk_first(&self, chunk: usize) -> [usize; 3] {
        let [nx, ny]: [usize; 2] = std::array::from_fn(|a| self.bricks[a].div_ceil(CHUNK[a]));
        let at = [chunk % nx, chunk / nx % ny, chunk / (nx * ny)];
        std::array::from_fn(|a| at[a] * CHUNK[a])
    }
}

/// The bricks of a chunk and those around it.
struct Surroundings<'a> {
    /// Visible cells, `None` without any, and whether they changed.
    bricks: [(Option<&'a CellBits>, bool); AROUND[0] * AROUND[1] * AROUND[2]],
    any_touched: bool,
}

/// Bricks of a chunk and around it along x, y, z.
const AROUND: [usize; 3] = [CHUNK[0] + 2, CHUNK[1] + 2, CHUNK[2] + 2];

impl<'a> Surroundings<'a> {
    /// `cells`: those of the brick at a place, if it exists, and whether they changed.
    fn new(
        bricks: [usize; 3],
        first: [usize; 3],
        cells: impl Fn([usize; 3]) -> (&'a CellBits, bool),
    ) -> Self {
        let mut around = Self {
            bricks: [(None, false); _],
            any_touched: false,
        };
        let [nx, ny, nz] = bricks;
        for (row, bricks) in around.bricks.chunks_exact_mut(AROUND[0]).enumerate() {
            // Wraps below zero, which is outside too.
            let y = (first[1] + row % AROUND[1]).wrapping_sub(1);
            let z = (first[2] + row / AROUND[1]).wrapping_sub(1);
            if y >= ny || z >= nz {
                continue;
            }
            for (x, brick) in (first[0]..).zip(bricks) {
                let x = x.wrapping_sub(1);
                if x < nx {
                    let (cells, touched) = cells([x, y, z]);
                    let any = cells.iter().fold(0, |all, bits| all | bits) != 0;
                    *brick = (any.then_some(cells), touched);
                    around.any_touched |= touched;
                }
            }
        }
        around
    }

    /// A brick of the chunk, in bricks from its first, and the 26 around it.
    #[inline(always)]
    fn of(&self, [x, y, z]: [usize; 3]) -> [(Option<&'a CellBits>, bool); 27] {
        let start = (z * AROUND[1] + y) * AROUND[0] + x;
        let mut around = [(None, false); 27];
        for (i, row) in around.as_chunks_mut::<3>().0.iter_mut().enumerate() {
            let from = start + (i / 3 * AROUND[1] + i % 3) * AROUND[0];
            row.copy_from_slice(&self.bricks[from..from + 3]);
        }
        around
    }
}

/// Position of a brick in its chunk, in bricks.
fn place(place: usize) -> [usize; 3] {
    [
        place % CHUNK[0],
        place / CHUNK[0] % CHUNK[1],
        place / (CHUNK[0] * CHUNK[1]),
    ]
}

impl Chunk {
    fn stored(&self, place: u32) -> &StoredBrick {
        &self.stored[(self.held & ((1 << place) - 1)).count_ones() as usize]
    }

    /// Memory held, bytes.
    fn bytes(&self) -> usize {
        size_of::<Self>()
            + self.stored.capacity() * size_of::<StoredBrick>()
            + self.needed.capacity() * size_of::<NeededBrick>()
    }

    /// Drops bricks other than those at `places`.
    fn keep(&mut self, places: u128) {
        if self.held & !places != 0 {
            let mut held = (0..u128::BITS).filter(|place| self.held >> place & 1 != 0);
            self.stored
                .retain(|_| held.next().is_some_and(|place| places >> place & 1 != 0));
            self.stored.shrink_to_fit();
            self.held &= places;
        }
    }
}

/// The update of one chunk.
struct ChunkJob<'a> {
    store: &'a FieldStore,
    touched: &'a [bool],
    all_again: bool,
    /// Bricks solved by all jobs.
    solved: &'a AtomicUsize,
}

impl ChunkJob<'_> {
    fn update(&self, index: usize, chunk: &mut Chunk, memory: (&mut Reader<'_>, &mut Scratch)) {
        let store = self.store;
        let first = store.chunk_first(index);
        let [nx, ny, _] = store.bricks;
        let surroundings = Surroundings::new(store.bricks, first, |[x, y, z]| {
            let index = (z * ny + y) * nx + x;
            (&store.cells[index], self.touched[index])
        });
        if !self.all_again && !surroundings.any_touched {
            return;
        }
        let mut old = std::mem::take(&mut chunk.needed).into_iter().peekable();
        let mut again: Vec<(u32, Needs)> = Vec::new();
        let mut wanted = 0u128;
        for at in 0..u128::BITS {
            let offset = place(at as usize);
            if (0..3).any(|a| first[a] + offset[a] >= store.bricks[a]) {
                continue;
            }
            let known = old.next_if(|brick| brick.place == at);
            let around = surroundings.of(offset);
            if self.all_again || around.iter().any(|(_, touched)| *touched) {
                let needs = store.needs(around.map(|(cells, _)| cells));
                if let Some(needs) = needs {
                    again.push((at, needs));
                    wanted |= 1 << at;
                }
            } else if let Some(known) = known {
                wanted |= 1 << at;
                chunk.needed.push(known);
            }
        }
        if wanted & !chunk.held != 0 {
            let (reader, scratch) = memory;
            let region = store.solver.region(&store.lattice, first.map(|b| b * BRICK));
            let solved =
                with_block!(reader, region, data => self.solve(data, (first, wanted), chunk, scratch));
            if solved.is_none() {
                return;
            }
        }
        store.mask(first, again, chunk);
        chunk.needed.sort_unstable_by_key(|brick| brick.place);
        if !store.keep_all {
            chunk.keep(wanted);
        }
    }

    /// Solves for the chunk and stores the wanted bricks, including those already held.
    fn solve<T: StoredSample>(
        &self,
        data: &Block<'_, T>,
        (first, wanted): ([usize; 3], u128),
        chunk: &mut Chunk,
        scratch: &mut Scratch,
    ) {
        let store = self.store;
        let origin = first.map(|b| b * BRICK);
        let solved = store.solver.solve(&store.lattice, data, origin, scratch);
        let mut bricks = Vec::new();
        chunk.held = 0;
        for at in 0..u128::BITS {
            let offset = place(at as usize);
            let inside = (0..3).all(|a| first[a] + offset[a] < store.bricks[a]);
            if inside && (store.keep_all || wanted >> at & 1 != 0) {
                let from = (offset.map(|b| b * BRICK), origin);
                bricks.push(solved.brick(scratch, &store.lattice, data, from));
                chunk.held |= 1 << at;
            }
        }
        self.solved.fetch_add(bricks.len(), Ordering::Relaxed);
        bricks.shrink_to_fit();
        chunk.stored = bricks;
    }
}
