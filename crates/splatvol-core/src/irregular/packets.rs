//! Packets of sixteen kernels, in vector layout.
//!
//! With `V = C C^T` (Cholesky) a kernel of mass m has the density `m p 2^-|F d|^2` at an offset d from its centre,
//! where `F = C^-1 sqrt(log2(e) / 2)` is lower triangular and `p = |2 pi V|^(-1/2)`. Numbers are of 32 bits.
//! Centres and places are offsets from nearby origins, so that rounding is small beside the kernels' widths however
//! far the mesh lies from zero.
//!
//! Sums are the same at every SIMD level: no operation is fused, and terms are added in the order of the kernels.

use fearless_simd::{Level, dispatch, f32x16, prelude::*};
use glam::DVec3;

use super::Sample;
use super::normalise::REACH_SQUARED;
use super::whitening::whitening;
use crate::exponential::exp2;

/// Kernels of a packet, and places of a block.
pub(super) const LANES: usize = 16;

/// Largest `|F d|^2` within a kernel's reach.
const REACH: f32 = (0.5 * REACH_SQUARED * std::f64::consts::LOG2_E) as f32;
/// Factor on the search distance for kernels that reach a block, for rounding.
const MARGIN: f32 = 1.001;

/// A kernel ready to be evaluated.
#[derive(Debug, Clone, Copy)]
pub(super) struct Evaluated {
    pub(super) position: DVec3,
    /// Rows of F: xx, yx, yy, zx, zy, zz.
    factor: [f32; 6],
    /// Peak of the density for mass 1; 0 for samples without a kernel.
    pub(super) peak: f64,
}

impl Evaluated {
    pub(super) fn new(sample: &Sample) -> Self {
        let determinant = sample.covariance.determinant();
        let is_legal = sample.valid && determinant > 0.0 && determinant.is_normal();
        let factor = if is_legal { factor(sample) } else { None };
        let volume = ((2.0 * std::f64::consts::PI).powi(3) * determinant).sqrt();
        Self {
            position: sample.position,
            factor: factor.unwrap_or_default(),
            peak: if factor.is_some() { volume.recip() } else { 0.0 },
        }
    }

    pub(super) fn is_legal(&self) -> bool {
        self.peak > 0.0
    }
}

/// F of a sample's covariance; `None` if that is not positive definite.
fn factor(sample: &Sample) -> Option<[f32; 6]> {
    let w = whitening(&sample.covariance)? * (0.5 * std::f64::consts::LOG2_E).sqrt();
    let rows = [
        w.x_axis.x, w.x_axis.y, w.y_axis.y, w.x_axis.z, w.y_axis.z, w.z_axis.z,
    ];
    let rows = rows.map(|entry| entry as f32);
    rows.iter().all(|entry| entry.is_finite()).then_some(rows)
}

/// Kernels, number by number.
#[derive(Debug, Clone, Copy)]
pub(super) struct Packet {
    origin: DVec3,
    centres: [[f32; LANES]; 3],
    factors: [[f32; LANES]; 6],
}

impl Packet {
    /// No kernels yet, around an origin.
    pub(super) fn around(origin: DVec3) -> Self {
        Self {
            origin,
            centres: [[0.0; LANES]; 3],
            factors: [[0.0; LANES]; 6],
        }
    }

    /// Stores a kernel's shape at a place.
    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, kernel: &Evaluated, centre: DVec3) {
        let offset = (centre - self.origin).as_vec3();
        for axis in 0..3 {
            self.centres[axis][lane] = offset[axis];
        }
        for (entries, entry) in self.factors.iter_mut().zip(kernel.factor) {
            entries[lane] = entry;
        }
    }

    #[inline(always)]
    fn offsets_to<S: Simd>(&self, simd: S, [x, y, z]: [f32; 3]) -> [f32x16<S>; 3] {
        let [cx, cy, cz] = self.centres;
        [
            x - f32x16::simd_from(simd, cx),
            y - f32x16::simd_from(simd, cy),
            z - f32x16::simd_from(simd, cz),
        ]
    }

    /// The factors of all kernels, a kernel per lane.
    #[inline(always)]
    fn all_factors<S: Simd>(&self, simd: S) -> [f32x16<S>; 6] {
        let [a, b, c, d, e, f] = self.factors;
        [
            f32x16::simd_from(simd, a),
            f32x16::simd_from(simd, b),
            f32x16::simd_from(simd, c),
            f32x16::simd_from(simd, d),
            f32x16::simd_from(simd, e),
            f32x16::simd_from(simd, f),
        ]
    }

    /// The factor of one kernel in all lanes.
    #[inline(always)]
    fn factor<S: Simd>(&self, simd: S, lane: usize) -> [f32x16<S>; 6] {
        let [a, b, c, d, e, f] = &self.factors;
        [
            f32x16::splat(simd, a[lane]),
            f32x16::splat(simd, b[lane]),
            f32x16::splat(simd, c[lane]),
            f32x16::splat(simd, d[lane]),
            f32x16::splat(simd, e[lane]),
            f32x16::splat(simd, f[lane]),
        ]
    }
}

