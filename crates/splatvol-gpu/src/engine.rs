//! GPU engine: renders frames from cached state, as the engine `sheets` of `splatvol-cpu` does.

use std::sync::{Arc, Weak};
use std::time::Instant;

use glam::DAffine3;
use splatvol_core::engine::{Engine, MemoryUse, RenderStatistics, Shot, Task};
use splatvol_core::level::{Detail, Wanted, blend};
use splatvol_core::plan::{GridView, Sampling};
use splatvol_core::prepared::{PreparedVolumes, SPARE};
use splatvol_scene::{
    Camera, Frame, Gradient, ImageSize, RenderSettings, SceneError, SheetKernel, SheetSettings, SingleVolume,
    TransferFunction, Volume,
};

use crate::atlas::Atlas;
use crate::check::supported;
use crate::device::{GpuConfig, GpuDevice};
use crate::effects::Effects;
use crate::error::GpuError;
use crate::gaussians::{Clouds, GaussianEngine, published, room_for};
use crate::layout::Picture;
use crate::march::{Canvas, March};
use crate::mode::Mode;
use crate::pipelines::{Classify, Pipelines, Variant};
use crate::voxels::{KeptSamples, Voxels};

/// Renders volumes on a GPU.
#[derive(Debug)]
pub struct GpuEngine {
    gpu: GpuDevice,
    pipelines: Pipelines,
    prepared: PreparedVolumes,
    placed: Option<(Weak<Volume>, DAffine3, Arc<Volume>)>,
    /// Coefficients on the device, by level.
    resident: Vec<Resident>,
    samples: KeptSamples,
    canvas: Option<Canvas>,
    /// The coarser level's frame, where two are blended.
    coarser: Option<Frame>,
    /// Made when Gaussians are first drawn.
    gaussians: Option<GaussianEngine>,
}

/// Coefficients on the device, and what they are of.
#[derive(Debug)]
struct Resident {
    level: usize,
    of: Key,
    atlas: Atlas,
    voxels: Option<Voxels>,
}

/// What a volume's needed coefficients depend on.
#[derive(Debug, Clone)]
struct Key {
    volume: Weak<Volume>,
    transfer_function: TransferFunction,
    unit_distance: f64,
    kernel: SheetKernel,
    prefilter: bool,
    wanted: Wanted,
}

impl PartialEq for Key {
    fn eq(&self, other: &Self) -> bool {
        Weak::ptr_eq(&self.volume, &other.volume)
            && self.transfer_function == other.transfer_function
            && self.unit_distance == other.unit_distance
            && self.kernel == other.kernel
            && self.prefilter == other.prefilter
            && self.wanted == other.wanted
    }
}

impl GpuEngine {
    /// Opens a device, and compiles its shaders.
    ///
    /// # Errors
    /// No adapter, or a driver that refuses the device or a shader.
    pub fn new(config: &GpuConfig) -> Result<Self, GpuError> {
        let gpu = GpuDevice::open(config)?;
        let pipelines = Pipelines::new(&gpu)?;
        Ok(Self {
            gpu,
            pipelines,
            prepared: PreparedVolumes::with_spare(SPARE),
            placed: None,
            resident: Vec::new(),
            samples: KeptSamples::default(),
            canvas: None,
            coarser: None,
            gaussians: None,
        })
    }

    /// Name of the adapter, and of the interface to its driver.
    pub fn adapter(&self) -> &str {
        &self.gpu.name
    }

    /// Whether the processor does the device's work.
    pub fn is_imitated(&self) -> bool {
        self.gpu.is_imitated
    }

    /// The volume where it lies.
    fn place(&mut self, single: &SingleVolume<'_>) -> Result<Arc<Volume>, SceneError> {
        let at = single.item.world_from_item;
        if let Some((volume, place, placed)) = &self.placed
            && std::ptr::addr_eq(volume.as_ptr(), Arc::as_ptr(single.volume))
            && *place == at
        {
            return Ok(Arc::clone(placed));
        }
        self.placed = None;
        let placed = single.placed()?;
        self.placed = Some((Arc::downgrade(single.volume), at, Arc::clone(&placed)));
        Ok(placed)
    }
}

