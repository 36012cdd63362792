//! The field between two planes along sixteen rays.
//!
//! Both planes hold the sums `S` and `W` with their gradients, so `v = S / W` and its slope along the ray,
//! `v' = (S' - v W') / W`, are known at both ends. Between them v is the cubic Hermite polynomial, `O(dz^4)`; W and
//! the coverage vary linearly. The gradient varies linearly between the ends, except for its part along the ray,
//! which is the polynomial's derivative. With the linear part alone, or with interpolated lighting instead of
//! gradients, sheets would show as wood grain on slopes.

use fearless_simd::{f32x16, mask32x16, prelude::*};

use super::cubic::Cubic;
use super::lattice_weights::{Weights, coverage};
use splatvol_core::border::FADED;

/// Least divisor in place of a smaller weight.
const LEAST_WEIGHT: f32 = 0.01;
/// Spreads of five samples of a cubic by which it may leave their range.
const OVERSHOOT: f32 = 0.125;
/// Most pieces of an interval.
const MOST_PIECES: f32 = 8.0;
/// Cells of the tables of classification per normalised value.
const CELLS_PER_VALUE: f32 = 1024.0;

/// Sums on a plane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct End<S: Simd> {
    /// S less the background times W, and its gradient: camera space, per world length.
    pub sum: f32x16<S>,
    pub gradient: [f32x16<S>; 3],
    pub weights: Weights<S>,
}

/// The rays.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RayLanes<S: Simd> {
    /// Motion of the rays in camera x and y per depth.
    pub slope: [f32x16<S>; 2],
    /// Path length per depth, squared.
    pub squared: f32x16<S>,
    /// Distance between the planes, world length.
    pub spacing: f32,
}

impl<S: Simd> RayLanes<S> {
    /// Change of something with this gradient, per depth.
    #[inline(always)]
    pub(super) fn along(&self, [x, y, z]: [f32x16<S>; 3]) -> f32x16<S> {
        self.slope[0] * x + self.slope[1] * y + z
    }
}

/// The field between the planes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hermite<S: Simd> {
    /// Coefficients of the value over u in 0..1.
    cubic: [f32x16<S>; 4],
    weights: [f32x16<S>; 2],
    /// Slopes of W along the ray, per interval.
    falls: [f32x16<S>; 2],
    /// Shares on the volume's own box.
    own: [f32x16<S>; 2],
    /// Gradients of S.
    gradients: [[f32x16<S>; 3]; 2],
    rays: RayLanes<S>,
}

#[inline(always)]
fn splat<S: Simd>(simd: S, value: f32) -> f32x16<S> {
    f32x16::splat(simd, value)
}

