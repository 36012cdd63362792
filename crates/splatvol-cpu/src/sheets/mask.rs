//! Open mask: the open pixels of a tile, and the footprints that reach one. Splats behind finished pixels are
//! skipped.
//!
//! The mask replaces huang2000's summed-area table (section 4.1). Pixels are bits. Rows of bits are shifted over
//! each other. This tells, for every first block at once, whether a footprint of n x n blocks touches an open
//! pixel, or a pixel that an open one's derivatives need. A voxel then tests one bit.

use fearless_simd::{mask32x16, prelude::*, u32x16};
use splatvol_core::plan::MAX_BLOCKS;

use super::canvas::Canvas;
use super::plane::HALO;
use super::ring::BLOCK_EDGE;
use super::upsample::RASTER_HALO;

/// Widest tile, pixels.
pub(crate) const MAX_EDGE: usize = 128;
/// Rows of blocks: the largest tile, with the largest footprint on both sides, and room for dilation.
const ROWS: usize = 104;
/// Words of a row of blocks.
const WORDS: usize = 4;
/// Words of all rows, rounded up to a power of two: indices are masked instead of checked.
const REACHED: usize = (ROWS * WORDS).next_power_of_two();

/// One bit per pixel, and per block of the ring.
#[derive(Debug, Clone)]
pub(crate) struct OpenMask {
    /// Open pixels of the tile, row by row.
    pixels: [u128; MAX_EDGE],
    /// Number of open pixels.
    open: usize,
    /// Octaves from raster points to pixels.
    octaves: u32,
    /// Pixels from the first raster point to the tile.
    phase: [usize; 2],
    /// Blocks of the ring that an open pixel's value or derivatives need.
    needed: [u128; ROWS],
    /// First blocks of footprints that reach a needed block, in words of 32.
    reached: [u32; REACHED],
    /// Blocks along the edge of the footprints for which `reached` was computed; 0 where it is out of date.
    size: usize,
    /// True once any pixel is finished.
    pub any_finished: bool,
}

impl Default for OpenMask {
    fn default() -> Self {
        Self {
            pixels: [0; MAX_EDGE],
            open: 0,
            octaves: 0,
            phase: [0; 2],
            needed: [0; ROWS],
            reached: [0; REACHED],
            size: 0,
            any_finished: false,
        }
    }
}

impl OpenMask {
    /// All pixels of a tile are open.
    pub(crate) fn reset(&mut self, [width, height]: [usize; 2]) {
        self.pixels = [0; MAX_EDGE];
        self.pixels[..height].fill(u128::MAX >> (MAX_EDGE - width));
        self.open = width * height;
        self.any_finished = false;
    }

    /// Closes the pixels that a canvas holds as finished.
    pub(crate) fn close_finished(&mut self, canvas: &Canvas, termination: f32) {
        for (pixel, sixteen) in canvas.transmittance.chunks_exact(16).enumerate() {
            let finished = |lane: usize| u16::from(sixteen[lane] < termination) << lane;
            let bits = (0..16).fold(0, |bits, lane| bits | finished(lane));
            if bits != 0 {
                self.finish(16 * pixel % canvas.pitch, 16 * pixel / canvas.pitch, bits);
            }
        }
    }

    /// A raster point every `step` pixels, a power of two, the first of them `phase` pixels before the tile.
    pub(crate) fn set_raster(&mut self, step: usize, phase: [usize; 2]) {
        self.octaves = step.ilog2();
        self.phase = phase;
        self.size = 0;
        self.find_needed();
    }

    /// Closes pixels x + i of row y where bit i is set.
    #[inline(always)]
    pub(crate) fn finish(&mut self, x: usize, y: usize, bits: u16) {
        let row = &mut self.pixels[y];
        let closed = *row & u128::from(bits) << x;
        *row ^= closed;
        self.open -= closed.count_ones() as usize;
        self.any_finished = true;
        self.size = 0;
    }

    /// Which of sixteen pixels beginning at (x, y) are open.
    #[inline(always)]
    pub(crate) fn sixteen(&self, x: usize, y: usize) -> u16 {
        (self.pixels[y] >> x) as u16
    }

    /// True when the tile is finished.
    pub(crate) fn none_left(&self) -> bool {
        self.open == 0
    }

