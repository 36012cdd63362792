//! Pre-classification: classified, lit voxels are splatted as extinction and emission, and intervals between planes
//! are composited.
//!
//! Along a pixel's ray all four channels are the cubics through both planes, as in `shade`. An interval holds their
//! integral, `(13 (v0 + v1) - (v_before + v_after)) / 24` of its length.

use fearless_simd::{f32x16, prelude::*};
use splatvol_core::plan::Rays;

use super::canvas::{Canvas, Material};
use super::classified::{ClassifiedBricks, ClassifiedVoxels};
use super::footprint::Scaled;
use super::frame::SheetFrame;
use super::mode::{Bricks, Mode};
use super::place::Place;
use super::plane::{HALO, Plane};
use super::shaded::filled;
use super::splat::Payload;
use super::tile::{MAX_CHANNELS, SheetScratch};
use crate::simd::math::{LEAST_EXPONENT, exp2_quick};

/// Pre-classification.
#[derive(Debug)]
pub(crate) struct Compose<'a> {
    pub bricks: ClassifiedBricks<'a>,
}

/// Extinction and emission of classified voxels, each into a ring of its own.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Emission<'m>(pub &'m ClassifiedVoxels);

impl Payload<4> for Emission<'_> {
    type Footprint = Scaled;

    #[inline(always)]
    fn weights<S: Simd>(&self, _: S, value: f32, weight: f32x16<S>, peak: f32x16<S>) -> [f32x16<S>; 4] {
        let [extinction, r, g, b] = *self.0.voxel(value);
        let weight = weight * peak;
        [weight * extinction, weight * r, weight * g, weight * b]
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, plane: &[f32], at: usize) -> f32x16<S> {
    f32x16::from_slice(simd, &plane[at..at + 16])
}

/// Mean of a channel over the interval between the middle two of four planes: of the cubic through all four, or of
/// the line between the two. The lines' means add up to the sum over the planes, however steeply the channel rises.
#[inline(always)]
fn mean<S: Simd, const CUBIC: bool>(
    simd: S,
    planes: &[[Plane; MAX_CHANNELS]; 4],
    channel: usize,
    at: usize,
) -> f32x16<S> {
    let [before, near, far, after] = planes;
    let inner = load(simd, &near[channel].values, at) + load(simd, &far[channel].values, at);
    if !CUBIC {
        return inner * 0.5;
    }
    let outer = load(simd, &before[channel].values, at) + load(simd, &after[channel].values, at);
    (inner * (13.0 / 24.0) - outer * (1.0 / 24.0)).max(f32x16::splat(simd, 0.0))
}

const LANES: [f32; 16] = [
    0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0,
];

/// Length of the rays of sixteen pixels per depth, from image x, y on.
#[inline(always)]
pub(crate) fn ray_length<S: Simd>(simd: S, rays: &Rays, [x, y]: [usize; 2]) -> f32x16<S> {
    let [cx, cy] = rays.principal;
    let per_pixel = rays.per_pixel;
    let across = (f32x16::from_slice(simd, &LANES) + (x as f32 + 0.5 - cx)) * per_pixel;
    let down = (y as f32 + 0.5 - cy) * per_pixel;
    (across * across + (1.0 + down * down)).sqrt()
}

/// Optical depth below which the series for `1 - exp(-tau)` is as exact as the exponential.
const THIN: f32 = 0.02;

/// `exp(-tau)` and `1 - exp(-tau)`; the latter is computed by itself because thin material would lose its digits.
#[inline(always)]
pub(crate) fn through_and_opacity<S: Simd>(simd: S, optical_depth: f32x16<S>) -> (f32x16<S>, f32x16<S>) {
    let exponent = (optical_depth * -std::f32::consts::LOG2_E).max(f32x16::splat(simd, LEAST_EXPONENT));
    let through = exp2_quick(simd, exponent);
    let thin = optical_depth.simd_lt(f32x16::splat(simd, THIN));
    let series = optical_depth * (1.0 - optical_depth * (0.5 - optical_depth * (1.0 / 6.0)));
    let opacity = thin.select(series, 1.0 - through);
    (thin.select(1.0 - series, through), opacity)
}

/// Composites an interval of sixteen pixels; returns those that it finished.
#[inline(always)]
fn composite<S: Simd, const CUBIC: bool>(
    simd: S,
    (frame, near): (&SheetFrame<'_>, usize),
    place: &Place,
    planes: &[[Plane; MAX_CHANNELS]; 4],
    canvas: &mut Canvas,
    [x, y]: [usize; 2],
) -> u16 {
    let at = (y + HALO) * planes[1][0].pitch + x + HALO;
    let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
    let extinction = mean::<S, CUBIC>(simd, planes, 0, at);
    let pixel = y * canvas.pitch + x;
    let transmittance = load(simd, &canvas.transmittance, pixel);
    let termination = f32x16::splat(simd, frame.termination);
    let open = transmittance.simd_ge(termination);
    let seen = extinction.simd_gt(zero) & open;
    if !seen.any_true() {
        return 0;
    }
    let spacing = frame.stack.spacing as f32;
    let length = ray_length(simd, &frame.rays, [place.rect.x0 + x, place.rect.y0 + y]) * spacing;
    let optical_depth = extinction * length;
    let (through, opacity) = through_and_opacity(simd, optical_depth);
    let opacity = seen.select(opacity, zero);
    let per_extinction = opacity / seen.select(extinction, one);
    let (front, back) = (
        load(simd, &planes[1][0].values, at),
        load(simd, &planes[2][0].values, at),
    );
    let total = front + back;
    let share_of_far = total.simd_gt(zero).select(back / total, f32x16::splat(simd, 0.5));
    let material = Material {
        through: seen.select(through, one),
        opacity,
        color: [
            mean::<S, CUBIC>(simd, planes, 1, at) * per_extinction,
            mean::<S, CUBIC>(simd, planes, 2, at) * per_extinction,
            mean::<S, CUBIC>(simd, planes, 3, at) * per_extinction,
        ],
        depth: (share_of_far * 0.5 + 0.25) * spacing + frame.sheets[near].depth,
    };
    canvas.put(simd, pixel, &material, frame.termination)
}

impl Mode<4> for Compose<'_> {
    type Payload<'m> = Emission<'m>;

    fn payload(classified: &ClassifiedVoxels) -> Emission<'_> {
        Emission(classified)
    }

    #[inline(always)]
    fn bricks(&self) -> Bricks<'_> {
        Bricks::Classified(&self.bricks)
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
        composite_planes::<S, true>(simd, (frame, near), place, (canvas, scratch));
    }
}

/// Composites the interval between a plane of extinction and emission and the next, and closes the pixels that it
/// finishes.
#[inline(always)]
pub(crate) fn composite_planes<S: Simd, const CUBIC: bool>(
    simd: S,
    (frame, near): (&SheetFrame<'_>, usize),
    place: &Place,
    (canvas, scratch): (&mut Canvas, &mut SheetScratch),
) {
    let SheetScratch { planes, mask, .. } = scratch;
    let Some(span) = filled(planes.each_ref().map(|p| &p[0]), place) else {
        return;
    };
    for y in span.y0..span.y1 {
        let mut x = span.x0 / 16 * 16;
        while x < span.x1 {
            if mask.sixteen(x, y) != 0 {
                let finished = composite::<S, CUBIC>(simd, (frame, near), place, planes, canvas, [x, y]);
                if finished != 0 {
                    mask.finish(x, y, finished);
                }
            }
            x += 16;
        }
    }
}
