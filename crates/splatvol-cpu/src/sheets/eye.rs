//! Eye: the planes at and before a perspective camera's eye, where it lies within the visible volume.
//!
//! A plane at depth 0 has no scale: all pixels look from one point. The sums there, `S = sum_k c_k K(-u_k)` over
//! the voxels around the eye, and their gradient are computed once per tile,
//!
//! `K(d) = peak exp(-e^T L^-1 e / 2) (g(d_z) - edge)`, `e = d_xy - t d_z`, g the kernel's profile in depth
//!
//! in the notation of [`splatvol_core::footprint`]. All pixels see this one sample, so S is divided there by the sum
//! of K over all lattice points, whose ripple averages out on other planes. The plane at the eye holds S in every pixel. The plane before
//! it lies on the other side of the eye and is extrapolated along each pixel's ray by a cubic. The cubic has the
//! values v of the eye and the two planes in front of it, and at the eye the slope `s = t grad S . ray`, t the
//! planes' distance. Its value at the plane before is `-3 v_eye / 2 + 3 v_1 - v_2 / 2 - 3 s`. The gradient across
//! the axis at the eye is that of S, too.

use fearless_simd::{f32x16, prelude::*};
use glam::{DAffine3, DMat2, DVec2, DVec3};
use splatvol_core::brick::BRICK;
use splatvol_core::plan::{Bricks, GridView};
use splatvol_core::visibility::BRICK_VOXELS;

use super::frame::SheetFrame;
use super::mode::Mode;
use super::place::Place;
use super::plane::{HALO, Plane, Span};
use super::splat::Payload;
use super::tile::{MAX_CHANNELS, SheetScratch};

/// The kernel around the eye, and the bricks whose voxels reach it.
#[derive(Debug, Default)]
pub(crate) struct Eye {
    /// Indices, and first lattice points.
    bricks: Vec<(u32, [u32; 3])>,
    camera_from_lattice: DAffine3,
    /// `L^-1`.
    inverse: DMat2,
    slope: DVec2,
    /// Variance in depth, world length squared.
    variance: f64,
    edge: f64,
    peak: f64,
    /// Reach of a voxel, world length.
    reach: f64,
    /// Sum of the weights of an endless lattice at the eye, and its gradient.
    weights: (f64, DVec3),
}

/// Sums and their gradients, camera space, per world length.
#[derive(Debug, Clone, Copy)]
struct Jet<const N: usize> {
    value: [f64; N],
    gradient: [DVec3; N],
    /// Weight of missing samples and its gradient.
    missing: (f64, DVec3),
}

impl<const N: usize> Jet<N> {
    /// Means instead of sums, given the sum of all weights and its gradient.
    fn per_weights(self, (sum, slope): (f64, DVec3)) -> Self {
        let mean = |value: f64, gradient: DVec3| {
            let mean = value / sum;
            (mean, (gradient - mean * slope) / sum)
        };
        let means: [_; N] = std::array::from_fn(|n| mean(self.value[n], self.gradient[n]));
        Self {
            value: means.map(|mean| mean.0),
            gradient: means.map(|mean| mean.1),
            missing: mean(self.missing.0, self.missing.1),
        }
    }
}

impl Eye {
    /// Prepares the eye for a camera within a grid, given the kernel's peak on planes.
    pub(crate) fn update(&mut self, view: &GridView, peak: f64, bricks: &dyn Bricks) {
        let (shape, kernel) = (view.shape(), view.kernel());
        self.camera_from_lattice = view.camera_from_lattice();
        let [xx, xy, yy] = shape.lateral_covariance;
        self.inverse = DMat2::from_cols(DVec2::new(xx, xy), DVec2::new(xy, yy)).inverse();
        self.slope = shape.lateral_slope;
        self.variance = shape.depth_sigma * shape.depth_sigma;
        self.edge = kernel.edge;
        self.peak = peak;
        self.reach = view.planes_reach();
        let eye = self.camera_from_lattice.inverse().translation;
        // In voxels the kernel is a sphere.
        let far = DVec3::splat(kernel.sigma * libm::hypot(self.reach / shape.depth_sigma, LATERAL_CUT));
        self.weights = self.weights_between((eye - far).ceil(), (eye + far).floor());
        let meets = |index: usize| {
            let first = DVec3::from_array(bricks.first(index).map(f64::from));
            let last = first + (BRICK - 1) as f64;
            eye.cmpge(first - far).all() && eye.cmple(last + far).all()
        };
        self.bricks.clear();
        self.bricks.extend(
            (0..bricks.len())
                .filter(|&index| meets(index))
                .map(|index| (index as u32, bricks.first(index))),
        );
    }

    /// Sum of the weights of lattice points at the eye, and its gradient.
    fn weights_between(&self, first: DVec3, last: DVec3) -> (f64, DVec3) {
        let count = (last - first).to_array().map(|n| n as usize + 1);
        let (mut sum, mut slope) = (0.0, DVec3::ZERO);
        for i in 0..count.into_iter().product::<usize>() {
            let [x, y, z] = [i % count[0], i / count[0] % count[1], i / (count[0] * count[1])];
            let point = first + DVec3::new(x as f64, y as f64, z as f64);
            let (weight, gradient) = self.weight(-self.camera_from_lattice.transform_point3(point));
            sum += weight;
            slope += gradient;
        }
        (sum, slope)
    }

