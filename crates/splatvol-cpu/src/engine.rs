//! CPU engine: selects the render loop for a scene, and caches data derived from the scene's items.

use splatvol_core::clock::Instant;
use splatvol_core::engine::{Engine, MemoryUse, RenderStatistics, Shot, Task};
use splatvol_core::prepared::SPARE;
use splatvol_scene::{Frame, RenderSettings, SceneError, SheetSettings};

use crate::check::check;
use crate::classic::ClassicEngine;
use crate::clouds::SplatScene;
use crate::config::{EngineConfig, EngineError};
use crate::instructions::InstructionSet;
use crate::integrals;
use crate::items::ItemStore;
use crate::meshes::MeshStore;
use crate::pool::Pool;
use crate::route::{Parts, PlacedVolumes, Route};
use crate::run::{Pass, Run};
use crate::sheets::engine::SheetEngine;
use crate::sheets::scene::LayeredScene;
use crate::sheets::tiles::TILE_EDGE;
use crate::splats::{Cloud, SplatEngine};

/// Renders scenes on the CPU.
#[derive(Debug)]
pub struct CpuEngine {
    pool: Pool,
    tile_edge: Option<usize>,
    instructions: InstructionSet,
    placed: PlacedVolumes,
    sheets: SheetEngine,
    classic: ClassicEngine,
    splats: SplatEngine,
    /// Clouds of pre-classified items.
    items: ItemStore,
    /// Clouds of post-classified meshes.
    meshes: MeshStore,
    /// The X-ray of one thing of several.
    part: Option<Frame>,
}

impl CpuEngine {
    /// Starts the engine with its own threads. [`EngineConfig::simd`] is the caller's to heed.
    ///
    /// # Errors
    /// The system refuses the threads, or the tile edge is outside its domain.
    pub fn new(config: EngineConfig, instructions: InstructionSet) -> Result<Self, EngineError> {
        Self::with_pool(Pool::new(config.threads)?, config, instructions)
    }

    /// Starts the engine on a caller-provided thread pool, which engines may share.
    ///
    /// # Errors
    /// The configured number of threads differs from the pool's, or the tile edge is outside its domain.
    pub fn with_pool(
        pool: impl Into<Pool>,
        config: EngineConfig,
        instructions: InstructionSet,
    ) -> Result<Self, EngineError> {
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
        Ok(Self {
            pool,
            tile_edge: config.tile_edge,
            instructions,
            placed: PlacedVolumes::default(),
            sheets: SheetEngine::with_spare(config.spare_bytes.unwrap_or(SPARE)),
            classic: ClassicEngine::default(),
            splats: SplatEngine::default(),
            items: ItemStore::default(),
            meshes: MeshStore::default(),
            part: None,
        })
    }

