//! 3-D Gaussians as published: projected, sorted by depth, put into the lists of tiles, and composited one by one.
//!
//! The formulas, their constants and the order are those of the engine `splats` of `splatvol-cpu`: Kerbl, Kopanas,
//! Leimkuehler and Drettakis 2023. Numbers are rounded otherwise: contraction and the device's own functions differ.
//!
//! | pass | shader | from | to |
//! |---|---|---|---|
//! | project | `gaussians/project` | Gaussians, page by page | ellipses with colours; keys: their depths |
//! | order | `sort/radix`, `sort/scan` | keys | splats by depth, equal ones by index |
//! | list | `gaussians/pairs` | splats by depth | pairs of a tile of 64 x 64 pixels and a splat, sorted by tile |
//! | composite | `gaussians/composite` | lists | display colour, transmittance, depth; a workgroup per 16 x 16 pixels |
//! | resolve | - | these | a frame |

use std::sync::{Arc, Weak};
use std::time::Instant;

use bytemuck::{Pod, Zeroable};
use glam::DAffine3;
use rayon::prelude::*;
use splatvol_core::cloud_view::{
    CloudView, LEAST_ALPHA, LEAST_RATIO, LEAST_SPREAD, LEAST_TRANSMITTANCE, LOG2_255, LowPass, MOST_ALPHA,
    PUBLISHED_LOW_PASS, PUBLISHED_NEAR, REFERENCE_TILE, UNSEEN_ALPHA, near_of_gaussians,
};
use splatvol_core::engine::{Shot, StageSeconds, Task};
use splatvol_scene::gaussians::harmonics_count;
use splatvol_scene::transfer_function::{linear_from_srgb, srgb_from_linear};
use splatvol_scene::{Compositing, Content, Frame, Gaussians, ImageSize, SceneError};

use crate::device::GpuDevice;
use crate::march::Canvas;
use crate::pass::{Pass, groups, numbers, uniform};
use crate::sort::{LISTS, ListsData, Pairs, Sorter};

const SPLAT: &str = include_str!("../shaders/gaussians/splat.wgsl");
const PROJECT: &str = include_str!("../shaders/gaussians/project.wgsl");
const PAIRS: &str = include_str!("../shaders/gaussians/pairs.wgsl");
const COMPOSITE: &str = include_str!("../shaders/gaussians/composite.wgsl");

/// Gaussians of a page: their harmonics take 96 MiB at most, less than any device binds.
const PAGE: usize = 1 << 19;
/// Tiles of the published renderer along an edge of one that has a list.
const LIST_TILE: u32 = 4;
/// Bytes of a projected splat.
const SPLAT_BYTES: u64 = 48;

/// A cloud before a camera: `View` in WGSL.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct ViewData {
    pub eye: [f32; 3],
    pub near: f32,
    pub eye_rest: [f32; 3],
    pub scale: f32,
    pub to_x: [f32; 3],
    pub low_pass: f32,
    pub to_y: [f32; 3],
    pub is_perspective: u32,
    pub to_z: [f32; 3],
    pub degree: u32,
    pub direction: [f32; 3],
    pub is_antialiased: u32,
    pub centre: [f32; 2],
    pub tangent_limit: [f32; 2],
    pub reference_tiles: [f32; 2],
    pub count: u32,
    pub before: u32,
}

/// A picture of splats: `Picture` in WGSL.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct PictureData {
    pub size: [u32; 2],
    pub columns: u32,
    pub unused: u32,
}

