//! Integral: X-rays of a cloud: whole footprints of optical depth, added up (docs/numerics.md, "Per-splat compositing").
//!
//! Formulas and cuts are those of `splatvol_cpu::splats`, in single precision. Nothing is sorted by depth; a tile's list has the
//! cloud's order, so sums do not depend on how a device runs workgroups. They join what rays keep of volumes.

use bytemuck::{Pod, Zeroable};
use splatvol_core::cloud_view::{CloudView, CutProfile, LEAST_VARIANCE, LowPass, cut_of, near_of_depths};
use splatvol_core::engine::Task;
use splatvol_core::plan::Rays;
use splatvol_scene::{Camera, RenderSettings, SceneError, SheetSettings};

use super::store::Ready;
use crate::device::GpuDevice;
use crate::footprints::{Footprints, ListPasses, ViewData, room_for};
use crate::layout::FrameData;
use crate::march::Canvas;
use crate::mode::integral_shaders;
use crate::pass::{Pass, groups, uniform};

/// How footprints fall off: `Profile` in WGSL.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct ProfileData {
    pub end: f32,
    pub edge: f32,
    pub height: f32,
    pub low_pass: f32,
    pub least_variance: f32,
    pub is_matched: u32,
    pub peaks_from: u32,
    pub unused: u32,
}

/// The tiles of lists, and where footprints end: `Tiles` in WGSL.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct TilesData {
    pub end: f32,
    pub edge: f32,
    pub columns: u32,
    pub unused: u32,
}

/// Compiled passes.
#[derive(Debug)]
pub(crate) struct IntegralPasses {
    project: Pass,
    integrate: Pass,
    settle: Pass,
    lists: ListPasses,
}

impl IntegralPasses {
    /// Compiles the passes.
    ///
    /// # Errors
    /// A driver that refuses a shader.
    pub(crate) fn new(gpu: &GpuDevice) -> Result<Self, SceneError> {
        gpu.scoped(|gpu| {
            let [project, integrate] = integral_shaders();
            Self {
                project: Pass::new(gpu, ("project_kernels", &project), &[]),
                integrate: Pass::new(gpu, ("integrate", &integrate), &[]),
                settle: Pass::new(gpu, ("settle", &integrate), &[]),
                lists: ListPasses::new(gpu),
            }
        })
    }
}

/// A cloud whose integrals are added to what rays keep.
pub(crate) struct Integral<'a> {
    pub gpu: &'a GpuDevice,
    pub passes: &'a IntegralPasses,
    pub canvas: &'a Canvas,
    pub cloud: Ready<'a>,
    pub camera: &'a Camera,
    pub settings: &'a RenderSettings,
    pub sheets: &'a RenderSettings<SheetSettings>,
}

impl Integral<'_> {
    /// Adds the cloud's integrals to the canvas, and makes pixels of what rays keep. Returns the bytes on the device that it took.
    ///
    /// # Errors
    /// A stopped picture, more footprints or pairs than the device has room for, or a device that fails.
    pub(crate) async fn show(&self, task: Task<'_>) -> Result<usize, SceneError> {
        let Self { gpu, passes, .. } = self;
        let profile = CutProfile::new(cut_of(self.settings));
        let what = "points and kernels";
        let count = room_for(gpu, self.cloud.0.len(), what)?;
        let footprints = gpu.scoped(|gpu| {
            let footprints = Footprints::new(gpu, count, self.settings.size);
            self.project(&footprints, &profile);
            footprints
        })?;
        task.go_on()?;
        task.report(0.4);
        let lists = passes.lists.list(gpu, &footprints, what).await?;
        task.go_on()?;
        task.report(0.7);
        let rays = Rays::new(&self.camera.screen_from_camera(self.settings.size));
        let data = FrameData::seen(self.sheets, &rays);
        gpu.scoped(|gpu| {
            let frame = uniform(gpu, &data);
            let tiles = uniform(
                gpu,
                &TilesData {
                    end: profile.end,
                    edge: profile.edge,
                    columns: footprints.columns(),
                    unused: 0,
                },
            );
            let [colors, depths] = self.canvas.targets();
            let common = [(0, &frame), (7, colors), (8, depths)];
            let of_lists = [
                (1, &footprints.projected),
                (2, &lists.pairs.values),
                (3, &lists.ranges),
                (4, &tiles),
            ];
            let mut commands = gpu.commands();
            let dispatched = [footprints.columns(), footprints.rows()];
            let bound = [&common[..], &of_lists].concat();
            passes.integrate.run(gpu, &mut commands, &bound, dispatched);
            passes.settle.run(gpu, &mut commands, &common, data.tiles);
            gpu.queue.submit([commands.finish()]);
        })?;
        Ok(footprints.bytes() + lists.pairs.bytes())
    }

    /// Projects the cloud's kernels, page by page.
    fn project(&self, footprints: &Footprints, profile: &CutProfile) {
        let Self {
            gpu,
            passes,
            cloud: (cloud, kernels),
            ..
        } = self;
        let low_pass = LowPass::of(self.settings.method.filter());
        let (variance, is_matched) = match low_pass {
            LowPass::Added(variance) => (variance, false),
            LowPass::Lacking(variance) => (variance, true),
        };
        let profile = uniform(
            gpu,
            &ProfileData {
                end: profile.end,
                edge: profile.edge,
                height: profile.peak_of_mass,
                low_pass: variance,
                least_variance: LEAST_VARIANCE,
                is_matched: u32::from(is_matched),
                peaks_from: cloud.peaks_from as u32,
                unused: 0,
            },
        );
        let near = near_of_depths(self.settings, cloud.spacing);
        let seen = (self.camera, self.settings.size);
        let view = ViewData::new(&CloudView::new(&cloud.world_from_local, near, seen, low_pass));
        let mut commands = gpu.commands();
        let mut before = 0;
        for page in &kernels.pages {
            let own = uniform(
                gpu,
                &ViewData {
                    count: page.count,
                    before,
                    ..view
                },
            );
            let bound = [
                (0, &own),
                (1, &profile),
                (2, &page.kernels),
                (3, &page.payloads),
                (4, &footprints.projected),
                (5, &footprints.order.values),
            ];
            passes
                .project
                .run(gpu, &mut commands, &bound, groups(page.count, 256));
            before += page.count;
        }
        gpu.queue.submit([commands.finish()]);
    }
}
