//! Footprints of splats that move while the shutter is open.

use glam::{DVec2, DVec3, Vec2, Vec3};
use splatvol_scene::Motion;

use super::matrix::Covariance;
use super::{CameraView, Projection};
use crate::splats::footprint::{Footprint, Warp};
use crate::splats::sweep::Sweep;

impl Projection<'_> {
    /// Adds motion blur of the footprints while the shutter is open, as capsules or exactly. Local space is a grid
    /// of `dims` voxels.
    #[must_use]
    pub fn moving(self, motion: &Motion, dims: [usize; 3], view: &CameraView, capsule: bool) -> Self {
        let sweep = Sweep::new(motion, (self.cloud, dims), view, capsule);
        Self {
            sweep: Some(sweep),
            ..self
        }
    }

    /// The footprint of a splat that moves.
    #[inline(always)]
    pub(super) fn moved(
        &self,
        sweep: &Sweep,
        splat: usize,
        (still, centre, covariance): (Footprint, DVec3, Covariance),
    ) -> Option<Footprint> {
        let displacement = sweep.displacement(self.cloud.positions[splat]);
        if displacement == Vec3::ZERO {
            return Some(still);
        }
        let half = 0.5 * displacement.as_dvec3();
        if self.perspective && centre.z - half.z.abs() <= self.near {
            return None;
        }
        let ray = if self.perspective {
            centre.truncate() / centre.z
        } else {
            DVec2::ZERO
        };
        let scale = self.pixels_per_length(centre.z) as f32;
        let ray = Vec2::new(ray.x as f32, ray.y as f32);
        let mut footprint = sweep.blur((still, self.cut as f32), displacement, (scale, ray));
        if !matches!(still.warp, Warp::Affine { .. }) {
            let ends = [centre - half, centre + half].map(|end| self.still(end, covariance));
            for end in ends.into_iter().flatten() {
                let ([a, b, c, d], [e, f, g, h]) = (footprint.bounds, end.bounds);
                footprint.bounds = [a.min(e), b.min(f), c.max(g), d.max(h)];
            }
        }
        Some(footprint)
    }
}