    /// Updates `reached` for footprints of `size` x `size` blocks.
    pub(crate) fn refresh(&mut self, size: usize) {
        if self.size == size {
            return;
        }
        if self.size == 0 && self.any_finished {
            self.find_needed();
        }
        self.size = size;
        // Bit by bit and row by row: all blocks from a footprint's first to its last.
        let mut wide = self.needed;
        for row in &mut wide {
            for by in doublings(size) {
                *row |= *row >> by;
            }
        }
        for by in doublings(size) {
            for row in 0..ROWS - by {
                wide[row] |= wide[row + by];
            }
        }
        for (words, row) in self.reached.chunks_exact_mut(WORDS).zip(&wide) {
            for (word, bits) in words.iter_mut().enumerate() {
                *bits = (row >> (32 * word)) as u32;
            }
        }
    }

    /// Blocks that open pixels need.
    fn find_needed(&mut self) {
        self.needed = [0; ROWS];
        if self.octaves == 0 {
            self.find_needed_pixels();
        } else {
            self.find_needed_points();
        }
    }

    /// Marks the open pixels and the pixels beside them.
    fn find_needed_pixels(&mut self) {
        const FIRST: usize = MAX_BLOCKS + HALO / BLOCK_EDGE;
        for (y, &row) in self.pixels.iter().enumerate().filter(|(_, row)| **row != 0) {
            let (even, odd) = (u128::from(every_other(row)), u128::from(every_other(row >> 1)));
            let blocks = (even | odd) << FIRST | even << (FIRST - 1) | odd << (FIRST + 1);
            let at = FIRST + y / BLOCK_EDGE;
            self.needed[at] |= blocks;
            self.needed[if y % BLOCK_EDGE == 0 { at - 1 } else { at + 1 }] |= blocks;
        }
    }

    /// Marks the coefficients that reach an open pixel or the pixels beside it: between raster points i and i + 1, those
    /// from i - 3 to i + 4.
    fn find_needed_points(&mut self) {
        const FIRST: usize = MAX_BLOCKS + RASTER_HALO / BLOCK_EDGE;
        for (y, &row) in self.pixels.iter().enumerate().filter(|(_, row)| **row != 0) {
            let blocks = self.blocks_of(row) << FIRST;
            let blocks = blocks | blocks >> 1 | blocks >> 2 | blocks << 1 | blocks << 2;
            let at = FIRST + ((y + self.phase[1]) >> (self.octaves + 1));
            for row in &mut self.needed[at - 2..=at + 2] {
                *row |= blocks;
            }
        }
    }

    /// Blocks of raster points that begin at or before the open pixels of a row.
    fn blocks_of(&self, row: u128) -> u128 {
        let octaves = self.octaves + 1;
        if self.phase[0] == 0 && octaves <= MAX_EDGE.ilog2() {
            let mut points = row;
            for _ in 0..octaves {
                points = u128::from(every_other(points | points >> 1));
            }
            return points;
        }
        let mut blocks = 0;
        let mut left = row;
        while left != 0 {
            let block = (left.trailing_zeros() as usize + self.phase[0]) >> octaves;
            blocks |= 1 << block;
            let end = ((block + 1) << octaves) - self.phase[0];
            left &= u128::MAX.checked_shl(end as u32).unwrap_or(0);
        }
        blocks
    }

    /// Whether a needed block lies within a rectangle of blocks of the ring (ends included).
    pub(crate) fn any(&self, blocks: [u8; 4]) -> bool {
        let (rows, bits) = rows_and_bits(blocks);
        let mut any = 0;
        for row in &self.needed[rows] {
            any |= row & bits;
        }
        any != 0
    }

    /// Whether all blocks within a rectangle are needed.
    pub(crate) fn all(&self, blocks: [u8; 4]) -> bool {
        let (rows, bits) = rows_and_bits(blocks);
        let mut all = bits;
        for row in &self.needed[rows] {
            all &= row;
        }
        all == bits
    }

    /// Which of sixteen footprints of [`OpenMask::refresh`]'s size, with these first blocks, reach a needed block. Blocks
    /// outside the ring say nothing.
    #[inline(always)]
    pub(crate) fn reaches<S: Simd>(&self, simd: S, columns: u32x16<S>, rows: u32x16<S>) -> mask32x16<S> {
        let places = rows * WORDS as u32 + (columns >> 5);
        let places = places.as_slice();
        let mut words = [0; 16];
        for lane in 0..16 {
            words[lane] = self.reached[places[lane] as usize % REACHED];
        }
        let bits = u32x16::from_slice(simd, &words) >> (columns & 31) & 1;
        bits.simd_gt(u32x16::splat(simd, 0))
    }
}

fn rows_and_bits([x0, y0, x1, y1]: [u8; 4]) -> (std::ops::RangeInclusive<usize>, u128) {
    let bits = (u128::MAX >> (127 - (x1 - x0).min(127))) << x0.min(127);
    (
        usize::from(y0).min(ROWS - 1)..=usize::from(y1).min(ROWS - 1),
        bits,
    )
}

