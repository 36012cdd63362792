//! Sheet engine: renders frames from cached state. A new camera costs only a frame, a new transfer function only
//! the parts that it changes, a new volume everything.

use std::borrow::Cow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use fearless_simd::{Simd, dispatch};
use rayon::prelude::*;
use splatvol_core::engine::{RenderStatistics, StageSeconds, Task};
use splatvol_core::field::FieldStore;
use splatvol_core::plan::{Bricks, FramePlan, GridView, Sampling};
use splatvol_scene::{Camera, Frame, Gradient, RenderSettings, SceneError, SheetSettings, Shows, Volume};

use super::analytic::{Analytic, Sums};
use super::blocks::{self, Needs, Room};
use super::canvas::Canvas;
use super::classified::ClassifiedBricks;
use super::cloud::plan::CloudPlan;
use super::compose::Compose;
use super::cut::{Cut, world_from_lattice};
use super::exact_intensity::ExactIntensity;
use super::frame::GridPlan;
use super::frame::ZonedFrame;
use super::frame::{analytic_field, shader};
use super::integral::Integral;
use super::intensity::{Extreme, Intensity, Mean, Reduction, ValueColors};
use super::layer::{ModeLayer, TileLayer, render};
use super::mode::Mode;
use super::operated::Operated;
use super::resolve::{Slots, resolve};
use super::scene::LayerStore;
use super::shade::PlaneShader;
use super::shaded::Shaded;
use super::tile::{SheetScratch, SheetWork};
use crate::clock::Instant;
use crate::phong::Phong;
use crate::route::VolumeScene;
use crate::run::Run;
use crate::sheets::extremum::{Largest, Smallest};
use splatvol_core::level::{Detail, Level, Wanted, blend};
use splatvol_core::prepared::PreparedVolumes;

/// Largest and default edge of a tile, pixels: few voxels lie in two tiles.
pub(crate) const TILE_EDGE: usize = 128;

/// A tile's pixels and its work counts.
pub(crate) type Tile = Mutex<(Canvas, SheetWork)>;

/// State between frames.
#[derive(Debug, Default)]
pub(crate) struct SheetEngine {
    pub(super) prepared: PreparedVolumes,
    plan: GridPlan,
    pub(super) cloud: CloudPlan,
    pub(super) layers: LayerStore,
    pub(super) memory: TileMemory,
    /// The coarser level's frame, where two are blended.
    pub(super) coarser: Option<Frame>,
}

/// Memory of the tiles, kept between frames.
#[derive(Debug, Default)]
pub(crate) struct TileMemory {
    /// One per thread, and of these one per layer.
    scratch: Vec<Mutex<Vec<SheetScratch>>>,
    tiles: Vec<Tile>,
}

impl TileMemory {
    /// Memory held, bytes.
    fn bytes(&self) -> usize {
        let scratch = self
            .scratch
            .iter()
            .map(|own| lock(own).iter().map(SheetScratch::bytes).sum::<usize>());
        let tiles = self.tiles.iter().map(|tile| lock(tile).0.bytes());
        scratch.sum::<usize>() + tiles.sum::<usize>()
    }

    /// Renders all tiles of a frame. `sheets_per_voxel`: number of sheets that a voxel is splatted into.
    pub(crate) fn render(
        &mut self,
        run: Run<'_>,
        picture: &impl Tiles,
        sheets_per_voxel: u64,
        frame: &mut Frame,
        statistics: &mut RenderStatistics,
    ) {
        let start = Instant::now();
        let plan = picture.frame().plan;
        let grid = &plan.tiles;
        let slots = Slots::new(run.task.held(grid.picture()), grid);
        self.scratch
            .resize_with(run.pool.current_num_threads(), Mutex::default);
        if self.tiles.len() < slots.len() {
            self.tiles.resize_with(slots.len(), Mutex::default);
        }
        let tiles = &self.tiles[..slots.len()];
        let order = order_of(&run, &slots, plan);
        render_tiles(run, picture, &self.scratch, (tiles, &slots, &order));
        if run.task.is_stopped() {
            return;
        }
        resolve((grid, &slots), tiles, frame, run.block.map(|block| block.rect));
        statistics.seconds.tiles += start.elapsed().as_secs_f64();
        statistics.active_bricks += picture.bricks();
        if run.block.is_none_or(|block| block.is_first) {
            statistics.sheets += plan.sheets();
            statistics.zones += picture.zones();
        }
        statistics.tiles += order.len();
        for &tile in &*order {
            let (_, work) = &*lock(&tiles[slots.of(tile as usize, grid)]);
            count_work(work, sheets_per_voxel, statistics);
        }
    }
}

