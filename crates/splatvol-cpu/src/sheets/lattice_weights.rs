//! Weights of the lattice: sums of the kernels near the lattice's faces, and the box's share of them.
//!
//! `W(x) = sum_k h(x - k)` over the points of a box is the product over its axes of
//! `w(x) = sum_j phi((x - j) / s) / s`, phi the normal density and s the low-passed kernel's standard deviation
//! along the axis. Its gradient follows from `w'(x) = -sum_j (x - j) phi((x - j) / s) / s^3`. A low-pass couples
//! axes by a covariance c, which to first order adds `c dw/da dw/db` (the density's derivative by c is its mixed
//! second derivative). Coverage is that of docs/numerics.md:
//! `B = prod_a Phi((x_a + 1/2) / s_a) - Phi((x_a - n_a + 1/2) / s_a)`. Only vectors of pixels near a face are
//! evaluated; elsewhere both are one, and the gradient is zero.

use fearless_simd::{f32x16, prelude::*};
use glam::{Affine3A, DAffine3, DVec3, Vec3, Vec3A};
use splatvol_core::bin::TileRect;

use crate::simd::math::exp2_quick;
use splatvol_core::border::RAMP;

/// Distance from a face, standard deviations, beyond which the face has no effect.
const REACH: f32 = 4.2;
/// Cut of sums over the lattice, standard deviations.
const CUT: f32 = 4.5;
/// Margin of the tests of whole tiles, voxels: their corners are rounded differently from their pixels.
const TILE_SLACK: f32 = 0.01;
/// From the first of sixteen pixels to the last.
const LAST_LANE: f32 = 15.0;
/// Standard deviations beyond which the normal distribution is 0 or 1 in 32 bits.
const END: f32 = 8.0;
/// Largest exponent of a term, to base 2.
const FARTHEST: f32 = -120.0;

/// The lattice and the volume's box in camera space.
#[derive(Debug, Clone)]
pub(crate) struct LatticeWeights {
    /// Voxels from the first sample.
    voxel_from_camera: Affine3A,
    /// Voxels along x, y, z.
    size: Vec3,
    /// Lattice points beyond the box along x, y, z.
    margin: Vec3,
    /// Variance of the kernel, voxels squared.
    variance: f32,
    /// Variance along x, y and z, and covariances of y z, z x and x y, per lateral variance in camera space.
    low_pass: [Vec3; 2],
}

/// A plane's pixels in voxels, and the low-passed kernel on it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WeightPlane {
    first: Vec3A,
    step_x: Vec3A,
    step_y: Vec3A,
    /// Standard deviations along the voxel axes.
    sigma: Vec3,
    /// Covariances of y z, z x and x y.
    covariance: Vec3,
}

/// Weights at sixteen pixels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Weights<S: Simd> {
    /// W.
    pub weight: f32x16<S>,
    /// Its gradient, camera space, per world length.
    pub gradient: [f32x16<S>; 3],
    /// B.
    pub own: f32x16<S>,
}

impl<S: Simd> Weights<S> {
    /// Weights far inside.
    #[inline(always)]
    pub(crate) fn inside(simd: S) -> Self {
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        Self {
            weight: one,
            gradient: [zero; 3],
            own: one,
        }
    }

    /// q.
    #[inline(always)]
    pub(crate) fn coverage(&self, simd: S) -> f32x16<S> {
        coverage(simd, self.own)
    }
}

/// Coverage q, 0 to 1, of a share B on the volume's own box.
#[inline(always)]
pub(crate) fn coverage<S: Simd>(simd: S, own: f32x16<S>) -> f32x16<S> {
    ((own - 0.5) * (1.0 / RAMP) + 0.5)
        .max(f32x16::splat(simd, 0.0))
        .min(f32x16::splat(simd, 1.0))
}

impl<S: Simd> Weights<S> {
    /// Leaves out missing samples, given their weight and its gradient.
    #[inline(always)]
    pub(crate) fn leave_out(&mut self, simd: S, missing: f32x16<S>, gradient: [f32x16<S>; 3]) {
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        // Far outside the lattice both are zero; platforms differ in which operand `min` takes beside NaN.
        let whole = self
            .weight
            .max(missing)
            .max(f32x16::splat(simd, f32::MIN_POSITIVE));
        self.own *= one - (missing / whole).min(one);
        self.weight = (self.weight - missing).max(zero);
        for (along, missing) in self.gradient.iter_mut().zip(gradient) {
            *along -= missing;
        }
    }
}

/// Lane numbers.
const LANES: [f32; 16] = [
    0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0,
];

