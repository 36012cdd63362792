//! Wanted: the tiles that a task asks for. Splats that reach none of them are left out, most of them before their footprints are
//! computed, the others before their colours are, and are neither sorted nor binned: of what a share of a picture costs, only
//! the places of splats are computed again by each.
//!
//! Wanted tiles of a rectangle are counted by sums over all tiles above and to the left of a corner (Crow 1984, "Summed-area
//! tables for texture mapping").

use std::ops::Range;

use fearless_simd::{f32x16, prelude::*, u32x16};
use splatvol_core::bin::TileGrid;
use splatvol_core::engine::Task;

use super::bin::tiles;
use super::cover::TILE;
use super::project::{LANES, Rect};

/// The tiles of a picture, wanted or not.
#[derive(Debug)]
pub(crate) struct WantedTiles {
    tiles: Vec<bool>,
    /// Whether all are wanted.
    all: bool,
    /// Columns and rows.
    sides: [usize; 2],
    /// Number of wanted tiles above and to the left of each corner of tiles, row by row.
    sums: Vec<u32>,
}

impl WantedTiles {
    /// The tiles that a task wants.
    pub(crate) fn new(task: &Task<'_>, grid: &TileGrid) -> Self {
        let tiles: Vec<bool> = (0..grid.len()).map(|tile| task.wants(&grid.rect(tile))).collect();
        let across = grid.columns + 1;
        let mut sums = vec![0; across * (grid.rows + 1)];
        for row in 0..grid.rows {
            let mut own = 0;
            for column in 0..grid.columns {
                own += u32::from(tiles[row * grid.columns + column]);
                sums[(row + 1) * across + column + 1] = sums[row * across + column + 1] + own;
            }
        }
        Self {
            all: !tiles.contains(&false),
            tiles,
            sides: [grid.columns, grid.rows],
            sums,
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
            let [columns, rows] = tiles(rects[lane as usize]);
            let [upper, lower] = [rows.start, rows.end].map(|row| row * (self.sides[0] + 1));
            let corners = [
                upper + columns.start,
                upper + columns.end,
                lower + columns.start,
                lower + columns.end,
            ];
            reached |= u32::from(self.any_within(corners)) << lane;
        }
        reached
    }

    /// Those of some lanes whose squares, of so many pixels from the centre to a side, touch a wanted tile.
    #[inline(always)]
    pub(crate) fn near<S: Simd>(
        &self,
        simd: S,
        centre: [f32x16<S>; 2],
        (reach, lanes): (f32x16<S>, u32),
    ) -> u32 {
        let zero = f32x16::splat(simd, 0.0);
        let mut ends = [[u32x16::splat(simd, 0); 2]; 2];
        for (axis, ends) in ends.iter_mut().enumerate() {
            let sides = f32x16::splat(simd, self.sides[axis] as f32);
            let edge = 1.0 / TILE as f32;
            let first = (centre[axis] - reach) * edge;
            let past = (centre[axis] + reach) * edge + 1.0;
            // Numbers that are not negative are rounded down.
            *ends = [
                first.max(zero).min(sides).to_int(),
                past.max(zero).min(sides).to_int(),
            ];
        }
        let [columns, rows] = ends;
        let meets = columns[0].simd_lt(columns[1]) & rows[0].simd_lt(rows[1]);
        let meets = meets.to_bitmask() as u32 & lanes;
        if self.all || meets == 0 {
            return meets;
        }
        let across = u32x16::splat(simd, self.sides[0] as u32 + 1);
        let mut corners = [[0; LANES]; 4];
        for (k, corner) in corners.iter_mut().enumerate() {
            *corner = (rows[k / 2] * across + columns[k % 2]).to_array();
        }
        let mut near = 0;
        let [a, b, c, d] = &corners;
        for (lane, (((a, b), c), d)) in a.iter().zip(b).zip(c).zip(d).enumerate() {
            let own = [a, b, c, d].map(|&corner| corner as usize);
            near |= u32::from(self.any_within(own)) << lane;
        }
        near & meets
    }

    /// Whether tiles between corners - both of the upper side, both of the lower - are wanted.
    #[inline(always)]
    fn any_within(&self, corners: [usize; 4]) -> bool {
        let [a, b, c, d] = corners.map(|corner| self.sums.get(corner).copied().unwrap_or_default());
        d + a != b + c
    }
}
