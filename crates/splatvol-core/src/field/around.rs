//! Cells whose corners do not bound the values inside.
//!
//! Near a missing sample, values come from the remaining samples within the kernel's reach, and interpolating
//! coefficients leave the samples' range further than elsewhere. A kernel of samples that are not prefiltered
//! smooths: values come from the whole reach of the kernel, and stay within the range of the samples there. Such a
//! cell has the range of all the points whose kernels reach it, and its brick includes the ranges of the bricks
//! around it.

use rayon::prelude::*;

use crate::brick::BRICK;
use crate::visibility::{LEVELS, VisibleLevels, level_of};

use super::Reader;
use super::cells::{
    self, CellBits, LevelRange, NO_LEVEL, POINTS, Verdict, along_bricks, existing, pack, span, union,
};
use super::lattice::{Block, Lattice, Row, StoredSample};
use super::level::{Failure, SourceLevel};

/// Voxels that kernels reach at most.
const REACH: usize = 3;
/// Points along an axis whose kernels reach a brick's cells.
const EDGE: usize = BRICK + 2 * REACH - 1;
/// Length of a row of such points, rounded up to whole vectors.
const ROW: usize = EDGE.next_multiple_of(BRICK);

/// Ranges of the values of bricks.
#[derive(Debug, Clone)]
pub(super) struct BrickRanges {
    ranges: Vec<LevelRange>,
    /// Marks bricks with cells that values from outside the cell reach; empty where there is no such brick.
    loose: Vec<bool>,
    /// Whether coefficients interpolate the samples.
    interpolates: bool,
    /// Whether the kernel reaches three voxels, not two.
    is_wide: bool,
}

impl BrickRanges {
    /// Reads all samples.
    pub(super) fn new(
        (lattice, source, failure): (&Lattice, &SourceLevel, &Failure),
        bricks: [usize; 3],
        (interpolates, is_wide): (bool, bool),
    ) -> Self {
        let count = bricks.iter().product();
        let mut ranges = vec![NO_LEVEL; count];
        let mut loose = Vec::new();
        let layer = bricks[0] * bricks[1];
        let reader = || Reader::new(source, failure);
        let layer_region = |bz: usize| {
            let [nx, ny, _] = lattice.dims;
            lattice.region([0, 0, bz * BRICK], [nx, ny, bz * BRICK + POINTS])
        };
        if lattice.any_missing {
            loose.resize(count, false);
            let layers = ranges.par_chunks_mut(layer).zip(loose.par_chunks_mut(layer));
            layers.enumerate().for_each_init(reader, |reader, (bz, (ranges, holed))| {
                with_block!(reader, layer_region(bz), data => layer_ranges(lattice, data, bz, (ranges, holed)));
            });
            around(&mut loose, bricks, |a, b| a | b);
        } else {
            let layers = ranges.par_chunks_mut(layer).enumerate();
            layers.for_each_init(reader, |reader, (bz, ranges)| {
                with_block!(reader, layer_region(bz), data => cells::layer_ranges(lattice, data, bz, ranges));
            });
        }
        if !interpolates {
            loose = vec![true; count];
        }
        let mut of = Self {
            ranges,
            loose,
            interpolates,
            is_wide,
        };
        of.spread(bricks);
        of
    }

    /// None: they are found brick by brick ([`Self::visible_within`]).
    pub(super) fn unknown((interpolates, is_wide): (bool, bool)) -> Self {
        Self {
            ranges: Vec::new(),
            loose: Vec::new(),
            interpolates,
            is_wide,
        }
    }

    /// Widens the ranges of bricks by those of the bricks around, where values from there reach them.
    fn spread(&mut self, bricks: [usize; 3]) {
        if !self.loose.contains(&true) {
            self.loose.clear();
            return;
        }
        let mut wide = self.ranges.clone();
        around(&mut wide, bricks, union);
        for ((own, wide), _) in self
            .ranges
            .iter_mut()
            .zip(wide)
            .zip(&self.loose)
            .filter(|of| *of.1)
        {
            let [low, high] = wide;
            *own = match low > high {
                true => NO_LEVEL,
                false => {
                    let slack = slack(self.interpolates, i32::from(low), i32::from(high)) as i16;
                    [(low - slack).max(0), (high + slack).min(LEVELS as i16 - 1)]
                }
            };
        }
    }

