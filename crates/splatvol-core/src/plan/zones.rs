//! Zones: runs of sheets along depth, each with a raster of its own.
//!
//! Where the footprints of a whole frame fit one raster there is one zone. Else zones follow each other from the
//! eye on: each takes the raster that suits its nearest sheet, and ends where that is too coarse for its farthest
//! one. An interval between planes belongs to one zone. Its planes, at its ends and before and behind for the
//! slopes, are made in that zone's raster. So two zones share no sum, and rasters differ by the error of a cubic
//! spline for a Gaussian of 0.8 points, which is invisible.
//!
//! Within [`NEAR`] reaches of a voxel in front of the eye the sheets of one voxel differ much in scale: weights are
//! computed one by one (`direct`) there, and at wide angles. A perspective camera has no plane at depth 0, where
//! the scale is undefined; `eye` handles the interval from there to the first plane.

use std::ops::Range;

use glam::DVec3;
use splatvol_scene::ScreenFromCamera;

use super::blocks::{blocks_of, fit_blocks, room_of};
use super::extents::{Ellipses, Extents, NEAR, STEEP, round_powers_fit};
use super::raster::{Raster, SheetShape};
use crate::footprint::FootprintShape;
use crate::sheets::Planes;

/// Width of a zone's farthest footprints relative to its nearest ones, where the nearest are too narrow already.
const TOO_NARROW: f64 = 0.6;
/// Intervals of a zone below which the voxels that two zones share cost more than large footprints.
const SHORT: usize = 24;

/// Evaluation of footprints.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Evaluation {
    /// Columns and rows of powers, counted from the first block.
    Round,
    /// Powers counted from the block in the middle.
    Ellipses,
    /// An exponential for each weight: the powers do not fit f32.
    Direct,
}

/// A run of sheets.
#[derive(Debug, Clone)]
pub struct Zone {
    /// Planes, from the first one of the tile loop on.
    pub planes: Planes,
    /// The first plane that is made. No earlier one is made; voxels before it enter in order.
    pub first_made: usize,
    /// Visible intervals, counted from the first of the planes.
    pub shown: Range<usize>,
    /// The last sheet of the tile loop.
    pub last_sheet: usize,
    /// Raster of its sheets.
    pub raster: Raster,
    /// Evaluation of its footprints.
    pub footprints: Evaluation,
    /// Cut of footprints, standard deviations.
    pub cut: f64,
    /// Depth of the eye, if the volume extends in front of it; nothing nearer is visible.
    pub eye: Option<f64>,
    /// Largest distance in depth between a voxel and its footprints, world length.
    pub depth_reach: f32,
}

/// Planes of a frame, and the visible intervals between them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sheets {
    pub planes: Planes,
    /// First interval that is shown, in front of the camera.
    pub first_shown: usize,
    /// End of the intervals that are shown, or slabs: there is one slab (before a plane) more than intervals between
    /// planes.
    pub end: usize,
    /// Whether another level shows the volume before the first interval.
    pub goes_on: bool,
    /// Depth at which visibility begins, if the volume extends in front of it.
    pub eye: Option<f64>,
}

impl Sheets {
    /// Planes before, within and behind camera-space corners grown by `reach`. With `xray_from`, slabs between the
    /// corners, from this depth on where rays diverge.
    pub(super) fn covering(
        corners: &[DVec3],
        reach: f64,
        spacing: f64,
        (screen, xray_from): (&ScreenFromCamera, Option<f64>),
    ) -> Self {
        let around = if xray_from.is_some() { 0.0 } else { reach };
        let planes = Planes::covering(corners, around, spacing, screen);
        let eye = match (xray_from, screen.perspective) {
            (Some(depth), true) => depth,
            (None, true) => planes.spacing,
            (_, false) => 0.0,
        };
        // Slabs lie before their planes.
        let slab = i64::from(xray_from.is_some());
        let first_shown = (eye / planes.spacing) as i64 + slab - planes.first;
        let nearest = corners
            .iter()
            .fold(f64::INFINITY, |near, corner| near.min(corner.z))
            - reach;
        Self {
            planes,
            first_shown: first_shown.max(0) as usize,
            end: planes.count + slab as usize,
            goes_on: false,
            eye: Some(eye).filter(|&eye| nearest < eye),
        }
    }

