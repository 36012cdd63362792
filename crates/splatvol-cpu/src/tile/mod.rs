//! The tile loop: sheet by sheet, front to back.

mod color;
mod data;

use std::time::Duration;

use fearless_simd::Simd;
use splatvol_core::bin::TileRect;
use splatvol_core::footprint::Slice;

pub(crate) use color::ColorMode;
pub(crate) use data::DataMode;

use crate::clock::Instant;
use crate::plan::FramePlan;
use crate::stage::activate::{OpenVoxel, activate};
use crate::stage::composite::{OpenBlocks, Pixel};
use crate::stage::resolve::{Resolved, resolve};
use crate::stage::sheet_buffer::SheetBuffer;
use crate::stage::splat::{Payload, Stamp};

/// What voxels splat and what becomes of a sheet: the difference between pre- and post-classification.
pub(crate) trait Mode: Sync {
    /// What a voxel splats.
    type Payload: Copy + Send;
    /// What a slice adds to the sheet's channels.
    type Splat: Payload + Default;
    /// A sheet's plane or slab.
    type Sheet: Copy;

    /// Sheet by index.
    fn sheet(&self, index: usize) -> Self::Sheet;

    /// What voxel `index` at `[x, y, z]` splats; `None` where it is missing or invisible.
    fn payload(&self, index: usize, position: [usize; 3]) -> Option<Self::Payload>;

    /// Whether a sheet cuts a voxel's footprint within the tile, and whether it is the last to do so. Without branches:
    /// neighbouring voxels' answers are too mixed to be predicted.
    fn meets(&self, sheet: &Self::Sheet, voxel: &OpenVoxel<Self::Payload>, rect: &TileRect) -> Fate;

    /// The slice of a voxel that the sheet meets, and what it adds.
    fn slice(&self, sheet: &Self::Sheet, voxel: &OpenVoxel<Self::Payload>) -> Option<(Slice, Self::Splat)>;

    /// Composites what lies between the sheet before, if there is one, and this one (or in this one).
    fn composite(
        &self,
        near: Option<(&Self::Sheet, &SheetBuffer)>,
        far: (&Self::Sheet, &SheetBuffer),
        canvas: &mut Canvas<'_>,
    );
}

/// What a sheet did to a voxel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fate {
    /// The footprint is cut.
    pub met: bool,
    /// No later sheet reaches the voxel.
    pub past: bool,
}

/// A tile's pixels while they are composited.
#[derive(Debug)]
pub(crate) struct Canvas<'a> {
    /// Where the tile lies.
    pub rect: TileRect,
    /// Row by row.
    pub pixels: &'a mut [Pixel],
    /// Pixels that are not finished.
    pub blocks: &'a mut OpenBlocks,
    /// Transmittance that counts as nothing.
    pub termination: f32,
}

impl Canvas<'_> {
    /// Index of the pixel at tile position x, y.
    #[inline(always)]
    pub(crate) fn index(&self, x: usize, y: usize) -> usize {
        y * (self.rect.x1 - self.rect.x0) + x
    }

    /// Closes a pixel that nothing shines through any more.
    #[inline(always)]
    pub(crate) fn close_if_opaque(&mut self, x: usize, y: usize) {
        let index = self.index(x, y);
        if self.pixels[index].transmittance < self.termination {
            self.pixels[index].finished = true;
            self.blocks.finish(x, y);
        }
    }
}

/// Slices that are made ready together.
const BATCH: usize = 8;

/// A thread's scratch memory.
#[derive(Debug)]
pub(crate) struct Scratch<M: Mode> {
    near: SheetBuffer,
    far: SheetBuffer,
    open: Vec<OpenVoxel<M::Payload>>,
    met: Vec<OpenVoxel<M::Payload>>,
    stamps: Vec<Stamp<M::Splat>>,
    pixels: Vec<Pixel>,
    blocks: OpenBlocks,
}

impl<M: Mode> Scratch<M> {
    /// Scratch for tiles of `edge` pixels.
    pub(crate) fn new(edge: usize) -> Self {
        Self {
            near: SheetBuffer::new(edge),
            far: SheetBuffer::new(edge),
            open: Vec::new(),
            met: Vec::new(),
            stamps: vec![Stamp::blank(M::Splat::default()); BATCH],
            pixels: Vec::new(),
            blocks: OpenBlocks::default(),
        }
    }

