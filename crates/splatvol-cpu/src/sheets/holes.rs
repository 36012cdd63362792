//! Holes: missing samples, which have no weight (docs/numerics.md).
//!
//! Planes hold `S = sum_k (c_k - b) h(x - k)` over the existing samples. If a lattice has all its samples, the
//! weights `h` add up to W, which is one except at the borders; if some are missing, to `W - M`,
//! `M = sum_k h(x - k)` over the missing ones. So the missing samples near visible ones are splatted, too, into a
//! ring of their own with coefficients of one; where gradients are analytic, with their moments. Then
//! `v = b + S / (W - M)`, and coverage is `B (W - M) / W` in place of B. Lighting uses the gradient of `S - b M`.
//! This is the gradient of the sum over all coefficients, the missing ones being 0, except for the border's part. A
//! sample is splatted only once, and pixels without holes are not changed by these sums.

use fearless_simd::{f32x16, mask32x16, prelude::*};

use super::frame::SheetFrame;
use super::place::Place;
use super::plane::{HALO, Plane};
use super::records::Records;
use super::ring::{LANES, SheetRing};
use super::shade::Interval;
use super::tile::{MAX_CHANNELS, SheetScratch, take};
use super::upsample::Sums;

/// Share of the weight below which a pixel has no value of its own.
const FADED: f32 = 0.15;
/// Least share used as a divisor.
const LEAST: f32 = 0.01;

/// A thread's memory of missing samples.
#[derive(Debug, Default)]
pub(crate) struct Holes {
    pub ring: SheetRing,
    /// Missing samples that are still to be splatted.
    pub records: Records,
    /// M and its moments on the last four sheets, by channel.
    pub planes: [[Plane; MAX_CHANNELS]; 4],
    /// Gradient of M, while the nearer of two planes lies at the eye.
    pub at_eye: [f32; 3],
}

impl Holes {
    /// Prepares for a zone of a tile, with the ring's rows and groups, and the pixels and channels of the planes.
    pub(super) fn begin_zone(&mut self, (height, groups): (usize, usize), size: [usize; 2], channels: usize) {
        self.ring.reset(height, groups);
        for planes in &mut self.planes {
            for plane in &mut planes[..channels] {
                plane.reset(size);
            }
        }
    }

    /// Weights of missing samples on the last four sheets; `None` where there are none.
    fn weights(&self) -> Option<[&Plane; 4]> {
        let any = self.planes.iter().any(|planes| planes[0].filled.is_some());
        any.then(|| self.planes.each_ref().map(|planes| &planes[0]))
    }

    /// Weights of missing samples and their moments on the two sheets of an interval; `None` where there are none.
    pub(super) fn moments(&self) -> Option<[&[Plane; MAX_CHANNELS]; 2]> {
        let [_, near, far, _] = &self.planes;
        let any = [near, far].iter().any(|planes| planes[0].filled.is_some());
        any.then_some([near, far])
    }
}

impl SheetScratch {
    /// Takes a finished sheet of missing samples out of their ring.
    #[inline(always)]
    pub(super) fn take_holes<S: Simd>(
        &mut self,
        simd: S,
        (frame, place): (&SheetFrame<'_>, &Place),
        (sheet, channels): (usize, usize),
    ) {
        let open = frame.groups * LANES;
        let Self {
            holes,
            raster,
            upsampler,
            ..
        } = self;
        holes.planes.rotate_left(1);
        let [.., last] = &mut holes.planes;
        for channel in 0..channels {
            let slot = channel * open + sheet % open;
            if holes.ring.touched[slot].is_empty() {
                last[channel].clear();
                continue;
            }
            let from = (&mut holes.ring, &mut last[channel]);
            take(
                simd,
                (frame.step, Sums::Values),
                place,
                slot,
                from,
                (raster, upsampler),
            );
        }
    }
}

impl<'a> Interval<'a> {
    /// Sets the weights of missing samples on the planes, given the background.
    pub(super) fn leave_out(&mut self, holes: &'a Holes, background: f32) {
        self.holes = holes.weights();
        if let (Some(_), Some(gradient)) = (&self.holes, &mut self.at_eye) {
            for (along, missing) in gradient.iter_mut().zip(holes.at_eye) {
                *along -= background * missing;
            }
        }
    }

