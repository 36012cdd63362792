//! The renderer: keeps what it derives from a volume, plans a frame, runs its tiles.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use fearless_simd::{Level, dispatch};
use rayon::prelude::*;
use splatvol_core::brick::BrickGrid;
use splatvol_core::classification::ClassificationTable;
use splatvol_core::coefficients::{Coefficients, Use};
use splatvol_core::kernel::GaussianKernel;
use splatvol_scene::{Camera, Compositing, Frame, Image, Kernel, RenderSettings, Scene, SceneError, Volume};

use crate::plan::{FramePlan, Geometry, splats_color};
use crate::stage::resolve::{Resolved, store};
use crate::stage::sheet_buffer::MAX_EDGE;
use crate::statistics::{RenderStatistics, StageSeconds};
use crate::tile::{self, ColorMode, DataMode, Mode, Scratch, TileWork};

/// Settings of an engine's lifetime.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct EngineConfig {
    /// Worker threads; `None` takes one per logical processor.
    pub threads: Option<usize>,
    /// Edge of a tile in pixels, a multiple of 16 from 16 to 64; `None` takes 64. Does not change the picture.
    pub tile_edge: Option<usize>,
}

/// Why an engine cannot start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EngineError {
    /// The operating system refused the threads.
    #[error("cannot start {threads:?} worker threads: {reason}")]
    Threads {
        /// Threads asked for.
        threads: Option<usize>,
        /// What the system said.
        reason: String,
    },
    /// A tile edge outside its domain.
    #[error("tile edge: {edge} is not allowed (a multiple of 16 from 16 to 64)")]
    TileEdge {
        /// The offending value, pixels.
        edge: usize,
    },
}

/// What coefficients of a volume are kept.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Content {
    /// The samples.
    Samples,
    /// A field, interpolating by a kernel where there is one.
    Field(Option<Kernel>),
}

/// What a volume became, and for which settings.
#[derive(Debug)]
struct Prepared {
    volume: Arc<Volume>,
    content: Content,
    coefficients: Coefficients,
    bricks: BrickGrid,
}

#[derive(Debug)]
struct DataState {
    volume: Arc<Volume>,
    tf: splatvol_scene::TransferFunction,
    kernel: Kernel,
    coefficients: Coefficients,
    store: splatvol_core::visibility::BrickStore,
    shade: crate::data::shade::ShadeTable,
}

/// Renders scenes; keeps what it derives from a volume between frames.
#[derive(Debug)]
pub struct Renderer {
    pool: rayon::ThreadPool,
    tile_edge: usize,
    level: Level,
    prepared: Option<Prepared>,
    data: Option<DataState>,
    statistics: RenderStatistics,
}

impl Renderer {
    /// Starts the engine.
    ///
    /// # Errors
    /// Threads that the system refuses, or a tile edge outside its domain.
    pub fn new(config: EngineConfig) -> Result<Self, EngineError> {
        let tile_edge = config.tile_edge.unwrap_or(64);
        if !tile_edge.is_multiple_of(16) || !(16..=MAX_EDGE).contains(&tile_edge) {
            return Err(EngineError::TileEdge { edge: tile_edge });
        }
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(config.threads.unwrap_or(0))
            .thread_name(|i| format!("splatvol-{i}"))
            .build()
            .map_err(|error| EngineError::Threads {
                threads: config.threads,
                reason: error.to_string(),
            })?;
        let statistics = RenderStatistics::default();
        Ok(Self {
            pool,
            tile_edge,
            level: Level::new(),
            prepared: None,
            data: None,
            statistics,
        })
    }

