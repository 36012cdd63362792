//! Visible cells of a brick: one bit per cell, from the ranges of their corners.
//!
//! Ranges are levels of [`VisibleLevels`], which keep the order of values, in 16
//! bits: eight cells fit the smallest vector register. A brick's own range decides most bricks; cells are tested
//! one by one only where some of its levels are visible and some are not. [`super::around`] handles cells whose
//! corners do not bound the values inside.

use crate::brick::BRICK;
use crate::visibility::{LEVELS, VisibleLevels};

use super::lattice::{Block, Lattice, Row, StoredSample};

/// Bit `8 y + x` of word z for each cell of a brick.
pub(super) type CellBits = [u64; BRICK];

/// Lattice points along the edge of a brick of cells.
pub(super) const POINTS: usize = BRICK + 1;

/// Smallest and largest level of the points around a brick's cells.
pub(super) type LevelRange = [i16; 2];

/// The range of no point.
pub(super) const NO_LEVEL: LevelRange = [i16::MAX, i16::MIN];

/// Union of two ranges.
pub(super) fn union(a: LevelRange, b: LevelRange) -> LevelRange {
    [a[0].min(b[0]), a[1].max(b[1])]
}

/// Overshoot: how far the reconstruction may leave a range of levels. It is 5/32 of the range's width, including
/// the width of the levels themselves.
#[inline(always)]
fn slack(low: i16, high: i16) -> i16 {
    (((high - low + 1) * 5) >> 5) + 1
}

/// A range with the reconstruction's overshoot.
pub(super) fn widened([low, high]: LevelRange) -> LevelRange {
    if low > high {
        return NO_LEVEL;
    }
    let slack = slack(low, high);
    [(low - slack).max(0), (high + slack).min(LEVELS as i16 - 1)]
}

/// Which of a brick's cells are visible, as far as its range tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Verdict {
    None,
    All,
    Mixed,
}

pub(super) fn verdict(range: LevelRange, levels: &VisibleLevels) -> Verdict {
    if range == NO_LEVEL || !levels.any_of(widened(range)) {
        Verdict::None
    } else if levels.all_of(range) {
        Verdict::All
    } else {
        Verdict::Mixed
    }
}

/// Cells of the brick at `first` that exist.
pub(super) fn existing(lattice: &Lattice, first: [usize; 3]) -> CellBits {
    let cells = lattice.dims.map(|n| n.saturating_sub(1).max(1));
    within(cells, first)
}

/// Cells of the brick at `first` that are within a box of so many cells along x, y, z.
pub(super) fn within(counts: [usize; 3], first: [usize; 3]) -> CellBits {
    let [x, y, z]: [usize; 3] = std::array::from_fn(|a| counts[a].saturating_sub(first[a]).min(BRICK));
    let row = (1u64 << x) - 1;
    let slice = (0..y).fold(0, |bits, y| bits | row << (BRICK * y));
    std::array::from_fn(|i| if i < z { slice } else { 0 })
}

/// Level ranges of a layer of bricks, x fastest.
pub(super) fn layer_ranges<T: StoredSample>(
    lattice: &Lattice,
    data: &Block<'_, T>,
    bz: usize,
    out: &mut [LevelRange],
) {
    let [nx, ny, nz] = lattice.dims;
    let bricks_x = nx.div_ceil(BRICK);
    let mut line = Vec::new();
    for (by, row) in out.chunks_mut(bricks_x).enumerate() {
        let (ys, zs) = (span(by, ny), span(bz, nz));
        // Minima and maxima over the brick's rows, per x; then over each brick's columns.
        let mut low: Vec<T> = Vec::new();
        let mut high: Vec<T> = Vec::new();
        for z in zs {
            for y in ys.clone() {
                let samples = lattice.row(data, [y, z]).samples();
                if low.is_empty() {
                    low.extend_from_slice(samples);
                    high.extend_from_slice(samples);
                } else {
                    join(&mut low, &mut high, samples);
                }
            }
        }
        line.clear();
        line.extend(low.iter().zip(&high).map(|(&low, &high)| {
            let (a, b) = (lattice.level(low), lattice.level(high));
            [a.min(b), a.max(b)]
        }));
        along_bricks(lattice, &line, row);
    }
}

/// Ranges of a row of bricks, from those of its columns.
pub(super) fn along_bricks(lattice: &Lattice, columns: &[LevelRange], row: &mut [LevelRange]) {
    let mut points = [NO_LEVEL; POINTS];
    for (bx, range) in row.iter_mut().enumerate() {
        lattice.points(Row::whole(columns), bx * BRICK, &mut points);
        *range = points.into_iter().fold(NO_LEVEL, union);
    }
}

