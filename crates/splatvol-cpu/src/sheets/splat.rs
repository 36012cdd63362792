//! Splat: voxels into the ring of sheets, each once into all the sheets that it reaches.
//!
//! Let `u, v` be the offset of the footprint's centre from a raster point in its middle, and `i, j` whole raster
//! points from there. A Gaussian footprint of exponents `a, c, b` (xx, xy, yy, negative, to base 2) is
//!
//! `2^(a (i-u)^2 + c (i-u)(j-v) + b (j-v)^2) = C(i, j) p^i q^j 2^(a u^2 + c u v + b v^2)`,
//! `C(i, j) = 2^(a i^2 + c i j + b j^2)`, `p = 2^(-2 a u - c v)`, `q = 2^(-2 b v - c u)`:
//!
//! C is the same for all voxels of a slab, and the powers follow by multiplication. So a voxel costs one
//! vector exponential whatever its size and shape, and every weight is exact: there is no table of phases and no
//! rounding of positions. Where C is a product of a column and a row (radial kernels) each vector of pixels costs
//! one multiply-add, otherwise one more multiplication.
//!
//! Round footprints count i and j from their first block. For an elongated footprint the powers would overflow
//! there; it counts from the middle block, and also needs the inverses of `p^2` and `q^2`. On the sheets of a group its
//! centres lie beside each other, along the kernel's slope, by the same s for all voxels: C is taken at `(i, j) - s`, `(u, v)`
//! is what remains of the centre's offset, and the last factor becomes `2^(q(u, v) + B((u, v), s))`, q the exponent as above and
//! B twice its bilinear form. So powers stay as small as u and v.

use std::ops::Range;

use fearless_simd::{f32x8, f32x16, prelude::*};
use splatvol_core::plan::{MAX_BLOCKS, SplatConstants};

use super::footprint::{Footprint, Scaled, Steps, Voxel};
use super::needed::{Footprints, Needed};
use super::records::{CAPACITY, Records};
use super::ring::{PITCH, Row};
use super::sheet::{GroupShape, Lanes16};
use super::tile::MAX_CHANNELS;
use crate::simd::math::{LEAST_NORMAL, exp2, exp2_quick};

/// The footprint of a voxel in the middle of a raster point: C(i, j) block by block, or its columns and rows.
#[derive(Debug)]
pub(crate) struct Stencil {
    pub blocks: [[Lanes16; MAX_BLOCKS]; MAX_BLOCKS],
    pub(super) columns: [Lanes16; MAX_BLOCKS],
    pub(super) rows: [Lanes16; MAX_BLOCKS],
    /// The blocks that are added.
    pub needed: Needed,
    /// Depth at which the square of blocks lies around the voxel's centre.
    anchor: f32,
    /// From the raster point that powers count from to the one around which centres lie at that depth.
    beside: f32,
}

impl Default for Stencil {
    fn default() -> Self {
        let row = [Lanes16::default(); MAX_BLOCKS];
        Self {
            blocks: [row; MAX_BLOCKS],
            columns: row,
            rows: row,
            needed: Needed::default(),
            anchor: 0.0,
            beside: 0.0,
        }
    }
}

#[inline(always)]
pub(crate) fn load<S: Simd>(simd: S, lanes: &Lanes16) -> f32x16<S> {
    f32x16::from_slice(simd, &lanes.0)
}

/// Each lane's column and row in a block.
pub(crate) const COLUMN: [f32; 16] = [
    0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0,
];
pub(crate) const ROW: [f32; 16] = [
    0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0,
];

/// Exponents from which `exp2` is exact.
const LEAST: f32 = -126.0;

