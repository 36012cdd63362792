//! Splat: adds a splat to the four planes that it meets next, with an exponential of its own for each block of 2 x
//! 2 pixels.
//!
//! Pixels' offsets are counted from the picture's corner, so that a pixel's sums do not depend on the tile, and a
//! footprint is clipped to the tile's blocks. Powers by recurrence, as for grids, would save little: with four
//! channels the stores are the bottleneck, and for long thin ellipses the powers overflow.

use fearless_simd::{f32x16, prelude::*};
use splatvol_core::cloud_planes::DEPTH_EDGE;
use splatvol_core::plan::SheetShape;

use super::open::OpenSplat;
use crate::sheets::frame::SheetFrame;
use crate::sheets::place::Place;
use crate::sheets::ring::{Area, BLOCK_EDGE, LANES, Row};
use crate::sheets::sheet::Lanes16;
use crate::simd::math::exp2_quick;

/// Position of a tile's ring in the picture.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Footing {
    /// Image coordinates of the principal point, from the middle of the picture's first pixel.
    pub principal: [f32; 2],
    /// Image coordinates of the first pixel of the ring's first block.
    pub first: [i32; 2],
    /// Blocks that the tile needs: first and one behind the last, by axis.
    pub blocks: [[usize; 2]; 2],
}

/// Four planes of a tile.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FourPlanes {
    /// Camera depth, plane by plane.
    depth: Lanes16,
    /// World length per pixel.
    per_pixel: Lanes16,
    /// One for existing planes, else zero.
    exists: Lanes16,
    /// Depths of the nearest and the farthest, and pixels per world length there.
    pub ends: [[f32; 2]; 2],
    pub footing: Footing,
}

/// Blocks of the ring, ends included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Blocks {
    pub x: [usize; 2],
    pub y: [usize; 2],
}

/// Each lane's column and row in a block.
const COLUMN: [f32; 16] = [
    0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0,
];
const ROW: [f32; 16] = [
    0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0,
];
/// Least exponent for which [`exp2_quick`] is right.
const LEAST: f32 = -126.0;

#[inline(always)]
fn load<S: Simd>(simd: S, lanes: &Lanes16) -> f32x16<S> {
    f32x16::from_slice(simd, &lanes.0)
}

impl Blocks {
    /// First and last, x and y, of these and so many around them.
    #[inline(always)]
    pub(crate) fn corners_around(&self, halo: u8) -> [u8; 4] {
        let [x0, y0, x1, y1] = [self.x[0], self.y[0], self.x[1], self.y[1]].map(|block| block as u8);
        [
            x0.saturating_sub(halo),
            y0.saturating_sub(halo),
            x1 + halo,
            y1 + halo,
        ]
    }

    pub(crate) fn area(&self) -> Area {
        Area {
            x0: self.x[0],
            y0: self.y[0],
            x1: self.x[1] + 1,
            y1: self.y[1] + 1,
        }
    }
}

impl Place {
    /// Position of this tile's ring, with a raster point per pixel.
    pub(crate) fn footing(&self, principal: [f32; 2]) -> Footing {
        let (first, blocks) = self.ring();
        Footing {
            principal,
            first,
            blocks,
        }
    }
}

impl Footing {
    /// The blocks of the tile that a splat reaches on planes between two depths, given with pixels per world length
    /// there.
    #[inline(always)]
    pub(crate) fn blocks_of(&self, splat: &OpenSplat, ends: [[f32; 2]; 2]) -> Option<Blocks> {
        Some(Blocks {
            x: self.blocks_along(0, splat, ends)?,
            y: self.blocks_along(1, splat, ends)?,
        })
    }

