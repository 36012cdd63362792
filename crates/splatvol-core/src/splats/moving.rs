//! Motion blur: footprints of kernels that move while the shutter is open.
//!
//! Time t runs from -1/2 to 1/2. In the plane across the ray, whitened so that the kernel is a unit circle, the
//! kernel's centre moves along a segment of the length L. The ray meets that plane u along the segment from its
//! middle, and v beside it. So at the time t its distance from the centre is `r^2 = v^2 + (u - t L)^2`, whatever
//! the conic of the footprint and its low-pass. For an affine footprint of conic Q whose centre moves by D pixels,
//! at the offset d,
//!
//! `L^2 = D^T Q D`, `u = d^T Q D / L`, `v^2 = |Q| (d x D)^2 / L^2`;
//!
//! for a true ray w (unit, whitened) past a centre c that moves by m, `L = |m - (m w) w|`,
//! `u = -(c m - (c w)(m w)) / L`, `v = (c x m) w / L`.
//!
//! * *exact*: the mean of the profile over the shutter, [`super::Profile::mean_along`]; of a Gaussian it is
//!   `sqrt(2 pi) / 2L exp(-v^2 / 2) [erf((u + L/2) / sqrt 2) - erf((u - L/2) / sqrt 2)]`;
//! * *capsule* (mueller1998 figure 11): the profile at the distance from the segment, dimmed by eq. 11,
//!   `A1 / (A1 + 2 l s) = pi s / (pi s + 2 L)` for a silhouette of radius s and the way L of its centre. As in the
//!   paper this is a factor on the opacity of a splat that is composited by itself, as `swan-alpha` is. Sheets and X-rays,
//!   which add splats up before anything is opaque, have no such opacity: there it is a factor on the optical depth. The capsule's
//!   energy is that of the still kernel times this factor and `1 + L l / E`, with l the profile's integral over a line and E over
//!   the plane. The product exceeds 1, as profiles fall off.
//!
//! Sections need the kernel's place along the ray while the pixel sees it. Of the times `t = (u - x) / L`, x is
//! normal within `u -+ L/2`, so the depth has the mean and the variance of that, times the rate at which it
//! changes.

use super::footprint::Sample;
use super::ray::Ray;

/// A kernel in motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moving {
    /// Its way.
    pub path: Path,
    /// Whether it is a capsule; otherwise the profile is integrated.
    pub capsule: bool,
}

/// The way of a kernel while the shutter is open.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Path {
    /// Motion of an affine footprint.
    Affine {
        /// From pixels to standard deviations, rows of the upper triangle: 00, 01, 11.
        whitening: [f32; 3],
        /// Depth of the ray's nearest point per pixel of offset.
        slope: [f32; 2],
        /// Displacement of the centre, whitened.
        displacement: [f32; 2],
        /// Change of the depth of the ray's nearest point.
        depth_change: f32,
    },
    /// Past true rays.
    Ray {
        /// The kernel in the shutter's middle.
        ray: Ray,
        /// Displacement of the centre, whitened camera space.
        displacement: [f32; 3],
    },
}

/// Passage of a moving kernel past a pixel's ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passage {
    /// Length of the path across the ray, standard deviations.
    pub length: f32,
    /// Position of the ray along the path, from its middle.
    pub along: f32,
    /// Squared distance of the ray from the line of the path.
    pub across_squared: f32,
    /// Factor on the weight.
    pub gain: f32,
    /// Depth of the ray's nearest point to the centre in the shutter's middle, and its change.
    depth: [f32; 2],
    depth_sigma: f32,
}

/// Length of a path, standard deviations, below which f32 shows no motion.
const STILL: f32 = 1e-4;

impl Moving {
    /// Factor on the opacity of a capsule whose centre moves by `length` and whose silhouette has the radius `cut`
    /// (mueller1998 eq. 11), both in standard deviations.
    #[inline(always)]
    pub(super) fn dimmed(length: f32, cut: f32) -> f32 {
        let half_around = std::f32::consts::PI * cut;
        half_around / (half_around + 2.0 * length)
    }

    /// Passage of the kernel past the ray through a point of the picture. `offset` is the point's from the centre,
    /// `depth` the centre's, with its standard deviation along the ray.
    #[inline(always)]
    pub fn passage(&self, pixel: [f32; 2], [dx, dy]: [f32; 2], depth: [f32; 2]) -> Passage {
        match self.path {
            Path::Affine {
                whitening: [a, b, c],
                slope,
                displacement: [mx, my],
                depth_change,
            } => {
                let (x, y) = (a * dx + b * dy, c * dy);
                Passage::new(
                    [x * x + y * y, x * mx + y * my, x * my - y * mx, mx * mx + my * my],
                    1.0,
                    [depth[0] + slope[0] * dx + slope[1] * dy, depth_change],
                    depth[1],
                )
            }
            Path::Ray { ray, displacement: m } => {
                let Sample {
                    squared,
                    gain,
                    depth,
                    depth_sigma,
                } = ray.at(pixel);
                // The ray's unit direction is `depth_sigma` times the one of unit depth.
                let w = ray.direction(pixel).map(|c| c * depth_sigma);
                let c = ray.centre;
                let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
                let rate = dot(m, w);
                let across: [f32; 3] = std::array::from_fn(|i| m[i] - rate * w[i]);
                let cross = [
                    c[1] * m[2] - c[2] * m[1],
                    c[2] * m[0] - c[0] * m[2],
                    c[0] * m[1] - c[1] * m[0],
                ];
                Passage::new(
                    [squared, -dot(c, across), dot(cross, w), dot(across, across)],
                    gain,
                    [depth, rate * depth_sigma],
                    depth_sigma,
                )
            }
        }
    }
}

