//! Analytic gradients: coefficients are splatted with their kernels' derivatives, and intervals between planes are
//! classified, lit and composited in up to eight pieces.

use fearless_simd::{f32x16, mask32x16, prelude::*};
use splatvol_core::classification::ClassificationTable;
use splatvol_core::field::FieldStore;
use splatvol_core::plan::SheetShape;

use super::canvas::{Canvas, Material};
use super::classified::ClassifiedVoxels;
use super::compose::through_and_opacity;
use super::fine_table::{ColoredSegment, FineTable, advantage};
use super::frame::SheetFrame;
use super::gradients::Moments;
use super::hermite::{End, Hermite, RayLanes, pieces};
use super::holes::{self, Holes};
use super::lattice_weights::{LatticeWeights, WeightPlane, Weights};
use super::mode::{Bricks, Mode};
use super::place::Place;
use super::plane::{HALO, Plane, Span};
use super::shade::{MIDDLES, PlaneShader};
use super::shaded::filled;
use super::tile::{MAX_CHANNELS, SheetScratch};

/// Sums that planes hold beside the values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sums {
    /// Moments, of which gradients are made ([`super::gradients`]).
    Moments,
    /// Slopes along the rays ([`super::slopes`]).
    Slopes,
}

/// A field whose coefficients are splatted with their kernels' derivatives.
#[derive(Debug)]
pub(crate) struct AnalyticField<'a> {
    pub store: &'a FieldStore,
    pub shader: PlaneShader<'a>,
    pub sums: Sums,
    pub weights: LatticeWeights,
}

/// Post-classification with analytic gradients.
#[derive(Debug)]
pub(crate) struct Analytic<'a> {
    field: AnalyticField<'a>,
    table: FineTable,
}

/// Coefficients of the gradient, from a sheet's sums of moments.
#[derive(Debug, Clone, Copy)]
struct Derivative {
    /// Per world length: `-Q` times raster points per world length.
    xx: f32,
    xy: f32,
    yy: f32,
    /// `-1 / s^2`, s the kernel's standard deviation in depth.
    zz: f32,
    /// Drift of footprints per depth.
    slope: [f32; 2],
}

impl Derivative {
    fn new(frame: &SheetFrame<'_>, sheet: &SheetShape) -> Self {
        let [xx, xy, yy] = sheet.exponent.map(|e| -std::f32::consts::LN_2 * e * sheet.scale);
        Self {
            xx: 2.0 * xx,
            xy,
            yy: 2.0 * yy,
            zz: 2.0 * std::f32::consts::LN_2 * frame.constants.depth_exponent,
            slope: frame.constants.slope,
        }
    }

    /// Camera space, per world length.
    #[inline(always)]
    fn gradient<S: Simd>(&self, [x, y, z]: [f32x16<S>; 3]) -> [f32x16<S>; 3] {
        let (along_x, along_y) = (x * self.xx + y * self.xy, x * self.xy + y * self.yy);
        // The depth derivative was taken along the footprint's drift.
        let along_z = z * self.zz - along_x * self.slope[0] - along_y * self.slope[1];
        [along_x, along_y, along_z]
    }
}