/// Places near each other, whose sums are computed together.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block {
    pub(super) low: DVec3,
    pub(super) high: DVec3,
    /// Offsets from the middle of `low` and `high`.
    offsets: [[f32; LANES]; 3],
}

impl Block {
    /// Up to [`LANES`] places.
    pub(super) fn new(places: impl ExactSizeIterator<Item = DVec3> + Clone) -> Self {
        let (low, high) = places
            .clone()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), place| {
                (low.min(place), high.max(place))
            });
        let middle = low.midpoint(high);
        let mut offsets = [[0.0; LANES]; 3];
        for (lane, place) in places.enumerate() {
            let offset = (place - middle).as_vec3();
            for axis in 0..3 {
                offsets[axis][lane] = offset[axis];
            }
        }
        Self { low, high, offsets }
    }

    /// The sums of weighted kernels at the places.
    pub(super) fn sums<'a>(
        &self,
        level: Level,
        packets: impl Iterator<Item = (&'a Packet, &'a [f32; LANES])>,
    ) -> [f32; LANES] {
        dispatch!(level, simd => self.sums_with(simd, packets))
    }

    #[inline(always)]
    fn sums_with<'a, S: Simd>(
        &self,
        simd: S,
        packets: impl Iterator<Item = (&'a Packet, &'a [f32; LANES])>,
    ) -> [f32; LANES] {
        let middle = self.low.midpoint(self.high);
        let half = (0.5 * (self.high - self.low)).as_vec3().to_array();
        let [x, y, z] = self.offsets;
        let offsets = [
            f32x16::simd_from(simd, x),
            f32x16::simd_from(simd, y),
            f32x16::simd_from(simd, z),
        ];
        let reach = f32x16::splat(simd, REACH);
        let mut sums = f32x16::splat(simd, 0.0);
        for (packet, weights) in packets {
            let shift = (middle - packet.origin).as_vec3().to_array();
            let mut near = reaching(simd, (packet, weights), shift, half);
            let [x, y, z] = [
                offsets[0] + shift[0],
                offsets[1] + shift[1],
                offsets[2] + shift[2],
            ];
            while near != 0 {
                let lane = near.trailing_zeros() as usize;
                near &= near - 1;
                let [cx, cy, cz] = [
                    packet.centres[0][lane],
                    packet.centres[1][lane],
                    packet.centres[2][lane],
                ];
                let exponent = squared([x - cx, y - cy, z - cz], packet.factor(simd, lane));
                let term = exp2(simd, -exponent) * weights[lane];
                sums += exponent.simd_le(reach).select(term, f32x16::splat(simd, 0.0));
            }
        }
        sums.into()
    }
}

/// The sum of weighted kernels at one place.
pub(super) fn sum_at(level: Level, place: DVec3, packets: &[Packet], weights: &[[f32; LANES]]) -> f64 {
    dispatch!(level, simd => sum_at_with(simd, place, packets, weights))
}

#[inline(always)]
fn sum_at_with<S: Simd>(simd: S, place: DVec3, packets: &[Packet], weights: &[[f32; LANES]]) -> f64 {
    let reach = f32x16::splat(simd, REACH);
    let mut sums = f32x16::splat(simd, 0.0);
    for (packet, weights) in packets.iter().zip(weights) {
        let shift = (place - packet.origin).as_vec3().to_array();
        let exponent = squared(packet.offsets_to(simd, shift), packet.all_factors(simd));
        let term = exp2(simd, -exponent) * f32x16::simd_from(simd, *weights);
        sums += exponent.simd_le(reach).select(term, f32x16::splat(simd, 0.0));
    }
    let sums: [f32; LANES] = sums.into();
    sums.into_iter().map(f64::from).sum()
}

/// The kernels of a packet that may reach a box of half sizes `half` around `middle`, as bits:
/// `|F d| <= reach + r`, with r the greatest length of `F d` for an offset d within the box.
#[inline(always)]
fn reaching<S: Simd>(
    simd: S,
    (packet, weights): (&Packet, &[f32; LANES]),
    middle: [f32; 3],
    half: [f32; 3],
) -> u64 {
    let factors = packet.all_factors(simd);
    let distance = squared(packet.offsets_to(simd, middle), factors);
    let [a, b, c, d, e, f] = factors;
    let sizes = [a.abs(), b.abs(), c.abs(), d.abs(), e.abs(), f.abs()];
    let [x, y, z] = half;
    let half = [
        f32x16::splat(simd, x),
        f32x16::splat(simd, y),
        f32x16::splat(simd, z),
    ];
    let limit = squared(half, sizes).sqrt() + REACH.sqrt() * MARGIN;
    let weighs = f32x16::simd_from(simd, *weights).simd_gt(f32x16::splat(simd, 0.0));
    (distance.simd_le(limit * limit) & weighs).to_bitmask()
}