/// The texts of the passes: project, pairs, composite.
pub(crate) fn shaders() -> [String; 3] {
    [
        [SPLAT, PROJECT].join("\n"),
        [SPLAT, LISTS, PAIRS].join("\n"),
        [SPLAT, COMPOSITE].join("\n"),
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

/// A cloud's attributes on the device.
#[derive(Debug)]
struct Resident {
    of: Weak<Gaussians>,
    pages: Vec<Page>,
}

#[derive(Debug)]
struct Page {
    means: wgpu::Buffer,
    rotations: wgpu::Buffer,
    scales: wgpu::Buffer,
    harmonics: wgpu::Buffer,
    count: u32,
}

impl Page {
    fn new(gpu: &GpuDevice, gaussians: &Gaussians, from: usize) -> Self {
        let all = gaussians.attributes();
        let range = from..(from + PAGE).min(gaussians.len());
        let means: Vec<[f32; 4]> = range
            .clone()
            .map(|i| {
                let [x, y, z] = all.means[i];
                [x, y, z, all.opacities[i]]
            })
            .collect();
        let scales: Vec<[f32; 4]> = all.scales[range.clone()]
            .iter()
            .map(|&[x, y, z]| [x, y, z, 0.0])
            .collect();
        let per_one = harmonics_count(gaussians.degree());
        Self {
            means: gpu.buffer_of("means", &means),
            rotations: gpu.buffer_of("rotations", &all.rotations[range.clone()]),
            scales: gpu.buffer_of("scales", &scales),
            harmonics: gpu.buffer_of(
                "harmonics",
                &all.harmonics[range.start * per_one..range.end * per_one],
            ),
            count: range.len() as u32,
        }
    }

    fn bytes(&self) -> usize {
        let buffers = [&self.means, &self.rotations, &self.scales, &self.harmonics];
        buffers.iter().map(|buffer| buffer.size() as usize).sum()
    }
}

/// Renders Gaussians; keeps them on the device.
#[derive(Debug)]
pub(crate) struct GaussianEngine {
    project: Pass,
    count_tiles: Pass,
    emit: Pass,
    find_ranges: Pass,
    composite: Pass,
    sorter: Sorter,
    resident: Vec<Resident>,
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
            let [project, pairs, composite] = shaders();
            let lists = [("LOG2_255", f64::from(LOG2_255))];
            let of_project = [
                lists[0],
                ("LEAST_ALPHA", f64::from(LEAST_ALPHA)),
                ("UNSEEN_ALPHA", f64::from(UNSEEN_ALPHA)),
                ("LEAST_SPREAD", f64::from(LEAST_SPREAD)),
                ("LEAST_RATIO", f64::from(LEAST_RATIO)),
            ];
            let of_composite = [
                lists[0],
                ("MOST_ALPHA", f64::from(MOST_ALPHA)),
                ("LEAST_TRANSMITTANCE", f64::from(LEAST_TRANSMITTANCE)),
            ];
            let pair = |entry| Pass::new(gpu, (entry, &pairs), &lists);
            Self {
                project: Pass::new(gpu, ("project", &project), &of_project),
                count_tiles: pair("count_tiles"),
                emit: pair("emit"),
                find_ranges: pair("find_ranges"),
                composite: Pass::new(gpu, ("composite", &composite), &of_composite),
                sorter: Sorter::new(gpu),
                resident: Vec::new(),
                transient: 0,
            }
        })
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> usize {
        let pages = self.resident.iter().flat_map(|resident| &resident.pages);
        pages.map(Page::bytes).sum::<usize>() + self.transient
    }

    /// Renders clouds over a background (linear light, straight alpha). Seconds, as the caller waits for them: `bin` until
    /// the lists' sizes are known, `tiles` after that.
    ///
    /// # Errors
    /// A stopped picture, more Gaussians than the device has room for, or a device that fails.
    pub(crate) fn render(
        &mut self,
        gpu: &GpuDevice,
        (clouds, shot): (&Clouds<'_>, &Shot<'_>),
        (canvas, frame): (&Canvas, &mut Frame),
        task: Task<'_>,
    ) -> Result<StageSeconds, SceneError> {
        let start = Instant::now();
        let count = room_for(gpu, clouds)?;
        self.upload(gpu, clouds)?;
        task.go_on()?;
        let mut splats = gpu.scoped(|gpu| Splats {
            projected: gpu.buffer(
                "splats",
                u64::from(count.max(1)) * SPLAT_BYTES,
                wgpu::BufferUsages::STORAGE,
            ),
            order: Pairs::new(gpu, count),
            size: shot.settings.size,
        })?;
        gpu.scoped(|gpu| self.project(gpu, (clouds, shot), &mut splats))?;
        task.go_on()?;
        task.report(0.4);
        let lists = self.list(gpu, &splats)?;
        let bin = start.elapsed().as_secs_f64();
        task.go_on()?;
        task.report(0.7);
        gpu.scoped(|gpu| self.composite(gpu, (&splats, &lists), canvas))?;
        self.transient = splats.order.bytes() + lists.pairs.bytes() + splats.projected.size() as usize;
        let background = Background::new(shot.scene.background);
        canvas.read(gpu, |colors, depths| {
            background.resolve(frame, (colors, depths));
        })?;
        Ok(StageSeconds {
            bin,
            tiles: start.elapsed().as_secs_f64() - bin,
            ..StageSeconds::default()
        })
    }

    /// Brings attributes to the device that are not there; frees those of other scenes.
    fn upload(&mut self, gpu: &GpuDevice, clouds: &Clouds<'_>) -> Result<(), SceneError> {
        let is_of =
            |resident: &Resident, own: &Arc<Gaussians>| std::ptr::eq(resident.of.as_ptr(), Arc::as_ptr(own));
        self.resident
            .retain(|resident| clouds.iter().any(|(own, _)| is_of(resident, own)));
        for (own, _) in clouds {
            if !self.resident.iter().any(|resident| is_of(resident, own)) {
                let firsts = (0..own.len()).step_by(PAGE);
                let pages = gpu.scoped(|gpu| firsts.map(|from| Page::new(gpu, own, from)).collect())?;
                self.resident.push(Resident {
                    of: Arc::downgrade(own),
                    pages,
                });
            }
        }
        Ok(())
    }

    /// Projects all clouds, and sorts the splats by depth.
    fn project(&self, gpu: &GpuDevice, (clouds, shot): (&Clouds<'_>, &Shot<'_>), splats: &mut Splats) {
        let mut commands = gpu.commands();
        let mut before = 0;
        for (own, world_from_item) in clouds {
            let view = view(own, world_from_item, shot);
            let resident = self
                .resident
                .iter()
                .find(|resident| std::ptr::eq(resident.of.as_ptr(), Arc::as_ptr(own)));
            for page in resident.iter().flat_map(|resident| &resident.pages) {
                let data = uniform(
                    gpu,
                    &ViewData {
                        count: page.count,
                        before,
                        ..view
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
        self.sorter.run(gpu, &mut commands, (&mut splats.order, 32));
        gpu.queue.submit([commands.finish()]);
    }

    /// Makes the lists of tiles.
    fn list(&self, gpu: &GpuDevice, splats: &Splats) -> Result<Lists, SceneError> {
        let count = splats.order.count;
        let mut sizes = ListsData {
            splats: count,
            pairs: 0,
            columns: splats.columns(),
            per_tile: 1,
        };
        let counts = gpu.scoped(|gpu| {
            let counts = numbers(gpu, "pairs per splat", count + 1);
            let mut commands = gpu.commands();
            let data = uniform(gpu, &sizes);
            let bound = [
                (7, &data),
                (1, &splats.projected),
                (2, &splats.order.values),
                (3, &counts),
            ];
            self.count_tiles
                .run(gpu, &mut commands, &bound, groups(count, 256));
            self.sorter.scanner.run(gpu, &mut commands, (&counts, count + 1));
            gpu.queue.submit([commands.finish()]);
            counts
        })?;
        sizes.pairs = gpu.number(&counts, count)?;
        let largest = gpu.device.limits().max_storage_buffer_binding_size;
        if 4 * u64::from(sizes.pairs) > largest {
            return Err(gpu.failed(&format_args!(
                "{} pairs of a Gaussian and a tile are more than its largest buffer holds",
                sizes.pairs
            )));
        }
        gpu.scoped(|gpu| self.fill(gpu, (splats, &counts), sizes))
    }

    /// Fills the lists of tiles in.
    fn fill(&self, gpu: &GpuDevice, (splats, counts): (&Splats, &wgpu::Buffer), sizes: ListsData) -> Lists {
        let tiles = sizes.columns * splats.rows();
        let mut pairs = Pairs::new(gpu, sizes.pairs);
        let ranges = numbers(gpu, "ranges of tiles", 2 * tiles);
        let data = uniform(gpu, &sizes);
        let mut commands = gpu.commands();
        let bound = [
            (7, &data),
            (1, &splats.projected),
            (2, &splats.order.values),
            (3, counts),
            (4, &pairs.keys),
            (5, &pairs.values),
        ];
        self.emit
            .run(gpu, &mut commands, &bound, groups(sizes.splats, 256));
        let bits = u32::BITS - tiles.saturating_sub(1).leading_zeros();
        self.sorter.run(gpu, &mut commands, (&mut pairs, bits));
        let bound = [(7, &data), (4, &pairs.keys), (6, &ranges)];
        self.find_ranges
            .run(gpu, &mut commands, &bound, groups(sizes.pairs, 256));
        gpu.queue.submit([commands.finish()]);
        Lists { pairs, ranges }
    }

    /// Composites the lists' splats.
    fn composite(&self, gpu: &GpuDevice, (splats, lists): (&Splats, &Lists), canvas: &Canvas) {
        let size = [splats.size.width(), splats.size.height()];
        let data = uniform(
            gpu,
            &PictureData {
                size,
                columns: splats.columns(),
                unused: 0,
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

/// Projected splats, and their order.
struct Splats {
    projected: wgpu::Buffer,
    order: Pairs,
    size: ImageSize,
}

impl Splats {
    /// Tiles with lists along x.
    fn columns(&self) -> u32 {
        self.size.width().div_ceil(REFERENCE_TILE * LIST_TILE)
    }

    /// Tiles with lists along y.
    fn rows(&self) -> u32 {
        self.size.height().div_ceil(REFERENCE_TILE * LIST_TILE)
    }
}

/// Lists of the tiles.
struct Lists {
    pairs: Pairs,
    ranges: wgpu::Buffer,
}

/// Number of Gaussians.
///
/// # Errors
/// More than the device has room for.
pub(crate) fn room_for(gpu: &GpuDevice, clouds: &Clouds<'_>) -> Result<u32, SceneError> {
    let count: usize = clouds.iter().map(|(own, _)| own.len()).sum();
    let most = gpu.device.limits().max_storage_buffer_binding_size / SPLAT_BYTES;
    u32::try_from(count)
        .ok()
        .filter(|&count| u64::from(count) <= most)
        .ok_or_else(|| {
            gpu.failed(&format_args!(
                "{count} Gaussians are more than the {most} that its largest buffer holds"
            ))
        })
}

/// A cloud before the camera; page and count are left open.
fn view(own: &Gaussians, world_from_item: &DAffine3, shot: &Shot<'_>) -> ViewData {
    let world_from_local = *world_from_item * *own.world_from_local();
    let near = near_of_gaussians(PUBLISHED_NEAR, &world_from_local);
    let camera = (shot.camera, shot.settings.size);
    let view = CloudView::new(
        &world_from_local,
        near,
        camera,
        LowPass::Added(PUBLISHED_LOW_PASS),
    );
    let [to_x, to_y, to_z] = view.camera_from_local;
    ViewData {
        eye: view.eye[0],
        near: view.near,
        eye_rest: view.eye[1],
        scale: view.scale,
        to_x,
        low_pass: PUBLISHED_LOW_PASS,
        to_y,
        is_perspective: u32::from(view.perspective),
        to_z,
        degree: own.degree(),
        direction: view.direction.unwrap_or_default(),
        is_antialiased: u32::from(own.antialiased()),
        centre: view.centre,
        tangent_limit: view.tangent_limit,
        reference_tiles: view.reference_tiles.map(|n| n as f32),
        count: 0,
        before: 0,
    }
}

/// What splats are composited over: display colour, straight, and opacity.
struct Background {
    color: [f64; 3],
    alpha: f64,
}

impl Background {
    fn new(linear: [f32; 4]) -> Self {
        let [r, g, b, alpha] = linear.map(|value| splatvol_core::cloud_view::sane(f64::from(value)));
        Self {
            color: [r, g, b].map(srgb_from_linear),
            alpha: alpha.min(1.0),
        }
    }

    /// Premultiplied display colours with transmittances, and sums of depths, to linear light, as
    /// `splatvol_cpu::splats::blend::Published`.
    fn resolve(&self, frame: &mut Frame, (colors, depth_sums): (&[[f32; 4]], &[f32])) {
        let targets = frame
            .image
            .pixels
            .par_iter_mut()
            .zip(frame.depth.par_iter_mut().zip(&mut frame.optical_depth));
        let found = colors.par_iter().zip(depth_sums);
        targets.zip(found).for_each(
            |((pixel, (depth, optical_depth)), (&[r, g, b, through], &depth_sum))| {
                let covered = 1.0 - f64::from(through);
                let behind = f64::from(through) * self.alpha;
                let alpha = covered + behind;
                let channel = |own: f32, under: f64| {
                    let encoded = (f64::from(own) + behind * under) / alpha;
                    (linear_from_srgb(encoded) * alpha) as f32
                };
                let [under_r, under_g, under_b] = self.color;
                *pixel = match alpha > 0.0 {
                    true => [
                        channel(r, under_r),
                        channel(g, under_g),
                        channel(b, under_b),
                        alpha as f32,
                    ],
                    false => [0.0; 4],
                };
                (*depth, *optical_depth) = match covered > 0.0 {
                    true => (
                        (f64::from(depth_sum) / covered) as f32,
                        -libm::log(f64::from(through)) as f32,
                    ),
                    false => (f32::INFINITY, 0.0),
                };
            },
        );
    }
}
