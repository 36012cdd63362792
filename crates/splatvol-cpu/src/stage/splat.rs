//! Splat: footprint slices into the sheet buffer.
//!
//! `sheet[channel](pixel) += payload[channel] exp(-d^T Q d / 2)` over the box around the cut ellipse; the box, not the
//! ellipse, because what lies between them only adds accuracy, and lanes there are free. Where Q is diagonal (swan1997's
//! and huang2000's radial kernels) the exponential is a product of a column and a row, and each channel takes one
//! multiply-add per pixel; otherwise it is evaluated per pixel. Positions are image coordinates, so weights do not
//! depend on the tile.

use fearless_simd::prelude::*;
use splatvol_core::bin::TileRect;
use splatvol_core::footprint::Slice;

use super::sheet_buffer::{CHANNELS, MAX_EDGE, PITCH, Row, SheetBuffer, Touched};
use super::simd_exp::exp;

/// What a slice adds to each channel of a vector of pixels.
pub(crate) trait Payload: Copy {
    /// Whether channel [`SLOPE_Y`] is a derivative, and takes the second kind of row factor.
    const HAS_GRADIENT: bool;

    /// Channels for given weights; `dx`, `dy`: offsets of the pixels from the centre.
    fn channels<S: Simd>(self, weight: S::f32s, dx: S::f32s, dy: f32) -> [S::f32s; CHANNELS];

    /// The same for a diagonal conic, to be multiplied by the row's factor `exp(-yy dy^2 / 2)`, or, a derivative to y, by
    /// `-yy dy` times it.
    fn columns<S: Simd>(self, column: S::f32s, dx: S::f32s) -> [S::f32s; CHANNELS];
}

/// The channel that may hold a derivative to screen y.
const SLOPE_Y: usize = 3;

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
    const HAS_GRADIENT: bool = true;

    #[inline(always)]
    fn channels<S: Simd>(self, weight: S::f32s, dx: S::f32s, dy: f32) -> [S::f32s; CHANNELS] {
        let [xx, xy, yy] = self.conic;
        let value = weight * self.coefficient;
        let (slope_x, slope_y) = (dx * -xx - xy * dy, dx * -xy - yy * dy);
        [
            value,
            weight,
            value * slope_x,
            value * slope_y,
            value * self.depth_derivative,
        ]
    }

    #[inline(always)]
    fn columns<S: Simd>(self, column: S::f32s, dx: S::f32s) -> [S::f32s; CHANNELS] {
        let value = column * self.coefficient;
        [
            value,
            column,
            value * dx * -self.conic[0],
            value,
            value * self.depth_derivative,
        ]
    }
}

impl Payload for ColorPayload {
    const HAS_GRADIENT: bool = false;

    #[inline(always)]
    fn channels<S: Simd>(self, weight: S::f32s, _dx: S::f32s, _dy: f32) -> [S::f32s; CHANNELS] {
        self.0.map(|factor| weight * factor)
    }

