//! The field of a kernel of the distance over a cube of samples, in f64: `v(x) = S / W`, `S = sum_k c_k h(|x - k|)`,
//! `W = sum_k h(|x - k|)`, as `splatvol_reference` defines it for Gaussians (docs/numerics.md, "The field").
//!
//! The lattice is continued by the outermost sample beyond each face. With the interpolating prefilter the coefficients
//! solve `sum_k c_k h(|i - k|) = F_i W(i)`, by conjugate gradients; without it they are the samples.

use std::ops::RangeInclusive;

use glam::DVec3;
use splatvol_core::radial::RadialKernel;

use crate::LabError;

/// Residual, as a share of the right-hand side, at which coefficients are accepted.
const ACCURACY: f64 = 1e-9;
/// Iterations after which a kernel counts as not invertible.
const MOST_ITERATIONS: usize = 2000;

/// A cube of samples as a continuous field.
pub(super) struct RadialField {
    kernel: RadialKernel,
    /// Samples per axis, repeated ones included.
    side: usize,
    /// x fastest.
    coefficients: Vec<f64>,
}

impl RadialField {
    /// The field of `side`^3 samples, x fastest.
    pub(super) fn new(
        kernel: RadialKernel,
        samples: &[f64],
        side: usize,
        prefilter: bool,
    ) -> Result<Self, LabError> {
        let nearest = |position: usize| position.saturating_sub(1).min(side - 1);
        let all = side + 2;
        let coefficients = (0..all.pow(3))
            .map(|index| [index % all, index / all % all, index / (all * all)].map(nearest))
            .map(|[x, y, z]| samples[(z * side + y) * side + x])
            .collect();
        let mut field = Self {
            kernel,
            side: all,
            coefficients,
        };
        if prefilter {
            field.solve()?;
        }
        Ok(field)
    }

    /// Value at a point in voxels, voxel (0, 0, 0) being the first of the samples.
    pub(super) fn value(&self, x: DVec3) -> f64 {
        let [s, w] = self.sums(x);
        s / w
    }

    /// Gradient of S per voxel, by central differences.
    pub(super) fn gradient(&self, x: DVec3) -> DVec3 {
        const STEP: f64 = 1e-4;
        let slope = |axis: DVec3| {
            let [above, below] = [self.sums(x + STEP * axis)[0], self.sums(x - STEP * axis)[0]];
            (above - below) / (2.0 * STEP)
        };
        DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z))
    }

    /// S and W.
    fn sums(&self, x: DVec3) -> [f64; 2] {
        let x = x + 1.0;
        let [ranges_x, ranges_y, ranges_z] = [x.x, x.y, x.z].map(|at| self.range(at));
        let mut sums = [0.0; 2];
        for k in ranges_z {
            for j in ranges_y.clone() {
                for i in ranges_x.clone() {
                    let offset = x - DVec3::new(i as f64, j as f64, k as f64);
                    let weight = self.kernel.value(offset.length());
                    sums[0] += weight * self.coefficients[(k * self.side + j) * self.side + i];
                    sums[1] += weight;
                }
            }
        }
        sums
    }

    fn range(&self, at: f64) -> RangeInclusive<usize> {
        let reach = self.kernel.support();
        let first = (at - reach).ceil().max(0.0) as usize;
        first..=((at + reach).floor().max(0.0) as usize).min(self.side - 1)
    }

    /// Replaces samples by coefficients.
    fn solve(&mut self) -> Result<(), LabError> {
        let weights = self.apply(&vec![1.0; self.coefficients.len()]);
        let right: Vec<f64> = self
            .coefficients
            .iter()
            .zip(weights)
            .map(|(f, w)| f * w)
            .collect();
        let target = ACCURACY * dot(&right, &right).sqrt();
        let mut residual: Vec<f64> = self.apply(&self.coefficients);
        for (r, b) in residual.iter_mut().zip(&right) {
            *r = b - *r;
        }
        let mut direction = residual.clone();
        let mut squared = dot(&residual, &residual);
        for _ in 0..MOST_ITERATIONS {
            if squared.sqrt() <= target {
                return Ok(());
            }
            let image = self.apply(&direction);
            let step = squared / dot(&direction, &image);
            add(&mut self.coefficients, step, &direction);
            add(&mut residual, -step, &image);
            let next = dot(&residual, &residual);
            let share = next / squared;
            for (d, r) in direction.iter_mut().zip(&residual) {
                *d = r + share * *d;
            }
            squared = next;
        }
        Err(LabError::Measurement(
            "prefilter: this kernel cannot be inverted".to_owned(),
        ))
    }

    /// `sum_k c_k h(|i - k|)` at every sample.
    fn apply(&self, values: &[f64]) -> Vec<f64> {
        let reach = self.kernel.support().ceil() as isize;
        let side = self.side as isize;
        let mut result = vec![0.0; values.len()];
        let offsets = || -reach..=reach;
        for [dx, dy, dz] in
            offsets().flat_map(|z| offsets().flat_map(move |y| offsets().map(move |x| [x, y, z])))
        {
            let weight = self.kernel.value(((dx * dx + dy * dy + dz * dz) as f64).sqrt());
            if weight == 0.0 {
                continue;
            }
            let inside = |d: isize| (-d).max(0)..(side - d).min(side);
            for z in inside(dz) {
                for y in inside(dy) {
                    let row = (z * side + y) * side;
                    let from = ((z + dz) * side + y + dy) * side + dx;
                    for x in inside(dx) {
                        result[(row + x) as usize] += weight * values[(from + x) as usize];
                    }
                }
            }
        }
        result
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn add(values: &mut [f64], factor: f64, others: &[f64]) {
    for (value, other) in values.iter_mut().zip(others) {
        *value += factor * other;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use splatvol::Kernel;
    use splatvol_testing::Random;

    fn random_cube(side: usize) -> Vec<f64> {
        let mut random = Random::new(4);
        (0..side.pow(3)).map(|_| random.unit()).collect()
    }

    #[test]
    fn a_prefiltered_field_passes_through_its_samples() {
        let samples = random_cube(9);
        for kernel in [Kernel::CrawfisMax, Kernel::CubicBspline, Kernel::KAISER_BESSEL] {
            let field = RadialField::new(RadialKernel::new(kernel), &samples, 9, true).unwrap();
            for (index, sample) in samples.iter().enumerate() {
                let at = DVec3::new((index % 9) as f64, (index / 9 % 9) as f64, (index / 81) as f64);
                assert!((field.value(at) - sample).abs() < 1e-6, "{kernel:?} {at}");
            }
        }
    }

    #[test]
    fn a_constant_stays_constant_and_a_field_without_prefilter_is_the_mean_of_its_samples() {
        let kernel = RadialKernel::new(Kernel::CubicBspline);
        let field = RadialField::new(kernel, &[0.3; 343], 7, false).unwrap();
        let at = DVec3::new(2.3, 3.7, 4.1);
        assert!((field.value(at) - 0.3).abs() < 1e-12);
        let samples = random_cube(7);
        let field = RadialField::new(kernel, &samples, 7, false).unwrap();
        let [mut s, mut w] = [0.0; 2];
        for (index, sample) in samples.iter().enumerate() {
            let k = DVec3::new((index % 7) as f64, (index / 7 % 7) as f64, (index / 49) as f64);
            s += sample * kernel.value((at - k).length());
            w += kernel.value((at - k).length());
        }
        assert!((field.value(at) - s / w).abs() < 1e-12);
    }
}
