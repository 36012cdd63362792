//! What a picture's tiles share, a tile's memory, and how the voxels of a grid come into its ring. The loop over sheets is [`super::layer`]'s.

use std::time::Duration;

use fearless_simd::prelude::*;
use glam::DAffine3;
use splatvol_core::bin::{ProjectedBrick, TileGrid, TileLists};
use splatvol_core::sheets::Planes;
use splatvol_core::visibility::BRICK_VOXELS;

use super::activate::{OpenBrick, OpenVoxels, Window, activate};
use super::classified::Classified;
use super::cloud::open::Waiting;
use super::direct::DirectGroup;
use super::eye::Eye;
use super::frame::ZonePlan;
use super::holes::Holes;
use super::mask::OpenMask;
use super::mode::{Bricks, Mode};
use super::operated::Faces;
use super::order::DepthOrder;
use super::place::{Place, blocks_of, room_of};
use super::plane::{HALO, Plane};
use super::ring::{Area, BLOCK_EDGE, LANES, Row, SheetRing};
use super::shade::ShadeBatch;
use super::sheet::{GroupShape, SheetShape};
use super::splat::{
    CAPACITY, MAX_BLOCKS, Payload, Powers, Records, SIZES, SplatConstants, Stencil, origin_block, splat_sized,
};
use super::upsample::Upsampler;
use super::zones::{Footprints, Zone};
use crate::clock::Instant;

/// What the tiles of a picture share, zone by zone.
#[derive(Debug)]
pub(crate) struct ZonedFrame<'a> {
    pub bricks: &'a dyn Bricks,
    pub order: &'a DepthOrder,
    pub tiles: TileGrid,
    /// Front to back.
    pub zones: &'a [Zone],
    pub plans: &'a [ZonePlan],
    /// Tiles, those with most bricks first.
    pub longest_first: &'a [u32],
    pub camera_from_lattice: DAffine3,
    pub rays: Rays,
    pub termination: f32,
    pub groups: usize,
    /// How far a voxel reaches in depth, world length.
    pub reach: f32,
    /// Room for footprints of neighbouring sheets: a world length, and a factor.
    pub room: [f32; 2],
}

impl<'a> ZonedFrame<'a> {
    /// What the tiles of a zone share.
    pub(crate) fn zone(&self, index: usize) -> Option<SheetFrame<'a>> {
        let zone = self.zones.get(index)?;
        let plan = self.plans.get(index)?;
        Some(SheetFrame {
            bricks: self.bricks,
            order: self.order,
            camera_from_lattice: self.camera_from_lattice,
            stack: zone.planes,
            zone,
            sheets: &plan.sheets,
            lists: &plan.lists,
            eye: &plan.eye,
            constants: plan.constants,
            rays: self.rays,
            termination: self.termination,
            step: zone.raster.step,
            depth_reach: self.reach,
            cut: zone.cut as f32,
            room: self.room,
            ellipses: zone.footprints != Footprints::Round,
            groups: self.groups,
        })
    }

    /// Sheets from front to back.
    pub(crate) fn sheets(&self) -> usize {
        self.zones.iter().map(|zone| zone.shown.len()).sum()
    }
}

/// What the tiles of a zone share.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SheetFrame<'a> {
    pub bricks: &'a dyn Bricks,
    pub order: &'a DepthOrder,
    pub camera_from_lattice: DAffine3,
    pub stack: Planes,
    pub zone: &'a Zone,
    pub sheets: &'a [SheetShape],
    pub lists: &'a TileLists,
    /// What the first interval needs of the eye, where it begins there.
    pub eye: &'a Eye,
    pub constants: SplatConstants,
    pub rays: Rays,
    pub termination: f32,
    /// Pixels from one raster point to the next.
    pub step: usize,
    /// How far a voxel reaches in depth, world length.
    pub depth_reach: f32,
    /// Standard deviations at which footprints are cut.
    pub cut: f32,
    /// Room for footprints of neighbouring sheets: a world length, and a factor.
    pub room: [f32; 2],
    /// Powers count from the block in the middle.
    pub ellipses: bool,
    pub groups: usize,
}

/// Where pixels look.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rays {
    /// Image coordinates of the principal point.
    pub principal: [f32; 2],
    /// Ray of a pixel at image x, y: `(x + 1/2 - principal) * per_pixel` per depth, 0 where parallel.
    pub per_pixel: f32,
    /// Width of a pixel, world length, where rays are parallel.
    pub plane_per_pixel: f32,
}

