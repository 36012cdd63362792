//! Place: position of a tile on a zone's raster.

use glam::DVec2;
use splatvol_core::bin::TileRect;
use splatvol_core::plan::MAX_BLOCKS;

use super::plane::HALO;
use super::ring::BLOCK_EDGE;
use super::upsample::RASTER_HALO;

/// Raster points around a tile that its pixels need.
fn halo(step: usize) -> usize {
    if step == 1 { HALO } else { RASTER_HALO }
}

/// Position of a tile.
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

    /// Image coordinates of the tile's middle.
    pub(crate) fn middle(&self) -> DVec2 {
        let rect = &self.rect;
        DVec2::new((rect.x0 + rect.x1) as f64, (rect.y0 + rect.y1) as f64) * 0.5
    }

    /// First raster point of the tile's ring, and the ring's blocks that its pixels need: first and one behind the
    /// last, by axis.
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
