//! Resolve: blocks to rows of premultiplied linear colours, depth and optical depth.

use fearless_simd::prelude::*;

use splatvol_core::bin::{TileGrid, TileRect};
use splatvol_scene::Frame;

use super::blend::Blend;
use super::composite::{Block, LANES};
use super::cover::{BLOCK, BLOCKS, TILE};

/// Rows of the frame that a tile owns; as many as it has in the picture.
#[derive(Debug, Default)]
pub(crate) struct TileRows<'a> {
    pub pixels: Vec<&'a mut [[f32; 4]]>,
    pub depth: Vec<&'a mut [f32]>,
    pub optical_depth: Vec<&'a mut [f32]>,
}

impl TileRows<'_> {
    /// The tile's pixels, row by row.
    pub(crate) fn colors(&self) -> Vec<[f32; 4]> {
        self.pixels.iter().flat_map(|row| row.iter().copied()).collect()
    }

    /// Blocks of the tile that have pixels in the picture.
    pub(crate) fn blocks(&self) -> u64 {
        let columns = self.pixels.first().map_or(0, |row| row.len()).div_ceil(BLOCK);
        let row = (1u64 << columns) - 1;
        (0..self.pixels.len().div_ceil(BLOCK)).fold(0, |mask, block_row| mask | row << (BLOCKS * block_row))
    }
}

/// A block's pixels in the form that a frame stores.
pub(crate) struct Resolved {
    /// Linear, premultiplied.
    pub color: [[f32; LANES]; 4],
    pub depth: [f32; LANES],
    pub optical_depth: [f32; LANES],
}

/// Writes a tile's blocks to its rows.
#[inline(always)]
pub(crate) fn resolve<S: Simd>(
    simd: S,
    blend: impl Blend,
    blocks: &[Block; BLOCKS * BLOCKS],
    rows: &mut TileRows<'_>,
) {
    for (index, block) in blocks.iter().enumerate() {
        let (left, top) = (BLOCK * (index % BLOCKS), BLOCK * (index / BLOCKS));
        if top >= rows.pixels.len() || left >= rows.pixels[top].len() {
            continue;
        }
        let resolved = blend.resolve(simd, block);
        for y in 0..BLOCK.min(rows.pixels.len() - top) {
            let width = BLOCK.min(rows.pixels[top + y].len() - left);
            let (target, source) = (left..left + width, BLOCK * y..BLOCK * y + width);
            let [r, g, b, a] = &resolved.color;
            for (pixel, lane) in rows.pixels[top + y][target.clone()]
                .iter_mut()
                .zip(source.clone())
            {
                *pixel = [r[lane], g[lane], b[lane], a[lane]];
            }
            rows.depth[top + y][target.clone()].copy_from_slice(&resolved.depth[source.clone()]);
            rows.optical_depth[top + y][target].copy_from_slice(&resolved.optical_depth[source]);
        }
    }
}

/// Fills a tile without splats with one pixel.
pub(crate) fn fill(pixel: [f32; 4], rows: &mut TileRows<'_>) {
    for row in &mut rows.pixels {
        row.fill(pixel);
    }
    for row in &mut rows.depth {
        row.fill(f32::INFINITY);
    }
    for row in &mut rows.optical_depth {
        row.fill(0.0);
    }
}

/// The frame's rows, tile by tile; none of tiles outside the pixels that it holds, which begin with a tile.
pub(crate) fn tile_rows<'a>(frame: &'a mut Frame, held: &TileRect, grid: &TileGrid) -> Vec<TileRows<'a>> {
    let width = frame.image.size().width() as usize;
    let [columns, rows] = grid.tiles_of(held);
    let mut tiles: Vec<TileRows<'_>> = (0..grid.len()).map(|_| TileRows::default()).collect();
    for row in rows.clone() {
        for tile in &mut tiles[row * grid.columns..][columns.clone()] {
            tile.pixels.reserve_exact(TILE);
            tile.depth.reserve_exact(TILE);
            tile.optical_depth.reserve_exact(TILE);
        }
    }
    let lines = frame
        .image
        .pixels
        .chunks_mut(width)
        .zip(frame.depth.chunks_mut(width));
    for (y, ((pixels, depth), optical_depth)) in lines.zip(frame.optical_depth.chunks_mut(width)).enumerate()
    {
        let band = &mut tiles[(rows.start + y / TILE) * grid.columns..][columns.clone()];
        let pieces = pixels.chunks_mut(TILE).zip(depth.chunks_mut(TILE));
        for (tile, ((pixels, depth), optical_depth)) in
            band.iter_mut().zip(pieces.zip(optical_depth.chunks_mut(TILE)))
        {
            tile.pixels.push(pixels);
            tile.depth.push(depth);
            tile.optical_depth.push(optical_depth);
        }
    }
    tiles
}