impl Stencil {
    /// Stencil of a slab's footprints of `size` blocks.
    #[inline(always)]
    pub(crate) fn prepare<S: Simd>(
        &mut self,
        simd: S,
        shape: &GroupShape,
        footprints: &Footprints,
        ellipses: bool,
    ) {
        let size = footprints.size;
        self.anchor = footprints.anchor;
        self.needed = match ellipses {
            true => Needed::new(shape, footprints),
            false => Needed::all(size),
        };
        let (xx, xy, yy) = (
            load(simd, &shape.xx),
            load(simd, &shape.xy),
            load(simd, &shape.yy),
        );
        if !ellipses {
            for n in 0..size {
                let j = f32x16::from_slice(simd, &ROW) + (2 * n) as f32;
                exp2(simd, yy * j * j).store_slice(&mut self.rows[n].0);
                let i = f32x16::from_slice(simd, &COLUMN) + (2 * n) as f32;
                exp2(simd, xx * i * i).store_slice(&mut self.columns[n].0);
            }
            return;
        }
        let middle = origin_point(size, ellipses);
        self.beside = middle - 2.0 * origin_block(size, ellipses) as f32;
        let [shift_x, shift_y] = shifts(simd, shape, (footprints.anchor, footprints.slope));
        for row in 0..size {
            let j = f32x16::from_slice(simd, &ROW) + (2 * row) as f32 - middle - shift_y;
            for column in 0..size {
                if !self.needed.has(row, column) {
                    continue;
                }
                let i = f32x16::from_slice(simd, &COLUMN) + (2 * column) as f32 - middle - shift_x;
                let exponent = xx * i * i + xy * i * j + yy * j * j;
                // Zero, not the least number, where it is less: powers of elongated footprints would show the
                // difference.
                exponent
                    .simd_gt(f32x16::splat(simd, LEAST))
                    .select(exp2(simd, exponent), f32x16::splat(simd, 0.0))
                    .store_slice(&mut self.blocks[row][column].0);
            }
        }
    }
}

/// Raster points by which a group's footprints lie beside the one at a depth, along the kernel's slope.
#[inline(always)]
fn shifts<S: Simd>(simd: S, shape: &GroupShape, (anchor, slope): (f32, [f32; 2])) -> [f32x16<S>; 2] {
    let apart = (load(simd, &shape.depth) - anchor) * load(simd, &shape.scale);
    slope.map(|slope| apart * slope)
}

/// The raster point, from a footprint's first one, from which its centre is counted. Those of ellipses lie around it.
pub(crate) const fn origin_point(size: usize, ellipses: bool) -> f32 {
    if ellipses { size as f32 - 0.5 } else { 0.0 }
}

/// The block of a footprint with the raster point from which i and j count.
pub(super) const fn origin_block(size: usize, ellipses: bool) -> usize {
    if ellipses { size / 2 } else { 0 }
}

/// Voxels whose powers are computed together. The chain of dependent instructions of one voxel is longer than a
/// processor's look-ahead; those of different voxels run side by side.
const BATCH: usize = 16;

/// Powers and weights of a batch.
#[derive(Debug, Default)]
pub(crate) struct Powers {
    /// `p, q, 2^(a u^2 + c u v + b v^2)`, profile in depth, four sheets each.
    exponents: [Lanes16; BATCH],
    /// What each footprint is multiplied by in each ring, at the raster point that powers count from.
    weights: [[Lanes16; MAX_CHANNELS]; BATCH],
}

impl Powers {
    /// Computes the powers of a batch of footprints.
    #[inline(always)]
    fn of_batch<S: Simd, const ELLIPSES: bool>(
        &mut self,
        simd: S,
        group: FootprintGroup<'_>,
        (records, batch): (&Records, Range<usize>),
    ) {
        // Voxels far before a zone's first plane are splatted into it, with powers that no number holds.
        let least = f32x16::splat(simd, LEAST_NORMAL);
        let count = batch.len();
        let shapes = (group.constants, group.shape, group.stencil);
        exponents::<S, ELLIPSES>(simd, shapes, (records, batch.start, count), &mut self.exponents);
        for lanes in &mut self.exponents[..count] {
            exp2_quick(simd, load(simd, lanes).max(least)).store_slice(&mut lanes.0);
        }
    }

    /// A footprint's weight, per peak, at the raster point that powers count from.
    #[inline(always)]
    fn weight<S: Simd>(&self, simd: S, n: usize, constants: &SplatConstants) -> f32x16<S> {
        let (_, weights) = load(simd, &self.exponents[n]).split();
        let (lateral, depth) = weights.split();
        let (lateral, depth) = (lateral.combine(lateral), depth.combine(depth));
        let profile = (depth - constants.depth_edge).max(f32x8::splat(simd, 0.0));
        let weight = lateral * profile;
        weight.combine(weight)
    }
}

/// Offset of a block of pixels from a voxel's footprints on the four sheets of a group.
pub(crate) struct Offset<'a, S: Simd> {
    /// Raster points from the centre.
    pub points: [f32x16<S>; 2],
    /// The profile's moment in depth relative to the profile.
    pub depth: f32x16<S>,
    /// The centre, camera x and y.
    pub centre: [f32x16<S>; 2],
    pub shape: &'a GroupShape,
    pub constants: &'a SplatConstants,
}

