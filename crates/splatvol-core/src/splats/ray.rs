//! A kernel in perspective: whitened camera space, where it is a unit sphere.
//!
//! W being the inverse of the covariance's Cholesky factor, a pixel's ray `d = (x, y, 1)` has the direction
//! `w = W d` and the kernel the centre `c = W u`. The ray passes it at `r = |c x w| / |w|`, and a piece of it of
//! length `|d|` is `|w|` standard deviations long (the alignment `exact`; mueller1998 table 1, rows 2 and 3).
//! The practical ray-perpendicular footprint (row 4) is a disc across c, which the ray meets at
//! `p = w |c|^2 / (w . c) - c`, so `r = |p| = |c x w| |c| / (w . c)`, and all rays pass it as the one through the
//! centre does. In two dimensions and with spheres this is the paper's
//! `(z_v y_p - y_v z_k) sqrt(y_v^2 + z_v^2) / (z_v z_k + y_p y_v)`; it prints a minus in the denominator.
//!
//! Rays are stored as their offset from the one through the centre, whose cross product with c vanishes. In 32 bits
//! `c x w` would lose `|c|` times as much to rounding; `|c|` is the distance in standard deviations.
//!
//! Under a [`Trapezoid`] (row 1) the kernel at the depth z is wider by `a(z) = max(1, z / z_k)` and thinner by
//! `1 / a^2`. Profiles are given by their sections, so the integral is a sum of sections, each with the a of its
//! middle. For a constant a it is exact, and otherwise wrong by less than 1e-4 of the peak where a deviation is a
//! tenth of the distance.

use super::footprint::Sample;
use super::profile::Profile;

/// A kernel in perspective.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// W: the inverse of the covariance's Cholesky factor, rows of the lower triangle: 00, 10, 11, 20, 21, 22.
    pub whitening: [f32; 6],
    /// The kernel's centre, whitened.
    pub centre: [f32; 3],
    /// Point from which rays are offset, pixels: the projected centre, or the principal point where the centre has
    /// no projection.
    pub origin: [f32; 2],
    /// x and y per depth of the ray there.
    pub along: [f32; 2],
    /// Its direction, whitened.
    pub towards: [f32; 3],
    /// `c x towards`: the residual from rounding the origin.
    pub moment: [f32; 3],
    /// Rays' x and y per pixel at depth 1.
    pub per_pixel: f32,
}

/// A kernel that the swan filter stretches as needed at each depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trapezoid {
    /// The kernel before the stretch.
    pub ray: Ray,
    /// `1 / z_k`: the stretch per camera depth.
    pub per_depth: f32,
    /// Camera depth of the centre.
    pub depth: f32,
    /// Camera depths that the kernel reaches.
    pub reach: [f32; 2],
}

/// Sections of a trapezoid's integral over all that the kernel reaches.
const SECTIONS: f32 = 16.0;

type Vector = [f32; 3];

