//! A cloud as a layer of a scene.

use glam::DAffine3;
use splatvol_core::bin::TileGrid;
use splatvol_core::splats::SplatCloud;
use splatvol_scene::{Camera, Clip, RenderSettings};

use super::emission::CloudEmission;
use super::plan::CloudPlan;
use crate::sheets::mode::Bricks;
use crate::sheets::tile::{Rays, ZonedFrame};

/// Chunks take the place of bricks.
impl Bricks for SplatCloud {
    fn len(&self) -> usize {
        self.chunks.len()
    }

    fn first(&self, _: usize) -> [u32; 3] {
        [0; 3]
    }
}

impl CloudPlan {
    /// A cloud's frame, what clips (world) leave of it, on planes this far apart, or on such as suit it, and its mode.
    pub(crate) fn layer<'a>(
        &'a mut self,
        (cloud, clips): (&'a SplatCloud, &[Clip]),
        (camera, settings): (&Camera, &RenderSettings),
        tiles: TileGrid,
        spacing: Option<f64>,
    ) -> (ZonedFrame<'a>, CloudEmission<'a>) {
        let view = self.update(cloud, (camera, settings), &tiles, spacing);
        let screen = view.screen;
        let per_pixel = 1.0 / screen.scale as f32;
        let frame = ZonedFrame {
            bricks: cloud,
            order: &self.order,
            tiles,
            zones: &self.zones,
            plans: std::slice::from_ref(&self.plan),
            longest_first: self.plan.lists.longest_first(),
            camera_from_lattice: DAffine3::IDENTITY,
            rays: Rays {
                principal: screen.centre.as_vec2().to_array(),
                per_pixel: if screen.perspective { per_pixel } else { 0.0 },
                plane_per_pixel: per_pixel,
            },
            termination: settings.termination as f32,
            groups: 1,
            reach: 0.0,
            room: [0.0, 1.0],
        };
        let view = view.cut(clips);
        (frame, CloudEmission { view })
    }
}
