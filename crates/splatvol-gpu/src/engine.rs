//! GPU engine: renders frames from cached state, as the engines of `splatvol-cpu` do.

use splatvol_core::bin::TileRect;
use splatvol_core::clock::Instant;
use splatvol_core::engine::{Engine, MemoryUse, RenderStatistics, Shot, Task};
use splatvol_core::level::blend;
use splatvol_scene::{Frame, ImageSize, SceneError};

use crate::check::supported;
use crate::device::{GpuConfig, GpuDevice};
use crate::error::GpuError;
use crate::gaussians::{Clouds, GaussianEngine, published, room_for};
use crate::layers::{LayerStore, Surface};
use crate::march::Canvas;
use crate::pipelines::Pipelines;
use crate::shown::Placed;

/// Renders scenes on a GPU.
#[derive(Debug)]
pub struct GpuEngine {
    gpu: GpuDevice,
    pipelines: Pipelines,
    layers: LayerStore,
    canvas: Option<Canvas>,
    /// The coarser level's frame, where two are blended.
    coarser: Option<Frame>,
    /// Made when Gaussians are first drawn.
    gaussians: Option<GaussianEngine>,
}

impl GpuEngine {
    /// Opens a device, and compiles its shaders.
    ///
    /// # Errors
    /// No adapter, or a driver that refuses the device or a shader.
    #[cfg(not(target_family = "wasm"))]
    pub fn new(config: &GpuConfig) -> Result<Self, GpuError> {
        pollster::block_on(Self::open(config))
    }

    /// As [`Self::new`], without blocking: in browsers nothing may wait.
    ///
    /// # Errors
    /// Those of [`Self::new`].
    pub async fn open(config: &GpuConfig) -> Result<Self, GpuError> {
        Self::on(GpuDevice::open(config).await?)
    }

