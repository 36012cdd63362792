//! The tile loop of post-classified volumes: slab by slab, front to back.

use std::time::{Duration, Instant};

use fearless_simd::{f32x16, mask32x16, prelude::*, u32x16};
use glam::DAffine3;
use splatvol_core::bin::{ProjectedBrick, TileGrid, TileLists, TileRect};
use splatvol_core::sheets::SheetStack;
use splatvol_core::visibility::{BRICK_VOXELS, BrickStore};

use super::mask::OpenMask;
use super::order::DepthOrder;
use super::plane::{HALO, Plane, Span};
use super::ring::{Area, BLOCK_EDGE, LANES, SheetRing};
use super::shade::{Canvas, Interval, PlaneShader, ShadeBatch, ShadeTarget};
use super::sheet::{GroupShape, SheetShape};
use super::splat::{CAPACITY, MAX_BLOCKS, Powers, Records, SplatConstants, Stencil, middle_block, splat};

/// What the tiles of a frame share.
#[derive(Debug)]
pub(crate) struct DataFrame<'a> {
    pub store: &'a BrickStore,
    pub order: DepthOrder,
    pub camera_from_lattice: DAffine3,
    pub stack: SheetStack,
    pub sheets: Vec<SheetShape>,
    pub tiles: TileGrid,
    pub lists: TileLists,
    pub constants: SplatConstants,
    pub shader: PlaneShader<'a>,
    /// How far a voxel reaches in depth, world length.
    pub depth_reach: f32,
    /// How far a footprint reaches, raster points.
    pub half_extent: [f32; 2],
    /// Standard deviations at which footprints are cut.
    pub cut: f32,
    /// Blocks along the edge of the largest footprint.
    pub size: usize,
    pub ellipses: bool,
    pub groups: usize,
    /// Principal point, raster points.
    pub principal: [f32; 2],
}

impl DataFrame<'_> {
    /// Blocks along the edge of footprints that reach so far, raster points. What lies in the outermost twentieth of the
    /// reach, less than a hundredth of the peak, may be left out where a footprint lies unfavourably.
    pub(crate) fn blocks_of(&self, [x, y]: [f32; 2]) -> usize {
        let points = (1.88 * x.max(y)).floor() as usize + 1;
        (points + 1).div_ceil(2).clamp(2, MAX_BLOCKS)
    }
}

/// A brick some of whose voxels are still to come.
#[derive(Debug, Clone, Copy)]
struct OpenBrick {
    /// Which of the scratch memory's value lists is its own.
    values: u32,
    /// Place of the next voxel in depth order.
    next: u32,
    /// First voxel in camera space.
    corner: [f32; 3],
    /// Pixels of the tile that it can touch: x0, y0, x1, y1.
    reach: [f32; 4],
}

/// A brick's values in depth order.
type SortedValues = [f32; BRICK_VOXELS + 16];

/// A thread's memory.
#[derive(Debug, Default)]
pub(crate) struct DataScratch {
    ring: SheetRing,
    records: Records,
    powers: Powers,
    stencils: Vec<Stencil>,
    groups: Vec<GroupShape>,
    planes: [Plane; 4],
    pub canvas: Canvas,
    open: Vec<OpenBrick>,
    values: Vec<SortedValues>,
    free: Vec<u32>,
    mask: OpenMask,
    batch: ShadeBatch,
}

/// Work done by a tile.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct DataWork {
    pub tested: u64,
    pub voxels: u64,
    pub activate: Duration,
    pub splat: Duration,
    pub take: Duration,
    pub shade: Duration,
}

impl DataScratch {
    /// Opens a brick: its values in depth order.
    fn open(&mut self, frame: &DataFrame<'_>, brick: &ProjectedBrick, rect: &TileRect) {
        let index = brick.active.brick as usize;
        let values = self.free.pop().unwrap_or_else(|| {
            self.values.push([f32::NAN; BRICK_VOXELS + 16]);
            self.values.len() as u32 - 1
        });
        let stored = &frame.store.values[index];
        for (value, &voxel) in self.values[values as usize]
            .iter_mut()
            .zip(&frame.order.voxel[..BRICK_VOXELS])
        {
            *value = stored[usize::from(voxel) % BRICK_VOXELS];
        }
        let first = glam::DVec3::from_array(frame.store.first[index].map(f64::from));
        let [x0, y0, x1, y1] = brick.rect;
        let (x, y, margin) = (rect.x0 as f32, rect.y0 as f32, (HALO + 1) as f32);
        self.open.push(OpenBrick {
            values,
            next: 0,
            corner: frame
                .camera_from_lattice
                .transform_point3(first)
                .as_vec3()
                .to_array(),
            reach: [x0 - x - margin, y0 - y - margin, x1 - x + margin, y1 - y + margin],
        });
    }
}