impl LatticeWeights {
    pub(crate) fn new(camera_from_voxel: DAffine3, dims: [usize; 3], margin: [usize; 3], sigma: f64) -> Self {
        let inverse = camera_from_voxel.inverse();
        let rows = inverse.matrix3.transpose();
        let [x, y, z] = [rows.x_axis, rows.y_axis, rows.z_axis].map(|row| row.truncate());
        Self {
            voxel_from_camera: Affine3A::from_mat3_translation(
                inverse.matrix3.as_mat3(),
                inverse.translation.as_vec3(),
            ),
            size: Vec3::from_array(dims.map(|n| n as f32)),
            margin: Vec3::from_array(margin.map(|n| n as f32)),
            variance: sigma.powi(2) as f32,
            low_pass: [
                DVec3::new(x.dot(x), y.dot(y), z.dot(z)).as_vec3(),
                DVec3::new(y.dot(z), z.dot(x), x.dot(y)).as_vec3(),
            ],
        }
    }

    /// The plane whose pixels' centres are at `first + x step_x + y step_y`, camera space, with a low-pass of this
    /// variance, world length squared.
    pub(crate) fn on_plane(&self, [first, step_x, step_y]: [Vec3A; 3], low_pass: f32) -> WeightPlane {
        let [own, shared] = self.low_pass;
        WeightPlane {
            first: self.voxel_from_camera.transform_point3a(first),
            step_x: self.voxel_from_camera.transform_vector3a(step_x),
            step_y: self.voxel_from_camera.transform_vector3a(step_y),
            sigma: (Vec3::splat(self.variance) + own * low_pass).map(f32::sqrt),
            covariance: shared * low_pass,
        }
    }

    /// Whether all points between two are far from the faces along an axis.
    #[inline(always)]
    fn is_inside(&self, axis: usize, plane: &WeightPlane, [from, to]: [Vec3A; 2]) -> bool {
        let reach = REACH * plane.sigma[axis];
        let (low, high) = (from[axis].min(to[axis]), from[axis].max(to[axis]));
        low + 0.5 >= reach && self.size[axis] - 0.5 - high >= reach
    }

    /// Whether sixteen pixels of a plane from (x, y) on are near a face.
    #[inline(always)]
    pub(crate) fn is_near(&self, plane: &WeightPlane, [x, y]: [usize; 2]) -> bool {
        let ends = plane.sixteen([x, y]);
        !(0..3).all(|axis| self.is_inside(axis, plane, ends))
    }

    /// Whether any sixteen of a tile's pixels may be near a face.
    pub(crate) fn is_near_any(&self, plane: &WeightPlane, tile: &TileRect) -> bool {
        let x1 = tile.x0 + (tile.x1 - tile.x0).next_multiple_of(16);
        let corners = [tile.y0, tile.y1].map(|y| [plane.at([tile.x0, y]), plane.at([x1, y])]);
        let [low, high] = [Vec3A::min, Vec3A::max].map(|pick: fn(Vec3A, Vec3A) -> Vec3A| {
            pick(
                pick(corners[0][0], corners[0][1]),
                pick(corners[1][0], corners[1][1]),
            )
        });
        !(0..3).all(|axis| self.is_inside(axis, plane, [low - TILE_SLACK, high + TILE_SLACK]))
    }

    /// Weights at sixteen pixels of a plane from (x, y) on.
    #[inline(always)]
    pub(crate) fn at<S: Simd>(&self, simd: S, plane: &WeightPlane, [x, y]: [usize; 2]) -> Weights<S> {
        let ends = plane.sixteen([x, y]);
        let lanes = f32x16::from_slice(simd, &LANES);
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let (mut weights, mut slopes, mut own) = ([one; 3], [zero; 3], one);
        for axis in 0..3 {
            if self.is_inside(axis, plane, ends) {
                continue;
            }
            let at = lanes * plane.step_x[axis] + ends[0][axis];
            let (sigma, size) = (plane.sigma[axis], self.size[axis]);
            [weights[axis], slopes[axis]] = lattice_sum(
                simd,
                at + self.margin[axis],
                size + 2.0 * self.margin[axis],
                sigma,
            );
            let per_sigma = 1.0 / sigma;
            own *=
                cumulative(simd, (at + 0.5) * per_sigma) - cumulative(simd, (at + (0.5 - size)) * per_sigma);
        }
        let [wx, wy, wz] = weights;
        let [sx, sy, sz] = slopes;
        let [yz, zx, xy] = plane.covariance.to_array();
        let weight = wx * wy * wz + (wx * sy * sz * yz + wy * sz * sx * zx + wz * sx * sy * xy);
        let gradient = [sx * wy * wz, wx * sy * wz, wx * wy * sz];
        let from_voxel = self.voxel_from_camera.matrix3;
        let along = |axis: Vec3A| gradient[0] * axis.x + gradient[1] * axis.y + gradient[2] * axis.z;
        Weights {
            weight,
            gradient: [
                along(from_voxel.x_axis),
                along(from_voxel.y_axis),
                along(from_voxel.z_axis),
            ],
            own,
        }
    }
}

impl WeightPlane {
    #[inline(always)]
    fn at(&self, [x, y]: [usize; 2]) -> Vec3A {
        self.first + self.step_x * x as f32 + self.step_y * y as f32
    }

