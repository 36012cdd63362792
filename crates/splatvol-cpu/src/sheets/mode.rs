//! Mode: payload of the voxels, and shading of finished sheets. All modes share one tile loop.
//!
//! | mode | splats | a finished sheet |
//! |---|---|---|
//! | `shaded` | coefficients | with the one before it: classified, lit, composited |
//! | `analytic` | the same, and the kernels' derivatives | the same, by exact slopes and gradients |
//! | `intensity`, `exact_intensity` | coefficients, and derivatives along the rays | with the one before it: the largest or smallest value is kept, or the mean taken |
//! | `compose` | extinction and lit emission of classified voxels | with the one before it: composited |
//! | `integral` | the same, unlit, integrated along the ray | - |
//! | `cloud::emission` | extinction and lit emission of a cloud | as `compose` |
//! | `cloud::field`, `cloud::values` | weights of a mesh's samples, and their values times those | divided, then as `shaded`, or as `intensity` |

use fearless_simd::prelude::*;
use splatvol_core::bin::{ProjectedBrick, TileRect};
use splatvol_core::field::FieldStore;
use splatvol_core::plan::SheetShape;
use splatvol_core::visibility::BRICK_VOXELS;

use super::activate::Window;
use super::canvas::Canvas;
use super::classified::{ClassifiedBricks, ClassifiedVoxels};
use super::frame::{SheetFrame, ZonedFrame};
use super::place::Place;
use super::ring::LANES;
use super::sheet::GroupShape;
use super::splat::Payload;
use super::tile::{SheetScratch, SheetWork, enter_lattice, lattice_window, take_planes};
use super::upsample::Sums;

/// What the voxels of a grid are splatted from.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Bricks<'a> {
    /// Coefficients of values.
    Field(&'a FieldStore),
    /// Samples that are classified when their brick is opened.
    Classified(&'a ClassifiedBricks<'a>),
    /// Nothing: kernels with covariances of their own are splatted.
    None,
}

/// Payload of the voxels, N numbers each, and shading of finished sheets.
pub(crate) trait Mode<const N: usize>: Sync {
    /// Payload that a record's value stands for.
    type Payload<'m>: Payload<N>;

    /// The payload, given the classified voxels of the open bricks.
    fn payload(classified: &ClassifiedVoxels) -> Self::Payload<'_>;

    /// Prepares an empty canvas.
    fn begin(&self, _: &mut Canvas) {}