    /// The intervals among these, counted from depth 0.
    pub(super) fn between(self, shown: &Range<i64>) -> Self {
        let local = |interval: i64| interval.saturating_sub(self.planes.first).max(0) as usize;
        let goes_on = local(shown.start) > self.first_shown;
        Self {
            first_shown: self.first_shown.max(local(shown.start)),
            end: self.end.min(local(shown.end)),
            goes_on,
            eye: self.eye.filter(|_| !goes_on),
            ..self
        }
    }

    /// Depths of the nearest and the farthest footprint.
    fn depths(&self, extents: &Extents) -> [f64; 2] {
        let [first, last] = self.made(extents, &(self.first_shown..self.end));
        let nearest = match self.goes_on {
            true => self.planes.plane(first),
            false if extents.along_rays => self.planes.plane(0) - self.planes.spacing,
            false => self.planes.plane(0),
        };
        [nearest, self.planes.plane(last.max(first))]
    }

    /// Depth of a sheet's footprints.
    fn depth(&self, extents: &Extents, sheet: usize) -> f64 {
        let before = if extents.along_rays { 0.5 } else { 0.0 };
        self.planes.plane(sheet) - before * self.planes.spacing
    }

    /// First and last plane that are made for intervals, or slabs.
    fn made(&self, extents: &Extents, shown: &Range<usize>) -> [usize; 2] {
        if extents.along_rays {
            [shown.start, shown.end - 1]
        } else {
            [
                shown.start.saturating_sub(1),
                (shown.end + 1).min(self.planes.count),
            ]
        }
    }
}

/// Kernel shared by the footprints of all voxels.
#[derive(Debug, Clone, Copy)]
pub(super) struct GridKernel {
    pub shape: FootprintShape,
    pub round: bool,
    /// Sheets that a voxel meets.
    pub sheets: usize,
    /// Cut of the kernel, standard deviations.
    pub cut: f64,
}

/// Inputs of the zone cutter.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cutting<'a> {
    pub extents: &'a Extents,
    pub sheets: &'a Sheets,
    pub kernels: GridKernel,
}

