//! Reference store straight from the definition: every cell and every voxel by itself, from coefficients of the
//! whole volume.

use rayon::prelude::*;
use splatvol_scene::volume::widen;
use splatvol_scene::{Volume, with_samples};

use crate::brick::BRICK;
use crate::coefficients::{Coefficients, sample_at};
use crate::visibility::{BRICK_VOXELS, TOLERANCE, VisibleLevels};

/// Overshoot of a cell's reconstruction beyond the range of its corners, relative to that range's width.
const CELL_OVERSHOOT: f32 = 0.15;

/// Bricks that hold needed voxels, and their coefficients less the background; NaN where a voxel is not needed.
#[derive(Debug, Clone, Default)]
pub(super) struct BrickStore {
    /// First lattice point of each brick.
    pub(super) first: Vec<[u32; 3]>,
    /// Coefficients of each brick, x fastest.
    pub(super) values: Vec<[f32; BRICK_VOXELS]>,
    /// The background b, normalised.
    pub(super) background: f32,
    /// Voxels that are needed.
    pub(super) needed: usize,
}

/// One bit per cell, rows of words along x.
struct VisibleCells {
    words: usize,
    rows: [usize; 2],
    bits: Vec<u64>,
}

impl VisibleCells {
    fn new(volume: &Volume, coefficients: &Coefficients, levels: &VisibleLevels) -> Self {
        let dims = coefficients.dims;
        let cells = dims.map(|n| n.saturating_sub(1).max(1));
        let words = cells[0].div_ceil(64);
        let mut bits = vec![0u64; words * cells[1] * cells[2]];
        bits.par_chunks_mut(words * cells[1])
            .enumerate()
            .for_each(|(z, slice)| {
                let mut ranges = CellRanges::new(volume, coefficients, z);
                for (y, row) in slice.chunks_mut(words).enumerate() {
                    let (low, high) = ranges.row(y);
                    for x in 0..cells[0] {
                        let (low, high) = (low[x].min(low[x + 1]), high[x].max(high[x + 1]));
                        let slack = CELL_OVERSHOOT * (high - low);
                        row[x / 64] |= u64::from(levels.any(low - slack, high + slack)) << (x % 64);
                    }
                }
            });
        Self {
            words,
            rows: [cells[1], cells[2]],
            bits,
        }
    }

    /// Cells `x0 - 2 .. x0 + 10` of a row, as twelve bits.
    #[inline]
    fn twelve(&self, x0: usize, y: isize, z: isize) -> u32 {
        if y < 0 || z < 0 || y as usize >= self.rows[0] || z as usize >= self.rows[1] {
            return 0;
        }
        let row = &self.bits[(z as usize * self.rows[0] + y as usize) * self.words..][..self.words];
        let word = |i: isize| {
            if i >= 0 && (i as usize) < row.len() {
                row[i as usize]
            } else {
                0
            }
        };
        let start = x0 as isize - 2;
        let (index, shift) = (start.div_euclid(64), start.rem_euclid(64) as u32);
        let both = u128::from(word(index)) | u128::from(word(index + 1)) << 64;
        (both >> shift) as u32 & 0xfff
    }
}

/// Ranges of samples over the two rows and slices that a row of cells lies between.
struct CellRanges<'a> {
    volume: &'a Volume,
    coefficients: &'a Coefficients,
    z: usize,
    line: Vec<f32>,
    low: Vec<f32>,
    high: Vec<f32>,
}

impl<'a> CellRanges<'a> {
    fn new(volume: &'a Volume, coefficients: &'a Coefficients, z: usize) -> Self {
        let n = coefficients.dims[0] + 1;
        Self {
            volume,
            coefficients,
            z,
            line: vec![0.0; n],
            low: vec![0.0; n],
            high: vec![0.0; n],
        }
    }

    fn row(&mut self, y: usize) -> (&[f32], &[f32]) {
        let dims = self.coefficients.dims;
        self.low.fill(f32::INFINITY);
        self.high.fill(f32::NEG_INFINITY);
        for (dy, dz) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let (y, z) = ((y + dy).min(dims[1] - 1), (self.z + dz).min(dims[2] - 1));
            normalised_row(self.volume, self.coefficients, [y, z], &mut self.line[..dims[0]]);
            self.line[dims[0]] = self.line[dims[0] - 1];
            for ((low, high), value) in self.low.iter_mut().zip(&mut self.high).zip(&self.line) {
                *low = low.min(*value);
                *high = high.max(*value);
            }
        }
        (&self.low, &self.high)
    }
}

