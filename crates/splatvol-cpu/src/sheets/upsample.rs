//! Upsample: sheets of coarse rasters to pixels.
//!
//! Big footprints are splatted narrower onto a raster of `step` pixels, whose points are the coefficients of a
//! cubic B-spline. The spline adds a variance of a third of a raster step squared, by which the footprints were
//! narrowed. So the cost of a voxel does not grow with the zoom. The spline is evaluated by subdivision: its
//! coefficients on the raster twice as fine are `(c[i-1] + 6 c[i] + c[i+1]) / 8` and `(c[i] + c[i+1]) / 2`, and at
//! pixels its value is `(c[i-1] + 4 c[i] + c[i+1]) / 6`.
//!
//! A spline has the footprint's variance but not its fourth moment. Waves of the data of 3.3 raster steps, which voxels
//! of 1.7 steps can hold, lose 1.8 % of their height, and leave as much of the raster's pattern. So the coarsest raster
//! of values is refined by other weights ([`COARSEST`]), which leave a third of that. Some of them are negative: amounts, as
//! extinctions are, keep the spline's.

use fearless_simd::{f32x16, prelude::*};

use super::place::Place;
use super::plane::{HALO, Plane, Span};

/// Raster points around a tile that its pixels need, at every step of the subdivision; even, as blocks are.
pub(crate) const RASTER_HALO: usize = 4;

/// A subdivision: coefficients of the raster twice as fine, from those at and around a coarse point, and from those on
/// both sides of the middle between two.
#[derive(Debug)]
struct Rule<const EVEN: usize, const ODD: usize> {
    even: [f32; EVEN],
    odd: [f32; ODD],
}

/// That of the cubic B-spline.
const CUBIC: Rule<2, 1> = Rule {
    even: [0.75, 0.125],
    odd: [0.5],
};

/// The coarsest raster's: of all rules of this size that keep a constant, the one with the least squares of differences
/// from whole footprints and their slopes, for waves of the data up to 0.95 times the Nyquist frequency with a spectrum
/// of 1 / frequency, kernels of 0.64 and 0.74 voxels, and 1 to 2.3 raster points per standard deviation, many counting
/// more than few. The footprints' own variance and the subdivisions to come are the spline's.
const COARSEST: Rule<3, 3> = Rule {
    even: [0.716926, 0.147511, -0.005974],
    odd: [0.509201, -0.014124, 0.004923],
};

impl<const EVEN: usize, const ODD: usize> Rule<EVEN, ODD> {
    /// Fine points from a coarse one within which its coefficient counts.
    const REACH: usize = if EVEN > ODD { 2 * EVEN - 2 } else { 2 * ODD - 1 };

    /// Fine coefficients at sixteen coarse points from `at` on, which lie `apart` from their neighbours.
    #[inline(always)]
    fn even<S: Simd>(&self, simd: S, values: &[f32], (at, apart): (usize, usize)) -> f32x16<S> {
        let mut sum = load(simd, values, at) * self.even[0];
        for k in 1..EVEN {
            let both = load(simd, values, at - k * apart) + load(simd, values, at + k * apart);
            sum = both * self.even[k] + sum;
        }
        sum
    }

    /// Fine coefficients in the middle between these points and the next.
    #[inline(always)]
    fn odd<S: Simd>(&self, simd: S, values: &[f32], (at, apart): (usize, usize)) -> f32x16<S> {
        let mut sum = (load(simd, values, at) + load(simd, values, at + apart)) * self.odd[0];
        for k in 1..ODD {
            let both = load(simd, values, at - k * apart) + load(simd, values, at + (k + 1) * apart);
            sum = both * self.odd[k] + sum;
        }
        sum
    }
}

/// What coefficients add up to.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Sums {
    /// Values of a field: its waves keep their height.
    Values,
    /// Extinctions, emissions and weights of clouds: never negative, nor are the spline's pixels.
    Amounts,
}

/// Memory for the steps between.
#[derive(Debug, Default)]
pub(crate) struct Upsampler {
    planes: [Plane; 2],
    row: Vec<f32>,
}

#[inline(always)]
fn load<S: Simd>(simd: S, row: &[f32], at: usize) -> f32x16<S> {
    f32x16::from_slice(simd, &row[at..at + 16])
}

