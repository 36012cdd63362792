//! Intensity: one value of each pixel's ray. Coefficients are splatted. The largest or smallest value of the cubics
//! between planes is kept, or their mean taken (docs/numerics.md, modes mip, minip and mean).

use std::marker::PhantomData;

use fearless_simd::{f32x16, prelude::*};
use splatvol_core::bin::TileRect;
use splatvol_core::classification::ClassificationTable;
use splatvol_core::field::FieldStore;

use super::canvas::Canvas;
use super::classified::ClassifiedVoxels;
use super::cubic::{Cubic, Parabola};
use super::frame::{SheetFrame, ZonedFrame};
use super::holes::Beside;
use super::mode::{Bricks, Mode};
use super::picture::{Picture, Values};
use super::place::Place;
use super::plane::{HALO, Plane, Span};
use super::shade::{Interval, PlaneShader};
use super::shaded::interval;
use super::splat::Coefficient;
use super::tile::SheetScratch;
use crate::sheets::extremum::Extremum;
use crate::simd::math::exp2;
use splatvol_core::border::{BorderPlane, Shares};

/// One value per ray.
#[derive(Debug)]
pub(crate) struct Intensity<'a, K> {
    store: &'a FieldStore,
    rays: RayValues<'a, K>,
}

/// Reduction of values on planes to one value per ray, whatever has been splatted.
#[derive(Debug)]
pub(crate) struct RayValues<'a, K> {
    shader: PlaneShader<'a>,
    colors: ValueColors<'a>,
    kept: PhantomData<K>,
}

/// Value and coverage of a pixel along one interval.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RayInterval<S: Simd> {
    pub values: Cubic<S>,
    /// Coverage, where it is not one.
    pub coverage: Option<Parabola<S>>,
    /// Camera depth of the near end, and to the far one.
    pub depth: f32,
    pub spacing: f32,
}

/// Reduction of the values along a ray: their extremum or mean.
pub(crate) trait Reduction: Sync + Sized {
    /// The picture of these values.
    fn picture<'a>(values: Values<'a, Self>) -> Picture<'a>;

    /// Merges sixteen pixels' piece into the canvas; values outside `hull` are not shown.
    fn keep<S: Simd>(simd: S, piece: &RayInterval<S>, hull: [f32; 2], canvas: &mut Canvas, pixel: usize);

    /// Turns the reduced state into the value, in `color[0]`, and its depth, in `depth_sum`; 0 where there is no
    /// value.
    fn settle<S: Simd>(simd: S, canvas: &mut Canvas, pixel: usize);
}

/// The largest or smallest value: its rank in `color[0]`, and the depth where it is first reached in `depth_sum`.
#[derive(Debug)]
pub(crate) struct Extreme<E>(PhantomData<E>);

/// The mean value, weighted by coverage: integrals of value and coverage in `color`, the largest coverage in the
/// third channel, the integral of depth in `depth_sum`.
#[derive(Debug)]
pub(crate) struct Mean;

#[inline(always)]
fn load<S: Simd>(simd: S, plane: &[f32], at: usize) -> f32x16<S> {
    f32x16::from_slice(simd, &plane[at..at + 16])
}

/// The value of a sum; where its weight is too small, `straight`, which continues the interval.
#[inline(always)]
fn or_straight<S: Simd>(simd: S, sum: f32x16<S>, shares: &Shares<S>, straight: f32x16<S>) -> f32x16<S> {
    shares.is_faded(simd).select(straight, sum * shares.per_weight)
}

impl<E: Extremum> Reduction for Extreme<E> {
    fn picture<'a>(values: Values<'a, Self>) -> Picture<'a> {
        E::picture(values)
    }

    #[inline(always)]
    fn keep<S: Simd>(simd: S, piece: &RayInterval<S>, hull: [f32; 2], canvas: &mut Canvas, pixel: usize) {
        let cubic = E::rank_cubic(piece.values);
        let kept = load(simd, &canvas.color[0], pixel);
        let best = kept.max(f32x16::splat(simd, E::least_rank(hull)));
        if !cubic.bound.simd_gt(best).any_true() {
            return;
        }
        let (rank, u) = match piece.coverage {
            Some(coverage) => cubic.largest_covered(simd, &coverage),
            None => cubic.largest(simd),
        };
        let larger = rank.simd_gt(best);
        let depth = u * piece.spacing + piece.depth;
        larger
            .select(rank, kept)
            .store_slice(&mut canvas.color[0][pixel..pixel + 16]);
        let before = load(simd, &canvas.depth_sum, pixel);
        larger
            .select(depth, before)
            .store_slice(&mut canvas.depth_sum[pixel..pixel + 16]);
    }

    #[inline(always)]
    fn settle<S: Simd>(simd: S, canvas: &mut Canvas, pixel: usize) {
        let value = E::rank_lanes(load(simd, &canvas.color[0], pixel));
        value.store_slice(&mut canvas.color[0][pixel..pixel + 16]);
    }
}