    /// Whether the weights of all its samples add up to one, except at a volume's border.
    pub(super) fn is_whole(&self) -> bool {
        self.holes.is_none() && self.weights.is_none()
    }

    /// Weights of missing samples at sixteen pixels of the four planes; `None` where there are none.
    #[inline(always)]
    pub(super) fn missing<S: Simd>(&self, simd: S, at: usize) -> Option<[f32x16<S>; 4]> {
        if let Some(planes) = self.weights {
            let zero = f32x16::splat(simd, 0.0);
            return Some(planes.map(|plane| {
                let weight = f32x16::from_slice(simd, &plane.values[at..at + 16]);
                (1.0 - weight).max(zero)
            }));
        }
        let planes = self.holes?;
        let missing = planes.map(|plane| f32x16::from_slice(simd, &plane.values[at..at + 16]));
        let [a, b, c, d] = missing;
        any(simd, a.max(b).max(c.max(d))).then_some(missing)
    }

    /// Marks those of sixteen pixels that miss samples on the interval's two planes.
    #[inline(always)]
    pub(super) fn lacks<S: Simd>(&self, simd: S, [x, y]: [usize; 2]) -> Option<mask32x16<S>> {
        let [_, near, far, _] = self.holes?;
        let at = (y + HALO) * near.pitch + x + HALO;
        let [near, far] = [near, far].map(|plane| f32x16::from_slice(simd, &plane.values[at..at + 16]));
        Some(near.max(far).simd_gt(f32x16::splat(simd, 0.0)))
    }
}

/// Whether any of sixteen weights is above zero.
#[inline(always)]
pub(super) fn any<S: Simd>(simd: S, missing: f32x16<S>) -> bool {
    missing.simd_gt(f32x16::splat(simd, 0.0)).any_true()
}

/// Sums on four planes, corrected for the missing samples beside them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Beside<S: Simd> {
    /// Values less the background; a plane with hardly any weight takes values continued from the others.
    pub values: [f32x16<S>; 4],
    /// Shares of the weight that are left.
    left: [f32x16<S>; 4],
    /// Coverage where no weight is left is this far below zero.
    below: f32,
}

impl<S: Simd> Beside<S> {
    /// From an interval's sums, less the background, or from their means where its planes have weights of their
    /// own. `missing`: M over W.
    #[inline(always)]
    pub(super) fn of(
        simd: S,
        interval: &Interval<'_>,
        mut sums: [f32x16<S>; 4],
        missing: [f32x16<S>; 4],
    ) -> Self {
        let divided = interval.weights.is_some();
        if !divided {
            let (one, least) = (f32x16::splat(simd, 1.0), f32x16::splat(simd, LEAST));
            for (sum, missing) in sums.iter_mut().zip(missing) {
                *sum /= (one - missing).max(least);
            }
        }
        let [before, near, far, after] = sums;
        let (one, faded) = (f32x16::splat(simd, 1.0), f32x16::splat(simd, FADED));
        let left = missing.map(|missing| one - missing);
        let nearer = left[1].simd_lt(faded.min(left[2])).select(far, near);
        let farther = left[2].simd_lt(faded.min(left[1])).select(near, far);
        let outer = |left: f32x16<S>, value, straight| left.simd_lt(faded).select(straight, value);
        Self {
            values: [
                outer(left[0], before, nearer * 2.0 - farther),
                nearer,
                farther,
                outer(left[3], after, farther * 2.0 - nearer),
            ],
            left,
            below: if divided { 0.0 } else { BELOW },
        }
    }

    /// Coverage at both ends of the interval, given the coverage at the volume's border.
    #[inline(always)]
    pub(super) fn covered(&self, simd: S, [near, far]: [f32x16<S>; 2]) -> [f32x16<S>; 2] {
        [
            self.covered_by(simd, near, self.left[1]),
            self.covered_by(simd, far, self.left[2]),
        ]
    }

