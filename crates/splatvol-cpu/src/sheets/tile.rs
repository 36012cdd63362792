//! Tiles of a picture: shared data, a tile's memory, and entry of a grid's voxels into its ring. The loop over
//! sheets is in [`super::layer`].

use std::time::Duration;

use fearless_simd::prelude::*;
use splatvol_core::bin::ProjectedBrick;
use splatvol_core::clock::Instant;
use splatvol_core::plan::{Evaluation, MAX_BLOCKS, SIZES, SheetShape, blocks_of};
use splatvol_core::visibility::BRICK_VOXELS;

use super::activate::{OpenBrick, OpenVoxels, Window, activate};
use super::classified::ClassifiedVoxels;
use super::cloud::open::Waiting;
use super::direct::DirectGroup;
use super::frame::SheetFrame;
use super::holes::Holes;
use super::mask::OpenMask;
use super::mode::Mode;
use super::needed::Footprints;
use super::operated::Faces;
use super::place::Place;
use super::plane::{HALO, Plane};
use super::records::{CAPACITY, Records};
use super::ring::{Area, BLOCK_EDGE, LANES, Row, SheetRing};
use super::shade_batch::ShadeBatch;
use super::sheet::GroupShape;
use super::splat::{FootprintGroup, Payload, Powers, Stencil, origin_point, splat};
use super::upsample::{Sums, Upsampler};

/// A brick's values.
#[derive(Debug)]
pub(crate) struct BrickValues(pub [f32; BRICK_VOXELS]);

impl Default for BrickValues {
    fn default() -> Self {
        Self([f32::NAN; BRICK_VOXELS])
    }
}

/// Numbers that a voxel splats at most.
pub(crate) const MAX_CHANNELS: usize = 4;

/// A thread's memory.
#[derive(Debug, Default)]
pub(crate) struct SheetScratch {
    pub ring: SheetRing,
    pub records: Records,
    powers: Powers,
    stencils: Vec<Stencil>,
    groups: Vec<GroupShape>,
    pub raster: Plane,
    pub upsampler: Upsampler,
    /// Planes of the last four sheets, by channel.
    pub planes: [[Plane; MAX_CHANNELS]; 4],
    /// Contributions that the missing samples would make to them.
    pub holes: Holes,
    pub open: Vec<OpenBrick>,
    voxels: Vec<OpenVoxels>,
    free: Vec<u32>,
    /// A brick's values, x fastest and in depth order.
    brick: [BrickValues; 2],
    /// Bricks opened in this tile.
    opened: u64,
    pub mask: OpenMask,
    pub batch: ShadeBatch,
    /// Cut faces seen by pixels.
    pub faces: Faces,
    /// Payload of the voxels of open bricks, where it is more than a number.
    pub classified: ClassifiedVoxels,
    /// Queues of a cloud's splats, by their next plane.
    pub waiting: Waiting,
    /// Gradient of the splatted sum, camera space per world length, while the nearer of two planes lies at the eye.
    pub at_eye: Option<[f32; 3]>,
}

/// Work done by a tile.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SheetWork {
    pub bricks: u64,
    pub voxels: u64,
    /// Vectors of sixteen voxels that were looked at, and of sheets and pixels that were added to.
    pub activated_vectors: u64,
    pub splatted_vectors: u64,
    /// Vectors of pixels that were shaded, and pixels of them that hold material.
    pub shaded_vectors: u64,
    pub shaded_pixels: u64,
    pub activate: Duration,
    pub splat: Duration,
    pub take: Duration,
    pub shade: Duration,
}

impl SheetScratch {
    /// Memory held, bytes: its larger parts.
    pub(crate) fn bytes(&self) -> usize {
        let rows = self.ring.rows.capacity() + self.holes.ring.rows.capacity();
        let planes = self.planes.iter().chain(&self.holes.planes).flatten();
        size_of::<Self>()
            + rows * size_of::<Row>()
            + planes
                .map(|plane| plane.values.capacity() * size_of::<f32>())
                .sum::<usize>()
            + self.voxels.capacity() * size_of::<OpenVoxels>()
            + self.waiting.bytes()
    }

