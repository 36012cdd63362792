//! Where a chunk's footprints can lie.

use glam::{DVec2, DVec3, Vec3};
use splatvol_scene::Alignment;

use super::Projection;
use super::rays::per_depth;
use crate::splats::cloud::Chunk;

/// Where a chunk's footprints can lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// x0, y0, x1, y1, pixels.
    pub rect: [f32; 4],
    /// Least and greatest camera depth that kernels reach.
    pub depth: [f32; 2],
}

/// Pixels around a chunk that rounding may reach.
const ROUNDING: f64 = 0.01;

impl Projection<'_> {
    /// Where a chunk's footprints can lie; `None` behind the camera.
    pub fn bounds(&self, chunk: &Chunk) -> Option<Bounds> {
        let [centres_low, centres_high] = self.corners(chunk);
        let (mut low, mut high) = (centres_low, centres_high);
        if let Some(sweep) = &self.sweep {
            // On either side of where they are in the shutter's middle.
            let (least, most) = sweep.extremes(self.cloud, chunk);
            let half = 0.5 * (-least).max(most).max(Vec3::ZERO).as_dvec3();
            (low, high) = (low - half, high + half);
        }
        let areas = match self.alignment {
            _ if !self.perspective => [self.projected(low, high), None],
            Alignment::Sheet | Alignment::Affine | Alignment::Grid => [self.projected(low, high), None],
            Alignment::Ray | Alignment::RayIdeal | Alignment::Exact => [None, self.met(low, high)],
            Alignment::Auto { .. } => [self.projected(low, high), self.met(low, high)],
        };
        let [first, last] = areas
            .into_iter()
            .flatten()
            .reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])?;
        let reach = f64::from(self.depth_reach());
        let rounding = ROUNDING + 1e-6 * first.abs().max(last.abs());
        let (first, last) = ((first - rounding).as_vec2(), (last + rounding).as_vec2());
        Some(Bounds {
            rect: [first.x, first.y, last.x, last.y],
            depth: [(centres_low.z - reach) as f32, (centres_high.z + reach) as f32],
        })
    }

    /// The box of a chunk's centres, camera space.
    fn corners(&self, chunk: &Chunk) -> [DVec3; 2] {
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for corner in 0..8 {
            let local = std::array::from_fn(|a| {
                if corner >> a & 1 == 0 {
                    chunk.low[a]
                } else {
                    chunk.high[a]
                }
            });
            let point = self.camera_from_local.transform_point3(Vec3::from_array(local));
            (low, high) = (low.min(point), high.max(point));
        }
        [low.as_dvec3(), high.as_dvec3()]
    }

    /// The pixels of affine footprints. As the ray is oblique, they are longer than at the axis; no Jacobian is more oblique than
    /// the widest.
    fn projected(&self, low: DVec3, high: DVec3) -> Option<[DVec2; 2]> {
        let [first, last] = if self.perspective {
            per_depth([low, high], self.near)?
        } else {
            [low.truncate(), high.truncate()]
        };
        let (pixels, stretch) = self.widest_filter(high.z);
        let oblique = if self.perspective {
            (1.0 + self.widest * self.widest).map(f64::sqrt)
        } else {
            DVec2::ONE
        };
        let sigma = oblique * (stretch * self.reach * self.pixels_per_length(low.z));
        let margin = (sigma + pixels) * self.cut;
        Some([
            first * self.scale + self.principal - margin,
            last * self.scale + self.principal + margin,
        ])
    }

    /// The pixels whose rays meet kernels behind the near plane.
    fn met(&self, low: DVec3, high: DVec3) -> Option<[DVec2; 2]> {
        let (pixels, stretch) = self.widest_filter(high.z + self.cut * self.reach);
        let across = stretch * self.reach + pixels / self.pixels_per_length(high.z);
        // A kernel across an oblique ray reaches as far in depth as it does beside the ray.
        let deep = if self.alignment == Alignment::Exact {
            self.reach
        } else {
            stretch * self.reach
        };
        let half = DVec3::new(across, across, deep) * self.cut;
        let [first, last] = per_depth([low - half, high + half], self.near)?;
        Some([first, last].map(|along| along * self.scale + self.principal))
    }
}
