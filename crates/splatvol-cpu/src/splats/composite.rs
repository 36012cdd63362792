//! Composite: a tile's splats, front to back, on blocks of 4 x 4 pixels, one SIMD vector each.
//!
//! `blend` defines the effect of a splat on a pixel. A block whose pixels have all ended is removed from the tile's
//! mask of blocks; a tile without blocks is finished.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use fearless_simd::{f32x16, prelude::*};

use super::blend::Blend;
use super::cover::{BATCH, BLOCK, BLOCKS, TILE, cover};
use super::project::ProjectedSplat;

/// Pixels of a block.
pub(crate) const LANES: usize = BLOCK * BLOCK;
/// Splats between two checks for cancellation.
const PATIENCE: usize = 256 * BATCH;
/// Positions of a block's pixels: rows of four.
const COLUMN: [f32; LANES] = [0., 1., 2., 3., 0., 1., 2., 3., 0., 1., 2., 3., 0., 1., 2., 3.];
const ROW: [f32; LANES] = [0., 0., 0., 0., 1., 1., 1., 1., 2., 2., 2., 2., 3., 3., 3., 3.];

/// Pixels of a block while splats are composited.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Block {
    /// Transmittance, negative where the pixel has ended; for line integrals, the optical depth so far.
    pub state: [f32; LANES],
    /// Premultiplied colour, and depth, weighted alike.
    pub sums: [[f32; LANES]; 4],
}

/// A thread's memory for a tile.
#[derive(Debug)]
pub(crate) struct Scratch {
    pub blocks: Box<[Block; BLOCKS * BLOCKS]>,
    batch: [ProjectedSplat; BATCH],
    masks: [u64; BATCH],
}

impl Default for Scratch {
    fn default() -> Self {
        Self {
            blocks: Box::new(
                [Block {
                    state: [0.0; LANES],
                    sums: [[0.0; LANES]; 4],
                }; BLOCKS * BLOCKS],
            ),
            batch: [ProjectedSplat::default(); BATCH],
            masks: [0; BATCH],
        }
    }
}

/// A tile's position among tiles, its blocks within the picture, and the cancellation flag.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place<'a> {
    pub tile: [usize; 2],
    pub blocks: u64,
    pub stop: &'a AtomicBool,
}

/// Composites the splats of a tile into the scratch's blocks.
#[inline(always)]
pub(crate) fn composite<S: Simd, B: Blend>(
    simd: S,
    blend: B,
    splats: &[ProjectedSplat],
    entries: &[AtomicU32],
    place: Place<'_>,
    scratch: &mut Scratch,
) {
    scratch.blocks.fill(B::EMPTY);
    let mut alive = place.blocks;
    for part in entries.chunks(PATIENCE) {
        for entries in part.chunks(BATCH) {
            for (splat, entry) in scratch.batch.iter_mut().zip(entries) {
                *splat = splats[entry.load(Ordering::Relaxed) as usize];
            }
            cover(simd, blend, &scratch.batch, place.tile, &mut scratch.masks);
            for (splat, mask) in scratch.batch.iter().zip(scratch.masks).take(entries.len()) {
                let mask = mask & alive;
                if mask != 0 {
                    alive &= !add(simd, blend, splat, mask, place.tile, &mut scratch.blocks);
                }
            }
            if alive == 0 {
                return;
            }
        }
        if place.stop.load(Ordering::Relaxed) {
            return;
        }
    }
}

/// Composites a splat behind the blocks of a mask; returns the finished ones.
#[inline(always)]
fn add<S: Simd, B: Blend>(
    simd: S,
    blend: B,
    splat: &ProjectedSplat,
    mut mask: u64,
    tile: [usize; 2],
    blocks: &mut [Block; BLOCKS * BLOCKS],
) -> u64 {
    let column = f32x16::simd_from(simd, COLUMN);
    let row = f32x16::simd_from(simd, ROW);
    let left = (tile[0] * TILE) as f32 + 0.5 - splat.centre[0];
    let top = (tile[1] * TILE) as f32 + 0.5 - splat.centre[1];
    let [a, b, c] = splat.conic;
    let mut finished = 0;
    while mask != 0 {
        let index = mask.trailing_zeros() as usize;
        mask &= mask - 1;
        let block = &mut blocks[index % (BLOCKS * BLOCKS)];
        let dx = column + (left + (BLOCK * (index % BLOCKS)) as f32);
        let dy = row + (top + (BLOCK * (index / BLOCKS)) as f32);
        let exponent = (dx * a + dy * b) * dx + (dy * dy * c + blend.offset(splat));
        if !blend.add(simd, splat, exponent, block) {
            finished |= 1 << index;
        }
    }
    finished
}
