//! The tile loop: slab by slab, front to back. What voxels splat and what becomes of finished sheets is the [`Mode`]'s.

use std::time::Duration;

use fearless_simd::prelude::*;
use glam::DAffine3;
use splatvol_core::bin::{ProjectedBrick, TileGrid, TileLists, TileRect};
use splatvol_core::sheets::Planes;
use splatvol_core::visibility::BRICK_VOXELS;

use super::activate::{OpenBrick, OpenVoxels, Window, activate};
use super::classified::Classified;
use super::mask::OpenMask;
use super::mode::{Bricks, Mode};
use super::operated::Faces;
use super::order::DepthOrder;
use super::plane::{HALO, Plane};
use super::ring::{BLOCK_EDGE, LANES, SheetRing};
use super::shade::{Canvas, ShadeBatch};
use super::sheet::{GroupShape, SheetShape};
use super::splat::{
    CAPACITY, MAX_BLOCKS, Powers, Records, SIZES, SplatConstants, Stencil, origin_block, splat_sized,
};
use super::upsample::{RASTER_HALO, Upsampler};
use crate::clock::Instant;

/// Sheets whose bricks are fetched from memory together.
const AHEAD: usize = 3;

/// What the tiles of a frame share.
#[derive(Debug)]
pub(crate) struct SheetFrame<'a> {
    pub bricks: &'a dyn Bricks,
    pub order: &'a DepthOrder,
    pub camera_from_lattice: DAffine3,
    pub stack: Planes,
    pub sheets: &'a [SheetShape],
    pub tiles: TileGrid,
    pub lists: &'a TileLists,
    pub constants: SplatConstants,
    pub rays: Rays,
    pub termination: f32,
    /// Pixels from one raster point to the next.
    pub step: usize,
    /// How far a voxel reaches in depth, world length.
    pub depth_reach: f32,
    /// Standard deviations at which footprints are cut.
    pub cut: f32,
    /// How far apart a voxel's footprints on neighbouring sheets are at the picture's corner, raster points on a sheet of
    /// one raster point per world length.
    pub spread: f32,
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
    /// How far footprints reach on a sheet, raster points.
    pub(crate) fn half_extent(&self, shape: &SheetShape) -> [f32; 2] {
        shape
            .half_extent(self.cut)
            .map(|half| half + self.spread * shape.scale)
    }
}

/// Blocks along the edge of footprints that reach so far, raster points. What lies in the outermost twentieth of the
/// reach, less than a hundredth of the peak, may be left out where a footprint lies unfavourably.
pub(crate) fn blocks_of([x, y]: [f32; 2]) -> usize {
    let points = (1.88 * x.max(y)).floor() as usize + 1;
    let blocks = (points + 1).div_ceil(2);
    SIZES
        .into_iter()
        .find(|&size| size >= blocks)
        .unwrap_or(MAX_BLOCKS)
}

/// How far from a footprint's centre pixels change that it touches with any of its blocks, or whose spline or gradient
/// it touches, for footprints that reach so far, raster points.
pub(crate) fn pixel_reach(half_extent: [f32; 2], step: usize) -> f32 {
    // Blocks begin at even points: up to a point and a half off the middle. A quarter is for rounding.
    let blocks = blocks_of(half_extent) as f32 + 0.75;
    let spline = if step > 1 { 2.0 } else { 0.0 };
    (blocks + spline) * step as f32 + 1.0
}

/// Raster points around a tile that its pixels need.
fn halo(step: usize) -> usize {
    if step == 1 { HALO } else { RASTER_HALO }
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
    open: Vec<OpenBrick>,
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

/// Where a tile lies.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    pub rect: TileRect,
    /// Pixels.
    pub size: [usize; 2],
    /// Raster points of a sheet, those around the tile included.
    pub raster: [usize; 2],
    /// Raster points around the tile that its pixels need.
    halo: usize,
    /// First raster point of the tile.
    first: [i32; 2],
}

impl Place {
    fn new(frame: &SheetFrame<'_>, tile: usize) -> Self {
        let rect = frame.tiles.rect(tile);
        let size = [rect.x1 - rect.x0, rect.y1 - rect.y0];
        let halo = halo(frame.step);
        Self {
            rect,
            size,
            raster: size.map(|n| n.div_ceil(frame.step) + 2 * halo),
            halo,
            first: [rect.x0, rect.y0].map(|first| (first / frame.step) as i32),
        }
    }

    /// Blocks of the ring that this rectangle of the picture covers: first and last, x and y.
    fn blocks(&self, [x0, y0, x1, y1]: [f32; 4], step: usize) -> [u8; 4] {
        let block = |pixel: f32, first: usize| {
            let points = (pixel - first as f32) / step as f32 + self.halo as f32;
            (points / BLOCK_EDGE as f32 + MAX_BLOCKS as f32).clamp(0.0, 127.0) as u8
        };
        let (x, y) = (self.rect.x0, self.rect.y0);
        [block(x0, x), block(y0, y), block(x1, x), block(y1, y)]
    }
}

