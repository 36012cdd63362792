//! Footprints of any conic: a recurrence from row to row.
//!
//! With `w(dy) = 2^(a dx^2 + c dx dy + b dy^2)`: `w(dy + 1) = w(dy) r(dy)`, `r(dy) = 2^(c dx + b (2 dy + 1))`,
//! `r(dy + 1) = r(dy) 2^(2 b)`: two multiplications per pixel instead of an exponential (zwicker2001's footprints, evaluated
//! as forward differences of the exponent). After j rows rounding has grown to j^2 / 2 times that of one multiplication, so
//! every [`BAND`] rows start afresh. Conics so narrow and oblique that a corner of the box would underflow, after which the
//! recurrence could not come back, are evaluated pixel by pixel.

use fearless_simd::{f32x8, f32x16, prelude::*};

use super::place::{BATCH, Footprint, Places, Splats, Window, pixel_of_lane, weight_of_lane};
use super::separable::half_vectors;
use super::sheet::{LINE, Sheet};
use super::{Scratch, small};
use crate::simd::math::{exp2, exp2_quick};

/// Rows from one start of the recurrence to the next.
pub(crate) const BAND: usize = 32;

/// Exponents to base 2 in which single precision has room: no factor is larger or smaller.
const LARGEST_EXPONENT: f32 = 100.0;

/// Adds splats to a sheet.
#[inline(always)]
pub(crate) fn splat<S: Simd, const CHANNELS: usize>(
    simd: S,
    sheet: &mut Sheet<CHANNELS>,
    footprint: &Footprint,
    splats: &Splats<'_, CHANNELS>,
    scratch: &mut Scratch,
) {
    if !is_tame(footprint) {
        splat_directly(simd, sheet, footprint, splats);
    } else if CHANNELS == 1 && small::fits(footprint) {
        small::splat_ellipses(simd, sheet, footprint, splats);
    } else if half_vectors::<S>(footprint, CHANNELS) {
        splat_by::<S, f32x8<S>, CHANNELS>(simd, sheet, footprint, splats, scratch);
    } else {
        splat_by::<S, S::f32s, CHANNELS>(simd, sheet, footprint, splats, scratch);
    }
}

/// Whether all factors of the recurrence are normal numbers. The exponent is concave: it is least in a corner.
pub(crate) fn is_tame(footprint: &Footprint) -> bool {
    let [xx, xy, yy] = footprint.exponents().map(f32::abs);
    let (dx, dy) = (footprint.reach[0], footprint.reach[1] + 1.0);
    let corner = xx * dx * dx + xy * dx * dy + yy * dy * dy;
    let ratio = xy * dx + yy * (2.0 * dy + 1.0);
    corner <= LARGEST_EXPONENT && ratio <= LARGEST_EXPONENT
}

#[inline(always)]
fn splat_by<S: Simd, V: SimdFloat<S, Element = f32>, const CHANNELS: usize>(
    simd: S,
    sheet: &mut Sheet<CHANNELS>,
    footprint: &Footprint,
    splats: &Splats<'_, CHANNELS>,
    scratch: &mut Scratch,
) {
    let Some(window) = Window::new(footprint, sheet, V::LEN, true).map(Window::exact) else {
        return;
    };
    let bands = window.rows.div_ceil(BAND);
    let stride = bands * window.lines * LINE;
    scratch.columns.reserve(BATCH * stride);
    scratch.rows.reserve(BATCH * stride);
    let exponents = footprint.exponents();
    let curvature = (2.0 * exponents[2]).exp2();
    let mut places = Places::default();
    for first in (0..splats.len()).step_by(BATCH) {
        let count = (splats.len() - first).min(BATCH);
        let range = first..first + count;
        places.find(simd, &window, &splats.x[range.clone()], &splats.y[range.clone()]);
        let values = scratch.columns.as_mut_slice().chunks_exact_mut(stride);
        let ratios = scratch.rows.as_mut_slice().chunks_exact_mut(stride);
        let weights = splats.weights[range].iter();
        for (n, ((weight, values), ratios)) in weights.zip(values).zip(ratios).enumerate() {
            for band in 0..bands {
                let offset = [places.dx[n], places.dy[n] + (band * BAND) as f32];
                let lanes = band * window.lines * LINE..(band + 1) * window.lines * LINE;
                let starts = (&mut values[lanes.clone()], &mut ratios[lanes]);
                start(simd, (exponents, window.reach[0]), offset, weight, starts);
            }
        }
        let starts = (scratch.columns.as_slice(), scratch.rows.as_slice());
        let batch = (&places, &window, count);
        let mut strip = 0;
        while strip < window.vectors {
            let target = sheet.padded_mut();
            strip += match window.vectors - strip {
                1 => add_strip::<S, V, 1>(simd, target, batch, starts, (curvature, strip)),
                2 => add_strip::<S, V, 2>(simd, target, batch, starts, (curvature, strip)),
                3 => add_strip::<S, V, 3>(simd, target, batch, starts, (curvature, strip)),
                _ => add_strip::<S, V, 4>(simd, target, batch, starts, (curvature, strip)),
            };
        }
    }
}

