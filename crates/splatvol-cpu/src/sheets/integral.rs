//! X-ray: classified voxels are splatted as their integrals along the rays.
//!
//! The integral of a voxel's Gaussian along the ray of pixel p (per depth) is itself a Gaussian of the voxel's
//! projected offset, of covariance `L + s_z^2 (p - t) (p - t)^T` in the notation of [`splatvol_core::footprint`].
//! It is exact in perspective, too, except for the length of the ray, which is applied at the end. So a voxel needs
//! only one sheet, and the four lanes of a pixel hold extinction and emission instead of four sheets. p is taken
//! from the tile's middle. The excess covariance D of a pixel is compensated as heat spreads, by
//! `I + D : grad grad I / 2`, at the pixel's mean depth.
//!
//! Voxels still enter slab by slab: footprints have their slab's size but their own centres and masses. For the
//! mean depth a second block per pixel sums `A = sum_s (s' - s) E_s`, with `E_s` the sum up to slab s and s' the
//! next slab. The sum over all slabs of content times index is then `s_last E - A`.

use fearless_simd::{f32x4, f32x16, mask32x16, prelude::*};
use splatvol_core::bin::TileRect;
use splatvol_core::normal;
use splatvol_core::plan::{RayShapes, SheetShape};

use super::canvas::Canvas;
use super::classified::{ClassifiedBricks, ClassifiedVoxels};
use super::compose::{ray_length, through_and_opacity};
use super::footprint::Scaled;
use super::frame::{SheetFrame, ZonedFrame};
use super::mode::{Bricks, Mode};
use super::place::Place;
use super::plane::{HALO, Plane};
use super::records::Records;
use super::ring::LANES;
use super::sheet::GroupShape;
use super::slab::Slab;
use super::splat::Payload;
use super::tile::{SheetScratch, take};
use super::upsample::Sums;
use crate::simd::math::exp2_of;
use splatvol_core::border::cumulative_of;

/// X-ray.
#[derive(Debug)]
pub(crate) struct Integral<'a> {
    pub bricks: ClassifiedBricks<'a>,
    pub shapes: RayShapes,
    /// Reach of a voxel in depth, world length.
    pub depth_reach: f64,
}

/// Extinction and emission of classified voxels, in the lanes of a pixel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct InLanes<'m>(&'m ClassifiedVoxels);

impl Payload<1> for InLanes<'_> {
    type Footprint = Scaled;

    #[inline(always)]
    fn weights<S: Simd>(&self, simd: S, value: f32, weight: f32x16<S>, peak: f32x16<S>) -> [f32x16<S>; 1] {
        let four = f32x4::from_slice(simd, self.0.voxel(value));
        let eight = four.combine(four);
        [weight * peak * eight.combine(eight)]
    }
}

/// Groups of the ring: sums of the voxels, and sums for their mean depth.
const SUMS: usize = 0;
const DEPTHS: usize = 1;