    /// Renders one frame.
    ///
    /// # Errors
    /// Settings outside their domain.
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
    /// Settings outside their domain.
    pub fn render_with_progress(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        settings: &RenderSettings,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Frame, SceneError> {
        settings.validate()?;
        let start = Instant::now();
        let mut seconds = StageSeconds::default();
        let content = if splats_color(settings) {
            Content::Samples
        } else {
            Content::Field(settings.prefilter.then_some(settings.kernel))
        };
        if settings.gradient == splatvol_scene::Gradient::Differences
            && settings.compositing == Compositing::ImageSheets
            && settings.classification == splatvol_scene::Classification::Post
            && scene.volume.statistics().non_finite == 0
        {
            let margin = scene.volume.grid().dims().map(|n| usize::from(n > 1));
            if let Some(view) = crate::data::frame::View::new(scene.volume.grid(), margin, camera, settings) {
                return Ok(self.render_data(scene, view, settings, progress));
            }
        }
        let Self { pool, prepared, .. } = self;
        let prepared = pool.install(|| prepare(prepared, &scene.volume, content));
        seconds.prefilter = start.elapsed().as_secs_f64();

        let classified = Instant::now();
        let unit_distance = scene.unit_distance();
        let table = ClassificationTable::new(
            &scene.transfer_function,
            scene.volume.value_range(),
            unit_distance,
        );
        seconds.classify = classified.elapsed().as_secs_f64();

        let binned = Instant::now();
        let geometry = Geometry::new(
            scene.volume.grid(),
            prepared.coefficients.margin,
            camera,
            settings,
        );
        let plan = self.pool.install(|| {
            FramePlan::new(
                &geometry,
                (&prepared.coefficients, &prepared.bricks),
                (&table, unit_distance),
                (camera, settings),
                self.tile_edge,
            )
        });
        seconds.bin = binned.elapsed().as_secs_f64();

        let tiled = Instant::now();
        let run = TileRun {
            plan: &plan,
            level: self.level,
            progress,
            done: AtomicUsize::new(0),
        };
        let tiles = self.pool.install(|| {
            if splats_color(settings) {
                run.all(&ColorMode::new(&plan))
            } else {
                run.all(&DataMode::new(&plan))
            }
        });
        seconds.tiles = tiled.elapsed().as_secs_f64();
        let frame = assemble(&plan, &tiles);

        let total = |pick: fn(&TileWork) -> f64| tiles.iter().map(|(_, work)| pick(work)).sum::<f64>();
        seconds.splat = total(|work| work.splat.as_secs_f64());
        seconds.shade = total(|work| work.shade.as_secs_f64());
        seconds.total = start.elapsed().as_secs_f64();
        self.statistics = RenderStatistics {
            seconds,
            threads: self.pool.current_num_threads(),
            simd: format!("{:?}", self.level),
            bricks: plan.bricks.len(),
            active_bricks: plan.active_bricks,
            sheets: plan.projector.sheets.count,
            tiles: plan.tiles.len(),
            voxels: tiles.iter().map(|(_, work)| work.voxels).sum(),
            slices: tiles.iter().map(|(_, work)| work.slices).sum(),
        };
        Ok(frame)
    }

    fn render_data(
        &mut self,
        scene: &Scene,
        view: crate::data::frame::View,
        settings: &RenderSettings,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Frame {
        let start = Instant::now();
        let mut seconds = StageSeconds::default();
        if self.data.as_ref().is_none_or(|d| {
            !Arc::ptr_eq(&d.volume, &scene.volume)
                || d.tf != scene.transfer_function
                || d.kernel != settings.kernel
        }) {
            let keep = self
                .data
                .take()
                .filter(|d| Arc::ptr_eq(&d.volume, &scene.volume) && d.kernel == settings.kernel);
            let data = self.pool.install(|| {
                let coefficients = match keep {
                    Some(d) => d.coefficients,
                    None => {
                        Coefficients::new(
                            &scene.volume,
                            Use::Field(Some(&GaussianKernel::new(settings.kernel))),
                        )
                        .0
                    }
                };
                seconds.prefilter = start.elapsed().as_secs_f64();
                let table = ClassificationTable::new(
                    &scene.transfer_function,
                    scene.volume.value_range(),
                    scene.unit_distance(),
                );
                let levels = splatvol_core::visibility::VisibleLevels::new(&table);
                let background = splatvol_core::visibility::background(&scene.volume, &levels);
                let store = splatvol_core::visibility::BrickStore::new(
                    &scene.volume,
                    &coefficients,
                    &levels,
                    background,
                );
                let hull = levels.hull().unwrap_or([f32::INFINITY; 2]);
                let shade = crate::data::shade::ShadeTable::new(&table, hull);
                DataState {
                    volume: Arc::clone(&scene.volume),
                    tf: scene.transfer_function.clone(),
                    kernel: settings.kernel,
                    coefficients,
                    store,
                    shade,
                }
            });
            self.data = Some(data);
            seconds.classify = start.elapsed().as_secs_f64() - seconds.prefilter;
        }
        let binned = Instant::now();
        let data = self.data.as_ref().expect("just made");
        let plan = self.pool.install(|| {
            crate::data::frame::plan(
                &view,
                scene.volume.grid(),
                (&data.store, &data.shade),
                (settings, data.coefficients.margin),
                std::env::var("TE").map_or(128, |t| t.parse().unwrap()),
            )
        });
        seconds.bin = binned.elapsed().as_secs_f64();
        let tiled = Instant::now();
        let count = plan.tiles.len();
        let done = AtomicUsize::new(0);
        let level = self.level;
        let size = settings.size;
        let tiles: Vec<_> = self.pool.install(|| {
            (0..count)
                .into_par_iter()
                .with_max_len(1)
                .map_init(crate::data::tile::DataScratch::default, |scratch, index| {
                    let work =
                        dispatch!(level, simd => crate::data::tile::render(simd, &plan, index, scratch));
                    let done = done.fetch_add(1, Ordering::Relaxed) + 1;
                    progress(done as f64 / count as f64);
                    let c = &scratch.canvas;
                    let rect = plan.tiles.rect(index);
                    let mut out = Vec::with_capacity((rect.x1 - rect.x0) * (rect.y1 - rect.y0));
                    for y in 0..rect.y1 - rect.y0 {
                        for x in 0..rect.x1 - rect.x0 {
                            let i = y * c.pitch + x;
                            out.push((
                                [c.color[0][i], c.color[1][i], c.color[2][i]],
                                c.transmittance[i],
                                c.depth_sum[i],
                            ));
                        }
                    }
                    (out, work)
                })
                .collect()
        });
        seconds.tiles = tiled.elapsed().as_secs_f64();
        let mut frame = Frame {
            image: Image::filled(size, [0.0; 4]),
            depth: vec![f32::INFINITY; size.pixel_count()],
            optical_depth: vec![0.0; size.pixel_count()],
        };
        let width = size.width() as usize;
        for (index, (pixels, _)) in tiles.iter().enumerate() {
            let rect = plan.tiles.rect(index);
            for (y, row) in (rect.y0..rect.y1).zip(pixels.chunks(rect.x1 - rect.x0)) {
                for (x, (color, t, d)) in (rect.x0..rect.x1).zip(row) {
                    let alpha = 1.0 - t;
                    frame.image.pixels[y * width + x] = [color[0], color[1], color[2], alpha];
                    frame.depth[y * width + x] = if alpha > 0.0 { d / alpha } else { f32::INFINITY };
                    frame.optical_depth[y * width + x] = -t.max(f32::MIN_POSITIVE).ln();
                }
            }
        }
        seconds.total = start.elapsed().as_secs_f64();
        let sum = |pick: fn(&crate::data::tile::DataWork) -> std::time::Duration| {
            tiles.iter().map(|(_, w)| pick(w).as_secs_f64()).sum::<f64>()
        };
        seconds.splat = sum(|w| w.splat);
        seconds.shade = sum(|w| w.shade);
        if std::env::var("SV").is_ok() {
            eprintln!(
                "prefilter {:.4} classify {:.4} bin {:.4} | activate {:.4} splat {:.4} take {:.4} shade {:.4} | tiles {:.4} total {:.4} | bricks {} needed {} tested {} voxels {} size {} ellipses {} groups {}",
                seconds.prefilter,
                seconds.classify,
                seconds.bin,
                sum(|w| w.activate),
                sum(|w| w.splat),
                sum(|w| w.take),
                sum(|w| w.shade),
                seconds.tiles,
                seconds.total,
                plan.store.first.len(),
                plan.store.needed,
                tiles.iter().map(|t| t.1.tested).sum::<u64>(),
                tiles.iter().map(|t| t.1.voxels).sum::<u64>(),
                plan.step,
                plan.ellipses,
                plan.groups
            );
        }
        frame
    }

    /// Times and counts of the last frame.
    pub fn statistics(&self) -> &RenderStatistics {
        &self.statistics
    }
}

/// Coefficients and bricks of a volume, kept from the last frame where they are still right.
fn prepare<'a>(kept: &'a mut Option<Prepared>, volume: &Arc<Volume>, content: Content) -> &'a Prepared {
    if kept
        .as_ref()
        .is_some_and(|p| !Arc::ptr_eq(&p.volume, volume) || p.content != content)
    {
        *kept = None;
    }
    kept.get_or_insert_with(|| {
        let (coefficients, bricks) = match content {
            Content::Samples => Coefficients::new(volume, Use::Samples),
            Content::Field(kernel) => {
                Coefficients::new(volume, Use::Field(kernel.map(GaussianKernel::new).as_ref()))
            }
        };
        Prepared {
            volume: Arc::clone(volume),
            content,
            coefficients,
            bricks,
        }
    })
}