    /// Weight and its gradient at an offset from a voxel.
    fn weight(&self, offset: DVec3) -> (f64, DVec3) {
        let e = offset.truncate() - self.slope * offset.z;
        let q = self.inverse * e;
        let exponent = -0.5 * e.dot(q);
        if offset.z.abs() > self.reach || exponent < -0.5 * LATERAL_CUT * LATERAL_CUT {
            return (0.0, DVec3::ZERO);
        }
        let profile = libm::exp(-0.5 * offset.z * offset.z / self.variance);
        if profile <= self.edge {
            return (0.0, DVec3::ZERO);
        }
        let lateral = self.peak * libm::exp(exponent);
        let weight = lateral * (profile - self.edge);
        let along = self.slope.dot(q) * weight - lateral * profile * offset.z / self.variance;
        (weight, (-q * weight).extend(along))
    }

    /// Sums at the eye over the voxels around it.
    fn sums<S: Simd, M: Mode<N>, const N: usize>(
        &self,
        simd: S,
        (_frame, mode): (&SheetFrame<'_>, &M),
        scratch: &mut SheetScratch,
    ) -> Jet<N> {
        let mut jet = Jet {
            value: [0.0; N],
            gradient: [DVec3::ZERO; N],
            missing: (0.0, DVec3::ZERO),
        };
        let one = f32x16::splat(simd, 1.0);
        let mut values = [f32::NAN; BRICK_VOXELS];
        let slot = scratch.take_slot();
        for &(brick, first) in &self.bricks {
            mode.open(simd, (brick as usize, slot), &mut values, &mut scratch.classified);
            let payload = M::payload(&scratch.classified);
            let first = DVec3::from_array(first.map(f64::from));
            for (place, &value) in values.iter().enumerate().filter(|(_, value)| !value.is_nan()) {
                let within = [0, 1, 2].map(|axis| (place / BRICK.pow(axis) % BRICK) as f64);
                let at = self
                    .camera_from_lattice
                    .transform_point3(first + DVec3::from_array(within));
                let (weight, gradient) = self.weight(-at);
                if value == f32::INFINITY {
                    jet.missing.0 += weight;
                    jet.missing.1 += gradient;
                } else if weight > 0.0 {
                    let terms = payload.weights(simd, value, one, one);
                    for channel in 0..N {
                        let term = f64::from(terms[channel].as_slice()[0]);
                        jet.value[channel] += weight * term;
                        jet.gradient[channel] += gradient * term;
                    }
                }
            }
        }
        scratch.give_slot(slot);
        jet.per_weights(self.weights)
    }

    /// Computes the planes at and before the eye, given the two in front of it.
    #[inline(always)]
    pub(crate) fn make_planes<S: Simd, M: Mode<N>, const N: usize>(
        &self,
        simd: S,
        (frame, mode): (&SheetFrame<'_>, &M),
        place: &Place,
        scratch: &mut SheetScratch,
    ) {
        let jet = self.sums(simd, (frame, mode), scratch);
        scratch.at_eye = Some(jet.gradient[0].as_vec3().to_array());
        for channel in 0..N.min(MAX_CHANNELS) {
            let rise = (jet.gradient[channel] * frame.stack.spacing).as_vec3().to_array();
            let planes = scratch.planes.each_mut().map(|planes| &mut planes[channel]);
            continue_before(frame, place, planes, (jet.value[channel] as f32, rise));
        }
        if mode.has_holes() {
            let (weight, gradient) = jet.missing;
            let rise = (gradient * frame.stack.spacing).as_vec3().to_array();
            scratch.holes.at_eye = gradient.as_vec3().to_array();
            let planes = scratch.holes.planes.each_mut().map(|planes| &mut planes[0]);
            continue_before(frame, place, planes, (weight as f32, rise));
        }
    }
}

/// Fills a channel's planes at and before the eye. `rise`: its gradient, per distance of planes.
fn continue_before(
    frame: &SheetFrame<'_>,
    place: &Place,
    [before, eye, near, far]: [&mut Plane; 4],
    (value, rise): (f32, [f32; 3]),
) {
    before.clear();
    eye.clear();
    let [width, height] = place.size.map(|n| n + 2 * HALO);
    let [cx, cy] = frame.rays.principal;
    let image = |at: usize, first: usize, principal: f32| {
        ((first + at) as f32 + (0.5 - HALO as f32) - principal) * frame.rays.per_pixel
    };
    for y in 0..height {
        let down = image(y, place.rect.y0, cy);
        for x in 0..width {
            let at = y * near.pitch + x;
            let slope = rise[0] * image(x, place.rect.x0, cx) + rise[1] * down + rise[2];
            eye.values[at] = value;
            before.values[at] = 3.0 * (near.values[at] - slope) - 0.5 * (3.0 * value + far.values[at]);
        }
    }
    let all = Span {
        x0: 0,
        y0: 0,
        x1: width,
        y1: height,
    };
    (before.filled, eye.filled) = (Some(all), Some(all));
}

/// Lateral cut of kernels, standard deviations: beyond it they are below a ten thousandth of the peak.
const LATERAL_CUT: f64 = 4.5;
