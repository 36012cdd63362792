//! Border: coverage at the faces of the volume (docs/numerics.md, `q`).
//!
//! Per axis the kernel's share on the box is `Phi((x + 1/2) / s) - Phi((x - n + 1/2) / s)`, and its share on the
//! lattice, which continues the box by a margin, is `1 - M`, M that of the points beyond its end (`beyond`). Only
//! vectors of pixels near a face are evaluated; elsewhere both are one. `Phi(x) = 1 / (1 + 2^-(2.3048 x + 0.1018 x^3))`
//! has an error of less than 2e-4.

mod beyond;

use crate::bin::TileRect;
use fearless_simd::{f32x16, mask32x16, prelude::*};
use glam::{Affine3A, DAffine3, Mat3A, Vec3, Vec3A};

use crate::exponential::{exp2, exp2_of};
use beyond::Beyond;

/// The volume's box in camera space.
#[derive(Debug, Clone)]
pub struct Border {
    /// Voxels from the box's first corner.
    corner_from_camera: Affine3A,
    /// Voxels along x, y, z.
    size: Vec3,
    /// Lattice points beyond the box along x, y, z.
    margin: Vec3,
    /// Standard deviation of the kernel, voxels.
    sigma: f32,
    /// Weight of the points beyond the lattice.
    beyond: Beyond,
}

/// Shares of the kernel at sixteen points.
#[derive(Debug, Clone, Copy)]
pub struct Shares<S: Simd> {
    /// Coverage, 0 to 1.
    pub coverage: f32x16<S>,
    /// One over the share on the lattice.
    pub per_weight: f32x16<S>,
}

/// Shares on the lattice below this lie so far outside the volume that their values are ignored.
pub const FADED: f32 = 0.15;
/// Factor on the limit of one over a share: what was cut at [`FADED`] and divided is less by rounding.
const NEARLY: f32 = 0.999;
/// Kernel's share on the box between a coverage of 0 and of 1: the last hundredth on either side is left out, so that
/// coverage reaches both (docs/numerics.md, `q`).
pub const RAMP: f32 = 0.98;
/// Margin of the tests of whole tiles, standard deviations: their corners are rounded differently from their
/// pixels.
const TILE_SLACK: f32 = 0.01;
/// From the first of sixteen pixels to the last.
const LAST_LANE: f32 = 15.0;
/// `Phi(x) = 1 / (1 + 2^-(LINEAR x + CUBIC x^3))`, to 2e-4; beyond `END` it is 0 or 1.
const LINEAR: f32 = 2.3048;
const CUBIC: f32 = 0.1018;
const END: f32 = 5.0;

impl<S: Simd> Shares<S> {
    /// Marks pixels whose share on the lattice is too small for a value.
    #[inline(always)]
    pub fn is_faded(&self, simd: S) -> mask32x16<S> {
        self.per_weight.simd_ge(f32x16::splat(simd, NEARLY / FADED))
    }
}

/// Distance from a face, standard deviations, beyond which the face has no effect.
const REACH: f32 = 3.4;

impl Border {
    /// Border of an endless volume: no pixel is near it.
    pub fn nowhere() -> Self {
        Self {
            corner_from_camera: Affine3A {
                matrix3: Mat3A::ZERO,
                translation: Vec3A::ONE,
            },
            size: Vec3::splat(2.0),
            margin: Vec3::ZERO,
            sigma: 0.0,
            beyond: Beyond::default(),
        }
    }

    /// Border of a box of `dims` samples, continued by a margin of lattice points; `sigma` of the kernel in voxels.
    pub fn new(camera_from_voxel: DAffine3, dims: [usize; 3], margin: [usize; 3], sigma: f64) -> Self {
        let inverse = camera_from_voxel.inverse();
        Self {
            corner_from_camera: Affine3A::from_mat3_translation(
                inverse.matrix3.as_mat3(),
                inverse.translation.as_vec3() + 0.5,
            ),
            size: Vec3::from_array(dims.map(|n| n as f32)),
            margin: Vec3::from_array(margin.map(|n| n as f32)),
            sigma: sigma as f32,
            beyond: Beyond::new(sigma),
        }
    }

    /// The plane whose pixels' centres are at `first + x step_x + y step_y`, camera space; x and y count from the
    /// picture's corner, so that rounding does not depend on the tile.
    pub fn on_plane(&self, first: Vec3A, step_x: Vec3A, step_y: Vec3A) -> BorderPlane {
        let step = |v| self.corner_from_camera.transform_vector3a(v);
        BorderPlane {
            first: self.corner_from_camera.transform_point3a(first),
            step_x: step(step_x),
            step_y: step(step_y),
        }
    }

    /// Whether all points between two points of a plane lie further inside the box than so many standard
    /// deviations.
    #[inline(always)]
    fn holds(&self, from: Vec3A, to: Vec3A, reach: f32) -> bool {
        let near = Vec3A::splat(reach * self.sigma);
        from.min(to).cmpge(near).all() && (Vec3A::from(self.size) - from.max(to)).cmpge(near).all()
    }

    /// Whether sixteen pixels of a plane from (x, y) on are near the border.
    #[inline(always)]
    pub fn is_near(&self, plane: &BorderPlane, [x, y]: [usize; 2]) -> bool {
        let from = plane.at(x, y);
        !self.holds(from, from + plane.step_x * LAST_LANE, REACH)
    }

