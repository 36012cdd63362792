//! Post-classified frames from state that is kept between them: a new camera costs a frame, a new transfer function what it
//! changes, a new volume everything.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use fearless_simd::{Level, dispatch};
use rayon::prelude::*;
use splatvol_core::classification::ClassificationTable;
use splatvol_core::coefficients::{Coefficients, Use};
use splatvol_core::kernel::GaussianKernel;
use splatvol_core::visibility::{BrickStore, VisibleLevels, background};
use splatvol_scene::{Frame, Kernel, RenderSettings, Scene, TransferFunction, Volume};

use super::frame::{Plan, View};
use super::shade::{Canvas, ShadeTable};
use super::tile::{DataFrame, DataScratch, DataWork, render};
use crate::statistics::{RenderStatistics, StageSeconds};

/// Largest edge of a tile, pixels, and the default: few voxels lie in two tiles.
const TILE_EDGE: usize = 128;

/// A volume's coefficients for a kernel.
#[derive(Debug)]
struct Prepared {
    volume: Arc<Volume>,
    kernel: Kernel,
    prefilter: bool,
    coefficients: Coefficients,
}

/// What a transfer function makes of them.
#[derive(Debug)]
struct Classified {
    transfer_function: TransferFunction,
    unit_distance: f64,
    store: BrickStore,
    table: ShadeTable,
}

/// State between frames.
#[derive(Debug, Default)]
pub(crate) struct DataEngine {
    prepared: Option<Prepared>,
    classified: Option<Classified>,
    plan: Plan,
    /// One per thread.
    scratch: Vec<Mutex<DataScratch>>,
    /// One per tile.
    tiles: Vec<Mutex<(Canvas, DataWork)>>,
}

/// What a frame is rendered with.
#[derive(Clone, Copy)]
pub(crate) struct Run<'a> {
    pub pool: &'a rayon::ThreadPool,
    pub level: Level,
    pub tile_edge: Option<usize>,
    pub progress: &'a (dyn Fn(f64) + Sync),
}

impl DataEngine {
    /// Lattice points that continue a volume beyond each face.
    pub(crate) fn margin(volume: &Volume) -> [usize; 3] {
        volume.grid().dims().map(|n| usize::from(n > 1))
    }

    /// Renders into a frame of the settings' size.
    pub(crate) fn render(
        &mut self,
        run: Run<'_>,
        scene: &Scene,
        (view, settings): (&View, &RenderSettings),
        frame: &mut Frame,
    ) -> RenderStatistics {
        let start = Instant::now();
        let mut seconds = StageSeconds::default();
        let (tiles, active) = run.pool.install(|| {
            self.prepare(scene, settings);
            seconds.prefilter = start.elapsed().as_secs_f64();
            self.classify(scene);
            seconds.classify = start.elapsed().as_secs_f64() - seconds.prefilter;
            let planned = Instant::now();
            let edge = run.tile_edge.unwrap_or(TILE_EDGE);
            let Some(Classified { store, table, .. }) = &self.classified else {
                return (0, 0);
            };
            let plan = self
                .plan
                .update(view, scene.volume.grid(), (store, table), settings, edge);
            seconds.bin = planned.elapsed().as_secs_f64();
            let tiled = Instant::now();
            let count = plan.tiles.len();
            self.scratch
                .resize_with(run.pool.current_num_threads(), Mutex::default);
            if self.tiles.len() < count {
                self.tiles.resize_with(count, Mutex::default);
            }
            tiles(run, &plan, &self.scratch, &self.tiles[..count]);
            seconds.tiles = tiled.elapsed().as_secs_f64();
            resolve(&plan, &self.tiles[..count], frame);
            (count, plan.store.first.len())
        });
        let mut statistics = RenderStatistics {
            threads: run.pool.current_num_threads(),
            simd: crate::level_name(run.level).to_owned(),
            bricks: self
                .prepared
                .as_ref()
                .map_or(0, |p| p.coefficients.dims.iter().map(|n| n.div_ceil(8)).product()),
            active_bricks: active,
            sheets: view.sheets(),
            tiles,
            ..RenderStatistics::default()
        };
        for tile in &self.tiles[..tiles] {
            let (_, work) = &*lock(tile);
            seconds.activate += work.activate.as_secs_f64();
            seconds.splat += work.splat.as_secs_f64();
            seconds.take += work.take.as_secs_f64();
            seconds.shade += work.shade.as_secs_f64();
            statistics.voxels += work.voxels;
            statistics.slices += work.voxels * view.sheets_per_voxel();
        }
        seconds.total = start.elapsed().as_secs_f64();
        statistics.seconds = seconds;
        statistics
    }