    fn reset(&mut self, rect: &TileRect) {
        self.near.clear();
        self.far.clear();
        self.open.clear();
        self.pixels.clear();
        self.pixels
            .resize((rect.x1 - rect.x0) * (rect.y1 - rect.y0), Pixel::EMPTY);
        self.blocks.reset(rect);
    }
}

/// Work done by a tile.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct TileWork {
    pub voxels: u64,
    pub slices: u64,
    pub splat: Duration,
    pub shade: Duration,
}

/// Renders one tile: its pixels, row by row.
#[inline(always)]
pub(crate) fn render<S: Simd, M: Mode>(
    simd: S,
    plan: &FramePlan<'_>,
    tile: usize,
    mode: &M,
    scratch: &mut Scratch<M>,
) -> (Vec<Resolved>, TileWork) {
    let rect = plan.tiles.rect(tile);
    scratch.reset(&rect);
    let mut work = TileWork::default();
    let mut bricks = plan.lists.of(tile).peekable();
    let mut index = 0;
    while index <= plan.projector.sheets.count && !scratch.blocks.none_left() && !plan.is_stopped() {
        if scratch.open.is_empty() && scratch.near.touched.is_empty() {
            // Nothing is open: the next brick's first sheet is the next that matters.
            let Some(next) = bricks.peek() else { break };
            index = index.max(next.front_sheet as usize);
        }
        let start = Instant::now();
        let sheet = mode.sheet(index);
        scratch.far.clear();
        work.slices += splat_open(simd, mode, &sheet, scratch, 0, &rect);
        while let Some(brick) = bricks.next_if(|brick| brick.front_sheet as usize <= index) {
            if scratch.blocks.hide(brick, &rect) {
                continue;
            }
            let first = scratch.open.len();
            activate(plan, &rect, brick.active, &mut scratch.open, |i, at| {
                mode.payload(i, at)
            });
            work.voxels += (scratch.open.len() - first) as u64;
            work.slices += splat_open(simd, mode, &sheet, scratch, first, &rect);
        }
        let splatted = Instant::now();
        let mut canvas = Canvas {
            rect,
            pixels: &mut scratch.pixels,
            blocks: &mut scratch.blocks,
            termination: plan.settings.termination as f32,
        };
        let before = index.checked_sub(1).map(|before| mode.sheet(before));
        let near = before.as_ref().map(|before| (before, &scratch.near));
        mode.composite(near, (&sheet, &scratch.far), &mut canvas);
        std::mem::swap(&mut scratch.near, &mut scratch.far);
        work.splat += splatted - start;
        work.shade += splatted.elapsed();
        index += 1;
    }
    let finish = |pixel| {
        resolve(
            pixel,
            plan.settings.compositing,
            plan.table,
            plan.unit_distance as f32,
        )
    };
    (scratch.pixels.iter().map(finish).collect(), work)
}

/// Splats the open voxels from `first` on, and drops those that no later sheet reaches. Returns the slices.
#[inline(always)]
fn splat_open<S: Simd, M: Mode>(
    simd: S,
    mode: &M,
    sheet: &M::Sheet,
    scratch: &mut Scratch<M>,
    first: usize,
    rect: &TileRect,
) -> u64 {
    let Scratch {
        open,
        met,
        far,
        stamps,
        ..
    } = scratch;
    met.clear();
    met.extend_from_slice(&open[first..]);
    let (mut count, mut kept) = (0, first);
    for i in first..open.len() {
        let voxel = open[i];
        let fate = mode.meets(sheet, &voxel, rect);
        met[count] = voxel;
        open[kept] = voxel;
        count += usize::from(fate.met);
        kept += usize::from(!fate.past);
    }
    open.truncate(kept);
    for batch in met[..count].chunks(BATCH) {
        let mut ready = 0;
        for voxel in batch {
            if let Some((slice, splat)) = mode.slice(sheet, voxel) {
                ready += usize::from(stamps[ready].prepare(simd, rect, &slice, splat));
            }
        }
        for stamp in &stamps[..ready] {
            stamp.add(simd, far);
        }
    }
    count as u64
}
