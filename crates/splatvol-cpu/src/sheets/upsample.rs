//! Upsample: sheets of coarse rasters to pixels.
//!
//! Big footprints are splatted narrower onto a raster of `step` pixels, whose points are the coefficients of a
//! cubic B-spline. The spline adds a variance of a third of a raster step squared, by which the footprints were
//! narrowed. So the cost of a voxel does not grow with the zoom. The spline is evaluated by subdivision: its
//! coefficients on the raster twice as fine are `(c[i-1] + 6 c[i] + c[i+1]) / 8` and `(c[i] + c[i+1]) / 2`, and at
//! pixels its value is `(c[i-1] + 4 c[i] + c[i+1]) / 6`.

use fearless_simd::{f32x16, prelude::*};

use super::place::Place;
use super::plane::{HALO, Plane, Span};

/// Raster points around a tile that its pixels need, at every step of the subdivision; even, as blocks are.
pub(crate) const RASTER_HALO: usize = 4;

/// Memory for the steps between.
#[derive(Debug, Default)]
pub(crate) struct Upsampler {
    planes: [Plane; 2],
}

#[inline(always)]
fn load<S: Simd>(simd: S, row: &[f32], at: usize) -> f32x16<S> {
    f32x16::from_slice(simd, &row[at..at + 16])
}

/// Three rows around a row of a plane.
#[inline(always)]
fn around(plane: &Plane, y: usize) -> [&[f32]; 3] {
    [y - 1, y, y + 1].map(|y| &plane.values[y * plane.pitch..(y + 1) * plane.pitch])
}

impl Upsampler {
    /// Pixels of a tile, with a halo, from its raster of every `step`-th pixel.
    #[inline(always)]
    pub(crate) fn run<S: Simd>(
        &mut self,
        simd: S,
        raster: &Plane,
        pixels: &mut Plane,
        (place, step): (&Place, usize),
    ) {
        pixels.clear();
        if raster.filled.is_none() {
            return;
        }
        let [even, odd] = &mut self.planes;
        let mut finer = Finer::than(place, step);
        subdivide(simd, raster, even, &finer);
        let (mut from, mut to) = (even, odd);
        while finer.step > 1 {
            finer = finer.next(place);
            subdivide(simd, from, to, &finer);
            std::mem::swap(&mut from, &mut to);
        }
        evaluate(simd, from, pixels, place.size.map(|n| n + 2 * HALO));
    }
}

/// A raster twice as fine as another. Both begin at an even point; if the tile begins within the coarse one's first
/// points, the finer one begins later.
#[derive(Debug, Clone, Copy)]
struct Finer {
    step: usize,
    /// Pixels from the first point to the tile.
    phase: [usize; 2],
    /// Coarse points left out before the tile, 0 or 1.
    skipped: [usize; 2],
    /// Points, those around the tile included.
    size: [usize; 2],
}

impl Finer {
    /// The raster twice as fine as a tile's own.
    fn than(place: &Place, step: usize) -> Self {
        Self::after(place, step, place.phase)
    }

    fn next(&self, place: &Place) -> Self {
        Self::after(place, self.step, self.phase)
    }

    fn after(place: &Place, coarse: usize, from: [usize; 2]) -> Self {
        let step = coarse / 2;
        let phase = from.map(|phase| phase % coarse);
        Self {
            step,
            phase,
            skipped: from.map(|phase| phase / coarse),
            size: std::array::from_fn(|a| (phase[a] + place.size[a]).div_ceil(step) + 2 * RASTER_HALO),
        }
    }
}