/// Payload of a voxel: the numbers that its record's value adds to N rings.
pub(crate) trait Payload<const N: usize>: Copy {
    /// How its footprints are added to the rings.
    type Footprint: Footprint;

    /// A footprint's weight (per peak) times its peak times each number.
    fn weights<S: Simd>(&self, simd: S, value: f32, weight: f32x16<S>, peak: f32x16<S>) -> [f32x16<S>; N];

    /// Contribution of a voxel to a block of pixels where each weight is computed by itself, given
    /// [`Payload::weights`] at the footprint's centre and the block's share of those.
    #[inline(always)]
    fn in_block<S: Simd>(
        &self,
        _: S,
        weights: &[f32x16<S>; N],
        share: f32x16<S>,
        _offset: &Offset<'_, S>,
    ) -> [f32x16<S>; N] {
        weights.map(|weight| weight * share)
    }
}

/// The value itself.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Coefficient;

impl Payload<1> for Coefficient {
    type Footprint = Scaled;

    #[inline(always)]
    fn weights<S: Simd>(&self, _: S, value: f32, weight: f32x16<S>, peak: f32x16<S>) -> [f32x16<S>; 1] {
        [weight * (peak * value)]
    }
}

/// What all voxels of a slab share on a group of sheets.
#[derive(Clone, Copy)]
pub(crate) struct FootprintGroup<'a> {
    pub constants: &'a SplatConstants,
    pub shape: &'a GroupShape,
    pub stencil: &'a Stencil,
    /// Blocks along a footprint's edge, one of `SIZES`.
    pub size: usize,
    pub ellipses: bool,
}

/// Splats all records into a group of sheets of each of N rings.
#[inline(always)]
pub(crate) fn splat<S: Simd, P: Payload<N>, const N: usize>(
    simd: S,
    group: FootprintGroup<'_>,
    (records, payload): (&Records, P),
    powers: &mut Powers,
    rings: &mut [&mut [Row]; N],
) {
    let total = records.len.min(CAPACITY);
    let mut first = 0;
    while first < total {
        let batch = first..total.min(first + BATCH);
        match group.ellipses {
            true => powers.of_batch::<S, true>(simd, group, (records, batch.clone())),
            false => powers.of_batch::<S, false>(simd, group, (records, batch.clone())),
        }
        if P::Footprint::WEIGHTED {
            let peak = load(simd, &group.shape.peak);
            for n in 0..batch.len() {
                let weight = powers.weight(simd, n, group.constants);
                let weights = payload.weights(simd, records.value[first + n], weight, peak);
                for (weight, kept) in weights.into_iter().zip(&mut powers.weights[n]) {
                    weight.store_slice(&mut kept.0);
                }
            }
        }
        add_batch::<S, P::Footprint>(simd, group, (records, batch.clone(), powers), rings);
        first = batch.end;
    }
}

/// Whether one body serves footprints of all sizes. SSE2 is for processors of before 2013, and for proof.
const fn has_one_body<S: Simd>() -> bool {
    cfg!(any(target_arch = "x86", target_arch = "x86_64")) && <S::f32s as SimdBase<S>>::LEN == 4
}

/// Adds a batch of footprints, by the body that is compiled for their size.
#[inline(always)]
fn add_batch<S: Simd, F: Footprint>(
    simd: S,
    group: FootprintGroup<'_>,
    batch: (&Records, Range<usize>, &Powers),
    rings: &mut [&mut [Row]],
) {
    macro_rules! by_size {
        ($($size:literal)*) => {
            match group.size {
                $($size => add_by_shape::<S, F, $size>(simd, group, batch, rings),)*
                _ => add_by_shape::<S, F, MAX_BLOCKS>(simd, group, batch, rings),
            }
        };
    }
    if const { has_one_body::<S>() } {
        add_by_shape::<S, F, MAX_BLOCKS>(simd, group, batch, rings);
    } else {
        by_size!(2 3 4 5 6 7 8 10 12);
    }
}

