//! The renderer: keeps what it derives from a volume, plans a frame, runs its tiles.

use fearless_simd::Level;
use splatvol_scene::{Camera, Coverage, Exposure, Frame, RenderSettings, Scene, SceneError};

use crate::check::check;
use crate::classic::{self, ClassicEngine};
use crate::clock::Instant;
use crate::clouds::SplatScene;
use crate::config::{EngineConfig, EngineError, level_name};
use crate::control::{Control, Progress, Task};
use crate::coverage::Edges;
use crate::items::ItemStore;
use crate::meshes::MeshStore;
use crate::part;
use crate::pool::Pool;
use crate::route::{Parts, PlacedVolumes, Route};
use crate::run::Run;
use crate::sheets::engine::{SheetEngine, TILE_EDGE};
use crate::sheets::prepared::SPARE;
use crate::sheets::scene::LayeredScene;
use crate::shutter::{self, Exposed};
use crate::splats::{Cloud, SplatEngine};
use crate::statistics::{MemoryUse, RenderStatistics, StageSeconds};

/// Renders scenes; keeps what it derives from their items between frames.
#[derive(Debug)]
pub struct Renderer {
    pool: Pool,
    tile_edge: Option<usize>,
    level: Level,
    placed: PlacedVolumes,
    data: SheetEngine,
    classic: ClassicEngine,
    splats: SplatEngine,
    /// Clouds of what is classified first.
    items: ItemStore,
    /// Clouds of meshes whose values are classified behind their kernels.
    meshes: MeshStore,
    /// The larger picture that edges are sampled from.
    fine: Option<Frame>,
    statistics: RenderStatistics,
}

impl Renderer {
    /// Starts the engine.
    ///
    /// # Errors
    /// Threads that the system refuses, or a tile edge outside its domain.
    pub fn new(config: EngineConfig) -> Result<Self, EngineError> {
        Self::with_pool(Pool::new(config.threads)?, config)
    }

    /// Starts the engine with threads that are there: renderers may share them.
    ///
    /// # Errors
    /// Another number of threads than the pool has, or a tile edge outside its domain.
    pub fn with_pool(pool: impl Into<Pool>, config: EngineConfig) -> Result<Self, EngineError> {
        let pool = pool.into();
        let there = pool.current_num_threads();
        if let Some(threads) = config.threads.filter(|&threads| threads != there) {
            return Err(EngineError::Pool { threads, there });
        }
        if let Some(edge) = config
            .tile_edge
            .filter(|edge| !edge.is_multiple_of(16) || !(16..=TILE_EDGE).contains(edge))
        {
            return Err(EngineError::TileEdge { edge });
        }
        let level = match config.simd {
            None => Level::new(),
            Some(simd) => simd.level().ok_or(EngineError::Simd { simd })?,
        };
        let statistics = RenderStatistics::default();
        Ok(Self {
            pool,
            tile_edge: config.tile_edge,
            level,
            placed: PlacedVolumes::default(),
            data: SheetEngine::with_spare(config.spare_bytes.unwrap_or(SPARE)),
            classic: ClassicEngine::default(),
            splats: SplatEngine::default(),
            items: ItemStore::default(),
            meshes: MeshStore::default(),
            fine: None,
            statistics,
        })
    }

    /// Renders one frame.
    ///
    /// A volume alone is rendered by the engines for grids. Several things are classified, lit, and composited sheet by
    /// sheet, or one by one ([`splatvol_scene::Compositing::PerSplat`]). Nothing but Gaussians is rendered as published,
    /// unless the settings say otherwise ([`splatvol_scene::GaussianMode`]).
    ///
    /// # Errors
    /// Settings outside their domain, methods that a kind of item does not have, or a rasteriser that cannot draw the
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
    /// Settings outside their domain, or a rasteriser that cannot draw the footprints of this view.
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