/// Rows of the upper triangle U with `U^T U` a conic xx, xy, yy.
#[inline(always)]
pub fn whitening([xx, xy, yy]: [f32; 3]) -> [f32; 3] {
    let [wide, mixed, tall] = [xx, xy, yy].map(f64::from);
    let first = wide.sqrt();
    let shear = mixed / first;
    // In f64: the difference is small for long and thin footprints.
    [first, shear, (tall - shear * shear).max(0.0).sqrt()].map(|v| v as f32)
}

impl Passage {
    /// From `d d`, `d m`, `d x m` and `m m` of an offset d and a displacement m, whitened and across the ray.
    #[inline(always)]
    fn new([squared, dot, cross, moved]: [f32; 4], gain: f32, depth: [f32; 2], depth_sigma: f32) -> Self {
        let (length, along, across_squared) = if moved > STILL * STILL {
            let length = moved.sqrt();
            (length, dot / length, cross * cross / moved)
        } else {
            (0.0, 0.0, squared)
        };
        Self {
            length,
            along,
            across_squared,
            gain,
            depth,
            depth_sigma,
        }
    }

    /// Squared distance from the way itself.
    #[inline(always)]
    pub fn nearest_squared(&self) -> f32 {
        let beyond = (self.along.abs() - 0.5 * self.length).max(0.0);
        self.across_squared + beyond * beyond
    }

    /// Mean and standard deviation of the depth at which the ray meets the kernel.
    #[inline(always)]
    pub fn depth(&self) -> [f32; 2] {
        let [depth, change] = self.depth;
        if change == 0.0 {
            return [depth, self.depth_sigma];
        }
        let [mean, variance] = self.times();
        let sigma = self.depth_sigma;
        [
            depth + change * mean,
            (sigma * sigma + change * change * variance).sqrt(),
        ]
    }

    /// Mean and variance of the times at which the ray sees a Gaussian kernel pass.
    #[inline(always)]
    fn times(&self) -> [f32; 2] {
        let Self { length, along, .. } = *self;
        if length < SHORT {
            // Over so short a way, the Gaussian is a slope.
            let tilt = along * length / 12.0;
            return [tilt.clamp(-0.5, 0.5), 1.0 / 12.0];
        }
        let (a, b) = (along - 0.5 * length, along + 0.5 * length);
        let mass = cumulative(b) - cumulative(a);
        if mass < LEAST_MASS {
            // Past an end, the kernel is seen when it is there.
            return [0.5 * along.signum(), 0.0];
        }
        let (at_a, at_b) = (density(a), density(b));
        let mean = (at_a - at_b) / mass;
        let variance = 1.0 + (a * at_a - b * at_b) / mass - mean * mean;
        let per_length = 1.0 / length;
        [
            ((along - mean) * per_length).clamp(-0.5, 0.5),
            (variance * per_length * per_length).clamp(0.0, 0.25),
        ]
    }
}

/// Ways, in standard deviations, over which a Gaussian is a slope.
const SHORT: f32 = 0.3;
/// Mass of the Gaussian below which its mean would be the rounding of two tails.
const LEAST_MASS: f32 = 1e-4;

#[inline(always)]
fn density(x: f32) -> f32 {
    const PEAK: f32 = 0.398_942_3;
    PEAK * libm::expf(-0.5 * x * x)
}

/// Standard normal distribution, Abramowitz and Stegun 26.2.17: absolute error 8e-8.
#[inline(always)]
fn cumulative(x: f32) -> f32 {
    let t = 1.0 / (1.0 + 0.231_641_9 * x.abs());
    let mut p = 1.330_274_5;
    for coefficient in [-1.821_255_9, 1.781_478, -0.356_563_78, 0.319_381_54] {
        p = p * t + coefficient;
    }
    let tail = density(x) * p * t;
    if x < 0.0 { tail } else { 1.0 - tail }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::normal;

    #[test]
    fn the_polynomial_is_the_normal_distribution() {
        for i in -600..=600 {
            let x = f64::from(i) * 0.01;
            let error = f64::from(cumulative(x as f32)) - normal::cumulative(x);
            assert!(error.abs() < 5e-7, "{x}: {error}");
        }
    }

    /// The depth along the ray against sums over the shutter.
    #[test]
    fn depths_are_those_at_which_the_kernel_passes() {
        for (length, along) in [
            (0.0, 0.0),
            (0.2, 1.5),
            (0.5, -2.0),
            (2.0, 0.3),
            (6.0, 2.0),
            (12.0, -6.5),
        ] {
            let passage = Passage {
                length,
                along,
                across_squared: 0.7,
                gain: 1.0,
                depth: [10.0, 3.0],
                depth_sigma: 0.5,
            };
            let (mut mass, mut first, mut second) = (0.0, 0.0, 0.0);
            for i in 0..4000 {
                let t = (f64::from(i) + 0.5) / 4000.0 - 0.5;
                let x = f64::from(along) - t * f64::from(length);
                let weight = (-0.5 * x * x).exp();
                let depth = 10.0 + 3.0 * t;
                mass += weight;
                first += weight * depth;
                second += weight * depth * depth;
            }
            let mean = first / mass;
            let sigma = (second / mass - mean * mean + 0.25).sqrt();
            let [found, found_sigma] = passage.depth().map(f64::from);
            assert!((found - mean).abs() < 0.01, "{length} {along}: {found} {mean}");
            assert!(
                (found_sigma - sigma).abs() < 0.01,
                "{length} {along}: {found_sigma} {sigma}"
            );
        }
    }
}
