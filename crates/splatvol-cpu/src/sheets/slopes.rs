//! Slopes: kernels and their derivatives along the rays, splatted side by side.
//!
//! Values along rays need only the gradient's part along the ray. A ray moves by t across per depth, and t is
//! affine on a plane: `t = t_0 + k d`, d the offset from a footprint's centre, where it is `t_0`. With
//! [`super::gradients`]' derivatives, Q the inverse of the footprint's covariance there and s the drift of its
//! centre per depth, a voxel's term is
//!
//! `c w (-(t_0 - s + k d) . Q d - dz / s_z^2)`:
//!
//! two sums instead of four, of products of columns and rows.

use std::f32::consts::LN_2;

use fearless_simd::{f32x16, prelude::*};
use splatvol_core::plan::SplatConstants;

use super::footprint::{Footprint, Voxel, accumulate};
use super::gradients::Centred;
use super::ring::Row;
use super::sheet::GroupShape;
use super::splat::{Offset, Payload, load};

/// A coefficient, with its footprint's slope along each pixel's ray.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slopes;

/// A voxel's slope at an offset of (x, y) raster points: `x (linear_x + xx x) + y (linear_y + yy y) + xy x y`, and
/// `depth` times the moment in depth.
struct Slope<S: Simd> {
    linear: [f32x16<S>; 2],
    xx: f32x16<S>,
    xy: f32x16<S>,
    yy: f32x16<S>,
    depth: f32,
}

impl<S: Simd> Slope<S> {
    /// `centre`: of the footprint, camera x and y.
    #[inline(always)]
    fn new(
        simd: S,
        (shape, constants): (&GroupShape, &SplatConstants),
        [centre_x, centre_y]: [f32x16<S>; 2],
    ) -> Self {
        let zero = f32x16::splat(simd, 0.0);
        let (depth, scale) = (load(simd, &shape.depth), load(simd, &shape.scale));
        // Before the eye there is no plane.
        let exists = depth.simd_gt(zero);
        let per_depth =
            f32x16::splat(simd, constants.per_depth) / exists.select(depth, f32x16::splat(simd, 1.0));
        let per_point = per_depth / scale;
        let [slope_x, slope_y] = constants.slope;
        let (across, down) = (centre_x * per_depth - slope_x, centre_y * per_depth - slope_y);
        // Per world length: -Q times raster points per world length.
        let xx = load(simd, &shape.xx) * scale * (2.0 * LN_2);
        let xy = load(simd, &shape.xy) * scale * LN_2;
        let yy = load(simd, &shape.yy) * scale * (2.0 * LN_2);
        Self {
            linear: [across * xx + down * xy, across * xy + down * yy],
            xx: xx * per_point,
            xy: xy * per_point * 2.0,
            yy: yy * per_point,
            depth: 2.0 * LN_2 * constants.depth_exponent,
        }
    }

    #[inline(always)]
    fn across(&self, x: f32x16<S>) -> f32x16<S> {
        (self.xx * x + self.linear[0]) * x
    }

    #[inline(always)]
    fn down(&self, y: f32x16<S>) -> f32x16<S> {
        (self.yy * y + self.linear[1]) * y
    }
}

impl Payload<2> for Slopes {
    type Footprint = Self;

    #[inline(always)]
    fn weights<S: Simd>(&self, _: S, value: f32, weight: f32x16<S>, peak: f32x16<S>) -> [f32x16<S>; 2] {
        [weight * (peak * value); 2]
    }

    #[inline(always)]
    fn in_block<S: Simd>(
        &self,
        simd: S,
        [weight, _]: &[f32x16<S>; 2],
        share: f32x16<S>,
        offset: &Offset<'_, S>,
    ) -> [f32x16<S>; 2] {
        let value = *weight * share;
        let slope = Slope::new(simd, (offset.shape, offset.constants), offset.centre);
        let [x, y] = offset.points;
        let along = slope.across(x) + slope.down(y) + slope.xy * x * y + offset.depth * slope.depth;
        [value, value * along]
    }
}

impl Footprint for Slopes {
    const WEIGHTED: bool = false;

    #[inline(always)]
    fn add<S: Simd, const CAPACITY: usize, const ELLIPSES: bool>(
        simd: S,
        voxel: &Voxel<'_, S, CAPACITY>,
        rings: &mut [&mut [Row]],
    ) {
        let Centred {
            centre,
            value: plain,
            in_depth,
            offsets: [column, row],
        } = voxel.centred::<ELLIPSES>(simd);
        let slope = Slope::new(simd, (voxel.shape, voxel.constants), centre);
        let in_depth = in_depth * slope.depth;
        let zero = f32x16::splat(simd, 0.0);
        let down = voxel.down::<ELLIPSES>(simd, f32x16::splat(simd, 1.0));
        // Columns and rows of the value, of the slope, and of the product of both offsets.
        let (mut across, mut rising, mut offsets) = ([zero; CAPACITY], [zero; CAPACITY], [zero; CAPACITY]);
        let (mut falling, mut places) = ([zero; CAPACITY], [zero; CAPACITY]);
        for b in 0..voxel.size {
            let step = voxel.steps.across[b];
            let (x, y) = (column + (2 * b) as f32, row + (2 * b) as f32);
            across[b] = step * plain;
            rising[b] = step * in_depth + across[b] * slope.across(x);
            falling[b] = down[b] * slope.down(y);
            if ELLIPSES {
                offsets[b] = across[b] * slope.xy * x;
                places[b] = down[b] * y;
            }
        }
        let [values, along] = rings else {
            return;
        };
        let (Some(values), Some(along)) = (voxel.rows(values), voxel.rows(along)) else {
            return;
        };
        let (size, columns) = (voxel.size, voxel.columns());
        let (across, rising, offsets) = (&across[..size], &rising[..size], &offsets[..size]);
        for r in 0..size {
            let values = &mut values[r].0[columns.clone()][..size];
            let along = &mut along[r].0[columns.clone()][..size];
            let stencil = &voxel.stencil.blocks[r][..size];
            for c in 0..size {
                if voxel.lacks::<ELLIPSES>(r, c) {
                    continue;
                }
                let mut value = across[c] * down[r];
                let mut rise = rising[c] * down[r] + across[c] * falling[r];
                if ELLIPSES {
                    let stencil = load(simd, &stencil[c]);
                    rise = (rise + offsets[c] * places[r]) * stencil;
                    value *= stencil;
                }
                accumulate(simd, value, &mut values[c]);
                accumulate(simd, rise, &mut along[c]);
            }
        }
    }
}
