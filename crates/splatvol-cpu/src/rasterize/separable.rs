//! Footprints whose axes lie along rows and columns: a product of a column's and a row's exponential.
//!
//! Exponents below -63 are raised to it: products stay above the smallest normal number, and what is added is less than
//! 2e-19 of a peak.

use fearless_simd::{f32x8, f32x16, prelude::*};

use super::place::{BATCH, Footprint, LANE, Places, Splats, Window, pixel_of_lane, weight_of_lane};
use super::sheet::{LINE, Sheet};
use super::{Scratch, small};
use crate::simd::math::exp2_quick;

/// Adds splats to a sheet; the conic's mixed term is ignored.
#[inline(always)]
pub(crate) fn splat<S: Simd, const CHANNELS: usize>(
    simd: S,
    sheet: &mut Sheet<CHANNELS>,
    footprint: &Footprint,
    splats: &Splats<'_, CHANNELS>,
    scratch: &mut Scratch,
) {
    if CHANNELS == 1 && small::fits(footprint) {
        small::splat_separable(simd, sheet, footprint, splats);
    } else if half_vectors::<S>(footprint, CHANNELS) {
        splat_by::<S, f32x8<S>, CHANNELS>(simd, sheet, footprint, splats, scratch);
    } else {
        splat_by::<S, S::f32s, CHANNELS>(simd, sheet, footprint, splats, scratch);
    }
}

/// Whether the longest vectors would be filled badly: half as long ones begin where more of them is used.
#[inline(always)]
pub(crate) fn half_vectors<S: Simd>(footprint: &Footprint, channels: usize) -> bool {
    S::f32s::LEN == 16 && channels == 1 && footprint.reach[0] < 4.6
}

#[inline(always)]
fn splat_by<S: Simd, V: SimdFloat<S, Element = f32>, const CHANNELS: usize>(
    simd: S,
    sheet: &mut Sheet<CHANNELS>,
    footprint: &Footprint,
    splats: &Splats<'_, CHANNELS>,
    scratch: &mut Scratch,
) {
    let Some(window) = Window::new(footprint, sheet, V::LEN, true) else {
        return;
    };
    let row_lines = window.rows.div_ceil(LINE);
    scratch.columns.reserve(BATCH * window.lines * LINE);
    scratch.rows.reserve(BATCH * row_lines * LINE);
    let [xx, _, yy] = footprint.exponents();
    let mut places = Places::default();
    for first in (0..splats.len()).step_by(BATCH) {
        let count = (splats.len() - first).min(BATCH);
        let range = first..first + count;
        places.find(simd, &window, &splats.x[range.clone()], &splats.y[range.clone()]);
        let columns = scratch.columns.as_mut_slice();
        let lanes = columns.chunks_exact_mut(window.lines * LINE);
        for ((n, weight), lanes) in splats.weights[range].iter().enumerate().zip(lanes) {
            column_factors(simd, (xx, window.reach[0]), places.dx[n], weight, lanes);
        }
        let rows = scratch.rows.as_mut_slice();
        for (n, lanes) in rows.chunks_exact_mut(row_lines * LINE).enumerate().take(count) {
            row_factors(simd, (yy, window.reach[1]), places.dy[n], lanes);
        }
        let factors = (scratch.columns.as_slice(), scratch.rows.as_slice());
        add::<S, V>(simd, sheet.padded_mut(), (&places, &window, count), factors);
    }
}

/// A batch's columns and rows to the sheet, a few vectors of all splats at a time.
#[inline(always)]
fn add<S: Simd, V: SimdFloat<S, Element = f32>>(
    simd: S,
    values: &mut [f32],
    batch: (&Places, &Window, usize),
    factors: (&[f32], &[f32]),
) {
    let mut strip = 0;
    while strip < batch.1.vectors {
        strip += match batch.1.vectors - strip {
            1 => add_strip::<S, V, 1>(simd, values, batch, factors, strip),
            2 => add_strip::<S, V, 2>(simd, values, batch, factors, strip),
            3 => add_strip::<S, V, 3>(simd, values, batch, factors, strip),
            _ => add_strip::<S, V, 4>(simd, values, batch, factors, strip),
        };
    }
}

/// `weight 2^max(e dx^2, -63)` of each pixel in reach.
#[inline(always)]
fn column_factors<S: Simd, const CHANNELS: usize>(
    simd: S,
    (exponent, reach): (f32, f32),
    dx: f32,
    weight: &[f32; CHANNELS],
    lanes: &mut [f32],
) {
    let weight = weight_of_lane(simd, weight);
    let mut dx = pixel_of_lane(simd, CHANNELS) + dx;
    let floor = f32x16::splat(simd, -63.0);
    for line in lanes.chunks_exact_mut(LINE) {
        let factor = exp2_quick(simd, (dx * dx * exponent).max(floor)) * weight;
        let inside = dx.abs().simd_le(f32x16::splat(simd, reach));
        inside.select(factor, f32x16::splat(simd, 0.0)).store_slice(line);
        dx += (LINE / CHANNELS) as f32;
    }
}

/// `2^max(e dy^2, -63)` of each row in reach.
#[inline(always)]
fn row_factors<S: Simd>(simd: S, (exponent, reach): (f32, f32), dy: f32, lanes: &mut [f32]) {
    let mut dy = f32x16::from_slice(simd, &LANE) + dy;
    let floor = f32x16::splat(simd, -63.0);
    for line in lanes.chunks_exact_mut(LINE) {
        let factor = exp2_quick(simd, (dy * dy * exponent).max(floor));
        let inside = dy.abs().simd_le(f32x16::splat(simd, reach));
        inside.select(factor, f32x16::splat(simd, 0.0)).store_slice(line);
        dy += LINE as f32;
    }
}

/// Vectors `strip..strip + N` of all splats of a batch; returns N.
#[inline(always)]
fn add_strip<S: Simd, V: SimdFloat<S, Element = f32>, const N: usize>(
    simd: S,
    values: &mut [f32],
    (places, window, count): (&Places, &Window, usize),
    (columns, rows): (&[f32], &[f32]),
    strip: usize,
) -> usize {
    let columns = columns.chunks_exact(window.lines * LINE);
    let factors = rows.chunks_exact(window.rows.next_multiple_of(LINE));
    for (n, (columns, factors)) in columns.zip(factors).enumerate().take(count) {
        let (lines, rows) = places.at(n, window, values);
        let columns = &columns[strip * V::LEN..][..N * V::LEN];
        let mut lanes = [V::simd_from(simd, 0.0); N];
        for v in 0..N {
            lanes[v] = V::from_slice(simd, &columns[v * V::LEN..][..V::LEN]);
        }
        for (line, factor) in lines.zip(&factors[..rows]) {
            let factor = V::simd_from(simd, *factor);
            let line = &mut line[strip * V::LEN..(strip + N) * V::LEN];
            for v in 0..N {
                let pixels = &mut line[v * V::LEN..(v + 1) * V::LEN];
                lanes[v]
                    .mul_add(factor, V::from_slice(simd, pixels))
                    .store_slice(pixels);
            }
        }
    }
    N
}