impl Upsampler {
    /// Pixels of a tile, with a halo, from its raster of every `step`-th pixel.
    #[inline(always)]
    pub(crate) fn run<S: Simd>(
        &mut self,
        simd: S,
        raster: &Plane,
        pixels: &mut Plane,
        (place, step, sums): (&Place, usize, Sums),
    ) {
        pixels.clear();
        if raster.filled.is_none() {
            return;
        }
        let Self {
            planes: [even, odd],
            row,
        } = self;
        let mut finer = Finer::than(place, step);
        let target = (raster, &mut *even, &mut *row);
        match sums {
            Sums::Values => subdivide(simd, target, &finer, &COARSEST),
            Sums::Amounts => subdivide(simd, target, &finer, &CUBIC),
        }
        let (mut from, mut to) = (even, odd);
        while finer.step > 1 {
            finer = finer.next(place);
            subdivide(simd, (from, to, row), &finer, &CUBIC);
            std::mem::swap(&mut from, &mut to);
        }
        evaluate(simd, (from, pixels, row), place.size.map(|n| n + 2 * HALO));
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

/// Coefficients of the raster twice as fine; not those of its last row.
#[inline(always)]
fn subdivide<S: Simd, const EVEN: usize, const ODD: usize>(
    simd: S,
    (coarse, fine, row): (&Plane, &mut Plane, &mut Vec<f32>),
    finer: &Finer,
    rule: &Rule<EVEN, ODD>,
) {
    fine.reset(finer.size);
    row.resize(coarse.pitch, 0.0);
    let Some(span) = coarse.filled else { return };
    let ([width, height], [skip_x, skip_y]) = (finer.size, finer.skipped);
    // Point i of the coarse raster is point 2 (i - skipped) - RASTER_HALO of the fine one.
    let reach = Rule::<EVEN, ODD>::REACH;
    let first = |i: usize, skip: usize| (2 * i).saturating_sub(RASTER_HALO + reach + 2 * skip);
    let last =
        |i: usize, skip: usize, n: usize| (2 * i + reach).saturating_sub(RASTER_HALO + 2 * skip).min(n);
    let (y0, y1) = (first(span.y0, skip_y), last(span.y1, skip_y, height - 1));
    let (x0, x1) = (first(span.x0, skip_x) / 32 * 32, last(span.x1, skip_x, width));
    if x0 >= x1 || y0 >= y1 {
        return;
    }
    let column = |x: usize| x / 2 + RASTER_HALO / 2 + skip_x;
    let (from, to) = (
        column(x0) - RASTER_HALO / 2,
        column(x1.next_multiple_of(32)) + RASTER_HALO,
    );
    for y in y0..y1 {
        let above = (y / 2 + RASTER_HALO / 2 + skip_y) * coarse.pitch;
        for at in (from..to).step_by(16) {
            let middle = (above + at, coarse.pitch);
            let sum = match y % 2 {
                0 => rule.even(simd, &coarse.values, middle),
                _ => rule.odd(simd, &coarse.values, middle),
            };
            sum.store_slice(&mut row[at..at + 16]);
        }
        let target = &mut fine.values[y * fine.pitch..(y + 1) * fine.pitch];
        for x in (x0..x1).step_by(32) {
            let middle = (column(x), 1);
            let (evens, odds) = (rule.even(simd, row, middle), rule.odd(simd, row, middle));
            let (low, high) = simd.interleave_f32x16(evens, odds);
            low.store_slice(&mut target[x..x + 16]);
            high.store_slice(&mut target[x + 16..x + 32]);
        }
    }
    fine.filled = Some(Span {
        x0,
        y0,
        x1: x0 + (x1 - x0).next_multiple_of(32),
        y1,
    });
}

/// The spline's values at the pixels.
#[inline(always)]
fn evaluate<S: Simd>(
    simd: S,
    (coefficients, pixels, row): (&Plane, &mut Plane, &mut Vec<f32>),
    [width, height]: [usize; 2],
) {
    const SHIFT: usize = RASTER_HALO - HALO;
    let Some(span) = coefficients.filled else { return };
    row.resize(coefficients.pitch, 0.0);
    let first = |i: usize| i.saturating_sub(SHIFT + 1);
    let last = |i: usize, n: usize| (i + 1).saturating_sub(SHIFT).min(n);
    let (y0, y1) = (first(span.y0), last(span.y1, height));
    let (x0, x1) = (first(span.x0) / 16 * 16, last(span.x1, width));
    if x0 >= x1 || y0 >= y1 {
        return;
    }
    for y in y0..y1 {
        for at in (x0..x1 + 16).step_by(16) {
            let middle = ((y + SHIFT) * coefficients.pitch + at, coefficients.pitch);
            value(simd, &coefficients.values, middle).store_slice(&mut row[at..at + 16]);
        }
        let target = &mut pixels.values[y * pixels.pitch..(y + 1) * pixels.pitch];
        for x in (x0..x1).step_by(16) {
            value(simd, row, (x + SHIFT, 1)).store_slice(&mut target[x..x + 16]);
        }
    }
    pixels.filled = Some(Span {
        x0,
        y0,
        x1: x0 + (x1 - x0).next_multiple_of(16),
        y1,
    });
}

/// The spline at sixteen of its points from `at` on, which lie `apart` from their neighbours.
#[inline(always)]
fn value<S: Simd>(simd: S, coefficients: &[f32], (at, apart): (usize, usize)) -> f32x16<S> {
    let beside = load(simd, coefficients, at - apart) + load(simd, coefficients, at + apart);
    (load(simd, coefficients, at) * 4.0 + beside) * (1.0 / 6.0)
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};
    use splatvol_core::bin::TileRect;

    use super::*;

    /// A wave of samples `cos(2 pi f j)`, splatted by Gaussians of a width in pixels, `pitch` pixels apart.
    struct Wave {
        frequency: f64,
        pitch: f64,
        width: f64,
    }

    impl Wave {
        /// Its value at a pixel, with Gaussians narrowed by a variance in pixels.
        fn at(&self, pixel: f64, narrowed: f64) -> f64 {
            let variance = self.width * self.width - narrowed;
            let peak = self.pitch / (2.0 * std::f64::consts::PI * variance).sqrt();
            let middle = (pixel / self.pitch).round() as i32;
            (middle - 8..=middle + 8)
                .map(|j| {
                    let offset = pixel - f64::from(j) * self.pitch;
                    let sample = (2.0 * std::f64::consts::PI * self.frequency * f64::from(j)).cos();
                    sample * peak * (-0.5 * offset * offset / variance).exp()
                })
                .sum()
        }
    }

    /// Largest difference of a tile's upsampled pixels from a wave in x times a constant in y, and of their slopes per
    /// voxel.
    fn errors(wave: &Wave, step: usize, rect: TileRect) -> [f64; 2] {
        let constant = Wave {
            frequency: 0.0,
            ..*wave
        };
        let place = Place::new(rect, step);
        let narrowed = (step * step) as f64 / 3.0;
        let mut raster = Plane::default();
        raster.reset(place.raster);
        let [columns, rows] = [0, 1].map(|axis| {
            let own = if axis == 0 { wave } else { &constant };
            let point = |i: usize| place.first[axis] + i as i32 - RASTER_HALO as i32;
            (0..place.raster[axis])
                .map(|i| own.at(f64::from(point(i)) * step as f64, narrowed))
                .collect::<Vec<_>>()
        });
        for (y, row) in rows.iter().enumerate() {
            for (x, column) in columns.iter().enumerate() {
                raster.values[y * raster.pitch + x] = (row * column) as f32;
            }
        }
        raster.filled = Some(Span {
            x0: 0,
            y0: 0,
            x1: place.raster[0],
            y1: place.raster[1],
        });
        let mut pixels = Plane::default();
        let [width, height] = place.size.map(|n| n + 2 * HALO);
        pixels.reset([width, height]);
        let mut upsampler = Upsampler::default();
        dispatch!(Level::new(), simd => upsampler.run(simd, &raster, &mut pixels, (&place, step, Sums::Values)));
        let mut most = [0.0f64; 2];
        for y in 0..height {
            let row = constant.at((rect.y0 + y) as f64 - HALO as f64, 0.0);
            let error = |x: usize| {
                let wanted = row * wave.at((rect.x0 + x) as f64 - HALO as f64, 0.0);
                f64::from(pixels.values[y * pixels.pitch + x]) - wanted
            };
            for x in 1..width {
                most[0] = most[0].max(error(x).abs());
                most[1] = most[1].max((error(x) - error(x - 1)).abs() * wave.pitch);
            }
        }
        most
    }

    fn tiles() -> [TileRect; 4] {
        [
            [0, 0, 64, 32],
            [24, 40, 88, 72],
            [128, 132, 165, 149],
            [16, 48, 32, 64],
        ]
        .map(|[x0, y0, x1, y1]| TileRect { x0, y0, x1, y1 })
    }

    /// The kernel of `best`, 1.33 raster points wide, and that of `fast`, 1.4 wide.
    fn kernels() -> [(f64, f64); 2] {
        [(0.74, 1.8), (0.64, 2.2)]
    }

    #[test]
    fn waves_of_the_data_keep_their_height() {
        for ((sigma, points), step, rect) in kernels().into_iter().flat_map(|kernel| {
            [2usize, 4, 8, 32]
                .into_iter()
                .flat_map(move |step| tiles().map(|rect| (kernel, step, rect)))
        }) {
            let pitch = points * step as f64;
            let (width, frequencies) = (sigma * pitch, [0.0, 0.125, 0.25, 0.375, 0.45]);
            // The spline alone: 6.6e-4, 8.3e-4, 1.7e-3, 3.7e-3, 3.9e-3; slopes 2.4e-3, 4.1e-3, 1.1e-2, 2.2e-2, 2.5e-2.
            let most = [7e-4, 7.5e-4, 9e-4, 1.3e-3, 1.7e-3]
                .into_iter()
                .zip([2.4e-3, 3.4e-3, 4.7e-3, 6.7e-3, 7.3e-3]);
            for (frequency, most) in frequencies.into_iter().zip(most) {
                let wave = Wave {
                    frequency,
                    pitch,
                    width,
                };
                let [value, slope] = errors(&wave, step, rect);
                assert!(
                    value < most.0 && slope < most.1,
                    "{sigma} {points} step {step} {rect:?}, frequency {frequency}: {value} {slope}"
                );
            }
        }
    }

    /// Pixels of a tile from a raster of noise, and of garbage where the tile has no points.
    fn pixels(step: usize, rect: TileRect) -> (Place, Plane) {
        let place = Place::new(rect, step);
        let mut raster = Plane::default();
        raster.reset(place.raster);
        raster.values.fill(f32::NAN);
        let [width, height] = place.raster;
        for y in 0..height {
            for x in 0..width {
                let point = [x as i32 + place.first[0], y as i32 + place.first[1]];
                let noise = (point[0] * 7919 + point[1] * 104_729).rem_euclid(1013);
                raster.values[y * raster.pitch + x] = noise as f32 / 1013.0;
            }
        }
        raster.filled = Some(Span {
            x0: 0,
            y0: 0,
            x1: width,
            y1: height,
        });
        let mut pixels = Plane::default();
        pixels.reset(place.size.map(|n| n + 2 * HALO));
        let mut upsampler = Upsampler::default();
        dispatch!(Level::new(), simd => upsampler.run(simd, &raster, &mut pixels, (&place, step, Sums::Values)));
        (place, pixels)
    }

    #[test]
    fn pixels_do_not_depend_on_tiles() {
        let rect = |[x0, y0, x1, y1]: [usize; 4]| TileRect { x0, y0, x1, y1 };
        for step in [2, 4, 8, 16, 32, 64] {
            let (_, whole) = pixels(step, rect([0, 0, 128, 128]));
            for tile in [
                [48, 96, 64, 112],
                [64, 64, 128, 128],
                [0, 64, 64, 128],
                [48, 96, 96, 128],
                [16, 16, 32, 32],
            ] {
                let tile = rect(tile);
                let (place, own) = pixels(step, tile);
                for y in 0..place.size[1] + 2 * HALO {
                    for x in 0..place.size[0] + 2 * HALO {
                        let found = own.values[y * own.pitch + x];
                        let wanted = whole.values[(tile.y0 + y) * whole.pitch + tile.x0 + x];
                        assert_eq!(found, wanted, "step {step} {tile:?} {x} {y}");
                    }
                }
            }
        }
    }
}
