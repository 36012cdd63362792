//! Wanted: the tiles that a task asks for. Splats that reach none of them are left out before their colours are evaluated, and
//! are neither sorted nor binned: of what shares of a picture cost, only the projection is done again by each.

use std::ops::Range;

use splatvol_core::bin::TileGrid;
use splatvol_core::engine::Task;

use super::bin::tiles;
use super::project::{LANES, Rect};

/// The tiles of a picture, wanted or not.
#[derive(Debug)]
pub(crate) struct WantedTiles {
    columns: usize,
    tiles: Vec<bool>,
    /// Whether all are wanted.
    all: bool,
}

impl WantedTiles {
    /// The tiles that a task wants.
    pub(crate) fn new(task: &Task<'_>, grid: &TileGrid) -> Self {
        let tiles: Vec<bool> = (0..grid.len()).map(|tile| task.wants(&grid.rect(tile))).collect();
        Self {
            columns: grid.columns,
            all: !tiles.contains(&false),
            tiles,
        }
    }

    /// Whether all are wanted.
    pub(crate) fn are_all(&self) -> bool {
        self.all
    }

    /// Which tiles of a range are wanted.
    pub(crate) fn of(&self, range: Range<usize>) -> &[bool] {
        &self.tiles[range]
    }

    /// Whether a tile is wanted.
    pub(crate) fn has(&self, tile: usize) -> bool {
        self.tiles[tile]
    }

    /// Those of some lanes that may touch a wanted tile.
    #[inline(always)]
    pub(crate) fn reached(&self, rects: &[Rect; LANES], lanes: u32) -> u32 {
        if self.all {
            return lanes;
        }
        let mut reached = 0;
        let mut left = lanes;
        while left != 0 {
            let lane = left.trailing_zeros();
            left &= left - 1;
            reached |= u32::from(self.meet(rects[lane as usize])) << lane;
        }
        reached
    }

    fn meet(&self, rect: Rect) -> bool {
        let [columns, mut rows] = tiles(rect);
        rows.any(|row| {
            let first = row * self.columns;
            self.of(first + columns.start..first + columns.end)
                .contains(&true)
        })
    }
}