impl Cutting<'_> {
    /// Cuts the sheets of a frame into zones, front to back; none where all is behind the camera.
    pub(super) fn cut(&self, mut add: impl FnMut(Zone)) {
        let Self { extents, sheets, .. } = *self;
        let Sheets {
            planes,
            first_shown,
            end,
            ..
        } = *sheets;
        if first_shown >= end {
            return;
        }
        let ends = sheets.depths(extents);
        let [nearest, _] = ends;
        if let Some(raster) = extents.one_raster(ends) {
            if let Some(footprints) = self.plain_footprints(&raster, ends) {
                let zone = self.zone(first_shown..end, raster);
                add(Zone { footprints, ..zone });
                return;
            }
            if !extents.is_near(nearest) {
                add(self.any_footprints(self.zone(first_shown..end, raster)));
                return;
            }
        }
        let mut from = first_shown;
        while from < end {
            let [first, _] = sheets.made(extents, &(from..from + 1));
            let [finest, comfortable] = extents.finest_and_comfortable(sheets.depth(extents, first));
            let near = extents.is_near(planes.plane(first));
            // The raster that reproduces the narrowest footprints of two intervals.
            let [_, last] = sheets.made(extents, &(from..(from + 2).min(end)));
            let coarsest = extents.coarsest(sheets.depth(extents, last));
            let (finest, comfortable) = if extents.widths.is_exact || extents.are_elongated() {
                // Footprints of any size, rather than widened ones.
                (finest.min(coarsest), comfortable.min(coarsest))
            } else if near || extents.is_too_steep() {
                // No square of blocks has to hold the widest.
                (finest.min(coarsest), comfortable)
            } else {
                (finest, comfortable)
            };
            let to = self.reach(comfortable, from);
            let (octaves, to) = if to == end || to >= from + SHORT {
                (comfortable, to)
            } else {
                (finest, self.reach(finest, from))
            };
            let zone = self.zone(from..to, extents.raster(octaves));
            add(if near { zone } else { self.any_footprints(zone) });
            from = to;
        }
    }

    /// End of the intervals from `from` on whose footprints fit a raster of so many octaves; at least one interval.
    fn reach(&self, octaves: f64, from: usize) -> usize {
        let Self { extents, sheets, .. } = *self;
        let mut end = sheets.end;
        let [first, last_of_first] = sheets.made(extents, &(from..from + 1));
        if extents.is_near(sheets.planes.plane(first)) {
            // A near zone ends where the first zone that is not near may begin.
            let far = (NEAR * extents.reach / sheets.planes.spacing).ceil() as i64 + 1 - sheets.planes.first;
            end = end.min((far.max(0) as usize).max(from + 1));
        }
        let narrowest = |plane: usize| extents.narrowest(sheets.depth(extents, plane));
        // Where even the first sheet's footprints are too narrow, being long ones, those behind may be somewhat
        // narrower.
        let wanted = extents.least(octaves);
        let first = narrowest(last_of_first);
        let least = if first < wanted {
            TOO_NARROW * first
        } else {
            wanted
        };
        let holds = |to: usize| octaves <= 0.0 || narrowest(sheets.made(extents, &(from..to))[1]) >= least;
        // Footprints shrink with depth.
        let (mut low, mut high) = (from + 1, end);
        while low < high {
            let middle = (low + high).div_ceil(2);
            if holds(middle) {
                low = middle;
            } else {
                high = middle - 1;
            }
        }
        low
    }

    /// A zone of some intervals, or slabs, before its footprints are chosen.
    fn zone(&self, shown: Range<usize>, raster: Raster) -> Zone {
        let Self {
            extents,
            sheets,
            kernels,
        } = *self;
        let [first, last] = sheets.made(extents, &shown);
        let eye = sheets
            .eye
            .filter(|_| extents.along_rays || shown.start == sheets.first_shown);
        // Where the volume extends in front of the first plane, so does the loop, by the sheets that a voxel meets.
        let goes_on =
            !extents.along_rays && (eye.is_some() || sheets.goes_on || shown.start > sheets.first_shown);
        let lead = if goes_on { kernels.sheets - 1 } else { 0 };
        let planes = Planes {
            first: sheets.planes.first + first as i64 - lead as i64,
            count: last - first + lead,
            ..sheets.planes
        };
        // The first interval begins at the eye, where there is no plane.
        let at_eye = usize::from(eye.is_some() && extents.screen.perspective);
        let (local, last_sheet) = if extents.along_rays {
            // Voxels that rounding puts behind the last slab belong to it.
            let behind = usize::from(shown.end == sheets.end);
            (0..0, planes.count + behind)
        } else {
            let local = shown.start + lead - first - at_eye..shown.end + lead - first;
            (local.clone(), local.end + 1)
        };
        Zone {
            planes,
            first_made: lead,
            shown: local,
            last_sheet,
            raster,
            footprints: Evaluation::Direct,
            cut: self.footprint_cut(&raster),
            eye,
            depth_reach: if extents.along_rays {
                f32::INFINITY
            } else {
                extents.reach as f32
            },
        }
    }

    fn footprint_cut(&self, raster: &Raster) -> f64 {
        let Self { extents, kernels, .. } = self;
        let cut = extents.widths.cut;
        let changed = raster.step > 1 || raster.low_pass > 0.0 && !raster.matched;
        if extents.widths.is_exact {
            cut
        } else if extents.along_rays {
            cut.max(kernels.cut)
        } else if changed || !kernels.round {
            cut
        } else {
            kernels.cut
        }
    }

    /// Evaluation of footprints for a frame with one raster, seen from afar and not at a wide angle; `None`
    /// otherwise, or if their powers do not fit f32.
    fn plain_footprints(&self, raster: &Raster, ends: [f64; 2]) -> Option<Evaluation> {
        let Self {
            extents,
            sheets,
            kernels,
        } = self;
        let perspective = extents.screen.perspective;
        if extents.steepest > STEEP || perspective && sheets.eye.is_some() {
            return None;
        }
        let shape = |own, depth| SheetShape::new(own, &extents.screen, raster, depth);
        let near = shape(&kernels.shape, ends[0]);
        let far = shape(&self.narrowest(), ends[1]);
        let reach = room_of(
            &near,
            self.footprint_cut(raster) as f32,
            &extents.room_of_long_voxels(),
        );
        if extents.are_long() && !fit_blocks(reach) {
            return None;
        }
        let blocks = blocks_of(reach) as f32;
        let drift = extents.drift(extents.steepest);
        if kernels.round {
            // Footprints that are cut later have larger powers.
            let cut_late = self.footprint_cut(raster) > extents.widths.cut;
            let may_fail = extents.widths.is_exact || extents.are_long() || cut_late;
            let fit = !may_fail || round_powers_fit(&far, blocks, drift);
            return fit.then_some(Evaluation::Round);
        }
        let ellipses = self.ellipses(self.footprint_cut(raster), drift);
        ellipses
            .powers_fit([&near, &far], blocks)
            .then_some(Evaluation::Ellipses)
    }

    fn ellipses(&self, cut: f64, drift: f32) -> Ellipses {
        Ellipses {
            drift,
            shear: self.extents.shear,
            cut: cut as f32,
            along_rays: self.extents.along_rays,
        }
    }

    /// The footprints with the steepest powers.
    fn narrowest(&self) -> FootprintShape {
        let Self { extents, kernels, .. } = self;
        if !extents.along_rays {
            return kernels.shape;
        }
        // Along rays each tile has an ellipse of its own, none of them narrower or wider than this.
        let [least, most] = extents.variances;
        FootprintShape {
            lateral_covariance: [least, 0.0, most],
            ..kernels.shape
        }
    }

    /// The zone with the cheapest powers that are floats for all its footprints.
    fn any_footprints(&self, zone: Zone) -> Zone {
        let Self { extents, kernels, .. } = self;
        if extents.is_too_steep() {
            return zone;
        }
        let before = if extents.along_rays {
            0.5 * zone.planes.spacing
        } else {
            0.0
        };
        let depths = [zone.first_made, zone.planes.count].map(|sheet| zone.planes.plane(sheet) - before);
        let room = extents.room_of_footprints(zone.planes.spacing);
        let narrowest = self.narrowest();
        // All footprints of a voxel have as many blocks as the one on its middle sheet, even where they are
        // narrower.
        let before_last = if extents.along_rays {
            0.0
        } else {
            0.5 * kernels.sheets as f64 * zone.planes.spacing
        };
        let all = |fits: &dyn Fn([&SheetShape; 2], f32, f32) -> bool| {
            let probes = if extents.screen.perspective { PROBES } else { 1 };
            (0..probes).all(|i| {
                let shape = |own, depth| SheetShape::new(own, &extents.screen, &zone.raster, depth);
                let [near, far] = [i, i + 1].map(|end| {
                    let share = f64::from(end) / f64::from(probes);
                    depths[0] + share * share * (depths[1] - depths[0])
                });
                let widest = shape(&kernels.shape, (near - before_last).max(depths[0]));
                let reach = room_of(&widest, zone.cut as f32, &room);
                let blocks = blocks_of(reach) as f32;
                let own = shape(&narrowest, far);
                let is_whole = extents.widths.is_exact || extents.are_long() || extents.are_elongated();
                (!is_whole || fit_blocks(reach))
                    && fits([&widest, &own], blocks, extents.drift_of_footprints(&own, blocks))
            })
        };
        let footprints = if kernels.round
            && all(&|[_, own], blocks, drift| round_powers_fit(own, blocks, drift))
        {
            Evaluation::Round
        } else if all(&|shapes, blocks, drift| self.ellipses(zone.cut, drift).powers_fit(shapes, blocks)) {
            Evaluation::Ellipses
        } else {
            Evaluation::Direct
        };
        Zone { footprints, ..zone }
    }
}

