//! Pixels of an interval between two planes, collected until they fill whole vectors, and their shading.
//!
//! Many pixels of a row hold nothing: outside of an object, behind its front, in front of its back. The others are
//! compressed into columns, shaded sixteen at a time, and expanded again to be composited. Every choice is made per
//! lane, so that a pixel does not depend on those beside it.

use fearless_simd::{f32x16, mask32x16, prelude::*};

use super::canvas::Material;
use super::shade::{Interval, PlaneShader, ShadeTarget, depth_slope};
use crate::simd::math::{LEAST_EXPONENT, exp2_quick};
use splatvol_core::shade_table::Segment;

/// Optical depth from which an interval is cut in halves.
const THICK: f32 = 0.02;
/// Optical depth of a whole interval of the densest material from which thin intervals are cut, too, where their middle
/// leaves the range of their ends: it may be opaque.
const DENSE: f32 = 0.1;
/// Pixels of a batch.
const CAPACITY: usize = 128;

/// A number of each pixel; vectors may be stored behind the last one.
type Column = [f32; CAPACITY + 16];

const ZEROS: Column = [0.0; CAPACITY + 16];

/// Sixteen pixels of a row, between the interval's planes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pixels<S: Simd> {
    /// Values on the four planes.
    pub values: [f32x16<S>; 4],
    /// Values whose slope along the ray light uses: beside missing samples, of the sum of all coefficients.
    pub along: [f32x16<S>; 4],
    /// Coverage on the two middle planes.
    pub coverage: [f32x16<S>; 2],
    /// Slopes of the rays: x and y per depth.
    pub rays: [f32x16<S>; 2],
}

/// Pixels of a row of a tile.
#[derive(Debug, Clone, Copy, Default)]
struct Source {
    place: [usize; 2],
    /// Which of the sixteen from there on are in the batch.
    which: u64,
}

/// Collected pixels, and what they show.
#[derive(Debug)]
pub(crate) struct ShadeBatch {
    /// Vectors shaded, and pixels of them that hold material.
    counts: [u64; 2],
    len: usize,
    sources: [Source; CAPACITY],
    from: usize,
    /// Whether coverage can differ from one, and `along` from the values.
    is_covered: bool,
    has_along: bool,
    values: [Column; 4],
    along: [Column; 4],
    coverage: [Column; 2],
    slopes: [Column; 4],
    rays: [Column; 2],
    /// Transmittance of the interval.
    through: Column,
    /// Lit colour times opacity.
    color: [Column; 3],
    /// Camera depth of the material.
    depth: Column,
}

impl Default for ShadeBatch {
    fn default() -> Self {
        Self {
            counts: [0; 2],
            len: 0,
            sources: [Source::default(); CAPACITY],
            from: 0,
            is_covered: false,
            has_along: false,
            values: [ZEROS; 4],
            along: [ZEROS; 4],
            coverage: [ZEROS; 2],
            slopes: [ZEROS; 4],
            rays: [ZEROS; 2],
            through: ZEROS,
            color: [ZEROS; 3],
            depth: ZEROS,
        }
    }
}

impl ShadeBatch {
    /// Begins an interval.
    pub(super) fn begin(&mut self, interval: &Interval<'_>) {
        (self.len, self.from) = (0, 0);
        self.has_along = interval.holes.is_some();
        self.is_covered = interval.is_near_border || !interval.is_whole();
    }

    /// Vectors shaded since the last call, and pixels of them that hold material.
    pub(super) fn take_counts(&mut self) -> [u64; 2] {
        std::mem::take(&mut self.counts)
    }

    /// Counts a vector, given what its live pixels hold.
    #[inline(always)]
    pub(super) fn count<S: Simd>(&mut self, simd: S, inside: Option<&Interior<S>>, live: mask32x16<S>) {
        self.counts[0] += 1;
        if let Some(inside) = inside {
            let held = inside.through.simd_lt(splat(simd, 1.0)) & live;
            self.counts[1] += u64::from(held.to_bitmask().count_ones());
        }
    }

    /// Whether there may be no room for sixteen more.
    pub(super) fn is_full(&self) -> bool {
        self.len > CAPACITY - 16
    }