    /// The bricks of a grid, if it splats one.
    #[inline(always)]
    fn bricks(&self) -> Bricks<'_> {
        Bricks::None
    }

    /// Opens a brick of a grid. Writes its voxels' values, NaN where there is nothing to splat, and their payloads
    /// into the memory of its slot.
    #[inline(always)]
    fn open<S: Simd>(
        &self,
        simd: S,
        (brick, slot): (usize, u32),
        values: &mut [f32; BRICK_VOXELS],
        classified: &mut ClassifiedVoxels,
    ) {
        match self.bricks() {
            Bricks::Field(store) => store.decode(brick, values),
            Bricks::Classified(bricks) => bricks.open(simd, (brick, slot), values, classified),
            Bricks::None => values.fill(f32::NAN),
        }
    }

    /// Opens the brick of a list entry, unless finished pixels hide it.
    #[inline(always)]
    fn open_brick<S: Simd>(
        &self,
        simd: S,
        frame: &SheetFrame<'_>,
        brick: &ProjectedBrick,
        (place, _sheet): (&Place, usize),
        scratch: &mut SheetScratch,
    ) where
        Self: Sized,
    {
        let blocks = place.blocks(brick.rect, frame.step);
        scratch.open_lattice(simd, (frame, self), brick, blocks);
    }

    /// Prepares memory of its own for a zone of a tile.
    fn reset(&self, _: &SheetFrame<'_>, _: &mut SheetScratch) {}

    /// Whether any open brick has voxels left to splat.
    fn waits(&self, scratch: &SheetScratch) -> bool {
        !scratch.open.is_empty()
    }

    /// Splats the voxels that enter a sheet.
    #[inline(always)]
    fn enter<S: Simd>(
        &self,
        simd: S,
        frame: &SheetFrame<'_>,
        (place, window, sheet): (&Place, &Window, usize),
        scratch: &mut SheetScratch,
        work: &mut SheetWork,
    ) where
        Self: Sized,
    {
        enter_lattice(simd, (frame, self), (place, window, sheet), scratch, work);
    }

    /// Which voxels enter a sheet.
    fn window(&self, frame: &SheetFrame<'_>, place: &Place, sheet: usize) -> Window {
        let shape = self.shape(frame, place, sheet);
        lattice_window(frame, place, (&shape, self.depths(frame, sheet)))
    }

    /// Whether samples may be missing; their voxels have infinite values.
    fn has_holes(&self) -> bool {
        matches!(self.bricks(), Bricks::Field(store) if store.any_missing())
    }

    /// Prefetches the data for opening a brick.
    #[inline(always)]
    fn touch(&self, brick: usize) {
        if let Bricks::Field(store) = self.bricks() {
            store.touch(brick);
        }
    }

    /// Groups of sheets in the ring.
    fn ring_groups(&self, frame: &SheetFrame<'_>) -> usize {
        frame.groups * N
    }

    /// Planes of a sheet, or of all.
    fn planes(&self) -> usize {
        N
    }

    /// Common footprint of all voxels that enter a sheet.
    fn shape(&self, frame: &SheetFrame<'_>, _: &Place, sheet: usize) -> SheetShape {
        let middle = sheet + frame.groups * LANES / 2;
        frame.sheets[middle.min(frame.sheets.len() - 1)]
    }

    /// Depths between which voxels enter a sheet.
    fn depths(&self, frame: &SheetFrame<'_>, sheet: usize) -> [f32; 2] {
        let plane = frame.stack.plane(sheet) as f32;
        [plane - frame.depth_reach, plane + frame.depth_reach]
    }

    /// The sheets of a group while the voxels that enter a sheet are splatted.
    fn group(&self, frame: &SheetFrame<'_>, _: &Place, sheet: usize, group: usize) -> GroupShape {
        GroupShape::new(frame.sheets, sheet as isize, group, frame.groups)
    }

    /// Prepares records for splatting; `first` if they are the first that enter the sheet.
    #[inline(always)]
    fn prepare<S: Simd>(
        &self,
        _: S,
        (_frame, _sheet, _first): (&SheetFrame<'_>, usize, bool),
        _: &mut SheetScratch,
    ) {
    }

    /// Takes a finished sheet out of the ring, as the last planes.
    #[inline(always)]
    fn take<S: Simd>(
        &self,
        simd: S,
        frame: &SheetFrame<'_>,
        place: &Place,
        sheet: usize,
        scratch: &mut SheetScratch,
    ) {
        let sums = match self.bricks() {
            Bricks::Field(_) => Sums::Values,
            Bricks::Classified(_) | Bricks::None => Sums::Amounts,
        };
        take_planes::<S, N>(simd, frame, (place, sheet, sums), scratch);
    }

    /// Composites the interval between a sheet and the next, and closes the pixels that it finishes.
    fn shade<S: Simd>(
        &self,
        simd: S,
        frame: &SheetFrame<'_>,
        near: usize,
        place: &Place,
        canvas_and_scratch: (&mut Canvas, &mut SheetScratch),
    );

    /// Composites the rest of a zone from the ring.
    #[inline(always)]
    fn leave<S: Simd>(
        &self,
        _: S,
        _: &SheetFrame<'_>,
        _: &Place,
        (_canvas, _scratch): (&mut Canvas, &mut SheetScratch),
    ) {
    }

    /// Converts the final canvas to pixels.
    #[inline(always)]
    fn finish<S: Simd>(&self, _: S, _: &ZonedFrame<'_>, _: &TileRect, _: &mut Canvas) {}
}
