//! Activate: brings voxels of open bricks that enter a sheet into camera space and to the records.
//!
//! A brick is opened when its first voxels come within reach of the current sheet: its needed voxels are put in
//! depth order. Each sheet then takes the next run of them, sixteen at a time, and leaves out voxels that miss the
//! tile or reach finished pixels only.

use fearless_simd::{f32x16, prelude::*, u32x16};
use splatvol_core::plan::{DepthOrder, SplatConstants};
use splatvol_core::visibility::BRICK_VOXELS;

use super::mask::OpenMask;
use super::records::{CAPACITY, Records};

/// A brick with voxels that have not entered a sheet yet.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OpenBrick {
    /// Which of the scratch memory's lists of voxels is its own.
    pub voxels: u32,
    /// Place of the next voxel in depth order, and its depth.
    pub next: u32,
    pub next_depth: f32,
    /// First voxel in camera space.
    pub corner: [f32; 3],
    /// Blocks of the ring that it can touch: x0, y0, x1, y1, ends included.
    pub blocks: [u8; 4],
}

/// A column of a brick's voxels; vectors may be read and stored behind the last one.
type Column = [f32; BRICK_VOXELS + 16];

/// The needed voxels of a brick, ascending in depth: offsets from the brick's first voxel in camera space, and values.
#[derive(Debug, Clone)]
pub(crate) struct OpenVoxels {
    x: Column,
    y: Column,
    /// Infinite behind the last one.
    depth: Column,
    value: Column,
    len: usize,
}

impl Default for OpenVoxels {
    fn default() -> Self {
        const ZERO: Column = [0.0; BRICK_VOXELS + 16];
        Self {
            x: ZERO,
            y: ZERO,
            depth: [f32::INFINITY; BRICK_VOXELS + 16],
            value: ZERO,
            len: 0,
        }
    }
}

impl OpenVoxels {
    /// Fills in a brick's values, x fastest; NaN where a voxel is not needed. `sorted` is memory for them in depth
    /// order.
    #[inline(always)]
    pub(crate) fn fill<S: Simd>(
        &mut self,
        simd: S,
        order: &DepthOrder,
        values: &[f32; BRICK_VOXELS],
        sorted: &mut [f32; BRICK_VOXELS],
    ) {
        for place in 0..BRICK_VOXELS {
            sorted[place] = values[usize::from(order.voxel[place]) % BRICK_VOXELS];
        }
        let mut len = 0;
        let mut place = 0;
        while place < BRICK_VOXELS {
            let value = f32x16::from_slice(simd, &sorted[place..place + 16]);
            let needed = value.simd_eq(value);
            let columns = [
                (&mut self.x, &order.x),
                (&mut self.y, &order.y),
                (&mut self.depth, &order.depth),
            ];
            let to = len..len + 16;
            for (column, from) in columns {
                f32x16::from_slice(simd, &from[place..place + 16])
                    .compress(needed)
                    .store_slice(&mut column[to.clone()]);
            }
            value.compress(needed).store_slice(&mut self.value[to]);
            len = (len + needed.to_bitmask().count_ones() as usize).min(BRICK_VOXELS);
            place += 16;
        }
        f32x16::splat(simd, f32::INFINITY).store_slice(&mut self.depth[len..len + 16]);
        self.len = len;
    }

    /// Voxels in all.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// Depth of a voxel beyond the brick's first; infinite behind the last one.
    pub(crate) fn depth(&self, place: usize) -> f32 {
        self.depth[place.min(BRICK_VOXELS)]
    }
}

/// Which voxels enter a sheet and touch the tile.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Window {
    /// Blocks along a footprint's edge.
    pub blocks: usize,
    /// Raster points from a footprint's first to the one that its powers count from.
    pub origin: f32,
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
    /// Voxels enter wherever they lie: splatting itself tests whether they touch the tile.
    pub anywhere: bool,
}

/// Moves a brick's voxels that enter a sheet to the records; returns the number of 16-voxel SIMD batches tested. Compiled
/// once, whatever the mode.
pub(crate) fn activate<S: Simd>(
    simd: S,
    constants: &SplatConstants,
    window: &Window,
    brick: (&mut OpenBrick, &OpenVoxels),
    mask: &OpenMask,
    records: &mut Records,
) -> u64 {
    simd.vectorize(
        #[inline(always)]
        || activate_sixteens(simd, constants, window, brick, mask, records),
    )
}