/// Renders one tile into the scratch memory's canvas.
#[inline(always)]
pub(crate) fn render<S: Simd>(
    simd: S,
    frame: &DataFrame<'_>,
    tile: usize,
    scratch: &mut DataScratch,
) -> DataWork {
    let rect = frame.tiles.rect(tile);
    let size = [rect.x1 - rect.x0, rect.y1 - rect.y0];
    let plane_size = size.map(|n| n + 2 * HALO);
    let apron = frame.size;
    scratch.ring.reset(
        plane_size[1].next_multiple_of(2) + 2 * BLOCK_EDGE * apron,
        frame.groups,
    );
    scratch
        .planes
        .iter_mut()
        .for_each(|plane| plane.reset(plane_size));
    scratch.canvas.reset(size);
    scratch
        .free
        .extend(scratch.open.drain(..).map(|brick| brick.values));
    let [rx, ry] = frame.half_extent;
    scratch.mask.reset(size, rx.max(ry) + 2.0);
    scratch.stencils.resize_with(frame.groups, Stencil::default);
    scratch.groups.resize(frame.groups, GroupShape::default());
    let mut work = DataWork::default();
    let offset = (BLOCK_EDGE * apron + HALO) as f32;
    let constants = SplatConstants {
        principal: [
            frame.principal[0] - rect.x0 as f32 + offset,
            frame.principal[1] - rect.y0 as f32 + offset,
        ],
        ..frame.constants
    };
    let mut bricks = frame.lists.of(tile).peekable();
    let mut sheet = 0usize;
    let mut drained = 0;
    while sheet <= frame.stack.count + 1 && !scratch.mask.none_left() {
        if scratch.open.is_empty() && drained >= frame.groups * LANES + 3 {
            let Some(next) = bricks.peek() else { break };
            if next.front_sheet as usize > sheet {
                sheet = next.front_sheet as usize;
            }
            drained = 0;
        }
        let start = Instant::now();
        while let Some(brick) = bricks.next_if(|brick| brick.front_sheet as usize <= sheet) {
            let [x0, y0, x1, y1] = brick.rect;
            let (x, y, margin) = (rect.x0 as f32, rect.y0 as f32, (HALO + 1) as f32);
            if scratch
                .mask
                .any([x0 - x - margin, y0 - y - margin, x1 - x + margin, y1 - y + margin])
            {
                scratch.open(frame, brick, &rect);
            }
        }
        // Voxels whose first sheet this is, or an earlier one.
        let limit = frame.stack.plane(sheet) as f32 + frame.depth_reach;
        let middle = sheet + frame.groups * LANES / 2;
        let shape = &frame.sheets[middle.min(frame.sheets.len() - 1)];
        let half = shape.half_extent(frame.cut);
        let blocks = frame.blocks_of(half);
        let window = Window {
            limit,
            blocks,
            depth: shape.depth,
            scale: shape.scale,
            half,
            low: offset - 1.0,
            high: [offset + size[0] as f32, offset + size[1] as f32],
            tile: offset,
        };
        let first_sheet = sheet as isize;
        for (group, (shape, stencil)) in scratch.groups.iter_mut().zip(&mut scratch.stencils).enumerate() {
            *shape = GroupShape::new(&frame.sheets, first_sheet, group, frame.groups);
            stencil.prepare(simd, shape, blocks, frame.ellipses);
        }
        scratch.records.len = 0;
        let mut kept = 0;
        for i in 0..scratch.open.len() {
            let mut brick = scratch.open[i];
            if scratch.mask.any_finished && !scratch.mask.any(brick.reach) {
                scratch.free.push(brick.values);
                continue;
            }
            activate(simd, frame, &constants, &window, &mut brick, scratch, &mut work);
            if scratch.records.len > CAPACITY - BRICK_VOXELS - 16 {
                let begun = Instant::now();
                flush(simd, (frame, blocks), &constants, scratch, &mut work);
                work.splat += begun.elapsed();
            }
            if (brick.next as usize) < BRICK_VOXELS {
                scratch.open[kept] = brick;
                kept += 1;
            } else {
                scratch.free.push(brick.values);
            }
        }
        scratch.open.truncate(kept);
        let activated = Instant::now();
        if scratch.records.len > 0 {
            drained = 0;
        }
        flush(simd, (frame, blocks), &constants, scratch, &mut work);
        let splatted = Instant::now();
        let slot = sheet % (frame.groups * LANES);
        scratch.planes.rotate_left(1);
        let [.., last] = &mut scratch.planes;
        last.take(simd, &mut scratch.ring, slot, apron, plane_size);
        let taken = Instant::now();
        if sheet >= 2 {
            let any_finished = shade(simd, frame, sheet - 2, &rect, scratch);
            if any_finished {
                scratch
                    .mask
                    .update(simd, &scratch.canvas, size[1], frame.shader.termination);
            }
        }
        work.activate += activated - start;
        work.splat += splatted - activated;
        work.take += taken - splatted;
        work.shade += taken.elapsed();
        drained += 1;
        sheet += 1;
    }
    work
}