/// The interval between two planes of a tile.
pub(crate) struct AnalyticInterval<'a> {
    sums: Sums,
    planes: [&'a [Plane; MAX_CHANNELS]; 2],
    derivatives: [Derivative; 2],
    /// The gradient at the nearer plane if that is at the eye, where there are no sums of moments.
    at_eye: Option<[f32; 3]>,
    /// Weights of missing samples with their moments, if any, and their gradient at the eye.
    holes: Option<[&'a [Plane; MAX_CHANNELS]; 2]>,
    holes_at_eye: [f32; 3],
    faces: [WeightPlane; 2],
    is_near_face: bool,
    /// Camera depth of the nearer plane.
    pub depth: f32,
    /// Image coordinates of the tile's first pixel.
    origin: [usize; 2],
}

impl AnalyticInterval<'_> {
    /// Image coordinates of one of the tile's pixels.
    #[inline(always)]
    pub(crate) fn in_picture(&self, [x, y]: [usize; 2]) -> [usize; 2] {
        [self.origin[0] + x, self.origin[1] + y]
    }

    /// The gradient of a sum on one of the planes; for slopes along the rays, only the slope.
    #[inline(always)]
    fn gradient<S: Simd>(
        &self,
        simd: S,
        (which, planes): (usize, &[Plane; MAX_CHANNELS]),
        at: usize,
    ) -> [f32x16<S>; 3] {
        match self.sums {
            Sums::Moments => self.derivatives[which].gradient([
                load(simd, &planes[1].values, at),
                load(simd, &planes[2].values, at),
                load(simd, &planes[3].values, at),
            ]),
            Sums::Slopes => {
                let zero = f32x16::splat(simd, 0.0);
                [zero, zero, load(simd, &planes[1].values, at)]
            }
        }
    }

    /// Weights of missing samples at sixteen pixels of one of the planes, and their gradient; `None` where there
    /// are none.
    #[inline(always)]
    fn missing<S: Simd>(
        &self,
        simd: S,
        which: usize,
        [x, y]: [usize; 2],
    ) -> Option<(f32x16<S>, [f32x16<S>; 3])> {
        let planes = self.holes?[which];
        let at = (y + HALO) * planes[0].pitch + x + HALO;
        let missing = load(simd, &planes[0].values, at);
        holes::any(simd, missing).then(|| {
            let gradient = match self.at_eye {
                Some(_) if which == 0 => self.holes_at_eye.map(|along| f32x16::splat(simd, along)),
                _ => self.gradient(simd, (which, planes), at),
            };
            (missing, gradient)
        })
    }

    /// Weights of missing samples in the middle between the planes, by a cubic along the rays, without gradient.
    #[inline(always)]
    pub(crate) fn missing_between<S: Simd>(
        &self,
        simd: S,
        rays: &RayLanes<S>,
        place: [usize; 2],
    ) -> Option<f32x16<S>> {
        let zero = f32x16::splat(simd, 0.0);
        let ends = [0, 1].map(|which| self.missing(simd, which, place));
        if ends.iter().all(Option::is_none) {
            return None;
        }
        let [(near, rise), (far, fall)] = ends.map(|end| match end {
            Some((missing, gradient)) => (missing, rays.along(gradient)),
            None => (zero, zero),
        });
        Some(((near + far) * 0.5 + (rise - fall) * (0.125 * rays.spacing)).max(zero))
    }

    /// Which of sixteen pixels have a sum on one of the planes.
    #[inline(always)]
    fn is_touched<S: Simd>(&self, simd: S, [x, y]: [usize; 2]) -> mask32x16<S> {
        let at = (y + HALO) * self.planes[0][0].pitch + x + HALO;
        let [near, far] = self.planes;
        let (near, far) = (load(simd, &near[0].values, at), load(simd, &far[0].values, at));
        near.abs().max(far.abs()).simd_gt(f32x16::splat(simd, 0.0))
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, plane: &[f32], at: usize) -> f32x16<S> {
    f32x16::from_slice(simd, &plane[at..at + 16])
}

impl AnalyticField<'_> {
    /// The interval behind a sheet, and its non-empty pixels.
    pub(crate) fn interval<'s>(
        &self,
        frame: &SheetFrame<'_>,
        (near, place): (usize, &Place),
        (planes, holes, at_eye): (&'s [[Plane; MAX_CHANNELS]; 4], &'s Holes, Option<[f32; 3]>),
    ) -> Option<(AnalyticInterval<'s>, Span)> {
        let span = filled(planes.each_ref().map(|p| &p[0]), place)?;
        let [first, second] = frame.sheets.get(near..near + 2)? else {
            return None;
        };
        let faces = [first, second].map(|sheet| {
            self.weights
                .on_plane(self.shader.pixels(sheet.depth), sheet.low_pass)
        });
        let interval = AnalyticInterval {
            sums: self.sums,
            planes: [&planes[1], &planes[2]],
            derivatives: [Derivative::new(frame, first), Derivative::new(frame, second)],
            at_eye,
            holes: self.store.any_missing().then(|| holes.moments()).flatten(),
            holes_at_eye: holes.at_eye,
            is_near_face: faces
                .iter()
                .any(|plane| self.weights.is_near_any(plane, &place.rect)),
            faces,
            depth: first.depth,
            origin: [place.rect.x0, place.rect.y0],
        };
        Some((interval, span))
    }

    /// The field along the rays of sixteen pixels between an interval's planes.
    #[inline(always)]
    pub(crate) fn along_rays<S: Simd>(
        &self,
        simd: S,
        interval: &AnalyticInterval<'_>,
        place: [usize; 2],
    ) -> (Hermite<S>, RayLanes<S>) {
        let ends = [
            self.end(simd, interval, 0, place),
            self.end(simd, interval, 1, place),
        ];
        let rays = self.rays(simd, interval.in_picture(place));
        let field = Hermite::new(simd, [&ends[0], &ends[1]], rays, self.shader.background);
        (field, rays)
    }

    /// Whether sixteen pixels are near a face on one of an interval's planes.
    #[inline(always)]
    pub(crate) fn is_near_face(&self, interval: &AnalyticInterval<'_>, in_picture: [usize; 2]) -> bool {
        interval.is_near_face
            && interval
                .faces
                .iter()
                .any(|face| self.weights.is_near(face, in_picture))
    }

    /// The sums of sixteen pixels on one of the planes.
    #[inline(always)]
    fn end<S: Simd>(
        &self,
        simd: S,
        interval: &AnalyticInterval<'_>,
        which: usize,
        [x, y]: [usize; 2],
    ) -> End<S> {
        let planes = interval.planes[which];
        let at = (y + HALO) * planes[0].pitch + x + HALO;
        let in_picture = interval.in_picture([x, y]);
        let face = &interval.faces[which];
        let mut weights = if interval.is_near_face && self.weights.is_near(face, in_picture) {
            self.weights.at(simd, face, in_picture)
        } else {
            Weights::inside(simd)
        };
        if let Some((missing, gradient)) = interval.missing(simd, which, [x, y]) {
            weights.leave_out(simd, missing, gradient);
        }
        End {
            sum: load(simd, &planes[0].values, at),
            gradient: match interval.at_eye {
                Some(gradient) if which == 0 => gradient.map(|along| f32x16::splat(simd, along)),
                _ => interval.gradient(simd, (which, planes), at),
            },
            weights,
        }
    }

    /// The rays of sixteen pixels.
    #[inline(always)]
    fn rays<S: Simd>(&self, simd: S, [x, y]: [usize; 2]) -> RayLanes<S> {
        let [cx, cy] = self.shader.principal;
        let across = (f32x16::from_slice(simd, &MIDDLES) + (x as f32 - cx)) * self.shader.per_pixel;
        let down = (y as f32 + 0.5 - cy) * self.shader.per_pixel;
        RayLanes {
            slope: [across, f32x16::splat(simd, down)],
            squared: across * across + (1.0 + down * down),
            spacing: self.shader.spacing,
        }
    }
}

