//! Post-classification: coefficients are splatted, intervals between planes are classified, lit and composited.

use fearless_simd::prelude::*;
use splatvol_core::field::FieldStore;

use super::canvas::Canvas;
use super::classified::ClassifiedVoxels;
use super::frame::SheetFrame;
use super::mode::{Bricks, Mode};
use super::operated::{Faces, Operated};
use super::place::Place;
use super::plane::{HALO, Plane, Span};
use super::shade::{Interval, PlaneShader, ShadeTarget};
use super::splat::Coefficient;
use super::tile::SheetScratch;

/// Post-classification.
#[derive(Debug)]
pub(crate) struct Shaded<'a> {
    pub store: &'a FieldStore,
    pub shader: PlaneShader<'a>,
    /// Operators, clips and isosurfaces, applied pixel by pixel, where a scene has any.
    pub operated: Option<Operated<'a>>,
}

impl Mode<1> for Shaded<'_> {
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
        let SheetScratch {
            planes,
            mask,
            batch,
            faces,
            at_eye,
            holes,
            ..
        } = scratch;
        let planes = planes.each_ref().map(|p| &p[0]);
        let Some((mut interval, span)) = interval(&self.shader, frame, (near, place), (planes, *at_eye))
        else {
            return;
        };
        if self.has_holes() {
            interval.leave_out(holes, self.shader.background);
        }
        let mut target = ShadeTarget::new((place, span), mask, canvas, batch);
        let sheet = (frame.stack.first + near as i64) as usize;
        let look = (&self.shader, self.operated.as_ref());
        show(simd, look, (&interval, sheet), (&mut target, faces));
    }
}

/// Classifies, lights and composites an interval: sixteen pixels at a time, or one by one where operators, clips or
/// isosurfaces apply.
pub(crate) fn show<S: Simd>(
    simd: S,
    (shader, operated): (&PlaneShader<'_>, Option<&Operated<'_>>),
    (interval, sheet): (&Interval<'_>, usize),
    (target, faces): (&mut ShadeTarget<'_>, &mut Faces),
) {
    match operated {
        None => shader.shade(simd, interval, target, None),
        Some(operated) => operated.shade(simd, (shader, interval, sheet), target, faces),
    }
}

/// Pixels of the tile where one of the two middle planes is not empty.
pub(crate) fn filled(planes: [&Plane; 4], place: &Place) -> Option<Span> {
    let filled = |plane: &Plane| plane.filled.unwrap_or(Span::EMPTY);
    let span = filled(planes[1]).join(filled(planes[2]));
    (!span.is_empty()).then(|| Span {
        x0: span.x0.saturating_sub(HALO),
        y0: span.y0.saturating_sub(HALO),
        x1: span.x1.saturating_sub(HALO).min(place.size[0]),
        y1: span.y1.saturating_sub(HALO).min(place.size[1]),
    })
}

/// The interval behind a sheet, and its non-empty pixels. `at_eye`: as [`SheetScratch::at_eye`].
pub(crate) fn interval<'a>(
    shader: &PlaneShader<'_>,
    frame: &SheetFrame<'_>,
    (near, place): (usize, &Place),
    (planes, at_eye): ([&'a Plane; 4], Option<[f32; 3]>),
) -> Option<(Interval<'a>, Span)> {
    let span = filled(planes, place)?;
    let sheets = frame.sheets.get(near..near + 2)?;
    let step = frame.step as f32;
    let depths = [sheets[0].depth, sheets[1].depth];
    let borders = shader.borders(depths);
    let interval = Interval {
        is_near_border: borders
            .iter()
            .any(|plane| shader.border.is_near_any(plane, &place.rect)),
        borders,
        planes,
        holes: None,
        weights: None,
        at_eye,
        depths,
        scales: [sheets[0].scale * step, sheets[1].scale * step],
    };
    Some((interval, span))
}
