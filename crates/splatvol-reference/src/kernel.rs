//! The reconstruction kernel and its low-passed form, in voxel space.
//!
//! `h(x) = g(x) g(y) g(z) / (sum_j g(j))^3`, `g(t) = exp(-t^2 / 2 sigma^2)` for abs(t) <= radius. With the EWA
//! low-pass the Gaussian gets the covariance `C = sigma^2 I + (pixel_sigma / s)^2 M^-1 diag(1, 1, 0) M^-T` and keeps
//! its mass:
//!
//! `h_C(x) = sigma^3 / (sqrt|C| (sum_j g(j))^3) exp(-x^T C^-1 x / 2)`, cut at `radius / sigma` standard deviations
//! along each voxel axis, which is h itself where C = sigma^2 I.

use glam::{DMat3, DVec3};
use splatvol_scene::Kernel;

use crate::ReferenceError;

/// The cut Gaussian h.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GaussianKernel {
    /// Standard deviation, voxels.
    pub(crate) sigma: f64,
    /// Cut-off along each axis, voxels.
    pub(crate) radius: f64,
    /// `sum_j g(j)` over the integers.
    lattice_sum: f64,
}

impl GaussianKernel {
    /// # Errors
    /// A kernel that is not a Gaussian: the reference knows no other.
    pub(crate) fn new(kernel: &Kernel) -> Result<Self, ReferenceError> {
        let name = kernel.name();
        let (sigma, radius) = kernel.gaussian().ok_or(ReferenceError::Kernel { name })?;
        let mut gaussian = Self {
            sigma,
            radius,
            lattice_sum: 1.0,
        };
        let last = radius.ceil() as i64;
        gaussian.lattice_sum = (-last..=last).map(|j| gaussian.factor(j as f64)).sum();
        Ok(gaussian)
    }

    /// One factor of h: `g(t) / sum_j g(j)`.
    pub(crate) fn factor(&self, t: f64) -> f64 {
        if t.abs() > self.radius {
            return 0.0;
        }
        (-0.5 * (t / self.sigma).powi(2)).exp() / self.lattice_sum
    }

    /// Derivative of [`GaussianKernel::factor`] within the cut.
    pub(crate) fn factor_slope(&self, t: f64) -> f64 {
        -t / (self.sigma * self.sigma) * self.factor(t)
    }

    /// The low-passed kernel of a covariance in voxel space.
    pub(crate) fn with_covariance(&self, covariance: DMat3) -> FilteredKernel {
        let deviations = self.radius / self.sigma;
        let variances = DVec3::new(covariance.x_axis.x, covariance.y_axis.y, covariance.z_axis.z);
        FilteredKernel {
            conic: covariance.inverse(),
            peak: (self.sigma / self.lattice_sum).powi(3) / covariance.determinant().sqrt(),
            reach: deviations * DVec3::new(variances.x.sqrt(), variances.y.sqrt(), variances.z.sqrt()),
        }
    }
}

/// h convolved with the low-pass of one camera depth.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FilteredKernel {
    /// Inverse covariance, voxel space.
    pub(crate) conic: DMat3,
    /// Value at the centre.
    pub(crate) peak: f64,
    /// Cut-off along each axis, voxels.
    pub(crate) reach: DVec3,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernel_sums_to_one_on_the_lattice() {
        let kernel = GaussianKernel::new(&Kernel::default()).expect("a Gaussian");
        let sum: f64 = (-5..=5).map(|j| kernel.factor(f64::from(j))).sum();
        assert!((sum - 1.0).abs() < 1e-15);
    }

    #[test]
    fn without_low_pass_the_filtered_kernel_is_h() {
        let kernel = GaussianKernel::new(&Kernel::default()).expect("a Gaussian");
        let filtered = kernel.with_covariance(DMat3::from_diagonal(DVec3::splat(kernel.sigma.powi(2))));
        let x = DVec3::new(0.3, -1.1, 0.7);
        let h = kernel.factor(x.x) * kernel.factor(x.y) * kernel.factor(x.z);
        let value = filtered.peak * (-0.5 * x.dot(filtered.conic * x)).exp();
        assert!((value / h - 1.0).abs() < 1e-12);
        assert!((filtered.reach - DVec3::splat(kernel.radius)).length() < 1e-12);
    }
}