/// Shifts that unite `size` neighbours.
fn doublings(size: usize) -> impl Iterator<Item = usize> {
    let shift = move |&span: &usize| (span < size).then(|| span + span.min(size - span));
    std::iter::successors(Some(1), shift)
        .take_while(move |&span| span < size)
        .map(move |span| span.min(size - span))
}

/// Every other bit, beginning with the first, packed together.
fn every_other(bits: u128) -> u64 {
    let half = |bits: u64| {
        let mut b = bits & 0x5555_5555_5555_5555;
        b = (b | b >> 1) & 0x3333_3333_3333_3333;
        b = (b | b >> 2) & 0x0f0f_0f0f_0f0f_0f0f;
        b = (b | b >> 4) & 0x00ff_00ff_00ff_00ff;
        b = (b | b >> 8) & 0x0000_ffff_0000_ffff;
        (b | b >> 16) & 0xffff_ffff
    };
    half(bits as u64) | half((bits >> 64) as u64) << 32
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};

    use super::*;

    /// Whether a footprint touches, by looking at every pixel.
    fn touches(open: &dyn Fn(i32, i32) -> bool, step: i32, column: i32, row: i32, size: i32) -> bool {
        let (halo, before, after) = if step == 1 {
            (HALO as i32, 1, 1)
        } else {
            (RASTER_HALO as i32, 3, 4)
        };
        let first = |block: i32| 2 * block - 2 * MAX_BLOCKS as i32 - halo;
        let points = |block: i32| first(block)..first(block) + 2 * size;
        (0..128).any(|y| {
            let rows = y / step - before..=y / step + after;
            points(row).any(|point| rows.contains(&point))
                && (0..128).any(|x| {
                    let columns = x / step - before..=x / step + after;
                    open(x, y) && points(column).any(|point| columns.contains(&point))
                })
        })
    }

    /// Which of the footprints from a first block on along its row reach a needed block.
    #[inline(always)]
    fn reached<S: Simd>(simd: S, mask: &OpenMask, [column, row]: [usize; 2]) -> u64 {
        let columns = std::array::from_fn(|lane| (column + lane) as u32);
        let columns = u32x16::from_slice(simd, &columns as &[u32; 16]);
        mask.reaches(simd, columns, u32x16::splat(simd, row as u32))
            .to_bitmask()
    }

    #[test]
    fn footprints_that_reach_an_open_pixel_are_never_left_out() {
        for step in [1usize, 2, 8] {
            let mut mask = OpenMask::default();
            mask.reset([128, 96]);
            mask.set_raster(step, [0; 2]);
            let left = [(0, 0), (127, 3), (64, 50), (65, 51), (17, 95)];
            for y in 0..96 {
                for x in (0..128).step_by(16) {
                    let bits = (0..16).filter(|i| !left.contains(&(x + i, y)));
                    mask.finish(x, y, bits.fold(0, |bits, i| bits | 1 << i));
                }
            }
            let open = |x: i32, y: i32| left.contains(&(x as usize, y as usize));
            let mut spared = 0;
            for size in [2usize, 3, 5, 16] {
                mask.refresh(size);
                for row in (0..97 - size).step_by(3) {
                    let mut sixteen = 0;
                    for column in 0..97 - size {
                        let place = (column as i32, row as i32);
                        if column % 16 == 0 {
                            sixteen = dispatch!(Level::new(), simd => reached(simd, &mask, [column, row]));
                        }
                        let reaches = sixteen >> (column % 16) & 1 != 0;
                        let touches = touches(&open, step as i32, place.0, place.1, size as i32);
                        assert!(reaches || !touches, "step {step} size {size} at {place:?}");
                        spared += usize::from(!reaches);
                        // Exact where pixels are splatted directly.
                        assert!(step > 1 || reaches == touches, "size {size} at {place:?}");
                    }
                }
            }
            assert!(spared > 1000, "step {step}: {spared}");
        }
    }

    #[test]
    fn a_tile_is_done_when_all_its_pixels_are() {
        let mut mask = OpenMask::default();
        mask.reset([20, 2]);
        mask.set_raster(1, [0; 2]);
        for (x, y, bits) in [(0, 0, u16::MAX), (16, 0, 0xf), (0, 1, u16::MAX), (16, 1, 7)] {
            mask.finish(x, y, bits);
            assert!(!mask.none_left());
        }
        assert_eq!(mask.sixteen(16, 1), 8);
        mask.finish(16, 1, u16::MAX);
        assert!(mask.none_left());
    }
}
