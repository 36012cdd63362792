//! Planes that suit a cloud of kernels, and how kernels are sampled on them.
//!
//! A plane at depth D receives from a splat with centre u and covariance V, camera space, at planes t apart (docs/numerics.md,
//! "Clouds of kernels"; zwicker2001 eq. 22, before the projection to a plane)
//!
//! `m g(D - u_z) exp(-d^T C^-1 d / 2) / (2 pi sqrt|C|)`, `d = x - u_xy - s (D - u_z)`,
//! `v = V_zz + (DEPTH_SIGMA t)^2`, `s = V_xy,z / v`, `C = V_xy,xy - s s^T v + p^2 I`,
//!
//! m the kernel's integral, p the low-pass, and g a Gaussian of variance v, cut at [`DEPTH_CUT`], less its value there,
//! normalised.

use glam::{DAffine3, DVec2, DVec3};
use splatvol_scene::{Camera, ImageSize, RenderSettings, ScreenFromCamera, SheetSettings};

use crate::bin::ProjectedBrick;
use crate::brick::ActiveBrick;
use crate::plan::low_pass;
use crate::sheets::Planes;
use crate::splats::{Chunk, KernelShape, SplatCloud};

/// Width, pixels, that is added to every footprint: a flat splat seen from its edge would fall between pixels.
pub const LEAST_WIDTH: f64 = 1e-3;
/// Standard deviation by which splats are widened in depth, in distances of planes: that of a kernel of radius two.
pub const DEPTH_SIGMA: f64 = 0.64;
/// Standard deviations at which splats are cut in depth: four planes hold a flat one.
pub const DEPTH_CUT: f64 = 2.0 / DEPTH_SIGMA;
/// Edge subtracted from the profile in depth, so that it ends without a step: its value at the cut.
pub const DEPTH_EDGE: f32 = 7.575_677_5e-3;
/// Integral of the profile in depth, standard deviations: `sqrt(2 pi) (Phi(c) - Phi(-c)) - 2 c e`.
pub const DEPTH_INTEGRAL: f64 = 2.454823378701;
/// Lateral cut of splats, standard deviations.
pub const CUT: f64 = 3.4;

/// Pixels added to a footprint on either side: by rounding to whole blocks, and as the border of a tile that differences
/// across it read.
const ROUNDING: f64 = 4.0;
/// Factor of a chunk's reach in depth, by which it stays an upper bound in 32 bits.
const ROUNDED_UP: f64 = 1.0 + 1e-6;

/// Variance in depth that splats have on planes `spacing` apart.
pub fn widened(variance: f64, spacing: f64) -> f64 {
    variance + (DEPTH_SIGMA * spacing).powi(2)
}

/// Distance of planes that suits a cloud, world length.
pub fn own_spacing(cloud: &SplatCloud, (camera, settings): (&Camera, &RenderSettings<SheetSettings>)) -> f64 {
    CloudBounds::new(cloud, (camera, settings))
        .planes(cloud, settings, None)
        .spacing
}

/// Least depth of planes, world length: the plane at the eye, which has no scale, counts as a little in front of it.
pub fn nearest(stack: &Planes, screen: &ScreenFromCamera) -> f64 {
    if screen.perspective {
        stack.plane(0).max(AT_EYE * stack.spacing)
    } else {
        f64::NEG_INFINITY
    }
}

/// Depth of the plane at the eye, distances of planes.
const AT_EYE: f64 = 1e-3;

/// Chunks of a cloud to screen rectangles and first planes.
#[derive(Debug, Clone)]
pub struct CloudBounds {
    camera_from_local: DAffine3,
    screen: ScreenFromCamera,
    size: ImageSize,
    /// Longest world length of a local unit.
    stretch: f64,
    /// Low-pass, pixels.
    pixel_sigma: f64,
    /// Standard deviation of kernels that have no covariance of their own, local.
    shared_sigma: f64,
}

impl CloudBounds {
    /// Bounds in a camera's view.
    pub fn new(cloud: &SplatCloud, (camera, settings): (&Camera, &RenderSettings<SheetSettings>)) -> Self {
        let screen = camera.screen_from_camera(settings.size);
        let camera_from_local = camera.camera_from_world() * cloud.world_from_local;
        let linear = camera_from_local.matrix3;
        // A bound on the largest singular value; exact for a rotation times a number.
        let square = linear.transpose() * linear;
        let rows = [square.row(0), square.row(1), square.row(2)];
        let stretch = rows
            .map(|row| row.abs().element_sum())
            .into_iter()
            .fold(0.0, f64::max)
            .sqrt();
        Self {
            camera_from_local,
            screen,
            size: settings.size,
            stretch,
            pixel_sigma: low_pass(settings.method.filter.into()).0.sqrt(),
            shared_sigma: match cloud.shape {
                KernelShape::Ellipsoids { .. } => 0.0,
                shape => shape.sigma(),
            },
        }
    }