#[inline(always)]
fn join<T: StoredSample>(low: &mut [T], high: &mut [T], samples: &[T]) {
    for ((low, high), &sample) in low.iter_mut().zip(high).zip(samples) {
        *low = if sample < *low { sample } else { *low };
        *high = if sample > *high { sample } else { *high };
    }
}

/// Lattice points of the cells of a brick along an axis.
pub(super) fn span(brick: usize, count: usize) -> std::ops::Range<usize> {
    brick * BRICK..(brick * BRICK + POINTS).min(count)
}

/// Lattice points around a brick's cells, in whole vectors.
const PADDED: usize = (POINTS * POINTS * POINTS).next_multiple_of(32);

/// Levels of the lattice points around a brick's cells, rows of nine.
pub(super) type PointLevels = [i16; PADDED];

/// Reads the points around a brick's cells; beyond the lattice, its last points repeat.
#[inline(always)]
pub(super) fn read<T: StoredSample>(
    lattice: &Lattice,
    data: &Block<'_, T>,
    first: [usize; 3],
) -> PointLevels {
    let lattice = *lattice;
    let [_, ny, nz] = lattice.dims;
    let mut samples = [data.any(); PADDED];
    let rows = samples
        .as_chunks_mut::<POINTS>()
        .0
        .iter_mut()
        .take(POINTS * POINTS);
    for (i, out) in rows.enumerate() {
        let (y, z) = (first[1] + i % POINTS, first[2] + i / POINTS);
        let row = lattice.row(data, [y.min(ny - 1), z.min(nz - 1)]);
        // The usual case, copied without a call.
        match row.chunk(first[0].wrapping_sub(lattice.margin[0])) {
            Some(points) => *out = *points,
            None => lattice.points(row, first[0], out),
        }
    }
    // All at once, which makes it a loop over vectors.
    let mut levels = [0; PADDED];
    for (level, &sample) in levels.iter_mut().zip(&samples) {
        *level = lattice.level(sample);
    }
    levels
}

/// Smallest and largest level of the points around a brick's cells.
#[inline(always)]
pub(super) fn range(points: &PointLevels) -> LevelRange {
    let points = &points[..POINTS * POINTS * POINTS];
    points.iter().fold([i16::MAX, i16::MIN], |[low, high], &level| {
        [low.min(level), high.max(level)]
    })
}

/// Visible cells between points, each by its own range. `intervals`: the visible levels.
#[inline(always)]
pub(super) fn visible(points: &PointLevels, intervals: &[LevelRange]) -> CellBits {
    let mut low = [[[0i16; BRICK]; POINTS]; POINTS];
    let mut high = low;
    let rows = points.as_chunks::<POINTS>().0.iter().take(POINTS * POINTS);
    for (row, points) in rows.enumerate() {
        let (low, high) = (
            &mut low[row / POINTS][row % POINTS],
            &mut high[row / POINTS][row % POINTS],
        );
        for x in 0..BRICK {
            low[x] = points[x].min(points[x + 1]);
            high[x] = points[x].max(points[x + 1]);
        }
    }
    fold(&mut low, i16::min);
    fold(&mut high, i16::max);
    let mut bits = [0u64; BRICK];
    for z in 0..BRICK {
        for y in 0..BRICK {
            let mut seen = [0u8; BRICK];
            let (low, high) = (&low[z][y], &high[z][y]);
            for [from, to] in intervals {
                for x in 0..BRICK {
                    let slack = slack(low[x], high[x]);
                    seen[x] |= u8::from(low[x] - slack <= *to) & u8::from(high[x] + slack >= *from);
                }
            }
            bits[z] |= pack(seen) << (BRICK * y);
        }
    }
    bits
}

/// Joins each row with the next along y, then each slice with the next.
#[inline(always)]
fn fold(slices: &mut [[[i16; BRICK]; POINTS]; POINTS], join: impl Fn(i16, i16) -> i16 + Copy) {
    for slice in slices.iter_mut() {
        for y in 0..BRICK {
            let next = slice[y + 1];
            slice[y].iter_mut().zip(next).for_each(|(a, b)| *a = join(*a, b));
        }
    }
    for z in 0..BRICK {
        let next = slices[z + 1];
        for (row, next) in slices[z].iter_mut().zip(next) {
            row.iter_mut().zip(next).for_each(|(a, b)| *a = join(*a, b));
        }
    }
}

/// Eight zeros and ones as eight bits, the first lowest: the product moves bit 8 i to bit 56 + i.
#[inline(always)]
pub(super) fn pack(flags: [u8; 8]) -> u64 {
    u64::from_le_bytes(flags).wrapping_mul(0x0102_0408_1020_4080) >> 56
}
