//! Frames from state that is kept between them: a new camera costs a frame, a new transfer function what it
//! changes, a new volume everything.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use fearless_simd::{Level, dispatch};
use glam::Affine3A;
use rayon::prelude::*;
use splatvol_core::bin::TileRect;
use splatvol_core::field::FieldStore;
use splatvol_scene::{Camera, Compositing, Frame, RenderSettings, Scene};

use super::classified::ClassifiedBricks;
use super::compose::Compose;
use super::cut::{Cut, world_from_lattice};
use super::frame::{Plan, Sampling, View};
use super::integral::Integral;
use super::intensity::{Extreme, Intensity, Mean};
use super::level::{Detail, Pyramid, Wanted};
use super::mode::{Bricks, Mode};
use super::operated::Operated;
use super::pixel::Units;
use super::resolve::{blend, resolve};
use super::shade::Canvas;
use super::shaded::Shaded;
use super::tile::{SheetFrame, SheetScratch, SheetWork, render};
use crate::clock::Instant;
use crate::coverage::Edges;
use crate::phong::Phong;
use crate::pool::Pool;
use crate::sheets::extremum::{Largest, Smallest};
use crate::statistics::{RenderStatistics, StageSeconds};

/// Largest edge of a tile, and what it is unless asked otherwise, pixels: few voxels lie in two tiles.
pub(crate) const TILE_EDGE: usize = 128;

/// A tile's pixels and what they took.
pub(crate) type Tile = Mutex<(Canvas, SheetWork)>;

/// State between frames.
#[derive(Debug, Default)]
pub(crate) struct SheetEngine {
    pyramid: Option<Pyramid>,
    plan: Plan,
    /// One per thread.
    scratch: Vec<Mutex<SheetScratch>>,
    tiles: Vec<Tile>,
    /// The coarser level's frame, where two are blended.
    coarser: Option<Frame>,
}

/// What a frame is rendered with.
#[derive(Clone, Copy)]
pub(crate) struct Run<'a> {
    pub pool: &'a Pool,
    pub level: Level,
    pub tile_edge: Option<usize>,
    pub progress: &'a (dyn Fn(f64) + Sync),
    /// Tiles without any of these are left out.
    pub only: Option<&'a Edges>,
}

impl Run<'_> {
    /// Whether a tile's pixels are wanted.
    pub(crate) fn wants(&self, rect: &TileRect) -> bool {
        self.only.is_none_or(|edges| edges.meets(rect))
    }
}

impl SheetEngine {
    /// Renders into a frame of the settings' size; `None` where footprints of one frame would differ too much in size.
    pub(crate) fn render(
        &mut self,
        run: Run<'_>,
        scene: &Scene,
        (camera, settings): (&Camera, &RenderSettings),
        frame: &mut Frame,
    ) -> Option<RenderStatistics> {
        let start = Instant::now();
        // The mean of two classified values is not the mean classified: labels would become others.
        let detail = if Wanted::of(settings) == Wanted::Classified {
            Detail::FINEST
        } else {
            Detail::new(&scene.volume, camera, settings.size)
        };
        let mut statistics = RenderStatistics {
            threads: run.pool.current_num_threads(),
            simd: crate::level_name(run.level),
            level: detail.level,
            ..RenderStatistics::default()
        };
        run.pool.install(|| {
            self.level(
                run,
                scene,
                (camera, settings),
                detail.level,
                frame,
                &mut statistics,
            )?;
            if detail.coarser > 0.0 {
                let mut coarser = self.coarser.take().unwrap_or_else(|| frame.clone());
                if coarser.image.size() != frame.image.size() {
                    coarser = frame.clone();
                }
                let rendered = self.level(
                    run,
                    scene,
                    (camera, settings),
                    detail.level + 1,
                    &mut coarser,
                    &mut statistics,
                );
                if rendered.is_some() {
                    blend(frame, &coarser, detail.coarser);
                }
                self.coarser = Some(coarser);
            }
            Some(())
        })?;
        statistics.seconds.total = start.elapsed().as_secs_f64();
        Some(statistics)
    }

