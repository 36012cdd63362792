//! Tiles: the pixels of a picture's tiles, kept from pass to pass and from frame to frame, and their rendering by threads.

use std::borrow::Cow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use fearless_simd::Simd;
use rayon::prelude::*;
use splatvol_core::clock::Instant;
use splatvol_core::engine::{RenderStatistics, StageSeconds};
use splatvol_core::plan::{FramePlan, Ramp};
use splatvol_scene::Frame;

use super::canvas::Canvas;
use super::frame::ZonedFrame;
use super::layer::{ModeLayer, TileLayer, render};
use super::mode::Mode;
use super::picture::{Picture, TileWork};
use super::resolve::{Slots, resolve};
use super::tile::{SheetScratch, SheetWork};
use crate::run::Run;

/// Largest and default edge of a tile, pixels: few voxels lie in two tiles.
pub(crate) const TILE_EDGE: usize = 128;

/// A tile's pixels and its work counts.
pub(crate) type Tile = Mutex<(Canvas, SheetWork)>;

/// Memory of the tiles, kept between frames.
#[derive(Debug, Default)]
pub(crate) struct TileMemory {
    /// One per thread, and of these one per layer.
    scratch: Vec<Mutex<Vec<SheetScratch>>>,
    tiles: Vec<Tile>,
}

impl TileMemory {
    /// Memory held, bytes.
    pub(super) fn bytes(&self) -> usize {
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
        picture: &Picture<'_>,
        sheets_per_voxel: u64,
        frame: &mut Frame,
        statistics: &mut RenderStatistics,
    ) {
        let start = Instant::now();
        let shown = picture.tiles();
        let plan = shown.frame().plan;
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
        if run.pass.is_last {
            resolve((grid, &slots), tiles, frame, run.block.map(|block| block.rect));
        }
        statistics.seconds.tiles += start.elapsed().as_secs_f64();
        statistics.active_bricks += shown.bricks();
        if run.block.is_none_or(|block| block.is_first) {
            statistics.sheets += plan.sheets();
            statistics.zones += shown.zones();
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
    ) -> SheetWork
    where
        Self: Sized;
}

/// One mode's picture of one frame.
#[derive(Debug)]
pub(crate) struct Single<'a, M, const N: usize> {
    frame: &'a ZonedFrame<'a>,
    mode: &'a M,
}

impl<'a, M, const N: usize> Single<'a, M, N> {
    /// A picture of a planned frame.
    pub(crate) fn new(frame: &'a ZonedFrame<'a>, mode: &'a M) -> Self {
        Self { frame, mode }
    }
}

impl<M, const N: usize> Clone for Single<'_, M, N> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M, const N: usize> Copy for Single<'_, M, N> {}

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
        render(simd, (self.frame.plan.termination, None, stop), layers, canvas)
    }
}

/// Two levels of one volume on the same planes, the first of which fades into the second.
#[derive(Debug)]
pub(crate) struct Both<'a, M, const N: usize> {
    frames: &'a [ZonedFrame<'a>; 2],
    modes: &'a [M; 2],
    fade: Ramp,
}

impl<'a, M, const N: usize> Both<'a, M, N> {
    /// A picture of two planned frames.
    pub(crate) fn new(frames: &'a [ZonedFrame<'a>; 2], modes: &'a [M; 2], fade: Ramp) -> Self {
        Self { frames, modes, fade }
    }
}

impl<M, const N: usize> Clone for Both<'_, M, N> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M, const N: usize> Copy for Both<'_, M, N> {}

impl<M: Mode<N>, const N: usize> Tiles for Both<'_, M, N> {
    fn frame(&self) -> &ZonedFrame<'_> {
        &self.frames[0]
    }

    fn bricks(&self) -> usize {
        self.frames.iter().map(|frame| frame.plan.corners.len()).sum()
    }

    fn zones(&self) -> usize {
        self.frames.iter().map(|frame| frame.plan.zones().len()).sum()
    }

    fn render<S: Simd>(
        &self,
        simd: S,
        (tile, stop): (usize, &AtomicBool),
        canvas: &mut Canvas,
        scratch: &mut Vec<SheetScratch>,
    ) -> SheetWork {
        if scratch.len() < 2 {
            scratch.resize_with(2, SheetScratch::default);
        }
        let [near, next] = &mut scratch[..2] else {
            return SheetWork::default();
        };
        let [first, second] = self.frames;
        let layers = (
            ModeLayer::new((first, &self.modes[0]), tile, near, canvas),
            ModeLayer::new((second, &self.modes[1]), tile, next, canvas),
        );
        let (Some(mut near), Some(mut next)) = layers else {
            return SheetWork::default();
        };
        let layers = &mut [&mut near as &mut dyn TileLayer<S>, &mut next];
        let of = (first.plan.termination, Some(self.fade), stop);
        render(simd, of, layers, canvas)
    }
}

/// Renders all tiles; each thread takes the next tile when it is free.
fn render_tiles(
    run: Run<'_>,
    picture: &Picture<'_>,
    scratch: &[Mutex<Vec<SheetScratch>>],
    (tiles, slots, order): (&[Tile], &Slots, &[u32]),
) {
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let frame = picture.tiles().frame().plan;
    scratch.par_iter().with_max_len(1).for_each(|scratch| {
        let scratch = &mut *lock(scratch);
        while let Some(&index) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
            let index = index as usize;
            let (canvas, work) = &mut *lock(&tiles[slots.of(index, &frame.tiles)]);
            let rect = frame.tiles.rect(index);
            if run.task.is_stopped() {
                break;
            }
            if run.pass.is_first {
                canvas.reset([rect.x1 - rect.x0, rect.y1 - rect.y0]);
            }
            canvas.continues = !run.pass.is_first;
            *work = SheetWork::default();
            if run.task.wants(&rect) {
                run.instructions.sheets(TileWork {
                    picture,
                    tile: index,
                    stop: run.task.stop,
                    canvas: &mut *canvas,
                    scratch: &mut *scratch,
                    done: work,
                });
                if run.pass.is_last && !run.task.is_stopped() {
                    run.task.show(&rect, || canvas.colors(rect.x1 - rect.x0));
                }
            }
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            run.task.report(done as f64 / order.len() as f64);
        }
    });
}