    /// Adds some of the pixels at a place of the tile.
    #[inline(always)]
    pub(super) fn push<S: Simd>(
        &mut self,
        simd: S,
        (pixels, slopes): (&Pixels<S>, &[f32x16<S>; 4]),
        (place, which): ([usize; 2], u64),
    ) {
        let at = self.len.min(CAPACITY - 16);
        let lanes = mask32x16::from_bitmask(simd, which);
        let all = which == u64::from(u16::MAX);
        append(&mut self.values, &pixels.values, (at, all, lanes));
        append(&mut self.slopes, slopes, (at, all, lanes));
        append(&mut self.rays, &pixels.rays, (at, all, lanes));
        if self.is_covered {
            append(&mut self.coverage, &pixels.coverage, (at, all, lanes));
        }
        if self.has_along {
            append(&mut self.along, &pixels.along, (at, all, lanes));
        }
        self.sources[self.from % CAPACITY] = Source { place, which };
        self.from += 1;
        self.len = at + which.count_ones() as usize;
    }
}

/// Appends the chosen lanes of vectors to columns.
#[inline(always)]
fn append<S: Simd, const N: usize>(
    columns: &mut [Column; N],
    vectors: &[f32x16<S>; N],
    (at, all, lanes): (usize, bool, mask32x16<S>),
) {
    for (column, vector) in columns.iter_mut().zip(vectors) {
        let vector = if all { *vector } else { vector.compress(lanes) };
        vector.store_slice(&mut column[at..at + 16]);
    }
}

#[inline(always)]
fn splat<S: Simd>(simd: S, value: f32) -> f32x16<S> {
    f32x16::splat(simd, value)
}

/// Sixteen numbers of each column.
#[inline(always)]
fn load<S: Simd, const N: usize>(simd: S, columns: &[Column; N], at: usize) -> [f32x16<S>; N] {
    let mut vectors = [splat(simd, 0.0); N];
    for (vector, column) in vectors.iter_mut().zip(columns) {
        *vector = f32x16::from_slice(simd, &column[at..at + 16]);
    }
    vectors
}

/// Numbers side by side, each in its lane.
#[inline(always)]
fn expanded<S: Simd>(simd: S, numbers: &[f32], lanes: mask32x16<S>) -> f32x16<S> {
    f32x16::from_slice(simd, numbers).expand(lanes)
}

/// Material of an interval.
#[derive(Debug, Clone, Copy)]
pub(super) struct Interior<S: Simd> {
    /// Transmittance of all of it.
    through: f32x16<S>,
    /// Opacity of each half, as seen from the front; of thin intervals all is the first's.
    opacities: [f32x16<S>; 2],
    /// Place in the interval, 0 to 1, and value of each half's material.
    places: [f32x16<S>; 2],
    values: [f32x16<S>; 2],
    /// Whether any pixel's interval is cut in halves.
    in_halves: bool,
}

