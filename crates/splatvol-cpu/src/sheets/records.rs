//! Records: the voxels of a slab that enter a sheet, in columns, ready to be splatted.

use fearless_simd::{f32x16, mask32x16, prelude::*};

use super::ring::Area;
use super::sheet::Lanes16;
use super::splat::load;

/// Voxels buffered for splatting.
pub(crate) const CAPACITY: usize = 1024;

/// A column of the records: vectors may be stored behind the last one.
pub(crate) type Column<T> = [T; CAPACITY + 16];

/// Voxels of a slab, ready to be splatted.
#[derive(Debug)]
pub(crate) struct Records {
    pub len: usize,
    /// Camera space.
    pub x: Column<f32>,
    pub y: Column<f32>,
    pub z: Column<f32>,
    /// Coefficient, or another number that the mode's [`Payload`] interprets.
    pub value: Column<f32>,
    /// Raster coordinates of the principal point from the footprint's middle.
    pub origin_x: Column<f32>,
    pub origin_y: Column<f32>,
    /// First block of the footprint, and its row.
    pub column: Column<u32>,
    pub row: Column<u32>,
    /// First and last column and row of the footprints, and of their first blocks.
    low: [Lanes16; 2],
    high: [Lanes16; 2],
}

impl Default for Records {
    fn default() -> Self {
        const ZERO: Column<f32> = [0.0; CAPACITY + 16];
        Self {
            len: 0,
            x: ZERO,
            y: ZERO,
            z: ZERO,
            value: ZERO,
            origin_x: ZERO,
            origin_y: ZERO,
            column: [0; CAPACITY + 16],
            row: [0; CAPACITY + 16],
            low: [NONE_LOW; 2],
            high: [NONE_HIGH; 2],
        }
    }
}

const NONE_LOW: Lanes16 = Lanes16([f32::INFINITY; 16]);
const NONE_HIGH: Lanes16 = Lanes16([-1.0; 16]);

impl Records {
    /// Stores the first blocks of footprints that are added next.
    #[inline(always)]
    pub(crate) fn join<S: Simd>(&mut self, simd: S, which: mask32x16<S>, column: f32x16<S>, row: f32x16<S>) {
        let (low, high) = (f32x16::splat(simd, f32::INFINITY), f32x16::splat(simd, -1.0));
        for (axis, first) in [column, row].into_iter().enumerate() {
            let (at_least, at_most) = (load(simd, &self.low[axis]), load(simd, &self.high[axis]));
            at_least
                .min(which.select(first, low))
                .store_slice(&mut self.low[axis].0);
            at_most
                .max(which.select(first, high))
                .store_slice(&mut self.high[axis].0);
        }
    }

    /// Includes the first block of one of them.
    pub(crate) fn widen(&mut self, first: [u32; 2]) {
        for (axis, first) in first.into_iter().enumerate() {
            let (low, high) = (&mut self.low[axis].0[0], &mut self.high[axis].0[0]);
            (*low, *high) = (low.min(first as f32), high.max(first as f32));
        }
    }

    /// Blocks covered by the footprints; resets them.
    pub(crate) fn take_area(&mut self, size: usize) -> Area {
        let low = std::mem::replace(&mut self.low, [NONE_LOW; 2])
            .map(|l| l.0.into_iter().fold(f32::INFINITY, f32::min));
        let high =
            std::mem::replace(&mut self.high, [NONE_HIGH; 2]).map(|h| h.0.into_iter().fold(-1.0, f32::max));
        Area {
            x0: low[0] as usize,
            y0: low[1] as usize,
            x1: high[0] as usize + size,
            y1: high[1] as usize + size,
        }
    }
}
