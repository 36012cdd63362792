//! Show: the field of a mesh's samples on planes, post-classified as a grid's field is.
//!
//! Each kernel carries its mass, and its value times its mass. With W and S the sums of both on a plane, the field
//! there is `v = S / W` (Shepard 1968, with elliptical kernels). Coverage is W, at most one; within the mesh it is
//! one up to the ripple of the kernels. Lighting uses the gradient of v: at the border of a mesh the samples end,
//! and the field has no surface there.

use fearless_simd::{f32x16, prelude::*};

use super::mode::CloudShading;
use crate::sheets::canvas::Canvas;
use crate::sheets::classified::ClassifiedVoxels;
use crate::sheets::footprint::Scaled;
use crate::sheets::frame::SheetFrame;
use crate::sheets::operated::Operated;
use crate::sheets::place::Place;
use crate::sheets::plane::{Plane, Span};
use crate::sheets::shade::{PlaneShader, ShadeTarget};
use crate::sheets::shaded::{interval, show};
use crate::sheets::splat::Payload;
use crate::sheets::tile::{MAX_CHANNELS, SheetScratch};

/// Least weight used as a divisor.
const LEAST: f32 = 1e-6;

/// The field of a mesh's samples, post-classified.
#[derive(Debug)]
pub(crate) struct FieldMaterial<'a> {
    pub shader: PlaneShader<'a>,
    /// Operators, clips and isosurfaces, applied pixel by pixel, where a scene has any.
    pub operated: Option<Operated<'a>>,
}

/// A weight, and a value times that.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Weighted;

impl Payload<2> for Weighted {
    type Footprint = Scaled;

    #[inline(always)]
    fn weights<S: Simd>(&self, _: S, value: f32, weight: f32x16<S>, peak: f32x16<S>) -> [f32x16<S>; 2] {
        let weight = weight * peak;
        [weight, weight * value]
    }
}

impl CloudShading<2> for FieldMaterial<'_> {
    type Payload<'m> = Weighted;

    const HALO: u8 = 1;

    fn payload(_: &ClassifiedVoxels) -> Weighted {
        Weighted
    }

    #[inline(always)]
    fn taken<S: Simd>(&self, simd: S, planes: &mut [Plane; MAX_CHANNELS]) {
        divide(simd, planes);
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
        let SheetScratch {
            planes,
            mask,
            batch,
            faces,
            ..
        } = scratch;
        let [weights, values] = of_field(planes);
        let Some((mut interval, span)) = interval(&self.shader, frame, (near, place), (values, None)) else {
            return;
        };
        interval.weights = Some(weights);
        let mut target = ShadeTarget::new((place, span), mask, canvas, batch);
        let sheet = (frame.stack.first + near as i64) as usize;
        let look = (&self.shader, self.operated.as_ref());
        show(simd, look, (&interval, sheet), (&mut target, faces));
    }
}

/// The planes of weights, and the planes of values.
pub(super) fn of_field(planes: &[[Plane; MAX_CHANNELS]; 4]) -> [[&Plane; 4]; 2] {
    [0, 1].map(|channel| planes.each_ref().map(|planes| &planes[channel]))
}

/// Divides a finished sheet's sums by their weights.
#[inline(always)]
pub(super) fn divide<S: Simd>(simd: S, [weights, sums, ..]: &mut [Plane; MAX_CHANNELS]) {
    let Some(Span { x0, y0, x1, y1 }) = weights.filled else {
        return;
    };
    let least = f32x16::splat(simd, LEAST);
    for y in y0..y1 {
        // Vectors may end behind a row.
        for x in (x0..x1).step_by(16) {
            let at = y * weights.pitch + x;
            let (Some(sums), Some(weights)) =
                (sums.values.get_mut(at..at + 16), weights.values.get(at..at + 16))
            else {
                break;
            };
            let weights = f32x16::from_slice(simd, weights).max(least);
            (f32x16::from_slice(simd, sums) / weights).store_slice(sums);
        }
    }
}
