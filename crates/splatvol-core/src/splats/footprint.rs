//! Footprint: map from a pixel to the radius at which its ray passes the kernel.
//!
//! A pixel receives `weight gain profile(r^2)`, world length: the line integral along its ray of a kernel whose
//! integral over space is its cell. The alignments differ in the map from pixels to `r^2`, the [`Warp`].

use super::moving::{Moving, Passage};
use super::profile::Profile;
use super::ray::{Ray, Trapezoid};

/// A splat projected to the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Footprint {
    /// Projected centre, pixels.
    pub centre: [f32; 2],
    /// Bounding box of the footprint's pixels: x0, y0, x1, y1, pixels.
    pub bounds: [f32; 4],
    /// Line integral through the centre, world length, where the warp's gain is 1.
    pub weight: f32,
    /// Factor on a splat's opacity (`swan-alpha`, capsules in motion), which is a factor in `weight`, too; 1 otherwise.
    pub opacity: f32,
    /// Camera depth of the centre.
    pub depth: f32,
    /// Standard deviation in depth along a ray.
    pub depth_sigma: f32,
    /// Camera depth at which the kernel is clipped if it reaches before the near plane; minus infinity otherwise.
    pub clip: f32,
    /// From pixels to radii.
    pub warp: Warp,
}

/// Passage of a pixel's ray through a kernel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Squared distance of the ray from the centre, standard deviations of the kernel.
    pub squared: f32,
    /// Factor on the weight.
    pub gain: f32,
    /// Camera depth of the point of the ray that is nearest to the centre.
    pub depth: f32,
    /// Standard deviation in depth along the ray.
    pub depth_sigma: f32,
}

/// Maps from pixels to radii.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Warp {
    /// `r^2 = d^T Q d`, d the pixel's offset from the centre.
    Affine {
        /// Conic Q: xx, xy, yy, per pixel squared.
        conic: [f32; 3],
        /// Depth of the ray's nearest point per pixel of offset.
        slope: [f32; 2],
    },
    /// The true distance of the pixel's ray from the centre.
    Ray(Ray),
    /// The distance at which the pixel's ray passes the plane across the ray through the centre.
    Perpendicular(Ray),
    /// The true distance from a kernel whose width grows with depth.
    Trapezoid(Trapezoid),
    /// The distance from a kernel in motion: see [`Moving`].
    Moving(Moving),
}

impl Footprint {
    /// Passage through the kernel of the ray through a point of the picture (pixels). A kernel whose width varies
    /// with depth is taken with the width at its centre.
    #[inline(always)]
    pub fn at(&self, [px, py]: [f32; 2]) -> Sample {
        match self.warp {
            Warp::Affine { conic, slope } => {
                let (dx, dy) = (px - self.centre[0], py - self.centre[1]);
                let [xx, xy, yy] = conic;
                Sample {
                    squared: xx * dx * dx + 2.0 * xy * dx * dy + yy * dy * dy,
                    gain: 1.0,
                    depth: self.depth + slope[0] * dx + slope[1] * dy,
                    depth_sigma: self.depth_sigma,
                }
            }
            Warp::Ray(ray) => ray.at([px, py]),
            Warp::Perpendicular(ray) => ray.at_plane([px, py], self.clip),
            Warp::Trapezoid(trapezoid) => trapezoid.at([px, py]),
            // Where the kernel comes nearest: the rest of its passage is farther away.
            Warp::Moving(moving) => {
                let passage = self.passage(&moving, [px, py]);
                let [depth, depth_sigma] = passage.depth();
                Sample {
                    squared: passage.nearest_squared(),
                    gain: passage.gain,
                    depth,
                    depth_sigma,
                }
            }
        }
    }

    /// Passage past this footprint's moving kernel of the ray through a point of the picture (pixels).
    #[inline(always)]
    pub fn passage(&self, moving: &Moving, [px, py]: [f32; 2]) -> Passage {
        let offset = [px - self.centre[0], py - self.centre[1]];
        moving.passage([px, py], offset, [self.depth, self.depth_sigma])
    }

    /// Line integral along the ray through a point of the picture (pixels), world length; between two camera depths
    /// if a section is given.
    #[inline(always)]
    pub fn integral<P: Profile>(&self, profile: &P, section: Option<[f32; 2]>, pixel: [f32; 2]) -> f32 {
        let section = self.section(section);
        if let Warp::Trapezoid(trapezoid) = &self.warp {
            return self.weight * trapezoid.integral(profile, section, pixel);
        }
        let sample = self.at(pixel);
        // False where a square is not a number.
        if sample.squared < profile.cut() * profile.cut() {
            self.weight * sample.gain * sample.share(profile, section)
        } else {
            0.0
        }
    }

    /// Clips a section at the near plane.
    #[inline(always)]
    pub fn section(&self, section: Option<[f32; 2]>) -> Option<[f32; 2]> {
        match section {
            Some([near, far]) => Some([near.max(self.clip), far.max(self.clip)]),
            None if self.clip > f32::NEG_INFINITY => Some([self.clip, f32::INFINITY]),
            None => None,
        }
    }
}

impl Sample {
    /// The profile here, or the part of it between two camera depths.
    #[inline(always)]
    pub(super) fn share<P: Profile>(&self, profile: &P, section: Option<[f32; 2]>) -> f32 {
        match section {
            None => profile.whole(self.squared),
            Some([near, far]) => {
                let inverse = 1.0 / self.depth_sigma.max(1e-20);
                profile.between(
                    self.squared,
                    (near - self.depth) * inverse,
                    (far - self.depth) * inverse,
                )
            }
        }
    }
}