/// A volume where it lies, and its look.
#[derive(Debug, Clone, Copy)]
struct Shown<'a> {
    volume: &'a Arc<Volume>,
    transfer_function: &'a TransferFunction,
    unit_distance: f64,
    labels: bool,
    camera: &'a Camera,
    settings: &'a RenderSettings<SheetSettings>,
    effects: &'a Effects,
}

impl Shown<'_> {
    fn key(&self) -> Key {
        Key {
            volume: Arc::downgrade(self.volume),
            transfer_function: self.transfer_function.clone(),
            unit_distance: self.unit_distance,
            kernel: self.settings.method.kernel,
            prefilter: self.settings.method.prefilter,
            wanted: Wanted::of(self.settings),
        }
    }

    /// Voxels along an axis that the kernel meets.
    fn taps(&self) -> i32 {
        if self.settings.method.kernel.radius > 2.0 {
            6
        } else {
            4
        }
    }
}

impl GpuEngine {
    /// Renders Gaussians as published.
    fn gaussians(
        &mut self,
        (clouds, shot): (&Clouds<'_>, &Shot<'_>),
        frame: &mut Frame,
        task: Task<'_>,
    ) -> Result<RenderStatistics, SceneError> {
        let start = Instant::now();
        let canvas = canvas_of(&mut self.canvas, &self.gpu, shot.settings.size)?;
        let engine = match self.gaussians.take() {
            Some(engine) => engine,
            None => GaussianEngine::new(&self.gpu)?,
        };
        let engine = self.gaussians.insert(engine);
        let seconds = engine.render(&self.gpu, (clouds, shot), (canvas, frame), task)?;
        let mut statistics = RenderStatistics {
            seconds,
            engine: "gpu",
            device: self.gpu.name.clone(),
            ..RenderStatistics::default()
        };
        statistics.seconds.total = start.elapsed().as_secs_f64();
        Ok(statistics)
    }

    /// Renders one level of a volume.
    fn level(
        &mut self,
        shown: &Shown<'_>,
        level: usize,
        (frame, task): (&mut Frame, Task<'_>),
        statistics: &mut RenderStatistics,
    ) -> Result<(), SceneError> {
        let start = Instant::now();
        let wanted = Wanted::of(shown.settings);
        let mode = Mode::of(wanted, &shown.settings.method, shown.effects);
        let [pyramid, ..] = self
            .prepared
            .of_scene(std::iter::once(shown.volume), shown.settings)
        else {
            return Ok(());
        };
        let look = (shown.transfer_function, shown.unit_distance);
        let prepared = pyramid.classify(level, look, wanted, task.stop)?;
        prepared.count_work(statistics);
        let sampling = if mode.splats_classes() {
            Sampling::Planes
        } else {
            Sampling::Field
        };
        let grid = prepared.field.source().grid();
        let view = GridView::new(grid, (shown.camera, shown.settings), sampling, None);
        let key = shown.key();
        self.resident.retain(|resident| resident.of == key);
        let known = self.resident.iter().position(|resident| resident.level == level);
        let at = match known {
            Some(at) => at,
            None => {
                let made = if mode.splats_classes() {
                    let of = (level, &prepared.field);
                    let samples = self.samples.of(&self.gpu, &key.volume, of)?;
                    let (atlas, voxels) = Voxels::new(&self.gpu, prepared, &samples, shown.taps())?;
                    (atlas, Some(voxels))
                } else {
                    (Atlas::new(&self.gpu, &prepared.field, shown.taps())?, None)
                };
                self.resident.push(Resident {
                    level,
                    of: key,
                    atlas: made.0,
                    voxels: made.1,
                });
                self.resident.len() - 1
            }
        };
        let Resident { atlas, voxels, .. } = &self.resident[at];
        let canvas = canvas_of(&mut self.canvas, &self.gpu, shown.settings.size)?;
        let ready = Instant::now();
        statistics.seconds.classify += (ready - start).as_secs_f64();
        statistics.active_bricks += if mode.splats_classes() {
            prepared.visible.len()
        } else {
            prepared.field.len()
        };
        statistics.sheets += view.planes().count;
        let variant = Variant {
            mode,
            taps: shown.taps(),
            from_eye: view.holds_eye(),
            has_holes: !mode.splats_classes() && prepared.field.any_missing(),
        };
        let marches = self.pipelines.marches(&self.gpu, variant)?;
        let classify = match voxels {
            Some(voxels) => Some(self.pipelines.classify(
                &self.gpu,
                Classify {
                    taps: shown.taps(),
                    from_means: voxels.has_means(),
                    labels: shown.labels,
                },
            )?),
            None => None,
        };
        let march = March {
            gpu: &self.gpu,
            pipelines: &self.pipelines,
            atlas,
            canvas,
            marches: &marches,
            mode,
            picture: Picture {
                view: &view,
                level: prepared,
                settings: shown.settings,
                voxel: shown.volume.grid().mean_spacing(),
                unit_distance: shown.unit_distance,
                effects: shown.effects,
            },
            voxels: voxels.as_ref().zip(classify.as_deref()),
        };
        march.render(task, frame)?;
        statistics.seconds.tiles += ready.elapsed().as_secs_f64();
        Ok(())
    }
}

/// The canvas of pictures of this size.
fn canvas_of<'a>(
    kept: &'a mut Option<Canvas>,
    gpu: &GpuDevice,
    size: ImageSize,
) -> Result<&'a Canvas, SceneError> {
    let pixels = size.pixel_count() as u64;
    let canvas = match kept.take().filter(|canvas| canvas.is_of(pixels)) {
        Some(canvas) => canvas,
        None => Canvas::new(gpu, pixels)?,
    };
    Ok(kept.insert(canvas))
}

