//! Activate: voxels of open bricks that enter a sheet, into camera space and to the records.
//!
//! A brick is opened when its first voxels come within reach of the current sheet: its values are put in depth order.
//! Each sheet then takes the next run of them, sixteen at a time, and leaves out what is not needed, what does not touch
//! the tile, and what only reaches finished pixels.

use fearless_simd::{f32x16, mask32x16, prelude::*, u32x16};
use splatvol_core::visibility::BRICK_VOXELS;

use super::mask::OpenMask;
use super::order::DepthOrder;
use super::splat::{CAPACITY, Records, SplatConstants, middle_block};

/// A brick some of whose voxels are still to come.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OpenBrick {
    /// Which of the scratch memory's value lists is its own.
    pub values: u32,
    /// Place of the next voxel in depth order.
    pub next: u32,
    /// First voxel in camera space.
    pub corner: [f32; 3],
    /// Pixels of the tile that it can touch: x0, y0, x1, y1.
    pub reach: [f32; 4],
}

/// A brick's values in depth order.
pub(crate) type SortedValues = [f32; BRICK_VOXELS + 16];

/// Which voxels enter a sheet and touch the tile.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Window {
    /// Blocks along a footprint's edge.
    pub blocks: usize,
    /// Depths between which voxels enter.
    pub depths: [f32; 2],
    /// The middle sheet's depth and scale.
    pub depth: f32,
    pub scale: f32,
    /// First and last raster points that matter, x and y.
    pub low: [f32; 2],
    pub high: [f32; 2],
    /// Raster point of the ring's first block, x and y.
    pub ring: [f32; 2],
    /// Raster point of the tile's first pixel, and pixels per raster point.
    pub tile: [f32; 2],
    pub step: f32,
}

/// Moves a brick's voxels that enter a sheet to the records.
#[inline(always)]
pub(crate) fn activate<S: Simd>(
    simd: S,
    (order, constants): (&DepthOrder, &SplatConstants),
    window: &Window,
    (brick, values): (&mut OpenBrick, &SortedValues),
    mask: &OpenMask,
    records: &mut Records,
) -> u32 {
    let mut tested = 0;
    let [x0, y0, z0] = brick.corner;
    let first = f32x16::splat(simd, window.depths[0] - z0);
    let limit = f32x16::splat(simd, window.depths[1] - z0);
    // From a footprint's middle to its first point, less the nearest even one.
    let before = -(window.blocks as f32 + 0.5);
    let test = mask.any_finished && !mask.all(brick.reach);
    let scale = f32x16::splat(simd, window.scale);
    loop {
        let next = (brick.next as usize).min(BRICK_VOXELS);
        let depth = f32x16::from_slice(simd, &order.depth[next..next + 16]);
        let entering = depth.simd_le(limit);
        let count = entering.to_bitmask().count_ones();
        if count == 0 {
            return tested;
        }
        brick.next += count;
        tested += count;
        let value = f32x16::from_slice(simd, &values[next..next + 16]);
        let needed = entering & value.simd_eq(value) & depth.simd_ge(first);
        let last = count < 16 || brick.next as usize >= BRICK_VOXELS;
        if !needed.any_true() {
            if last {
                return tested;
            }
            continue;
        }
        let x = f32x16::from_slice(simd, &order.x[next..next + 16]) + x0;
        let y = f32x16::from_slice(simd, &order.y[next..next + 16]) + y0;
        let z = depth + z0;
        let dz = window.depth - z;
        let [px, py] = constants.principal;
        let u = dz
            .mul_add(constants.slope[0], x)
            .mul_add(scale, f32x16::splat(simd, px));
        let v = dz
            .mul_add(constants.slope[1], y)
            .mul_add(scale, f32x16::splat(simd, py));
        // Whole footprints, with all their blocks: what a pixel gets must not depend on the tile.
        let (column, row) = (
            ((u + before) * 0.5).ceil() * 2.0,
            ((v + before) * 0.5).ceil() * 2.0,
        );
        let extent = (2 * window.blocks - 1) as f32;
        let mut wanted = needed
            & (column + extent).simd_ge(f32x16::splat(simd, window.low[0]))
            & column.simd_le(f32x16::splat(simd, window.high[0]))
            & (row + extent).simd_ge(f32x16::splat(simd, window.low[1]))
            & row.simd_le(f32x16::splat(simd, window.high[1]));
        if test {
            let (block_x, block_y) = (
                OpenMask::block(simd, (u - window.tile[0]) * window.step),
                OpenMask::block(simd, (v - window.tile[1]) * window.step),
            );
            let (block_x, block_y) = (block_x.as_slice(), block_y.as_slice());
            let mut bits = wanted.to_bitmask();
            let mut left = bits;
            while left != 0 {
                let lane = left.trailing_zeros() as usize & 15;
                left &= left - 1;
                bits &= !(mask.out_of_reach(block_x[lane], block_y[lane]) << lane);
            }
            wanted = mask32x16::from_bitmask(simd, bits);
        }
        let found = wanted.to_bitmask().count_ones() as usize;
        if found > 0 {
            let middle = 2.0 * middle_block(window.blocks) as f32;
            let at = records.len.min(CAPACITY);
            let range = at..at + 16;
            x.compress(wanted).store_slice(&mut records.x[range.clone()]);
            y.compress(wanted).store_slice(&mut records.y[range.clone()]);
            z.compress(wanted).store_slice(&mut records.z[range.clone()]);
            value
                .compress(wanted)
                .store_slice(&mut records.value[range.clone()]);
            (px - column - middle)
                .compress(wanted)
                .store_slice(&mut records.origin_x[range.clone()]);
            (py - row - middle)
                .compress(wanted)
                .store_slice(&mut records.origin_y[range.clone()]);
            let (column, row) = ((column - window.ring[0]) * 0.5, (row - window.ring[1]) * 0.5);
            records.join(simd, wanted, column, row);
            column
                .to_int::<u32x16<S>>()
                .compress(wanted)
                .store_slice(&mut records.column[range.clone()]);
            row.to_int::<u32x16<S>>()
                .compress(wanted)
                .store_slice(&mut records.row[range]);
            records.len = at + found;
        }
        if last {
            return tested;
        }
    }
}
