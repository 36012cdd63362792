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

use fearless_simd::{f32x4, f32x8, f32x16, mask32x16, prelude::*};
use splatvol_core::plan::{MAX_BLOCKS, SplatConstants};

use super::needed::{Footprints, Needed};
use super::ring::{Area, Block, PITCH, Row};
use super::sheet::{GroupShape, Lanes16};
use super::tile::MAX_CHANNELS;
use crate::simd::math::{LEAST_NORMAL, exp2, exp2_quick};

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

/// The footprint of a voxel in the middle of a raster point: C(i, j) block by block, or its columns and rows.
#[derive(Debug)]
pub(crate) struct Stencil {
    pub blocks: [[Lanes16; MAX_BLOCKS]; MAX_BLOCKS],
    columns: [Lanes16; MAX_BLOCKS],
    rows: [Lanes16; MAX_BLOCKS],
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
const fn origin_block(size: usize, ellipses: bool) -> usize {
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

/// Footprints of a voxel in the rings, block by block. Compiled for each size of footprints; payloads share them.
pub(crate) trait Footprint {
    /// Whether the payload's weights are used.
    const WEIGHTED: bool;

    /// Adds a voxel's footprint to each ring. `CAPACITY` is the number of blocks along the edge, or the most of these.
    fn add<S: Simd, const CAPACITY: usize, const ELLIPSES: bool>(
        simd: S,
        voxel: &Voxel<'_, S, CAPACITY>,
        rings: &mut [&mut [Row]],
    );
}

/// One footprint in every ring, times a weight for each.
pub(crate) struct Scaled;

impl Footprint for Scaled {
    const WEIGHTED: bool = true;

    #[inline(always)]
    fn add<S: Simd, const CAPACITY: usize, const ELLIPSES: bool>(
        simd: S,
        voxel: &Voxel<'_, S, CAPACITY>,
        rings: &mut [&mut [Row]],
    ) {
        for (ring, weight) in rings.iter_mut().zip(voxel.weights) {
            let Some(rows) = voxel.rows(ring) else {
                continue;
            };
            let down = voxel.down::<ELLIPSES>(simd, load(simd, weight));
            voxel.add_product::<ELLIPSES>(simd, &down, rows);
        }
    }
}

/// A voxel about to be splatted into a group of sheets.
pub(crate) struct Voxel<'a, S: Simd, const CAPACITY: usize> {
    pub records: &'a Records,
    pub index: usize,
    pub constants: &'a SplatConstants,
    pub shape: &'a GroupShape,
    pub stencil: &'a Stencil,
    /// Blocks along the footprint's edge: `CAPACITY`, but where one body is compiled for several sizes.
    pub size: usize,
    pub steps: Steps<S, CAPACITY>,
    /// The footprint at the raster point that its powers count from, and the profile in depth: four sheets, twice.
    pub lateral: f32x8<S>,
    pub depth: f32x8<S>,
    /// What the footprint is multiplied by in each ring.
    weights: &'a [Lanes16; MAX_CHANNELS],
    /// Column of the first block.
    pub column: usize,
}

impl<S: Simd, const CAPACITY: usize> Voxel<'_, S, CAPACITY> {
    /// Rows of a ring that the footprint touches.
    #[inline(always)]
    pub(crate) fn rows<'r>(&self, ring: &'r mut [Row]) -> Option<&'r mut [Row]> {
        let row = self.records.row[self.index] as usize;
        ring.get_mut(row..row + self.size)
    }

    /// Columns of a ring that the footprint touches.
    #[inline(always)]
    pub(crate) fn columns(&self) -> Range<usize> {
        self.column..self.column + self.size
    }

    /// Whether a block is left out.
    #[inline(always)]
    pub(crate) fn lacks<const ELLIPSES: bool>(&self, row: usize, column: usize) -> bool {
        self.stencil.needed.lacks::<ELLIPSES>(self.size, [row, column])
    }

    /// Powers of the rows, times a weight.
    #[inline(always)]
    pub(crate) fn down<const ELLIPSES: bool>(&self, simd: S, weight: f32x16<S>) -> [f32x16<S>; CAPACITY] {
        let Self {
            steps, stencil, size, ..
        } = self;
        let origin = origin_block(*size, ELLIPSES);
        let mut down = [steps.origin * weight; CAPACITY];
        for r in origin + 1..*size {
            down[r] = down[r - 1] * steps.forward;
        }
        for r in (0..origin).rev() {
            down[r] = down[r + 1] * steps.back;
        }
        if !ELLIPSES {
            for b in 0..*size {
                down[b] *= load(simd, &stencil.rows[b]);
            }
        }
        down
    }

    /// Adds the product of columns and rows, of ellipses times their stencil, to the blocks from the first column on.
    #[inline(always)]
    fn add_product<const ELLIPSES: bool>(&self, simd: S, down: &[f32x16<S>; CAPACITY], rows: &mut [Row]) {
        // Slices of one length: no test of an index is left in the inner loop.
        let size = self.size;
        let (across, rows, down) = (&self.steps.across[..size], &mut rows[..size], &down[..size]);
        for r in 0..size {
            let line = &mut rows[r].0[self.columns()][..size];
            let stencil = &self.stencil.blocks[r][..size];
            for c in 0..size {
                if self.lacks::<ELLIPSES>(r, c) {
                    continue;
                }
                let weights = if ELLIPSES {
                    across[c] * load(simd, &stencil[c])
                } else {
                    across[c]
                };
                accumulate(simd, weights * down[r], &mut line[c]);
            }
        }
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

/// Powers of a voxel's columns, and the factors from row to row.
pub(crate) struct Steps<S: Simd, const CAPACITY: usize> {
    pub across: [f32x16<S>; CAPACITY],
    /// Factors of the rows in the block from which they are counted.
    origin: f32x16<S>,
    forward: f32x16<S>,
    back: f32x16<S>,
}

/// Four numbers in all quarters of a vector.
#[inline(always)]
fn four_times<S: Simd>(four: f32x4<S>) -> f32x16<S> {
    let both = four.combine(four);
    both.combine(both)
}

impl<S: Simd, const CAPACITY: usize> Steps<S, CAPACITY> {
    #[inline(always)]
    fn of_round(simd: S, size: usize, bases: f32x8<S>, stencil: &Stencil) -> Self {
        let (p, q) = bases.split();
        let one = f32x4::splat(simd, 1.0);
        let columns = one.combine(p);
        let mut across = [columns.combine(columns); CAPACITY];
        let p = four_times(p);
        let forward = p * p;
        for b in 1..size {
            across[b] = across[b - 1] * forward;
        }
        for b in 0..size {
            across[b] *= load(simd, &stencil.columns[b]);
        }
        let origin = one.combine(one).combine(q.combine(q));
        let q = four_times(q);
        Self {
            across,
            origin,
            forward: q * q,
            back: q,
        }
    }

    #[inline(always)]
    fn of_ellipse(simd: S, size: usize, bases: f32x8<S>) -> Self {
        let origin = origin_block(size, true);
        let (p, q) = bases.split();
        let inverse = f32x8::splat(simd, 1.0) / bases;
        let (p_back, q_back) = (inverse * inverse).split();
        let one = f32x4::splat(simd, 1.0);
        let columns = one.combine(p);
        let mut across = [columns.combine(columns); CAPACITY];
        let p = four_times(p);
        let (forward, back) = (p * p, four_times(p_back));
        for b in origin + 1..size {
            across[b] = across[b - 1] * forward;
        }
        for b in (0..origin).rev() {
            across[b] = across[b + 1] * back;
        }
        let rows = one.combine(one).combine(q.combine(q));
        let q = four_times(q);
        Self {
            across,
            origin: rows,
            forward: q * q,
            back: four_times(q_back),
        }
    }
}

/// Adds to a block.
#[inline(always)]
pub(crate) fn accumulate<S: Simd>(simd: S, weights: f32x16<S>, block: &mut Block) {
    (weights + f32x16::from_slice(simd, &block.0)).store_slice(&mut block.0);
}