/// Normalised samples of a lattice row (y, z); the outermost ones fill the margin.
fn normalised_row(volume: &Volume, coefficients: &Coefficients, [y, z]: [usize; 2], line: &mut [f32]) {
    let [low, high] = volume.value_range();
    let rescale = volume.rescale();
    let scale = if high > low { 1.0 / (high - low) } else { 1.0 };
    let (slope, offset) = (
        (rescale.slope * scale) as f32,
        ((rescale.intercept - low) * scale) as f32,
    );
    let own = volume.grid().dims();
    let sample = |axis: usize, point: usize| sample_at(point, coefficients.margin[axis], own[axis]);
    let start = (sample(2, z) * own[1] + sample(1, y)) * own[0];
    let margin = coefficients.margin[0];
    with_samples!(volume.samples(), data => {
        let source = &data[start..start + own[0]];
        for (value, sample) in line[margin..].iter_mut().zip(source) {
            *value = widen(*sample) as f32 * slope + offset;
        }
        for x in (0..margin).chain(margin + own[0]..line.len()) {
            line[x] = widen(source[sample(0, x)]) as f32 * slope + offset;
        }
    });
}

impl BrickStore {
    /// Collects the voxels that a reconstruction needs under a transfer function.
    pub(super) fn new(
        volume: &Volume,
        coefficients: &Coefficients,
        levels: &VisibleLevels,
        background: f32,
    ) -> Self {
        let cells = VisibleCells::new(volume, coefficients, levels);
        let bricks = coefficients.dims.map(|n| n.div_ceil(BRICK));
        let layers: Vec<Self> = (0..bricks[2])
            .into_par_iter()
            .map(|bz| {
                let mut layer = Self {
                    background,
                    ..Self::default()
                };
                for by in 0..bricks[1] {
                    for bx in 0..bricks[0] {
                        layer.add(&cells, coefficients, [bx, by, bz].map(|b| b * BRICK));
                    }
                }
                layer
            })
            .collect();
        let mut store = Self {
            background,
            ..Self::default()
        };
        for mut layer in layers {
            store.first.append(&mut layer.first);
            store.values.append(&mut layer.values);
            store.needed += layer.needed;
        }
        store
    }

    fn add(&mut self, cells: &VisibleCells, coefficients: &Coefficients, first: [usize; 3]) {
        let Some(needs) = Needs::around(cells, first) else {
            return;
        };
        let dims = coefficients.dims;
        let mut values = [f32::NAN; BRICK_VOXELS];
        let mut count = 0;
        for z in 0..BRICK.min(dims[2] - first[2]) {
            for y in 0..BRICK.min(dims[1] - first[1]) {
                let start = ((first[2] + z) * dims[1] + first[1] + y) * dims[0] + first[0];
                let row = &coefficients.values[start..start + BRICK.min(dims[0] - first[0])];
                let (near, far) = needs.row(y, z);
                for (x, coefficient) in row.iter().enumerate() {
                    let difference = coefficient - self.background;
                    let needed = near >> x & 1 != 0 || (far >> x & 1 != 0 && difference.abs() > TOLERANCE);
                    if needed {
                        values[(z * BRICK + y) * BRICK + x] = difference;
                        count += usize::from(!difference.is_nan());
                    }
                }
            }
        }
        if count > 0 {
            self.first.push(first.map(|f| f as u32));
            self.values.push(values);
            self.needed += count;
        }
    }
}

/// Bits per row of a brick: voxels within one cell of a visible one, and within two.
struct Needs {
    near: [[u8; BRICK]; BRICK],
    far: [[u8; BRICK]; BRICK],
}

impl Needs {
    fn around(cells: &VisibleCells, first: [usize; 3]) -> Option<Self> {
        const REGION: usize = BRICK + 4;
        let mut along_x = [[(0u8, 0u8); REGION]; REGION];
        let mut any = 0;
        for (dz, slice) in along_x.iter_mut().enumerate() {
            for (dy, bits) in slice.iter_mut().enumerate() {
                let (y, z) = ((first[1] + dy) as isize - 2, (first[2] + dz) as isize - 2);
                let row = cells.twelve(first[0], y, z);
                any |= row;
                // Voxel x touches cells x - 1 and x: bits x + 1 and x + 2.
                *bits = (
                    (row >> 1 | row >> 2) as u8,
                    (row | row >> 1 | row >> 2 | row >> 3) as u8,
                );
            }
        }
        if any == 0 {
            return None;
        }
        let mut needs = Self {
            near: [[0; BRICK]; BRICK],
            far: [[0; BRICK]; BRICK],
        };
        for z in 0..BRICK {
            for y in 0..BRICK {
                for (dz, slice) in along_x[z..z + 4].iter().enumerate() {
                    for (dy, (near, far)) in slice[y..y + 4].iter().enumerate() {
                        needs.far[z][y] |= far;
                        if matches!(dz, 1 | 2) && matches!(dy, 1 | 2) {
                            needs.near[z][y] |= near;
                        }
                    }
                }
            }
        }
        Some(needs)
    }

    fn row(&self, y: usize, z: usize) -> (u8, u8) {
        (self.near[z][y], self.far[z][y])
    }
}
