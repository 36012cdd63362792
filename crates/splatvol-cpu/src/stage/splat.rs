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
use crate::simd::math::exp;

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
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct DataPayload {
    /// Kernel coefficient.
    pub coefficient: f32,
    /// Conic of the slice; `d weight / d screen = -Q d weight`.
    pub conic: [f32; 3],
    /// `d ln weight / d depth`.
    pub depth_derivative: f32,
}

/// Five numbers that scale with the weight.
#[derive(Debug, Clone, Copy, Default)]
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

impl ColorPayload {
    #[inline(always)]
    fn times<S: Simd>(self, weight: S::f32s) -> [S::f32s; CHANNELS] {
        let [a, b, c, d, e] = self.0;
        [weight * a, weight * b, weight * c, weight * d, weight * e]
    }
}

impl Payload for ColorPayload {
    const HAS_GRADIENT: bool = false;

    #[inline(always)]
    fn channels<S: Simd>(self, weight: S::f32s, _dx: S::f32s, _dy: f32) -> [S::f32s; CHANNELS] {
        self.times::<S>(weight)
    }

    #[inline(always)]
    fn columns<S: Simd>(self, column: S::f32s, _dx: S::f32s) -> [S::f32s; CHANNELS] {
        self.times::<S>(column)
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

/// A slice ready to be added to a tile's sheet: its pixels and, where its conic is diagonal, the factors of its rows and
/// columns.
///
/// Getting ready is a long chain of dependent instructions, longer than a processor looks ahead; so slices are made
/// ready a batch at a time, side by side, before their pixels are added.
#[derive(Debug, Clone)]
pub(crate) struct Stamp<P> {
    slice: Slice,
    payload: P,
    /// Columns and rows of the tile, ends excluded.
    area: Touched,
    /// Image coordinates of the tile's first pixel.
    origin: [usize; 2],
    /// Weights of the columns, from the tile's first column on.
    columns: [f32; PITCH],
    /// `exp(-yy dy^2 / 2)` of the rows, from the area's first row on.
    rows: [f32; PITCH],
    /// `-yy dy` times that.
    slopes: [f32; PITCH],
}

impl<P: Payload> Stamp<P> {
    /// A stamp to be made ready.
    pub(crate) fn blank(payload: P) -> Self {
        let slice = Slice {
            centre: [0.0; 2],
            conic: [1.0, 0.0, 1.0],
            half_extent: [0.0; 2],
            weight: 0.0,
            depth: 0.0,
        };
        Self {
            slice,
            payload,
            area: Touched::default(),
            origin: [0; 2],
            columns: [0.0; PITCH],
            rows: [0.0; PITCH],
            slopes: [0.0; PITCH],
        }
    }

    /// Takes a slice; false where it touches no pixel centre of the tile.
    #[inline(always)]
    pub(crate) fn prepare<S: Simd>(&mut self, simd: S, rect: &TileRect, slice: &Slice, payload: P) -> bool {
        let ([cx, cy], [rx, ry]) = (slice.centre, slice.half_extent);
        let (x0, x1) = pixel_range(cx, rx, rect.x0, rect.x1);
        let (y0, y1) = pixel_range(cy, ry, rect.y0, rect.y1);
        if x0 >= x1 || y0 >= y1 {
            return false;
        }
        self.area = Touched {
            x0: x0 - rect.x0,
            y0: y0 - rect.y0,
            x1: x1 - rect.x0,
            y1: y1 - rect.y0,
        };
        self.origin = [rect.x0, rect.y0];
        self.slice = *slice;
        self.payload = payload;
        if self.is_separable() {
            self.separate(simd);
        }
        true
    }

    #[inline(always)]
    fn is_separable(&self) -> bool {
        self.slice.conic[1] == 0.0
    }

    /// Tile columns where vectors begin, at multiples of their length.
    #[inline(always)]
    fn vectors(&self, length: usize) -> impl Iterator<Item = usize> + use<P> {
        (self.area.x0 / length * length..self.area.x1).step_by(length)
    }

    /// Offsets of a vector's pixel centres from the slice's.
    #[inline(always)]
    fn column_offsets<S: Simd>(&self, simd: S, column: usize) -> S::f32s {
        let first = (self.origin[0] + column) as f32 + 0.5 - self.slice.centre[0];
        S::f32s::from_fn(simd, |lane| lane as f32) + first
    }

    /// Offset of the area's i-th row of pixel centres from the slice's.
    #[inline(always)]
    fn row_offset(&self, row: usize) -> f32 {
        (self.origin[1] + self.area.y0 + row) as f32 + 0.5 - self.slice.centre[1]
    }

    /// Weights of pixels, of those within the slice's box: lanes outside it get none.
    #[inline(always)]
    fn weights<S: Simd>(&self, simd: S, dx: S::f32s, exponent: S::f32s) -> S::f32s {
        let inside = dx
            .abs()
            .simd_le(S::f32s::simd_from(simd, self.slice.half_extent[0]));
        inside.select(
            exp(simd, exponent) * self.slice.weight,
            S::f32s::simd_from(simd, 0.0),
        )
    }

    #[inline(always)]
    fn separate<S: Simd>(&mut self, simd: S) {
        let [xx, _, yy] = self.slice.conic;
        let lanes = S::f32s::from_fn(simd, |lane| lane as f32);
        for first in (0..self.area.y1 - self.area.y0).step_by(S::f32s::LEN) {
            let dy = lanes + self.row_offset(first);
            let factor = exp(simd, dy * dy * (-0.5 * yy));
            factor.store_slice(&mut self.rows[first..first + S::f32s::LEN]);
            (factor * dy * -yy).store_slice(&mut self.slopes[first..first + S::f32s::LEN]);
        }
        for column in self.vectors(S::f32s::LEN) {
            let dx = self.column_offsets(simd, column);
            let weights = self.weights(simd, dx, dx * dx * (-0.5 * xx));
            weights.store_slice(&mut self.columns[column..column + S::f32s::LEN]);
        }
    }

    /// Adds the slice to the sheet.
    #[inline(always)]
    pub(crate) fn add<S: Simd>(&self, simd: S, sheet: &mut SheetBuffer) {
        sheet.touched = sheet.touched.join(self.area);
        let rows = &mut sheet.rows[self.area.y0..self.area.y1];
        if self.is_separable() {
            self.add_separable(simd, rows);
        } else {
            self.add_general(simd, rows);
        }
    }

    #[inline(always)]
    fn add_separable<S: Simd>(&self, simd: S, rows: &mut [Row]) {
        for column in self.vectors(S::f32s::LEN) {
            let dx = self.column_offsets(simd, column);
            let weights = S::f32s::from_slice(simd, &self.columns[column..column + S::f32s::LEN]);
            let columns = self.payload.columns::<S>(weights, dx);
            for (row, (factor, slope)) in rows.iter_mut().zip(self.rows.iter().zip(&self.slopes)) {
                for (channel, value) in columns.into_iter().enumerate() {
                    let is_slope = P::HAS_GRADIENT && channel == SLOPE_Y;
                    let factor = S::f32s::simd_from(simd, if is_slope { *slope } else { *factor });
                    let pixels = &mut row.0[channel][column..column + S::f32s::LEN];
                    (value * factor + S::f32s::from_slice(simd, pixels)).store_slice(pixels);
                }
            }
        }
    }

    #[inline(always)]
    fn add_general<S: Simd>(&self, simd: S, rows: &mut [Row]) {
        let [xx, xy, yy] = self.slice.conic;
        for column in self.vectors(S::f32s::LEN) {
            let dx = self.column_offsets(simd, column);
            for (i, row) in rows.iter_mut().enumerate() {
                let dy = self.row_offset(i);
                let along_x = dx * dx * (-0.5 * xx);
                let exponent = dx * (-xy * dy) + along_x - 0.5 * yy * dy * dy;
                let weights = self.weights(simd, dx, exponent);
                for (channel, value) in self
                    .payload
                    .channels::<S>(weights, dx, dy)
                    .into_iter()
                    .enumerate()
                {
                    let pixels = &mut row.0[channel][column..column + S::f32s::LEN];
                    (S::f32s::from_slice(simd, pixels) + value).store_slice(pixels);
                }
            }
        }
    }
}

// The rows of a tile, rounded up to vectors, fit a stamp's rows.
const _: () = assert!(MAX_EDGE <= PITCH);
