//! Blocks: pictures of volumes that are read in chunks, within a budget of bytes ([`splatvol_core::chunk_memory`]): [`PIXEL`] per
//! pixel and the tile of each thread, [`BRICK`] per brick that a block may show.
//!
//! The picture is drawn block by block, each of whole tiles, as few as the plan allows. Tiles next to each other follow
//! each other, so that chunks they share are still there. Neither blocks nor memory change a pixel: a brick has the same
//! place among those that a tile opens, and the same coefficients, whenever it is solved.

use std::borrow::Cow;

use splatvol_core::bin::{TileGrid, TileRect};
use splatvol_core::chunk_memory::ChunkMemory;
use splatvol_core::level::Level;
use splatvol_core::plan::{GridView, Reach};
use splatvol_scene::{ImageSize, SceneError};

use crate::run::Run;

/// Bytes of a pixel: frame, tile, the frame of a coarser level, codes of the file.
const PIXEL: u64 = 24 + 24 + 24 + 8;
/// Bytes of a brick in the plan of a block.
const BRICK: u64 = 160;
/// Bytes of a pixel of a thread's tile, and pixels around the tile, in all its buffers.
const TILE: (u64, u64) = (80, 96);

/// A block of whole tiles.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Block {
    pub rect: TileRect,
    /// Whether it is the first of its picture.
    pub is_first: bool,
}

impl Block {
    /// The tiles of a block, neighbours near each other.
    pub(crate) fn tiles(&self, grid: &TileGrid) -> Vec<u32> {
        let inside = |tile: &u32| {
            let rect = grid.rect(*tile as usize);
            let own = &self.rect;
            rect.x0 >= own.x0 && rect.x1 <= own.x1 && rect.y0 >= own.y0 && rect.y1 <= own.y1
        };
        let mut tiles: Vec<u32> = (0..grid.len() as u32).filter(inside).collect();
        let along_curve = |tile: &u32| {
            let (x, y) = (*tile as usize % grid.columns, *tile as usize / grid.columns);
            (0..usize::BITS / 2).fold(0usize, |code, bit| {
                code | (x >> bit & 1) << (2 * bit) | (y >> bit & 1) << (2 * bit + 1)
            })
        };
        tiles.sort_by_key(along_curve);
        tiles
    }
}

/// Bytes of a picture's pixels, and of each thread's tile.
pub(crate) fn picture_bytes(held: &TileRect, threads: usize, tile_edge: usize) -> u64 {
    let edge = tile_edge as u64 + TILE.1;
    let [width, height] = held.sides().map(|side| side as u64);
    width * height * PIXEL + threads as u64 * edge * edge * TILE.0
}

/// Blocks along each axis.
fn divisions((memory, level): (&ChunkMemory, &Level), tiles: &TileGrid) -> usize {
    let bytes = level.field.candidates() as u64 * BRICK;
    let most = tiles.columns.max(tiles.rows).max(1);
    // Blocks overlap, and some show more than others.
    (1..most)
        .find(|&n| bytes / (n * n) as u64 * if n > 1 { 2 } else { 1 } <= memory.plan())
        .unwrap_or(most)
}

/// The blocks of a picture; one, the whole, where no volume is read in chunks. Each level gets its memory.
///
/// # Errors
/// Memory that is used otherwise.
pub(crate) fn of_picture(
    chunked: &[(&ChunkMemory, &Level)],
    size: ImageSize,
    run: &Run<'_>,
    tile_edge: usize,
) -> Result<Cow<'static, [Option<Block>]>, SceneError> {
    let lazy = chunked.iter().filter(|(_, level)| level.field.is_lazy());
    let tiles = TileGrid::new(size, tile_edge);
    for (memory, level) in chunked {
        memory.give(level)?;
    }
    let Some(divisions) = lazy.map(|&of| divisions(of, &tiles)).max() else {
        // Nothing is allocated here: viewers render frame after frame.
        return Ok(Cow::Borrowed(&[None]));
    };
    let (whole, held) = (TileRect::of(size), run.task.held(size));
    let part = run.task.part.map_or(held, |part| part.overlap(&held));
    let ends = |count: usize, i: usize| i * count.div_ceil(divisions) * tile_edge;
    let mut blocks = Vec::new();
    for row in 0..divisions {
        for column in 0..divisions {
            // The part of the block that is wanted, out to the ends of its tiles.
            let low = |end: usize, part: usize| end.max(part / tile_edge * tile_edge);
            let high = |end: usize, part: usize, size: usize| {
                end.min(part.div_ceil(tile_edge).saturating_mul(tile_edge))
                    .min(size)
            };
            let rect = TileRect {
                x0: low(ends(tiles.columns, column), part.x0),
                y0: low(ends(tiles.rows, row), part.y0),
                x1: high(ends(tiles.columns, column + 1), part.x1, whole.x1),
                y1: high(ends(tiles.rows, row + 1), part.y1, whole.y1),
            };
            if rect.x0 < rect.x1 && rect.y0 < rect.y1 {
                blocks.push(Some(Block {
                    rect,
                    is_first: blocks.is_empty(),
                }));
            }
        }
    }
    Ok(Cow::Owned(blocks))
}

/// Leaves the bricks of a level that a block can show.
pub(crate) fn restrict(level: &mut Level, view: &GridView, block: Option<Block>) {
    if let Some(block) = block.filter(|_| level.field.is_lazy()) {
        let reach = Reach::new(view, block.rect);
        level.restrict(&|first| reach.meets(first));
    }
}
