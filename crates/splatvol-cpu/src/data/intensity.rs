//! Maximum intensity: coefficients are splatted, the largest value along each pixel's ray is kept.
//!
//! Between two planes the value is the cubic of `shade`. It lies within its Bezier points, which most intervals' are all
//! below what the pixel has; else its largest value is one of the ends', or at the root `b / (sqrt(c^2 - 3 b d) - c)` of its
//! derivative. Near the volume's border, where only covered points count, it is sampled.

use fearless_simd::{f32x16, prelude::*};
use splatvol_core::classification::ClassificationTable;
use splatvol_core::field::FieldStore;
use splatvol_core::visibility::BRICK_VOXELS;

use super::border::BorderPlane;
use super::classified::Classified;
use super::mode::Mode;
use super::plane::HALO;
use super::shade::{Canvas, Interval, PlaneShader};
use super::shaded::interval;
use super::splat::Coefficient;
use super::tile::{DataFrame, DataScratch, Place};
use crate::stage::simd_exp::exp2;

/// Maximum intensity.
#[derive(Debug)]
pub(crate) struct Intensity<'a> {
    store: &'a FieldStore,
    shader: PlaneShader<'a>,
    table: &'a ClassificationTable,
    /// World length whose opacity a maximum has.
    unit_distance: f32,
    /// Values up to this show nothing.
    floor: f32,
}

/// Points of an interval that are looked at near the border.
const STEPS: usize = 8;

/// The cubic between two planes, `a + u (b + u (c + u d))`.
#[derive(Debug, Clone, Copy)]
struct Cubic<S: Simd> {
    a: f32x16<S>,
    b: f32x16<S>,
    c: f32x16<S>,
    d: f32x16<S>,
    end: f32x16<S>,
    /// No value exceeds it.
    bound: f32x16<S>,
}

#[inline(always)]
fn load<S: Simd>(simd: S, plane: &[f32], at: usize) -> f32x16<S> {
    f32x16::from_slice(simd, &plane[at..at + 16])
}

impl<S: Simd> Cubic<S> {
    /// Through the middle two of four values with the slopes that the outer ones give.
    #[inline(always)]
    fn through([before, near, far, after]: [f32x16<S>; 4]) -> Self {
        let rise = far - near;
        let (start, end) = ((far - before) * 0.5, (after - near) * 0.5);
        Self {
            a: near,
            b: start,
            c: rise * 3.0 - start * 2.0 - end,
            d: start + end - rise * 2.0,
            end: far,
            bound: near
                .max(far)
                .max((near + start * (1.0 / 3.0)).max(far - end * (1.0 / 3.0))),
        }
    }

    #[inline(always)]
    fn at(&self, u: f32x16<S>) -> f32x16<S> {
        ((self.d * u + self.c) * u + self.b) * u + self.a
    }

    /// Its largest value, and where.
    #[inline(always)]
    fn largest(&self, simd: S) -> (f32x16<S>, f32x16<S>) {
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let square = self.c * self.c - self.b * self.d * 3.0;
        let root = square.max(zero).sqrt() - self.c;
        let inside = square.simd_gt(zero) & root.simd_gt(self.b) & self.b.simd_gt(zero);
        let u = self.b / inside.select(root, one);
        let ends = self.a.max(self.end);
        let place = self.a.simd_ge(self.end).select(zero, one);
        let value = self.at(u);
        let peak = inside & value.simd_gt(ends);
        (peak.select(value, ends), peak.select(u, place))
    }