impl<S: Simd> Hermite<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, [near, far]: [&End<S>; 2], rays: RayLanes<S>, background: f32) -> Self {
        let (v0, start) = value_and_slope(simd, [near, far], &rays, background);
        let (v1, end) = value_and_slope(simd, [far, near], &rays, background);
        let rise = v1 - v0;
        let whole = |end: &End<S>| {
            let ([x, y, z], [wx, wy, wz]) = (end.gradient, end.weights.gradient);
            [x + wx * background, y + wy * background, z + wz * background]
        };
        Self {
            cubic: [
                v0,
                start,
                rise * 3.0 - start * 2.0 - end,
                start + end - rise * 2.0,
            ],
            weights: [near.weights.weight, far.weights.weight],
            falls: [
                rays.along(near.weights.gradient) * rays.spacing,
                rays.along(far.weights.gradient) * rays.spacing,
            ],
            own: [near.weights.own, far.weights.own],
            gradients: [whole(near), whole(far)],
            rays,
        }
    }

    #[inline(always)]
    pub(crate) fn value(&self, u: f32x16<S>) -> f32x16<S> {
        let [a, b, c, d] = self.cubic;
        ((d * u + c) * u + b) * u + a
    }

    /// The value as a cubic.
    #[inline(always)]
    pub(crate) fn values(&self) -> Cubic<S> {
        let [a, b, c, d] = self.cubic;
        Cubic::with_slopes([a, a + b + c + d], [b, b + c * 2.0 + d * 3.0])
    }

    /// Coverage, 0 to 1.
    #[inline(always)]
    pub(crate) fn coverage(&self, simd: S, u: f32x16<S>) -> f32x16<S> {
        coverage(simd, (self.own[1] - self.own[0]) * u + self.own[0])
    }

    /// Gradient of S, camera space, per world length.
    #[inline(always)]
    pub(crate) fn gradient(&self, u: f32x16<S>) -> [f32x16<S>; 3] {
        let [_, b, c, d] = self.cubic;
        let slope = (d * u * 3.0 + c * 2.0) * u + b;
        let weight = (self.weights[1] - self.weights[0]) * u + self.weights[0];
        let fall = (self.falls[1] - self.falls[0]) * u + self.falls[0];
        let along = (slope * weight + self.value(u) * fall) * (1.0 / self.rays.spacing);
        let [near, far] = self.gradients;
        let [x, y, z] = [
            (far[0] - near[0]) * u + near[0],
            (far[1] - near[1]) * u + near[1],
            (far[2] - near[2]) * u + near[2],
        ];
        let missing = (along - self.rays.along([x, y, z])) / self.rays.squared;
        [
            missing * self.rays.slope[0] + x,
            missing * self.rays.slope[1] + y,
            z + missing,
        ]
    }

    /// Rays that may meet values from `first` to `last`, and the largest bend of the value within a quarter of the
    /// interval.
    #[inline(always)]
    pub(crate) fn may_meet(&self, simd: S, [first, last]: [f32; 2]) -> (mask32x16<S>, f32x16<S>) {
        let [a, b, c, d, e] = [
            self.value(splat(simd, 0.0)),
            self.value(splat(simd, 0.25)),
            self.value(splat(simd, 0.5)),
            self.value(splat(simd, 0.75)),
            self.value(splat(simd, 1.0)),
        ];
        let (low, high) = (a.min(b).min(c).min(d.min(e)), a.max(b).max(c).max(d.max(e)));
        let slack = (high - low) * OVERSHOOT;
        let bend = (a - b * 2.0 + c)
            .abs()
            .max((b - c * 2.0 + d).abs())
            .max((c - d * 2.0 + e).abs());
        let meets = (high + slack).simd_ge(splat(simd, first)) & (low - slack).simd_le(splat(simd, last));
        (meets, bend)
    }
}

/// Value and slope per interval at one end, given the other end's, which replace them where the end has hardly any
/// weight.
#[inline(always)]
fn value_and_slope<S: Simd>(
    simd: S,
    [end, other]: [&End<S>; 2],
    rays: &RayLanes<S>,
    background: f32,
) -> (f32x16<S>, f32x16<S>) {
    let (zero, least) = (splat(simd, 0.0), splat(simd, LEAST_WEIGHT));
    let (weight, beside) = (end.weights.weight, other.weights.weight);
    let is_faded = weight.simd_lt(splat(simd, FADED).min(beside));
    let per_weight = 1.0 / weight.max(least);
    let value = end.sum * per_weight;
    let slope =
        (rays.along(end.gradient) - value * rays.along(end.weights.gradient)) * per_weight * rays.spacing;
    let value = is_faded.select(other.sum / beside.max(least), value);
    (value + background, is_faded.select(zero, slope))
}

/// Number of pieces of each ray: enough that in each the value is linear to half a table cell and the optical depth
/// is small.
#[inline(always)]
pub(crate) fn pieces<S: Simd>(simd: S, bend: f32x16<S>, optical_depth: f32x16<S>) -> f32x16<S> {
    // Linear interpolation over 1/n of the interval errs by (16 bend) / (8 n^2): n^2 is asked of both.
    let squared = (bend * (8.0 * CELLS_PER_VALUE)).max(optical_depth * 4.0);
    let count = squared.sqrt().ceil();
    count.max(splat(simd, 1.0)).min(splat(simd, MOST_PIECES))
}
