//! Tiles of a picture, and lists of the bricks (or chunks of a cloud) that each may show, front to back.

use std::ops::Range;

use splatvol_scene::{ImageSize, SceneError};

use crate::brick::ActiveBrick;

/// The tiles of a picture, row by row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TileGrid {
    /// Edge of a tile, pixels.
    pub edge: usize,
    /// Tiles per row.
    pub columns: usize,
    /// Rows of tiles.
    pub rows: usize,
    size: ImageSize,
}

/// A tile's pixels: x0 to x1 and y0 to y1, ends excluded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TileRect {
    /// First column.
    pub x0: usize,
    /// First row.
    pub y0: usize,
    /// Column after the last.
    pub x1: usize,
    /// Row after the last.
    pub y1: usize,
}

impl TileRect {
    /// All pixels of a picture.
    pub fn of(size: ImageSize) -> Self {
        let [x1, y1] = <[u32; 2]>::from(size).map(|side| side as usize);
        Self { x0: 0, y0: 0, x1, y1 }
    }

    /// Columns and rows.
    pub fn sides(&self) -> [usize; 2] {
        [self.x1.saturating_sub(self.x0), self.y1.saturating_sub(self.y0)]
    }

    /// Its size as a picture of its own.
    ///
    /// # Errors
    /// A rectangle without pixels, or too large for a picture.
    pub fn size(&self) -> Result<ImageSize, SceneError> {
        let [width, height] = self.sides().map(|side| u32::try_from(side).unwrap_or(u32::MAX));
        ImageSize::new(width, height)
    }

    /// Whether two rectangles have a pixel in common.
    pub fn meets(&self, other: &Self) -> bool {
        self.x0 < other.x1 && other.x0 < self.x1 && self.y0 < other.y1 && other.y0 < self.y1
    }

    /// The pixels that both have; none if they do not meet.
    #[must_use]
    pub fn overlap(&self, other: &Self) -> Self {
        Self {
            x0: self.x0.max(other.x0),
            y0: self.y0.max(other.y0),
            x1: self.x1.min(other.x1),
            y1: self.y1.min(other.y1),
        }
    }
}

impl TileGrid {
    /// Divides a picture.
    pub fn new(size: ImageSize, edge: usize) -> Self {
        let tiles = |pixels: u32| (pixels as usize).div_ceil(edge);
        Self {
            edge,
            columns: tiles(size.width()),
            rows: tiles(size.height()),
            size,
        }
    }

    /// Number of tiles.
    pub fn len(&self) -> usize {
        self.columns * self.rows
    }

    /// True for a grid without tiles (none exists: pictures are not empty).
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Size of the picture.
    pub fn picture(&self) -> ImageSize {
        self.size
    }

    /// Columns and rows of the picture's pixels.
    pub fn size(&self) -> [usize; 2] {
        [self.size.width(), self.size.height()].map(|side| side as usize)
    }

    /// Columns and rows of tiles that have pixels of a rectangle.
    pub fn tiles_of(&self, rect: &TileRect) -> [Range<usize>; 2] {
        let of = |from: usize, to: usize, count: usize| from / self.edge..to.div_ceil(self.edge).min(count);
        [
            of(rect.x0, rect.x1, self.columns),
            of(rect.y0, rect.y1, self.rows),
        ]
    }

    /// Pixels of a tile.
    pub fn rect(&self, tile: usize) -> TileRect {
        let (x0, y0) = (tile % self.columns * self.edge, tile / self.columns * self.edge);
        TileRect {
            x0,
            y0,
            x1: (x0 + self.edge).min(self.size.width() as usize),
            y1: (y0 + self.edge).min(self.size.height() as usize),
        }
    }
}

/// A brick projected to the screen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProjectedBrick {
    /// Which brick, and which of its blocks.
    pub active: ActiveBrick,
    /// First sheet within its reach.
    pub front_sheet: u32,
    /// Bounds of the pixels that it can touch: x0, y0, x1, y1, ends included.
    pub rect: [f32; 4],
}

