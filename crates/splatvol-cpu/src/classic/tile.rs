//! The tile loop: turn by turn, front to back.
//!
//! * *image sheets*: splats stay open while sheets cut sections from their kernels; a finished sheet goes behind
//!   the pixels (huang2000 section 2.1);
//! * *slices* (axis-aligned sheets) and *all at once* (X-ray): a turn's whole footprints are added up first;
//! * *per splat*: each footprint goes behind, or before, the pixels as it comes.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use splatvol_core::bin::{ProjectedBrick, TileRect};
use splatvol_core::clock::Instant;
use splatvol_core::splats::{Footprint, Profile};
use splatvol_scene::{Absorption, SplatCompositing};

use super::occlusion::Finished;
use super::order::Order;
use super::pixel::{Pixel, Resolved, resolve};
use super::plan::Plan;
use super::post_classified::ValueSheets;
use super::raster::{Brush, Target};
use super::sheet::Sheet;
use super::turns::{Turns, ordered};
use crate::room::grow_with;

/// Splats between two checks for cancellation.
const PATIENCE: usize = 64;

/// A thread's memory.
#[derive(Debug, Default)]
pub(crate) struct TileScratch {
    pub turns: Turns,
    pub open: Vec<Open>,
    /// Extinction, emission, extinction times depth.
    pub sheet: Sheet<5>,
    pub values: ValueSheets,
    pub pixels: Vec<Pixel>,
    pub finished: Finished,
    pub row: Vec<f32>,
}

/// A splat that later sheets may section.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Open {
    pub footprint: Footprint,
    /// Camera depth at which the splat ends.
    pub end: f32,
    pub area: [usize; 4],
    pub payload: [f32; 4],
}

/// Work done by a tile.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct TileWork {
    /// Splats projected and not hidden.
    pub splats: u64,
    pub slices: u64,
    pub hidden_chunks: u64,
    pub hidden_splats: u64,
    pub splat: Duration,
    pub shade: Duration,
}

/// How far a tile is.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Progress {
    /// The next turn.
    turn: usize,
    /// Chunks opened so far.
    chunks: usize,
}

/// Inputs and state for rendering one tile.
pub(crate) struct Tile<'a, P> {
    pub plan: &'a Plan<'a, P>,
    pub brush: Brush<'a, P>,
    /// The tile's own pixels.
    pub rect: TileRect,
    pub scratch: &'a mut TileScratch,
    pub work: TileWork,
    /// Cancellation flag.
    pub stop: &'a AtomicBool,
}

/// Renders one tile: its pixels, row by row; none if the picture is cancelled.
pub(crate) fn render<P: Profile>(
    plan: &Plan<'_, P>,
    (tile, stop): (usize, &AtomicBool),
    scratch: &mut TileScratch,
) -> (Vec<Resolved>, TileWork) {
    let mut run = Tile::new(plan, (tile, stop), scratch);
    if run.reset().is_some() {
        let mut progress = Progress::default();
        run.advance(tile, &mut progress, plan.order.count());
        run.finish(tile, progress);
    }
    (run.resolved().unwrap_or_default(), run.work)
}