/// The tiles to render, in this order. Only pictures in blocks or windows allocate.
fn order_of<'a>(run: &Run<'_>, slots: &Slots, plan: &'a FramePlan) -> Cow<'a, [u32]> {
    let grid = &plan.tiles;
    let held = |tile: &u32| slots.holds(*tile as usize, grid);
    match &run.block {
        Some(block) => block.tiles(grid).into_iter().filter(held).collect(),
        None if slots.len() < grid.len() => plan.longest_first.iter().copied().filter(held).collect(),
        None => Cow::Borrowed(&plan.longest_first),
    }
}

impl SheetEngine {
    /// An engine with a memory budget, bytes, for volumes of earlier scenes.
    pub(crate) fn with_spare(spare: usize) -> Self {
        Self {
            prepared: PreparedVolumes::with_spare(spare),
            ..Self::default()
        }
    }

    /// Bytes of the current scene's prepared volumes, of other volumes, and of the tiles.
    pub(crate) fn bytes(&self) -> [usize; 3] {
        let [own, others] = self.prepared.bytes();
        [own, others, self.memory.bytes()]
    }

    /// Renders into a frame of the settings' size.
    ///
    /// # Errors
    /// A cancelled picture, or samples that cannot be read.
    pub(crate) fn render(
        &mut self,
        run: Run<'_>,
        scene: &VolumeScene<'_>,
        (camera, settings): (&Camera, &RenderSettings<SheetSettings>),
        frame: &mut Frame,
    ) -> Result<RenderStatistics, SceneError> {
        let start = Instant::now();
        let detail = detail((&scene.volume, scene.labels), (camera, settings));
        let mut statistics = RenderStatistics {
            threads: run.pool.current_num_threads(),
            engine: "sheets",
            simd: crate::level_name(run.level),
            level: detail.level,
            ..RenderStatistics::default()
        };
        // The coarser level has a quarter of the pixels' voxels to splat.
        let finest_share = if detail.coarser > 0.0 { 0.75 } else { 1.0 };
        let finest = |done: f64| (run.task.progress)(finest_share * done);
        let coarser_share = |done: f64| (run.task.progress)(finest_share + (1.0 - finest_share) * done);
        run.pool.install(|| {
            self.level(
                Run {
                    task: Task {
                        progress: &finest,
                        ..run.task
                    },
                    ..run
                },
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
                self.level(
                    Run {
                        task: run.task.unseen(&coarser_share),
                        ..run
                    },
                    scene,
                    (camera, settings),
                    detail.level + 1,
                    &mut coarser,
                    &mut statistics,
                )?;
                blend(frame, &coarser, detail.coarser);
                run.task.show_all(frame);
                self.coarser = Some(coarser);
            }
            Ok(())
        })?;
        statistics.seconds.total = start.elapsed().as_secs_f64();
        Ok(statistics)
    }

    /// Renders one level of the volume.
    fn level(
        &mut self,
        run: Run<'_>,
        scene: &VolumeScene<'_>,
        (camera, settings): (&Camera, &RenderSettings<SheetSettings>),
        number: usize,
        frame: &mut Frame,
        statistics: &mut RenderStatistics,
    ) -> Result<(), SceneError> {
        let prepared = Instant::now();
        let edge = run.tile_edge.unwrap_or(TILE_EDGE);
        let Self {
            prepared: kept,
            plan,
            memory,
            ..
        } = self;
        let [pyramid, ..] = kept.of_scene(std::iter::once(&scene.volume), settings) else {
            return Ok(());
        };
        let wanted = Wanted::of(settings);
        pyramid.keep_only(number..number + 1);
        let needs = Needs {
            held: run.task.held(settings.size),
            threads: run.pool.current_num_threads(),
            tile_edge: edge,
            volumes: 1,
        };
        let room = Room::of_picture((&scene.volume, pyramid), needs, wanted)?;
        let look = (&*scene.transfer_function, scene.unit_distance());
        let level = pyramid.classify(number, look, wanted, run.task.stop)?;
        level.count_work(statistics);
        let sampling = match (wanted, settings.method.shows) {
            (Wanted::Classified, Shows::Xray) => Sampling::Rays,
            (Wanted::Classified, _) => Sampling::Planes,
            _ => Sampling::Field,
        };
        let grid = level.field.source().grid();
        let view = GridView::new(grid, (camera, settings), sampling, None);
        statistics.bricks += level
            .field
            .dims()
            .iter()
            .map(|n| n.div_ceil(8))
            .product::<usize>();
        let edge = match sampling {
            Sampling::Rays => view.ray_tile_edge(TILE_EDGE),
            _ => edge,
        };
        let own = room.as_ref().map(|room| (room, &*level));
        let blocks = blocks::of_picture(own.as_slice(), settings.size, &run, edge)?;
        statistics.seconds.classify += prepared.elapsed().as_secs_f64();
        for (at, &block) in blocks.iter().enumerate() {
            let planned = Instant::now();
            blocks::restrict(level, &view, block);
            statistics.seconds.bin += planned.elapsed().as_secs_f64();
            let share = |done: f64| (run.task.progress)((at as f64 + done) / blocks.len() as f64);
            let task = Task {
                progress: &share,
                ..run.task
            };
            let job = Job {
                run: Run { task, block, ..run },
                view: &view,
                settings,
                plan,
                memory,
            };
            draw(job, (scene, level), (camera, sampling), (frame, statistics));
            if let Some(error) = level.field.failure() {
                pyramid.forget(number);
                return Err(error);
            }
            run.task.go_on()?;
        }
        if let Some(room) = &room {
            room.count(level, statistics);
        }
        Ok(())
    }
}

