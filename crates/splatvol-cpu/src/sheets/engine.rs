//! Sheet engine: renders frames from cached state. A new camera costs only a frame, a new transfer function only
//! the parts that it changes, a new volume everything.

use std::sync::Arc;

use splatvol_core::chunk_memory::{ChunkMemory, PictureNeeds};
use splatvol_core::clock::Instant;
use splatvol_core::engine::{RenderStatistics, Task};
use splatvol_core::field::FieldStore;
use splatvol_core::plan::{Bricks, GridView, Ramp, Sampling};
use splatvol_scene::{Camera, Frame, Gradient, RenderSettings, SceneError, SheetSettings, Shows, Volume};

use super::analytic::{Analytic, Sums};
use super::blocks::{self, picture_bytes};
use super::classified::ClassifiedBricks;
use super::cloud::plan::CloudPlan;
use super::compose::Compose;
use super::cut::{Cut, world_from_lattice};
use super::exact_intensity::ExactIntensity;
use super::frame::{GridPlan, ZonedFrame};
use super::frame::{analytic_field, shader};
use super::integral::Integral;
use super::intensity::{Extreme, Intensity, Mean, Reduction, ValueColors};
use super::operated::Operated;
use super::picture::{Picture, Values};
use super::scene::LayerStore;
use super::shade::PlaneShader;
use super::shaded::Shaded;
use super::tiles::{Both, Single, TILE_EDGE, TileMemory};
use crate::phong::Phong;
use crate::route::VolumeScene;
use crate::run::Run;
use crate::sheets::extremum::{Largest, Smallest};
use splatvol_core::level::{Level, Wanted};
use splatvol_core::prepared::PreparedVolumes;

/// State between frames.
#[derive(Debug, Default)]
pub(crate) struct SheetEngine {
    pub(super) prepared: PreparedVolumes,
    /// Volumes that are drawn one after the other for one picture: none of them is given up for another.
    pub(crate) beside: Vec<Arc<Volume>>,
    /// Of the level that is drawn, and of the next where both are.
    plans: [GridPlan; 2],
    pub(super) cloud: CloudPlan,
    pub(super) layers: LayerStore,
    pub(super) memory: TileMemory,
    /// The coarser level's frame, where two are blended.
    pub(super) coarser: Option<Frame>,
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

    /// Renders levels of the volume, from one on: one, or two that lie side by side.
    ///
    /// # Errors
    /// A cancelled picture, or samples that cannot be read.
    pub(super) fn levels<const N: usize>(
        &mut self,
        run: Run<'_>,
        scene: &VolumeScene<'_>,
        (camera, settings): (&Camera, &RenderSettings<SheetSettings>),
        (first, views, fade): (usize, Option<[&GridView; N]>, Option<Ramp>),
        (frame, statistics): (&mut Frame, &mut RenderStatistics),
    ) -> Result<(), SceneError> {
        let prepared = Instant::now();
        let edge = run.tile_edge.unwrap_or(TILE_EDGE);
        let Self {
            prepared: kept,
            beside,
            plans,
            memory,
            ..
        } = self;
        let volumes = std::iter::once(&scene.volume).chain(others(beside, &scene.volume));
        let [pyramid, ..] = kept.of_scene(volumes, settings) else {
            return Ok(());
        };
        let wanted = Wanted::of(settings);
        let threads = run.pool.current_num_threads();
        let needs = PictureNeeds {
            bytes: picture_bytes(&run.task.held(settings.size), threads, edge),
            threads,
            volumes: beside.len().max(1),
            levels: N,
        };
        let of_chunks = ChunkMemory::of_picture((&scene.volume, first..first + N), pyramid, needs, wanted)?;
        let look = scene.look();
        let mut levels: [_; N] = pyramid.classify_all(first, look, wanted, run.task.stop)?;
        let sampling = sampling(settings);
        let own;
        let views = match views {
            Some(views) => views,
            None => {
                own = levels.each_ref().map(|level| {
                    let grid = level.field.source().grid();
                    GridView::new(grid, (camera, settings), sampling, None)
                });
                own.each_ref()
            }
        };
        for level in &levels {
            level.count_work(statistics);
            let bricks = level.field.dims().map(|n| n.div_ceil(8));
            statistics.bricks += bricks.iter().product::<usize>();
        }
        let edge = match sampling {
            Sampling::Rays => views[0].ray_tile_edge(TILE_EDGE),
            _ => edge,
        };
        let blocks = match &of_chunks {
            Some(memory) => {
                let own = levels.each_ref().map(|level| (memory, &**level));
                blocks::of_picture(&own, settings.size, &run, edge)?
            }
            None => blocks::of_picture(&[], settings.size, &run, edge)?,
        };
        statistics.seconds.classify += prepared.elapsed().as_secs_f64();
        for (at, &block) in blocks.iter().enumerate() {
            let planned = Instant::now();
            for (level, view) in levels.iter_mut().zip(views) {
                blocks::restrict(level, view, block);
            }
            statistics.seconds.bin += planned.elapsed().as_secs_f64();
            let share = |done: f64| (run.task.progress)((at as f64 + done) / blocks.len() as f64);
            let task = Task {
                progress: &share,
                ..run.task
            };
            let job = Job {
                run: Run { task, block, ..run },
                view: views[0],
                settings,
                plans,
                memory,
            };
            let shared = levels.each_ref().map(|level| &**level);
            match (&shared[..], &views[..], fade) {
                ([near, next], [_, beside], Some(ramp)) => {
                    let both = [(*near, views[0]), (*next, *beside)];
                    job.draw_both(scene, both, (camera, ramp), (frame, statistics));
                }
                _ => draw(job, (scene, shared[0]), (camera, sampling), (frame, statistics)),
            }
            if let Some(error) = levels.iter().find_map(|level| level.field.failure()) {
                pyramid.forget_failed();
                return Err(error);
            }
            run.task.go_on()?;
        }
        if let Some(memory) = &of_chunks {
            memory.count(&levels.each_ref().map(|level| &**level), statistics);
        }
        Ok(())
    }
}

