//! Footprints of up to 8 x 8 pixels of one channel: a row is one vector, wherever it begins.
//!
//! Where footprints are small, getting ready costs more than their pixels. A column of factors (or the first row) and a row
//! of them (or of ratios) share one vector of sixteen lanes, so a splat costs one exponential; and eight lanes from where
//! the footprint begins are half of what aligned vectors need to hold it. A vector across a cache line's end costs twice an
//! aligned one, but only one in two lies so.

use fearless_simd::{f32x8, f32x16, prelude::*};

use super::place::{BATCH, Footprint, LANE, Places, Splats, Window, points};
use super::sheet::{LINE, Sheet};
use crate::simd::math::exp2_quick;

/// Pixels along an edge.
const EDGE: usize = 8;

/// Whether footprints are small.
pub(crate) fn fits(footprint: &Footprint) -> bool {
    footprint.reach.iter().all(|&reach| points(reach) <= EDGE)
}

/// A batch's factors or starts.
#[repr(align(64))]
struct Ready([[f32; LINE]; BATCH]);

/// `low` in the first eight lanes, `high` in the others.
#[inline(always)]
fn halves<S: Simd>(simd: S, low: f32, high: f32) -> f32x16<S> {
    f32x8::splat(simd, low).combine(f32x8::splat(simd, high))
}

/// As `separable::splat`.
#[inline(always)]
pub(crate) fn splat_separable<S: Simd, const CHANNELS: usize>(
    simd: S,
    sheet: &mut Sheet<CHANNELS>,
    footprint: &Footprint,
    splats: &Splats<'_, CHANNELS>,
) {
    if points(footprint.reach[1]) <= EDGE / 2 {
        splat_rows::<S, CHANNELS, { EDGE / 2 }>(simd, sheet, footprint, splats);
    } else {
        splat_rows::<S, CHANNELS, EDGE>(simd, sheet, footprint, splats);
    }
}

/// Footprints of `ROWS` rows; what is out of reach gets zero, what is out of the sheet lies in its padding.
#[inline(always)]
fn splat_rows<S: Simd, const CHANNELS: usize, const ROWS: usize>(
    simd: S,
    sheet: &mut Sheet<CHANNELS>,
    footprint: &Footprint,
    splats: &Splats<'_, CHANNELS>,
) {
    let Some(window) = Window::new(footprint, sheet, EDGE, false) else {
        return;
    };
    let [xx, _, yy] = footprint.exponents();
    let exponents = halves(simd, xx, yy);
    let reach = halves(simd, window.reach[0], window.reach[1]);
    let lanes = f32x8::from_slice(simd, &LANE[..EDGE]);
    let lanes = lanes.combine(lanes);
    let floor = f32x16::splat(simd, -63.0);
    let zero = f32x16::splat(simd, 0.0);
    let mut ready = Ready([[0.0; LINE]; BATCH]);
    let mut places = Places::default();
    for first in (0..splats.len()).step_by(BATCH) {
        let count = (splats.len() - first).min(BATCH);
        let range = first..first + count;
        places.find(simd, &window, &splats.x[range.clone()], &splats.y[range.clone()]);
        for (n, (weight, ready)) in splats.weights[range].iter().zip(&mut ready.0).enumerate() {
            let d = lanes + halves(simd, places.dx[n], places.dy[n]);
            let factor = exp2_quick(simd, (d * d * exponents).max(floor)) * halves(simd, weight[0], 1.0);
            let inside = d.abs().simd_le(reach);
            inside.select(factor, zero).store_slice(ready);
        }
        let values = sheet.padded_mut();
        for (n, ready) in ready.0[..count].iter().enumerate() {
            let (mut lines, _) = places.at(n, &window, values);
            let columns = f32x8::from_slice(simd, &ready[..EDGE]);
            for row in 0..ROWS {
                let Some(line) = lines.next() else { break };
                let pixels = &mut line[..EDGE];
                columns
                    .mul_add(ready[EDGE + row], f32x8::from_slice(simd, pixels))
                    .store_slice(pixels);
            }
        }
    }
}

/// As `ellipse::splat`, of tame footprints.
#[inline(always)]
pub(crate) fn splat_ellipses<S: Simd, const CHANNELS: usize>(
    simd: S,
    sheet: &mut Sheet<CHANNELS>,
    footprint: &Footprint,
    splats: &Splats<'_, CHANNELS>,
) {
    let Some(window) = Window::new(footprint, sheet, EDGE, false).map(Window::exact) else {
        return;
    };
    let [xx, xy, yy] = footprint.exponents();
    let curvature = f32x8::splat(simd, (2.0 * yy).exp2());
    let square = halves(simd, xx, 0.0);
    let reach = f32x16::splat(simd, window.reach[0]);
    let lanes = f32x8::from_slice(simd, &LANE[..EDGE]);
    let lanes = lanes.combine(lanes);
    let mut ready = Ready([[0.0; LINE]; BATCH]);
    let mut places = Places::default();
    for first in (0..splats.len()).step_by(BATCH) {
        let count = (splats.len() - first).min(BATCH);
        let range = first..first + count;
        places.find(simd, &window, &splats.x[range.clone()], &splats.y[range.clone()]);
        for (n, (weight, ready)) in splats.weights[range].iter().zip(&mut ready.0).enumerate() {
            let dy = places.dy[n];
            let dx = lanes + places.dx[n];
            let near = dx.max(-reach).min(reach);
            let slope = halves(simd, xy * dy, xy);
            let constant = halves(simd, yy * dy * dy, yy * (2.0 * dy + 1.0));
            let exponent = near.mul_add(near.mul_add(square, slope), constant);
            let factor = exp2_quick(simd, exponent) * halves(simd, weight[0], 1.0);
            let inside = dx.abs().simd_le(reach);
            inside.select(factor, f32x16::splat(simd, 0.0)).store_slice(ready);
        }
        let values = sheet.padded_mut();
        for (n, ready) in ready.0[..count].iter().enumerate() {
            let (lines, rows) = places.at(n, &window, values);
            let (mut value, mut ratio) = f32x16::from_slice(simd, ready).split();
            for line in lines.take(rows) {
                let pixels = &mut line[..EDGE];
                (f32x8::from_slice(simd, pixels) + value).store_slice(pixels);
                value *= ratio;
                ratio *= curvature;
            }
        }
    }
}