/// Draws the tiles of a block, or of the whole picture.
fn draw(
    mut job: Job<'_>,
    (scene, level): (&VolumeScene<'_>, &Level),
    (camera, sampling): (&Camera, Sampling),
    (frame, statistics): (&mut Frame, &mut RenderStatistics),
) {
    let (view, settings) = (job.view, job.settings);
    let wanted = Wanted::of(settings);
    let store: &FieldStore = &level.field;
    let spacing = scene.volume.finest_grid().mean_spacing();
    let cut = || {
        Cut::new(
            &scene.effects.clips,
            world_from_lattice(store.source().grid().world_from_voxel(), view.margin()),
        )
    };
    let voxel_cut = if wanted == Wanted::Classified {
        cut()
    } else {
        Cut::default()
    };
    let bricks = ClassifiedBricks::new(level).cut(&voxel_cut);
    let values = ValueColors::new(&level.classification, scene.unit_distance());
    let shade = || shader(view, (store, &level.table), (settings, spacing));
    match (wanted, sampling) {
        (Wanted::Classified, Sampling::Rays) => {
            let mode = Integral {
                bricks: bricks.clone(),
                shapes: view.ray_shapes(),
                depth_reach: view.depth_reach(),
            };
            job.run.tile_edge = Some(view.ray_tile_edge(TILE_EDGE));
            job.render(&bricks, &mode, frame, statistics);
        }
        (Wanted::Classified, _) => {
            let phong = settings.lighting.as_ref().map(|l| Phong::new(l, spacing));
            let bricks = bricks.lit(phong, view.camera_from_voxel(), scene.labels);
            let mode = Compose {
                bricks: bricks.clone(),
            };
            job.render(&bricks, &mode, frame, statistics);
        }
        (Wanted::Largest, _) => {
            job.values::<Extreme<Largest>>((store, shade()), values, (frame, statistics));
        }
        (Wanted::Smallest, _) => {
            job.values::<Extreme<Smallest>>((store, shade()), values, (frame, statistics));
        }
        (Wanted::All, _) => job.values::<Mean>((store, shade()), values, (frame, statistics)),
        (Wanted::Visible, _) if settings.method.gradient == Gradient::Analytic => {
            let mode = Analytic::new(
                analytic_field(view, store, (shade(), Sums::Moments)),
                &level.classification,
            );
            job.render(store, &mode, frame, statistics);
        }
        (Wanted::Visible, _) => {
            let mode = Shaded {
                store,
                shader: shade(),
                operated: Operated::new(&scene.effects, spacing, (camera, store.source().value_range())),
            };
            job.render(store, &mode, frame, statistics);
        }
    }
}

/// Level of detail of a volume. Labels are lit by their own shapes, and analytic gradients show the field as it is: both
/// have none.
pub(super) fn detail(
    (volume, labels): (&Volume, bool),
    (camera, settings): (&Camera, &RenderSettings<SheetSettings>),
) -> Detail {
    let exact = Wanted::of(settings) != Wanted::Classified && settings.method.gradient == Gradient::Analytic;
    if labels || exact {
        Detail::FINEST
    } else {
        Detail::new(volume, camera, (settings.size, settings.method.level_bias))
    }
}

/// The tiles of one level's picture.
struct Job<'a> {
    run: Run<'a>,
    view: &'a GridView,
    settings: &'a RenderSettings<SheetSettings>,
    plan: &'a mut GridPlan,
    memory: &'a mut TileMemory,
}