#[inline(always)]
fn shade<S: Simd>(
    simd: S,
    frame: &DataFrame<'_>,
    near: usize,
    rect: &TileRect,
    scratch: &mut DataScratch,
) -> bool {
    let planes = &scratch.planes;
    let span = planes[1]
        .filled
        .unwrap_or(Span::EMPTY)
        .join(planes[2].filled.unwrap_or(Span::EMPTY));
    if span.is_empty() || near + 1 >= frame.sheets.len() {
        return false;
    }
    let span = Span {
        x0: span.x0.saturating_sub(HALO),
        y0: span.y0.saturating_sub(HALO),
        x1: span.x1.saturating_sub(HALO).min(rect.x1 - rect.x0),
        y1: span.y1.saturating_sub(HALO).min(rect.y1 - rect.y0),
    };
    let interval = Interval {
        planes: [&planes[0], &planes[1], &planes[2], &planes[3]],
        depth: frame.sheets[near].depth,
        scales: [frame.sheets[near].scale, frame.sheets[near + 1].scale],
    };
    let mut target = ShadeTarget {
        origin: [rect.x0, rect.y0],
        span,
        mask: &scratch.mask,
        canvas: &mut scratch.canvas,
        batch: &mut scratch.batch,
    };
    frame.shader.shade(simd, &interval, &mut target)
}

/// Which voxels enter a sheet and touch the tile.
struct Window {
    /// Blocks along a footprint's edge.
    blocks: usize,
    /// Depth of the last voxel that enters.
    limit: f32,
    /// The middle sheet's depth and scale.
    depth: f32,
    scale: f32,
    half: [f32; 2],
    /// First and last raster point that matters.
    low: f32,
    high: [f32; 2],
    /// Raster coordinate of the tile's first pixel.
    tile: f32,
}

