//! Bin: adds splats in depth order to the lists of the wanted tiles that they may touch, by counting.
//!
//! Parts of the order count their splats per tile, then write them behind those of the parts before. The number of
//! tiles whose lists are made at once is limited by a fixed number of entries per splat, so memory is bounded
//! however large splats are.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};

use rayon::prelude::*;
use splatvol_core::bin::TileGrid;

use super::cover::TILE;
use super::order::{even, index, starts};
use super::project::Rect;
use super::view::REFERENCE_TILE;
use super::wanted::WantedTiles;
use crate::room::grow;

/// Reference tiles along an edge of a tile.
const RATIO: u16 = (TILE as u32 / REFERENCE_TILE) as u16;
/// Entries in lists per splat; a tile's list is made whole in any case.
const ENTRIES_PER_SPLAT: usize = 16;

/// Lists of splats per tile, of some tiles at a time.
#[derive(Debug, Default)]
pub(crate) struct Bins {
    entries: Vec<AtomicU32>,
}

/// Number of splats per wanted tile, for each part of the order.
pub(crate) struct Counted<'a> {
    wanted: &'a WantedTiles,
    grid: TileGrid,
    order: &'a [AtomicU64],
    rects: &'a [Rect],
    parts: Vec<Range<usize>>,
    counts: Vec<Vec<u32>>,
    stop: &'a AtomicBool,
}

/// The lists of the tiles of a range.
pub(crate) struct Lists<'a> {
    pub tiles: Range<usize>,
    entries: &'a [AtomicU32],
    /// Start of each list, and the end of the last.
    starts: Vec<u32>,
}

impl Lists<'_> {
    /// Indices of the splats of a tile of the range, front to back.
    pub(crate) fn of(&self, tile: usize) -> &[AtomicU32] {
        let place = tile - self.tiles.start;
        &self.entries[self.starts[place] as usize..self.starts[place + 1] as usize]
    }
}

/// Tile columns and rows of a rectangle of reference tiles.
#[inline(always)]
pub(crate) fn tiles(rect: Rect) -> [Range<usize>; 2] {
    [rect.columns, rect.rows]
        .map(|[first, past]| usize::from(first / RATIO)..usize::from(past.div_ceil(RATIO)))
}

impl<'a> Counted<'a> {
    /// Counts in so many parts; `None` once `stop` is set.
    pub(crate) fn new(
        (grid, wanted): (TileGrid, &'a WantedTiles),
        (order, rects): (&'a [AtomicU64], &'a [Rect]),
        parts: usize,
        stop: &'a AtomicBool,
    ) -> Option<Self> {
        let parts = even(0..order.len(), parts);
        let count = |part: &Range<usize>| {
            if stop.load(Ordering::Relaxed) {
                return None;
            }
            let mut counts = vec![0u32; grid.len()];
            for key in &order[part.clone()] {
                let [columns, rows] = tiles(rects[index(key)]);
                for row in rows {
                    let first = row * grid.columns;
                    let tiles = first + columns.start..first + columns.end;
                    for (count, &wanted) in counts[tiles.clone()].iter_mut().zip(wanted.of(tiles)) {
                        *count += u32::from(wanted);
                    }
                }
            }
            Some(counts)
        };
        let counts = parts
            .par_iter()
            .with_max_len(1)
            .map(count)
            .collect::<Option<_>>()?;
        Some(Self {
            wanted,
            grid,
            order,
            rects,
            parts,
            counts,
            stop,
        })
    }

    /// The tiles from `first` on whose lists are made at once, at least one.
    fn next_tiles(&self, first: usize) -> Range<usize> {
        let most = (self.order.len() * ENTRIES_PER_SPLAT).min(u32::MAX as usize);
        let mut sum = 0;
        let mut past = first;
        while past < self.grid.len() {
            sum += self.counts.iter().map(|part| part[past] as usize).sum::<usize>();
            if sum > most && past > first {
                break;
            }
            past += 1;
        }
        first..past
    }
}

impl Bins {
    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.entries.capacity() * size_of::<AtomicU32>()
    }

    /// Calls `consume` with the lists of all tiles, some at a time, in order, until the picture is cancelled; the
    /// last lists may then be wrong.
    pub(crate) fn for_each(&mut self, mut counted: Counted<'_>, mut consume: impl FnMut(&Lists<'_>)) {
        let mut first = 0;
        while first < counted.grid.len() && !counted.stop.load(Ordering::Relaxed) {
            let tiles = counted.next_tiles(first);
            first = tiles.end;
            let Some(lists) = self.fill(&mut counted, tiles) else {
                return;
            };
            consume(&lists);
        }
    }

    fn fill(&mut self, counted: &mut Counted<'_>, range: Range<usize>) -> Option<Lists<'_>> {
        let sum = starts(&mut counted.counts, range.clone());
        let mut first = vec![0u32; range.len() + 1];
        if let Some(part) = counted.counts.first() {
            first[..range.len()].copy_from_slice(&part[range.clone()]);
        }
        first[range.len()] = sum as u32;
        grow(&mut self.entries, sum, counted.stop)?;
        let (entries, columns) = (&self.entries[..sum], counted.grid.columns);
        let (order, rects) = (counted.order, counted.rects);
        let wanted = counted.wanted;
        let all = range.len() == counted.grid.len() && wanted.are_all();
        let stop = counted.stop;
        counted
            .parts
            .par_iter()
            .zip(&mut counted.counts)
            .with_max_len(1)
            .for_each(|(part, places)| {
                if stop.load(Ordering::Relaxed) {
                    return;
                }
                for key in &order[part.clone()] {
                    let splat = index(key);
                    let [tile_columns, tile_rows] = tiles(rects[splat]);
                    for row in tile_rows {
                        let tiles = row * columns + tile_columns.start..row * columns + tile_columns.end;
                        for (tile, place) in tiles.clone().zip(&mut places[tiles]) {
                            if all || (range.contains(&tile) && wanted.has(tile)) {
                                entries[*place as usize].store(splat as u32, Ordering::Relaxed);
                                *place += 1;
                            }
                        }
                    }
                }
            });
        Some(Lists {
            tiles: range,
            entries,
            starts: first,
        })
    }
}