    /// Renders a scene in layers.
    fn render_layers(
        &mut self,
        run: Run<'_>,
        parts: &Parts<'_>,
        (shot, own): (Shot<'_>, &RenderSettings<SheetSettings>),
        frame: &mut Frame,
    ) -> Result<RenderStatistics, SceneError> {
        let view = (shot.camera, own);
        let start = Instant::now();
        let cloud = match parts.rest.items.is_empty() {
            true => None,
            false => Some(
                self.items
                    .cloud(run, &parts.rest, (shot.camera, shot.settings))
                    .ok_or(SceneError::Stopped)?,
            ),
        };
        self.meshes
            .update(run, &parts.meshes, own)
            .ok_or(SceneError::Stopped)?;
        let scene = LayeredScene {
            volumes: &parts.volumes,
            meshes: &parts.meshes,
            mesh_clouds: &self.meshes,
            cloud,
            clips: &shot.scene.clips,
        };
        self.sheets.render_layers(run, &scene, view, (frame, start))
    }

    /// Renders X-rays of several things, each by itself, and adds them up.
    fn render_integrals(
        &mut self,
        run: Run<'_>,
        parts: &Parts<'_>,
        (shot, own): (Shot<'_>, &RenderSettings<SheetSettings>),
        frame: &mut Frame,
    ) -> Result<RenderStatistics, SceneError> {
        let Parts { volumes, rest, .. } = parts;
        let count = volumes.len() + usize::from(!rest.items.is_empty());
        let mut statistics = RenderStatistics::default();
        let mut part = self.part.take();
        for at in 0..count {
            let share = |done: f64| (run.task.progress)((at as f64 + done) / count as f64);
            let task = Task {
                progress: &share,
                ..run.task
            };
            let run = Run { task, ..run };
            let target = match at {
                0 => &mut *frame,
                _ => match part.take().filter(|part| part.image.size() == frame.image.size()) {
                    Some(kept) => part.insert(kept),
                    None => part.insert(frame.clone()),
                },
            };
            let found = match volumes.get(at) {
                Some(volume) => {
                    let own = volume.settings(own);
                    self.sheets.render(run, volume, (shot.camera, &own), target)?
                }
                None => self.render_splats(run, &SplatScene::of_depths(rest), shot, target)?,
            };
            task.go_on()?;
            if let Some(part) = part.as_ref().filter(|_| at > 0) {
                run.pool.install(|| integrals::add(frame, part));
            }
            let all = statistics.chunks.all + found.chunks.all;
            statistics = statistics.plus(&found);
            statistics.chunks.all = all;
        }
        self.part = part;
        Ok(RenderStatistics {
            engine: "sheets",
            ..statistics
        })
    }

    /// Renders splats one by one.
    fn render_splats(
        &mut self,
        run: Run<'_>,
        drawn: &SplatScene<'_>,
        shot: Shot<'_>,
        frame: &mut Frame,
    ) -> Result<RenderStatistics, SceneError> {
        let start = Instant::now();
        let mut clouds = drawn.gaussians.clone();
        let mut spacing = 0.0;
        if !drawn.rest.items.is_empty() {
            let view = (shot.camera, shot.settings);
            let cloud = self
                .items
                .cloud(run, &drawn.rest, view)
                .ok_or(SceneError::Stopped)?;
            spacing = cloud.spacing;
            clouds.push(Cloud::Kernels(cloud));
        }
        let classify = start.elapsed().as_secs_f64();
        let settings = drawn.settings(shot.scene, shot.settings, spacing);
        let mut seconds = self.splats.render(run, &clouds, (shot.camera, &settings), frame);
        seconds.classify = classify;
        seconds.total = start.elapsed().as_secs_f64();
        Ok(RenderStatistics {
            seconds,
            threads: run.pool.current_num_threads(),
            engine: "splats",
            simd: self.instructions.name(),
            voxels: clouds.iter().map(|cloud| cloud.len() as u64).sum(),
            ..RenderStatistics::default()
        })
    }
}

impl Engine for CpuEngine {
    fn check(&self, shot: Shot<'_>) -> Result<(), SceneError> {
        check(shot)
    }

    fn render(
        &mut self,
        shot: Shot<'_>,
        frame: &mut Frame,
        task: Task<'_>,
    ) -> Result<RenderStatistics, SceneError> {
        let Shot {
            scene,
            camera,
            settings,
        } = shot;
        let route = Route::of(scene, settings, &mut self.placed)?;
        self.sheets.beside = match &route {
            Route::Integrals(parts, _) => parts.distinct_volumes(),
            _ => Vec::new(),
        };
        let pool = self.pool.clone();
        let run = Run {
            pool: &pool,
            instructions: self.instructions,
            tile_edge: self.tile_edge,
            task,
            block: None,
            pass: Pass::WHOLE,
        };
        if !matches!(route, Route::Classic(..)) {
            task.refuse_partial()?;
        }
        let statistics = match &route {
            Route::Volume(volume, own) => self.sheets.render(run, volume, (camera, own), frame)?,
            Route::Classic(volume, own) => self.classic.render(run, volume, (camera, own), frame)?,
            Route::Layers(parts, own) => self.render_layers(run, parts, (shot, own), frame)?,
            Route::Integrals(parts, own) => self.render_integrals(run, parts, (shot, own), frame)?,
            Route::Splats(splats) => self.render_splats(run, splats, shot, frame)?,
        };
        task.go_on()?;
        Ok(statistics)
    }

    fn memory(&self) -> MemoryUse {
        let [volumes, spare_volumes, tiles] = self.sheets.bytes();
        let [samples, cloud] = self.classic.bytes();
        MemoryUse {
            volumes: volumes + samples,
            spare_volumes,
            clouds: self.items.bytes() + self.meshes.bytes() + cloud,
            tiles: tiles + self.splats.bytes(),
            device: 0,
        }
    }
}