    /// Prepares for a tile of so many pixels.
    pub(crate) fn reset(&mut self, size: [usize; 2]) {
        self.mask.reset(size);
        self.faces.clear();
        self.opened = 0;
        self.batch.take_counts();
    }

    /// Adds this tile's counts.
    pub(crate) fn count(&mut self, work: &mut SheetWork) {
        let [vectors, pixels] = self.batch.take_counts();
        work.bricks += self.opened;
        work.shaded_vectors += vectors;
        work.shaded_pixels += pixels;
    }

    /// Prepares for a zone of a tile.
    pub(crate) fn begin_zone(
        &mut self,
        frame: &SheetFrame<'_>,
        place: &Place,
        ring_groups: usize,
        channels: usize,
    ) {
        self.ring.reset(ring_height(place), ring_groups);
        for planes in &mut self.planes {
            for plane in &mut planes[..channels] {
                plane.reset(place.size.map(|n| n + 2 * HALO));
            }
        }
        if frame.step > 1 {
            self.raster.reset(place.raster);
        }
        self.free.extend(self.open.drain(..).map(|brick| brick.voxels));
        self.mask.set_raster(frame.step, place.phase);
        self.at_eye = None;
        self.stencils.resize_with(frame.groups, Stencil::default);
        self.groups.resize(frame.groups, GroupShape::default());
    }

    /// Prepares memory of missing samples for a zone of a tile.
    pub(crate) fn begin_holes(&mut self, frame: &SheetFrame<'_>, place: &Place, channels: usize) {
        let ring = (ring_height(place), frame.groups * channels);
        let size = place.size.map(|n| n + 2 * HALO);
        self.holes.begin_zone(ring, size, channels);
    }

    /// A free slot for a brick's voxels.
    pub(crate) fn take_slot(&mut self) -> u32 {
        self.free.pop().unwrap_or_else(|| {
            self.voxels.push(OpenVoxels::default());
            self.voxels.len() as u32 - 1
        })
    }

    /// Frees it again.
    pub(crate) fn give_slot(&mut self, slot: u32) {
        self.free.push(slot);
    }

