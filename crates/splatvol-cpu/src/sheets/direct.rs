//! Direct splatting: an exponential for every weight, without powers.
//!
//! Powers (`splat`) share one square of blocks among all sheets that a voxel meets. They stay within f32 only if
//! the footprint's centre is near that square on each of them. Close to the eye, where scales differ from sheet to
//! sheet, and at wide angles it is not. Then each weight is computed as
//! `2^(xx (i - u)^2 + xy (i - u) (j - v) + yy (j - v)^2)`, in as many blocks as the footprints on all four sheets
//! of a group cover. This takes three to four times as long per block, and works for any size and shape. Points are
//! counted from the picture's corner, so that a pixel's sums do not depend on the tile.

use fearless_simd::{f32x16, prelude::*};
use splatvol_core::plan::{SplatConstants, half_extent};

use super::mask::OpenMask;
use super::place::Place;
use super::records::{CAPACITY, Records};
use super::ring::{Area, BLOCK_EDGE, LANES, Row};
use super::sheet::GroupShape;
use super::splat::{COLUMN, Offset, Payload, ROW, load};
use crate::simd::math::exp2_quick;

/// The four sheets of a group in a tile.
#[derive(Debug)]
pub(crate) struct DirectGroup<'a> {
    constants: &'a SplatConstants,
    shape: &'a GroupShape,
    /// Half widths of footprints along x and y, raster points, sheet by sheet.
    half_extents: [[f32; 2]; LANES],
    /// First raster point of the ring, and the blocks that the tile needs: first and one behind the last, by axis.
    first: [f32; 2],
    blocks: [[usize; 2]; 2],
}

impl<'a> DirectGroup<'a> {
    /// `cut`: standard deviations at which footprints are cut.
    pub(crate) fn new(
        (constants, shape): (&'a SplatConstants, &'a GroupShape),
        place: &Place,
        cut: f32,
    ) -> Self {
        let (first, blocks) = place.ring();
        let GroupShape { xx, xy, yy, .. } = shape;
        Self {
            constants,
            shape,
            half_extents: std::array::from_fn(|l| half_extent([-xx.0[l], -xy.0[l], -yy.0[l]], cut)),
            first: first.map(|first| first as f32),
            blocks,
        }
    }

    /// A record's offset in depth from a sheet, and its footprint's centre there, raster points from the picture's
    /// corner.
    fn centre(&self, records: &Records, n: usize, lane: usize) -> (f32, [f32; 2]) {
        let from = self.shape.depth.0[lane] - records.z[n];
        let [slope_x, slope_y] = self.constants.slope;
        let [px, py] = self.constants.principal;
        let scale = self.shape.scale.0[lane];
        let x = (from * slope_x + records.x[n]) * scale + px;
        let y = (from * slope_y + records.y[n]) * scale + py;
        (from, [x, y])
    }

    /// Blocks of the tile that a record's footprints cover on the sheets that it reaches.
    fn blocks_of(&self, records: &Records, n: usize, reach: f32) -> Option<Area> {
        let (mut low, mut high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
        for lane in 0..LANES {
            let (from, centre) = self.centre(records, n, lane);
            if from.abs() <= reach && self.shape.peak.0[lane] > 0.0 {
                for axis in 0..2 {
                    let half = self.half_extents[lane][axis];
                    low[axis] = low[axis].min(centre[axis] - half);
                    high[axis] = high[axis].max(centre[axis] + half);
                }
            }
        }
        let along = |axis: usize| {
            // Whole blocks from the picture's corner first: rounding must not depend on the tile.
            let ring = self.first[axis] / BLOCK_EDGE as f32;
            let block = |point: f32| (point * (1.0 / BLOCK_EDGE as f32)).floor() - ring;
            let [first, end] = self.blocks[axis].map(|block| block as f32);
            let (from, to) = (block(low[axis]).max(first), (block(high[axis]) + 1.0).min(end));
            (from < to).then_some([from as usize, to as usize])
        };
        let ([x0, x1], [y0, y1]) = (along(0)?, along(1)?);
        Some(Area { x0, y0, x1, y1 })
    }

    /// Splats all records, with the given reach in depth, into the group's sheets of each of N rings, unless
    /// finished pixels hide them; returns the blocks written.
    #[inline(always)]
    pub(crate) fn splat<S: Simd, P: Payload<N>, const N: usize>(
        &self,
        simd: S,
        (records, payload): (&Records, P),
        (reach, mask): (f32, &OpenMask),
        rings: &mut [&mut [Row]; N],
    ) -> Area {
        let Self { shape, constants, .. } = self;
        let (depth, scale) = (load(simd, &shape.depth), load(simd, &shape.scale));
        let (xx, xy, yy) = (
            load(simd, &shape.xx),
            load(simd, &shape.xy),
            load(simd, &shape.yy),
        );
        let peak = load(simd, &shape.peak);
        let columns = f32x16::from_slice(simd, &COLUMN) + self.first[0];
        let rows = f32x16::from_slice(simd, &ROW) + self.first[1];
        let [px, py] = constants.principal;
        let zero = f32x16::splat(simd, 0.0);
        let tiny = f32x16::splat(simd, f32::MIN_POSITIVE);
        // Smaller weights would lead to denormal numbers, which are slow.
        let least = f32x16::splat(simd, -90.0);
        let mut touched = Area::EMPTY;
        for n in 0..records.len.min(CAPACITY) {
            let Some(area) = self.blocks_of(records, n, reach) else {
                continue;
            };
            let corners = [area.x0, area.y0, area.x1 - 1, area.y1 - 1].map(|block| block as u8);
            if mask.any_finished && !mask.any(corners) {
                continue;
            }
            touched = touched.join(area);
            let dz = depth - records.z[n];
            let centre = [
                dz * constants.slope[0] + records.x[n],
                dz * constants.slope[1] + records.y[n],
            ];
            let (u, v) = (centre[0] * scale + px, centre[1] * scale + py);
            let profile = exp2_quick(simd, (dz * dz * constants.depth_exponent).max(least));
            let windowed = (profile - constants.depth_edge).max(zero);
            let along = profile * dz / windowed.max(tiny);
            let weights = payload.weights(simd, records.value[n], windowed, peak);
            for r in area.y0..area.y1 {
                let j = rows + (BLOCK_EDGE * r) as f32 - v;
                let (linear, constant) = (j * xy, j * j * yy);
                for c in area.x0..area.x1 {
                    let i = columns + (BLOCK_EDGE * c) as f32 - u;
                    let share = exp2_quick(simd, ((i * xx + linear) * i + constant).max(least));
                    let offset = Offset {
                        points: [i, j],
                        depth: along,
                        centre,
                        shape,
                        constants,
                    };
                    let own = payload.in_block(simd, &weights, share, &offset);
                    for channel in 0..N {
                        let Some(block) = rings[channel].get_mut(r).and_then(|row| row.0.get_mut(c)) else {
                            continue;
                        };
                        (own[channel] + f32x16::from_slice(simd, &block.0)).store_slice(&mut block.0);
                    }
                }
            }
        }
        touched
    }
}