    fn prepare(&mut self, scene: &Scene, settings: &RenderSettings) {
        let is_right = |p: &Prepared| {
            Arc::ptr_eq(&p.volume, &scene.volume)
                && p.kernel == settings.kernel
                && p.prefilter == settings.prefilter
        };
        if self.prepared.as_ref().is_some_and(is_right) {
            return;
        }
        // Freed before the new ones are made.
        (self.prepared, self.classified) = (None, None);
        let kernel = GaussianKernel::new(settings.kernel);
        let (coefficients, _) =
            Coefficients::new(&scene.volume, Use::Field(settings.prefilter.then_some(&kernel)));
        self.prepared = Some(Prepared {
            volume: Arc::clone(&scene.volume),
            kernel: settings.kernel,
            prefilter: settings.prefilter,
            coefficients,
        });
    }

    fn classify(&mut self, scene: &Scene) {
        let Some(Prepared { coefficients, .. }) = &self.prepared else {
            return;
        };
        let unit_distance = scene.unit_distance();
        let is_right = |c: &Classified| {
            c.transfer_function == scene.transfer_function && c.unit_distance == unit_distance
        };
        if self.classified.as_ref().is_some_and(is_right) {
            return;
        }
        let table = ClassificationTable::new(
            &scene.transfer_function,
            scene.volume.value_range(),
            unit_distance,
        );
        let levels = VisibleLevels::new(&table);
        let background = background(&scene.volume, &levels);
        self.classified = Some(Classified {
            transfer_function: scene.transfer_function.clone(),
            unit_distance,
            store: BrickStore::new(&scene.volume, coefficients, &levels, background),
            table: ShadeTable::new(&table, levels.hull().unwrap_or([f32::INFINITY; 2])),
        });
    }
}

/// A lock whose holder cannot have left nonsense: what it guards is overwritten.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Renders all tiles; threads take the next one as they come free.
fn tiles(
    run: Run<'_>,
    plan: &DataFrame<'_>,
    scratch: &[Mutex<DataScratch>],
    tiles: &[Mutex<(Canvas, DataWork)>],
) {
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    scratch.par_iter().with_max_len(1).for_each(|scratch| {
        let scratch = &mut *lock(scratch);
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(tile) = tiles.get(index) else { break };
            let (canvas, work) = &mut *lock(tile);
            *work = dispatch!(run.level, simd => render(simd, plan, index, canvas, scratch));
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            (run.progress)(done as f64 / tiles.len() as f64);
        }
    });
}

/// Copies the tiles' pixels to the frame.
fn resolve(plan: &DataFrame<'_>, tiles: &[Mutex<(Canvas, DataWork)>], frame: &mut Frame) {
    let grid = &plan.tiles;
    let width = frame.image.size().width() as usize;
    let band = width * grid.edge;
    let bands = frame
        .image
        .pixels
        .par_chunks_mut(band)
        .zip(frame.depth.par_chunks_mut(band));
    let bands = bands
        .zip(frame.optical_depth.par_chunks_mut(band))
        .with_max_len(1);
    bands
        .enumerate()
        .for_each(|(row, ((pixels, depths), optical_depths))| {
            for column in 0..grid.columns {
                let index = row * grid.columns + column;
                let rect = grid.rect(index);
                let (canvas, _) = &*lock(&tiles[index]);
                for y in 0..rect.y1 - rect.y0 {
                    let target = y * width + rect.x0..y * width + rect.x1;
                    let source = y * canvas.pitch..y * canvas.pitch + (rect.x1 - rect.x0);
                    let [r, g, b] = &canvas.color;
                    let colors = r[source.clone()]
                        .iter()
                        .zip(&g[source.clone()])
                        .zip(&b[source.clone()]);
                    let rest = canvas.transmittance[source.clone()]
                        .iter()
                        .zip(&canvas.depth_sum[source]);
                    let targets = pixels[target.clone()].iter_mut().zip(&mut depths[target.clone()]);
                    let targets = targets.zip(&mut optical_depths[target]);
                    for (((pixel, depth), optical_depth), (((r, g), b), (t, sum))) in
                        targets.zip(colors.zip(rest))
                    {
                        let alpha = 1.0 - t;
                        *pixel = [*r, *g, *b, alpha];
                        *depth = if alpha > 0.0 { sum / alpha } else { f32::INFINITY };
                        *optical_depth = if alpha > 0.0 {
                            -t.max(f32::MIN_POSITIVE).ln()
                        } else {
                            0.0
                        };
                    }
                }
            }
        });
}