/// Coefficients of the raster twice as fine.
#[inline(always)]
fn subdivide<S: Simd>(simd: S, coarse: &Plane, fine: &mut Plane, finer: &Finer) {
    fine.reset(finer.size);
    let Some(span) = coarse.filled else { return };
    let ([width, height], [skip_x, skip_y]) = (finer.size, finer.skipped);
    // Point i of the coarse raster is point 2 (i - skipped) - RASTER_HALO of the fine one.
    let first = |i: usize, skip: usize| (2 * i).saturating_sub(RASTER_HALO + 2 + 2 * skip);
    let last = |i: usize, skip: usize, n: usize| (2 * i + 2).saturating_sub(RASTER_HALO + 2 * skip).min(n);
    let (y0, y1) = (first(span.y0, skip_y), last(span.y1, skip_y, height));
    let (x0, x1) = (first(span.x0, skip_x) / 32 * 32, last(span.x1, skip_x, width));
    for y in y0..y1 {
        let [above, here, below] = around(coarse, y / 2 + RASTER_HALO / 2 + skip_y);
        let target = &mut fine.values[y * fine.pitch..(y + 1) * fine.pitch];
        let mut x = x0;
        while x < x1 {
            let at = x / 2 + RASTER_HALO / 2 + skip_x;
            let (left, middle, right) = if y % 2 == 0 {
                (
                    even(simd, [above, here, below], at - 1),
                    even(simd, [above, here, below], at),
                    even(simd, [above, here, below], at + 1),
                )
            } else {
                (
                    odd(simd, [here, below], at - 1),
                    odd(simd, [here, below], at),
                    odd(simd, [here, below], at + 1),
                )
            };
            let evens = (left + right + middle * 6.0) * 0.125;
            let odds = (middle + right) * 0.5;
            let (low, high) = simd.interleave_f32x16(evens, odds);
            low.store_slice(&mut target[x..x + 16]);
            high.store_slice(&mut target[x + 16..x + 32]);
            x += 32;
        }
    }
    if x0 < x1 && y0 < y1 {
        fine.filled = Some(Span {
            x0,
            y0,
            x1: x0 + (x1 - x0).next_multiple_of(32),
            y1,
        });
    }
}

#[inline(always)]
fn even<S: Simd>(simd: S, [above, here, below]: [&[f32]; 3], at: usize) -> f32x16<S> {
    (load(simd, above, at) + load(simd, below, at) + load(simd, here, at) * 6.0) * 0.125
}

#[inline(always)]
fn odd<S: Simd>(simd: S, [here, below]: [&[f32]; 2], at: usize) -> f32x16<S> {
    (load(simd, here, at) + load(simd, below, at)) * 0.5
}

/// The spline's values at the pixels.
#[inline(always)]
fn evaluate<S: Simd>(simd: S, coefficients: &Plane, pixels: &mut Plane, [width, height]: [usize; 2]) {
    const SHIFT: usize = RASTER_HALO - HALO;
    let Some(span) = coefficients.filled else { return };
    let first = |i: usize| i.saturating_sub(SHIFT + 1);
    let last = |i: usize, n: usize| (i + 1).saturating_sub(SHIFT).min(n);
    let (y0, y1) = (first(span.y0), last(span.y1, height));
    let (x0, x1) = (first(span.x0) / 16 * 16, last(span.x1, width));
    for y in y0..y1 {
        let rows = around(coefficients, y + SHIFT);
        let target = &mut pixels.values[y * pixels.pitch..(y + 1) * pixels.pitch];
        let mut x = x0;
        while x < x1 {
            let (left, middle, right) = (
                smooth(simd, rows, x + SHIFT - 1),
                smooth(simd, rows, x + SHIFT),
                smooth(simd, rows, x + SHIFT + 1),
            );
            ((left + right + middle * 4.0) * (1.0 / 6.0)).store_slice(&mut target[x..x + 16]);
            x += 16;
        }
    }
    if x0 < x1 && y0 < y1 {
        pixels.filled = Some(Span {
            x0,
            y0,
            x1: x0 + (x1 - x0).next_multiple_of(16),
            y1,
        });
    }
}

#[inline(always)]
fn smooth<S: Simd>(simd: S, [above, here, below]: [&[f32]; 3], at: usize) -> f32x16<S> {
    (load(simd, above, at) + load(simd, below, at) + load(simd, here, at) * 4.0) * (1.0 / 6.0)
}
