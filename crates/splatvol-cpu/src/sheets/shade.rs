//! Shade: two neighbouring planes, classified, lit and composited sixteen pixels at a time.
//!
//! Along a pixel's ray the value is the cubic through both planes with slopes from the planes beside them (Catmull
//! and Rom). It is cut in the middle. Each half takes its mean extinction from the integral of the transfer
//! function, `(K(b) - K(a)) / (b - a)`, and its colour and lighting at the place of its material. This is right for
//! any transfer function, and shows thin bands between two planes as they are. The gradient consists of the planes'
//! central differences across the ray and, along it, of a difference of the four planes with the same low-pass.
//! Thin intervals are not cut.

use fearless_simd::{f32x16, mask32x16, prelude::*};
use glam::Vec3A;

use super::border::{Border, BorderPlane};
use super::canvas::{Canvas, Material};
use super::holes::Beside;
use super::mask::OpenMask;
use super::place::Place;
use super::plane::{HALO, Plane, Span};
use super::sheet::Lanes16;
use super::table::{Segment, ShadeTable};
use crate::phong::Phong;
use crate::simd::math::{LEAST_EXPONENT, exp2_quick};

/// Beyond this, four planes are too few to soften the slope as much as the differences across the ray.
const SOFTEST: f32 = -0.1;
/// Optical depth from which an interval is cut in halves.
const THICK: f32 = 0.02;
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
fn depth_slope<S: Simd>([a, b, c, d]: [f32x16<S>; 4], u: f32x16<S>, sharpness: f32) -> f32x16<S> {
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

/// Diffuse and specular factors of a gradient.
#[inline(always)]
fn lit<S: Simd>(simd: S, phong: &Phong, gradient: &[Lanes16; 3]) -> [f32x16<S>; 2] {
    let [x, y, z] = gradient;
    let gradient = [load(simd, &x.0, 0), load(simd, &y.0, 0), load(simd, &z.0, 0)];
    let (diffuse, specular) = phong.lanes(simd, gradient);
    [diffuse, specular]
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

/// Vectors shaded together. The chain of dependent instructions of one vector is longer than a processor's
/// look-ahead; those of several vectors run side by side, stage by stage.
const BATCH: usize = 8;

/// Intermediate results between the shading stages, per vector.
#[derive(Debug)]
pub(crate) struct ShadeBatch {
    /// First pixel of each vector.
    places: [[usize; 2]; BATCH],
    len: usize,
    /// Transmittance of the interval.
    through: [Lanes16; BATCH],
    /// Colour times opacity.
    color: [[Lanes16; 3]; BATCH],
    /// Place of the material in the interval, 0 to 1.
    place: [Lanes16; BATCH],
    /// Gradients at the material of each half, and the second half's share of the visible material.
    gradients: [[[Lanes16; 3]; 2]; BATCH],
    behind: [Lanes16; BATCH],
    /// Whether the interval is cut in halves; else the first gradient is that of the whole.
    halves: [bool; BATCH],
    /// Diffuse and specular factors.
    light: [[Lanes16; 2]; BATCH],
}

impl Default for ShadeBatch {
    fn default() -> Self {
        const ZERO: Lanes16 = Lanes16([0.0; 16]);
        Self {
            places: [[0; 2]; BATCH],
            len: 0,
            through: [ZERO; BATCH],
            color: [[ZERO; 3]; BATCH],
            place: [ZERO; BATCH],
            gradients: [[[ZERO; 3]; 2]; BATCH],
            behind: [ZERO; BATCH],
            halves: [false; BATCH],
            light: [[ZERO; 2]; BATCH],
        }
    }
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
    fn in_picture(&self, [x, y]: [usize; 2]) -> [usize; 2] {
        [self.origin[0] + x, self.origin[1] + y]
    }

    /// Which of sixteen pixels from (x, y) on are open.
    #[inline(always)]
    fn open<S: Simd>(&self, simd: S, [x, y]: [usize; 2]) -> mask32x16<S> {
        mask32x16::from_bitmask(simd, u64::from(self.mask.sixteen(x, y)))
    }
}

impl PlaneShader<'_> {
    /// Shades an interval, and closes the pixels that it finishes.
    #[inline(always)]
    pub(crate) fn shade<S: Simd>(&self, simd: S, interval: &Interval<'_>, target: &mut ShadeTarget<'_>) {
        let span = target.span;
        for y in span.y0..span.y1 {
            let mut x = span.x0 / 16 * 16;
            while x < span.x1 {
                if target.mask.sixteen(x, y) != 0 && self.may_show(simd, interval, target, [x, y]) {
                    target.batch.places[target.batch.len % BATCH] = [x, y];
                    target.batch.len += 1;
                    if target.batch.len == BATCH {
                        self.flush(simd, interval, target);
                    }
                }
                x += 16;
            }
        }
        self.flush(simd, interval, target);
    }

    /// Whether any of sixteen pixels can hold visible values. Only open pixels count, since the contents of
    /// finished ones depend on the tile.
    #[inline(always)]
    fn may_show<S: Simd>(
        &self,
        simd: S,
        interval: &Interval<'_>,
        target: &ShadeTarget<'_>,
        [x, y]: [usize; 2],
    ) -> bool {
        let mut open = target.open(simd, [x, y]);
        let [_, near, far, _] = interval.planes;
        let at = (y + HALO) * near.pitch + x + HALO;
        let (v0, v1) = (load(simd, &near.values, at), load(simd, &far.values, at));
        let (low, high) = (v0.min(v1), v0.max(v1));
        if !self.table.shows_background {
            open &= low.simd_lt(splat(simd, 0.0)) | high.simd_gt(splat(simd, 0.0));
        }
        let slack = (high - low) * OVERSHOOT + (ROUNDING + self.background);
        let [first, last] = self.table.hull;
        let may = (high + slack).simd_ge(splat(simd, first))
            & (low - slack).simd_le(splat(simd, last - 2.0 * self.background))
            & open;
        // Near the border and beside holes sums are still to be divided by their weights.
        may.any_true()
            || interval
                .lacks(simd, [x, y])
                .is_some_and(|lacks| (lacks & open).any_true())
            || (interval.is_near_border
                && ((high - low).simd_gt(splat(simd, 0.0)) & open).any_true()
                && self
                    .border
                    .is_near(&interval.borders[0], target.in_picture([x, y])))
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

    #[inline(always)]
    fn flush<S: Simd>(&self, simd: S, interval: &Interval<'_>, target: &mut ShadeTarget<'_>) {
        let found = std::mem::take(&mut target.batch.len).min(BATCH);
        let mut count = 0;
        for n in 0..found {
            // Vectors without material leave their place to the next.
            target.batch.places[count] = target.batch.places[n];
            let holds = match interval.is_whole() {
                true => self.classify::<S, false>(simd, interval, target, count),
                false => self.classify::<S, true>(simd, interval, target, count),
            };
            count += usize::from(holds);
        }
        if let Some(phong) = &self.phong {
            let batch = &mut *target.batch;
            for n in 0..count {
                let [first, second] = &batch.gradients[n];
                let mut light = lit(simd, phong, first);
                if batch.halves[n] {
                    let behind = load(simd, &batch.behind[n].0, 0);
                    let second = lit(simd, phong, second);
                    for factor in 0..2 {
                        light[factor] += (second[factor] - light[factor]) * behind;
                    }
                }
                for factor in 0..2 {
                    light[factor].store_slice(&mut batch.light[n][factor].0);
                }
            }
        }
        for n in 0..count {
            self.composite(simd, interval.depths[0], target, n);
        }
    }

    /// Opacity, colour and gradient of the batch's n-th vector; false if none of its open pixels holds material.
    #[inline(always)]
    fn classify<S: Simd, const HOLED: bool>(
        &self,
        simd: S,
        interval: &Interval<'_>,
        target: &mut ShadeTarget<'_>,
        n: usize,
    ) -> bool {
        let [x, y] = target.batch.places[n];
        let pitch = interval.planes[1].pitch;
        let at = (y + HALO) * pitch + x + HALO;
        let [before, near, far, after] = interval.around(at);
        let here = pitch + 1;
        let (mut s0, mut s1) = (load(simd, near, here), load(simd, far, here));
        let (mut sb, mut sa) = (load(simd, before, here), load(simd, after, here));
        let mut coverage = [splat(simd, 1.0); 2];
        let mut per_weight = coverage;
        if interval.is_near_border
            && interval
                .borders
                .iter()
                .any(|plane| self.border.is_near(plane, target.in_picture([x, y])))
        {
            let near = self
                .border
                .at(simd, &interval.borders[0], target.in_picture([x, y]));
            let far = self
                .border
                .at(simd, &interval.borders[1], target.in_picture([x, y]));
            (s0, sb) = (s0 * near.per_weight, sb * near.per_weight);
            (s1, sa) = (s1 * far.per_weight, sa * far.per_weight);
            coverage = [near.coverage, far.coverage];
            per_weight = [near.per_weight, far.per_weight];
        }
        let mut missing = None;
        let mut whole_sums = [sb, s0, s1, sa];
        if HOLED && let Some(weights) = interval.missing(simd, at) {
            let [near, far] = per_weight;
            let [mb, m0, m1, ma] = weights;
            let shares = [mb * near, m0 * near, m1 * far, ma * far];
            for (sum, share) in whole_sums.iter_mut().zip(shares) {
                *sum -= share * self.background;
            }
            let beside = Beside::of(simd, interval, [sb, s0, s1, sa], shares);
            [sb, s0, s1, sa] = beside.values;
            coverage = beside.covered(simd, coverage);
            missing = interval.holes;
        }
        let (v0, v1) = (s0 + self.background, s1 + self.background);
        let ends = [self.table.classify(simd, v0), self.table.classify(simd, v1)];
        let whole = Segment::between(simd, [v0, v1], [&ends[0], &ends[1]]);
        let [cx, cy] = self.principal;
        let ray_x =
            (f32x16::from_slice(simd, &MIDDLES) + ((target.origin[0] + x) as f32 - cx)) * self.per_pixel;
        let ray_y = ((target.origin[1] + y) as f32 + 0.5 - cy) * self.per_pixel;
        let ray_squared = ray_x * ray_x + (1.0 + ray_y * ray_y);
        let length = ray_squared.sqrt() * self.spacing;
        let (before, after) = (sb + self.background, sa + self.background);
        let covered = (coverage[0] + coverage[1]) * 0.5;
        let (m0, m1) = ((v1 - before) * 0.5, (after - v0) * 0.5);

        // Opaque intervals in two halves, so that the front hides the back; thin ones in one.
        let extinction = whole.extinction * covered;
        let open = target.open(simd, [x, y]);
        let thick = (extinction * length).simd_gt(splat(simd, THICK)) & open;
        let (through, color, u, places, behind);
        let in_halves = thick.any_true() || !(extinction.simd_gt(splat(simd, 0.0)) & open).any_true();
        if in_halves {
            let vm = (v0 + v1) * 0.5 + (m0 - m1) * 0.125;
            let middle = self.table.classify(simd, vm);
            let mut halves = [
                Segment::between(simd, [v0, vm], [&ends[0], &middle]),
                Segment::between(simd, [vm, v1], [&middle, &ends[1]]),
            ];
            let first = halves[0].extinction * (coverage[0] + covered) * 0.5;
            let second = halves[1].extinction * (covered + coverage[1]) * 0.5;
            if !((first + second).simd_gt(splat(simd, 0.0)) & open).any_true() {
                return false;
            }
            let half = length * (-0.5 * std::f32::consts::LOG2_E);
            let front = exp2_quick(simd, (first * half).max(splat(simd, LEAST_EXPONENT)));
            let back = exp2_quick(simd, (second * half).max(splat(simd, LEAST_EXPONENT)));
            through = front * back;
            if interval.at_eye.is_some() {
                halves[0].move_forward(simd, [v0, vm], (first * length * 0.5, front));
                halves[1].move_forward(simd, [vm, v1], (second * length * 0.5, back));
            }
            let opacities = [1.0 - front, front * (1.0 - back)];
            let [a, b] = [
                self.table.color(simd, halves[0].value),
                self.table.color(simd, halves[1].value),
            ];
            color = [
                a[0] * opacities[0] + b[0] * opacities[1],
                a[1] * opacities[0] + b[1] * opacities[1],
                a[2] * opacities[0] + b[2] * opacities[1],
            ];
            let seen = opacities[0] + opacities[1];
            behind = opacities[1] / seen.max(splat(simd, 1e-30));
            places = [halves[0].place * 0.5, halves[1].place * 0.5 + 0.5];
            u = places[0] + behind * (places[1] - places[0]);
        } else {
            through = exp2_quick(simd, extinction * length * -std::f32::consts::LOG2_E);
            let opacity = 1.0 - through;
            let [r, g, b] = self.table.color(simd, whole.value);
            color = [r * opacity, g * opacity, b * opacity];
            u = whole.place;
            places = [u; 2];
            behind = splat(simd, 0.0);
        }
        let batch = &mut target.batch;
        through.store_slice(&mut batch.through[n].0);
        for c in 0..3 {
            color[c].store_slice(&mut batch.color[n][c].0);
        }
        u.store_slice(&mut batch.place[n].0);
        if self.phong.is_none() {
            splat(simd, 1.0).store_slice(&mut batch.light[n][0].0);
            splat(simd, 0.0).store_slice(&mut batch.light[n][1].0);
            return true;
        }
        behind.store_slice(&mut batch.behind[n].0);
        batch.halves[n] = in_halves;
        let sharpness = interval.sharpness(self.spacing);
        let [mut x_near, mut x_far] = across(simd, [near, far], interval.scales, (here, 1));
        let [mut y_near, mut y_far] = across(simd, [near, far], interval.scales, (here, pitch));
        if let Some([_, near, far, _]) = missing {
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
        let along = match missing {
            None => [before, v0, v1, after],
            Some(_) => whole_sums.map(|sum| sum + self.background),
        };
        for half in 0..1 + usize::from(in_halves) {
            let u = places[half];
            let gx = (x_far - x_near) * u + x_near;
            let gy = (y_far - y_near) * u + y_near;
            let slope = depth_slope(along, u, sharpness);
            let gz = slope * (1.0 / self.spacing) - ray_x * gx - gy * ray_y;
            let gradient = &mut batch.gradients[n][half];
            gx.store_slice(&mut gradient[0].0);
            gy.store_slice(&mut gradient[1].0);
            gz.store_slice(&mut gradient[2].0);
        }
        true
    }

    /// Composites the batch's n-th vector behind its pixels.
    #[inline(always)]
    fn composite<S: Simd>(&self, simd: S, near_depth: f32, target: &mut ShadeTarget<'_>, n: usize) {
        let ShadeTarget { batch, canvas, .. } = target;
        let [x, y] = batch.places[n];
        let of = |lanes: &Lanes16| load(simd, &lanes.0, 0);
        let through = of(&batch.through[n]);
        let opacity = 1.0 - through;
        let [diffuse, specular] = [of(&batch.light[n][0]), of(&batch.light[n][1])];
        let shine = specular * opacity;
        let [r, g, b] = &batch.color[n];
        let material = Material {
            through,
            opacity,
            color: [
                of(r) * diffuse + shine,
                of(g) * diffuse + shine,
                of(b) * diffuse + shine,
            ],
            depth: of(&batch.place[n]) * self.spacing + near_depth,
        };
        let pixel = y * canvas.pitch + x;
        let finished = canvas.put(simd, pixel, &material, self.termination);
        if finished != 0 {
            target.mask.finish(x, y, finished);
        }
    }
}