/// Values of a band's first row, and their ratios to the second one's.
#[inline(always)]
fn start<S: Simd, const CHANNELS: usize>(
    simd: S,
    ([xx, xy, yy], reach): ([f32; 3], f32),
    [dx, dy]: [f32; 2],
    weight: &[f32; CHANNELS],
    (values, ratios): (&mut [f32], &mut [f32]),
) {
    let weight = weight_of_lane(simd, weight);
    let mut dx = pixel_of_lane(simd, CHANNELS) + dx;
    let reach = f32x16::splat(simd, reach);
    let constant = f32x16::splat(simd, yy * dy * dy);
    let slope = f32x16::splat(simd, xy * dy);
    let step = f32x16::splat(simd, yy * (2.0 * dy + 1.0));
    for (value, ratio) in values.chunks_exact_mut(LINE).zip(ratios.chunks_exact_mut(LINE)) {
        // Pixels outside the box have a finite ratio, and no value.
        let near = dx.max(-reach).min(reach);
        let exponent = near.mul_add(near.mul_add(xx, slope), constant);
        let factor = exp2_quick(simd, exponent) * weight;
        let inside = dx.abs().simd_le(reach);
        inside.select(factor, f32x16::splat(simd, 0.0)).store_slice(value);
        // Its error is multiplied once per row.
        exp2(simd, near.mul_add(xy, step)).store_slice(ratio);
        dx += (LINE / CHANNELS) as f32;
    }
}

/// Vectors `strip..strip + N` of all splats of a batch; returns N.
#[inline(always)]
fn add_strip<S: Simd, V: SimdFloat<S, Element = f32>, const N: usize>(
    simd: S,
    values: &mut [f32],
    (places, window, count): (&Places, &Window, usize),
    (starts, ratios): (&[f32], &[f32]),
    (curvature, strip): (f32, usize),
) -> usize {
    let width = window.lines * LINE;
    let bands = window.rows.div_ceil(BAND);
    let curvature = V::simd_from(simd, curvature);
    for n in 0..count {
        let (mut lines, rows) = places.at(n, window, values);
        for band in 0..rows.div_ceil(BAND) {
            let lanes = (n * bands + band) * width + strip * V::LEN..;
            let starts = &starts[lanes.clone()][..N * V::LEN];
            let ratios = &ratios[lanes][..N * V::LEN];
            let mut value = [V::simd_from(simd, 0.0); N];
            let mut ratio = value;
            for v in 0..N {
                value[v] = V::from_slice(simd, &starts[v * V::LEN..][..V::LEN]);
                ratio[v] = V::from_slice(simd, &ratios[v * V::LEN..][..V::LEN]);
            }
            for line in lines.by_ref().take((rows - band * BAND).min(BAND)) {
                let line = &mut line[strip * V::LEN..(strip + N) * V::LEN];
                for v in 0..N {
                    let pixels = &mut line[v * V::LEN..(v + 1) * V::LEN];
                    (V::from_slice(simd, pixels) + value[v]).store_slice(pixels);
                    value[v] *= ratio[v];
                    ratio[v] *= curvature;
                }
            }
        }
    }
    N
}

/// One exponential per pixel.
#[inline(always)]
fn splat_directly<S: Simd, const CHANNELS: usize>(
    simd: S,
    sheet: &mut Sheet<CHANNELS>,
    footprint: &Footprint,
    splats: &Splats<'_, CHANNELS>,
) {
    let Some(window) = Window::new(footprint, sheet, LINE, true).map(Window::exact) else {
        return;
    };
    let [xx, xy, yy] = footprint.exponents();
    let reach = f32x16::splat(simd, window.reach[0]);
    let mut places = Places::default();
    for n in 0..splats.len() {
        places.find(simd, &window, &splats.x[n..=n], &splats.y[n..=n]);
        let weight = weight_of_lane(simd, &splats.weights[n]);
        let (lines, rows) = places.at(0, &window, sheet.padded_mut());
        for (j, line) in lines.take(rows).enumerate() {
            let dy = places.dy[0] + j as f32;
            let mut dx = pixel_of_lane(simd, CHANNELS) + places.dx[0];
            for pixels in line[..window.lines * LINE].chunks_exact_mut(LINE) {
                let exponent = (dx * xx + xy * dy) * dx + yy * dy * dy;
                let inside = dx.abs().simd_le(reach);
                let factor = inside.select(exp2(simd, exponent), f32x16::splat(simd, 0.0));
                factor
                    .mul_add(weight, f32x16::from_slice(simd, pixels))
                    .store_slice(pixels);
                dx += (LINE / CHANNELS) as f32;
            }
        }
    }
}