/// Those volumes that are not this one.
fn others<'v>(volumes: &'v [Arc<Volume>], own: &'v Arc<Volume>) -> impl Iterator<Item = &'v Arc<Volume>> {
    volumes.iter().filter(|other| !Arc::ptr_eq(other, own))
}

/// Draws the tiles of a block, or of the whole picture.
fn draw(
    job: Job<'_>,
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
            let edge = view.ray_tile_edge(TILE_EDGE);
            let (plan, shown) = job.planned((&bricks, Some(edge)), statistics);
            shown.render(&Picture::Integral(Single::new(&plan, &mode)), frame, statistics);
        }
        (Wanted::Classified, _) => {
            let mode = composed((scene, bricks), view, settings);
            let (plan, shown) = job.planned((&mode.bricks, None), statistics);
            shown.render(&Picture::Composed(Single::new(&plan, &mode)), frame, statistics);
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
            let (plan, shown) = job.planned((store, None), statistics);
            shown.render(&Picture::Analytic(Single::new(&plan, &mode)), frame, statistics);
        }
        (Wanted::Visible, _) => {
            let mode = shaded((scene, level), view, (camera, settings));
            let (plan, shown) = job.planned((store, None), statistics);
            shown.render(&Picture::Shaded(Single::new(&plan, &mode)), frame, statistics);
        }
    }
}

/// Post-classification of a level.
fn shaded<'a>(
    (scene, level): (&'a VolumeScene<'_>, &'a Level),
    view: &GridView,
    (camera, settings): (&Camera, &RenderSettings<SheetSettings>),
) -> Shaded<'a> {
    let spacing = scene.volume.finest_grid().mean_spacing();
    let range = level.field.source().value_range();
    Shaded {
        store: &level.field,
        shader: shader(view, (&level.field, &level.table), (settings, spacing)),
        operated: Operated::new(&scene.effects, spacing, (camera, range)),
    }
}

/// Pre-classification of a level's bricks.
fn composed<'a>(
    (scene, bricks): (&VolumeScene<'_>, ClassifiedBricks<'a>),
    view: &GridView,
    settings: &RenderSettings<SheetSettings>,
) -> Compose<'a> {
    let spacing = scene.volume.finest_grid().mean_spacing();
    let phong = settings.lighting.as_ref().map(|l| Phong::new(l, spacing));
    Compose {
        bricks: bricks.lit(phong, view.camera_from_voxel(), scene.labels),
    }
}

/// What voxels are splatted on.
pub(super) fn sampling(settings: &RenderSettings<SheetSettings>) -> Sampling {
    match (Wanted::of(settings), settings.method.shows) {
        (Wanted::Classified, Shows::Xray) => Sampling::Rays,
        (Wanted::Classified, _) => Sampling::Planes,
        _ => Sampling::Field,
    }
}