impl PlaneShader<'_> {
    /// Shades and composites the batch. Compiled once for both of its callers.
    pub(super) fn flush<S: Simd>(&self, simd: S, interval: &Interval<'_>, target: &mut ShadeTarget<'_>) {
        simd.vectorize(
            #[inline(always)]
            || self.shade_batch(simd, interval, target),
        );
    }

    #[inline(always)]
    fn shade_batch<S: Simd>(&self, simd: S, interval: &Interval<'_>, target: &mut ShadeTarget<'_>) {
        let mut at = 0;
        while at < target.batch.len.min(CAPACITY) {
            self.shade_sixteen(simd, interval, target.batch, at);
            at += 16;
        }
        let mut at = 0;
        for source in 0..target.batch.from.min(CAPACITY) {
            let Source { place, which } = target.batch.sources[source];
            self.composite(simd, target, (place, which, at));
            at += which.count_ones() as usize;
        }
        (target.batch.len, target.batch.from) = (0, 0);
    }

    /// Shades sixteen pixels of the batch.
    #[inline(always)]
    fn shade_sixteen<S: Simd>(&self, simd: S, interval: &Interval<'_>, batch: &mut ShadeBatch, at: usize) {
        let live = u64::from(u16::MAX) >> (16 - (batch.len - at).min(16));
        let live = mask32x16::from_bitmask(simd, live);
        let values = load(simd, &batch.values, at);
        let pixels = Pixels {
            values,
            along: match batch.has_along {
                true => load(simd, &batch.along, at),
                false => values,
            },
            coverage: match batch.is_covered {
                true => load(simd, &batch.coverage, at),
                false => [splat(simd, 1.0); 2],
            },
            rays: load(simd, &batch.rays, at),
        };
        let range = at..at + 16;
        let inside = self.interior(simd, &pixels, (live, interval.at_eye.is_some()));
        batch.count(simd, inside.as_ref(), live);
        let Some(inside) = inside else {
            splat(simd, 1.0).store_slice(&mut batch.through[range]);
            return;
        };
        let slopes = load(simd, &batch.slopes, at);
        let shown = self.show(simd, interval, (&pixels, &slopes), &inside);
        shown.through.store_slice(&mut batch.through[range.clone()]);
        for (channel, column) in shown.color.iter().zip(&mut batch.color) {
            channel.store_slice(&mut column[range.clone()]);
        }
        shown.depth.store_slice(&mut batch.depth[range]);
    }

    /// What sixteen pixels with this material show. `slopes`: those of the planes across, per world length, along x and y on
    /// the nearer middle plane, then on the farther.
    #[inline(always)]
    pub(super) fn show<S: Simd>(
        &self,
        simd: S,
        interval: &Interval<'_>,
        (pixels, slopes): (&Pixels<S>, &[f32x16<S>; 4]),
        inside: &Interior<S>,
    ) -> Material<S> {
        let [front, back] = inside.opacities;
        let [r, g, b] = self.table.color(simd, inside.values[0]);
        let mut color = [r * front, g * front, b * front];
        let (mut place, mut behind) = (inside.places[0], splat(simd, 0.0));
        if inside.in_halves {
            let second = self.table.color(simd, inside.values[1]);
            for c in 0..3 {
                color[c] += second[c] * back;
            }
            behind = back / (front + back).max(splat(simd, 1e-30));
            place += behind * (inside.places[1] - place);
        }
        let opacity = 1.0 - inside.through;
        if let Some(phong) = &self.phong {
            let first = self.gradient(interval, (pixels, slopes), inside.places[0]);
            let (mut diffuse, mut specular) = phong.lanes(simd, first);
            if inside.in_halves {
                let second = self.gradient(interval, (pixels, slopes), inside.places[1]);
                let (diffuse_behind, specular_behind) = phong.lanes(simd, second);
                diffuse += (diffuse_behind - diffuse) * behind;
                specular += (specular_behind - specular) * behind;
            }
            let shine = specular * opacity;
            for channel in &mut color {
                *channel = *channel * diffuse + shine;
            }
        }
        Material {
            through: inside.through,
            opacity,
            color,
            depth: place * self.spacing + interval.depths[0],
        }
    }

    /// Material of the interval; `None` if none of the live pixels holds any. Opaque intervals are cut in two halves, so
    /// that the front hides the back; so are those with material in the middle only.
    #[inline(always)]
    pub(super) fn interior<S: Simd>(
        &self,
        simd: S,
        pixels: &Pixels<S>,
        (live, from_eye): (mask32x16<S>, bool),
    ) -> Option<Interior<S>> {
        let Pixels {
            values: [before, v0, v1, after],
            coverage,
            rays: [ray_x, ray_y],
            ..
        } = *pixels;
        let length = (ray_x * ray_x + (1.0 + ray_y * ray_y)).sqrt() * self.spacing;
        let zero = splat(simd, 0.0);
        let ends = [self.table.classify(simd, v0), self.table.classify(simd, v1)];
        let whole = Segment::between(simd, [v0, v1], [&ends[0], &ends[1]]);
        let covered = (coverage[0] + coverage[1]) * 0.5;
        let extinction = whole.extinction * covered;
        let optical_depth = extinction * length;
        let holds = extinction.simd_gt(zero);
        let (m0, m1) = ((v1 - before) * 0.5, (after - v0) * 0.5);
        let vm = (v0 + v1) * 0.5 + (m0 - m1) * 0.125;
        let [first, last] = self.table.hull;
        let meets =
            v0.max(v1).max(vm).simd_ge(splat(simd, first)) & v0.min(v1).min(vm).simd_le(splat(simd, last));
        let bulges = (vm.simd_gt(v0.max(v1)) | vm.simd_lt(v0.min(v1))) & meets;
        let middle_matters = match self.table.densest * self.spacing > DENSE {
            true => bulges,
            false => bulges & !holds,
        };
        let cut = (optical_depth.simd_gt(splat(simd, THICK)) | middle_matters) & live;
        let through = exp2_quick(simd, optical_depth * -std::f32::consts::LOG2_E);
        let thin = Interior {
            through,
            opacities: [1.0 - through, zero],
            places: [whole.place; 2],
            values: [whole.value; 2],
            in_halves: false,
        };
        if !cut.any_true() {
            return if (holds & live).any_true() {
                Some(thin)
            } else {
                None
            };
        }
        let middle = self.table.classify(simd, vm);
        let mut halves = [
            Segment::between(simd, [v0, vm], [&ends[0], &middle]),
            Segment::between(simd, [vm, v1], [&middle, &ends[1]]),
        ];
        let first = halves[0].extinction * (coverage[0] + covered) * 0.5;
        let second = halves[1].extinction * (covered + coverage[1]) * 0.5;
        if !((holds | (first + second).simd_gt(zero)) & live).any_true() {
            return None;
        }
        let half = length * (-0.5 * std::f32::consts::LOG2_E);
        let least = splat(simd, LEAST_EXPONENT);
        let front = exp2_quick(simd, (first * half).max(least));
        let back = exp2_quick(simd, (second * half).max(least));
        if from_eye {
            halves[0].move_forward(simd, [v0, vm], (first * length * 0.5, front));
            halves[1].move_forward(simd, [vm, v1], (second * length * 0.5, back));
        }
        let [near, far] = halves;
        Some(Interior {
            through: cut.select(front * back, thin.through),
            opacities: [
                cut.select(1.0 - front, thin.opacities[0]),
                cut.select(front * (1.0 - back), zero),
            ],
            places: [cut.select(near.place * 0.5, whole.place), far.place * 0.5 + 0.5],
            values: [cut.select(near.value, whole.value), far.value],
            in_halves: true,
        })
    }

    /// Gradient at a place of the interval, camera space, per world length.
    #[inline(always)]
    fn gradient<S: Simd>(
        &self,
        interval: &Interval<'_>,
        (pixels, &[x_near, y_near, x_far, y_far]): (&Pixels<S>, &[f32x16<S>; 4]),
        place: f32x16<S>,
    ) -> [f32x16<S>; 3] {
        let [ray_x, ray_y] = pixels.rays;
        let x = (x_far - x_near) * place + x_near;
        let y = (y_far - y_near) * place + y_near;
        let slope = depth_slope(pixels.along, place, interval.sharpness(self.spacing));
        [x, y, slope * (1.0 / self.spacing) - ray_x * x - y * ray_y]
    }

    /// Composites collected pixels behind those of their row. `at`: the first of them in the batch.
    #[inline(always)]
    fn composite<S: Simd>(
        &self,
        simd: S,
        target: &mut ShadeTarget<'_>,
        (place, which, at): ([usize; 2], u64, usize),
    ) {
        let batch = &*target.batch;
        let lanes = mask32x16::from_bitmask(simd, which);
        let at = at.min(CAPACITY)..at.min(CAPACITY) + 16;
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let through = lanes.select(expanded(simd, &batch.through[at.clone()], lanes), one);
        let holds = through.simd_lt(one);
        if !holds.any_true() {
            return;
        }
        let mut color = [zero; 3];
        for (channel, column) in color.iter_mut().zip(&batch.color) {
            *channel = holds.select(expanded(simd, &column[at.clone()], lanes), zero);
        }
        let material = Material {
            through,
            opacity: 1.0 - through,
            color,
            depth: holds.select(expanded(simd, &batch.depth[at], lanes), zero),
        };
        self.put(simd, target, place, &material);
    }

    /// Composites material behind sixteen pixels of a row, and closes those that it finishes.
    #[inline(always)]
    pub(super) fn put<S: Simd>(
        &self,
        simd: S,
        target: &mut ShadeTarget<'_>,
        [x, y]: [usize; 2],
        material: &Material<S>,
    ) {
        let pixel = y * target.canvas.pitch + x;
        let finished = target.canvas.put(simd, pixel, material, self.termination);
        if finished != 0 {
            target.mask.finish(x, y, finished);
        }
    }
}
