//! Layer: state of a part of a scene in a tile, and the loop over all layers of the tile.
//!
//! All layers of a scene lie on the same planes. Sheet by sheet each layer splats its voxels. For each interval
//! between two planes the layers add their materials to the canvas ([`Canvas::gather`]), which composites them
//! once. A single layer is composited directly, and gives the same picture as among other layers that do not reach
//! its pixels.
//!
//! Each layer is cut into its own zones of depth (`splatvol_core::plan`). A layer that enters its next zone
//! rebuilds the planes before the current one in that zone's raster, while the others wait.

use std::sync::atomic::{AtomicBool, Ordering};

use fearless_simd::prelude::*;
use splatvol_core::clock::Instant;
use splatvol_core::plan::{Ramp, ZonePlan};

use super::canvas::Canvas;
use super::frame::{SheetFrame, ZonedFrame};
use super::mask::OpenMask;
use super::mode::Mode;
use super::place::Place;
use super::ring::LANES;
use super::tile::{SheetScratch, SheetWork};

/// Sheets whose bricks are fetched from memory together.
const AHEAD: usize = 3;

/// A part of a scene in a tile.
pub(crate) trait TileLayer<S: Simd> {
    /// The first plane that this layer can reach; planes are counted from depth 0
    /// ([`splatvol_core::sheets::Planes`]).
    fn first(&self) -> i64;

    /// The first plane, from this one on, that needs work.
    fn next(&self, plane: i64) -> Option<i64>;

    /// Enters the zone of a plane: composites the rest of the last zone, and rebuilds the planes before this one
    /// that both zones need.
    fn go_on_to(&mut self, simd: S, plane: i64, canvas: &mut Canvas, work: &mut SheetWork);

    /// Splats the voxels that enter a plane, and takes the plane out of the ring.
    fn splat(&mut self, simd: S, plane: i64, work: &mut SheetWork);

    /// Composites the interval between the last plane but two and the one behind it; slopes need the plane that was
    /// taken last.
    fn shade(&mut self, simd: S, plane: i64, canvas: &mut Canvas);

    /// Converts the final canvas to pixels.
    fn finish(&mut self, simd: S, canvas: &mut Canvas);

    /// Which of the tile's pixels are still open.
    fn mask(&mut self) -> &mut OpenMask;

    /// Adds the counts of its work.
    fn count(&mut self, work: &mut SheetWork);
}

/// A layer of a [`Mode`] in a tile.
#[derive(Debug)]
pub(crate) struct ModeLayer<'a, M, const N: usize> {
    picture: &'a ZonedFrame<'a>,
    mode: &'a M,
    scratch: &'a mut SheetScratch,
    tile: usize,
    /// Index of the current zone, and its frame.
    zone: usize,
    frame: SheetFrame<'a>,
    place: Place,
    /// The tile's first unopened brick, and the first that is not prefetched.
    next: usize,
    fetched: usize,
    /// Sheets since the last voxel: when the ring and the planes are empty, sheets are skipped.
    idle: usize,
}

