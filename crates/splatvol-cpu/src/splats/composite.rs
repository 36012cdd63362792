//! Composite: a tile's splats, front to back, on blocks of 4 x 4 pixels, one SIMD vector each.
//!
//! ```text
//! alpha = min(0.99, 2^(log2 o + conic . (dx^2, dx dy, dy^2))),  T' = T (1 - alpha)
//! a pixel ends, without the splat, where T' < 1e-4
//! ```
//!
//! A pixel that has ended keeps its transmittance with the sign turned. A block whose pixels have all ended is taken out of
//! the tile's mask of blocks, and a tile without blocks is finished.

use std::sync::atomic::{AtomicU32, Ordering};

use fearless_simd::{f32x16, prelude::*};

use super::bin::TILE;
use super::cover::{BATCH, BLOCK, BLOCKS, cover};
use super::project::{LOG2_255, Splat};
use crate::simd::math::exp2_quick;

/// Pixels of a block.
pub(crate) const LANES: usize = BLOCK * BLOCK;
/// Opacity is cut here.
const MOST_ALPHA: f32 = 0.99;
/// Pixels end before their transmittance falls below.
const LEAST_TRANSMITTANCE: f32 = 1e-4;
/// Positions of a block's pixels: rows of four.
const COLUMN: [f32; LANES] = [0., 1., 2., 3., 0., 1., 2., 3., 0., 1., 2., 3., 0., 1., 2., 3.];
const ROW: [f32; LANES] = [0., 0., 0., 0., 1., 1., 1., 1., 2., 2., 2., 2., 3., 3., 3., 3.];

/// Pixels of a block while splats are composited.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Block {
    /// Transmittance; negative where the pixel has ended.
    pub through: [f32; LANES],
    /// Premultiplied display colour, and depth times opacity.
    pub sums: [[f32; LANES]; 4],
}

impl Block {
    const EMPTY: Self = Self {
        through: [1.0; LANES],
        sums: [[0.0; LANES]; 4],
    };
}

/// What a thread needs for a tile.
#[derive(Debug)]
pub(crate) struct Scratch {
    pub blocks: Box<[Block; BLOCKS * BLOCKS]>,
    batch: [Splat; BATCH],
    masks: [u64; BATCH],
}

impl Default for Scratch {
    fn default() -> Self {
        Self {
            blocks: Box::new([Block::EMPTY; BLOCKS * BLOCKS]),
            batch: [Splat::default(); BATCH],
            masks: [0; BATCH],
        }
    }
}

/// Composites the splats of a tile into the scratch's blocks, of which `alive` lie in the picture.
#[inline(always)]
pub(crate) fn composite<S: Simd>(
    simd: S,
    splats: &[Splat],
    entries: &[AtomicU32],
    tile: [usize; 2],
    mut alive: u64,
    scratch: &mut Scratch,
) {
    scratch.blocks.fill(Block::EMPTY);
    for entries in entries.chunks(BATCH) {
        for (splat, entry) in scratch.batch.iter_mut().zip(entries) {
            *splat = splats[entry.load(Ordering::Relaxed) as usize];
        }
        cover(simd, &scratch.batch, tile, &mut scratch.masks);
        for (splat, mask) in scratch.batch.iter().zip(scratch.masks).take(entries.len()) {
            let mask = mask & alive;
            if mask != 0 {
                alive &= !add(simd, splat, mask, tile, &mut scratch.blocks);
            }
        }
        if alive == 0 {
            return;
        }
    }
}

/// Puts a splat behind the blocks of a mask; returns those that are finished.
#[inline(always)]
fn add<S: Simd>(
    simd: S,
    splat: &Splat,
    mut mask: u64,
    tile: [usize; 2],
    blocks: &mut [Block; BLOCKS * BLOCKS],
) -> u64 {
    let column = f32x16::simd_from(simd, COLUMN);
    let row = f32x16::simd_from(simd, ROW);
    let left = (tile[0] * TILE) as f32 + 0.5 - splat.centre[0];
    let top = (tile[1] * TILE) as f32 + 0.5 - splat.centre[1];
    let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
    let most = f32x16::splat(simd, MOST_ALPHA);
    let least = f32x16::splat(simd, LEAST_TRANSMITTANCE);
    let threshold = f32x16::splat(simd, -LOG2_255);
    let [a, b, c] = splat.conic;
    let values = [splat.color[0], splat.color[1], splat.color[2], splat.depth];
    let mut finished = 0;
    while mask != 0 {
        let index = mask.trailing_zeros() as usize;
        mask &= mask - 1;
        let block = &mut blocks[index % (BLOCKS * BLOCKS)];
        let dx = column + (left + (BLOCK * (index % BLOCKS)) as f32);
        let dy = row + (top + (BLOCK * (index / BLOCKS)) as f32);
        let exponent = (dx * a + dy * b) * dx + (dy * dy * c + splat.log2_opacity);
        let counts = exponent.simd_ge(threshold);
        if !counts.any_true() {
            continue;
        }
        let alpha = exp2_quick(simd, exponent.max(threshold)).min(most);
        let alpha = counts.select(alpha, zero);
        let through = f32x16::simd_from(simd, block.through);
        let next = through * (one - alpha);
        let goes_on = next.simd_ge(least);
        let share = goes_on.select(through * alpha, zero);
        let ended = -through.abs();
        block.through = goes_on.select(next, ended).to_array();
        for (sum, value) in block.sums.iter_mut().zip(values) {
            *sum = (f32x16::simd_from(simd, *sum) + share * value).to_array();
        }
        if !goes_on.any_true() {
            finished |= 1 << index;
        }
    }
    finished
}
