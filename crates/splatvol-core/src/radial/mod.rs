//! Radial kernels, their footprints, and footprint tables, for splatting with any kernel.
//!
//! `h(r)`, r in voxels, has unit integral over space. So the mean of `sum_k h(x - k)` over the unit cell is 1
//! (Poisson summation); its deviation is the ripple measured by [`analyse`]. The footprint is the line integral
//! `q(rho^2) = int h(sqrt(rho^2 + z^2)) dz` (westover1990; huang2000 section 2.1).
//!
//! Two of the kernels differ from others of the same name. The Gaussian is cut at a distance, where
//! [`crate::kernel`] cuts along each axis. The cubic B-spline is `beta3(r)`, not the usual product
//! `beta3(x) beta3(y) beta3(z)`, whose footprint would change with the direction of view.

mod analysis;
mod blob;
mod piecewise;
mod quadrature;
mod section;
mod table;
#[cfg(test)]
mod tests;

use std::f64::consts::{FRAC_PI_2, PI, SQRT_2};

use splatvol_scene::Kernel;

use blob::Blob;
use piecewise::PiecewiseCubic;
use quadrature::integral;

pub use analysis::{KernelAnalysis, RESPONSE_FREQUENCIES, analyse};
pub use section::{AnySection, Entry, Section};
pub use table::{FootprintTable, Precision, Spacing, TableSettings};

/// A radially symmetric kernel in space, of unit integral. Lengths are voxels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RadialKernel {
    profile: Profile,
    support: f64,
    /// One over the profile's integral over space.
    scale: f64,
}

/// h up to a factor.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Profile {
    Gaussian { sigma: f64 },
    Piecewise(PiecewiseCubic),
    Blob(Blob),
}

impl RadialKernel {
    /// The kernel of the settings, whose parameters are within their domain ([`Kernel::validate`]).
    pub fn new(kernel: Kernel) -> Self {
        let (profile, support) = match kernel {
            Kernel::Gaussian { sigma, radius } => (Profile::Gaussian { sigma }, radius),
            Kernel::CrawfisMax => Self::piecewise(PiecewiseCubic::crawfis_max()),
            Kernel::CubicBspline => Self::piecewise(PiecewiseCubic::cubic_bspline()),
            Kernel::KaiserBessel { radius, alpha } => (Profile::Blob(Blob { radius, alpha }), radius),
        };
        let mut kernel = Self {
            profile,
            support,
            scale: 1.0,
        };
        kernel.scale = 1.0 / kernel.moment(0);
        kernel
    }

    fn piecewise(cubic: PiecewiseCubic) -> (Profile, f64) {
        (Profile::Piecewise(cubic), cubic.support())
    }

    /// Distance beyond which h is zero.
    pub fn support(&self) -> f64 {
        self.support
    }

    /// h at a distance, per cubic voxel. It is zero at the support itself: otherwise six voxels at exactly that
    /// distance, and only at such points, would add a ripple to the cut Gaussian that no picture shows.
    pub fn value(&self, r: f64) -> f64 {
        if r < self.support { self.uncut(r) } else { 0.0 }
    }

    /// h at a distance within the support.
    fn uncut(&self, r: f64) -> f64 {
        self.scale
            * match self.profile {
                Profile::Gaussian { sigma } => libm::exp(-0.5 * (r / sigma).powi(2)),
                Profile::Piecewise(cubic) => cubic.value(r),
                Profile::Blob(blob) => blob.value(r),
            }
    }

    /// The footprint `q(rho^2)`, per square voxel: h integrated along a line that passes the centre at the distance
    /// rho.
    pub fn line_integral(&self, rho2: f64) -> f64 {
        2.0 * self.half_line(rho2, self.support)
    }

    /// The part of [`RadialKernel::line_integral`] in front of the depth z, which is zero at the centre: `int_-inf^z`.
    pub fn partial_line_integral(&self, rho2: f64, z: f64) -> f64 {
        let rest = self.half_line(rho2, z.abs());
        self.half_line(rho2, self.support) + if z < 0.0 { -rest } else { rest }
    }

    /// `int_0^z h dz`, z >= 0.
    fn half_line(&self, rho2: f64, z: f64) -> f64 {
        let chord2 = self.support * self.support - rho2;
        if chord2 <= 0.0 {
            return 0.0;
        }
        let z = z.min(chord2.sqrt());
        self.scale
            * match self.profile {
                Profile::Gaussian { sigma } => {
                    let across = libm::exp(-0.5 * rho2 / (sigma * sigma));
                    across * sigma * FRAC_PI_2.sqrt() * libm::erf(z / (SQRT_2 * sigma))
                }
                Profile::Piecewise(cubic) => cubic.half_line(rho2, z),
                Profile::Blob(blob) => blob.half_line(rho2, z),
            }
    }

    /// Standard deviation along any axis.
    pub fn sigma(&self) -> f64 {
        (self.moment(2) / 3.0).sqrt()
    }

    /// Frequency response: the Fourier transform of h at `frequency` cycles per voxel, the same in all directions and 1
    /// at 0. `H(f) = 2 / f int r h(r) sin(2 pi f r) dr`.
    pub fn response(&self, frequency: f64) -> f64 {
        if frequency == 0.0 {
            return 1.0;
        }
        let wave = 2.0 * PI * frequency;
        2.0 / frequency * self.over_distance(|r| r * self.value(r) * libm::sin(wave * r))
    }

    /// `int r^power h dV`.
    fn moment(&self, power: i32) -> f64 {
        4.0 * PI * self.over_distance(|r| r.powi(2 + power) * self.value(r))
    }

    /// `int_0^support f(r) dr`, between the places where h is not smooth, and in pieces of a voxel at most.
    fn over_distance(&self, f: impl Fn(f64) -> f64) -> f64 {
        let knot = match self.profile {
            Profile::Piecewise(cubic) => cubic.knot(),
            Profile::Gaussian { .. } | Profile::Blob(_) => self.support,
        };
        [(0.0, knot), (knot, self.support)]
            .into_iter()
            .map(|(from, to)| {
                let count = (to - from).ceil();
                let step = (to - from) / count.max(1.0);
                (0..count as u32)
                    .map(|i| from + step * f64::from(i))
                    .map(|start| integral(start, start + step, &f))
                    .sum::<f64>()
            })
            .sum()
    }
}