    /// Renders one level of the volume.
    fn level(
        &mut self,
        run: Run<'_>,
        scene: &Scene,
        (camera, settings): (&Camera, &RenderSettings),
        level: usize,
        frame: &mut Frame,
        statistics: &mut RenderStatistics,
    ) -> Option<()> {
        let prepared = Instant::now();
        if !self
            .pyramid
            .as_ref()
            .is_some_and(|p| p.is_of(&scene.volume, settings.kernel))
        {
            // Freed before the new one is made.
            self.pyramid = None;
        }
        let pyramid = self
            .pyramid
            .get_or_insert_with(|| Pyramid::new(scene.volume.clone(), settings.kernel));
        let wanted = Wanted::of(settings);
        pyramid.classify(level, (&scene.transfer_function, scene.unit_distance()), wanted);
        let level = pyramid.level(level)?;
        let sampling = match (wanted, settings.compositing) {
            (Wanted::Classified, Compositing::Xray) => Sampling::Rays,
            (Wanted::Classified, _) => Sampling::Planes,
            _ => Sampling::Field,
        };
        let grid = level.field.volume().grid();
        let view = View::new(grid, camera, settings, sampling)?;
        let planned = Instant::now();
        statistics.seconds.classify += (planned - prepared).as_secs_f64();
        let mut job = Job {
            run,
            view: &view,
            settings,
            plan: &mut self.plan,
            scratch: &mut self.scratch,
            tiles: &mut self.tiles,
        };
        let store: &FieldStore = &level.field;
        let spacing = scene.volume.grid().mean_spacing();
        statistics.bricks += store.dims().iter().map(|n| n.div_ceil(8)).product::<usize>();
        let look = (&level.classification, level.hull);
        let cut = || {
            Cut::new(
                &scene.clips,
                world_from_lattice(grid.world_from_voxel(), view.margin()),
            )
        };
        let voxel_cut = if wanted == Wanted::Classified {
            cut()
        } else {
            Cut::default()
        };
        let bricks = ClassifiedBricks::new((store, &level.visible), look).cut(&voxel_cut);
        let classified = (&level.classification, scene.unit_distance());
        let shader = || view.shader((store, &level.table), (settings, spacing));
        match (wanted, sampling) {
            (Wanted::Classified, Sampling::Rays) => {
                let (shapes, raster) = view.along_rays();
                let mode = Integral {
                    bricks: bricks.clone(),
                    shapes,
                    raster,
                };
                // Footprints are those of the tile's middle: tiles have one size, so that it changes no picture.
                job.run.tile_edge = None;
                job.render(&bricks, &mode, frame, statistics);
            }
            (Wanted::Classified, _) => {
                let phong = settings.lighting.as_ref().map(|l| Phong::new(l, spacing));
                let bricks = bricks.lit(phong, view.camera_from_voxel());
                let mode = Compose {
                    bricks: bricks.clone(),
                };
                job.render(&bricks, &mode, frame, statistics);
            }
            (Wanted::Largest, _) => {
                let mode = Intensity::<Extreme<Largest>>::new(store, shader(), classified);
                job.render(store, &mode, frame, statistics);
            }
            (Wanted::Smallest, _) => {
                let mode = Intensity::<Extreme<Smallest>>::new(store, shader(), classified);
                job.render(store, &mode, frame, statistics);
            }
            (Wanted::All, _) => {
                let mode = Intensity::<Mean>::new(store, shader(), classified);
                job.render(store, &mode, frame, statistics);
            }
            (Wanted::Visible, _) => {
                let mode = Shaded {
                    store,
                    shader: shader(),
                    operated: operated(scene, camera, store),
                };
                job.render(store, &mode, frame, statistics);
            }
        }
        Some(())
    }
}