impl<'a, P: Profile> Tile<'a, P> {
    /// A tile, with what it keeps from turn to turn.
    pub(crate) fn new(
        plan: &'a Plan<'a, P>,
        (tile, stop): (usize, &'a AtomicBool),
        scratch: &'a mut TileScratch,
    ) -> Self {
        let rect = plan.tiles.rect(tile);
        Self {
            plan,
            brush: Brush {
                profile: plan.profile,
                tables: plan.tables,
                rect: plan.splatted(&rect),
            },
            rect,
            scratch,
            work: TileWork::default(),
            stop,
        }
    }

    /// Forgets the last picture; `None` if this one is cancelled meanwhile.
    pub(crate) fn reset(&mut self) -> Option<()> {
        let splatted = self.brush.rect;
        let (width, height) = (splatted.x1 - splatted.x0, splatted.y1 - splatted.y0);
        let (own_width, own_height) = (self.rect.x1 - self.rect.x0, self.rect.y1 - self.rect.y0);
        let scratch = &mut *self.scratch;
        scratch.turns.reset(self.plan.order.count());
        scratch.open.clear();
        let levels = self.plan.sheet_levels();
        let of_colors = levels.map(|levels| (levels, 4));
        scratch.sheet.reset([width, height], of_colors, self.stop)?;
        if self.plan.shading.is_some() {
            scratch.values.reset([width, height], levels, self.stop)?;
        }
        scratch.pixels.clear();
        let own = own_width * own_height;
        grow_with(&mut scratch.pixels, own, || Pixel::EMPTY, self.stop)?;
        scratch
            .finished
            .reset(self.plan.settings.method.occlusion, own_width, own_height);
        Some(())
    }

    /// Takes the turns up to `until`, excluded.
    pub(crate) fn advance(&mut self, tile: usize, progress: &mut Progress, until: usize) {
        let plan = self.plan;
        let count = plan.lists.of(tile).count();
        let mut chunks = plan.lists.of(tile).skip(progress.chunks).peekable();
        let mut turn = progress.turn;
        while turn < until && !self.scratch.finished.all() && !self.is_stopped() {
            if self.is_idle(turn) {
                // Nothing is open: the next chunk's first turn is the next that matters, or one that waits.
                let next = chunks
                    .peek()
                    .map_or(usize::MAX, |chunk| chunk.front_sheet as usize);
                turn = match (turn..until.min(next)).find(|&t| self.scratch.turns.has(t)) {
                    Some(waiting) => waiting,
                    None => next.max(turn).min(until),
                };
                if turn == until {
                    break;
                }
            }
            self.open_chunks(&mut chunks, turn);
            self.take_turn(turn);
            turn += 1;
        }
        *progress = Progress {
            turn,
            chunks: count - chunks.count(),
        };
    }

    /// Finishes the picture after the last turn.
    pub(crate) fn finish(&mut self, tile: usize, progress: Progress) {
        if self.is_stopped() {
            return;
        }
        // Chunks never opened and splats never drawn are hidden by finished pixels.
        let plan = self.plan;
        for chunk in plan.lists.of(tile).skip(progress.chunks) {
            self.work.hidden_chunks += 1;
            let chunk = &plan.cloud.chunks[chunk.active.brick as usize];
            self.work.hidden_splats += u64::from(chunk.end - chunk.first);
        }
        self.work.hidden_splats += self.scratch.turns.waiting() as u64;
        if plan.shading.is_some() {
            self.finish_values();
        }
    }

    /// The pixels so far; `None` if the picture is cancelled, since a tile may be the whole picture.
    pub(crate) fn resolved(&self) -> Option<Vec<Resolved>> {
        let is_integral = self.plan.settings.method.compositing == SplatCompositing::Xray;
        let pixels = &self.scratch.pixels;
        let mut resolved = Vec::with_capacity(pixels.len());
        for row in pixels.chunks(self.rect.x1 - self.rect.x0) {
            if self.is_stopped() {
                return None;
            }
            resolved.extend(row.iter().map(|pixel| resolve(pixel, is_integral)));
        }
        Some(resolved)
    }

    fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Whether the picture is cancelled; checked once every so many splats.
    #[inline(always)]
    fn gives_up(&self, splats: usize) -> bool {
        splats.is_multiple_of(PATIENCE) && self.is_stopped()
    }

    /// Whether no started sheet is left.
    fn is_idle(&self, turn: usize) -> bool {
        let Self { scratch, plan, .. } = self;
        scratch.open.is_empty()
            && !scratch.turns.has(turn)
            && (plan.shading.is_none() || scratch.values.is_idle())
    }

    /// Opens the chunks whose first turn has come, unless they are hidden. As in huang2000 section 4.1, the table
    /// is updated only before a chunk that is not hidden according to the current table.
    fn open_chunks<'b>(
        &mut self,
        chunks: &mut std::iter::Peekable<impl Iterator<Item = &'b ProjectedBrick>>,
        turn: usize,
    ) {
        let mut refreshed = false;
        while let Some(chunk) = chunks.next_if(|chunk| chunk.front_sheet as usize <= turn) {
            if self.is_stopped() {
                return;
            }
            let finished = &mut self.scratch.finished;
            if let Some(area) = own_area(&self.rect, chunk.rect) {
                let mut hidden = finished.hide(area);
                if !hidden && !refreshed {
                    finished.refresh();
                    refreshed = true;
                    hidden = finished.hide(area);
                }
                if hidden {
                    self.work.hidden_chunks += 1;
                    let chunk = &self.plan.cloud.chunks[chunk.active.brick as usize];
                    self.work.hidden_splats += u64::from(chunk.end - chunk.first);
                    continue;
                }
            }
            self.scratch
                .turns
                .open(self.plan, chunk.active.brick as usize, turn);
        }
    }

