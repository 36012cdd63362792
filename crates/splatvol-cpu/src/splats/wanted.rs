//! Wanted: the tiles that a task asks for. Splats that reach none of them are left out before their colours are evaluated, so
//! that the shares of a picture cost little more than the picture.

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

    /// Whether a tile is wanted.
    pub(crate) fn has(&self, tile: usize) -> bool {
        self.tiles[tile]
    }

    /// Whether all are wanted.
    pub(crate) fn are_all(&self) -> bool {
        self.all
    }

    /// Those of the lanes that may touch a wanted tile.
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

    /// Whether a rectangle has a wanted tile.
    pub(crate) fn meet(&self, rect: Rect) -> bool {
        let [columns, mut rows] = tiles(rect);
        rows.any(|row| {
            columns
                .clone()
                .any(|column| self.tiles[row * self.columns + column])
        })
    }
}