impl Mode<1> for Integral<'_> {
    type Payload<'m> = InLanes<'m>;

    fn payload(classified: &ClassifiedVoxels) -> InLanes<'_> {
        InLanes(classified)
    }

    #[inline(always)]
    fn bricks(&self) -> Bricks<'_> {
        Bricks::Classified(&self.bricks)
    }

    fn ring_groups(&self, _: &SheetFrame<'_>) -> usize {
        DEPTHS + 1
    }

    fn planes(&self) -> usize {
        LANES
    }

    fn begin(&self, canvas: &mut Canvas) {
        // Holds extinction until all zones have added theirs.
        canvas.transmittance.fill(0.0);
    }

    fn shape(&self, frame: &SheetFrame<'_>, place: &Place, sheet: usize) -> SheetShape {
        self.shapes
            .at(&frame.zone.raster, place.middle(), self.slab(frame, sheet).depth)
    }

    /// Depths of a slab. A voxel belongs to one slab only; on a plane, to the slab before it, even if that is in
    /// another zone.
    fn depths(&self, frame: &SheetFrame<'_>, sheet: usize) -> [f32; 2] {
        let before = (frame.stack.first + sheet as i64 - 1) as f64 * frame.stack.spacing;
        let first = match frame.zone.eye {
            Some(eye) if before <= eye => eye - self.depth_reach,
            _ => before,
        };
        [first as f32, frame.stack.plane(sheet) as f32]
    }

    fn group(&self, frame: &SheetFrame<'_>, place: &Place, sheet: usize, _: usize) -> GroupShape {
        let shape = self.shape(frame, place, sheet);
        GroupShape::same(&SheetShape {
            peak: shape.peak * self.slab(frame, sheet).most() / frame.mass_drawn(&shape),
            ..shape
        })
    }

    #[inline(always)]
    fn prepare<S: Simd>(
        &self,
        simd: S,
        (frame, sheet, first): (&SheetFrame<'_>, usize, bool),
        scratch: &mut SheetScratch,
    ) {
        let SheetScratch { ring, records, .. } = scratch;
        let gap = sheet as f32 - ring.last_sheet;
        if first && gap != 0.0 {
            let area = ring.touched[0];
            let [sums, depths] = ring.groups::<2>(SUMS, 1);
            for y in area.y0..area.y1 {
                for x in area.x0..area.x1 {
                    let sum = f32x16::from_slice(simd, &sums[y].0[x].0);
                    let depth = &mut depths[y].0[x].0;
                    (sum * gap + f32x16::from_slice(simd, depth)).store_slice(depth);
                }
            }
            ring.last_sheet = sheet as f32;
        }
        let slab = self.slab(frame, sheet);
        match frame.zone.eye {
            Some(eye) if slab_depth(frame, sheet) < eye + self.depth_reach => {
                self.leave_out_before_eye(frame, &slab, (records, eye as f32));
            }
            _ => slab.gather(simd, &frame.constants, records),
        }
    }

    #[inline(always)]
    fn take<S: Simd>(&self, _: S, _: &SheetFrame<'_>, _: &Place, _: usize, _: &mut SheetScratch) {}

    #[inline(always)]
    fn shade<S: Simd>(
        &self,
        _: S,
        _: &SheetFrame<'_>,
        _: usize,
        _: &Place,
        _: (&mut Canvas, &mut SheetScratch),
    ) {
    }

    #[inline(always)]
    fn leave<S: Simd>(
        &self,
        simd: S,
        frame: &SheetFrame<'_>,
        place: &Place,
        (canvas, scratch): (&mut Canvas, &mut SheetScratch),
    ) {
        let SheetScratch {
            ring,
            raster,
            upsampler,
            planes: [sums, [depths, ..], ..],
            ..
        } = scratch;
        for channel in 0..LANES {
            let slot = SUMS * LANES + channel;
            take(
                simd,
                (frame.step, Sums::Amounts),
                place,
                slot,
                (ring, &mut sums[channel]),
                (raster, upsampler),
            );
        }
        take(
            simd,
            (frame.step, Sums::Amounts),
            place,
            DEPTHS * LANES,
            (ring, depths),
            (raster, upsampler),
        );
        let last = ring.last_sheet;
        let shape = &self.shapes.shape;
        let ray = self.shapes.ray(place.middle());
        let [xx, _, yy] = self.shapes.covariance(ray);
        let mut pixels = Pixels {
            frame,
            place,
            canvas,
            drift: (ray - shape.lateral_slope).as_vec2().to_array(),
            slope: shape.lateral_slope.as_vec2().to_array(),
            depth_sigma: shape.depth_sigma as f32,
            own: [xx as f32, yy as f32],
            least: if frame.zone.raster.matched {
                frame.zone.raster.low_pass as f32
            } else {
                0.0
            },
        };
        for y in 0..place.size[1] {
            for x in (0..place.size[0]).step_by(16) {
                let at = (y + HALO) * depths.pitch + x + HALO;
                let extinction = load(simd, &sums[0].values, at);
                let seen = extinction.simd_gt(f32x16::splat(simd, 1e-20));
                if seen.any_true() {
                    let index = extinction * last - load(simd, &depths.values, at);
                    let index = index / seen.select(extinction, f32x16::splat(simd, 1.0));
                    pixels.add(simd, (sums, at), (seen, index), [x, y]);
                }
            }
        }
    }

    /// Line integrals per depth become pixels, as homogeneous slabs.
    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, frame: &ZonedFrame<'_>, rect: &TileRect, canvas: &mut Canvas) {
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        canvas.optical_depth.resize(canvas.transmittance.len(), 0.0);
        for y in 0..rect.y1 - rect.y0 {
            for x in (0..rect.x1 - rect.x0).step_by(16) {
                let pixel = y * canvas.pitch + x;
                let extinction = load(simd, &canvas.transmittance, pixel);
                let seen = extinction.simd_gt(zero);
                let length = ray_length(simd, &frame.plan.rays, [rect.x0 + x, rect.y0 + y]);
                let optical_depth = extinction * length;
                optical_depth.store_slice(&mut canvas.optical_depth[pixel..pixel + 16]);
                let (through, opacity) = through_and_opacity(simd, optical_depth);
                let per_extinction = opacity / seen.select(extinction, one);
                for plane in &mut canvas.color {
                    let emission = load(simd, plane, pixel);
                    (emission * per_extinction).store_slice(&mut plane[pixel..pixel + 16]);
                }
                let depth = load(simd, &canvas.depth_sum, pixel);
                (depth * opacity).store_slice(&mut canvas.depth_sum[pixel..pixel + 16]);
                through.store_slice(&mut canvas.transmittance[pixel..pixel + 16]);
            }
        }
    }
}