    #[inline(always)]
    fn columns<S: Simd>(self, column: S::f32s, _dx: S::f32s) -> [S::f32s; CHANNELS] {
        self.0.map(|factor| column * factor)
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

/// Adds a slice to a tile's sheet.
#[inline(always)]
pub(crate) fn splat<S: Simd, P: Payload>(
    simd: S,
    (sheet, rect): (&mut SheetBuffer, &TileRect),
    slice: &Slice,
    payload: P,
) {
    let [cx, cy] = slice.centre;
    let [rx, ry] = slice.half_extent;
    let (x0, x1) = pixel_range(cx, rx, rect.x0, rect.x1);
    let (y0, y1) = pixel_range(cy, ry, rect.y0, rect.y1);
    if x0 >= x1 || y0 >= y1 {
        return;
    }
    sheet.touched = sheet.touched.join(Touched {
        x0: x0 - rect.x0,
        y0: y0 - rect.y0,
        x1: x1 - rect.x0,
        y1: y1 - rect.y0,
    });
    let rows = &mut sheet.rows[y0 - rect.y0..y1 - rect.y0];
    let area = Area {
        first_column: x0 - rect.x0,
        end_column: x1 - rect.x0,
        first: [rect.x0, y0],
    };
    if slice.conic[1] == 0.0 {
        splat_separable(simd, rows, area, slice, payload);
    } else {
        splat_general(simd, rows, area, slice, payload);
    }
}

/// The part of a tile that a slice touches.
#[derive(Debug, Clone, Copy)]
struct Area {
    /// Columns of the tile.
    first_column: usize,
    end_column: usize,
    /// Image coordinates of column 0 and of the first row.
    first: [usize; 2],
}

impl Area {
    /// Columns where vectors begin, at multiples of their length.
    #[inline(always)]
    fn vectors(&self, length: usize) -> impl Iterator<Item = usize> {
        (self.first_column / length * length..self.end_column).step_by(length)
    }

    /// Offsets of a vector's pixel centres from the slice's, and which of them lie in its box.
    #[inline(always)]
    fn offsets<S: Simd>(&self, simd: S, column: usize, slice: &Slice) -> (S::f32s, S::mask32s) {
        let first = (self.first[0] + column) as f32 + 0.5 - slice.centre[0];
        let dx = S::f32s::from_fn(simd, |lane| lane as f32) + first;
        (
            dx,
            dx.abs().simd_le(S::f32s::simd_from(simd, slice.half_extent[0])),
        )
    }

    /// Offset of a row's pixel centres from the slice's.
    #[inline(always)]
    fn row_offset(&self, row: usize, slice: &Slice) -> f32 {
        (self.first[1] + row) as f32 + 0.5 - slice.centre[1]
    }
}

#[inline(always)]
fn splat_separable<S: Simd, P: Payload>(simd: S, rows: &mut [Row], area: Area, slice: &Slice, payload: P) {
    let [xx, _, yy] = slice.conic;
    let zero = S::f32s::simd_from(simd, 0.0);
    let lanes = S::f32s::from_fn(simd, |lane| lane as f32);
    let (mut factors, mut slopes) = ([0.0; PITCH], [0.0; PITCH]);
    for first in (0..rows.len()).step_by(S::f32s::LEN) {
        let dy = lanes + area.row_offset(first, slice);
        let factor = exp(simd, dy * dy * (-0.5 * yy));
        factor.store_slice(&mut factors[first..first + S::f32s::LEN]);
        (factor * dy * -yy).store_slice(&mut slopes[first..first + S::f32s::LEN]);
    }
    for column in area.vectors(S::f32s::LEN) {
        let (dx, inside) = area.offsets(simd, column, slice);
        let weight = inside.select(exp(simd, dx * dx * (-0.5 * xx)) * slice.weight, zero);
        let columns = payload.columns::<S>(weight, dx);
        for (row, (factor, slope)) in rows.iter_mut().zip(factors.iter().zip(&slopes)) {
            for (channel, value) in columns.into_iter().enumerate() {
                let factor = if P::HAS_GRADIENT && channel == SLOPE_Y {
                    *slope
                } else {
                    *factor
                };
                let pixels = &mut row.0[channel][column..column + S::f32s::LEN];
                let before = S::f32s::from_slice(simd, pixels);
                value
                    .mul_add(S::f32s::simd_from(simd, factor), before)
                    .store_slice(pixels);
            }
        }
    }
}

#[inline(always)]
fn splat_general<S: Simd, P: Payload>(simd: S, rows: &mut [Row], area: Area, slice: &Slice, payload: P) {
    let [xx, xy, yy] = slice.conic;
    let zero = S::f32s::simd_from(simd, 0.0);
    for column in area.vectors(S::f32s::LEN) {
        let (dx, inside) = area.offsets(simd, column, slice);
        let along_x = dx * dx * (-0.5 * xx);
        for (i, row) in rows.iter_mut().enumerate() {
            let dy = area.row_offset(i, slice);
            let exponent = dx.mul_add(S::f32s::simd_from(simd, -xy * dy), along_x) - 0.5 * yy * dy * dy;
            let weight = inside.select(exp(simd, exponent) * slice.weight, zero);
            for (channel, value) in payload.channels::<S>(weight, dx, dy).into_iter().enumerate() {
                let pixels = &mut row.0[channel][column..column + S::f32s::LEN];
                (S::f32s::from_slice(simd, pixels) + value).store_slice(pixels);
            }
        }
    }
}

// The rows of a tile, rounded up to vectors, fit a slice's row factors.
const _: () = assert!(MAX_EDGE <= PITCH);