    /// Opens a brick of a grid: its voxels in depth order.
    #[inline(always)]
    pub(crate) fn open_lattice<S: Simd, M: Mode<N>, const N: usize>(
        &mut self,
        simd: S,
        (frame, mode): (&SheetFrame<'_>, &M),
        brick: &ProjectedBrick,
        blocks: [u8; 4],
    ) {
        let index = brick.active.brick as usize;
        self.opened += 1;
        let voxels = self.take_slot();
        let [values, sorted] = &mut self.brick;
        mode.open(simd, (index, voxels), &mut values.0, &mut self.classified);
        self.voxels[voxels as usize].fill(simd, frame.order, &values.0, &mut sorted.0);
        self.open.push(OpenBrick {
            voxels,
            next: 0,
            next_depth: f32::NEG_INFINITY,
            corner: frame.corners[index],
            blocks,
        });
    }
}

/// Rows of a tile's ring.
fn ring_height(place: &Place) -> usize {
    place.raster[1].next_multiple_of(BLOCK_EDGE) + 2 * BLOCK_EDGE * MAX_BLOCKS
}

/// Which voxels of a grid enter a sheet.
pub(crate) fn lattice_window(
    frame: &SheetFrame<'_>,
    place: &Place,
    (shape, depths): (&SheetShape, [f32; 2]),
) -> Window {
    let needed = place.halo as f32;
    let first = place.first.map(|first| first as f32);
    let ring = (BLOCK_EDGE * MAX_BLOCKS + place.halo) as f32;
    let points = place.raster.map(|n| (n - 2 * place.halo) as f32);
    let anywhere = frame.zone.footprints == Evaluation::Direct;
    let blocks = match anywhere {
        true => SIZES[0],
        false => blocks_of(frame.half_extent(shape)),
    };
    Window {
        anywhere,
        blocks,
        origin: origin_point(blocks, frame.ellipses),
        depths,
        depth: frame.anchor(shape),
        scale: shape.scale,
        low: first.map(|first| first - needed),
        high: [
            first[0] + points[0] - 1.0 + needed,
            first[1] + points[1] - 1.0 + needed,
        ],
        ring: first.map(|first| first - ring),
    }
}

/// Splats the voxels of a grid that enter a sheet.
#[inline(always)]
pub(crate) fn enter_lattice<S: Simd, M: Mode<N>, const N: usize>(
    simd: S,
    (frame, mode): (&SheetFrame<'_>, &M),
    (place, window, sheet): (&Place, &Window, usize),
    scratch: &mut SheetScratch,
    work: &mut SheetWork,
) {
    let mut prepared = false;
    let mut kept = 0;
    scratch.records.len = 0;
    for i in 0..scratch.open.len() {
        let mut brick = scratch.open[i];
        if brick.next_depth > window.depths[1] {
            scratch.open[kept] = brick;
            kept += 1;
            continue;
        }
        if scratch.mask.any_finished && !scratch.mask.any(brick.blocks) {
            scratch.free.push(brick.voxels);
            continue;
        }
        let SheetScratch {
            voxels,
            mask,
            records,
            ..
        } = scratch;
        let voxels = &voxels[brick.voxels as usize];
        work.activated_vectors += activate(
            simd,
            &frame.constants,
            window,
            (&mut brick, voxels),
            mask,
            records,
        );
        let done = brick.next as usize >= voxels.len();
        brick.next_depth = voxels.depth(brick.next as usize) + brick.corner[2];
        if records.len > CAPACITY - BRICK_VOXELS - 16 {
            flush(
                simd,
                (frame, mode),
                (place, window.blocks, sheet),
                &mut prepared,
                scratch,
                work,
            );
        }
        if done {
            scratch.free.push(brick.voxels);
        } else {
            scratch.open[kept] = brick;
            kept += 1;
        }
    }
    scratch.open.truncate(kept);
    flush(
        simd,
        (frame, mode),
        (place, window.blocks, sheet),
        &mut prepared,
        scratch,
        work,
    );
}

/// Splats the records, if there are any. Compiled once for both of its callers.
fn flush<S: Simd, M: Mode<N>, const N: usize>(
    simd: S,
    of: (&SheetFrame<'_>, &M),
    around: (&Place, usize, usize),
    prepared: &mut bool,
    scratch: &mut SheetScratch,
    work: &mut SheetWork,
) {
    if scratch.records.len > 0 {
        simd.vectorize(
            #[inline(always)]
            || splat_records(simd, of, around, prepared, scratch, work),
        );
    }
}

/// Splats the records.
#[inline(always)]
fn splat_records<S: Simd, M: Mode<N>, const N: usize>(
    simd: S,
    (frame, mode): (&SheetFrame<'_>, &M),
    (place, size, sheet): (&Place, usize, usize),
    prepared: &mut bool,
    scratch: &mut SheetScratch,
    work: &mut SheetWork,
) {
    let start = Instant::now();
    mode.prepare(simd, (frame, sheet, !*prepared), scratch);
    if !std::mem::replace(prepared, true) {
        let middle = mode.shape(frame, place, sheet);
        let footprints = Footprints {
            anchor: frame.anchor(&middle),
            scale: middle.scale,
            slope: frame.constants.slope,
            farthest: frame.farthest(size),
            cut: frame.cut,
            size,
        };
        for (group, (shape, stencil)) in scratch.groups.iter_mut().zip(&mut scratch.stencils).enumerate() {
            *shape = mode.group(frame, place, sheet, group);
            if frame.zone.footprints != Evaluation::Direct {
                stencil.prepare(simd, shape, &footprints, frame.ellipses);
            }
        }
    }
    let SheetScratch {
        ring,
        records,
        holes,
        powers,
        stencils,
        groups,
        classified,
        mask,
        ..
    } = scratch;
    work.voxels += records.len as u64;
    if frame.zone.footprints != Evaluation::Direct {
        let needed = stencils[..frame.groups]
            .iter()
            .map(|stencil| stencil.needed.count());
        work.splatted_vectors += (records.len * N * needed.sum::<usize>()) as u64;
    }
    let any_missing = mode.has_holes() && records.part(&mut holes.records);
    let sheets = OpenSheets {
        frame,
        place,
        size,
        groups,
        stencils,
        mask,
    };
    sheets.splat(simd, (records, M::payload(classified)), powers, ring);
    if any_missing {
        let missing = &mut holes.records;
        sheets.splat(simd, (missing, M::payload(classified)), powers, &mut holes.ring);
    }
    work.splat += start.elapsed();
}

/// The sheets that are open, as records are splatted into them.
struct OpenSheets<'a> {
    frame: &'a SheetFrame<'a>,
    place: &'a Place,
    /// Blocks along a footprint's edge.
    size: usize,
    groups: &'a [GroupShape],
    stencils: &'a [Stencil],
    mask: &'a OpenMask,
}

impl OpenSheets<'_> {
    /// Splats all records, and forgets them.
    #[inline(always)]
    fn splat<S: Simd, P: Payload<N>, const N: usize>(
        &self,
        simd: S,
        (records, payload): (&mut Records, P),
        powers: &mut Powers,
        ring: &mut SheetRing,
    ) {
        let Self {
            frame, place, size, ..
        } = *self;
        let direct = frame.zone.footprints == Evaluation::Direct;
        let around = records.take_area(size);
        let mut area = if direct { Area::EMPTY } else { around };
        let records_of = (&*records, payload);
        for group in 0..frame.groups {
            let shape = &self.groups[group];
            let rings = &mut ring.groups::<N>(group, frame.groups);
            if direct {
                let group = DirectGroup::new((&frame.constants, shape), place, frame.cut);
                let of = (frame.zone.depth_reach, self.mask);
                area = area.join(simd.vectorize(
                    #[inline(always)]
                    || group.splat(simd, records_of, of, rings),
                ));
            } else {
                let footprints = FootprintGroup {
                    constants: &frame.constants,
                    shape,
                    stencil: &self.stencils[group],
                    size,
                    ellipses: frame.ellipses,
                };
                simd.vectorize(
                    #[inline(always)]
                    || splat(simd, footprints, records_of, powers, rings),
                );
            }
        }
        for touched in &mut ring.touched {
            *touched = touched.join(area);
        }
        records.len = 0;
    }
}

/// Takes a finished sheet out of the ring, as the last planes, one per splatted number.
#[inline(always)]
pub(crate) fn take_planes<S: Simd, const N: usize>(
    simd: S,
    frame: &SheetFrame<'_>,
    (place, sheet, sums): (&Place, usize, Sums),
    scratch: &mut SheetScratch,
) {
    let open = frame.groups * LANES;
    let SheetScratch {
        ring,
        raster,
        upsampler,
        planes: [.., last],
        ..
    } = scratch;
    for channel in 0..N {
        let slot = channel * open + sheet % open;
        take(
            simd,
            (frame.step, sums),
            place,
            slot,
            (ring, &mut last[channel]),
            (raster, upsampler),
        );
    }
}

/// Takes a finished sheet out of the ring, to pixels. Compiled once, whatever the mode.
pub(crate) fn take<S: Simd>(
    simd: S,
    (step, sums): (usize, Sums),
    place: &Place,
    slot: usize,
    (ring, plane): (&mut SheetRing, &mut Plane),
    (raster, upsampler): (&mut Plane, &mut Upsampler),
) {
    let taken = if step == 1 { &mut *plane } else { &mut *raster };
    simd.vectorize(
        #[inline(always)]
        || taken.take(simd, ring, slot, MAX_BLOCKS, place.raster),
    );
    if step > 1 {
        simd.vectorize(
            #[inline(always)]
            || upsampler.run(simd, raster, plane, (place, step, sums)),
        );
    }
}