impl<'a, M: Mode<N>, const N: usize> ModeLayer<'a, M, N> {
    /// A layer at the start of a tile; `None` where all of it is behind the camera.
    pub(crate) fn new(
        (picture, mode): (&'a ZonedFrame<'a>, &'a M),
        tile: usize,
        scratch: &'a mut SheetScratch,
        canvas: &mut Canvas,
    ) -> Option<Self> {
        let frame = picture.zone(0)?;
        let place = Place::new(picture.plan.tiles.rect(tile), frame.step);
        scratch.reset(place.size);
        if canvas.continues {
            scratch.mask.close_finished(canvas, frame.termination);
        } else {
            mode.begin(canvas);
        }
        let mut layer = Self {
            picture,
            mode,
            scratch,
            tile,
            zone: 0,
            frame,
            place,
            next: 0,
            fetched: 0,
            idle: usize::MAX,
        };
        layer.begin_zone();
        Some(layer)
    }

    /// Prepares for the current zone.
    fn begin_zone(&mut self) {
        let Self { frame, mode, .. } = self;
        self.place = Place::new(self.picture.plan.tiles.rect(self.tile), frame.step);
        let groups = mode.ring_groups(frame);
        self.scratch.begin_zone(frame, &self.place, groups, mode.planes());
        if mode.has_holes() {
            self.scratch.begin_holes(frame, &self.place, N);
        }
        mode.reset(frame, self.scratch);
        (self.next, self.fetched, self.idle) = (0, 0, usize::MAX);
    }

    /// Index of a plane in this zone; `None` before its first plane and behind the last that may hold anything.
    fn sheet(&self, plane: i64) -> Option<usize> {
        let sheet = usize::try_from(plane - self.frame.stack.first).ok()?;
        (sheet <= self.frame.zone.last_sheet).then_some(sheet)
    }

    /// The first plane of this zone, from this one on, that needs work.
    fn next_here(&self, plane: i64) -> Option<i64> {
        let first = self.frame.stack.first;
        let plane = plane.max(first);
        let lasting = self.frame.groups * LANES + self.scratch.planes.len();
        let next = if self.mode.waits(self.scratch) || self.idle <= lasting {
            plane
        } else {
            let next = self.frame.lists.brick(self.tile, self.next)?;
            plane.max(first + i64::from(next.front_sheet))
        };
        (next <= self.frame.zone.last_plane()).then_some(next)
    }

    /// The first such plane of the zones behind it.
    fn next_behind(&self, plane: i64) -> Option<i64> {
        let mut behind = self.picture.plan.zones().iter().skip(self.zone + 1);
        behind.find_map(|ZonePlan { zone, lists, .. }| {
            let brick = lists.brick(self.tile, 0)?;
            let first = zone.planes.first + i64::from(brick.front_sheet);
            let next = plane.max(first).max(zone.first_shown());
            (next <= zone.last_plane()).then_some(next)
        })
    }

    /// Opens the bricks that a sheet is the first to meet, unless finished pixels hide them.
    #[inline(always)]
    fn open<S: Simd>(&mut self, simd: S, sheet: usize) {
        let lists = self.frame.lists;
        let comes = |at: usize, by: usize| {
            let brick = lists.brick(self.tile, at);
            brick.filter(|brick| brick.front_sheet as usize <= by)
        };
        if comes(self.fetched, sheet + 1).is_some() {
            while let Some(brick) = comes(self.fetched, sheet + AHEAD) {
                self.mode.touch(brick.active.brick as usize);
                self.fetched += 1;
            }
        }
        while let Some(brick) = comes(self.next, sheet) {
            self.next += 1;
            if self
                .scratch
                .mask
                .any(self.place.blocks(brick.rect, self.frame.step))
            {
                let around = (&self.place, sheet);
                self.mode
                    .open_brick(simd, &self.frame, brick, around, self.scratch);
            }
        }
    }

    /// Leaves a zone, and composites the rest of it.
    fn leave<S: Simd>(&mut self, simd: S, canvas: &mut Canvas) {
        simd.vectorize(
            #[inline(always)]
            || {
                let target = (canvas, &mut *self.scratch);
                self.mode.leave(simd, &self.frame, &self.place, target);
            },
        );
    }
}

impl<S: Simd, M: Mode<N>, const N: usize> TileLayer<S> for ModeLayer<'_, M, N> {
    fn first(&self) -> i64 {
        self.frame.stack.first
    }

    fn next(&self, plane: i64) -> Option<i64> {
        self.next_here(plane).or_else(|| self.next_behind(plane))
    }

    fn go_on_to(&mut self, simd: S, plane: i64, canvas: &mut Canvas, work: &mut SheetWork) {
        let zones = self.picture.plan.zones();
        let behind = |zone: usize| zone + 1 < zones.len() && plane > zones[zone].zone.last_plane();
        if !behind(self.zone) {
            return;
        }
        self.leave(simd, canvas);
        while behind(self.zone) {
            self.zone += 1;
        }
        let Some(frame) = self.picture.zone(self.zone) else {
            return;
        };
        self.frame = frame;
        self.begin_zone();
        let mut next = frame.stack.first;
        while let Some(before) = self.next_here(next).filter(|&before| before < plane) {
            self.splat(simd, before, work);
            next = before + 1;
        }
    }