    /// Renders one frame into memory that is there, or a part of it, and can be stopped.
    ///
    /// # Errors
    /// As [`Renderer::render`]; and [`SceneError::Stopped`], which leaves nonsense in the frame.
    pub fn render_with(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        settings: &RenderSettings,
        frame: &mut Frame,
        control: &Control<'_>,
    ) -> Result<(), SceneError> {
        let progress = Progress::new(control);
        progress.report(0.0);
        let report = |share| progress.report(share);
        let task = Task::new(control, &report);
        self.render_whole(scene, (camera, settings), frame, task)?;
        if let Some(part) = &control.part {
            part::keep(frame, part);
        }
        self.statistics.memory = self.memory();
        task.show_all(frame);
        progress.report(1.0);
        Ok(())
    }

    /// Bytes held between frames.
    fn memory(&self) -> MemoryUse {
        let [volumes, spare_volumes, tiles] = self.data.bytes();
        let [samples, cloud] = self.classic.bytes();
        MemoryUse {
            volumes: volumes + samples,
            spare_volumes,
            clouds: self.items.bytes() + self.meshes.bytes() + cloud,
            tiles: tiles + self.splats.bytes(),
        }
    }

    /// Renders one frame into memory that is there: frames of a volume allocate nothing but for the first two, where
    /// gradients are differences ([`RenderSettings::fast`]).
    ///
    /// # Errors
    /// Settings outside their domain, or a rasteriser that cannot draw the footprints of this view.
    pub fn render_into(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        settings: &RenderSettings,
        frame: &mut Frame,
    ) -> Result<(), SceneError> {
        self.render_with(scene, camera, settings, frame, &Control::default())
    }

    fn render_whole(
        &mut self,
        scene: &Scene,
        (camera, settings): (&Camera, &RenderSettings),
        frame: &mut Frame,
        task: Task<'_>,
    ) -> Result<(), SceneError> {
        check(scene, camera, settings)?;
        if let Some(exposed) = shutter::sub_frames(scene, camera, settings)? {
            return self.render_mean(&exposed, settings, frame, task);
        }
        let route = Route::of(scene, settings, &mut self.placed)?;
        let shot = Shot {
            scene,
            route: &route,
            camera,
        };
        if settings.coverage == Coverage::Off {
            return self.render_once(&shot, settings, frame, (task, None));
        }
        let first = |done: f64| (task.progress)(0.5 * done);
        let second = |done: f64| (task.progress)(0.5 + 0.5 * done);
        let around = Task {
            progress: &first,
            // Edges are differences from neighbours.
            part: task.part.map(part::with_neighbors),
            ..task
        };
        self.render_once(&shot, settings, frame, (around, None))?;
        if let Some(edges) = Edges::of(frame, settings.coverage) {
            self.refine(&shot, settings, frame, (task.unseen(&second), &edges))?;
        }
        Ok(())
    }