/// The tiles of one frame.
struct TileRun<'a> {
    plan: &'a FramePlan<'a>,
    level: Level,
    progress: &'a (dyn Fn(f64) + Sync),
    done: AtomicUsize,
}

impl TileRun<'_> {
    fn all<M: Mode>(&self, mode: &M) -> Vec<(Vec<Resolved>, TileWork)> {
        let count = self.plan.tiles.len();
        (0..count)
            .into_par_iter()
            .with_max_len(1)
            .map_init(
                || Scratch::new(self.plan.tiles.edge),
                |scratch, index| {
                    let pixels =
                        dispatch!(self.level, simd => tile::render(simd, self.plan, index, mode, scratch));
                    let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
                    (self.progress)(done as f64 / count as f64);
                    pixels
                },
            )
            .collect()
    }
}

fn assemble(plan: &FramePlan<'_>, tiles: &[(Vec<Resolved>, TileWork)]) -> Frame {
    let size = plan.settings.size;
    let mut frame = Frame {
        image: Image::filled(size, [0.0; 4]),
        depth: vec![f32::INFINITY; size.pixel_count()],
        optical_depth: vec![0.0; size.pixel_count()],
    };
    for (tile, (pixels, _)) in tiles.iter().enumerate() {
        store(&mut frame, &plan.tiles.rect(tile), pixels);
    }
    debug_assert!(
        plan.settings.compositing == Compositing::Mip || frame.image.pixels.iter().all(|p| p[3] <= 1.0),
        "no pixel is more than opaque"
    );
    frame
}