    /// All of them.
    pub(super) fn all(&self) -> &[LevelRange] {
        &self.ranges
    }

    /// Memory held, bytes.
    pub(super) fn bytes(&self) -> usize {
        self.ranges.len() * size_of::<LevelRange>() + self.loose.len()
    }

    /// Visible cells of the brick at `first`, among the existing ones. `intervals`: the visible levels.
    pub(super) fn visible(
        &self,
        (lattice, reader): (&Lattice, &mut Reader<'_>),
        (brick, first): (usize, [usize; 3]),
        (levels, intervals): (&VisibleLevels, &[LevelRange]),
    ) -> CellBits {
        if levels.all_of([0, LEVELS as i16 - 1]) {
            // Even where there is no sample: it must be known that there is none.
            return existing(lattice, first);
        }
        let range = self.ranges[brick];
        let is_loose = self.loose.get(brick).is_some_and(|loose| *loose);
        let found = match cells::verdict(range, levels) {
            Verdict::None => return [0; BRICK],
            Verdict::All if !is_loose => [u64::MAX; BRICK],
            _ => {
                let [low, high] = cells::widened(range);
                let from = intervals.partition_point(|interval| interval[1] < low);
                let to = intervals.partition_point(|interval| interval[0] <= high);
                let intervals = &intervals[from..to];
                // Samples read a little too far have no effect.
                let region = lattice.region(first, first.map(|at| at + ROW));
                let found = with_block!(reader, region, data => match is_loose {
                    false => vectorized!(lattice.simd, {
                        let points = cells::read(lattice, data, first);
                        cells::visible(&points, intervals)
                    }),
                    true => vectorized!(lattice.simd, self.loosely((lattice, data), first, intervals)),
                });
                found.unwrap_or_default()
            }
        };
        let existing = existing(lattice, first);
        std::array::from_fn(|z| found[z] & existing[z])
    }

    /// As [`Self::visible`], of a brick whose range is not known and whose cells are bounded by their corners.
    pub(super) fn visible_within<T: StoredSample>(
        (lattice, data): (&Lattice, &Block<'_, T>),
        first: [usize; 3],
        (levels, intervals): (&VisibleLevels, &[LevelRange]),
    ) -> CellBits {
        let existing = existing(lattice, first);
        if levels.all_of([0, LEVELS as i16 - 1]) {
            return existing;
        }
        let found = vectorized!(lattice.simd, {
            let points = cells::read(lattice, data, first);
            let range = cells::range(&points);
            match cells::verdict(range, levels) {
                Verdict::None => [0; BRICK],
                Verdict::All => [u64::MAX; BRICK],
                Verdict::Mixed => {
                    let [low, high] = cells::widened(range);
                    let from = intervals.partition_point(|interval| interval[1] < low);
                    let to = intervals.partition_point(|interval| interval[0] <= high);
                    cells::visible(&points, &intervals[from..to])
                }
            }
        });
        std::array::from_fn(|z| found[z] & existing[z])
    }

    /// Visible cells of a brick whose cells are reached by values from outside.
    #[inline(always)]
    fn loosely<T: StoredSample>(
        &self,
        (lattice, data): (&Lattice, &Block<'_, T>),
        first: [usize; 3],
        intervals: &[LevelRange],
    ) -> CellBits {
        let points = Points::read(lattice, data, first);
        let cells = match self.is_wide {
            true => Reached::of::<3>(&points),
            false => Reached::of::<2>(&points),
        };
        let reached = cells.visible(intervals, self.interpolates);
        if !self.interpolates {
            return reached;
        }
        let corners = cells::visible(&cells::read(lattice, data, first), intervals);
        let holed = cells.holed();
        std::array::from_fn(|z| (reached[z] & holed[z]) | (corners[z] & !holed[z]))
    }
}

/// Overshoot: how far a reconstruction from all the points around may leave the range of their levels. It is the
/// range's width where coefficients interpolate, since an isolated coefficient may lie that far outside, plus the
/// levels' own width.
#[inline(always)]
fn slack(interpolates: bool, low: i32, high: i32) -> i32 {
    1 + if interpolates { high - low + 1 } else { 0 }
}

/// Joins each brick's value with those of the 26 bricks around.
fn around<T: Copy>(values: &mut [T], bricks: [usize; 3], join: impl Fn(T, T) -> T) {
    let strides = [1, bricks[0], bricks[0] * bricks[1]];
    for axis in 0..3 {
        let before = values.to_vec();
        for (index, value) in values.iter_mut().enumerate() {
            let at = index / strides[axis] % bricks[axis];
            if at > 0 {
                *value = join(*value, before[index - strides[axis]]);
            }
            if at + 1 < bricks[axis] {
                *value = join(*value, before[index + strides[axis]]);
            }
        }
    }
}

/// Ranges of the existing samples in a layer of bricks, x fastest, and which bricks have missing samples.
fn layer_ranges<T: StoredSample>(
    lattice: &Lattice,
    data: &Block<'_, T>,
    bz: usize,
    (ranges, holed): (&mut [LevelRange], &mut [bool]),
) {
    let [nx, ny, nz] = lattice.dims;
    let bricks_x = nx.div_ceil(BRICK);
    let rows = ranges.chunks_mut(bricks_x).zip(holed.chunks_mut(bricks_x));
    for (by, (ranges, holed)) in rows.enumerate() {
        let mut columns = vec![NO_LEVEL; lattice.own[0]];
        let mut gaps = vec![false; lattice.own[0]];
        for z in span(bz, nz) {
            for y in span(by, ny) {
                let samples = lattice.row(data, [y, z]).samples();
                for ((range, gap), &sample) in columns.iter_mut().zip(&mut gaps).zip(samples) {
                    let value = lattice.normalised(sample);
                    match value.is_finite() {
                        true => *range = union(*range, [level_of(value); 2]),
                        false => *gap = true,
                    }
                }
            }
        }
        along_bricks(lattice, &columns, ranges);
        let mut points = [false; POINTS];
        for (bx, holed) in holed.iter_mut().enumerate() {
            lattice.points(Row::whole(&gaps), bx * BRICK, &mut points);
            *holed = points.contains(&true);
        }
    }
}

/// A number for each point whose kernel reaches a brick's cells.
type Numbers = [[[i16; ROW]; EDGE]; EDGE];
/// Numbers of its cells.
type Cells = [[[i16; BRICK]; BRICK]; BRICK];

/// The points whose kernels reach a brick's cells.
struct Points {
    /// Levels; a missing sample's low level is above all others, and its high level below.
    low: Numbers,
    high: Numbers,
    /// One where a sample is missing.
    gaps: Numbers,
}

impl Points {
    /// Reads the points around the brick at `first`; points beyond the lattice repeat its outermost ones.
    #[inline(always)]
    fn read<T: StoredSample>(lattice: &Lattice, data: &Block<'_, T>, first: [usize; 3]) -> Self {
        let [_, ny, nz] = lattice.dims;
        let mut points = Self {
            low: [[[0; ROW]; EDGE]; EDGE],
            high: [[[0; ROW]; EDGE]; EDGE],
            gaps: [[[0; ROW]; EDGE]; EDGE],
        };
        let before = REACH - 1;
        // Kernels reach less than a brick's width before it, so only the first brick lacks points there.
        let skipped = if first[0] == 0 { before } else { 0 };
        let start = (first[0] + skipped).saturating_sub(before);
        for z in 0..EDGE {
            for y in 0..EDGE {
                let at =
                    |first: usize, i: usize, count: usize| (first + i).saturating_sub(before).min(count - 1);
                let row = lattice.row(data, [at(first[1], y, ny), at(first[2], z, nz)]);
                let mut samples = [data.any(); ROW];
                lattice.points(row, start, &mut samples[skipped..]);
                for (x, sample) in samples.into_iter().enumerate() {
                    let value = lattice.normalised(sample);
                    let (is_there, level) = (value.is_finite(), level_of(value));
                    points.low[z][y][x] = if is_there { level } else { i16::MAX };
                    points.high[z][y][x] = if is_there { level } else { i16::MIN };
                    points.gaps[z][y][x] = i16::from(!is_there);
                }
            }
        }
        points
    }
}

/// Levels and missing points within reach of each cell of a brick.
struct Reached {
    low: Cells,
    high: Cells,
    gaps: Cells,
}

impl Reached {
    /// By kernels that reach `R` voxels.
    #[inline(always)]
    fn of<const R: usize>(points: &Points) -> Self {
        Self {
            low: slide::<R>(&points.low, i16::min),
            high: slide::<R>(&points.high, i16::max),
            gaps: slide::<R>(&points.gaps, i16::max),
        }
    }

    #[inline(always)]
    fn visible(&self, intervals: &[LevelRange], interpolates: bool) -> CellBits {
        let seen = |low: i16, high: i16| {
            let (low, high) = (i32::from(low), i32::from(high));
            let slack = slack(interpolates, low, high);
            let meets =
                |[from, to]: &LevelRange| low - slack <= i32::from(*to) && high + slack >= i32::from(*from);
            u8::from(low <= high && intervals.iter().any(meets))
        };
        let row = |z: usize, y: usize| {
            let (low, high) = (&self.low[z][y], &self.high[z][y]);
            pack(std::array::from_fn(|x| seen(low[x], high[x]))) << (BRICK * y)
        };
        std::array::from_fn(|z| (0..BRICK).fold(0, |bits, y| bits | row(z, y)))
    }

    /// Cells that a missing sample would reach.
    #[inline(always)]
    fn holed(&self) -> CellBits {
        let row = |z: usize, y: usize| pack(self.gaps[z][y].map(|gap| gap as u8)) << (BRICK * y);
        std::array::from_fn(|z| (0..BRICK).fold(0, |bits, y| bits | row(z, y)))
    }
}

/// Joins the numbers of the `2 R` points along each axis around each cell.
#[inline(always)]
fn slide<const R: usize>(points: &Numbers, join: impl Fn(i16, i16) -> i16 + Copy) -> Cells {
    let window = |cell: usize| cell + REACH - R..cell + REACH + R;
    let joined = |out: &mut [i16; BRICK], other: &[i16]| {
        for (out, other) in out.iter_mut().zip(other) {
            *out = join(*out, *other);
        }
    };
    let mut rows = [[[0; BRICK]; EDGE]; EDGE];
    for (rows, points) in rows.iter_mut().zip(points) {
        for (row, points) in rows.iter_mut().zip(points) {
            row.copy_from_slice(&points[REACH - R..][..BRICK]);
            for x in window(0).skip(1) {
                joined(row, &points[x..x + BRICK]);
            }
        }
    }
    let mut slices = [[[0; BRICK]; BRICK]; EDGE];
    for (slice, rows) in slices.iter_mut().zip(&rows) {
        for (y, out) in slice.iter_mut().enumerate() {
            *out = rows[window(y).start];
            for row in &rows[window(y)] {
                joined(out, row);
            }
        }
    }
    let mut cells = [[[0; BRICK]; BRICK]; BRICK];
    for (z, cells) in cells.iter_mut().enumerate() {
        for (y, out) in cells.iter_mut().enumerate() {
            *out = slices[window(z).start][y];
            for slice in &slices[window(z)] {
                joined(out, &slice[y]);
            }
        }
    }
    cells
}