impl SheetScratch {
    fn reset(&mut self, frame: &SheetFrame<'_>, place: &Place, ring_groups: usize, channels: usize) {
        let height = place.raster[1].next_multiple_of(BLOCK_EDGE) + 2 * BLOCK_EDGE * MAX_BLOCKS;
        self.ring.reset(height, ring_groups);
        for planes in &mut self.planes {
            for plane in &mut planes[..channels] {
                plane.reset(place.size.map(|n| n + 2 * HALO));
            }
        }
        if frame.step > 1 {
            self.raster.reset(place.raster);
        }
        self.free.extend(self.open.drain(..).map(|brick| brick.voxels));
        self.mask.reset(place.size, frame.step);
        self.faces.clear();
        self.stencils.resize_with(frame.groups, Stencil::default);
        self.groups.resize(frame.groups, GroupShape::default());
    }

    /// Opens a brick: its voxels in depth order.
    #[inline(always)]
    fn open<S: Simd, M: Mode<N>, const N: usize>(
        &mut self,
        simd: S,
        (frame, mode): (&SheetFrame<'_>, &M),
        brick: &ProjectedBrick,
        blocks: [u8; 4],
    ) {
        let index = brick.active.brick as usize;
        let voxels = self.free.pop().unwrap_or_else(|| {
            self.voxels.push(OpenVoxels::default());
            self.voxels.len() as u32 - 1
        });
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

/// Renders one tile into its canvas.
#[inline(always)]
pub(crate) fn render<S: Simd, M: Mode<N>, const N: usize>(
    simd: S,
    (frame, mode): (&SheetFrame<'_>, &M),
    tile: usize,
    canvas: &mut Canvas,
    scratch: &mut SheetScratch,
) -> SheetWork {
    let place = Place::new(frame, tile);
    scratch.reset(frame, &place, mode.ring_groups(frame), mode.planes());
    canvas.reset(place.size);
    let mut work = SheetWork::default();
    let mut bricks = frame.lists.of(tile).peekable();
    let mut ahead = frame.lists.of(tile).peekable();
    let mut sheet = 0usize;
    // Sheets since the last voxel: when the ring and the planes are empty, sheets are skipped.
    let mut idle = usize::MAX;
    while sheet <= frame.stack.count + 1 && !scratch.mask.none_left() {
        if scratch.open.is_empty() && idle > frame.groups * LANES + scratch.planes.len() {
            let Some(next) = bricks.peek() else { break };
            sheet = sheet.max(next.front_sheet as usize);
        }
        let start = Instant::now();
        let window = window(
            frame,
            &place,
            (&mode.shape(frame, &place, sheet), mode.depths(frame, sheet)),
        );
        scratch.mask.refresh(window.blocks);
        if ahead
            .peek()
            .is_some_and(|brick| brick.front_sheet as usize <= sheet + 1)
        {
            while let Some(brick) = ahead.next_if(|brick| brick.front_sheet as usize <= sheet + AHEAD) {
                mode.touch(brick.active.brick as usize);
            }
        }
        while let Some(brick) = bricks.next_if(|brick| brick.front_sheet as usize <= sheet) {
            let blocks = place.blocks(brick.rect, frame.step);
            if scratch.mask.any(blocks) {
                simd.vectorize(
                    #[inline(always)]
                    || scratch.open(simd, (frame, mode), brick, blocks),
                );
            }
        }
        let splat_before = work.splat;
        let voxels = work.voxels;
        enter(simd, (frame, mode), (&place, &window, sheet), scratch, &mut work);
        let entered = Instant::now();
        idle = if work.voxels > voxels {
            0
        } else {
            idle.saturating_add(1)
        };
        scratch.planes.rotate_left(1);
        mode.take(simd, frame, &place, sheet, scratch);
        let taken = Instant::now();
        if sheet >= 2 {
            mode.shade(simd, frame, sheet - 2, &place, (canvas, scratch));
        }
        work.activate += (entered - start).saturating_sub(work.splat - splat_before);
        work.take += taken - entered;
        work.shade += taken.elapsed();
        sheet += 1;
    }
    let start = Instant::now();
    mode.finish(simd, frame, &place, (canvas, scratch));
    work.shade += start.elapsed();
    work
}

/// Which voxels enter a sheet.
fn window(frame: &SheetFrame<'_>, place: &Place, (shape, depths): (&SheetShape, [f32; 2])) -> Window {
    let needed = place.halo as f32;
    let first = place.first.map(|first| first as f32);
    let ring = (BLOCK_EDGE * MAX_BLOCKS + place.halo) as f32;
    let points = place.size.map(|n| n.div_ceil(frame.step) as f32);
    let blocks = blocks_of(frame.half_extent(shape));
    Window {
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

/// Splats the voxels that enter a sheet.
#[inline(always)]
fn enter<S: Simd, M: Mode<N>, const N: usize>(
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
            stencil.prepare(simd, shape, size, frame.ellipses);
        }
    }
    let SheetScratch {
        ring,
        records,
        powers,
        stencils,
        groups,
        classified,
        ..
    } = scratch;
    work.voxels += records.len as u64;
    let area = records.take_area(size);
    for touched in &mut ring.touched {
        *touched = touched.join(area);
    }
    let records_of = (&*records, M::payload(classified));
    for group in 0..frame.groups {
        let shapes = (&frame.constants, &groups[group], &stencils[group]);
        let rings = &mut ring.groups::<N>(group, frame.groups);
        let size = (size, frame.ellipses);
        splat_sized(simd, size, shapes, records_of, powers, rings);
    }
    records.len = 0;
    work.splat += start.elapsed();
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
        upsampler.run(simd, raster, plane, (place.size, step));
    }
}
