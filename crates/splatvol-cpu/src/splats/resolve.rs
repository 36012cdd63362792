//! Resolve: blocks of premultiplied display colours to rows of premultiplied linear colours, depth and optical depth.

use fearless_simd::{f32x16, prelude::*};

use super::bin::TILE;
use super::composite::{Block, LANES};
use super::cover::{BLOCK, BLOCKS};
use crate::simd::math::{linear_from_srgb, log2};

/// Display colour and opacity behind the Gaussians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Background {
    /// Straight.
    pub color: [f32; 3],
    pub alpha: f32,
}

/// Rows of the frame that a tile owns; as many as it has in the picture.
#[derive(Debug, Default)]
pub(crate) struct TileRows<'a> {
    pub pixels: Vec<&'a mut [[f32; 4]]>,
    pub depth: Vec<&'a mut [f32]>,
    pub optical_depth: Vec<&'a mut [f32]>,
}

impl TileRows<'_> {
    /// Blocks of the tile that have pixels in the picture.
    pub(crate) fn blocks(&self) -> u64 {
        let columns = self.pixels.first().map_or(0, |row| row.len()).div_ceil(BLOCK);
        let row = (1u64 << columns) - 1;
        (0..self.pixels.len().div_ceil(BLOCK)).fold(0, |mask, block_row| mask | row << (BLOCKS * block_row))
    }
}

/// A block's pixels as a frame wants them.
struct Resolved {
    color: [[f32; LANES]; 4],
    depth: [f32; LANES],
    optical_depth: [f32; LANES],
}

#[inline(always)]
fn resolve_block<S: Simd>(simd: S, block: &Block, background: &Background) -> Resolved {
    let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
    let through = f32x16::simd_from(simd, block.through).abs();
    let covered = one - through;
    let behind = through * background.alpha;
    let alpha = covered + behind;
    let seen = alpha.simd_gt(zero);
    let inverse = one / seen.select(alpha, one);
    let mut color = [[0.0; LANES]; 4];
    let (sums, unders) = (block.sums.iter(), background.color);
    for (channel, (sum, under)) in color.iter_mut().zip(sums.zip(unders)) {
        let sum = f32x16::simd_from(simd, *sum) + behind * under;
        let linear = linear_from_srgb(simd, sum * inverse) * alpha;
        *channel = seen.select(linear, zero).to_array();
    }
    color[3] = alpha.to_array();
    let touched = covered.simd_gt(zero);
    let depth = f32x16::simd_from(simd, block.sums[3]) / touched.select(covered, one);
    let depth = touched.select(depth, f32x16::splat(simd, f32::INFINITY));
    let optical_depth = log2(simd, through) * -std::f32::consts::LN_2;
    Resolved {
        color,
        depth: depth.to_array(),
        optical_depth: touched.select(optical_depth, zero).to_array(),
    }
}

/// Writes a tile's blocks to its rows.
#[inline(always)]
pub(crate) fn resolve<S: Simd>(
    simd: S,
    blocks: &[Block; BLOCKS * BLOCKS],
    background: &Background,
    rows: &mut TileRows<'_>,
) {
    for (index, block) in blocks.iter().enumerate() {
        let (left, top) = (BLOCK * (index % BLOCKS), BLOCK * (index / BLOCKS));
        if top >= rows.pixels.len() || left >= rows.pixels[top].len() {
            continue;
        }
        let resolved = resolve_block(simd, block, background);
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

/// Writes the background, display colour over nothing, where a tile has no splats.
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

/// The frame's rows, tile by tile.
pub(crate) fn tile_rows(frame: &mut splatvol_scene::Frame, columns: usize, rows: usize) -> Vec<TileRows<'_>> {
    let width = frame.image.size().width() as usize;
    let mut tiles: Vec<TileRows<'_>> = (0..columns * rows)
        .map(|_| TileRows {
            pixels: Vec::with_capacity(TILE),
            depth: Vec::with_capacity(TILE),
            optical_depth: Vec::with_capacity(TILE),
        })
        .collect();
    let lines = frame
        .image
        .pixels
        .chunks_mut(width)
        .zip(frame.depth.chunks_mut(width));
    for (y, ((pixels, depth), optical_depth)) in lines.zip(frame.optical_depth.chunks_mut(width)).enumerate()
    {
        let band = &mut tiles[y / TILE * columns..][..columns];
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