    fn take_turn(&mut self, turn: usize) {
        let start = Instant::now();
        match self.plan.order {
            Order::Depth { reversed, .. } => {
                self.splat_each(turn, reversed);
                self.work.splat += start.elapsed();
            }
            Order::Slices { .. } | Order::Once => {
                self.splat_whole(turn);
                let splatted = Instant::now();
                self.composite(None);
                self.work.splat += splatted - start;
                self.work.shade += splatted.elapsed();
            }
            Order::Sheets { sheets, .. } => {
                let section = sheets.slab(turn).map(|depth| depth as f32);
                self.open_splats(turn);
                if self.plan.shading.is_some() {
                    self.splat_values(turn, section);
                    let splatted = Instant::now();
                    self.shade_values(turn);
                    self.work.splat += splatted - start;
                    self.work.shade += splatted.elapsed();
                } else {
                    self.splat_sections(section);
                    let splatted = Instant::now();
                    self.composite(Some(0.5 * (section[0] + section[1])));
                    self.work.splat += splatted - start;
                    self.work.shade += splatted.elapsed();
                }
            }
        }
    }

    /// Projects the splats of a turn that may touch an open pixel.
    fn project(&mut self, splat: u32) -> Option<Open> {
        let mut footprint = self.plan.projection.project(splat as usize)?;
        if let Some(tables) = self.plan.tables {
            footprint = tables.snap(footprint);
        }
        let area = self.brush.area(&footprint)?;
        self.work.splats += 1;
        self.scratch.finished.note([area[2] - area[0], area[3] - area[1]]);
        let splatted = &self.brush.rect;
        let near = [
            (area[0] + splatted.x0) as f32,
            (area[1] + splatted.y0) as f32,
            (area[2] + splatted.x0 - 1) as f32,
            (area[3] + splatted.y0 - 1) as f32,
        ];
        // A splat beside the tile's own pixels takes part in their differences.
        let apron = self.plan.apron as f32;
        let grown = [near[0] - apron, near[1] - apron, near[2] + apron, near[3] + apron];
        if own_area(&self.rect, grown).is_some_and(|own| self.scratch.finished.hide(own)) {
            self.work.hidden_splats += 1;
            self.work.splats -= 1;
            return None;
        }
        Some(Open {
            footprint,
            end: footprint.depth + self.plan.projection.reach_of(splat as usize),
            area,
            payload: self.plan.payload(splat as usize),
        })
    }

    fn open_splats(&mut self, turn: usize) {
        let mut turns = std::mem::take(&mut self.scratch.turns);
        for (count, &(_, splat)) in turns.take(turn, |splat| splat).iter().enumerate() {
            if self.gives_up(count) {
                break;
            }
            if let Some(open) = self.project(splat) {
                self.scratch.open.push(open);
            }
        }
        self.scratch.turns = turns;
    }

    /// Adds the open splats' sections to the sheet, and drops splats that end before the next sheet.
    fn splat_sections(&mut self, section: [f32; 2]) {
        let TileScratch {
            open,
            sheet,
            row,
            finished,
            ..
        } = &mut *self.scratch;
        let (brush, stop) = (&self.brush, self.stop);
        let work = &mut self.work;
        open.retain(|splat| {
            if work.slices.is_multiple_of(PATIENCE as u64) && stop.load(Ordering::Relaxed) {
                return false;
            }
            // The apron is only there for values, so areas are the tile's own pixels.
            if finished.hide(splat.area) {
                return false;
            }
            work.slices += 1;
            let mut target = Sum {
                sheet: &mut *sheet,
                payload: with_depth(splat.payload, 0.0),
            };
            target.sheet.touch(splat.area);
            brush.draw(&splat.footprint, Some(section), splat.area, row, &mut target);
            section[1] < splat.end
        });
    }

    /// Adds a turn's whole footprints to the sheet.
    fn splat_whole(&mut self, turn: usize) {
        let mut turns = std::mem::take(&mut self.scratch.turns);
        for (count, &(_, splat)) in turns.take(turn, |splat| splat).iter().enumerate() {
            if self.gives_up(count) {
                break;
            }
            let Some(open) = self.project(splat) else { continue };
            self.work.slices += 1;
            let TileScratch { sheet, row, .. } = &mut *self.scratch;
            sheet.touch(open.area);
            let mut target = Sum {
                sheet,
                payload: with_depth(open.payload, open.footprint.depth),
            };
            self.brush
                .draw(&open.footprint, None, open.area, row, &mut target);
        }
        self.scratch.turns = turns;
    }

    /// Composites a turn's footprints one by one.
    fn splat_each(&mut self, turn: usize, reversed: bool) {
        let mut turns = std::mem::take(&mut self.scratch.turns);
        let plan = self.plan;
        let key = |splat: u32| {
            let depth = ordered(plan.projection.centre(splat as usize).z);
            if reversed { !depth } else { depth }
        };
        for (count, &(_, splat)) in turns.take(turn, key).iter().enumerate() {
            if self.gives_up(count) {
                break;
            }
            let Some(open) = self.project(splat) else { continue };
            self.work.slices += 1;
            let [extinction, r, g, b] = open.payload;
            let TileScratch {
                pixels,
                finished,
                row,
                ..
            } = &mut *self.scratch;
            let mut target = Over {
                pixels,
                finished,
                width: self.rect.x1 - self.rect.x0,
                extinction,
                color: [r, g, b].map(|e| e / extinction),
                footprint: &open.footprint,
                absorption: plan.settings.method.absorption,
                termination: plan.settings.termination as f32,
                reversed,
            };
            self.brush
                .draw(&open.footprint, None, open.area, row, &mut target);
        }
        self.scratch.turns = turns;
    }

