//! Splat: footprint slices into the sheet buffer.
//!
//! `sheet[channel](pixel) += payload[channel] exp(-d^T Q d / 2)` over the box around the cut ellipse; the box, not the
//! ellipse, because what lies between them only adds accuracy, and lanes there are free. Where Q is diagonal the
//! exponential is a product of a row and a column (swan1997's and huang2000's radial kernels); otherwise it is
//! evaluated per pixel. Positions are image coordinates, so weights do not depend on the tile.

use fearless_simd::prelude::*;
use splatvol_core::bin::TileRect;
use splatvol_core::footprint::Slice;

use super::sheet_buffer::{CHANNELS, MAX_LANES, SheetBuffer, Touched};
use super::simd_exp::exp;

/// What a slice adds to each channel, given its weight at some pixels.
pub(crate) trait Payload: Copy {
    /// Adds to the vector of pixels at `row[at..]` of each channel (`pitch` apart); `dx`, `dy`: offsets from the centre.
    fn add<S: Simd>(self, simd: S, row: &mut [f32], pitch: usize, weight: S::f32s, dx: S::f32s, dy: f32);
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

#[inline(always)]
fn accumulate<S: Simd>(simd: S, pixels: &mut [f32], value: S::f32s) {
    let pixels = &mut pixels[..S::f32s::LEN];
    (S::f32s::from_slice(simd, pixels) + value).store_slice(pixels);
}

impl Payload for DataPayload {
    #[inline(always)]
    fn add<S: Simd>(self, simd: S, row: &mut [f32], pitch: usize, weight: S::f32s, dx: S::f32s, dy: f32) {
        let [xx, xy, yy] = self.conic;
        let value = weight * self.coefficient;
        let slope_x = dx * -xx - xy * dy;
        let slope_y = dx * -xy - yy * dy;
        accumulate(simd, row, value);
        accumulate(simd, &mut row[pitch..], weight);
        accumulate(simd, &mut row[2 * pitch..], value * slope_x);
        accumulate(simd, &mut row[3 * pitch..], value * slope_y);
        accumulate(simd, &mut row[4 * pitch..], value * self.depth_derivative);
    }
}

impl Payload for ColorPayload {
    #[inline(always)]
    fn add<S: Simd>(self, simd: S, row: &mut [f32], pitch: usize, weight: S::f32s, _dx: S::f32s, _dy: f32) {
        for (channel, factor) in self.0.into_iter().enumerate() {
            accumulate(simd, &mut row[channel * pitch..], weight * factor);
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
    let (pitch, stride) = (sheet.pitch, CHANNELS * sheet.pitch);
    let lanes = S::f32s::from_fn(simd, |i| i as f32);
    let zero = S::f32s::simd_from(simd, 0.0);
    let diagonal = xy == 0.0;
    let rows = RowFactors::new(simd, -0.5 * yy, cy, y0, if diagonal { y1 } else { y0 });
    // Vectors begin at multiples of their length within the tile; lanes outside the box get no weight.
    let aligned = (x0 - rect.x0) / S::f32s::LEN * S::f32s::LEN + rect.x0;
    for x in (aligned..x1).step_by(S::f32s::LEN) {
        let dx = lanes + (x as f32 + 0.5 - cx);
        let inside = dx.abs().simd_le(S::f32s::simd_from(simd, rx));
        let along_x = dx * dx * (-0.5 * xx);
        let column = inside.select(exp(simd, along_x) * slice.weight, zero);
        let start = sheet.row(y0 - rect.y0) + x - rect.x0;
        let end = start + (y1 - y0 - 1) * stride + (CHANNELS - 1) * pitch + S::f32s::LEN;
        for (i, row) in sheet.data[start..end].chunks_mut(stride).enumerate() {
            let dy = (y0 + i) as f32 + 0.5 - cy;
            let weight = if diagonal {
                column * rows.factor(simd, i, dy)
            } else {
                let exponent = dx.mul_add(S::f32s::simd_from(simd, -xy * dy), along_x) - 0.5 * yy * dy * dy;
                inside.select(exp(simd, exponent) * slice.weight, zero)
            };
            payload.add(simd, row, pitch, weight, dx, dy);
        }
    }
    true
}

/// `exp(-yy dy^2 / 2)` of the rows of a slice, a vector at a time.
struct RowFactors {
    factors: [f32; Self::KEPT],
    half_yy: f32,
}

impl RowFactors {
    /// Rows of a tile; taller tiles compute the rest row by row.
    const KEPT: usize = 64 + MAX_LANES;

    #[inline(always)]
    fn new<S: Simd>(simd: S, half_yy: f32, cy: f32, y0: usize, y1: usize) -> Self {
        let mut factors = [0.0; Self::KEPT];
        let lanes = S::f32s::from_fn(simd, |i| i as f32);
        for first in (0..(y1 - y0).min(64)).step_by(S::f32s::LEN) {
            let dy = lanes + ((y0 + first) as f32 + 0.5 - cy);
            exp(simd, dy * dy * half_yy).store_slice(&mut factors[first..first + S::f32s::LEN]);
        }
        Self { factors, half_yy }
    }

    #[inline(always)]
    fn factor<S: Simd>(&self, simd: S, row: usize, dy: f32) -> f32 {
        if row < 64 {
            self.factors[row]
        } else {
            exp(simd, S::f32s::simd_from(simd, self.half_yy * dy * dy))[0]
        }
    }
}
