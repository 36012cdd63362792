//! The reconstruction kernel.

use serde::{Deserialize, Serialize};

/// Reconstruction kernel, in voxel space. docs/kernels.md compares them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kernel {
    /// `exp(-r^2 / 2 sigma^2)`, normalised to unit lattice sum. Where it is a product of three axes it is cut at
    /// `radius` along each; where it is a radial kernel, at the distance `radius`.
    Gaussian {
        /// Standard deviation, voxels.
        sigma: f64,
        /// Cut-off, voxels.
        radius: f64,
    },
    /// The piecewise cubic of Crawfis and Max, of radius 1.556 voxels: the smallest footprint.
    CrawfisMax,
    /// The cubic B-spline as a function of the distance from the voxel (not the product of three axes), of radius 2.
    CubicBspline,
    /// Lewitt's generalised Kaiser-Bessel window of order 2, a "blob".
    KaiserBessel {
        /// Radius, voxels.
        radius: f64,
        /// Shape: 0 is broad, large values are narrow and smooth.
        alpha: f64,
    },
}

impl Default for Kernel {
    fn default() -> Self {
        Self::Gaussian {
            sigma: 0.74,
            radius: 3.0,
        }
    }
}

impl Kernel {
    /// [`Kernel::kaiser_bessel`] of radius 2.
    pub const KAISER_BESSEL: Self = Self::KaiserBessel {
        radius: 2.0,
        alpha: 10.444_255_683_092_527,
    };

    /// The Kaiser-Bessel kernel of a radius in voxels whose frequency response is zero at one cycle per voxel,
    /// where the first alias of a constant lies: this alpha has the least ripple of all.
    /// `alpha^2 = (2 pi radius)^2 - x^2`, x being the first zero of the Bessel function of order 7/2; alpha is 0
    /// where the radius is too small for that.
    pub fn kaiser_bessel(radius: f64) -> Self {
        const FIRST_ZERO: f64 = 6.987_932_000_500_519;
        let zero = 2.0 * std::f64::consts::PI * radius;
        let alpha = (zero * zero - FIRST_ZERO * FIRST_ZERO).max(0.0).sqrt();
        Self::KaiserBessel { radius, alpha }
    }

    /// Name, as settings spell it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gaussian { .. } => "gaussian",
            Self::CrawfisMax => "crawfis-max",
            Self::CubicBspline => "cubic-bspline",
            Self::KaiserBessel { .. } => "kaiser-bessel",
        }
    }

    /// Sigma and radius in voxels, where the kernel is a Gaussian.
    pub fn gaussian(self) -> Option<(f64, f64)> {
        match self {
            Self::Gaussian { sigma, radius } => Some((sigma, radius)),
            Self::CrawfisMax | Self::CubicBspline | Self::KaiserBessel { .. } => None,
        }
    }
}