    /// Least and greatest coordinates of a chunk's centres, camera space.
    fn centres(&self, chunk: &Chunk) -> [DVec3; 2] {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for corner in chunk.corners() {
            let point = self
                .camera_from_local
                .transform_point3(DVec3::from_array(corner.map(f64::from)));
            (low, high) = (low.min(point), high.max(point));
        }
        [low, high]
    }

    /// Largest standard deviation of a chunk's kernels, world length.
    fn sigma(&self, chunk: &Chunk) -> f64 {
        f64::from(chunk.sigma).max(self.shared_sigma) * self.stretch
    }

    /// Planes of the given spacing, or else of the settings', but at least that of the pixels in the middle of the
    /// cloud: closer planes cost more and show nothing new.
    pub fn planes(
        &self,
        cloud: &SplatCloud,
        settings: &RenderSettings<SheetSettings>,
        spacing: Option<f64>,
    ) -> Planes {
        let wanted = settings.method.thickness * cloud.spacing;
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for chunk in &cloud.chunks {
            let [near, far] = self.centres(chunk);
            let sigma = self.sigma(chunk);
            (low, high) = (
                low.min(near - DEPTH_CUT * sigma),
                high.max(far + DEPTH_CUT * sigma),
            );
        }
        if cloud.chunks.is_empty() {
            (low, high) = (DVec3::ZERO, DVec3::ZERO);
        }
        let middle = 0.5 * (low.z + high.z);
        let pixel = 1.0 / self.screen.scale_at(middle.max(wanted));
        let spacing = spacing.unwrap_or(wanted.max(pixel));
        // Two planes more on either side, which the widening in depth reaches.
        let mut planes = Planes::covering(&[low, high], 2.0 * spacing, spacing, &self.screen);
        if self.screen.perspective && planes.first == 1 && low.z < spacing {
            // Splats between the eye and the first plane are visible, too.
            (planes.first, planes.count) = (0, planes.count + 1);
        }
        planes
    }

    /// Bounds of a chunk's footprints; `None` behind the camera, and outside the picture.
    pub fn project(&self, chunk: &Chunk, index: usize, stack: &Planes) -> Option<ProjectedBrick> {
        let [low, high] = self.centres(chunk);
        let sigma = self.sigma(chunk);
        let reach = DEPTH_CUT * widened(sigma * sigma, stack.spacing).sqrt() * ROUNDED_UP;
        let first = nearest(stack, &self.screen).max(stack.plane(0));
        let near = (low.z - reach).max(first);
        let far = high.z + reach;
        if far < first {
            return None;
        }
        // Sections drift with depth, and are as wide as the kernel at most: together no farther than this.
        let lateral = (DEPTH_CUT * DEPTH_CUT + CUT * CUT).sqrt() * sigma;
        let scales = [self.screen.scale_at(near), self.screen.scale_at(far)];
        // The low-pass is as wide as it is at a splat's own depth: nearer planes show it larger.
        let own = self.screen.scale_at(low.z.max(first));
        let margin = CUT * self.pixel_sigma * (scales[0] / own).max(1.0) + ROUNDING;
        let bound = |value: DVec2, pick: fn(f64, f64) -> f64| {
            let [a, b] = scales.map(|scale| value * scale);
            DVec2::new(pick(a.x, b.x), pick(a.y, b.y)) + self.screen.centre
        };
        let from = bound(low.truncate() - lateral, f64::min) - margin;
        let to = bound(high.truncate() + lateral, f64::max) + margin;
        let (width, height) = (f64::from(self.size.width()), f64::from(self.size.height()));
        if to.x < 0.0 || to.y < 0.0 || from.x > width || from.y > height {
            return None;
        }
        Some(ProjectedBrick {
            active: ActiveBrick {
                brick: index as u32,
                blocks: u8::MAX,
            },
            front_sheet: stack.first_touched(low.z - reach) as u32,
            rect: [from.x as f32, from.y as f32, to.x as f32, to.y as f32],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::normal::mass_within;

    #[test]
    fn constants_are_those_of_the_cut_profile() {
        let edge = (-0.5 * DEPTH_CUT * DEPTH_CUT).exp();
        assert!((f64::from(DEPTH_EDGE) - edge).abs() < 1e-9);
        let integral = std::f64::consts::TAU.sqrt() * mass_within(DEPTH_CUT) - 2.0 * DEPTH_CUT * edge;
        assert!((DEPTH_INTEGRAL - integral).abs() < 1e-9, "{integral}");
    }
}