    /// The first and the last of sixteen pixels.
    #[inline(always)]
    fn sixteen(&self, place: [usize; 2]) -> [Vec3A; 2] {
        let from = self.at(place);
        [from, from + self.step_x * LAST_LANE]
    }
}

/// Sum of the normal densities around lattice points 0 to `count - 1`, and its derivative.
#[inline(always)]
fn lattice_sum<S: Simd>(simd: S, at: f32x16<S>, count: f32, sigma: f32) -> [f32x16<S>; 2] {
    let (zero, last) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, count - 1.0));
    let nearest = at.round_ties_even().max(zero).min(last);
    let reach = (CUT * sigma).ceil();
    let exponent = -0.5 * std::f32::consts::LOG2_E / (sigma * sigma);
    let (mut sum, mut moment) = (zero, zero);
    let mut step = -reach;
    while step <= reach {
        let point = nearest + step;
        let exists = point.simd_ge(zero) & point.simd_le(last);
        let offset = at - point;
        let density = exp2_quick(
            simd,
            (offset * offset * exponent).max(f32x16::splat(simd, FARTHEST)),
        );
        let density = exists.select(density, zero);
        sum += density;
        moment += density * offset;
        step += 1.0;
    }
    let peak = 1.0 / (sigma * (2.0 * std::f32::consts::PI).sqrt());
    [sum * peak, moment * (-peak / (sigma * sigma))]
}

/// Standard normal cumulative distribution, to 1e-6 (Abramowitz and Stegun 7.1.26).
#[inline(always)]
fn cumulative<S: Simd>(simd: S, x: f32x16<S>) -> f32x16<S> {
    let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
    let z = x.abs().min(f32x16::splat(simd, END)) * std::f32::consts::FRAC_1_SQRT_2;
    let t = one / (z * 0.327_591_1 + 1.0);
    let mut tail = f32x16::splat(simd, 1.061_405_4);
    for coefficient in [-1.453_152_1, 1.421_413_8, -0.284_496_72, 0.254_829_6] {
        tail = tail * t + coefficient;
    }
    let tail = tail * t * exp2_quick(simd, z * z * -std::f32::consts::LOG2_E) * 0.5;
    x.simd_lt(zero).select(tail, one - tail)
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};
    use splatvol_core::normal;
    use splatvol_testing::random::Random;

    use super::*;

    #[inline(always)]
    fn found<S: Simd>(simd: S, at: f32, count: f32, sigma: f32) -> [f32; 3] {
        let at = f32x16::splat(simd, at);
        let [sum, slope] = lattice_sum(simd, at, count, sigma);
        [sum[0], slope[0], cumulative(simd, at)[0]]
    }

    /// Shares that are left of one half, for these weights and weights of missing samples.
    #[inline(always)]
    fn left<S: Simd>(simd: S, weight: f32, missing: f32) -> f32 {
        let [weight, missing, own] = [weight, missing, 0.5].map(|value| f32x16::splat(simd, value));
        let mut weights = Weights {
            weight,
            gradient: [own; 3],
            own,
        };
        weights.leave_out(simd, missing, [own; 3]);
        weights.own[0]
    }

    #[test]
    fn missing_samples_take_their_share_of_the_weight() {
        for (weight, missing, expected) in [
            (1.0, 0.25, 0.375),
            (0.5, 0.5, 0.0),
            (0.5, 0.75, 0.0),
            (0.5, 0.0, 0.5),
            // Far outside nothing is missing: no quotient of zeros.
            (0.0, 0.0, 0.5),
        ] {
            let found = dispatch!(Level::new(), simd => left(simd, weight, missing));
            assert_eq!(found, expected, "{weight} {missing}");
        }
    }

    #[test]
    fn sums_over_the_lattice_are_those_of_its_points() {
        let mut random = Random::new(17);
        for _ in 0..2000 {
            let count = (random.unit() * 30.0).ceil().max(1.0);
            let sigma = 0.5 + 1.5 * random.unit();
            let at = -6.0 + (count + 12.0) * random.unit();
            let (mut sum, mut slope) = (0.0, 0.0);
            for j in 0..count as usize {
                let offset = at - j as f64;
                let density = normal::density(offset / sigma) / sigma;
                sum += density;
                slope -= density * offset / (sigma * sigma);
            }
            let [s, d, phi] =
                dispatch!(Level::new(), simd => found(simd, at as f32, count as f32, sigma as f32));
            // Less the terms beyond the cut, 4.5 standard deviations away on both sides.
            assert!(
                (f64::from(s) - sum).abs() < 1e-4,
                "{at} {count} {sigma}: {s} {sum}"
            );
            assert!(
                (f64::from(d) - slope).abs() < 5e-4,
                "{at} {count} {sigma}: {d} {slope}"
            );
            assert!(
                (f64::from(phi) - normal::cumulative(at)).abs() < 2e-6,
                "{at}: {phi}"
            );
        }
    }
}