impl Integral<'_> {
    /// Depth of a slab's footprints. It is the slab's middle. Within reach of the eye it is the mean depth of the
    /// visible part of a kernel there. In the slab that begins at the eye, which also has all kernels before it, it
    /// is the mean depth of half a kernel.
    fn slab(&self, frame: &SheetFrame<'_>, sheet: usize) -> Slab {
        let middle = slab_depth(frame, sheet);
        let sigma = self.shapes.shape.depth_sigma;
        let begin = middle - 0.5 * frame.stack.spacing;
        let (begin, depth) = match frame.zone.eye {
            Some(eye) if begin <= eye => (eye, middle.max(eye + MEAN_OF_HALF * sigma)),
            Some(eye) if middle < eye + self.depth_reach => {
                let before = (eye - middle) / sigma;
                let moved = sigma * normal::density(before) / normal::cumulative(-before);
                (begin, middle + moved)
            }
            _ => (begin, middle),
        };
        Slab {
            begin: begin as f32,
            depth,
            is_wider_when_near: frame.rays.per_pixel > 0.0,
        }
    }

    /// Reduces voxels at the eye to their visible part, which lies behind its depth: a share of them, at that
    /// share's mean depth.
    fn leave_out_before_eye(&self, frame: &SheetFrame<'_>, slab: &Slab, (records, eye): (&mut Records, f32)) {
        let depth = slab.depth as f32;
        let sigma = self.shapes.shape.depth_sigma as f32;
        let slope = self.shapes.shape.lateral_slope.as_vec2();
        let most = slab.most();
        for n in 0..records.len {
            let before = (eye - records.z[n]) / sigma;
            let share = cumulative_of(-before);
            let density = exp2_of(-0.5 * std::f32::consts::LOG2_E * before * before) * PER_ROOT_TWO_PI;
            let moved = (sigma * density / share).max(sigma * before);
            let ratio = if slab.is_wider_when_near {
                depth / (records.z[n] + moved)
            } else {
                1.0
            };
            records.x[n] = (records.x[n] + slope.x * moved) * ratio;
            records.y[n] = (records.y[n] + slope.y * moved) * ratio;
            let share = (share * ratio * ratio / most).min(1.0);
            records.z[n] =
                depth - (libm::log2f(share).max(LEAST_SHARE) / frame.constants.depth_exponent).sqrt();
        }
    }
}

/// Least share, as a power of two, of a voxel that is cut by the plane of the eye.
const LEAST_SHARE: f32 = -60.0;

/// Mean of half a Gaussian, standard deviations.
const MEAN_OF_HALF: f64 = 0.8;
/// `1 / sqrt(2 pi)`.
const PER_ROOT_TWO_PI: f32 = 0.398_942_3;

#[inline(always)]
fn load<S: Simd>(simd: S, plane: &[f32], at: usize) -> f32x16<S> {
    f32x16::from_slice(simd, &plane[at..at + 16])
}

/// A channel's second differences around sixteen pixels, xx, 2 xy and yy, times the excess covariance.
#[inline(always)]
fn spread<S: Simd>(simd: S, plane: &Plane, at: usize, [xx, xy, yy]: [f32x16<S>; 3]) -> f32x16<S> {
    let (values, pitch) = (&plane.values, plane.pitch);
    let twice = load(simd, values, at) * 2.0;
    let across = load(simd, values, at + 1) + load(simd, values, at - 1) - twice;
    let down = load(simd, values, at + pitch) + load(simd, values, at - pitch) - twice;
    let rising = load(simd, values, at + pitch + 1) + load(simd, values, at - pitch - 1);
    let falling = load(simd, values, at + pitch - 1) + load(simd, values, at - pitch + 1);
    (xx * across + yy * down + xy * (rising - falling) * 0.5) * 0.5
}

