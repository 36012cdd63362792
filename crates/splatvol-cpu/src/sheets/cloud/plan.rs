//! Plan: planes that suit a cloud, and its chunks in tile lists.

use splatvol_core::bin::TileGrid;
use splatvol_core::cloud_planes::{CloudBounds, nearest};
use splatvol_core::plan::{FramePlan, SheetShape, Zone, low_pass};
use splatvol_core::splats::SplatCloud;
use splatvol_scene::{Camera, RenderSettings, SheetSettings};

use super::open::CloudView;
use crate::sheets::frame::ZonedFrame;
use crate::splat_light::SplatLight;

/// Planes and lists of a cloud; the next frame reuses their memory.
#[derive(Debug, Default)]
pub(crate) struct CloudPlan {
    plan: FramePlan,
}

impl CloudPlan {
    /// Plans a cloud's frame, on planes of the given spacing or else of one that suits it, and returns the cloud in
    /// that view. There is one zone: splats are drawn on pixels, whatever their size, and sorted as they are
    /// opened.
    pub(crate) fn frame<'a>(
        &'a mut self,
        cloud: &'a SplatCloud,
        (camera, settings): (&Camera, &RenderSettings<SheetSettings>),
        tiles: TileGrid,
        spacing: Option<f64>,
    ) -> (ZonedFrame<'a>, CloudView<'a>) {
        let screen = camera.screen_from_camera(settings.size);
        let camera_from_local = camera.camera_from_world() * cloud.world_from_local;
        let bounds = CloudBounds::new(cloud, (camera, settings));
        let stack = bounds.planes(cloud, settings, spacing);
        let view = CloudView::new(
            (
                cloud,
                settings
                    .lighting
                    .as_ref()
                    .filter(|_| !cloud.gradients.is_empty())
                    .map(|lighting| SplatLight::new(lighting, cloud, camera)),
            ),
            camera_from_local,
            screen,
            low_pass(settings.method.filter.into()),
            (stack.plane(usize::from(stack.first == 0)), stack.spacing),
        );
        let least = nearest(&stack, &screen);
        let sheets = (0..=stack.count).map(|i| {
            let depth = stack.plane(i).max(least);
            SheetShape {
                depth: depth as f32,
                scale: screen.scale_at(depth) as f32,
                ..SheetShape::default()
            }
        });
        let project = |index: usize| bounds.project(&cloud.chunks[index], index, &stack);
        self.plan.of_pixels(
            (&screen, settings),
            (Zone::of_pixels(stack), sheets),
            (cloud.chunks.len(), project),
            tiles,
        );
        let plan = &self.plan;
        (ZonedFrame { plan, eyes: &[] }, view)
    }
}