    /// Composites the sheet behind the pixels, or keeps its sums for the picture (X-ray), and empties it. `depth`:
    /// the sheet's; `None` takes the mean depth of the sheet's splats.
    fn composite(&mut self, depth: Option<f32>) {
        let TileScratch {
            sheet,
            pixels,
            finished,
            ..
        } = &mut *self.scratch;
        let [x0, y0, x1, y1] = sheet.touched();
        let stop = self.stop;
        let settings = self.plan.settings;
        let termination = settings.termination as f32;
        let levels = self.plan.picture_levels();
        let width = self.rect.x1 - self.rect.x0;
        for y in y0..y1 {
            if stop.load(Ordering::Relaxed) {
                break;
            }
            for x in x0..x1 {
                let &[extinction, r, g, b, weighted] = sheet.pixel(x, y);
                if extinction <= 0.0 || finished.is(x, y) {
                    continue;
                }
                let pixel = &mut pixels[y * width + x];
                if settings.method.compositing == SplatCompositing::Xray {
                    pixel.integrate(extinction, [r, g, b], weighted);
                    continue;
                }
                let color = [r, g, b].map(|e| e / extinction);
                let depth = depth.unwrap_or(weighted / extinction);
                pixel.composite((extinction, settings.method.absorption), color, depth, levels);
                if pixel.transmittance <= termination {
                    finished.finish(x, y);
                }
            }
        }
        sheet.clear();
    }
}

fn with_depth([extinction, r, g, b]: [f32; 4], depth: f32) -> [f32; 5] {
    [extinction, r, g, b, extinction * depth]
}

/// The tile pixels that a rectangle of the picture (pixels, ends included) may cover, ends excluded.
#[inline(always)]
pub(crate) fn own_area(rect: &TileRect, [x0, y0, x1, y1]: [f32; 4]) -> Option<[usize; 4]> {
    let low = |at: f32, from: usize| (at.max(from as f32)) as usize;
    let high = |at: f32, to: usize| (at.min(to as f32 - 1.0).max(-1.0) + 1.0) as usize;
    let (ax, ay) = (low(x0, rect.x0), low(y0, rect.y0));
    let (bx, by) = (high(x1, rect.x1), high(y1, rect.y1));
    (ax < bx && ay < by).then(|| [ax - rect.x0, ay - rect.y0, bx - rect.x0, by - rect.y0])
}

/// Adds a splat to a sheet.
struct Sum<'a> {
    sheet: &'a mut Sheet<5>,
    payload: [f32; 5],
}

impl Target for Sum<'_> {
    #[inline(always)]
    fn row(&mut self, place: (usize, usize), weights: &[f32]) {
        self.sheet.add_row(place, weights, &self.payload);
    }
}

/// Composites a splat with the pixels.
struct Over<'a> {
    pixels: &'a mut [Pixel],
    finished: &'a mut Finished,
    width: usize,
    extinction: f32,
    color: [f32; 3],
    footprint: &'a Footprint,
    absorption: Absorption,
    termination: f32,
    reversed: bool,
}

impl Over<'_> {
    /// The opacity of an optical depth.
    #[inline(always)]
    fn opacity(&self, optical_depth: f32) -> f32 {
        let opacity = match self.absorption {
            Absorption::Exp => -libm::expm1f(-optical_depth),
            Absorption::Linear => optical_depth.min(1.0),
        };
        opacity * self.footprint.opacity
    }
}

impl Target for Over<'_> {
    #[inline(always)]
    fn row(&mut self, (x, y): (usize, usize), weights: &[f32]) {
        // Where only its opacity falls as it grows or moves, a splat is as dense as if it had not.
        let density = self.extinction / self.footprint.opacity;
        for (i, weight) in weights.iter().enumerate() {
            if *weight <= 0.0 || self.finished.is(x + i, y) {
                continue;
            }
            let opacity = self.opacity(density * weight);
            let pixel = &mut self.pixels[y * self.width + x + i];
            if self.reversed {
                pixel.cover(opacity, self.color, self.footprint.depth);
            } else {
                pixel.add_opacity(opacity, self.color, self.footprint.depth);
                if pixel.transmittance <= self.termination {
                    self.finished.finish(x + i, y);
                }
            }
        }
    }
}