    /// As [`Self::covered`], at the near end, in the middle and at the far end.
    #[inline(always)]
    pub(super) fn covered_along(&self, simd: S, [near, middle, far]: [f32x16<S>; 3]) -> [f32x16<S>; 3] {
        let [a, b, c, d] = self.left;
        let between = (b + c) * (9.0 / 16.0) - (a + d) * (1.0 / 16.0);
        let [near, far] = self.covered(simd, [near, far]);
        let share = between
            .max(f32x16::splat(simd, 0.0))
            .min(f32x16::splat(simd, 1.0));
        [near, self.covered_by(simd, middle, share), far]
    }

    /// Coverage for a share of the weight, given that for the whole weight.
    #[inline(always)]
    fn covered_by(&self, simd: S, border: f32x16<S>, left: f32x16<S>) -> f32x16<S> {
        (border * left - (1.0 - left) * self.below).max(f32x16::splat(simd, 0.0))
    }
}

/// Coverage `q = (B - 1/2) / 0.98 + 1/2` is `-BELOW` at B = 0; for a share of B it is
/// `q share - BELOW (1 - share)`.
const BELOW: f32 = 0.01 / 0.98;

/// Scalar version of [`Beside`]: values on the four planes, less the background, and coverage. `divided`: the sums
/// are means already.
pub(super) fn beside_of(
    (sums, divided): ([f32; 4], bool),
    missing: [f32; 4],
    border: [f32; 2],
) -> ([f32; 4], [f32; 2]) {
    let left = missing.map(|missing| 1.0 - missing);
    let divisor = |i: usize| if divided { 1.0 } else { left[i].max(LEAST) };
    let [before, near, far, after]: [f32; 4] = std::array::from_fn(|i| sums[i] / divisor(i));
    let nearer = if left[1] < FADED.min(left[2]) { far } else { near };
    let farther = if left[2] < FADED.min(left[1]) { near } else { far };
    let outer = |left: f32, value, straight| if left < FADED { straight } else { value };
    let values = [
        outer(left[0], before, nearer * 2.0 - farther),
        nearer,
        farther,
        outer(left[3], after, farther * 2.0 - nearer),
    ];
    let covered = |end: usize| match divided {
        true => left[1 + end],
        false => (border[end] * left[1 + end] - missing[1 + end] * BELOW).max(0.0),
    };
    (values, [covered(0), covered(1)])
}

impl Records {
    /// Copies one of another's records to a place.
    fn copy(&mut self, other: &Self, (from, to): (usize, usize)) {
        self.x[to] = other.x[from];
        self.y[to] = other.y[from];
        self.z[to] = other.z[from];
        self.value[to] = other.value[from];
        self.origin_x[to] = other.origin_x[from];
        self.origin_y[to] = other.origin_y[from];
        self.column[to] = other.column[from];
        self.row[to] = other.row[from];
    }

    /// Copies one of its own records to another place.
    fn move_forward(&mut self, from: usize, to: usize) {
        for column in [
            &mut self.x,
            &mut self.y,
            &mut self.z,
            &mut self.value,
            &mut self.origin_x,
            &mut self.origin_y,
        ] {
            column[to] = column[from];
        }
        for column in [&mut self.column, &mut self.row] {
            column[to] = column[from];
        }
    }

    /// Moves the records of missing samples to `missing`, with coefficients of one; returns whether there are any.
    pub(super) fn part(&mut self, missing: &mut Self) -> bool {
        missing.len = 0;
        if !self.value[..self.len].contains(&f32::INFINITY) {
            return false;
        }
        let mut kept = 0;
        for i in 0..self.len {
            if self.value[i] == f32::INFINITY {
                let to = missing.len;
                missing.len += 1;
                missing.copy(self, (i, to));
                missing.value[to] = 1.0;
                missing.widen([self.column[i], self.row[i]]);
            } else {
                self.move_forward(i, kept);
                kept += 1;
            }
        }
        self.len = kept;
        true
    }
}
