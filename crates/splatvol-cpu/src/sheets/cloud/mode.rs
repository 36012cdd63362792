//! Mode: renders clouds in the tile loop; a [`CloudShading`] shades the finished planes.

use fearless_simd::prelude::*;
use splatvol_core::bin::{ProjectedBrick, TileRect};

use super::enter::{enter, window};
use super::open::CloudView;
use crate::sheets::activate::Window;
use crate::sheets::canvas::Canvas;
use crate::sheets::classified::ClassifiedVoxels;
use crate::sheets::frame::{SheetFrame, ZonedFrame};
use crate::sheets::mode::Mode;
use crate::sheets::place::Place;
use crate::sheets::plane::Plane;
use crate::sheets::splat::Payload;
use crate::sheets::tile::{MAX_CHANNELS, SheetScratch, SheetWork, take_planes};
use crate::sheets::upsample::Sums;

/// A cloud and the shading of its planes.
#[derive(Debug)]
pub(crate) struct CloudMode<'a, F> {
    pub view: CloudView<'a>,
    pub shading: F,
}

/// Shading of a cloud's finished planes, N of each sheet.
pub(crate) trait CloudShading<const N: usize>: Sync {
    /// Payload that a splat's value stands for.
    type Payload<'m>: Payload<N>;

    /// Width, in blocks, of the border of pixels that is needed around a tile where gradients are differences of
    /// neighbours.
    const HALO: u8;

    /// The payload, given the classified voxels of the open chunks.
    fn payload(classified: &ClassifiedVoxels) -> Self::Payload<'_>;

    /// Converts a finished sheet's planes to the form in which they are kept.
    #[inline(always)]
    fn taken<S: Simd>(&self, _: S, _: &mut [Plane; MAX_CHANNELS]) {}

    /// As [`Mode::shade`].
    fn shade<S: Simd>(
        &self,
        simd: S,
        frame: &SheetFrame<'_>,
        near: usize,
        place: &Place,
        canvas_and_scratch: (&mut Canvas, &mut SheetScratch),
    );

    /// As [`Mode::finish`].
    #[inline(always)]
    fn finish<S: Simd>(&self, _: S, _: &mut Canvas) {}
}

impl<const N: usize, F: CloudShading<N>> Mode<N> for CloudMode<'_, F> {
    type Payload<'m> = F::Payload<'m>;

    fn payload(classified: &ClassifiedVoxels) -> F::Payload<'_> {
        F::payload(classified)
    }

    #[inline(always)]
    fn open_brick<S: Simd>(
        &self,
        _: S,
        frame: &SheetFrame<'_>,
        chunk: &ProjectedBrick,
        around: (&Place, usize),
        scratch: &mut SheetScratch,
    ) {
        self.view.open_chunk(frame, chunk, around, scratch);
    }

    fn reset(&self, frame: &SheetFrame<'_>, scratch: &mut SheetScratch) {
        scratch.waiting.reset(frame.sheets.len());
    }

    fn waits(&self, scratch: &SheetScratch) -> bool {
        scratch.waiting.count > 0
    }

    fn window(&self, frame: &SheetFrame<'_>, _: &Place, sheet: usize) -> Window {
        window(frame, sheet)
    }

    #[inline(always)]
    fn enter<S: Simd>(
        &self,
        simd: S,
        frame: &SheetFrame<'_>,
        (place, _, sheet): (&Place, &Window, usize),
        scratch: &mut SheetScratch,
        work: &mut SheetWork,
    ) {
        enter::<S, N>(simd, frame, (place, sheet, F::HALO), scratch, work);
    }

    #[inline(always)]
    fn take<S: Simd>(
        &self,
        simd: S,
        frame: &SheetFrame<'_>,
        place: &Place,
        sheet: usize,
        scratch: &mut SheetScratch,
    ) {
        take_planes::<S, N>(simd, frame, (place, sheet, Sums::Amounts), scratch);
        let [.., last] = &mut scratch.planes;
        self.shading.taken(simd, last);
    }

    #[inline(always)]
    fn shade<S: Simd>(
        &self,
        simd: S,
        frame: &SheetFrame<'_>,
        near: usize,
        place: &Place,
        canvas_and_scratch: (&mut Canvas, &mut SheetScratch),
    ) {
        self.shading.shade(simd, frame, near, place, canvas_and_scratch);
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: &ZonedFrame<'_>, _: &TileRect, canvas: &mut Canvas) {
        self.shading.finish(simd, canvas);
    }
}