#[inline(always)]
fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[inline(always)]
fn dot(a: Vector, b: Vector) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl Ray {
    /// The pixel's direction of unit depth, whitened.
    #[inline(always)]
    pub(super) fn direction(&self, pixel: [f32; 2]) -> Vector {
        self.through(pixel).1
    }

    /// A vector of camera space, whitened.
    #[inline(always)]
    pub(super) fn whitened(&self, [x, y, z]: Vector) -> Vector {
        let [a, b, c, d, e, f] = self.whitening;
        [a * x, b * x + c * y, d * x + e * y + f * z]
    }

    /// The ray's x and y per depth, `w`, and `|c x w|^2`.
    #[inline(always)]
    fn through(&self, [px, py]: [f32; 2]) -> ([f32; 2], Vector, f32) {
        let x = (px - self.origin[0]) * self.per_pixel;
        let y = (py - self.origin[1]) * self.per_pixel;
        let [a, b, c, d, e, _] = self.whitening;
        let offset = [a * x, b * x + c * y, d * x + e * y];
        let [mx, my, mz] = cross(self.centre, offset);
        let moment = [mx + self.moment[0], my + self.moment[1], mz + self.moment[2]];
        let [tx, ty, tz] = self.towards;
        (
            [self.along[0] + x, self.along[1] + y],
            [tx + offset[0], ty + offset[1], tz + offset[2]],
            dot(moment, moment),
        )
    }

    /// Passage of the ray through a point of the picture (pixels) through the kernel.
    #[inline(always)]
    pub fn at(&self, pixel: [f32; 2]) -> Sample {
        let ([x, y], w, moment) = self.through(pixel);
        let inverse = 1.0 / dot(w, w);
        let depth_sigma = inverse.sqrt();
        Sample {
            squared: moment * inverse,
            gain: (1.0 + x * x + y * y).sqrt() * depth_sigma,
            depth: dot(self.centre, w) * inverse,
            depth_sigma,
        }
    }

    /// Passage through the disc across the ray through the centre, clipped at a camera depth, and empty behind the
    /// eye.
    #[inline(always)]
    pub fn at_plane(&self, pixel: [f32; 2], clip: f32) -> Sample {
        let (_, w, moment) = self.through(pixel);
        let along = dot(self.centre, w);
        let far = dot(self.centre, self.centre);
        let depth = far / along;
        let depth_sigma = 1.0 / dot(self.towards, self.towards).sqrt();
        let [x, y] = self.along;
        Sample {
            squared: if along > 0.0 && depth >= clip {
                moment * far / (along * along)
            } else {
                f32::INFINITY
            },
            gain: (1.0 + x * x + y * y).sqrt() * depth_sigma,
            depth,
            depth_sigma,
        }
    }

    /// The rays relative to a kernel stretched in x and y, for rays whose origin is the projected centre.
    #[inline(always)]
    fn stretched(&self, stretch: f32, depth: f32) -> Self {
        let shrink = 1.0 / stretch;
        let [a, b, c, d, e, f] = self.whitening;
        let [x, y] = self.along;
        let towards = [
            a * shrink * x,
            shrink * (b * x + c * y),
            shrink * (d * x + e * y) + f,
        ];
        Self {
            whitening: [a * shrink, b * shrink, c * shrink, d * shrink, e * shrink, f],
            centre: towards.map(|v| v * depth),
            towards,
            moment: [0.0; 3],
            ..*self
        }
    }
}

impl Trapezoid {
    #[inline(always)]
    fn stretch(&self, depth: f32) -> f32 {
        (self.per_depth * depth).max(1.0)
    }

    /// Passage of a ray through the kernel, with the kernel's width at its centre everywhere.
    #[inline(always)]
    pub fn at(&self, pixel: [f32; 2]) -> Sample {
        let stretch = self.stretch(self.depth);
        let sample = self.ray.stretched(stretch, self.depth).at(pixel);
        Sample {
            gain: sample.gain / (stretch * stretch),
            ..sample
        }
    }

    /// The line integral, in units of the footprint's weight.
    #[inline(always)]
    pub fn integral<P: Profile>(&self, profile: &P, section: Option<[f32; 2]>, pixel: [f32; 2]) -> f32 {
        let [near, far] = section.unwrap_or([f32::NEG_INFINITY, f32::INFINITY]);
        let (first, last) = (near.max(self.reach[0]), far.min(self.reach[1]));
        let whole = self.reach[1] - self.reach[0];
        let count = (SECTIONS * (last - first) / whole).ceil().clamp(1.0, SECTIONS);
        let step = (last - first) / count;
        let limit = profile.cut() * profile.cut();
        let mut sum = 0.0;
        for index in 0..count as usize {
            let before = first + index as f32 * step;
            let stretch = self.stretch(before + 0.5 * step);
            let sample = self.ray.stretched(stretch, self.depth).at(pixel);
            if sample.squared < limit {
                // The first section begins at `near`, and the last ends at `far`.
                let from = if index == 0 { near } else { before };
                let to = if index + 1 == count as usize {
                    far
                } else {
                    before + step
                };
                sum += sample.gain * sample.share(profile, Some([from, to])) / (stretch * stretch);
            }
        }
        sum
    }
}
