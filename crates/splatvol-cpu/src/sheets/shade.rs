//! Shade: two neighbouring planes, classified, lit and composited.
//!
//! Sixteen pixels of a row are tested at a time. Those that may hold something are collected, until they fill whole
//! vectors ([`super::shade_batch`]): of the lanes that are shaded, hardly any is idle. What a pixel gets does not
//! depend on the others of its vector.
//!
//! Along a pixel's ray the value is the cubic through both planes with slopes from the planes beside them (Catmull
//! and Rom). It is cut in the middle. Each half takes its mean extinction from the integral of the transfer
//! function, `(K(b) - K(a)) / (b - a)`, and its colour and lighting at the place of its material. This is right for
//! any transfer function, and shows thin bands between two planes as they are. The gradient consists of the planes'
//! central differences across the ray and, along it, of a difference of the four planes with the same low-pass.
//! Thin intervals are not cut.

use fearless_simd::{f32x16, mask32x16, prelude::*};
use glam::Vec3A;

use super::canvas::Canvas;
use super::holes::Beside;
use super::mask::OpenMask;
use super::operated::Divided;
use super::place::Place;
use super::plane::{HALO, Plane, Span};
use super::shade_batch::{Pixels, ShadeBatch};
use crate::phong::Phong;
use splatvol_core::border::{Border, BorderPlane};
use splatvol_core::shade_table::ShadeTable;

/// Beyond this, four planes are too few to soften the slope as much as the differences across the ray.
const SOFTEST: f32 = -0.1;
/// Differences of an interval's ends by which the cubic between them may leave their range.
const OVERSHOOT: f32 = 0.25;
/// Normalised values by which planes may be off by rounding.
const ROUNDING: f32 = 1e-3;