impl SheetFrame<'_> {
    /// Image coordinates of the principal point, from the middle of the picture's first pixel.
    pub(crate) fn principal(&self) -> [f32; 2] {
        self.rays.principal.map(|at| at - 0.5)
    }

    /// How far footprints reach on a sheet, raster points.
    pub(crate) fn half_extent(&self, shape: &SheetShape) -> [f32; 2] {
        room_of(shape, self.cut, self.room)
    }
}

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
    /// Of the last four sheets, by channel.
    pub planes: [[Plane; MAX_CHANNELS]; 4],
    /// What samples that are missing would add to them.
    pub holes: Holes,
    pub open: Vec<OpenBrick>,
    voxels: Vec<OpenVoxels>,
    free: Vec<u32>,
    /// A brick's values, x fastest and in depth order.
    brick: [BrickValues; 2],
    pub mask: OpenMask,
    pub batch: ShadeBatch,
    /// What pixels see of cuts.
    pub faces: Faces,
    /// What the voxels of open bricks splat, where it is more than a number.
    pub classified: Classified,
    /// Splats of a cloud that wait for their next plane.
    pub waiting: Waiting,
    /// Gradient of what is splatted, camera space per world length, while the nearer of two planes lies at the eye.
    pub at_eye: Option<[f32; 3]>,
}

/// Work done by a tile.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SheetWork {
    pub voxels: u64,
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

    /// Gets ready for a tile of so many pixels.
    pub(crate) fn reset(&mut self, size: [usize; 2]) {
        self.mask.reset(size);
        self.faces.clear();
    }

    /// Gets ready for a zone of a tile.
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

    /// Gets memory of missing samples ready for a zone of a tile.
    pub(crate) fn begin_holes(&mut self, frame: &SheetFrame<'_>, place: &Place, channels: usize) {
        let ring = (ring_height(place), frame.groups * channels);
        let size = place.size.map(|n| n + 2 * HALO);
        self.holes.begin_zone(ring, size, channels);
    }

    /// Memory for a brick's voxels that is free.
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
        let voxels = self.take_slot();
        let [values, sorted] = &mut self.brick;
        mode.open(simd, (index, voxels), &mut values.0, &mut self.classified);
        self.voxels[voxels as usize].fill(simd, frame.order, &values.0, &mut sorted.0);
        let first = glam::DVec3::from_array(frame.bricks.first(index).map(f64::from));
        let corner = frame.camera_from_lattice.transform_point3(first);
        self.open.push(OpenBrick {
            voxels,
            next: 0,
            next_depth: f32::NEG_INFINITY,
            corner: corner.as_vec3().to_array(),
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
    let anywhere = frame.zone.footprints == Footprints::Direct;
    let blocks = match anywhere {
        true => SIZES[0],
        false => blocks_of(frame.half_extent(shape)),
    };
    Window {
        anywhere,
        blocks,
        origin: (BLOCK_EDGE * origin_block(blocks, frame.ellipses)) as f32,
        depths,
        depth: shape.depth,
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
        activate(
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

/// Splats the records.
#[inline(always)]
fn flush<S: Simd, M: Mode<N>, const N: usize>(
    simd: S,
    (frame, mode): (&SheetFrame<'_>, &M),
    (place, size, sheet): (&Place, usize, usize),
    prepared: &mut bool,
    scratch: &mut SheetScratch,
    work: &mut SheetWork,
) {
    if scratch.records.len == 0 {
        return;
    }
    let start = Instant::now();
    mode.prepare(simd, (frame, sheet, !*prepared), scratch);
    if !std::mem::replace(prepared, true) {
        for (group, (shape, stencil)) in scratch.groups.iter_mut().zip(&mut scratch.stencils).enumerate() {
            *shape = mode.group(frame, place, sheet, group);
            if frame.zone.footprints != Footprints::Direct {
                stencil.prepare(simd, shape, size, frame.ellipses);
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
        let direct = frame.zone.footprints == Footprints::Direct;
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
                let shapes = (&frame.constants, shape, &self.stencils[group]);
                splat_sized(simd, (size, frame.ellipses), shapes, records_of, powers, rings);
            }
        }
        for touched in &mut ring.touched {
            *touched = touched.join(area);
        }
        records.len = 0;
    }
}

/// Takes a finished sheet out of the ring, as the last planes, one per number that is splatted.
#[inline(always)]
pub(crate) fn take_planes<S: Simd, const N: usize>(
    simd: S,
    frame: &SheetFrame<'_>,
    (place, sheet): (&Place, usize),
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
            frame.step,
            place,
            slot,
            (ring, &mut last[channel]),
            (raster, upsampler),
        );
    }
}

/// Takes a finished sheet out of the ring, to pixels.
#[inline(always)]
pub(crate) fn take<S: Simd>(
    simd: S,
    step: usize,
    place: &Place,
    slot: usize,
    (ring, plane): (&mut SheetRing, &mut Plane),
    (raster, upsampler): (&mut Plane, &mut Upsampler),
) {
    if step == 1 {
        plane.take(simd, ring, slot, MAX_BLOCKS, place.raster);
    } else {
        raster.take(simd, ring, slot, MAX_BLOCKS, place.raster);
        upsampler.run(simd, raster, plane, (place, step));
    }
}