impl Job<'_> {
    /// Renders one value of each ray.
    fn values<K: Reduction>(
        &mut self,
        (store, shader): (&FieldStore, PlaneShader<'_>),
        colors: ValueColors<'_>,
        (frame, statistics): (&mut Frame, &mut RenderStatistics),
    ) {
        match self.settings.method.gradient {
            Gradient::Analytic => {
                let field = analytic_field(self.view, store, (shader, Sums::Slopes));
                self.render(store, &ExactIntensity::<K>::new(field, colors), frame, statistics);
            }
            Gradient::Differences => {
                let mode = Intensity::<K>::new(store, shader, colors);
                self.render(store, &mode, frame, statistics);
            }
        }
    }

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
        statistics.seconds.bin += start.elapsed().as_secs_f64();
        let sheets_per_voxel = self.view.sheets_per_voxel();
        let picture = Single { frame: &plan, mode };
        self.memory
            .render(self.run, &picture, sheets_per_voxel, frame, statistics);
    }
}

fn count_work(work: &SheetWork, sheets_per_voxel: u64, statistics: &mut RenderStatistics) {
    let seconds: &mut StageSeconds = &mut statistics.seconds;
    seconds.activate += work.activate.as_secs_f64();
    seconds.splat += work.splat.as_secs_f64();
    seconds.take += work.take.as_secs_f64();
    seconds.shade += work.shade.as_secs_f64();
    statistics.opened_bricks += work.bricks;
    statistics.voxels += work.voxels;
    statistics.activated_vectors += work.activated_vectors;
    statistics.splatted_vectors += work.splatted_vectors;
    statistics.shaded_vectors += work.shaded_vectors;
    statistics.shaded_pixels += work.shaded_pixels;
    statistics.slices += work.voxels * sheets_per_voxel;
}

/// Locks a mutex, poisoned or not: its contents are overwritten.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The layers shown in a frame's tiles.
pub(crate) trait Tiles: Sync {
    /// The frame of any of the layers: they share tiles and planes.
    fn frame(&self) -> &ZonedFrame<'_>;

    /// Bricks of all layers.
    fn bricks(&self) -> usize;

    /// Zones of all layers.
    fn zones(&self) -> usize;

    /// Renders a tile, unless the flag is set meanwhile.
    fn render<S: Simd>(
        &self,
        simd: S,
        tile: (usize, &AtomicBool),
        canvas: &mut Canvas,
        scratch: &mut Vec<SheetScratch>,
    ) -> SheetWork;
}

/// One mode's picture of one frame.
#[derive(Debug)]
pub(crate) struct Single<'a, M, const N: usize> {
    pub frame: &'a ZonedFrame<'a>,
    pub mode: &'a M,
}

impl<M: Mode<N>, const N: usize> Tiles for Single<'_, M, N> {
    fn frame(&self) -> &ZonedFrame<'_> {
        self.frame
    }

    fn bricks(&self) -> usize {
        self.frame.plan.corners.len()
    }

    fn zones(&self) -> usize {
        self.frame.plan.zones().len()
    }

    fn render<S: Simd>(
        &self,
        simd: S,
        (tile, stop): (usize, &AtomicBool),
        canvas: &mut Canvas,
        scratch: &mut Vec<SheetScratch>,
    ) -> SheetWork {
        if scratch.is_empty() {
            scratch.push(SheetScratch::default());
        }
        let Some(mut layer) = ModeLayer::new((self.frame, self.mode), tile, &mut scratch[0], canvas) else {
            return SheetWork::default();
        };
        let layers = &mut [&mut layer as &mut dyn TileLayer<S>];
        render(simd, (self.frame.plan.termination, stop), layers, canvas)
    }
}

/// Renders all tiles; each thread takes the next tile when it is free.
fn render_tiles(
    run: Run<'_>,
    picture: &impl Tiles,
    scratch: &[Mutex<Vec<SheetScratch>>],
    (tiles, slots, order): (&[Tile], &Slots, &[u32]),
) {
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let frame = picture.frame().plan;
    scratch.par_iter().with_max_len(1).for_each(|scratch| {
        let scratch = &mut *lock(scratch);
        while let Some(&index) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
            let index = index as usize;
            let (canvas, work) = &mut *lock(&tiles[slots.of(index, &frame.tiles)]);
            let rect = frame.tiles.rect(index);
            if run.task.is_stopped() {
                break;
            }
            canvas.reset([rect.x1 - rect.x0, rect.y1 - rect.y0]);
            *work = if run.task.wants(&rect) {
                let work = dispatch!(run.level, simd => picture.render(simd, (index, run.task.stop), canvas, scratch));
                if !run.task.is_stopped() {
                    run.task.show(&rect, || canvas.colors(rect.x1 - rect.x0));
                }
                work
            } else {
                SheetWork::default()
            };
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            run.task.report(done as f64 / order.len() as f64);
        }
    });
}
