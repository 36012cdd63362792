//! Show: a cloud's extinction and emission on planes, composited like classified voxels.

use fearless_simd::prelude::*;

use super::mode::CloudShading;
use crate::sheets::canvas::Canvas;
use crate::sheets::classified::ClassifiedVoxels;
use crate::sheets::compose::{Emission, composite_planes};
use crate::sheets::frame::SheetFrame;
use crate::sheets::place::Place;
use crate::sheets::tile::SheetScratch;

/// Material of classified splats.
#[derive(Debug)]
pub(crate) struct EmittedLight;

impl CloudShading<4> for EmittedLight {
    type Payload<'m> = Emission<'m>;

    const HALO: u8 = 0;

    fn payload(classified: &ClassifiedVoxels) -> Emission<'_> {
        Emission(classified)
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