    #[inline(always)]
    fn blocks_along(&self, axis: usize, splat: &OpenSplat, ends: [[f32; 2]; 2]) -> Option<[usize; 2]> {
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for [depth, scale] in ends {
            // The splat ends at its reach.
            let from_centre = (depth - splat.centre[2]).clamp(-splat.reach, splat.reach);
            let centre = splat.centre[axis] + splat.slope[axis] * from_centre;
            let half = splat.half_extent[axis] * scale;
            let middle = centre * scale + self.principal[axis];
            (low, high) = (low.min(middle - half), high.max(middle + half));
        }
        // Whole blocks from the picture's corner first: rounding must not depend on the tile.
        let ring = self.first[axis] as f32 / BLOCK_EDGE as f32;
        let block = |pixel: f32| (pixel * (1.0 / BLOCK_EDGE as f32)).floor() - ring;
        let [first, end] = self.blocks[axis];
        let from = block(low).max(first as f32);
        let to = block(high).min((end - 1) as f32);
        (from <= to).then_some([from as usize, to as usize])
    }
}

impl FourPlanes {
    /// The four planes from this one on.
    pub(crate) fn new(frame: &SheetFrame<'_>, place: &Place, first: usize) -> Self {
        let sheet = |lane: usize| {
            let plane = plane_of_lane(first, lane);
            (
                frame.sheets[plane.min(frame.sheets.len() - 1)],
                plane < frame.sheets.len(),
            )
        };
        let of = |value: &dyn Fn((SheetShape, bool)) -> f32| {
            Lanes16(std::array::from_fn(|lane| value(sheet(lane % LANES))))
        };
        let end = |plane: usize| {
            let sheet = frame.sheets[plane.min(frame.sheets.len() - 1)];
            [sheet.depth, sheet.scale]
        };
        Self {
            depth: of(&|(sheet, _)| sheet.depth),
            per_pixel: of(&|(sheet, _)| 1.0 / sheet.scale),
            exists: of(&|(_, exists)| if exists { 1.0 } else { 0.0 }),
            ends: [end(first), end(first + LANES - 1)],
            footing: place.footing(frame.principal()),
        }
    }

    /// Adds a splat's footprints to N rings.
    #[inline(always)]
    pub(crate) fn add<S: Simd, const N: usize>(
        &self,
        simd: S,
        (splat, payload): (&OpenSplat, [f32; N]),
        blocks: Blocks,
        rings: &mut [&mut [Row]; N],
    ) {
        let from_centre = load(simd, &self.depth) - splat.centre[2];
        let profile = exp2_quick(
            simd,
            (from_centre * from_centre * splat.depth_exponent).max(f32x16::splat(simd, LEAST)),
        ) - DEPTH_EDGE;
        let profile = profile.max(f32x16::splat(simd, 0.0)) * load(simd, &self.exists);
        let weights = payload.map(|value| profile * value);
        let per_pixel = load(simd, &self.per_pixel);
        // World offset of the footprint's centre from the picture's first column and row.
        let origin = |axis: usize, lanes: &[f32; 16]| {
            let own = from_centre * splat.slope[axis] + splat.centre[axis];
            (f32x16::from_slice(simd, lanes) - self.footing.principal[axis]) * per_pixel - own
        };
        let (origin_x, origin_y) = (origin(0, &COLUMN), origin(1, &ROW));
        let [xx, xy, yy] = splat.exponent;
        let pixel =
            |axis: usize, block: usize| (self.footing.first[axis] + (BLOCK_EDGE * block) as i32) as f32;
        for row in blocks.y[0]..=blocks.y[1] {
            let dy = per_pixel * pixel(1, row) + origin_y;
            let (down, across) = (dy * dy * yy, dy * xy);
            for column in blocks.x[0]..=blocks.x[1] {
                let dx = per_pixel * pixel(0, column) + origin_x;
                let exponent = (dx * xx + across) * dx + down;
                let footprint = exp2_quick(simd, exponent.max(f32x16::splat(simd, LEAST)));
                for channel in 0..N {
                    let Some(block) = rings[channel].get_mut(row).and_then(|row| row.0.get_mut(column))
                    else {
                        continue;
                    };
                    (footprint * weights[channel] + f32x16::from_slice(simd, &block.0))
                        .store_slice(&mut block.0);
                }
            }
        }
    }
}

/// The plane that lane l holds, of the four from `first` on.
fn plane_of_lane(first: usize, lane: usize) -> usize {
    first + (lane + LANES - first % LANES) % LANES
}
