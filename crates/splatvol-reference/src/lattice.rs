//! Sums over the samples: `sum_k p_k h(x - k)` of N numbers per sample, and their gradients in voxel space.

use std::ops::RangeInclusive;

use glam::{DMat3, DVec3};

use crate::kernel::GaussianKernel;

/// Most samples that a cut kernel of the widest legal radius (32 voxels) can reach along an axis.
const MAX_TAPS: usize = 66;

/// N numbers per voxel, x fastest.
#[derive(Debug, Clone)]
pub(crate) struct Lattice<const N: usize> {
    pub(crate) dims: [usize; 3],
    pub(crate) payload: Vec<[f64; N]>,
}

/// The N sums at a point, and the gradient of the first in voxel space.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LatticeSums<const N: usize> {
    pub(crate) sums: [f64; N],
    pub(crate) gradient: DVec3,
}

/// `sums += weight * payload`.
fn add<const N: usize>(sums: &mut [f64; N], weight: f64, payload: &[f64; N]) {
    for (sum, value) in sums.iter_mut().zip(payload) {
        *sum += weight * value;
    }
}

impl<const N: usize> Lattice<N> {
    /// Sums with the kernel itself: the box cut and a product of three factors.
    pub(crate) fn sums(&self, kernel: &GaussianKernel, x: DVec3) -> LatticeSums<N> {
        let ranges: [_; 3] = std::array::from_fn(|axis| self.range(axis, x[axis], kernel.radius));
        let mut factors = [[0.0; MAX_TAPS]; 3];
        let mut slopes = [[0.0; MAX_TAPS]; 3];
        for axis in 0..3 {
            for (tap, k) in ranges[axis].clone().enumerate().take(MAX_TAPS) {
                factors[axis][tap] = kernel.factor(x[axis] - k as f64);
                slopes[axis][tap] = kernel.factor_slope(x[axis] - k as f64);
            }
        }
        let [gx, gy, gz] = &factors;
        let [dx, dy, dz] = &slopes;
        let mut total = LatticeSums {
            sums: [0.0; N],
            gradient: DVec3::ZERO,
        };
        for (c, k) in ranges[2].clone().enumerate() {
            for (b, j) in ranges[1].clone().enumerate() {
                // The sum over x of this row, and of its derivative; y and z are factors outside.
                let mut row = [0.0; N];
                let mut row_slope = 0.0;
                for (a, payload) in self.row(&ranges[0], j, k).iter().enumerate() {
                    add(&mut row, gx[a], payload);
                    row_slope += dx[a] * payload[0];
                }
                add(&mut total.sums, gy[b] * gz[c], &row);
                total.gradient += DVec3::new(
                    row_slope * gy[b] * gz[c],
                    row[0] * dy[b] * gz[c],
                    row[0] * gy[b] * dz[c],
                );
            }
        }
        total
    }

    /// Sums with the kernel low-passed to a covariance (voxel space): one exponential per sample.
    pub(crate) fn filtered_sums(
        &self,
        kernel: &GaussianKernel,
        covariance: DMat3,
        x: DVec3,
    ) -> LatticeSums<N> {
        let kernel = kernel.with_covariance(covariance);
        let ranges: [_; 3] = std::array::from_fn(|axis| self.range(axis, x[axis], kernel.reach[axis]));
        let mut total = LatticeSums {
            sums: [0.0; N],
            gradient: DVec3::ZERO,
        };
        for k in ranges[2].clone() {
            for j in ranges[1].clone() {
                for (i, payload) in ranges[0].clone().zip(self.row(&ranges[0], j, k)) {
                    let offset = x - DVec3::new(i as f64, j as f64, k as f64);
                    let normal = kernel.conic * offset;
                    let weight = kernel.peak * (-0.5 * offset.dot(normal)).exp();
                    add(&mut total.sums, weight, payload);
                    total.gradient -= weight * payload[0] * normal;
                }
            }
        }
        total
    }

    /// Voxels of one axis within `reach` of `x`.
    fn range(&self, axis: usize, x: f64, reach: f64) -> RangeInclusive<i64> {
        let last = self.dims[axis] as i64 - 1;
        ((x - reach).ceil().max(0.0) as i64)..=((x + reach).floor() as i64).min(last)
    }

    fn row(&self, range: &RangeInclusive<i64>, j: i64, k: i64) -> &[[f64; N]] {
        if range.is_empty() {
            return &[];
        }
        let start = (k as usize * self.dims[1] + j as usize) * self.dims[0];
        &self.payload[start + *range.start() as usize..=start + *range.end() as usize]
    }
}