    fn splat(&mut self, simd: S, plane: i64, work: &mut SheetWork) {
        let Some(sheet) = self.sheet(plane) else { return };
        simd.vectorize(
            #[inline(always)]
            || {
                let start = Instant::now();
                let before = *work;
                let window = self.mode.window(&self.frame, &self.place, sheet);
                self.scratch.mask.refresh(window.blocks);
                self.open(simd, sheet);
                let around = (&self.place, &window, sheet);
                self.mode.enter(simd, &self.frame, around, self.scratch, work);
                let entered = Instant::now();
                self.idle = if work.voxels > before.voxels {
                    0
                } else {
                    self.idle.saturating_add(1)
                };
                self.scratch.planes.rotate_left(1);
                self.mode
                    .take(simd, &self.frame, &self.place, sheet, self.scratch);
                if self.mode.has_holes() {
                    let around = (&self.frame, &self.place);
                    self.scratch.take_holes(simd, around, (sheet, N));
                }
                work.activate += (entered - start).saturating_sub(work.splat - before.splat);
                work.take += entered.elapsed();
            },
        );
    }

    fn shade(&mut self, simd: S, plane: i64, canvas: &mut Canvas) {
        let Some(near) = self.sheet(plane).and_then(|sheet| sheet.checked_sub(2)) else {
            return;
        };
        let zone = self.frame.zone;
        if !zone.shown.contains(&near) {
            return;
        }
        let at_eye = near == zone.shown.start && zone.begins_at_eye();
        simd.vectorize(
            #[inline(always)]
            || {
                if at_eye {
                    let of = (&self.frame, self.mode);
                    if let Some(eye) = self.frame.eye {
                        eye.make_planes(simd, of, &self.place, self.scratch);
                    }
                }
                let target = (canvas, &mut *self.scratch);
                self.mode.shade(simd, &self.frame, near, &self.place, target);
            },
        );
        self.scratch.at_eye = None;
    }

    fn finish(&mut self, simd: S, canvas: &mut Canvas) {
        self.leave(simd, canvas);
        simd.vectorize(
            #[inline(always)]
            || self.mode.finish(simd, self.picture, &self.place.rect, canvas),
        );
    }

    fn mask(&mut self) -> &mut OpenMask {
        &mut self.scratch.mask
    }

    fn count(&mut self, work: &mut SheetWork) {
        self.scratch.count(work);
    }
}

/// Renders the layers of a tile, plane by plane, front to back, unless `stop` is set meanwhile; with a ramp, two levels of
/// one volume, the first of which fades into the second.
pub(crate) fn render<S: Simd>(
    simd: S,
    (termination, fade, stop): (f32, Option<Ramp>, &AtomicBool),
    layers: &mut [&mut dyn TileLayer<S>],
    canvas: &mut Canvas,
) -> SheetWork {
    let several = layers.len() > 1;
    match several {
        true => canvas.gather(),
        false => canvas.composite(),
    }
    let mut work = SheetWork::default();
    let mut plane = layers.iter().map(|layer| layer.first()).min().unwrap_or(0);
    while !stop.load(Ordering::Relaxed) && layers.iter_mut().any(|layer| !layer.mask().none_left()) {
        let next = layers.iter().filter_map(|layer| layer.next(plane)).min();
        let Some(next) = next else { break };
        plane = next;
        for layer in layers.iter_mut() {
            layer.go_on_to(simd, plane, canvas, &mut work);
            layer.splat(simd, plane, &mut work);
        }
        let start = Instant::now();
        for (at, layer) in layers.iter_mut().enumerate() {
            if let Some(ramp) = fade {
                // The interval between the last plane but two and the one behind it.
                let next = ramp.share(plane - 2).clamp(0.0, 1.0);
                canvas.share = if at == 0 { 1.0 - next } else { next };
            }
            layer.shade(simd, plane, canvas);
        }
        if several {
            settle(simd, termination, layers, canvas);
        }
        work.shade += start.elapsed();
        plane += 1;
    }
    let start = Instant::now();
    for layer in layers.iter_mut() {
        layer.finish(simd, canvas);
        layer.count(&mut work);
    }
    work.shade += start.elapsed();
    work
}

/// Composites the gathered materials of an interval, and closes the pixels that it finishes.
fn settle<S: Simd>(simd: S, termination: f32, layers: &mut [&mut dyn TileLayer<S>], canvas: &mut Canvas) {
    simd.vectorize(
        #[inline(always)]
        || {
            canvas.settle(simd, termination, |x, y, finished| {
                for layer in layers.iter_mut() {
                    layer.mask().finish(x, y, finished);
                }
            });
        },
    );
}