/// Four neighbouring planes; the interval is between the second and the third.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Interval<'a> {
    pub planes: [&'a Plane; 4],
    /// Weights of missing samples there, if any.
    pub holes: Option<[&'a Plane; 4]>,
    /// Weights by which the planes' values have been divided, where those are not one.
    pub weights: Option<[&'a Plane; 4]>,
    /// Camera depths of the second and third plane, and pixels per world length there.
    pub depths: [f32; 2],
    pub scales: [f32; 2],
    /// Gradient at the second plane if that is at the eye, where there are no differences.
    pub at_eye: Option<[f32; 3]>,
    /// Borders of the volume on the two middle planes, and whether the tile is near one.
    pub borders: [BorderPlane; 2],
    pub is_near_border: bool,
}

#[inline(always)]
fn load<S: Simd>(simd: S, plane: &[f32], at: usize) -> f32x16<S> {
    f32x16::from_slice(simd, &plane[at..at + 16])
}

#[inline(always)]
fn splat<S: Simd>(simd: S, value: f32) -> f32x16<S> {
    f32x16::splat(simd, value)
}

/// Lane numbers, and a half.
pub(crate) const MIDDLES: [f32; 16] = [
    0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5, 8.5, 9.5, 10.5, 11.5, 12.5, 13.5, 14.5, 15.5,
];

/// Slope per interval, at u between the second and the third of four values one interval apart. In the middle it is
/// `(c - b) - sharpness (d - 3 c + 3 b - a)`.
#[inline(always)]
pub(super) fn depth_slope<S: Simd>([a, b, c, d]: [f32x16<S>; 4], u: f32x16<S>, sharpness: f32) -> f32x16<S> {
    let rise = c - b;
    let (near, far) = (a - b - b + c, b - c - c + d);
    let (bend, third) = ((near + far) * 0.5, far - near);
    let from_middle = u - 0.5;
    let correction = from_middle * from_middle * 0.5 - sharpness;
    third * correction + (from_middle * bend + rise)
}

/// Scalar version of `depth_slope`.
pub(crate) fn depth_slope_of([a, b, c, d]: [f32; 4], u: f32, sharpness: f32) -> f32 {
    let rise = c - b;
    let (near, far) = (a - b - b + c, b - c - c + d);
    let (bend, third) = ((near + far) * 0.5, far - near);
    let from_middle = u - 0.5;
    let correction = from_middle * from_middle * 0.5 - sharpness;
    third * correction + (from_middle * bend + rise)
}

/// Central differences at point i of both planes, per world length; `step` leads to the next point.
#[inline(always)]
fn across<S: Simd>(
    simd: S,
    [near, far]: [&[f32]; 2],
    scales: [f32; 2],
    (i, step): (usize, usize),
) -> [f32x16<S>; 2] {
    [
        (load(simd, near, i + step) - load(simd, near, i - step)) * (0.5 * scales[0]),
        (load(simd, far, i + step) - load(simd, far, i - step)) * (0.5 * scales[1]),
    ]
}

impl<'a> Interval<'a> {
    /// Share of the third difference with which slopes along the ray lose as much at high frequencies as the
    /// central differences across it. So gradients keep their direction: differences over a width w lose
    /// `(w omega)^2 / 24`.
    pub(crate) fn sharpness(&self, spacing: f32) -> f32 {
        let width = 2.0 / (self.scales[0] * spacing);
        ((1.0 - width * width) / 24.0).max(SOFTEST)
    }

    /// Rows above, at and below a point and the points beside it, of each plane.
    #[inline(always)]
    fn around(&self, at: usize) -> [&'a [f32]; 4] {
        let [a, b, c, d] = self.planes;
        let range = at - a.pitch - 1..at + a.pitch + 17;
        [
            &a.values[range.clone()],
            &b.values[range.clone()],
            &c.values[range.clone()],
            &d.values[range],
        ]
    }
}

/// Constants of a frame.
#[derive(Debug, Clone)]
pub(crate) struct PlaneShader<'a> {
    pub table: &'a ShadeTable,
    pub phong: Option<Phong>,
    /// Distance between planes, world length.
    pub spacing: f32,
    pub background: f32,
    /// Ray of a pixel at image x, y: `(x + 1/2 - principal) * per_pixel` per depth, 0 where parallel.
    pub principal: [f32; 2],
    pub per_pixel: f32,
    /// Width of a pixel, world length, where rays are parallel.
    pub plane_per_pixel: f32,
    pub termination: f32,
    pub border: Border,
}

/// Area of a tile to shade.
#[derive(Debug)]
pub(crate) struct ShadeTarget<'a> {
    /// Image coordinates of the tile's first pixel.
    pub origin: [usize; 2],
    /// Pixels of the tile to shade.
    pub span: Span,
    pub mask: &'a mut OpenMask,
    pub canvas: &'a mut Canvas,
    pub batch: &'a mut ShadeBatch,
}

impl<'a> ShadeTarget<'a> {
    /// Pixels of a tile.
    pub(crate) fn new(
        (place, span): (&Place, Span),
        mask: &'a mut OpenMask,
        canvas: &'a mut Canvas,
        batch: &'a mut ShadeBatch,
    ) -> Self {
        Self {
            origin: [place.rect.x0, place.rect.y0],
            span,
            mask,
            canvas,
            batch,
        }
    }

    /// Image coordinates of a pixel of the tile.
    #[inline(always)]
    pub(super) fn in_picture(&self, [x, y]: [usize; 2]) -> [usize; 2] {
        [self.origin[0] + x, self.origin[1] + y]
    }

    /// Which of sixteen pixels from (x, y) on are open.
    #[inline(always)]
    fn open<S: Simd>(&self, simd: S, [x, y]: [usize; 2]) -> mask32x16<S> {
        mask32x16::from_bitmask(simd, u64::from(self.mask.sixteen(x, y)))
    }
}

