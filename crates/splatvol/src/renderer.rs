//! The renderer: motion blur, anti-aliasing of edges, parts and progress, on top of an engine's pictures.

use splatvol_core::bin::TileRect;
use splatvol_core::engine::{
    Control, Edges, Engine, Progress, RenderStatistics, Share, Shot, StageSeconds, Task,
};
use splatvol_cpu::{EngineConfig, EngineError, Pool};
use splatvol_scene::{Camera, Coverage, Exposure, Frame, RenderSettings, Scene, SceneError};

use crate::CpuEngine;
use crate::check::check_by;
use crate::part;
use crate::shutter::{self, Exposed};

/// Renders scenes; caches data derived from their items between frames.
#[derive(Debug)]
pub struct Renderer {
    engine: Box<dyn Engine>,
    /// The larger picture that edges are sampled from.
    fine: Option<Frame>,
    statistics: RenderStatistics,
}

impl Renderer {
    /// Starts an engine on the CPU.
    ///
    /// # Errors
    /// Threads that the system refuses, or a tile edge out of range.
    pub fn new(config: EngineConfig) -> Result<Self, EngineError> {
        CpuEngine::new(config).map(Self::with_engine)
    }

    /// Starts an engine on the CPU with existing threads: renderers may share them.
    ///
    /// # Errors
    /// A number of threads other than the pool's, or a tile edge out of range.
    pub fn with_pool(pool: impl Into<Pool>, config: EngineConfig) -> Result<Self, EngineError> {
        CpuEngine::with_pool(pool, config).map(Self::with_engine)
    }

    /// Renders with an engine that was started elsewhere.
    pub fn with_engine(engine: impl Engine + 'static) -> Self {
        Self {
            engine: Box::new(engine),
            fine: None,
            statistics: RenderStatistics::default(),
        }
    }

    /// Renders one frame.
    ///
    /// A single volume is rendered by the engines for grids. Several items are classified, lit, and composited sheet by
    /// sheet, or one by one ([`splatvol_scene::Compositing::PerSplat`]). A scene of Gaussians only is rendered as
    /// published, unless the settings say otherwise ([`splatvol_scene::GaussianMode`]).
    ///
    /// # Errors
    /// Settings out of range, methods that a kind of item does not support, or a rasteriser that cannot draw the
    /// footprints of this view.
    pub fn render(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        settings: &RenderSettings,
    ) -> Result<Frame, SceneError> {
        self.render_with_progress(scene, camera, settings, &|_| {})
    }