/// Bricks per tile, by front sheet, then by brick.
#[derive(Debug, Clone, Default)]
pub struct TileLists {
    offsets: Vec<u32>,
    entries: Vec<u32>,
    next: Vec<u32>,
    /// Projected bricks, by front sheet, then by brick; the lists' entries are indices of these.
    pub bricks: Vec<ProjectedBrick>,
    /// Tiles, sorted by descending number of bricks.
    longest_first: Vec<u32>,
}

impl TileLists {
    /// Sorts projected bricks into tiles.
    pub fn new(bricks: Vec<ProjectedBrick>, tiles: &TileGrid) -> Self {
        let mut lists = Self::default();
        lists.fill(bricks, tiles);
        lists
    }

    /// As [`Self::new`], in existing memory.
    pub fn fill(&mut self, bricks: impl IntoIterator<Item = ProjectedBrick>, tiles: &TileGrid) {
        let Self {
            offsets,
            entries,
            next,
            bricks: sorted,
            longest_first,
        } = self;
        sorted.clear();
        sorted.extend(bricks);
        sorted.sort_unstable_by_key(|b| (b.front_sheet, b.active.brick));
        offsets.clear();
        offsets.resize(tiles.len() + 1, 0);
        for brick in &*sorted {
            for_each_tile(&brick.rect, tiles, |tile| offsets[tile + 1] += 1);
        }
        for tile in 0..tiles.len() {
            offsets[tile + 1] += offsets[tile];
        }
        next.clear();
        next.extend_from_slice(offsets);
        entries.clear();
        let count = offsets[tiles.len()] as usize;
        if entries.capacity() < count {
            // The next frame has a few more or fewer.
            entries.reserve(count + count / 4);
        }
        entries.resize(count, 0);
        for (index, brick) in sorted.iter().enumerate() {
            for_each_tile(&brick.rect, tiles, |tile| {
                entries[next[tile] as usize] = index as u32;
                next[tile] += 1;
            });
        }
        longest_first.clear();
        longest_first.extend(0..tiles.len() as u32);
        longest_first.sort_unstable_by_key(|&tile| {
            let bricks = offsets[tile as usize + 1] - offsets[tile as usize];
            (std::cmp::Reverse(bricks), tile)
        });
    }

    /// All tiles, sorted by descending number of bricks: in this order threads finish at nearly the same time.
    pub fn longest_first(&self) -> &[u32] {
        &self.longest_first
    }

    /// The n-th brick of a tile, front to back.
    pub fn brick(&self, tile: usize, n: usize) -> Option<&ProjectedBrick> {
        let range = self.offsets[tile] as usize..self.offsets[tile + 1] as usize;
        let index = *self.entries[range].get(n)?;
        Some(&self.bricks[index as usize])
    }

    /// Bricks of a tile, front to back.
    pub fn of(&self, tile: usize) -> impl ExactSizeIterator<Item = &ProjectedBrick> + Clone {
        let range = self.offsets[tile] as usize..self.offsets[tile + 1] as usize;
        self.entries[range]
            .iter()
            .map(|&index| &self.bricks[index as usize])
    }
}

fn for_each_tile(rect: &[f32; 4], tiles: &TileGrid, mut visit: impl FnMut(usize)) {
    let index = |pixel: f32, count: usize| (pixel.max(0.0) as usize / tiles.edge).min(count - 1);
    let [x0, y0, x1, y1] = *rect;
    if x1 < 0.0 || y1 < 0.0 || x0 >= tiles.size.width() as f32 || y0 >= tiles.size.height() as f32 {
        return;
    }
    for row in index(y0, tiles.rows)..=index(y1, tiles.rows) {
        for column in index(x0, tiles.columns)..=index(x1, tiles.columns) {
            visit(row * tiles.columns + column);
        }
    }
}
