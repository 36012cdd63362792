//! 3-D Gaussians as published: projected, sorted by depth, put into the lists of tiles, and composited one by one.
//!
//! The formulas, their constants and the order are those of the engine `splats` of `splatvol-cpu`: Kerbl, Kopanas,
//! Leimkuehler and Drettakis 2023. Numbers are rounded otherwise: contraction and the device's own functions differ.
//!
//! | pass | shader | from | to |
//! |---|---|---|---|
//! | project | `gaussians/project` | Gaussians, page by page | ellipses with colours; keys: their depths |
//! | order | `sort/radix`, `sort/scan` | keys | splats by depth, equal ones by index |
//! | list | `footprints/pairs` | splats by depth | pairs of a tile of 16 x 16 pixels and a splat, sorted by tile |
//! | composite | `gaussians/composite` | lists | linear colour, transmittance, depth; a workgroup per tile |
//! | resolve | - | these | a frame |

mod attributes;
mod background;
mod view;

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::DAffine3;
use splatvol_core::clock::Instant;
use splatvol_core::cloud_view::{
    LEAST_ALPHA, LEAST_RATIO, LEAST_SPREAD, LEAST_TRANSMITTANCE, LOG2_255, MOST_ALPHA, REFERENCE_TILE,
    UNSEEN_ALPHA,
};
use splatvol_core::engine::{Shot, StageSeconds, Task};
use splatvol_scene::{Compositing, Content, Frame, Gaussians, SceneError};

use self::attributes::Attributes;
use self::background::displayed;
use self::view::{DepthKeys, view};
use crate::device::GpuDevice;
use crate::footprints::{self, BATCH, Footprints, ListPasses, SPLAT, TileLists, VIEW, ViewData};
use crate::march::Canvas;
use crate::pass::{Pass, groups, uniform};

const PROJECT: &str = include_str!("../../shaders/gaussians/project.wgsl");
const COMPOSITE: &str = include_str!("../../shaders/gaussians/composite.wgsl");

/// A picture of splats: `Picture` in WGSL.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct PictureData {
    pub size: [u32; 2],
    pub columns: u32,
    pub unused: u32,
    /// Background: straight display colour and opacity.
    pub background: [f32; 4],
}

/// The texts of the passes: project, composite.
pub(crate) fn shaders() -> [String; 2] {
    [
        [SPLAT, VIEW, PROJECT].join("\n"),
        [SPLAT, BATCH, COMPOSITE].join("\n"),
    ]
}

/// The Gaussians of a scene, and where their own worlds lie.
pub(crate) type Clouds<'a> = Vec<(&'a Arc<Gaussians>, DAffine3)>;

/// The Gaussians of a shot that are drawn as published; `None` where it is something else.
///
/// # Errors
/// What is not drawn among or with them.
pub(crate) fn published<'a>(shot: &Shot<'a>) -> Result<Option<Clouds<'a>>, SceneError> {
    let scene = shot.scene;
    if !scene.is_published(shot.settings) {
        return Ok(None);
    }
    let refuse = |what| {
        Err(SceneError::Combination {
            what,
            why: "the GPU engine draws Gaussians as published among themselves; take the engine cpu, or auto",
        })
    };
    let mut clouds = Vec::new();
    for item in &scene.items {
        let Content::Gaussians(own) = &item.content else {
            return refuse("on the GPU, Gaussians beside something else");
        };
        if !item.operators.is_empty() || !item.clips.is_empty() {
            return refuse("on the GPU, Gaussians with a clip or an operator");
        }
        clouds.push((own, item.world_from_item));
    }
    if !scene.clips.is_empty() {
        return refuse("on the GPU, Gaussians with a clip");
    }
    if shot.settings.method.compositing() != Compositing::ImageSheets {
        return refuse("on the GPU, Gaussians by a method of the papers");
    }
    Ok(Some(clouds))
}

/// Renders Gaussians; keeps them on the device.
#[derive(Debug)]
pub(crate) struct GaussianEngine {
    project: Pass,
    composite: Pass,
    lists: ListPasses,
    attributes: Attributes,
    /// Bytes of the last frame's splats and lists.
    transient: usize,
}

