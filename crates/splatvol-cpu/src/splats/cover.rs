//! Cover: which 4 x 4-pixel blocks of a tile a splat may change, for sixteen splats at a time.
//!
//! In the ellipse `d^T V^-1 d <= r^2` a row at `dy` reaches from `shear dy - w` to `shear dy + w`,
//! `w = w_0 sqrt(1 - (dy / h)^2)`. The right end is a concave function of `dy`. So over a band of rows it is
//! farthest at the row of the ellipse's rightmost point or, if that lies outside the band, at the band's row next
//! to it.

use fearless_simd::{f32x16, prelude::*, u32x16};

use super::blend::Blend;
use super::project::{ProjectedSplat, Rect};
use super::view::REFERENCE_TILE;

/// Splats that are tested at once.
pub(crate) const BATCH: usize = 16;
/// Pixels along an edge of a tile.
pub(crate) const TILE: usize = 32;
/// Pixels along an edge of a block.
pub(crate) const BLOCK: usize = 4;
/// Blocks along an edge of a tile.
pub(crate) const BLOCKS: usize = TILE / BLOCK;
/// Margin for rounding of an ellipse, pixels.
const SLACK: f32 = 0.02;

/// Masks of blocks, bit `8 row + column`, of the splats in `batch`.
#[inline(always)]
pub(crate) fn cover<S: Simd>(
    simd: S,
    blend: impl Blend,
    batch: &[ProjectedSplat; BATCH],
    tile: [usize; 2],
    masks: &mut [u64; BATCH],
) {
    let mut soa = [[0.0; BATCH]; 8];
    for (lane, splat) in batch.iter().enumerate() {
        let values = [
            splat.centre[0],
            splat.centre[1],
            splat.conic[0],
            splat.conic[1],
            splat.conic[2],
            splat.peak,
            splat.reach[0],
            splat.reach[1],
        ];
        for (column, value) in soa.iter_mut().zip(values) {
            column[lane] = value;
        }
    }
    let mut vectors = [f32x16::splat(simd, 0.0); 8];
    for k in 0..8 {
        vectors[k] = f32x16::simd_from(simd, soa[k]);
    }
    let [x, y, a, b, c, peak, width, height] = vectors;
    let (x, y) = (x - (tile[0] * TILE) as f32, y - (tile[1] * TILE) as f32);
    let half_width = (blend.end(simd, peak) / (-a)).sqrt();
    let shear = b * -0.5 / a;
    let rightmost = b * -0.5 / c * width;
    let leftmost = -rightmost;
    let inverse_height = f32x16::splat(simd, 1.0) / (height + SLACK);
    let zero = f32x16::splat(simd, 0.0);
    let edge = f32x16::splat(simd, BLOCKS as f32);
    let one = u32x16::splat(simd, 1);
    let mut halves = [u32x16::splat(simd, 0); 2];
    for row in 0..BLOCKS {
        let first = -y + ((BLOCK * row) as f32 + 0.5);
        let last = first + (BLOCK as f32 - 1.0);
        let right_at = rightmost.max(first).min(last);
        let left_at = leftmost.max(first).min(last);
        let right_share = left_over(simd, right_at * inverse_height);
        let left_share = left_over(simd, left_at * inverse_height);
        let right = x + shear * right_at + half_width * right_share.max(zero).sqrt();
        let left = x + shear * left_at - half_width * left_share.max(zero).sqrt();
        // Blocks whose pixel centres reach beyond `left`, and those whose begin before `right`.
        let first = ((left - (BLOCK as f32 - 0.5 + SLACK)) * (1.0 / BLOCK as f32)).ceil();
        let past = ((right + (SLACK - 0.5)) * (1.0 / BLOCK as f32)).floor() + 1.0;
        let past: u32x16<S> = past.max(zero).min(edge).to_int();
        let first: u32x16<S> = first.max(zero).min(edge).to_int();
        let bits = ((one << past) - one) & !((one << first) - one);
        let inside = right_share.max(left_share).simd_ge(zero);
        let bits = inside.select(bits, u32x16::splat(simd, 0));
        halves[row / 4] |= bits << (8 * (row as u32 % 4));
    }
    let (low, high) = (halves[0].to_array(), halves[1].to_array());
    for (lane, mask) in masks.iter_mut().enumerate() {
        let ellipse = u64::from(low[lane]) | u64::from(high[lane]) << 32;
        *mask = ellipse & clip(batch[lane].rect, tile);
    }
}

/// `1 - x^2`.
#[inline(always)]
fn left_over<S: Simd>(simd: S, x: f32x16<S>) -> f32x16<S> {
    f32x16::splat(simd, 1.0) - x * x
}

/// Blocks of a tile within a splat's reference tiles.
#[inline(always)]
fn clip(rect: Rect, tile: [usize; 2]) -> u64 {
    const HALF: usize = TILE / REFERENCE_TILE as usize;
    const ROW: u64 = 0x0101_0101_0101_0101;
    let columns = pick(rect.columns, HALF * tile[0], [0x0f * ROW, 0xf0 * ROW]);
    columns & pick(rect.rows, HALF * tile[1], [0xffff_ffff, 0xffff_ffff << 32])
}

/// The masks of two reference tiles, from `tile` on, limited to a range.
#[inline(always)]
fn pick([first, past]: [u16; 2], tile: usize, masks: [u64; 2]) -> u64 {
    let mut picked = 0;
    for (half, mask) in masks.into_iter().enumerate() {
        if (usize::from(first)..usize::from(past)).contains(&(tile + half)) {
            picked |= mask;
        }
    }
    picked
}