impl Reduction for Mean {
    fn picture<'a>(values: Values<'a, Self>) -> Picture<'a> {
        Picture::Mean(values)
    }

    #[inline(always)]
    fn keep<S: Simd>(simd: S, piece: &RayInterval<S>, _: [f32; 2], canvas: &mut Canvas, pixel: usize) {
        let cubic = piece.values;
        let one = f32x16::splat(simd, 1.0);
        let ([covered, value, place], most) = match piece.coverage {
            Some(coverage) => (cubic.covered_integrals(&coverage), coverage.largest(simd)),
            None => ([one, cubic.mean(), one * 0.5], one),
        };
        let depth = place * piece.spacing + covered * piece.depth;
        let Canvas {
            color: [values, coverages, most_coverage],
            depth_sum,
            ..
        } = canvas;
        for (sum, term) in [(values, value), (coverages, covered), (depth_sum, depth)] {
            (load(simd, sum, pixel) + term).store_slice(&mut sum[pixel..pixel + 16]);
        }
        let most = load(simd, most_coverage, pixel).max(most);
        most.store_slice(&mut most_coverage[pixel..pixel + 16]);
    }

    #[inline(always)]
    fn settle<S: Simd>(simd: S, canvas: &mut Canvas, pixel: usize) {
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let inside = load(simd, &canvas.color[2], pixel).simd_ge(f32x16::splat(simd, 0.5));
        let covered = inside.select(load(simd, &canvas.color[1], pixel), one);
        let value = load(simd, &canvas.color[0], pixel) / covered;
        value.store_slice(&mut canvas.color[0][pixel..pixel + 16]);
        let depth = load(simd, &canvas.depth_sum, pixel) / covered;
        inside
            .select(depth, zero)
            .store_slice(&mut canvas.depth_sum[pixel..pixel + 16]);
    }
}

impl<'a, K: Reduction> Intensity<'a, K> {
    /// The mode for a field.
    pub(crate) fn new(store: &'a FieldStore, shader: PlaneShader<'a>, colors: ValueColors<'a>) -> Self {
        let rays = RayValues::new(shader, colors);
        Self { store, rays }
    }
}

impl<'a, K: Reduction> RayValues<'a, K> {
    pub(crate) fn new(shader: PlaneShader<'a>, colors: ValueColors<'a>) -> Self {
        Self {
            shader,
            colors,
            kept: PhantomData,
        }
    }

