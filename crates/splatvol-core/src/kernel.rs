//! Reconstruction kernels in voxel space (docs/numerics.md, "The field").
//!
//! `h(x) = g(x) g(y) g(z) / (sum_j g(j))^3`, a Gaussian cut at `radius` along each axis and normalised to unit sum
//! over the lattice. The papers' kernel `exp(-1.38 r^2)` is sigma = 0.602. zwicker2001 section 6 cuts at two sigma and
//! loses 13.5 % of the mass; our presets cut at four, or at three and subtract half of what is left there
//! ([`GaussianKernel::windowed`]).

use splatvol_scene::Kernel;

use crate::normal::{density, mass_within};
use crate::radial::RadialKernel;

/// A Gaussian kernel with its derived numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussianKernel {
    /// Standard deviation, voxels.
    pub sigma: f64,
    /// Cut-off along each axis, voxels.
    pub radius: f64,
    /// Edge subtracted from the profile: half its value at the radius, or zero.
    pub edge: f64,
    /// Sum of the profile over the integers within the radius.
    pub lattice_sum: f64,
}

impl GaussianKernel {
    /// The kernel of the settings. A kernel of another kind is represented by the Gaussian of its standard
    /// deviation and support; this gives its reach, not its values. Engines that evaluate this type accept
    /// Gaussians only.
    pub fn new(kernel: Kernel) -> Self {
        let (sigma, radius) = moments(kernel);
        Self::with_edge(sigma, radius, 0.0)
    }

    /// As [`Self::new`], less half the value at the radius, so that the kernel ends with half the step. With sigma
    /// 0.64 and radius 2 its sum over the lattice ripples by 1e-3; all of the step off, it is too narrow, and none
    /// off, its sum ripples by 5e-3. A step of less than a thousandth of the peak is kept: it is smaller than the
    /// effect of the window.
    pub fn windowed(kernel: Kernel) -> Self {
        let (sigma, radius) = moments(kernel);
        let step = profile(radius, sigma);
        Self::with_edge(sigma, radius, if step < LEAST_STEP { 0.0 } else { 0.5 * step })
    }

    fn with_edge(sigma: f64, radius: f64, edge: f64) -> Self {
        let reach = radius.floor() as i32;
        let lattice_sum = (-reach..=reach)
            .map(|j| profile(f64::from(j), sigma) - edge)
            .sum();
        Self {
            sigma,
            radius,
            edge,
            lattice_sum,
        }
    }

    /// Extends the radius to at least so many standard deviations, if the cut only saves time and is not part of
    /// the kernel: beyond four standard deviations.
    #[must_use]
    pub fn without_tails_cut(self, deviations: f64) -> Self {
        let radius = self.radius.max(deviations * self.sigma);
        if self.edge == 0.0 && self.cut() >= 4.0 && radius > self.radius {
            Self::with_edge(self.sigma, radius, 0.0)
        } else {
            self
        }
    }

    /// Cut-off in standard deviations.
    pub fn cut(&self) -> f64 {
        self.radius / self.sigma
    }

    /// One axis' factor of h at an integer offset: the tap of the discrete filter.
    pub fn tap(&self, offset: usize) -> f64 {
        let offset = offset as f64;
        if offset > self.radius {
            0.0
        } else {
            (profile(offset, self.sigma) - self.edge) / self.lattice_sum
        }
    }

    /// Integer reach of the discrete filter.
    pub fn reach(&self) -> usize {
        self.radius.floor() as usize
    }

    /// Standard deviation of a Gaussian that has the variance of this one once it is cut at the radius: of a cut at c
    /// deviations `1 - 2 c phi(c) / (2 Phi(c) - 1)` of the variance is left.
    pub fn sigma_before_cut(&self) -> f64 {
        let left = |c: f64| 1.0 - 2.0 * c * density(c) / mass_within(c);
        let wider = |sigma: f64| self.sigma / left(self.radius / sigma).sqrt();
        // Each step leaves a tenth of the error and less, where the cut is not part of the kernel.
        let before = (0..STEPS).fold(self.sigma, |sigma, _| wider(sigma));
        before.min(MOST_WIDER * self.sigma)
    }