/// Number of parts of a zone for which powers are tested, with the blocks of the part's nearest footprints and the
/// shape of its farthest ones.
const PROBES: i32 = 24;

impl Default for Zone {
    /// A zone without planes.
    fn default() -> Self {
        Self::of_pixels(Planes {
            first: 0,
            spacing: 1.0,
            count: 0,
        })
    }
}

impl Zone {
    /// All planes of a frame, on a raster of pixels.
    pub fn of_pixels(planes: Planes) -> Self {
        Self {
            planes,
            first_made: 0,
            shown: 0..planes.count,
            last_sheet: planes.count + 1,
            raster: Raster::PIXELS,
            footprints: Evaluation::Direct,
            cut: 0.0,
            eye: None,
            depth_reach: 0.0,
        }
    }

    /// Whether the first interval begins at the eye.
    pub fn begins_at_eye(&self) -> bool {
        self.shown.start < self.first_made && !self.shown.is_empty()
    }

    /// The last plane of the tile loop, counted from depth 0.
    pub fn last_plane(&self) -> i64 {
        self.planes.first + self.last_sheet as i64
    }

    /// The plane at which the first interval is shown, or the first slab is splatted.
    pub fn first_shown(&self) -> i64 {
        self.planes.first
            + if self.shown.is_empty() {
                0
            } else {
                self.shown.start as i64 + 2
            }
    }

    /// Least depth that a footprint has.
    pub(super) fn nearest(&self, along_rays: bool) -> f64 {
        let first = self.planes.plane(self.first_made);
        if along_rays {
            (first - self.planes.spacing).max(self.eye.unwrap_or(f64::NEG_INFINITY))
        } else {
            first
        }
    }
}