impl Engine for GpuEngine {
    fn check(&self, shot: Shot<'_>) -> Result<(), SceneError> {
        match published(&shot)? {
            Some(clouds) => room_for(&self.gpu, &clouds).map(|_| ()),
            None => supported(&shot).map(|_| ()),
        }
    }

    fn render(
        &mut self,
        shot: Shot<'_>,
        frame: &mut Frame,
        task: Task<'_>,
    ) -> Result<RenderStatistics, SceneError> {
        if let Some(clouds) = published(&shot)? {
            return self.gaussians((&clouds, &shot), frame, task);
        }
        let start = Instant::now();
        let (single, sheets) = supported(&shot)?;
        let volume = self.place(&single)?;
        let settings = shot.settings.with(sheets);
        let spacing = volume.grid().mean_spacing();
        let range = volume.value_range();
        let effects = Effects::new((shot.scene, &single), shot.camera, (range, spacing));
        let shown = Shown {
            volume: &volume,
            transfer_function: single.transfer_function,
            unit_distance: single.unit_distance(),
            labels: single.labels,
            camera: shot.camera,
            settings: &settings,
            effects: &effects,
        };
        // Labels are lit by their own shapes, analytic gradients show the field as it is.
        let is_classified = Wanted::of(&settings) == Wanted::Classified;
        let detail = if single.labels || (!is_classified && settings.method.gradient == Gradient::Analytic) {
            Detail::FINEST
        } else {
            Detail::new(&volume, shot.camera, (settings.size, settings.method.level_bias))
        };
        let mut statistics = RenderStatistics {
            engine: "gpu",
            device: self.gpu.name.clone(),
            level: detail.level,
            ..RenderStatistics::default()
        };
        self.level(&shown, detail.level, (&mut *frame, task), &mut statistics)?;
        if detail.coarser > 0.0 {
            let mut coarser = match self.coarser.take() {
                Some(coarser) if coarser.image.size() == frame.image.size() => coarser,
                _ => frame.clone(),
            };
            let next = (&mut coarser, task.unseen(&|_| {}));
            self.level(&shown, detail.level + 1, next, &mut statistics)?;
            blend(frame, &coarser, detail.coarser);
            self.coarser = Some(coarser);
        }
        statistics.seconds.total = start.elapsed().as_secs_f64();
        Ok(statistics)
    }

    fn memory(&self) -> MemoryUse {
        let [volumes, spare_volumes] = self.prepared.bytes();
        MemoryUse {
            volumes,
            spare_volumes,
            device: self
                .resident
                .iter()
                .map(|resident| resident.atlas.layout.bytes() as usize)
                .sum::<usize>()
                + self.samples.bytes() as usize
                + self.canvas.as_ref().map_or(0, Canvas::bytes)
                + self.gaussians.as_ref().map_or(0, GaussianEngine::bytes),
            ..MemoryUse::default()
        }
    }
}