impl PlaneShader<'_> {
    /// Shades an interval, or some of its pixels, and closes those that it finishes. Compiled once, whatever the mode.
    pub(crate) fn shade<S: Simd>(
        &self,
        simd: S,
        interval: &Interval<'_>,
        target: &mut ShadeTarget<'_>,
        some: Option<&Divided>,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.shade_rows(simd, interval, target, some),
        );
    }

    #[inline(always)]
    fn shade_rows<S: Simd>(
        &self,
        simd: S,
        interval: &Interval<'_>,
        target: &mut ShadeTarget<'_>,
        some: Option<&Divided>,
    ) {
        let span = target.span;
        target.batch.begin(interval);
        for y in span.y0..span.y1 {
            let mut x = span.x0 / 16 * 16;
            while x < span.x1 {
                if target.mask.sixteen(x, y) != 0 {
                    let which = some.map_or(u16::MAX, |divided| divided.whole([x, y]));
                    let shown = self.may_show(simd, interval, target, [x, y]) & u64::from(which);
                    if shown != 0 {
                        self.collect(simd, interval, target, ([x, y], shown));
                    }
                    if target.batch.is_full() {
                        self.flush(simd, interval, target);
                    }
                }
                x += 16;
            }
        }
        self.flush(simd, interval, target);
    }

    /// Which of sixteen pixels can hold visible values. Finished ones do not count: their contents depend on the tile.
    #[inline(always)]
    fn may_show<S: Simd>(
        &self,
        simd: S,
        interval: &Interval<'_>,
        target: &ShadeTarget<'_>,
        [x, y]: [usize; 2],
    ) -> u64 {
        let open = target.open(simd, [x, y]);
        let mut touched = open;
        let [_, near, far, _] = interval.planes;
        let at = (y + HALO) * near.pitch + x + HALO;
        let (v0, v1) = (load(simd, &near.values, at), load(simd, &far.values, at));
        let (low, high) = (v0.min(v1), v0.max(v1));
        if !self.table.shows_background {
            touched &= low.simd_lt(splat(simd, 0.0)) | high.simd_gt(splat(simd, 0.0));
        }
        let slack = (high - low) * OVERSHOOT + (ROUNDING + self.background);
        let [first, last] = self.table.hull;
        let mut may = (high + slack).simd_ge(splat(simd, first))
            & (low - slack).simd_le(splat(simd, last - 2.0 * self.background))
            & touched;
        // Near the border and beside holes sums are still to be divided by their weights.
        if let Some(lacks) = interval.lacks(simd, [x, y]) {
            may |= lacks & open;
        }
        if interval.is_near_border
            && self
                .border
                .is_near(&interval.borders[0], target.in_picture([x, y]))
        {
            may |= (high - low).simd_gt(splat(simd, 0.0)) & open;
        }
        may.to_bitmask()
    }

    /// Adds pixels to the batch, with the values and differences of the planes there.
    #[inline(always)]
    fn collect<S: Simd>(
        &self,
        simd: S,
        interval: &Interval<'_>,
        target: &mut ShadeTarget<'_>,
        ([x, y], which): ([usize; 2], u64),
    ) {
        let pitch = interval.planes[1].pitch;
        let at = (y + HALO) * pitch + x + HALO;
        let around = interval.around(at);
        let here = pitch + 1;
        let (mut sb, mut s0) = (load(simd, around[0], here), load(simd, around[1], here));
        let (mut s1, mut sa) = (load(simd, around[2], here), load(simd, around[3], here));
        let one = splat(simd, 1.0);
        let (mut coverage, mut per_weight) = ([one; 2], [one; 2]);
        let in_picture = target.in_picture([x, y]);
        let is_near = |plane| self.border.is_near(plane, in_picture);
        if interval.is_near_border && interval.borders.iter().any(is_near) {
            let near = self.border.at(simd, &interval.borders[0], in_picture);
            let far = self.border.at(simd, &interval.borders[1], in_picture);
            (s0, sb) = (s0 * near.per_weight, sb * near.per_weight);
            (s1, sa) = (s1 * far.per_weight, sa * far.per_weight);
            coverage = [near.coverage, far.coverage];
            per_weight = [near.per_weight, far.per_weight];
        }
        let mut along = [sb, s0, s1, sa];
        let mut lacks = false;
        if !interval.is_whole()
            && let Some(missing) = interval.missing(simd, at)
        {
            let [near, far] = per_weight;
            let [mb, m0, m1, ma] = missing;
            let shares = [mb * near, m0 * near, m1 * far, ma * far];
            let beside = Beside::of(simd, interval, along, shares);
            for (sum, share) in along.iter_mut().zip(shares) {
                *sum -= share * self.background;
            }
            [sb, s0, s1, sa] = beside.values;
            coverage = beside.covered(simd, coverage);
            lacks = interval.holes.is_some();
        }
        let background = self.background;
        let values = [sb + background, s0 + background, s1 + background, sa + background];
        let [before, near, far, after] = along;
        let pixels = Pixels {
            values,
            along: match lacks {
                true => [
                    before + background,
                    near + background,
                    far + background,
                    after + background,
                ],
                false => values,
            },
            coverage,
            rays: self.rays(simd, in_picture),
        };
        if which == u64::from(u16::MAX) {
            // Full already.
            let all = mask32x16::from_bitmask(simd, which);
            let inside = self.interior(simd, &pixels, (all, interval.at_eye.is_some()));
            target.batch.count(simd, inside.as_ref(), all);
            if let Some(inside) = inside {
                let slopes = self.slopes(simd, interval, (at, lacks));
                let shown = self.show(simd, interval, (&pixels, &slopes), &inside);
                self.put(simd, target, [x, y], &shown);
            }
            return;
        }
        let slopes = match self.phong {
            Some(_) => self.slopes(simd, interval, (at, lacks)),
            None => [one; 4],
        };
        target.batch.push(simd, (&pixels, &slopes), ([x, y], which));
    }

    /// Slopes of the planes across, per world length: along x and y of the nearer, then of the farther.
    #[inline(always)]
    fn slopes<S: Simd>(
        &self,
        simd: S,
        interval: &Interval<'_>,
        (at, lacks): (usize, bool),
    ) -> [f32x16<S>; 4] {
        let [_, near, far, _] = interval.around(at);
        let pitch = interval.planes[1].pitch;
        let here = pitch + 1;
        let [mut x_near, mut x_far] = across(simd, [near, far], interval.scales, (here, 1));
        let [mut y_near, mut y_far] = across(simd, [near, far], interval.scales, (here, pitch));
        if let Some([_, near, far, _]) = interval.holes.filter(|_| lacks) {
            // Gradient of the sum of all coefficients, the missing ones being 0.
            let planes = [&near.values[..], &far.values[..]];
            let [by_near, by_far] = across(simd, planes, interval.scales, (at, 1));
            (x_near, x_far) = (
                x_near - by_near * self.background,
                x_far - by_far * self.background,
            );
            let [by_near, by_far] = across(simd, planes, interval.scales, (at, pitch));
            (y_near, y_far) = (
                y_near - by_near * self.background,
                y_far - by_far * self.background,
            );
        }
        if let Some([x, y, _]) = interval.at_eye {
            (x_near, y_near) = (splat(simd, x), splat(simd, y));
        }
        [x_near, y_near, x_far, y_far]
    }

    /// Slopes of the rays of sixteen pixels of the picture: x and y per depth.
    #[inline(always)]
    fn rays<S: Simd>(&self, simd: S, [x, y]: [usize; 2]) -> [f32x16<S>; 2] {
        let [cx, cy] = self.principal;
        let ray_x = (f32x16::from_slice(simd, &MIDDLES) + (x as f32 - cx)) * self.per_pixel;
        let ray_y = (y as f32 + 0.5 - cy) * self.per_pixel;
        [ray_x, splat(simd, ray_y)]
    }

    /// The planes' border.
    pub(crate) fn borders(&self, depths: [f32; 2]) -> [BorderPlane; 2] {
        depths.map(|depth| {
            let [first, step_x, step_y] = self.pixels(depth);
            self.border.on_plane(first, step_x, step_y)
        })
    }

    /// The picture's first pixel on the plane of a depth, camera space, and the steps to the next along x and y.
    pub(crate) fn pixels(&self, depth: f32) -> [Vec3A; 3] {
        let scale = if self.per_pixel > 0.0 {
            self.per_pixel * depth
        } else {
            self.plane_per_pixel
        };
        let [cx, cy] = self.principal;
        let first = Vec3A::new((0.5 - cx) * scale, (0.5 - cy) * scale, depth);
        [first, Vec3A::X * scale, Vec3A::Y * scale]
    }
}