    /// Renders one frame, reporting the finished share (0..1) from any thread.
    ///
    /// # Errors
    /// Settings out of range, or a rasteriser that cannot draw the footprints of this view.
    pub fn render_with_progress(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        settings: &RenderSettings,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Frame, SceneError> {
        let mut frame = Frame::empty(settings.size);
        let control = Control {
            progress: Some(progress),
            ..Control::default()
        };
        self.render_with(scene, camera, settings, &mut frame, &control)?;
        Ok(frame)
    }

    /// Renders one frame into an existing frame. Frames of a volume allocate nothing, except the first two if gradients
    /// are differences ([`RenderSettings::fast`]).
    ///
    /// # Errors
    /// Settings out of range, or a rasteriser that cannot draw the footprints of this view.
    pub fn render_into(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        settings: &RenderSettings,
        frame: &mut Frame,
    ) -> Result<(), SceneError> {
        self.render_with(scene, camera, settings, frame, &Control::default())
    }

    /// Renders one frame, a part of it, or a window, into an existing frame, and can be stopped. The frame gets the size
    /// of the picture, or of the window ([`Control::window`]).
    ///
    /// # Errors
    /// Same as [`Renderer::render`]; a window that is not within the picture; and [`SceneError::Stopped`], which leaves
    /// the frame in an undefined state.
    pub fn render_with(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        settings: &RenderSettings,
        frame: &mut Frame,
        control: &Control<'_>,
    ) -> Result<(), SceneError> {
        part::check_partial(control, settings)?;
        let progress = Progress::new(control);
        progress.report(0.0);
        let report = |share| progress.report(share);
        let task = Task::new(control, &report);
        let shot = Shot {
            scene,
            camera,
            settings,
        };
        match control.window {
            Some(window) => self.render_window(shot, (frame, window), task)?,
            None => self.render_moving(shot, frame, task)?,
        }
        let held = task.held(settings.size);
        if let Some(part) = &control.part {
            part::keep(frame, (&held, part));
        }
        if let Some(share) = control.share {
            share.keep(frame, [held.x0, held.y0]);
        }
        self.statistics.memory = self.engine.memory();
        task.show_all(frame);
        progress.report(1.0);
        Ok(())
    }

    /// Renders the mean of what several cameras see: the picture of a shutter that is open while the camera moves.
    ///
    /// # Errors
    /// Same as [`Renderer::render_with`]; and no camera.
    pub fn expose(
        &mut self,
        scene: &Scene,
        cameras: &[Camera],
        settings: &RenderSettings,
        frame: &mut Frame,
        control: &Control<'_>,
    ) -> Result<(), SceneError> {
        if let Some(partial) = control.partial {
            return Err(SceneError::invalid("partial", partial, "a picture of one moment"));
        }
        let size = control.window.map_or(Ok(settings.size), |window| window.size())?;
        let mut exposure = Exposure::new(size);
        for (index, camera) in cameras.iter().enumerate() {
            let report = |done: f64| {
                if let Some(progress) = control.progress {
                    progress((index as f64 + done) / cameras.len() as f64);
                }
            };
            let control = Control {
                progress: Some(&report),
                tile: None,
                ..*control
            };
            self.render_with(scene, camera, settings, frame, &control)?;
            exposure.add(frame)?;
        }
        exposure.take(frame)
    }

    /// Times and counts of the last frame; if it is the mean of several pictures, their total times, and the counts of
    /// the last of them.
    pub fn statistics(&self) -> &RenderStatistics {
        &self.statistics
    }

    /// Renders the pixels of a window, and as many more as engines and edges need.
    fn render_window(
        &mut self,
        shot: Shot<'_>,
        (frame, window): (&mut Frame, TileRect),
        task: Task<'_>,
    ) -> Result<(), SceneError> {
        let around = part::around(window, shot.settings)?;
        let task = Task {
            window: Some(around),
            part: Some(task.part.map_or(window, |part| part.overlap(&window))),
            tile: None,
            ..task
        };
        if around == window {
            return self.render_moving(shot, frame, task);
        }
        let mut larger = Frame::empty(around.size()?);
        self.render_moving(shot, &mut larger, task)?;
        let own = |from: usize, to: usize, first: usize| from - first..to - first;
        *frame = larger.cut(
            own(window.x0, window.x1, around.x0),
            own(window.y0, window.y1, around.y0),
        )?;
        Ok(())
    }

    /// Renders the picture that a shutter sees, or a scene at rest.
    fn render_moving(&mut self, shot: Shot<'_>, frame: &mut Frame, task: Task<'_>) -> Result<(), SceneError> {
        check_by(shot, |shot| self.engine.check(shot))?;
        match shutter::sub_frames(shot)? {
            Some(exposed) => self.render_mean(&exposed, shot.settings, frame, task),
            None => self.render_sampled(shot, frame, task),
        }
    }

    /// The mean of pictures of scenes at rest: the motion-blurred picture of an open shutter.
    fn render_mean(
        &mut self,
        exposed: &[Exposed<'_>],
        settings: &RenderSettings,
        frame: &mut Frame,
        task: Task<'_>,
    ) -> Result<(), SceneError> {
        let mut exposure = Exposure::new(task.held(settings.size).size()?);
        let mut total = StageSeconds::default();
        let settings = shutter::still(settings);
        for (index, Exposed { scene, camera }) in exposed.iter().enumerate() {
            let share = |done: f64| (task.progress)((index as f64 + done) / exposed.len() as f64);
            let shot = Shot {
                scene,
                camera,
                settings: &settings,
            };
            self.render_moving(shot, frame, task.unseen(&share))?;
            exposure.add(frame)?;
            total = total.plus(&self.statistics.seconds);
        }
        self.statistics.seconds = total;
        exposure.take(frame)
    }

    /// Renders a scene at rest, with several samples at its edges if the settings ask for it.
    fn render_sampled(
        &mut self,
        shot: Shot<'_>,
        frame: &mut Frame,
        task: Task<'_>,
    ) -> Result<(), SceneError> {
        let coverage = shot.settings.coverage;
        if coverage == Coverage::Off {
            return self.render_once(shot, frame, task);
        }
        let first = |done: f64| (task.progress)(0.5 * done);
        let second = |done: f64| (task.progress)(0.5 + 0.5 * done);
        let around = Task {
            progress: &first,
            // Edges are differences from neighbours.
            part: task.part.map(part::with_neighbors),
            share: task.share.map(Share::with_neighbors),
            ..task
        };
        self.render_once(shot, frame, around)?;
        let held = task.held(shot.settings.size);
        match Edges::of(frame, [held.x0, held.y0], coverage) {
            Some(edges) => self.refine(shot, frame, (task.unseen(&second), &edges)),
            None => Ok(()),
        }
    }

    /// Replaces the edge pixels of a frame by the means of several samples.
    fn refine(
        &mut self,
        shot: Shot<'_>,
        frame: &mut Frame,
        (task, edges): (Task<'_>, &Edges),
    ) -> Result<(), SceneError> {
        let first = self.statistics.clone();
        let settings = &edges.settings(shot.settings)?;
        let task = edges.task(task);
        let mut fine = match self.fine.take() {
            Some(fine) => fine,
            None => Frame::empty(task.held(settings.size).size()?),
        };
        self.render_once(Shot { settings, ..shot }, &mut fine, task)?;
        edges.refine(frame, &fine);
        self.fine = Some(fine);
        let seconds = first.seconds.plus(&self.statistics.seconds);
        self.statistics = RenderStatistics {
            seconds,
            sampled_pixels: edges.count() as u64,
            ..first
        };
        Ok(())
    }

    /// Renders one picture by the engine.
    fn render_once(&mut self, shot: Shot<'_>, frame: &mut Frame, task: Task<'_>) -> Result<(), SceneError> {
        let size = task.held(shot.settings.size).size()?;
        if !frame.fits(size) {
            *frame = Frame::empty(size);
        }
        self.statistics = self.engine.render(shot, frame, task)?;
        Ok(())
    }
}
