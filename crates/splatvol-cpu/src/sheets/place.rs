//! Where a tile lies on a zone's raster, and how far footprints reach there.

use splatvol_core::bin::TileRect;

use super::plane::HALO;
use super::ring::BLOCK_EDGE;
use super::sheet::SheetShape;
use super::splat::{MAX_BLOCKS, SIZES};
use super::upsample::RASTER_HALO;

/// How far a voxel's footprints reach around that of its middle sheet, raster points.
pub(crate) fn room_of(shape: &SheetShape, cut: f32, [spread, factor]: [f32; 2]) -> [f32; 2] {
    shape
        .half_extent(cut)
        .map(|half| (half + spread * shape.scale) * factor)
}

/// Blocks along the edge of footprints that reach so far, raster points. What lies in the outermost twentieth of the
/// reach, less than a hundredth of the peak, may be left out where a footprint lies unfavourably.
pub(crate) fn blocks_of([x, y]: [f32; 2]) -> usize {
    let points = (1.88 * x.max(y)).floor() as usize + 1;
    let blocks = (points + 1).div_ceil(2);
    SIZES
        .into_iter()
        .find(|&size| size >= blocks)
        .unwrap_or(MAX_BLOCKS)
}

/// Whether the largest blocks hold footprints that reach so far.
pub(crate) fn fit_blocks([x, y]: [f32; 2]) -> bool {
    1.88 * x.max(y) < (2 * MAX_BLOCKS - 1) as f32
}

/// How far from a footprint's centre pixels change that it touches with any of its blocks, or whose spline or gradient
/// it touches, for footprints that reach so far, raster points.
pub(crate) fn pixel_reach(half_extent: [f32; 2], step: usize) -> f32 {
    // Blocks begin at even points: up to a point and a half off the middle. A quarter is for rounding.
    let blocks = blocks_of(half_extent) as f32 + 0.75;
    let spline = if step > 1 { 2.0 } else { 0.0 };
    (blocks + spline) * step as f32 + 1.0
}

/// Raster points around a tile that its pixels need.
fn halo(step: usize) -> usize {
    if step == 1 { HALO } else { RASTER_HALO }
}

/// Where a tile lies.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    pub rect: TileRect,
    /// Pixels.
    pub size: [usize; 2],
    /// Raster points of a sheet, those around the tile included.
    pub raster: [usize; 2],
    /// Raster points around the tile that its pixels need.
    pub halo: usize,
    /// First raster point of the tile, an even one.
    pub first: [i32; 2],
    /// Pixels from there to the tile's first.
    pub phase: [usize; 2],
}

impl Place {
    /// A tile's place on a raster with a point every `step` pixels.
    pub(crate) fn new(rect: TileRect, step: usize) -> Self {
        let size = [rect.x1 - rect.x0, rect.y1 - rect.y0];
        let halo = halo(step);
        let blocks = [rect.x0, rect.y0].map(|first| first / (BLOCK_EDGE * step));
        let phase = [rect.x0, rect.y0].map(|first| first % (BLOCK_EDGE * step));
        let points = |a: usize| (phase[a] + size[a]).div_ceil(step);
        Self {
            rect,
            size,
            raster: [points(0) + 2 * halo, points(1) + 2 * halo],
            halo,
            first: blocks.map(|block| (BLOCK_EDGE * block) as i32),
            phase,
        }
    }

    /// First raster point of the tile's ring, and the ring's blocks that its pixels need: first and one behind the last, by axis.
    pub(crate) fn ring(&self) -> ([i32; 2], [[usize; 2]; 2]) {
        let apron = (BLOCK_EDGE * MAX_BLOCKS + self.halo) as i32;
        let blocks = self
            .raster
            .map(|points| [MAX_BLOCKS, MAX_BLOCKS + points.div_ceil(BLOCK_EDGE)]);
        (self.first.map(|first| first - apron), blocks)
    }

    /// Blocks of the ring that this rectangle of the picture covers: first and last, x and y.
    pub(crate) fn blocks(&self, [x0, y0, x1, y1]: [f32; 4], step: usize) -> [u8; 4] {
        let block = |pixel: f32, first: usize| {
            let points = (pixel - first as f32) / step as f32 + self.halo as f32;
            (points / BLOCK_EDGE as f32 + MAX_BLOCKS as f32).clamp(0.0, 127.0) as u8
        };
        let (x, y) = (self.rect.x0 - self.phase[0], self.rect.y0 - self.phase[1]);
        [block(x0, x), block(y0, y), block(x1, x), block(y1, y)]
    }
}
