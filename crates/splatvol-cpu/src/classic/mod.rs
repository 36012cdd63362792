//! The papers' methods: whole footprints of one volume, or sections of them, one kernel at a time.
//!
//! The papers' features are used only on request: non-Gaussian kernels, rasterisers with their tables, alignments,
//! swan's filters, the summed-area table for occlusion, slices of the grid, `1 - tau`, flattened kernels, ranges of
//! interest and motion blur in closed form (swan1997, mueller1998, huang2000, zwicker2001). No default comes here:
//! grids and scenes go to `sheets`, and splats of anything but one volume to `splats`. This is scalar code, one to
//! two orders of magnitude slower than both, and its pictures stay the same to the bit.
//!
//! This engine knows only [`SplatCloud`](splatvol_core::splats::SplatCloud)s and
//! [`Footprint`](splatvol_core::splats::Footprint)s, not their origin. Stages of a picture:
//!
//! | stage | module | what happens |
//! |---|---|---|
//! | extract | `cloud` | the volume's visible voxels become a cloud, kept between frames |
//! | profile | `profiles` | the kernel's line integrals, as a function or as tables, kept between frames |
//! | bin | `plan`, `order` | chunks of the cloud into tile lists, by the *turn* at which they are needed |
//! | open | `turns` | chunks that are not hidden give their splats to the turns |
//! | splat | `raster`, `sheet`, `levels` | footprints, whole or a sheet's section of them, become pixels |
//! | composite | `tile`, `post_classified`, `partial` | sheets, or splats one by one, are composited behind the pixels |
//!
//! A *turn* is a sheet, a slice of the grid, or a range of depths whose splats are sorted, front to back (`order`).
//! Pixels receive their contributions turn by turn, then by depth and index, so pictures are the same for any
//! number of threads and any tile.

mod cloud;
mod levels;
mod occlusion;
mod order;
mod partial;
mod pixel;
mod plan;
mod post_classified;
mod profiles;
mod raster;
mod sheet;
mod tile;
mod turns;

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use splatvol_core::clock::Instant;
use splatvol_core::engine::{RenderStatistics, StageSeconds};
use splatvol_core::splats::Profile;
use splatvol_scene::{Camera, Frame, RenderSettings, SceneError, SplatSettings};

use self::cloud::CloudStore;
use self::pixel::{Resolved, store};
use self::plan::{Drawn, Plan};
use self::profiles::{FootprintProfile, ProfileStore};
use self::tile::{TileScratch, TileWork};
use crate::route::VolumeScene;
use crate::run::Run;

/// Keeps the cloud between frames.
#[derive(Debug, Default)]
pub(crate) struct ClassicEngine {
    store: CloudStore,
    kernels: ProfileStore,
}

impl ClassicEngine {
    /// Memory of samples and of the cloud, bytes.
    pub(crate) fn bytes(&self) -> [usize; 2] {
        self.store.bytes()
    }

    /// Renders a frame.
    ///
    /// # Errors
    /// A rasteriser that cannot draw the footprints of this view; a cancelled picture.
    pub(crate) fn render(
        &mut self,
        run: Run<'_>,
        scene: &VolumeScene<'_>,
        (camera, settings): (&Camera, &RenderSettings<SplatSettings>),
        frame: &mut Frame,
    ) -> Result<RenderStatistics, SceneError> {
        let start = Instant::now();
        self.kernels.prepare(settings)?;
        let shape = self.kernels.shape(settings);
        let (cloud, bricks) = self
            .store
            .cloud(run, scene, settings, shape)
            .ok_or(SceneError::Stopped)?;
        let drawn = Drawn { cloud, bricks, scene };
        let view = (camera, settings);
        Ok(draw(run, (drawn, self.kernels.footprints()), view, frame, start))
    }
}

/// Plans and renders a frame. `start`: start time of the frame.
fn draw(
    run: Run<'_>,
    (drawn, footprints): (Drawn<'_>, FootprintProfile<'_>),
    view: (&Camera, &RenderSettings<SplatSettings>),
    frame: &mut Frame,
    start: Instant,
) -> RenderStatistics {
    let seconds = StageSeconds {
        classify: start.elapsed().as_secs_f64(),
        ..StageSeconds::default()
    };
    let mut statistics = match footprints {
        FootprintProfile::Gaussian(profile) => {
            let plan = || Plan::new(drawn, view, (profile, None));
            render_tiles(run, &run.pool.install(plan), frame, seconds)
        }
        FootprintProfile::Radial(profile, tables) => {
            let plan = || Plan::new(drawn, view, (profile, tables));
            render_tiles(run, &run.pool.install(plan), frame, seconds)
        }
    };
    statistics.seconds.total = start.elapsed().as_secs_f64();
    statistics
}

/// Renders all tiles into a frame.
fn render_tiles<P: Profile>(
    run: Run<'_>,
    plan: &Plan<'_, P>,
    frame: &mut Frame,
    mut seconds: StageSeconds,
) -> RenderStatistics {
    let start = Instant::now();
    let done = AtomicUsize::new(0);
    let count = plan.tiles.len();
    let wanted = |tile: &&u32| !run.task.is_stopped() && run.task.wants(&plan.tiles.rect(**tile as usize));
    let whole = || {
        plan.lists
            .longest_first()
            .par_iter()
            .with_max_len(1)
            .filter(wanted)
            .map_init(TileScratch::default, |scratch, &tile| {
                let work = tile::render(plan, (tile as usize, run.task.stop), scratch);
                let done = done.fetch_add(1, Ordering::Relaxed) + 1;
                run.task.report(done as f64 / count as f64);
                if !run.task.is_stopped() {
                    let rect = plan.tiles.rect(tile as usize);
                    run.task.show(&rect, || Resolved::colors(&work.0));
                }
                (tile as usize, work)
            })
            .collect()
    };
    let tiles: Vec<_> = match run.task.partial {
        None => run.pool.install(whole),
        Some(partial) => partial::render(run, plan, partial, frame),
    };
    let held = run.task.held(plan.tiles.picture());
    for (tile, (pixels, _)) in tiles.iter().filter(|_| !run.task.is_stopped()) {
        store((frame, &held), &plan.tiles.rect(*tile), pixels);
    }
    let sum = |pick: fn(&TileWork) -> u64| tiles.iter().map(|(_, (_, work))| pick(work)).sum::<u64>();
    let time = |pick: fn(&TileWork) -> f64| tiles.iter().map(|(_, (_, work))| pick(work)).sum::<f64>();
    seconds.bin = plan.seconds;
    seconds.tiles = start.elapsed().as_secs_f64();
    seconds.splat = time(|work| work.splat.as_secs_f64());
    seconds.shade = time(|work| work.shade.as_secs_f64());
    RenderStatistics {
        seconds,
        threads: run.pool.current_num_threads(),
        engine: "classic",
        simd: "scalar",
        bricks: plan.bricks,
        active_bricks: plan.cloud.chunks.len(),
        sheets: plan.order.count(),
        tiles: count,
        voxels: sum(|work| work.splats),
        slices: sum(|work| work.slices),
        hidden_bricks: sum(|work| work.hidden_chunks),
        hidden_voxels: sum(|work| work.hidden_splats),
        hidden_share: share(sum(|work| work.hidden_splats), sum(|work| work.splats)),
        ..RenderStatistics::default()
    }
}

/// Share of hidden splats among the hidden and the drawn ones.
fn share(hidden: u64, drawn: u64) -> f64 {
    hidden as f64 / (hidden + drawn).max(1) as f64
}