/// The tiles of one level's picture.
struct Job<'a> {
    run: Run<'a>,
    view: &'a GridView,
    settings: &'a RenderSettings<SheetSettings>,
    plans: &'a mut [GridPlan; 2],
    memory: &'a mut TileMemory,
}

impl<'a> Job<'a> {
    /// Renders one value of each ray.
    fn values<K: Reduction>(
        self,
        (store, shader): (&FieldStore, PlaneShader<'_>),
        colors: ValueColors<'_>,
        (frame, statistics): (&mut Frame, &mut RenderStatistics),
    ) {
        let (view, gradient) = (self.view, self.settings.method.gradient);
        let (plan, shown) = self.planned((store, None), statistics);
        match gradient {
            Gradient::Analytic => {
                let field = analytic_field(view, store, (shader, Sums::Slopes));
                let mode = ExactIntensity::<K>::new(field, colors);
                let values = Values::WithSlopes(Single::new(&plan, &mode));
                shown.render(&K::picture(values), frame, statistics);
            }
            Gradient::Differences => {
                let mode = Intensity::<K>::new(store, shader, colors);
                let values = Values::OnPlanes(Single::new(&plan, &mode));
                shown.render(&K::picture(values), frame, statistics);
            }
        }
    }

    /// Draws two levels side by side, the first of which fades into the second.
    fn draw_both(
        self,
        scene: &VolumeScene<'_>,
        both: [(&Level, &GridView); 2],
        (camera, fade): (&Camera, Ramp),
        (frame, statistics): (&mut Frame, &mut RenderStatistics),
    ) {
        let settings = self.settings;
        let views = both.map(|(_, view)| view);
        match Wanted::of(settings) {
            Wanted::Classified => {
                let modes =
                    both.map(|(level, view)| composed((scene, ClassifiedBricks::new(level)), view, settings));
                let bricks = modes.each_ref().map(|mode| &mode.bricks as &dyn Bricks);
                let (plans, shown) = self.both_planned((views, bricks), statistics);
                let both = Both::new(&plans, &modes, fade);
                shown.render(&Picture::ComposedLevels(both), frame, statistics);
            }
            _ => {
                let modes = both.map(|(level, view)| shaded((scene, level), view, (camera, settings)));
                let bricks = both.map(|(level, _)| &level.field as &dyn Bricks);
                let (plans, shown) = self.both_planned((views, bricks), statistics);
                let both = Both::new(&plans, &modes, fade);
                shown.render(&Picture::ShadedLevels(both), frame, statistics);
            }
        }
    }

    /// Plans the frame; with another edge of tiles than the usual one, if any.
    fn planned(
        self,
        (bricks, tile_edge): (&dyn Bricks, Option<usize>),
        statistics: &mut RenderStatistics,
    ) -> (ZonedFrame<'a>, Shown<'a>) {
        let start = Instant::now();
        let edge = tile_edge.or(self.run.tile_edge).unwrap_or(TILE_EDGE);
        let plan = self.plans[0].update(self.view, bricks, self.settings, edge);
        statistics.seconds.bin += start.elapsed().as_secs_f64();
        let shown = Shown {
            run: self.run,
            memory: self.memory,
            sheets_per_voxel: self.view.sheets_per_voxel(),
        };
        (plan, shown)
    }

    /// Plans the frames of two levels.
    fn both_planned(
        self,
        ([near, next], bricks): ([&GridView; 2], [&dyn Bricks; 2]),
        statistics: &mut RenderStatistics,
    ) -> ([ZonedFrame<'a>; 2], Shown<'a>) {
        let start = Instant::now();
        let edge = self.run.tile_edge.unwrap_or(TILE_EDGE);
        let [first, second] = self.plans;
        let plans = [
            first.update(near, bricks[0], self.settings, edge),
            second.update(next, bricks[1], self.settings, edge),
        ];
        statistics.seconds.bin += start.elapsed().as_secs_f64();
        let shown = Shown {
            run: self.run,
            memory: self.memory,
            sheets_per_voxel: near.sheets_per_voxel(),
        };
        (plans, shown)
    }
}

/// The tiles of a frame that is planned.
struct Shown<'a> {
    run: Run<'a>,
    memory: &'a mut TileMemory,
    sheets_per_voxel: u64,
}

impl Shown<'_> {
    fn render(self, picture: &Picture<'_>, frame: &mut Frame, statistics: &mut RenderStatistics) {
        let Self {
            run,
            memory,
            sheets_per_voxel,
        } = self;
        memory.render(run, picture, sheets_per_voxel, frame, statistics);
    }
}
