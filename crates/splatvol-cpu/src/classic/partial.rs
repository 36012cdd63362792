//! Partial images: the picture after every so many sheets (swan1997 section 3.1).
//!
//! All tiles take the same turns before any takes the next, so each keeps its state. Sheets of values are one behind, since
//! their gradients need the next. The last picture is that of [`tile::render`], to the bit.

use rayon::prelude::*;
use splatvol_core::engine::Partial;
use splatvol_core::splats::Profile;
use splatvol_scene::Frame;

use super::pixel::{Resolved, store};
use super::plan::Plan;
use super::tile::{Progress, Tile, TileScratch, TileWork};
use crate::run::Run;

/// A tile between two of its turns.
struct Kept {
    tile: usize,
    scratch: TileScratch,
    progress: Progress,
    work: TileWork,
    pixels: Vec<Resolved>,
}

/// Renders all tiles, and shows the picture after every so many turns.
pub(super) fn render<P: Profile>(
    run: Run<'_>,
    plan: &Plan<'_, P>,
    partial: Partial<'_>,
    frame: &mut Frame,
) -> Vec<(usize, (Vec<Resolved>, TileWork))> {
    let mut tiles: Vec<Kept> = plan
        .lists
        .longest_first()
        .iter()
        .map(|&tile| Kept::new(tile as usize))
        .collect();
    let count = plan.order.count();
    let held = run.task.held(plan.tiles.picture());
    let mut turn = 0;
    while turn < count && !run.task.is_stopped() {
        let from = turn;
        turn = (turn + partial.every.max(1)).min(count);
        run.pool.install(|| {
            let each = tiles.par_iter_mut().with_max_len(1);
            each.for_each(|kept| kept.advance(run, plan, from..turn));
        });
        run.task.report(turn as f64 / count as f64);
        if run.task.is_stopped() {
            break;
        }
        for kept in &tiles {
            store((frame, &held), &plan.tiles.rect(kept.tile), &kept.pixels);
        }
        (partial.picture)(turn, &frame.image.pixels);
    }
    tiles
        .into_iter()
        .map(|kept| (kept.tile, (kept.pixels, kept.work)))
        .collect()
}

impl Kept {
    fn new(tile: usize) -> Self {
        Self {
            tile,
            scratch: TileScratch::default(),
            progress: Progress::default(),
            work: TileWork::default(),
            pixels: Vec::new(),
        }
    }

    /// Takes a range of turns, of which the first begins and the last ends the picture.
    fn advance<P: Profile>(&mut self, run: Run<'_>, plan: &Plan<'_, P>, turns: std::ops::Range<usize>) {
        let mut tile = Tile::new(plan, (self.tile, run.task.stop), &mut self.scratch);
        tile.work = self.work;
        if turns.start == 0 && tile.reset().is_none() {
            return;
        }
        tile.advance(self.tile, &mut self.progress, turns.end);
        if turns.end == plan.order.count() {
            tile.finish(self.tile, self.progress);
        }
        self.pixels = tile.resolved().unwrap_or_default();
        self.work = tile.work;
    }
}