    /// Replaces the edges of a frame by the means of several samples.
    fn refine(
        &mut self,
        shot: &Shot<'_>,
        settings: &RenderSettings,
        frame: &mut Frame,
        (task, edges): (Task<'_>, &Edges),
    ) -> Result<(), SceneError> {
        let first = self.statistics.clone();
        let settings = edges.settings(settings)?;
        let mut fine = self.fine.take().unwrap_or_else(|| Frame::empty(settings.size));
        self.render_once(shot, &settings, &mut fine, (edges.task(task), Some(edges)))?;
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

    /// One picture, or the tiles of it that edges need.
    fn render_once(
        &mut self,
        shot: &Shot<'_>,
        settings: &RenderSettings,
        frame: &mut Frame,
        (task, only): (Task<'_>, Option<&Edges>),
    ) -> Result<(), SceneError> {
        if !frame.fits(settings.size) {
            *frame = Frame::empty(settings.size);
        }
        let pool = self.pool.clone();
        let run = Run {
            pool: &pool,
            level: self.level,
            tile_edge: self.tile_edge,
            task,
            only,
        };
        let view = (shot.camera, settings);
        match shot.route {
            Route::Volume(scene) => {
                if classic::render(scene.motion, settings) {
                    self.statistics = self.classic.render(run, scene, view, frame)?;
                } else {
                    self.statistics = self.data.render(run, scene, view, frame);
                }
            }
            Route::Layers(parts) => self.render_layers(run, shot, (parts, settings), frame)?,
            Route::Splats(splats) => self.render_splats(run, shot, (splats, settings), frame)?,
        }
        task.go_on()
    }

    /// Renders a scene in layers.
    fn render_layers(
        &mut self,
        run: Run<'_>,
        shot: &Shot<'_>,
        (parts, settings): (&Parts<'_>, &RenderSettings),
        frame: &mut Frame,
    ) -> Result<(), SceneError> {
        let view = (shot.camera, settings);
        let start = Instant::now();
        let cloud = match parts.rest.items.is_empty() {
            true => None,
            false => Some(
                self.items
                    .cloud(run, &parts.rest, view)
                    .ok_or(SceneError::Stopped)?,
            ),
        };
        self.meshes
            .update(run, &parts.meshes, settings)
            .ok_or(SceneError::Stopped)?;
        let scene = LayeredScene {
            volumes: &parts.volumes,
            meshes: &parts.meshes,
            mesh_clouds: &self.meshes,
            cloud,
            clips: &shot.scene.clips,
        };
        self.statistics = self.data.render_layers(run, &scene, view, (frame, start));
        Ok(())
    }

    /// Renders splats one by one.
    fn render_splats(
        &mut self,
        run: Run<'_>,
        shot: &Shot<'_>,
        (drawn, settings): (&SplatScene<'_>, &RenderSettings),
        frame: &mut Frame,
    ) -> Result<(), SceneError> {
        let start = Instant::now();
        let mut clouds = drawn.gaussians.clone();
        let mut spacing = 0.0;
        if !drawn.rest.items.is_empty() {
            let view = (shot.camera, settings);
            let cloud = self
                .items
                .cloud(run, &drawn.rest, view)
                .ok_or(SceneError::Stopped)?;
            spacing = cloud.spacing;
            clouds.push(Cloud::Kernels(cloud));
        }
        let classify = start.elapsed().as_secs_f64();
        let settings = drawn.settings(shot.scene, settings, spacing);
        let mut seconds = self.splats.render(run, &clouds, (shot.camera, &settings), frame);
        seconds.classify = classify;
        seconds.total = start.elapsed().as_secs_f64();
        self.statistics = RenderStatistics {
            seconds,
            threads: run.pool.current_num_threads(),
            engine: "splats",
            simd: level_name(self.level),
            voxels: clouds.iter().map(|cloud| cloud.len() as u64).sum(),
            ..RenderStatistics::default()
        };
        Ok(())
    }

    /// The mean of the pictures of a scene at rest: what a shutter sees while it is open.
    fn render_mean(
        &mut self,
        exposed: &[Exposed<'_>],
        settings: &RenderSettings,
        frame: &mut Frame,
        task: Task<'_>,
    ) -> Result<(), SceneError> {
        let mut exposure = Exposure::new(settings.size);
        let mut total = StageSeconds::default();
        for (index, Exposed { scene, camera }) in exposed.iter().enumerate() {
            let share = |done: f64| (task.progress)((index as f64 + done) / exposed.len() as f64);
            self.render_whole(
                scene,
                (camera, &shutter::still(settings)),
                frame,
                task.unseen(&share),
            )?;
            exposure.add(frame)?;
            total = total.plus(&self.statistics.seconds);
        }
        self.statistics.seconds = total;
        exposure.take(frame)
    }

    /// Times and counts of the last frame; of the mean of several, all their times, and the counts of the last of them.
    pub fn statistics(&self) -> &RenderStatistics {
        &self.statistics
    }
}

/// What is rendered, which way, and from where.
struct Shot<'a> {
    scene: &'a Scene,
    route: &'a Route<'a>,
    camera: &'a Camera,
}