#[inline(always)]
fn activate_sixteens<S: Simd>(
    simd: S,
    constants: &SplatConstants,
    window: &Window,
    (brick, voxels): (&mut OpenBrick, &OpenVoxels),
    mask: &OpenMask,
    records: &mut Records,
) -> u64 {
    let [x0, y0, z0] = brick.corner;
    let first = f32x16::splat(simd, window.depths[0] - z0);
    let limit = f32x16::splat(simd, window.depths[1] - z0);
    // From a footprint's middle to its first point, less the nearest even one.
    let before = -(window.blocks as f32 + 0.5);
    let test = !window.anywhere && mask.any_finished && !mask.all(brick.blocks);
    let scale = f32x16::splat(simd, window.scale);
    let mut vectors = 0;
    loop {
        vectors += 1;
        let next = (brick.next as usize).min(BRICK_VOXELS);
        let depth = f32x16::from_slice(simd, &voxels.depth[next..next + 16]);
        let entering = depth.simd_le(limit);
        let count = entering.to_bitmask().count_ones();
        if count == 0 {
            return vectors;
        }
        brick.next += count;
        let value = f32x16::from_slice(simd, &voxels.value[next..next + 16]);
        let needed = entering & depth.simd_gt(first);
        let last = count < 16 || brick.next as usize >= voxels.len;
        if !needed.any_true() {
            if last {
                return vectors;
            }
            continue;
        }
        let x = f32x16::from_slice(simd, &voxels.x[next..next + 16]) + x0;
        let y = f32x16::from_slice(simd, &voxels.y[next..next + 16]) + y0;
        let z = depth + z0;
        let dz = window.depth - z;
        let [px, py] = constants.principal;
        let u = (dz * constants.slope[0] + x) * scale + px;
        let v = (dz * constants.slope[1] + y) * scale + py;
        // Whole footprints, with all their blocks: what a pixel gets must not depend on the tile.
        let (first_x, first_y) = (
            ((u + before) * 0.5).ceil() * 2.0,
            ((v + before) * 0.5).ceil() * 2.0,
        );
        let extent = (2 * window.blocks - 1) as f32;
        let touches = (first_x + extent).simd_ge(f32x16::splat(simd, window.low[0]))
            & first_x.simd_le(f32x16::splat(simd, window.high[0]))
            & (first_y + extent).simd_ge(f32x16::splat(simd, window.low[1]))
            & first_y.simd_le(f32x16::splat(simd, window.high[1]));
        let mut wanted = if window.anywhere { needed } else { needed & touches };
        let (column, row) = ((first_x - window.ring[0]) * 0.5, (first_y - window.ring[1]) * 0.5);
        let (blocks_x, blocks_y) = (column.to_int::<u32x16<S>>(), row.to_int::<u32x16<S>>());
        if test {
            wanted &= mask.reaches(simd, blocks_x, blocks_y);
        }
        let found = wanted.to_bitmask().count_ones() as usize;
        if found > 0 {
            let at = records.len.min(CAPACITY);
            let range = at..at + 16;
            x.compress(wanted).store_slice(&mut records.x[range.clone()]);
            y.compress(wanted).store_slice(&mut records.y[range.clone()]);
            z.compress(wanted).store_slice(&mut records.z[range.clone()]);
            value
                .compress(wanted)
                .store_slice(&mut records.value[range.clone()]);
            (px - first_x - window.origin)
                .compress(wanted)
                .store_slice(&mut records.origin_x[range.clone()]);
            (py - first_y - window.origin)
                .compress(wanted)
                .store_slice(&mut records.origin_y[range.clone()]);
            records.join(simd, wanted, column, row);
            blocks_x
                .compress(wanted)
                .store_slice(&mut records.column[range.clone()]);
            blocks_y.compress(wanted).store_slice(&mut records.row[range]);
            records.len = at + found;
        }
        if last {
            return vectors;
        }
    }
}
