//! Which pixels of a tile are still open, by blocks of 4 x 4: what lies behind finished ones is not splatted.
//!
//! The mask replaces huang2000's summed-area table (section 4.1). It is tested per brick and per voxel.

use fearless_simd::{f32x16, prelude::*, u32x16};

use super::shade::Canvas;

/// Pixels along a block's edge.
const BLOCK: usize = 4;
/// Blocks around the tile, where footprints' centres may lie.
const MARGIN: usize = 8;
/// Rows of the largest tile of 128 pixels, margins included, rounded up to a power of two.
const ROWS: usize = 64;

/// One bit per block, rows of words; block (0, 0) of the tile is bit `MARGIN` of row `MARGIN`.
#[derive(Debug, Clone)]
pub(crate) struct OpenMask {
    /// Blocks with open pixels.
    open: [u64; ROWS],
    /// Blocks from whose pixels a footprint reaches an open block.
    reached: [u64; ROWS],
    /// Blocks that a footprint reaches beyond its own.
    reach: usize,
    /// True once any block is finished.
    pub any_finished: bool,
}

impl Default for OpenMask {
    fn default() -> Self {
        Self {
            open: [0; ROWS],
            reached: [0; ROWS],
            reach: 0,
            any_finished: false,
        }
    }
}

impl OpenMask {
    /// All pixels of a tile are open; `reach`: of footprints around their centres, pixels.
    pub(crate) fn reset(&mut self, [width, height]: [usize; 2], reach: f32) {
        let (columns, rows) = (width.div_ceil(BLOCK), height.div_ceil(BLOCK));
        self.open = [0; ROWS];
        self.open[MARGIN..MARGIN + rows].fill(((1 << columns) - 1) << MARGIN);
        self.reach = ((reach / BLOCK as f32).ceil() as usize).max(1);
        self.dilate();
        self.any_finished = false;
    }

    fn dilate(&mut self) {
        if self.reach >= MARGIN {
            // Footprints reach across the margin: bricks are tested, voxels are not.
            self.reached = [u64::MAX; ROWS];
            return;
        }
        let mut wide = self.open;
        for _ in 0..self.reach {
            wide.iter_mut().for_each(|row| *row |= *row << 1 | *row >> 1);
        }
        self.reached = [0; ROWS];
        for (y, row) in self.reached.iter_mut().enumerate() {
            let (first, end) = (y.saturating_sub(self.reach), (y + self.reach + 1).min(ROWS));
            *row = wide[first..end].iter().fold(0, |all, row| all | row);
        }
    }

    /// Closes blocks all of whose pixels are finished.
    #[inline(always)]
    pub(crate) fn update<S: Simd>(&mut self, simd: S, canvas: &Canvas, height: usize, termination: f32) {
        let before = self.open;
        let mut alive = [0u64; ROWS];
        for (y, row) in canvas
            .transmittance
            .chunks_exact(canvas.pitch)
            .take(height)
            .enumerate()
        {
            let line = MARGIN + y / BLOCK;
            for (x, pixels) in row.chunks_exact(16).enumerate() {
                let shift = MARGIN + x * (16 / BLOCK);
                if before[line] & !alive[line] & 0xf << shift == 0 {
                    continue;
                }
                let open = f32x16::from_slice(simd, pixels)
                    .simd_ge(f32x16::splat(simd, termination))
                    .to_bitmask();
                let any = open | open >> 1 | open >> 2 | open >> 3;
                let blocks = any & 1 | any >> 3 & 2 | any >> 6 & 4 | any >> 9 & 8;
                alive[line] |= blocks << shift & before[line];
            }
        }
        if alive != before {
            self.open = alive;
            self.any_finished = true;
            self.dilate();
        }
    }

    /// Whether any of sixteen pixels beginning at (x, y), x a multiple of sixteen, is open.
    #[inline(always)]
    pub(crate) fn sixteen_open(&self, x: usize, y: usize) -> bool {
        self.open[(MARGIN + y / BLOCK) & (ROWS - 1)] >> (MARGIN + x / BLOCK) & 0xf != 0
    }

    /// True when the tile is finished.
    pub(crate) fn none_left(&self) -> bool {
        self.open == [0; ROWS]
    }

    /// Whether an open pixel lies within a rectangle (x0, y0, x1, y1, pixels of the tile, ends included).
    pub(crate) fn any(&self, rect: [f32; 4]) -> bool {
        let (rows, bits) = Self::blocks(rect);
        self.open[rows].iter().any(|row| row & bits != 0)
    }

    /// Whether all pixels within a rectangle are open.
    pub(crate) fn all(&self, rect: [f32; 4]) -> bool {
        let (rows, bits) = Self::blocks(rect);
        self.open[rows].iter().all(|row| row & bits == bits)
    }

    fn blocks([x0, y0, x1, y1]: [f32; 4]) -> (std::ops::RangeInclusive<usize>, u64) {
        let block = |pixel: f32| {
            ((pixel + (BLOCK * MARGIN) as f32).clamp(0.0, (BLOCK * ROWS - 1) as f32)) as usize / BLOCK
        };
        let (x0, x1) = (block(x0), block(x1));
        (block(y0)..=block(y1), (u64::MAX >> (63 - (x1 - x0))) << x0)
    }

    /// Blocks of pixels of the tile along one axis.
    #[inline(always)]
    pub(crate) fn block<S: Simd>(simd: S, pixel: f32x16<S>) -> u32x16<S> {
        let shifted = (pixel + (BLOCK * MARGIN) as f32).max(f32x16::splat(simd, 0.0)) * (1.0 / BLOCK as f32);
        shifted.to_int()
    }

    /// 1 where a footprint centred in a block reaches no open pixel, else 0.
    #[inline(always)]
    pub(crate) fn out_of_reach(&self, column: u32, row: u32) -> u64 {
        !self.reached[row as usize & (ROWS - 1)] >> (column & 63) & 1
    }
}