    /// The interval behind a sheet, and its non-empty pixels. `at_eye`: as [`SheetScratch::at_eye`].
    pub(crate) fn interval<'p>(
        &self,
        frame: &SheetFrame<'_>,
        at: (usize, &Place),
        planes: ([&'p Plane; 4], Option<[f32; 3]>),
    ) -> Option<(Interval<'p>, Span)> {
        interval(&self.shader, frame, at, planes)
    }

    /// Merges an interval's values into the canvas.
    #[inline(always)]
    pub(crate) fn keep<S: Simd>(
        &self,
        simd: S,
        (interval, span): (&Interval<'_>, Span),
        place: &Place,
        canvas: &mut Canvas,
    ) {
        let [near, far] = interval.depths;
        let [middle, _] = self.shader.borders([0.5 * (near + far); 2]);
        let spacing = self.shader.spacing;
        let outer = self.shader.borders([near - spacing, far + spacing]);
        let around = Around { middle, outer };
        for y in span.y0..span.y1 {
            let mut x = span.x0 / 16 * 16;
            while x < span.x1 {
                let piece = self.piece(simd, (interval, &around, place), [x, y]);
                let pixel = y * canvas.pitch + x;
                K::keep(simd, &piece, self.shader.table.hull, canvas, pixel);
                x += 16;
            }
        }
    }

    /// Converts the reduced values to pixels.
    #[inline(always)]
    pub(crate) fn finish<S: Simd>(&self, simd: S, canvas: &mut Canvas) {
        self.colors.finish::<S, K>(simd, canvas);
    }

    /// Piece of sixteen pixels in an interval.
    #[inline(always)]
    fn piece<S: Simd>(
        &self,
        simd: S,
        (interval, around, place): (&Interval<'_>, &Around, &Place),
        [x, y]: [usize; 2],
    ) -> RayInterval<S> {
        let in_picture = [place.rect.x0 + x, place.rect.y0 + y];
        let at = (y + HALO) * interval.planes[0].pitch + x + HALO;
        let border = &self.shader.border;
        let near_border = interval.is_near_border
            && interval
                .borders
                .iter()
                .any(|plane| border.is_near(plane, in_picture));
        let background = self.shader.background;
        let [before, near, far, after] = interval.planes;
        let mut values = [
            load(simd, &before.values, at),
            load(simd, &near.values, at),
            load(simd, &far.values, at),
            load(simd, &after.values, at),
        ];
        let mut coverage = None;
        let mut borders = None;
        if near_border {
            let [from, to] = &interval.borders;
            let from = border.at(simd, from, in_picture);
            let to = border.at(simd, to, in_picture);
            let middle = border.at(simd, &around.middle, in_picture);
            let along = [from.coverage, middle.coverage, to.coverage];
            coverage = Some(Parabola::through(along));
            let [near, far] = [values[1] * from.per_weight, values[2] * to.per_weight];
            let before = border.at(simd, &around.outer[0], in_picture);
            let after = border.at(simd, &around.outer[1], in_picture);
            // Planes too far outside have no value: the slope is that of the interval.
            values = [
                or_straight(simd, values[0], &before, near * 2.0 - far),
                near,
                far,
                or_straight(simd, values[3], &after, far * 2.0 - near),
            ];
            borders = Some((along, [before, from, to, after]));
        }
        if let Some(mut missing) = interval.missing(simd, at) {
            let mut along = [f32x16::splat(simd, 1.0); 3];
            if let Some((border, shares)) = borders {
                let zero = f32x16::splat(simd, 0.0);
                along = border;
                for (missing, shares) in missing.iter_mut().zip(&shares) {
                    *missing = shares.is_faded(simd).select(zero, *missing * shares.per_weight);
                }
            }
            let beside = Beside::of(simd, interval, values, missing);
            values = beside.values;
            coverage = Some(Parabola::through(beside.covered_along(simd, along)));
        }
        for value in &mut values {
            *value += background;
        }
        RayInterval {
            values: Cubic::through(values),
            coverage,
            depth: interval.depths[0],
            spacing: self.shader.spacing,
        }
    }
}

/// Transfer function for values that are shown by themselves.
#[derive(Debug)]
pub(crate) struct ValueColors<'a> {
    table: &'a ClassificationTable,
    /// World length over which a value's opacity is taken.
    unit_distance: f32,
}

impl<'a> ValueColors<'a> {
    pub(crate) fn new(table: &'a ClassificationTable, unit_distance: f64) -> Self {
        Self {
            table,
            unit_distance: unit_distance as f32,
        }
    }

    /// Replaces the reduced value by its colour, with the opacity of the unit distance.
    #[inline(always)]
    pub(crate) fn finish<S: Simd, K: Reduction>(&self, simd: S, canvas: &mut Canvas) {
        for pixel in (0..canvas.depth_sum.len()).step_by(16) {
            K::settle(simd, canvas, pixel);
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

/// Border on the planes beside an interval's own: in the middle, before and behind.
#[derive(Debug)]
struct Around {
    middle: BorderPlane,
    outer: [BorderPlane; 2],
}

impl<K: Reduction> Mode<1> for Intensity<'_, K> {
    type Payload<'m> = Coefficient;

    fn payload(_: &ClassifiedVoxels) -> Coefficient {
        Coefficient
    }

    #[inline(always)]
    fn bricks(&self) -> Bricks<'_> {
        Bricks::Field(self.store)
    }

    #[inline(always)]
    fn shade<S: Simd>(
        &self,
        simd: S,
        frame: &SheetFrame<'_>,
        near: usize,
        place: &Place,
        (canvas, scratch): (&mut Canvas, &mut SheetScratch),
    ) {
        let planes = scratch.planes.each_ref().map(|plane| &plane[0]);
        let planes = (planes, scratch.at_eye);
        let Some((mut interval, span)) = self.rays.interval(frame, (near, place), planes) else {
            return;
        };
        if self.has_holes() {
            interval.leave_out(&scratch.holes, self.rays.shader.background);
        }
        self.rays.keep(simd, (&interval, span), place, canvas);
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: &ZonedFrame<'_>, _: &TileRect, canvas: &mut Canvas) {
        self.rays.finish(simd, canvas);
    }
}
