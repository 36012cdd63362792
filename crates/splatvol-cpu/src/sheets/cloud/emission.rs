//! Show: a cloud's extinction and emission on planes, composited like classified voxels.

use fearless_simd::prelude::*;
use splatvol_core::bin::ProjectedBrick;

use super::enter::{enter, window};
use super::open::CloudView;
use crate::sheets::activate::Window;
use crate::sheets::canvas::Canvas;
use crate::sheets::classified::Classified;
use crate::sheets::compose::{Emission, composite_planes};
use crate::sheets::frame::SheetFrame;
use crate::sheets::mode::Mode;
use crate::sheets::place::Place;
use crate::sheets::tile::{SheetScratch, SheetWork};

/// Clouds of classified splats.
#[derive(Debug)]
pub(crate) struct CloudEmission<'a> {
    pub view: CloudView<'a>,
}

impl Mode<4> for CloudEmission<'_> {
    type Payload<'m> = Emission<'m>;

    fn payload(classified: &Classified) -> Emission<'_> {
        Emission(classified)
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
        enter::<S, 4>(simd, frame, (place, sheet, 0), scratch, work);
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
        composite_planes::<S, false>(simd, (frame, near), place, canvas_and_scratch);
    }
}