    /// The largest of its values where the coverage, the parabola through its values at both ends and in the middle, is a
    /// half and more; -1 where it is nowhere.
    #[inline(always)]
    fn largest_covered(&self, simd: S, [from, middle, to]: [f32x16<S>; 3]) -> (f32x16<S>, f32x16<S>) {
        let bend = (from + to) * 2.0 - middle * 4.0;
        let slope = to - from - bend;
        let mut best = (f32x16::splat(simd, -1.0), f32x16::splat(simd, 0.0));
        for step in 0..=STEPS {
            let u = f32x16::splat(simd, step as f32 / STEPS as f32);
            let value = self.at(u);
            let coverage = (bend * u + slope) * u + from;
            let better = coverage.simd_ge(f32x16::splat(simd, 0.5)) & value.simd_gt(best.0);
            best = (better.select(value, best.0), better.select(u, best.1));
        }
        best
    }
}

impl<'a> Intensity<'a> {
    /// The mode for a field, with its classification and the world length whose opacity a maximum has.
    pub(crate) fn new(
        store: &'a FieldStore,
        shader: PlaneShader<'a>,
        (table, unit_distance): (&'a ClassificationTable, f64),
    ) -> Self {
        Self {
            store,
            table,
            unit_distance: unit_distance as f32,
            floor: shader.table.hull[0].max(0.0),
            shader,
        }
    }

    /// Keeps what is larger in an interval than what sixteen pixels have.
    #[inline(always)]
    fn keep<S: Simd>(
        &self,
        simd: S,
        (interval, middle, place): (&Interval<'_>, &BorderPlane, &Place),
        canvas: &mut Canvas,
        [x, y]: [usize; 2],
    ) {
        let in_picture = [place.rect.x0 + x, place.rect.y0 + y];
        let pixel = y * canvas.pitch + x;
        let best = load(simd, &canvas.color[0], pixel);
        let at = (y + HALO) * interval.planes[0].pitch + x + HALO;
        let near_border = interval.is_near_border
            && interval
                .borders
                .iter()
                .any(|plane| self.shader.border.is_near(plane, in_picture));
        let one = f32x16::splat(simd, 1.0);
        let (mut weights, mut coverage) = ([one; 2], [one; 3]);
        if near_border {
            for end in 0..2 {
                let shares = self.shader.border.at(simd, &interval.borders[end], in_picture);
                (weights[end], coverage[2 * end]) = (shares.per_weight, shares.coverage);
            }
            coverage[1] = self.shader.border.at(simd, middle, in_picture).coverage;
        }
        let [before, near, far, after] = interval.planes;
        let background = self.shader.background;
        let cubic = Cubic::through([
            load(simd, &before.values, at) * weights[0] + background,
            load(simd, &near.values, at) * weights[0] + background,
            load(simd, &far.values, at) * weights[1] + background,
            load(simd, &after.values, at) * weights[1] + background,
        ]);
        let best = best.max(f32x16::splat(simd, self.floor));
        if !cubic.bound.simd_gt(best).any_true() {
            return;
        }
        let (value, u) = if near_border {
            cubic.largest_covered(simd, coverage)
        } else {
            cubic.largest(simd)
        };
        let larger = value.simd_gt(best);
        let depth = u * self.shader.spacing + interval.depths[0];
        let before = load(simd, &canvas.color[0], pixel);
        larger
            .select(value, before)
            .store_slice(&mut canvas.color[0][pixel..pixel + 16]);
        let before = load(simd, &canvas.depth_sum, pixel);
        larger
            .select(depth, before)
            .store_slice(&mut canvas.depth_sum[pixel..pixel + 16]);
    }
}

impl Mode<1> for Intensity<'_> {
    type Payload<'m> = Coefficient;

    fn payload(_: &Classified) -> Coefficient {
        Coefficient
    }

    #[inline(always)]
    fn touch(&self, brick: usize) {
        self.store.touch(brick);
    }

    #[inline(always)]
    fn open<S: Simd>(
        &self,
        _: S,
        (brick, _): (usize, u32),
        values: &mut [f32; BRICK_VOXELS],
        _: &mut Classified,
    ) {
        self.store.decode(brick, values);
    }

    #[inline(always)]
    fn shade<S: Simd>(
        &self,
        simd: S,
        frame: &DataFrame<'_>,
        near: usize,
        place: &Place,
        (canvas, scratch): (&mut Canvas, &mut DataScratch),
    ) {
        let planes = scratch.planes.each_ref().map(|plane| &plane[0]);
        let Some((interval, span)) = interval(&self.shader, frame, (near, place), planes) else {
            return;
        };
        let middle = 0.5 * (interval.depths[0] + interval.depths[1]);
        let [middle, _] = self.shader.borders([middle; 2]);
        for y in span.y0..span.y1 {
            let mut x = span.x0 / 16 * 16;
            while x < span.x1 {
                self.keep(simd, (&interval, &middle, place), canvas, [x, y]);
                x += 16;
            }
        }
    }

    /// The largest value in its colour, as thick as the unit distance.
    #[inline(always)]
    fn finish<S: Simd>(
        &self,
        simd: S,
        _: &DataFrame<'_>,
        _: &Place,
        (canvas, _): (&mut Canvas, &mut DataScratch),
    ) {
        for pixel in (0..canvas.depth_sum.len()).step_by(16) {
            let depth = load(simd, &canvas.depth_sum, pixel);
            let zero = f32x16::splat(simd, 0.0);
            let (mut extinction, mut color) = ([0.0; 16], [[0.0; 16]; 3]);
            if depth.simd_gt(zero).any_true() {
                for lane in 0..16 {
                    let [value, emission @ ..] = self.table.at(canvas.color[0][pixel + lane]);
                    if value > 0.0 && canvas.depth_sum[pixel + lane] > 0.0 {
                        extinction[lane] = value;
                        for c in 0..3 {
                            color[c][lane] = emission[c] / value;
                        }
                    }
                }
            }
            let per_extinction = -self.unit_distance * std::f32::consts::LOG2_E;
            let through = exp2(simd, f32x16::from_slice(simd, &extinction) * per_extinction);
            let alpha = 1.0 - through;
            through.store_slice(&mut canvas.transmittance[pixel..pixel + 16]);
            (depth * alpha).store_slice(&mut canvas.depth_sum[pixel..pixel + 16]);
            for c in 0..3 {
                (f32x16::from_slice(simd, &color[c]) * alpha)
                    .store_slice(&mut canvas.color[c][pixel..pixel + 16]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};

    use super::*;

    /// Largest value and where, by the closed form and by many samples, for sixteen quadruples of values.
    #[inline(always)]
    fn both<S: Simd>(simd: S, values: [[f32; 16]; 4]) -> [[f32; 16]; 3] {
        let cubic = Cubic::through(values.map(|v| f32x16::from_slice(simd, &v)));
        let (value, place) = cubic.largest(simd);
        let mut sampled = cubic.at(f32x16::splat(simd, 0.0));
        for i in 1..=4000 {
            sampled = sampled.max(cubic.at(f32x16::splat(simd, i as f32 / 4000.0)));
        }
        let at_place = (cubic.at(place) - value).abs();
        assert!(
            (cubic.bound + 1e-6).simd_ge(sampled).all_true(),
            "the bound holds"
        );
        [value, sampled, at_place].map(|v| v.as_slice().try_into().expect("sixteen lanes"))
    }

    #[test]
    fn the_largest_value_of_an_interval_is_that_of_many_samples() {
        let unit = |seed: usize| (seed.wrapping_mul(0x9e37_79b9) >> 7 & 0xfff) as f32 / 4095.0;
        for round in 0..50 {
            let mut values: [[f32; 16]; 4] =
                std::array::from_fn(|i| std::array::from_fn(|lane| unit((round * 4 + i) * 16 + lane)));
            if round == 0 {
                values = [[0.25; 16]; 4];
            }
            let [value, sampled, at_place] = dispatch!(Level::new(), simd => both(simd, values));
            for lane in 0..16 {
                assert!((value[lane] - sampled[lane]).abs() < 2e-6, "{round} {lane}");
                assert!(at_place[lane] < 1e-6, "{round} {lane}");
            }
        }
    }
}