/// What a scene asks to be done to pixels.
fn operated<'a>(scene: &'a Scene, camera: &Camera, store: &FieldStore) -> Option<Operated<'a>> {
    let [low, high] = store.volume().value_range();
    let world_from_camera = camera.camera_from_world().inverse();
    let range = if high > low { high - low } else { 1.0 };
    let units = Units {
        world_from_camera: Affine3A::from_mat3_translation(
            world_from_camera.matrix3.as_mat3(),
            world_from_camera.translation.as_vec3(),
        ),
        lowest: low as f32,
        range: range as f32,
    };
    Operated::new(scene, Cut::new(&scene.clips, world_from_camera), units)
}

/// The tiles of one level's picture.
struct Job<'a> {
    run: Run<'a>,
    view: &'a View,
    settings: &'a RenderSettings,
    plan: &'a mut Plan,
    scratch: &'a mut Vec<Mutex<SheetScratch>>,
    tiles: &'a mut Vec<Tile>,
}

impl Job<'_> {
    fn render<M: Mode<N>, const N: usize>(
        &mut self,
        bricks: &dyn Bricks,
        mode: &M,
        frame: &mut Frame,
        statistics: &mut RenderStatistics,
    ) {
        let start = Instant::now();
        let edge = self.run.tile_edge.unwrap_or(TILE_EDGE);
        let plan = self.plan.update(self.view, bricks, self.settings, edge);
        let tiled = Instant::now();
        let count = plan.tiles.len();
        self.scratch
            .resize_with(self.run.pool.current_num_threads(), Mutex::default);
        if self.tiles.len() < count {
            self.tiles.resize_with(count, Mutex::default);
        }
        let tiles = &self.tiles[..count];
        render_tiles(self.run, (&plan, mode), self.scratch, tiles);
        resolve(&plan.tiles, tiles, frame);
        let seconds = &mut statistics.seconds;
        seconds.bin += (tiled - start).as_secs_f64();
        seconds.tiles += tiled.elapsed().as_secs_f64();
        statistics.active_bricks += bricks.len();
        statistics.sheets += self.view.sheets();
        statistics.tiles += count;
        for tile in tiles {
            let (_, work) = &*lock(tile);
            count_work(work, self.view.sheets_per_voxel(), statistics);
        }
    }
}

fn count_work(work: &SheetWork, sheets_per_voxel: u64, statistics: &mut RenderStatistics) {
    let seconds: &mut StageSeconds = &mut statistics.seconds;
    seconds.activate += work.activate.as_secs_f64();
    seconds.splat += work.splat.as_secs_f64();
    seconds.take += work.take.as_secs_f64();
    seconds.shade += work.shade.as_secs_f64();
    statistics.voxels += work.voxels;
    statistics.slices += work.voxels * sheets_per_voxel;
}

/// A lock whose holder cannot have left nonsense: what it guards is overwritten.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Renders all tiles; threads take the next one as they come free.
fn render_tiles<M: Mode<N>, const N: usize>(
    run: Run<'_>,
    plan: (&SheetFrame<'_>, &M),
    scratch: &[Mutex<SheetScratch>],
    tiles: &[Tile],
) {
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    scratch.par_iter().with_max_len(1).for_each(|scratch| {
        let scratch = &mut *lock(scratch);
        loop {
            let order = plan.0.lists.longest_first();
            let Some(&index) = order.get(next.fetch_add(1, Ordering::Relaxed)) else {
                break;
            };
            let index = index as usize;
            let (canvas, work) = &mut *lock(&tiles[index]);
            let rect = plan.0.tiles.rect(index);
            if run.wants(&rect) {
                *work = dispatch!(run.level, simd => render(simd, plan, index, canvas, scratch));
            } else {
                canvas.reset([rect.x1 - rect.x0, rect.y1 - rect.y0]);
                *work = SheetWork::default();
            }
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            (run.progress)(done as f64 / tiles.len() as f64);
        }
    });
}