/// A tile's pixels.
struct Pixels<'a> {
    frame: &'a SheetFrame<'a>,
    place: &'a Place,
    canvas: &'a mut Canvas,
    /// Drift of footprints for the tile's middle, and for a camera that looks along the axis.
    drift: [f32; 2],
    slope: [f32; 2],
    depth_sigma: f32,
    /// Covariance xx and yy of the tile's middle, world length squared.
    own: [f32; 2],
    /// Variance to which the filter widens narrower footprints, pixels squared.
    least: f32,
}

impl Pixels<'_> {
    /// Excess covariance of sixteen pixels' footprints at given depths over that of the tile's middle: xx, xy, yy,
    /// pixels squared.
    #[inline(always)]
    fn lacking<S: Simd>(&self, simd: S, depth: f32x16<S>, [x, y]: [usize; 2]) -> [f32x16<S>; 3] {
        let rays = &self.frame.rays;
        let [cx, cy] = rays.principal;
        let (x, y) = ((self.place.rect.x0 + x) as f32, (self.place.rect.y0 + y) as f32);
        let lanes = f32x16::from_slice(simd, &NUMBERS);
        let across = (lanes + (x + 0.5 - cx)) * rays.per_pixel - self.slope[0];
        let down = f32x16::splat(simd, (y + 0.5 - cy) * rays.per_pixel - self.slope[1]);
        let [own_x, own_y] = self.drift;
        let per_length = f32x16::splat(simd, 1.0) / (depth * rays.per_pixel);
        let area = per_length * per_length;
        let square = area * (self.depth_sigma * self.depth_sigma);
        let xx = (across * across - own_x * own_x) * square;
        let yy = (down * down - own_y * own_y) * square;
        // Where the filter widens footprints, it adds less to wider ones.
        let (own_xx, own_yy) = (area * self.own[0], area * self.own[1]);
        let zero = f32x16::splat(simd, 0.0);
        let filter = (self.least - (own_xx + xx).min(own_yy + yy)).max(zero)
            - (self.least - own_xx.min(own_yy)).max(zero);
        [xx + filter, (across * down - own_x * own_y) * square, yy + filter]
    }

    /// Adds sixteen line integrals per depth, of the lanes `seen`; `index`: mean index of the slab.
    #[inline(always)]
    fn add<S: Simd>(
        &mut self,
        simd: S,
        (sums, at): (&[Plane; LANES], usize),
        (seen, index): (mask32x16<S>, f32x16<S>),
        [x, y]: [usize; 2],
    ) {
        let frame = self.frame;
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let depth = index * (frame.stack.spacing as f32) + slab_depth(frame, 0) as f32;
        let mut channels = [zero; LANES];
        for channel in 0..LANES {
            channels[channel] = load(simd, &sums[channel].values, at);
        }
        if frame.rays.per_pixel > 0.0 {
            let depth = seen.select(depth, one);
            let lacking = self.lacking(simd, depth, [x, y]);
            for channel in 0..LANES {
                let spread = spread(simd, &sums[channel], at, lacking);
                // The compensation is small; more than half would be noise.
                let half = channels[channel] * 0.5;
                channels[channel] += spread.max(-half).min(half);
            }
        }
        let [extinction, emission @ ..] = channels;
        let extinction = seen.select(extinction, zero);
        let canvas = &mut *self.canvas;
        let pixel = y * canvas.pitch + x;
        let all = load(simd, &canvas.transmittance, pixel) + extinction;
        all.store_slice(&mut canvas.transmittance[pixel..pixel + 16]);
        for c in 0..3 {
            let emission = seen.select(emission[c], zero) + load(simd, &canvas.color[c], pixel);
            emission.store_slice(&mut canvas.color[c][pixel..pixel + 16]);
        }
        // The mean depth moves towards this zone's by its share.
        let share = extinction / all.simd_gt(zero).select(all, one);
        let before = load(simd, &canvas.depth_sum, pixel);
        let depth = (seen.select(depth, zero) - before) * share + before;
        depth.store_slice(&mut canvas.depth_sum[pixel..pixel + 16]);
    }
}

/// Lane numbers.
const NUMBERS: [f32; 16] = [
    0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0,
];

/// Depth of the middle of the slab that ends at a sheet's plane.
fn slab_depth(frame: &SheetFrame<'_>, sheet: usize) -> f64 {
    frame.stack.plane(sheet) - 0.5 * frame.stack.spacing
}