    /// Integral of the profile, less its edge, within a reach and where it is not negative, voxels.
    pub fn integral_within(&self, reach: f64) -> f64 {
        let end = match self.edge {
            0.0 => reach,
            edge => reach.min(self.sigma * (-2.0 * libm::log(edge)).sqrt()),
        };
        let whole = (2.0 * std::f64::consts::PI).sqrt() * self.sigma;
        whole * mass_within(end / self.sigma) - 2.0 * end * self.edge
    }

    /// Integral of h over space, in voxels, without the cut: 1 up to the ripple (3e-4 for sigma 0.7).
    pub fn mass(&self) -> f64 {
        ((2.0 * std::f64::consts::PI).sqrt() * self.sigma / self.lattice_sum).powi(3)
    }
}

/// Steps to the deviation before a cut.
const STEPS: usize = 4;
/// Deviations that are wider by more belong to kernels whose cut, at 2.6 deviations and less, is a part of them.
const MOST_WIDER: f64 = 1.05;

/// Steps below this share of the peak are not windowed away.
const LEAST_STEP: f64 = 1e-3;

/// Standard deviation along an axis and radius.
fn moments(kernel: Kernel) -> (f64, f64) {
    kernel.gaussian().unwrap_or_else(|| {
        let radial = RadialKernel::new(kernel);
        (radial.sigma(), radial.support())
    })
}

fn profile(offset: f64, sigma: f64) -> f64 {
    libm::exp(-0.5 * (offset / sigma).powi(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn taps_sum_to_one_and_the_mass_is_one_up_to_the_ripple() {
        for (sigma, radius) in [(0.6, 2.0), (0.7, 3.0), (0.7, 3.5), (1.0, 4.0)] {
            let kernel = GaussianKernel::new(Kernel::Gaussian { sigma, radius });
            let sum = kernel.tap(0) + 2.0 * (1..=kernel.reach()).map(|j| kernel.tap(j)).sum::<f64>();
            assert!((sum - 1.0).abs() < 1e-12);
            // Poisson summation: the ripple's amplitude per axis is 2 exp(-2 pi^2 sigma^2), plus the cut's tail.
            let ripple =
                2.0 * (-2.0 * (std::f64::consts::PI * sigma).powi(2)).exp() + 2e-3 * f64::from(radius < 2.5);
            assert!(
                (kernel.mass() - 1.0).abs() < 3.2 * ripple + 1e-4,
                "{sigma} {radius} {}",
                kernel.mass()
            );
        }
    }
    #[test]
    fn a_cut_gaussian_has_the_variance_of_the_whole_one() {
        for (sigma, radius, error) in [(0.64, 2.0, 1e-5), (0.74, 3.0, 1e-8), (1.2, 6.0, 1e-8)] {
            let before = GaussianKernel::new(Kernel::Gaussian { sigma, radius }).sigma_before_cut();
            let points = (0..20_000).map(|i| (f64::from(i) + 0.5) / 20_000.0 * radius);
            let (mass, second) = points.fold((0.0, 0.0), |(mass, second), x| {
                let weight = profile(x, before);
                (mass + weight, second + weight * x * x)
            });
            let found = second / mass / (sigma * sigma);
            println!("{sigma} cut at {radius}: {before}, {found}");
            assert!((found - 1.0).abs() < error, "{sigma} {radius}: {before}, {found}");
        }
    }

    #[test]
    fn integrals_are_those_of_the_profile() {
        let kernel = |sigma, radius| GaussianKernel::windowed(Kernel::Gaussian { sigma, radius });
        for (kernel, reach) in [
            (kernel(0.64, 2.0), 2.0),
            (kernel(0.64, 2.0), 3.0),
            (kernel(0.74, 3.0), 3.5),
        ] {
            let points = (0..40_000).map(|i| (f64::from(i) + 0.5) / 40_000.0 * reach);
            let sum: f64 = points
                .map(|x| (profile(x, kernel.sigma) - kernel.edge).max(0.0))
                .sum();
            let expected = 2.0 * sum * reach / 40_000.0;
            let found = kernel.integral_within(reach);
            assert!(
                (found - expected).abs() < 1e-7,
                "{kernel:?} {reach}: {found} {expected}"
            );
        }
    }
}