impl<'a> Analytic<'a> {
    pub(crate) fn new(field: AnalyticField<'a>, classification: &ClassificationTable) -> Self {
        Self {
            field,
            table: FineTable::new(classification),
        }
    }

    /// Composites the interval behind sixteen pixels; returns those that it finished.
    #[inline(always)]
    fn composite<S: Simd>(
        &self,
        simd: S,
        interval: &AnalyticInterval<'_>,
        canvas: &mut Canvas,
        (place, open): ([usize; 2], mask32x16<S>),
    ) -> u16 {
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let shader = &self.field.shader;
        if !shader.table.shows_background && !(interval.is_touched(simd, place) & open).any_true() {
            return 0;
        }
        let (field, rays) = self.field.along_rays(simd, interval, place);
        let (meets, bend) = field.may_meet(simd, shader.table.hull);
        let covered = field.coverage(simd, zero).max(field.coverage(simd, one));
        let seen = meets & open & covered.simd_gt(zero);
        if !seen.any_true() {
            return 0;
        }
        let mut front = self.table.classify(simd, field.value(zero));
        let last = self.table.classify(simd, field.value(one));
        let length = rays.squared.sqrt() * shader.spacing;
        let whole = ColoredSegment::between(simd, [&front, &last]).extinction * length;
        let count = seen.select(pieces(simd, bend, whole), zero);
        let most = count.as_slice().iter().fold(0.0f32, |most, &n| most.max(n));
        let share = one / count.max(one);

        let mut through = one;
        let (mut color, mut opacities, mut depth_sum) = ([zero; 3], zero, zero);
        let mut piece = 0.0;
        while piece < most {
            let start = share * piece;
            let back = self.table.classify(simd, field.value((start + share).min(one)));
            let segment = ColoredSegment::between(simd, [&front, &back]);
            front = back;
            let coverage = field.coverage(simd, share * 0.5 + start);
            let exists = count.simd_gt(f32x16::splat(simd, piece));
            piece += 1.0;
            let optical_depth = exists.select(segment.extinction * coverage * length * share, zero);
            if !optical_depth.simd_gt(zero).any_true() {
                continue;
            }
            let u = segment.place * share + start;
            let (left, opacity) = through_and_opacity(simd, optical_depth);
            let (diffuse, specular) = match &shader.phong {
                Some(phong) => phong.lanes(simd, field.gradient(u)),
                None => (one, zero),
            };
            let visible = through * opacity;
            let in_front = through * advantage(simd, optical_depth, left, opacity) * diffuse;
            for c in 0..3 {
                color[c] +=
                    (segment.color[c] * diffuse + specular) * visible + segment.half_step[c] * in_front;
            }
            opacities += visible;
            depth_sum += (u * shader.spacing + interval.depth) * visible;
            through *= left;
        }
        let material = Material {
            through,
            opacity: opacities,
            color,
            depth: depth_sum / opacities.max(f32x16::splat(simd, f32::MIN_POSITIVE)),
        };
        let pixel = place[1] * canvas.pitch + place[0];
        canvas.put(simd, pixel, &material, shader.termination)
    }
}

impl Mode<4> for Analytic<'_> {
    type Payload<'m> = Moments;

    fn payload(_: &ClassifiedVoxels) -> Moments {
        Moments
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
        let SheetScratch {
            planes,
            mask,
            at_eye,
            holes,
            ..
        } = scratch;
        let Some((interval, span)) = self
            .field
            .interval(frame, (near, place), (planes, holes, *at_eye))
        else {
            return;
        };
        for y in span.y0..span.y1 {
            let mut x = span.x0 / 16 * 16;
            while x < span.x1 {
                let bits = mask.sixteen(x, y);
                if bits != 0 {
                    let open = mask32x16::from_bitmask(simd, u64::from(bits));
                    let finished = self.composite(simd, &interval, canvas, ([x, y], open));
                    if finished != 0 {
                        mask.finish(x, y, finished);
                    }
                }
                x += 16;
            }
        }
    }
}