/// Adds a batch of footprints of up to `CAPACITY` x `CAPACITY` blocks, round or elliptical.
#[inline(always)]
fn add_by_shape<S: Simd, F: Footprint, const CAPACITY: usize>(
    simd: S,
    group: FootprintGroup<'_>,
    batch: (&Records, Range<usize>, &Powers),
    rings: &mut [&mut [Row]],
) {
    match group.ellipses {
        false => simd.vectorize(
            #[inline(always)]
            || add_sized::<S, F, CAPACITY, false>(simd, group, batch, rings),
        ),
        true => simd.vectorize(
            #[inline(always)]
            || add_sized::<S, F, CAPACITY, true>(simd, group, batch, rings),
        ),
    }
}

/// Adds a batch of footprints of up to `CAPACITY` x `CAPACITY` blocks.
#[inline(always)]
fn add_sized<S: Simd, F: Footprint, const CAPACITY: usize, const ELLIPSES: bool>(
    simd: S,
    group: FootprintGroup<'_>,
    (records, batch, powers): (&Records, Range<usize>, &Powers),
    rings: &mut [&mut [Row]],
) {
    let FootprintGroup {
        constants,
        shape,
        stencil,
        ..
    } = group;
    // Known when it is compiled, but in the body for all sizes.
    let size = match CAPACITY {
        MAX_BLOCKS => group.size.min(MAX_BLOCKS),
        _ => CAPACITY,
    };
    for (n, index) in batch.enumerate() {
        let (bases, weights) = load(simd, &powers.exponents[n]).split();
        let (lateral, depth) = weights.split();
        let steps = if ELLIPSES {
            Steps::of_ellipse(simd, size, bases)
        } else {
            Steps::of_round(simd, size, bases, stencil)
        };
        let voxel = Voxel {
            records,
            index,
            constants,
            shape,
            stencil,
            size,
            steps,
            lateral: lateral.combine(lateral),
            depth: depth.combine(depth),
            weights: &powers.weights[n],
            column: (records.column[index] as usize).min(PITCH - size),
        };
        F::add::<S, CAPACITY, ELLIPSES>(simd, &voxel, rings);
    }
}

/// Exponents of a batch of footprints.
#[inline(always)]
fn exponents<S: Simd, const ELLIPSES: bool>(
    simd: S,
    (constants, shape, stencil): (&SplatConstants, &GroupShape, &Stencil),
    (records, first, count): (&Records, usize, usize),
    exponents: &mut [Lanes16; BATCH],
) {
    let (depth, scale) = (load(simd, &shape.depth), load(simd, &shape.scale));
    let (xx, yy) = (load(simd, &shape.xx), load(simd, &shape.yy));
    // Four lanes each: -2 a u - c v, -2 b v - c u, a u^2 + c u v + b v^2, the profile.
    let zero = f32x16::splat(simd, 0.0);
    let upper = f32x16::from_slice(simd, &ROW).simd_gt(zero);
    let odd = f32x16::from_slice(simd, &COLUMN).simd_gt(zero);
    let (second, last) = (odd & !upper, odd & upper);
    let factor = last.select(
        f32x16::splat(simd, constants.depth_exponent),
        upper.select(xx, second.select(yy, xx) * -2.0),
    );
    let xy = load(simd, &shape.xy);
    let cross = last.select(zero, upper.select(xy, -xy));
    let vertical = (upper & !odd).select(yy, zero);
    let one = f32x16::splat(simd, 1.0);
    let shifts = shifts(simd, shape, (stencil.anchor, constants.slope));
    let [shift_x, shift_y] = shifts.map(|shift| shift + stencil.beside);
    let of_third = |slope: f32x16<S>| (upper & !odd).select(slope, zero);
    let slope_x = of_third(xx * shift_x * 2.0 + xy * shift_y);
    let slope_y = of_third(yy * shift_y * 2.0 + xy * shift_x);
    for n in 0..count {
        let record = first + n;
        let dz = depth - records.z[record];
        let (mut x, mut y) = (scale * records.x[record], scale * records.y[record]);
        if ELLIPSES {
            let dz = stencil.anchor - records.z[record];
            x = scale * (dz * constants.slope[0] + records.x[record]);
            y = scale * (dz * constants.slope[1] + records.y[record]);
        }
        let (u, v) = (x + records.origin_x[record], y + records.origin_y[record]);
        let own = last.select(dz, second.select(v, u));
        let again = upper.select(own, one);
        let mut linear = own * factor;
        let mut rest = v * v * vertical;
        if ELLIPSES {
            linear += second.select(u, v) * cross + slope_x;
            rest += v * slope_y;
        }
        (linear * again + rest).store_slice(&mut exponents[n].0);
    }
}
