//! Weight of the lattice points beyond the end of a lattice.
//!
//! At a distance d within the end, half a voxel beyond the last point, the points that are there weigh
//! `sum_j g(d - 1/2 - j)` and those that would follow `sum_j g(d + 1/2 + j)`, j = 0, 1, ..., g the kernel. Their
//! ratio is `M / (1 - M)`, so that `1 / W = 1 + M / (1 - M)`. Its logarithm is nearly a straight line: a
//! polynomial through its values at Chebyshev's nodes, once per frame, saves the sums. An integral instead of the
//! sums, `Phi(d)`, would be 2 % off at the box's face.

use fearless_simd::{f32x16, prelude::*};

use crate::exponential::{exp2, exp2_of};

/// `log2 (M / (1 - M))` as a polynomial.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Beyond {
    /// Coefficients, highest power first.
    coefficients: [f32; NODES],
}

const NODES: usize = 8;
/// Distances from the end of the lattice, standard deviations, between which the ratio is computed: outside, less
/// than [`super::FADED`] of the kernel is left, and farther inside next to nothing is missing.
const OUTSIDE: f32 = 1.2;
const FARTHEST: f32 = 4.0;
/// Lattice points that are added up: the widest kernel is [`FARTHEST`] times less wide.
const POINTS: usize = 40;
/// Argument of the polynomial, -1 to 1, per standard deviation, and at the end of the lattice.
const PER_SIGMA: f32 = 2.0 / (OUTSIDE + FARTHEST);
const AT_END: f32 = OUTSIDE * PER_SIGMA - 1.0;

impl Beyond {
    /// `sigma`: standard deviation of the kernel, voxels.
    pub(super) fn new(sigma: f64) -> Self {
        let nodes: [f64; NODES] =
            std::array::from_fn(|i| libm::cos(std::f64::consts::PI * (i as f64 + 0.5) / NODES as f64));
        let values = nodes.map(|u| log2_ratio((u - f64::from(AT_END)) / f64::from(PER_SIGMA) * sigma, sigma));
        let coefficients = through(&nodes, values).map(|c| c as f32);
        Self { coefficients }
    }

    /// `M / (1 - M)` at sixteen distances within the lattice's end, standard deviations.
    #[inline(always)]
    pub(super) fn ratio<S: Simd>(&self, simd: S, distance: f32x16<S>) -> f32x16<S> {
        let one = f32x16::splat(simd, 1.0);
        let u = (distance * PER_SIGMA + AT_END).max(-one).min(one);
        let mut power = f32x16::splat(simd, self.coefficients[0]);
        for &coefficient in &self.coefficients[1..] {
            power = power * u + coefficient;
        }
        exp2(simd, power)
    }

    /// Scalar version of [`Self::ratio`].
    pub(super) fn ratio_of(&self, distance: f32) -> f32 {
        let u = (distance * PER_SIGMA + AT_END).clamp(-1.0, 1.0);
        exp2_of(self.coefficients.iter().fold(0.0, |power, c| power * u + c))
    }
}

/// `log2 (M / (1 - M))` at a distance within the lattice's end, voxels.
fn log2_ratio(distance: f64, sigma: f64) -> f64 {
    let log2_sum = |first: f64, step: f64| {
        let exponents: [f64; POINTS] = std::array::from_fn(|j| {
            let at = (first + step * j as f64) / sigma;
            -0.5 * std::f64::consts::LOG2_E * at * at
        });
        let most = exponents.into_iter().fold(f64::NEG_INFINITY, f64::max);
        most + libm::log2(exponents.into_iter().map(|e| libm::exp2(e - most)).sum())
    };
    log2_sum(distance + 0.5, 1.0) - log2_sum(distance - 0.5, -1.0)
}

/// Coefficients, highest power first, of the polynomial with given values at its nodes (Newton's divided
/// differences).
fn through(nodes: &[f64; NODES], values: [f64; NODES]) -> [f64; NODES] {
    let mut differences = values;
    for order in 1..NODES {
        for i in (order..NODES).rev() {
            differences[i] = (differences[i] - differences[i - 1]) / (nodes[i] - nodes[i - order]);
        }
    }
    let mut coefficients = [0.0; NODES];
    for i in (0..NODES).rev() {
        // The polynomial so far times (u - node), and the next difference.
        for power in 0..NODES {
            let lower = coefficients.get(power + 1).copied().unwrap_or(0.0);
            coefficients[power] = lower - nodes[i] * coefficients[power];
        }
        coefficients[NODES - 1] += differences[i];
    }
    coefficients
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};

    use super::*;

    #[inline(always)]
    fn lane<S: Simd>(simd: S, beyond: &Beyond, distance: f32) -> f32 {
        beyond.ratio(simd, f32x16::splat(simd, distance))[3]
    }

    #[test]
    fn weights_are_those_of_the_lattice() {
        for sigma in [0.3, 0.5, 0.605, 0.64, 0.74, 1.0, 1.2] {
            let beyond = Beyond::new(sigma);
            let mut worst = 0.0f64;
            for i in 0..=1040 {
                let distance = i as f32 * 0.005 - OUTSIDE;
                let at = f64::from(distance) * sigma;
                let sum = |points: std::ops::Range<i32>| -> f64 {
                    points
                        .map(|j| libm::exp(-0.5 * ((at - 0.5 - f64::from(j)) / sigma).powi(2)))
                        .sum()
                };
                // The end is at 0, the lattice's points at 1/2, 3/2, and so on.
                let weight = sum(0..20) / sum(-20..20);
                let ratio = dispatch!(Level::new(), simd => lane(simd, &beyond, distance));
                assert_eq!(
                    ratio.to_bits(),
                    beyond.ratio_of(distance).to_bits(),
                    "{sigma} {distance}"
                );
                worst = worst.max((f64::from(1.0 + ratio) * weight - 1.0).abs());
            }
            println!("sigma {sigma}: 1 / W to {worst:.1e}");
            // Of narrow kernels the logarithm is a chain of lines.
            let limit = if sigma < 0.6 { 1e-2 } else { 1e-3 };
            assert!(worst < limit, "{sigma}: {worst:.1e}");
        }
    }
}
