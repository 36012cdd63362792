//! Bounds of a chunk's footprints.

use glam::{DVec2, DVec3, Vec3};
use splatvol_scene::Alignment;

use super::Projection;
use super::rays::per_depth;
use crate::splats::cloud::Chunk;

/// Bounds of a chunk's footprints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// x0, y0, x1, y1, pixels.
    pub rect: [f32; 4],
    /// Least and greatest camera depth that kernels reach.
    pub depth: [f32; 2],
    /// Reach of kernels before and behind their centres, world length.
    pub reach: f32,
}

/// Largest relative error by which a standard deviation may have been rounded down.
const ROUNDED: f64 = 1e-6;
/// Pixels around a chunk that rounding may reach.
const ROUNDING: f64 = 0.01;

impl Projection<'_> {
    /// Bounds of a chunk's footprints; `None` behind the camera.
    pub fn bounds(&self, chunk: &Chunk) -> Option<Bounds> {
        let [centres_low, centres_high] = self.corners(chunk);
        let (mut low, mut high) = (centres_low, centres_high);
        if let Some(sweep) = &self.sweep {
            // On either side of where they are in the shutter's middle.
            let (least, most) = sweep.extremes(self.cloud, chunk);
            let half = 0.5 * (-least).max(most).max(Vec3::ZERO).as_dvec3();
            (low, high) = (low - half, high + half);
        }
        let wide = self.stretch_from_local * f64::from(chunk.sigma) * (1.0 + ROUNDED);
        let projected = || self.projected([low, high], wide);
        let met = || self.met([low, high], wide);
        let areas = match self.alignment {
            _ if !self.perspective => [projected(), None],
            Alignment::Sheet | Alignment::Affine | Alignment::Grid => [projected(), None],
            Alignment::Ray | Alignment::RayIdeal | Alignment::Exact => [None, met()],
            Alignment::Switch { .. } | Alignment::Auto { .. } => [projected(), met()],
        };
        let [first, last] = areas
            .into_iter()
            .flatten()
            .reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])?;
        let moved = self.sweep.as_ref().map_or(0.0, |sweep| sweep.depth_change);
        let reach = self.cut * wide + 0.5 * f64::from(moved);
        let rounding = ROUNDING + 1e-6 * first.abs().max(last.abs());
        let (first, last) = ((first - rounding).as_vec2(), (last + rounding).as_vec2());
        Some(Bounds {
            rect: [first.x, first.y, last.x, last.y],
            depth: [(centres_low.z - reach) as f32, (centres_high.z + reach) as f32],
            reach: reach as f32,
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

    /// Pixels of affine footprints, `reach` being their kernels' largest standard deviation. Footprints are longer
    /// off the axis, where rays are oblique; no Jacobian is more oblique than the widest.
    fn projected(&self, [low, high]: [DVec3; 2], reach: f64) -> Option<[DVec2; 2]> {
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
        let sigma = oblique * (stretch * reach * self.pixels_per_length(low.z));
        let margin = (sigma + pixels) * self.cut;
        Some([
            first * self.scale + self.principal - margin,
            last * self.scale + self.principal + margin,
        ])
    }

    /// Pixels whose rays meet kernels behind the near plane.
    fn met(&self, [low, high]: [DVec3; 2], reach: f64) -> Option<[DVec2; 2]> {
        let (pixels, stretch) = self.widest_filter(high.z + self.cut * reach);
        let across = stretch * reach + pixels / self.pixels_per_length(high.z);
        // A kernel across an oblique ray reaches as far in depth as it does beside the ray.
        let deep = if self.alignment == Alignment::Exact {
            reach
        } else {
            stretch * reach
        };
        let half = DVec3::new(across, across, deep) * self.cut;
        let [first, last] = per_depth([low - half, high + half], self.near)?;
        Some([first, last].map(|along| along * self.scale + self.principal))
    }
}