impl GaussianEngine {
    /// Compiles all passes.
    ///
    /// # Errors
    /// A driver that refuses a shader.
    pub(crate) fn new(gpu: &GpuDevice) -> Result<Self, SceneError> {
        gpu.scoped(|gpu| {
            let [project, composite] = shaders();
            let least = ("LOG2_255", f64::from(LOG2_255));
            let of_project = [
                least,
                ("LEAST_ALPHA", f64::from(LEAST_ALPHA)),
                ("UNSEEN_ALPHA", f64::from(UNSEEN_ALPHA)),
                ("LEAST_SPREAD", f64::from(LEAST_SPREAD)),
                ("LEAST_RATIO", f64::from(LEAST_RATIO)),
            ];
            let of_composite = [
                least,
                ("MOST_ALPHA", f64::from(MOST_ALPHA)),
                ("LEAST_TRANSMITTANCE", f64::from(LEAST_TRANSMITTANCE)),
            ];
            Self {
                project: Pass::new(gpu, ("project", &project), &of_project),
                composite: Pass::new(gpu, ("composite", &composite), &of_composite),
                lists: ListPasses::new(gpu),
                attributes: Attributes::default(),
                transient: 0,
            }
        })
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> usize {
        self.attributes.bytes() + self.transient
    }

    /// Renders clouds over a background (linear light, straight alpha). Seconds, as the caller waits for them: `bin` until
    /// the lists' sizes are known, `tiles` after that.
    ///
    /// # Errors
    /// A stopped picture, more Gaussians than the device has room for, or a device that fails.
    pub(crate) async fn render(
        &mut self,
        gpu: &GpuDevice,
        (clouds, shot): (&Clouds<'_>, &Shot<'_>),
        (canvas, frame): (&Canvas, &mut Frame),
        task: Task<'_>,
    ) -> Result<StageSeconds, SceneError> {
        let start = Instant::now();
        let count = room_for(gpu, clouds)?;
        self.attributes.upload(gpu, clouds)?;
        task.go_on()?;
        let mut splats = gpu.scoped(|gpu| Footprints::new(gpu, count, shot.settings.size))?;
        gpu.scoped(|gpu| self.project(gpu, (clouds, shot), &mut splats))?;
        task.go_on()?;
        task.report(0.4);
        let lists = self.lists.list(gpu, &splats, "a Gaussian").await?;
        let bin = start.elapsed().as_secs_f64();
        task.go_on()?;
        task.report(0.7);
        let background = displayed(shot.scene.background);
        gpu.scoped(|gpu| self.composite(gpu, (&splats, &lists), background, canvas))?;
        self.transient = splats.bytes() + lists.pairs.bytes();
        canvas.resolve(gpu, frame, background[3]).await?;
        Ok(StageSeconds {
            bin,
            tiles: start.elapsed().as_secs_f64() - bin,
            ..StageSeconds::default()
        })
    }

    /// Projects all clouds, and sorts the splats by depth.
    fn project(&self, gpu: &GpuDevice, (clouds, shot): (&Clouds<'_>, &Shot<'_>), splats: &mut Footprints) {
        let mut commands = gpu.commands();
        let mut before = 0;
        let views: Vec<ViewData> = clouds
            .iter()
            .map(|(own, world_from_item)| view(own, world_from_item, shot))
            .collect();
        let bounds = clouds.iter().filter_map(|(own, _)| self.attributes.bounds(own));
        let keys = DepthKeys::new(bounds.zip(&views));
        for ((own, _), view) in clouds.iter().zip(&views) {
            for page in self.attributes.pages(own) {
                let data = uniform(
                    gpu,
                    &ViewData {
                        count: page.count,
                        before,
                        first_key: keys.first,
                        unseen_key: keys.unseen,
                        ..*view
                    },
                );
                let bound = [
                    (0, &data),
                    (1, &page.means),
                    (2, &page.rotations),
                    (3, &page.scales),
                    (4, &page.harmonics),
                    (5, &splats.projected),
                    (6, &splats.order.keys),
                    (7, &splats.order.values),
                ];
                self.project
                    .run(gpu, &mut commands, &bound, groups(page.count, 256));
                before += page.count;
            }
        }
        self.lists
            .sorter
            .run(gpu, &mut commands, (&mut splats.order, keys.bits()));
        gpu.queue.submit([commands.finish()]);
    }

    /// Composites the lists' splats over a background.
    fn composite(
        &self,
        gpu: &GpuDevice,
        (splats, lists): (&Footprints, &TileLists),
        background: [f32; 4],
        canvas: &Canvas,
    ) {
        let size = [splats.size.width(), splats.size.height()];
        let data = uniform(
            gpu,
            &PictureData {
                size,
                columns: splats.columns(),
                unused: 0,
                background,
            },
        );
        let mut commands = gpu.commands();
        let [colors, depths] = canvas.targets();
        let bound = [
            (0, &data),
            (1, &splats.projected),
            (2, &lists.pairs.values),
            (3, &lists.ranges),
            (4, colors),
            (5, depths),
        ];
        let tiles = size.map(|pixels| pixels.div_ceil(REFERENCE_TILE));
        self.composite.run(gpu, &mut commands, &bound, tiles);
        gpu.queue.submit([commands.finish()]);
    }
}

/// Number of Gaussians.
///
/// # Errors
/// More than the device has room for.
pub(crate) fn room_for(gpu: &GpuDevice, clouds: &Clouds<'_>) -> Result<u32, SceneError> {
    let count: usize = clouds.iter().map(|(own, _)| own.len()).sum();
    footprints::room_for(gpu, count, "Gaussians")
}