/// Moves a brick's voxels that enter a sheet to the records.
#[inline(always)]
fn activate<S: Simd>(
    simd: S,
    frame: &DataFrame<'_>,
    constants: &SplatConstants,
    window: &Window,
    brick: &mut OpenBrick,
    scratch: &mut DataScratch,
    work: &mut DataWork,
) {
    let DataScratch {
        values,
        records,
        mask,
        ..
    } = scratch;
    let values = &values[brick.values as usize];
    let order = &frame.order;
    let [x0, y0, z0] = brick.corner;
    let limit = f32x16::splat(simd, window.limit - z0);
    let [rx, ry] = window.half;
    let test = mask.any_finished && !mask.all(brick.reach);
    let scale = f32x16::splat(simd, window.scale);
    loop {
        let next = (brick.next as usize).min(BRICK_VOXELS);
        let depth = f32x16::from_slice(simd, &order.depth[next..next + 16]);
        let entering = depth.simd_le(limit);
        let count = entering.to_bitmask().count_ones();
        if count == 0 {
            return;
        }
        brick.next += count;
        work.tested += u64::from(count);
        let value = f32x16::from_slice(simd, &values[next..next + 16]);
        let needed = entering & value.simd_eq(value);
        let last = count < 16 || brick.next as usize >= BRICK_VOXELS;
        if !needed.any_true() {
            if last {
                return;
            }
            continue;
        }
        let x = f32x16::from_slice(simd, &order.x[next..next + 16]) + x0;
        let y = f32x16::from_slice(simd, &order.y[next..next + 16]) + y0;
        let z = depth + z0;
        let dz = window.depth - z;
        let [px, py] = constants.principal;
        let u = dz
            .mul_add(constants.slope[0], x)
            .mul_add(scale, f32x16::splat(simd, px));
        let v = dz
            .mul_add(constants.slope[1], y)
            .mul_add(scale, f32x16::splat(simd, py));
        let mut wanted = needed
            & (u + rx).simd_ge(f32x16::splat(simd, window.low))
            & (u - rx).simd_le(f32x16::splat(simd, window.high[0]))
            & (v + ry).simd_ge(f32x16::splat(simd, window.low))
            & (v - ry).simd_le(f32x16::splat(simd, window.high[1]));
        if test {
            let (column, row) = (
                OpenMask::block(simd, u - window.tile),
                OpenMask::block(simd, v - window.tile),
            );
            let (column, row) = (column.as_slice(), row.as_slice());
            let mut bits = wanted.to_bitmask();
            let mut left = bits;
            while left != 0 {
                let lane = left.trailing_zeros() as usize & 15;
                left &= left - 1;
                bits &= !(mask.out_of_reach(column[lane], row[lane]) << lane);
            }
            wanted = mask32x16::from_bitmask(simd, bits);
        }
        let found = wanted.to_bitmask().count_ones() as usize;
        if found > 0 {
            let column = ((u - rx).ceil() * 0.5).floor();
            let row = ((v - ry).ceil() * 0.5).floor();
            let middle = 2.0 * middle_block(window.blocks) as f32;
            records.join(simd, wanted, column, row);
            let at = records.len.min(CAPACITY);
            let range = at..at + 16;
            x.compress(wanted).store_slice(&mut records.x[range.clone()]);
            y.compress(wanted).store_slice(&mut records.y[range.clone()]);
            z.compress(wanted).store_slice(&mut records.z[range.clone()]);
            value
                .compress(wanted)
                .store_slice(&mut records.value[range.clone()]);
            (px - column * 2.0 - middle)
                .compress(wanted)
                .store_slice(&mut records.origin_x[range.clone()]);
            (py - row * 2.0 - middle)
                .compress(wanted)
                .store_slice(&mut records.origin_y[range.clone()]);
            column
                .to_int::<u32x16<S>>()
                .compress(wanted)
                .store_slice(&mut records.column[range.clone()]);
            row.to_int::<u32x16<S>>()
                .compress(wanted)
                .store_slice(&mut records.row[range]);
            records.len = at + found;
        }
        if last {
            return;
        }
    }
}

/// Splats the records.
#[inline(always)]
fn flush<S: Simd>(
    simd: S,
    (frame, size): (&DataFrame<'_>, usize),
    constants: &SplatConstants,
    scratch: &mut DataScratch,
    work: &mut DataWork,
) {
    let DataScratch {
        ring,
        records,
        powers,
        stencils,
        groups,
        ..
    } = scratch;
    if records.len == 0 {
        return;
    }
    work.voxels += records.len as u64;
    let area = records.take_area(size);
    for touched in &mut ring.touched {
        *touched = touched.join(area);
    }
    for group in 0..frame.groups {
        let shape = (&groups[group], &stencils[group]);
        let target = ring.group(group);
        macro_rules! by_size {
            ($($size:literal)*) => {
                match (size, frame.ellipses) {
                    $(($size, false) => simd.vectorize(#[inline(always)] || splat::<S, $size, false>(simd, constants, shape, records, powers, target)),
                    ($size, true) => simd.vectorize(#[inline(always)] || splat::<S, $size, true>(simd, constants, shape, records, powers, target)),)*
                    _ => unreachable!("footprints of {size} blocks"),
                }
            };
        }
        by_size!(2 3 4 5 6 7 8);
    }
    records.len = 0;
}
