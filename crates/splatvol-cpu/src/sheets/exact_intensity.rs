//! Exact intensity: one value of each pixel's ray, of cubics with exact slopes. Coefficients are splatted with
//! their kernels' derivatives along the rays.

use std::marker::PhantomData;

use fearless_simd::{f32x16, prelude::*};
use splatvol_core::bin::TileRect;

use super::analytic::{AnalyticField, AnalyticInterval};
use super::canvas::Canvas;
use super::classified::ClassifiedVoxels;
use super::cubic::Parabola;
use super::frame::{SheetFrame, ZonedFrame};
use super::intensity::{RayInterval, Reduction, ValueColors};
use super::lattice_weights::{WeightPlane, Weights};
use super::mode::{Bricks, Mode};
use super::place::Place;
use super::slopes::Slopes;
use super::tile::SheetScratch;

/// One value per ray.
#[derive(Debug)]
pub(crate) struct ExactIntensity<'a, K> {
    field: AnalyticField<'a>,
    colors: ValueColors<'a>,
    kept: PhantomData<K>,
}

impl<'a, K: Reduction> ExactIntensity<'a, K> {
    pub(crate) fn new(field: AnalyticField<'a>, colors: ValueColors<'a>) -> Self {
        Self {
            field,
            colors,
            kept: PhantomData,
        }
    }

    /// Piece of sixteen pixels in an interval, given the plane in its middle.
    #[inline(always)]
    fn piece<S: Simd>(
        &self,
        simd: S,
        (interval, middle): (&AnalyticInterval<'_>, &WeightPlane),
        place: [usize; 2],
    ) -> RayInterval<S> {
        let (along, rays) = self.field.along_rays(simd, interval, place);
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let in_picture = interval.in_picture(place);
        let is_near_face = self.field.is_near_face(interval, in_picture);
        let missing = interval.missing_between(simd, &rays, place);
        RayInterval {
            values: along.values(),
            coverage: (is_near_face || missing.is_some()).then(|| {
                let mut middle = match is_near_face {
                    true => self.field.weights.at(simd, middle, in_picture),
                    false => Weights::inside(simd),
                };
                if let Some(missing) = missing {
                    middle.leave_out(simd, missing, [zero; 3]);
                }
                Parabola::through([
                    along.coverage(simd, zero),
                    middle.coverage(simd),
                    along.coverage(simd, one),
                ])
            }),
            depth: interval.depth,
            spacing: self.field.shader.spacing,
        }
    }
}

impl<K: Reduction> Mode<2> for ExactIntensity<'_, K> {
    type Payload<'m> = Slopes;

    fn payload(_: &ClassifiedVoxels) -> Slopes {
        Slopes
    }

    #[inline(always)]
    fn bricks(&self) -> Bricks<'_> {
        Bricks::Field(self.field.store)
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
        let planes = (&scratch.planes, &scratch.holes, scratch.at_eye);
        let Some((interval, span)) = self.field.interval(frame, (near, place), planes) else {
            return;
        };
        let shader = &self.field.shader;
        let [first, second] = [near, near + 1].map(|sheet| frame.sheets[sheet]);
        let middle = self.field.weights.on_plane(
            shader.pixels(0.5 * (first.depth + second.depth)),
            0.5 * (first.low_pass + second.low_pass),
        );
        for y in span.y0..span.y1 {
            let mut x = span.x0 / 16 * 16;
            while x < span.x1 {
                let piece = self.piece(simd, (&interval, &middle), [x, y]);
                let pixel = y * canvas.pitch + x;
                K::keep(simd, &piece, shader.table.hull, canvas, pixel);
                x += 16;
            }
        }
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: &ZonedFrame<'_>, _: &TileRect, canvas: &mut Canvas) {
        self.colors.finish::<S, K>(simd, canvas);
    }
}
