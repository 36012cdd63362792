//! Splat: footprint slices into the sheet buffer.
//!
//! `sheet[channel](pixel) += payload[channel] exp(-d^T Q d / 2)` over the box around the cut ellipse; the box, not the
//! ellipse, because what lies between them only adds accuracy, and lanes there are free. Where Q is diagonal the
//! exponential is a product of a row and a column (swan1997's and huang2000's radial kernels); otherwise it is
//! evaluated per pixel. Positions are image coordinates, so weights do not depend on the tile.

use fearless_simd::prelude::*;
use splatvol_core::bin::TileRect;
use splatvol_core::footprint::Slice;

use super::sheet_buffer::{CHANNELS, MAX_EDGE, PITCH, Row, SheetBuffer, Touched};
use super::simd_exp::exp;

/// What a slice adds to each channel, given its weight at some pixels.
pub(crate) trait Payload: Copy {
    /// Adds to the vector of pixels at column `x` of each channel; `dx`, `dy`: offsets from the centre.
    fn add<S: Simd>(self, target: Target<'_, S>, weight: S::f32s, dx: S::f32s, dy: f32);
}

/// A vector of pixels of a row.
pub(crate) struct Target<'a, S> {
    simd: S,
    row: &'a mut Row,
    x: usize,
}

impl<S: Simd> Target<'_, S> {
    #[inline(always)]
    fn accumulate(&mut self, channel: usize, value: S::f32s) {
        let pixels = &mut self.row.0[channel][self.x..self.x + S::f32s::LEN];
        (S::f32s::from_slice(self.simd, pixels) + value).store_slice(pixels);
    }
}

/// Data with its analytic gradient: value, weight, derivatives to screen x, screen y, depth.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DataPayload {
    /// Kernel coefficient.
    pub coefficient: f32,
    /// Conic of the slice; `d weight / d screen = -Q d weight`.
    pub conic: [f32; 3],
    /// `d ln weight / d depth`.
    pub depth_derivative: f32,
}

/// Five numbers that scale with the weight.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ColorPayload(pub [f32; CHANNELS]);

impl Payload for DataPayload {
    #[inline(always)]
    fn add<S: Simd>(self, mut target: Target<'_, S>, weight: S::f32s, dx: S::f32s, dy: f32) {
        let [xx, xy, yy] = self.conic;
        let value = weight * self.coefficient;
        target.accumulate(0, value);
        target.accumulate(1, weight);
        target.accumulate(2, value * (dx * -xx - xy * dy));
        target.accumulate(3, value * (dx * -xy - yy * dy));
        target.accumulate(4, value * self.depth_derivative);
    }
}

impl Payload for ColorPayload {
    #[inline(always)]
    fn add<S: Simd>(self, mut target: Target<'_, S>, weight: S::f32s, _dx: S::f32s, _dy: f32) {
        for (channel, factor) in self.0.into_iter().enumerate() {
            target.accumulate(channel, weight * factor);
        }
    }
}

/// First and last pixel (end excluded) of `low..high` whose centres lie within `reach` of `centre`.
#[inline(always)]
fn pixel_range(centre: f32, reach: f32, low: usize, high: usize) -> (usize, usize) {
    let first = (centre - reach - 0.5).ceil().max(low as f32);
    let last = (centre + reach - 0.5).floor().min(high as f32 - 1.0);
    // Also when a slice is so far away that floats have no such integer: the range is empty.
    if first <= last {
        (first as usize, last as usize + 1)
    } else {
        (low, low)
    }
}

/// Adds a slice to a tile's sheet; true where it touched any pixel.
#[inline(always)]
pub(crate) fn splat<S: Simd, P: Payload>(
    simd: S,
    sheet: &mut SheetBuffer,
    rect: &TileRect,
    slice: &Slice,
    payload: P,
) -> bool {
    let [cx, cy] = slice.centre;
    let [rx, ry] = slice.half_extent;
    let (x0, x1) = pixel_range(cx, rx, rect.x0, rect.x1);
    let (y0, y1) = pixel_range(cy, ry, rect.y0, rect.y1);
    if x0 >= x1 || y0 >= y1 {
        return false;
    }
    sheet.touched = sheet.touched.join(Touched {
        x0: x0 - rect.x0,
        y0: y0 - rect.y0,
        x1: x1 - rect.x0,
        y1: y1 - rect.y0,
    });
    let [xx, xy, yy] = slice.conic;
    let lanes = S::f32s::from_fn(simd, |i| i as f32);
    let zero = S::f32s::simd_from(simd, 0.0);
    let diagonal = xy == 0.0;
    let mut factors = [0.0; PITCH];
    if diagonal {
        row_factors(
            simd,
            -0.5 * yy,
            y0 as f32 + 0.5 - cy,
            &mut factors[..(y1 - y0).next_multiple_of(S::f32s::LEN)],
        );
    }
    // Vectors begin at multiples of their length within the tile; lanes outside the box get no weight.
    let aligned = (x0 - rect.x0) / S::f32s::LEN * S::f32s::LEN;
    for column in (aligned..x1 - rect.x0).step_by(S::f32s::LEN) {
        let dx = lanes + ((rect.x0 + column) as f32 + 0.5 - cx);
        let inside = dx.abs().simd_le(S::f32s::simd_from(simd, rx));
        let along_x = dx * dx * (-0.5 * xx);
        let peak = inside.select(exp(simd, along_x) * slice.weight, zero);
        let rows = &mut sheet.rows[y0 - rect.y0..y1 - rect.y0];
        for (i, (row, factor)) in rows.iter_mut().zip(&factors).enumerate() {
            let dy = (y0 + i) as f32 + 0.5 - cy;
            let weight = if diagonal {
                peak * *factor
            } else {
                let exponent = dx.mul_add(S::f32s::simd_from(simd, -xy * dy), along_x) - 0.5 * yy * dy * dy;
                inside.select(exp(simd, exponent) * slice.weight, zero)
            };
            payload.add(Target { simd, row, x: column }, weight, dx, dy);
        }
    }
    true
}

/// `exp(half_yy dy^2)` of the rows from `first` (offset of the first row from the centre) on, a vector at a time.
#[inline(always)]
fn row_factors<S: Simd>(simd: S, half_yy: f32, first: f32, factors: &mut [f32]) {
    let lanes = S::f32s::from_fn(simd, |i| i as f32);
    for (chunk, factors) in factors.chunks_exact_mut(S::f32s::LEN).enumerate() {
        let dy = lanes + (first + (chunk * S::f32s::LEN) as f32);
        exp(simd, dy * dy * half_yy).store_slice(factors);
    }
}

// A tile's rows and one vector more fit the factors of a slice.
const _: () = assert!(MAX_EDGE <= PITCH);