    /// As [`Self::new`], on an open device.
    pub(crate) fn on(gpu: GpuDevice) -> Result<Self, GpuError> {
        let pipelines = Pipelines::new(&gpu)?;
        Ok(Self {
            gpu,
            pipelines,
            layers: LayerStore::default(),
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
}

impl GpuEngine {
    /// Renders Gaussians as published.
    async fn gaussians(
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
        let seconds = engine
            .render(&self.gpu, (clouds, shot), (canvas, frame), task)
            .await?;
        let mut statistics = RenderStatistics {
            seconds,
            ..statistics_of(&self.gpu)
        };
        statistics.seconds.total = start.elapsed().as_secs_f64();
        Ok(statistics)
    }
}

impl GpuEngine {
    /// Renders every volume at one of its levels, and the clouds.
    async fn once(
        &mut self,
        (shot, placed): (&Shot<'_>, &Placed<'_>),
        levels: &[usize],
        (frame, task): (&mut Frame, Task<'_>),
        statistics: &mut RenderStatistics,
    ) -> Result<(), SceneError> {
        let device = (&self.gpu, &mut self.pipelines);
        let surface = surface_of(&mut self.canvas, device, shot.settings.size)?;
        self.layers
            .render((shot, placed), levels, (surface, frame, task), statistics)
            .await
    }

    /// Renders layers.
    async fn layers(
        &mut self,
        shot: &Shot<'_>,
        frame: &mut Frame,
        task: Task<'_>,
    ) -> Result<RenderStatistics, SceneError> {
        let start = Instant::now();
        let placed = self.layers.place(shot, supported(shot)?)?;
        let segments = self.layers.segments(shot, &placed)?;
        if let (Some(first), Some(last)) = (segments.first(), segments.last()) {
            let mut statistics = RenderStatistics {
                level: first.level,
                levels: 1 + last.level - first.level,
                ..statistics_of(&self.gpu)
            };
            let device = (&self.gpu, &mut self.pipelines);
            let surface = surface_of(&mut self.canvas, device, shot.settings.size)?;
            self.layers
                .behind_each_other(
                    (shot, &placed),
                    &segments,
                    (surface, frame, task),
                    &mut statistics,
                )
                .await?;
            statistics.seconds.total = start.elapsed().as_secs_f64();
            return Ok(statistics);
        }
        let details: Vec<_> = placed.shown.iter().map(|own| own.detail(shot.camera)).collect();
        let mut levels: Vec<usize> = details.iter().map(|detail| detail.level).collect();
        let mut statistics = RenderStatistics {
            level: levels.first().copied().unwrap_or(0),
            levels: 1 + usize::from(details.iter().any(|detail| detail.coarser > 0.0)),
            ..statistics_of(&self.gpu)
        };
        self.once((shot, &placed), &levels, (&mut *frame, task), &mut statistics)
            .await?;
        for (at, detail) in details
            .iter()
            .enumerate()
            .filter(|(_, detail)| detail.coarser > 0.0)
        {
            let mut coarser = match self.coarser.take() {
                Some(coarser) if coarser.image.size() == frame.image.size() => coarser,
                _ => frame.clone(),
            };
            levels[at] += 1;
            let next = (&mut coarser, task.unseen(&|_| {}));
            self.once((shot, &placed), &levels, next, &mut statistics).await?;
            levels[at] -= 1;
            blend(frame, &coarser, detail.coarser);
            self.coarser = Some(coarser);
        }
        statistics.seconds.total = start.elapsed().as_secs_f64();
        Ok(statistics)
    }
}

impl GpuEngine {
    /// Cuts a window out of the whole picture: the device holds all of it.
    async fn window(
        &mut self,
        shot: &Shot<'_>,
        (frame, window): (&mut Frame, TileRect),
        task: Task<'_>,
    ) -> Result<RenderStatistics, SceneError> {
        let mut whole = Frame::empty(shot.settings.size);
        let task = Task { window: None, ..task };
        let statistics = self.picture(*shot, &mut whole, task).await?;
        *frame = whole.cut(window.x0..window.x1, window.y0..window.y1)?;
        Ok(statistics)
    }
}

/// Statistics of a picture by a device.
fn statistics_of(gpu: &GpuDevice) -> RenderStatistics {
    RenderStatistics {
        engine: "gpu",
        device: gpu.name.clone(),
        ..RenderStatistics::default()
    }
}

/// Where pictures of this size are made.
fn surface_of<'a>(
    canvas: &'a mut Option<Canvas>,
    (gpu, pipelines): (&'a GpuDevice, &'a mut Pipelines),
    size: ImageSize,
) -> Result<Surface<'a>, SceneError> {
    let canvas = canvas_of(canvas, gpu, size)?;
    Ok(Surface {
        gpu,
        pipelines,
        canvas,
    })
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

impl GpuEngine {
    /// Renders the whole picture.
    async fn picture(
        &mut self,
        shot: Shot<'_>,
        frame: &mut Frame,
        task: Task<'_>,
    ) -> Result<RenderStatistics, SceneError> {
        self.gpu.forget_passes();
        let mut statistics = match published(&shot)? {
            Some(clouds) => self.gaussians((&clouds, &shot), frame, task).await?,
            None => {
                let drawn = self.layers(&shot, frame, task).await;
                drawn.inspect_err(|_| self.layers.forget_failed())?
            }
        };
        statistics.passes = self.gpu.pass_seconds().await?;
        Ok(statistics)
    }

    /// As [`Engine::render`], without blocking: in browsers nothing may wait.
    ///
    /// # Errors
    /// Those of [`Engine::render`].
    pub async fn render_async(
        &mut self,
        shot: Shot<'_>,
        frame: &mut Frame,
        task: Task<'_>,
    ) -> Result<RenderStatistics, SceneError> {
        match task.window {
            Some(window) => self.window(&shot, (frame, window), task).await,
            None => self.picture(shot, frame, task).await,
        }
    }
}

impl Engine for GpuEngine {
    fn check(&self, shot: Shot<'_>) -> Result<(), SceneError> {
        match published(&shot)? {
            Some(clouds) => room_for(&self.gpu, &clouds).map(|_| ()),
            None => supported(&shot).map(|_| ()),
        }
    }

    #[cfg(not(target_family = "wasm"))]
    fn render(
        &mut self,
        shot: Shot<'_>,
        frame: &mut Frame,
        task: Task<'_>,
    ) -> Result<RenderStatistics, SceneError> {
        task.refuse_partial()?;
        pollster::block_on(self.render_async(shot, frame, task))
    }

    #[cfg(target_family = "wasm")]
    fn render(&mut self, _: Shot<'_>, _: &mut Frame, _: Task<'_>) -> Result<RenderStatistics, SceneError> {
        Err(self
            .gpu
            .failed(&"in browsers nothing may wait for it: take `render_async`"))
    }

    fn memory(&self) -> MemoryUse {
        let [volumes, spare_volumes] = self.layers.host_bytes();
        MemoryUse {
            volumes,
            spare_volumes,
            clouds: self.layers.cloud_bytes(),
            device: self.layers.device_bytes()
                + self.canvas.as_ref().map_or(0, Canvas::bytes)
                + self.gaussians.as_ref().map_or(0, GaussianEngine::bytes),
            ..MemoryUse::default()
        }
    }
}