    /// Whether any sixteen of a tile's pixels may be near the border.
    pub fn is_near_any(&self, plane: &BorderPlane, tile: &TileRect) -> bool {
        let (top, bottom) = (plane.at(tile.x0, tile.y0), plane.at(tile.x0, tile.y1));
        let across = plane.step_x * (tile.x1 - tile.x0).next_multiple_of(16) as f32;
        let reach = REACH + TILE_SLACK;
        !(self.holds(top, top + across, reach) && self.holds(bottom, bottom + across, reach))
    }

    /// Shares at sixteen pixels of a plane from (x, y) on.
    #[inline(always)]
    pub fn at<S: Simd>(&self, simd: S, plane: &BorderPlane, [x, y]: [usize; 2]) -> Shares<S> {
        let (from, step) = (plane.at(x, y), plane.step_x);
        let lanes = f32x16::from_slice(simd, &LANES);
        let one = f32x16::splat(simd, 1.0);
        let (mut own, mut per_weight) = (one, one);
        let to = from + step * LAST_LANE;
        for axis in 0..3 {
            let (low, high) = (from[axis].min(to[axis]), from[axis].max(to[axis]));
            if low >= REACH * self.sigma && self.size[axis] - high >= REACH * self.sigma {
                continue;
            }
            let x = (lanes * step[axis] + from[axis]) * (1.0 / self.sigma);
            let (size, margin) = (self.size[axis] / self.sigma, self.margin[axis] / self.sigma);
            // Only the nearer face matters, unless the box is thin.
            let near = x.min(size - x);
            own *= cumulative(simd, near);
            let mut ratio = self.beyond.ratio(simd, near + margin);
            if size < 2.0 * REACH {
                own *= cumulative(simd, size - near);
                ratio = both_ends(simd, ratio, self.beyond.ratio(simd, size + margin - near));
            }
            per_weight *= one + ratio;
        }
        let coverage = ((own - 0.5) * (1.0 / RAMP) + 0.5)
            .max(f32x16::splat(simd, 0.0))
            .min(one);
        Shares {
            coverage,
            per_weight: per_weight.min(f32x16::splat(simd, 1.0 / FADED)),
        }
    }

    /// Coverage, and one over the share on the lattice, of one pixel of a plane.
    pub fn at_pixel(&self, plane: &BorderPlane, [x, y]: [usize; 2]) -> [f32; 2] {
        let point = plane.at(x, y);
        let (mut own, mut per_weight) = (1.0, 1.0);
        for axis in 0..3 {
            let (size, margin) = (self.size[axis] / self.sigma, self.margin[axis] / self.sigma);
            let x = point[axis] / self.sigma;
            let near = x.min(size - x);
            if near >= REACH {
                continue;
            }
            own *= cumulative_of(near);
            let mut ratio = self.beyond.ratio_of(near + margin);
            if size < 2.0 * REACH {
                own *= cumulative_of(size - near);
                ratio = both_ends_of(ratio, self.beyond.ratio_of(size + margin - near));
            }
            per_weight *= 1.0 + ratio;
        }
        let coverage: f32 = ((own - 0.5) * (1.0 / RAMP) + 0.5).clamp(0.0, 1.0);
        [coverage, f32::min(per_weight, 1.0 / FADED)]
    }
}

/// A plane's pixels, in voxels from the box's first corner.
#[derive(Debug, Clone, Copy)]
pub struct BorderPlane {
    first: Vec3A,
    step_x: Vec3A,
    step_y: Vec3A,
}

impl BorderPlane {
    #[inline(always)]
    fn at(&self, x: usize, y: usize) -> Vec3A {
        self.first + self.step_x * x as f32 + self.step_y * y as f32
    }
}

const LANES: [f32; 16] = [
    0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0,
];

/// `M / (1 - M)` of what lies beyond both ends of an axis, from those of each: at thin boxes the shares add up.
#[inline(always)]
fn both_ends<S: Simd>(simd: S, a: f32x16<S>, b: f32x16<S>) -> f32x16<S> {
    let product = a * b;
    let left = (f32x16::splat(simd, 1.0) - product).max(f32x16::splat(simd, LEAST_LEFT));
    (a + b + product * 2.0) / left
}

/// Scalar version of `both_ends`.
fn both_ends_of(a: f32, b: f32) -> f32 {
    let product = a * b;
    (a + b + product * 2.0) / f32::max(1.0 - product, LEAST_LEFT)
}

/// Far less than a share that counts.
const LEAST_LEFT: f32 = 1e-3;

/// Standard normal cumulative distribution.
#[inline(always)]
fn cumulative<S: Simd>(simd: S, x: f32x16<S>) -> f32x16<S> {
    let x = x.max(f32x16::splat(simd, -END)).min(f32x16::splat(simd, END));
    let exponent = (x * x * -CUBIC - LINEAR) * x;
    let one = f32x16::splat(simd, 1.0);
    one / (one + exp2(simd, exponent))
}

/// Scalar version of `cumulative`.
pub fn cumulative_of(x: f32) -> f32 {
    let x = x.clamp(-END, END);
    1.0 / (1.0 + exp2_of((x * x * -CUBIC - LINEAR) * x))
}