/// `|F d|^2`.
#[inline(always)]
fn squared<S: Simd>([x, y, z]: [f32x16<S>; 3], factor: [f32x16<S>; 6]) -> f32x16<S> {
    let [xx, yx, yy, zx, zy, zz] = factor;
    let first = xx * x;
    let second = yx * x + yy * y;
    let third = zx * x + zy * y + zz * z;
    first * first + second * second + third * third
}

#[cfg(test)]
mod tests {
    use glam::DMat3;
    use splatvol_testing::Random;

    use super::*;

    /// Places and kernels far from zero, flat and tilted kernels, against the formula with the inverse in 64 bits.
    #[test]
    fn sums_are_those_of_the_inverse_covariance() {
        let mut random = Random::new(41);
        let far = DVec3::new(3000.0, -500.0, 40.0);
        let cube = |random: &mut Random, size: f64| random.point(DVec3::splat(-size), DVec3::splat(size));
        let samples: Vec<Sample> = (0..LANES)
            .map(|_| {
                let map = DMat3::from_cols(
                    cube(&mut random, 1.0),
                    cube(&mut random, 0.5),
                    cube(&mut random, 0.1),
                );
                Sample {
                    position: far + cube(&mut random, 2.0),
                    covariance: map * map.transpose() + DMat3::from_diagonal(DVec3::splat(1e-3)),
                    mass: 0.1 + random.unit(),
                    gradient: DVec3::ZERO,
                    value: 0.0,
                    valid: true,
                }
            })
            .collect();
        let kernels: Vec<Evaluated> = samples.iter().map(Evaluated::new).collect();
        let mut packet = Packet::around(far + DVec3::ONE);
        let mut weights = [0.0; LANES];
        for (lane, (kernel, sample)) in kernels.iter().zip(&samples).enumerate() {
            packet.set(lane, kernel, kernel.position);
            weights[lane] = (kernel.peak * sample.mass) as f32;
        }
        let (mut seen, mut greatest) = (0, 0.0f64);
        for _ in 0..200 {
            let middle = far + cube(&mut random, 3.0);
            let places: Vec<DVec3> = (0..LANES).map(|_| middle + cube(&mut random, 0.4)).collect();
            let found =
                Block::new(places.iter().copied()).sums(Level::new(), [(&packet, &weights)].into_iter());
            for (&place, found) in places.iter().zip(found) {
                let term = |sample: &Sample| {
                    let offset = place - sample.position;
                    let squared = offset.dot(sample.covariance.inverse() * offset);
                    let peak =
                        ((2.0 * std::f64::consts::PI).powi(3) * sample.covariance.determinant()).sqrt();
                    // On the edge of its reach either is right.
                    let on_edge = (squared - REACH_SQUARED).abs() < 1e-2;
                    let value = sample.mass / peak * (-0.5 * squared).exp();
                    let within = if squared <= REACH_SQUARED { value } else { 0.0 };
                    (within, if on_edge { value } else { 0.0 })
                };
                let (expected, slack) = samples
                    .iter()
                    .map(term)
                    .fold((0.0, 0.0), |(sum, slack), (a, b)| (sum + a, slack + b));
                let alone = sum_at(Level::new(), place, &[packet], &[weights]);
                for found in [f64::from(found), alone] {
                    let error = (found - expected).abs() - slack;
                    assert!(error <= 1e-4 * expected + 1e-12, "{found} {expected}");
                    greatest = greatest.max(error / expected.max(1e-9));
                }
                seen += usize::from(expected > 0.0);
            }
        }
        println!("greatest relative error {greatest:.1e}");
        assert!(seen > 500, "{seen}");
    }

    #[test]
    fn every_level_finds_the_same_bits() {
        let mut random = Random::new(42);
        let mut packet = Packet::around(DVec3::ZERO);
        let mut weights = [0.0; LANES];
        for (lane, weight) in weights.iter_mut().enumerate() {
            let sides = random.point(DVec3::splat(0.1), DVec3::ONE);
            let sample = Sample {
                position: random.point(DVec3::splat(-1.0), DVec3::ONE),
                covariance: DMat3::from_diagonal(sides),
                mass: 1.0,
                gradient: DVec3::ZERO,
                value: 0.0,
                valid: true,
            };
            let kernel = Evaluated::new(&sample);
            packet.set(lane, &kernel, kernel.position);
            *weight = kernel.peak as f32;
        }
        let places: Vec<DVec3> = (0..LANES)
            .map(|_| random.point(DVec3::splat(-1.0), DVec3::ONE))
            .collect();
        let block = Block::new(places.iter().copied());
        let sums = |level| {
            block
                .sums(level, [(&packet, &weights)].into_iter())
                .map(f32::to_bits)
        };
        assert_eq!(sums(Level::new()), sums(Level::baseline()));
        let alone = |level| sum_at(level, places[0], &[packet], &[weights]).to_bits();
        assert_eq!(alone(Level::new()), alone(Level::baseline()));
    }
}
