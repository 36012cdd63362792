//! Gradients: kernels and their derivatives, splatted side by side.
//!
//! A footprint `w` on a sheet has the derivatives `-Q d w`, d the offset from its centre, and `-dz / s^2 w` along
//! depth. So four sums give the value and gradient of a field exactly: `S = sum c w`, `sum c w dx`, `sum c w dy`
//! and `sum c w dz`. Offsets are counted from each footprint's own centre: sums of coordinates from another origin
//! would lose digits in the difference, and depend on the tile's place. The profile in depth is not windowed, so
//! that its derivative is that of value and gradient alike.

use fearless_simd::{f32x16, prelude::*};

use super::footprint::{Footprint, Voxel, accumulate};
use super::ring::Row;
use super::splat::{COLUMN, Offset, Payload, ROW, load, origin_point};

/// A voxel's footprints on four sheets about their own centres, for the sums of its derivatives.
pub(crate) struct Centred<S: Simd> {
    /// Centres, camera x and y.
    pub centre: [f32x16<S>; 2],
    /// Value at the raster point that powers count from.
    pub value: f32x16<S>,
    /// The same without the window in depth, whose slope no derivative has, times the distance in depth.
    pub in_depth: f32x16<S>,
    /// Offsets of the first block's columns and rows of points from the centre, raster points.
    pub offsets: [f32x16<S>; 2],
}

impl<S: Simd, const CAPACITY: usize> Voxel<'_, S, CAPACITY> {
    /// The footprints about their own centres.
    #[inline(always)]
    pub(crate) fn centred<const ELLIPSES: bool>(&self, simd: S) -> Centred<S> {
        let (records, n) = (self.records, self.index);
        let scale = load(simd, &self.shape.scale);
        let dz = load(simd, &self.shape.depth) - records.z[n];
        let [slope_x, slope_y] = self.constants.slope;
        let (x, y) = (dz * slope_x + records.x[n], dz * slope_y + records.y[n]);
        let (u, v) = (x * scale + records.origin_x[n], y * scale + records.origin_y[n]);
        let value = self.lateral.combine(self.lateral) * (load(simd, &self.shape.peak) * records.value[n]);
        let zero = f32x16::splat(simd, 0.0);
        let profile = self.depth.combine(self.depth);
        let windowed = (profile - self.constants.depth_edge).max(zero);
        let first = origin_point(self.size, ELLIPSES);
        Centred {
            centre: [x, y],
            value: value * windowed,
            in_depth: windowed.simd_gt(zero).select(value * profile * dz, zero),
            offsets: [
                f32x16::from_slice(simd, &COLUMN) - first - u,
                f32x16::from_slice(simd, &ROW) - first - v,
            ],
        }
    }
}

/// A coefficient, with the offsets of each pixel from its footprint's centre.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moments;

impl Payload<4> for Moments {
    type Footprint = Self;

    #[inline(always)]
    fn weights<S: Simd>(&self, _: S, value: f32, weight: f32x16<S>, peak: f32x16<S>) -> [f32x16<S>; 4] {
        [weight * (peak * value); 4]
    }

    #[inline(always)]
    fn in_block<S: Simd>(
        &self,
        _: S,
        [weight, ..]: &[f32x16<S>; 4],
        share: f32x16<S>,
        offset: &Offset<'_, S>,
    ) -> [f32x16<S>; 4] {
        let value = *weight * share;
        let [x, y] = offset.points;
        [value, value * x, value * y, value * offset.depth]
    }
}

impl Footprint for Moments {
    const WEIGHTED: bool = false;

    #[inline(always)]
    fn add<S: Simd, const CAPACITY: usize, const ELLIPSES: bool>(
        simd: S,
        voxel: &Voxel<'_, S, CAPACITY>,
        rings: &mut [&mut [Row]],
    ) {
        let Centred {
            value: plain,
            in_depth: along,
            offsets: [column, row],
            ..
        } = voxel.centred::<ELLIPSES>(simd);
        let zero = f32x16::splat(simd, 0.0);
        let down = voxel.down::<ELLIPSES>(simd, f32x16::splat(simd, 1.0));
        let mut across = [[zero; CAPACITY]; 3];
        let mut slopes = [zero; CAPACITY];
        for b in 0..voxel.size {
            let step = voxel.steps.across[b];
            across[0][b] = step * plain;
            across[1][b] = across[0][b] * (column + (2 * b) as f32);
            across[2][b] = step * along;
            slopes[b] = down[b] * (row + (2 * b) as f32);
        }
        let [values, along_x, along_y, along_z] = rings else {
            return;
        };
        let (Some(values), Some(along_x), Some(along_y), Some(along_z)) = (
            voxel.rows(values),
            voxel.rows(along_x),
            voxel.rows(along_y),
            voxel.rows(along_z),
        ) else {
            return;
        };
        // All sums of a block in turn: four streams of stores keep a processor busier than one after the other.
        let (size, columns) = (voxel.size, voxel.columns());
        let across = across.each_ref().map(|across| &across[..size]);
        for r in 0..size {
            let values = &mut values[r].0[columns.clone()][..size];
            let along_x = &mut along_x[r].0[columns.clone()][..size];
            let along_y = &mut along_y[r].0[columns.clone()][..size];
            let along_z = &mut along_z[r].0[columns.clone()][..size];
            let stencil = &voxel.stencil.blocks[r][..size];
            for c in 0..size {
                if voxel.lacks::<ELLIPSES>(r, c) {
                    continue;
                }
                let [value, moment, in_depth] = if ELLIPSES {
                    let stencil = load(simd, &stencil[c]);
                    [
                        across[0][c] * stencil,
                        across[1][c] * stencil,
                        across[2][c] * stencil,
                    ]
                } else {
                    [across[0][c], across[1][c], across[2][c]]
                };
                accumulate(simd, value * down[r], &mut values[c]);
                accumulate(simd, moment * down[r], &mut along_x[c]);
                accumulate(simd, value * slopes[r], &mut along_y[c]);
                accumulate(simd, in_depth * down[r], &mut along_z[c]);
            }
        }
    }
}
