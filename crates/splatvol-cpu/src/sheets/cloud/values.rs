//! Show: one value of each ray through a mesh, of the field `v = S / W` on planes ([`super::field`]).
//!
//! As for volumes, the largest or smallest value counts where coverage, here W, is a half or more, and the mean is
//! weighted by it (docs/numerics.md, modes mip, minip and mean).

use fearless_simd::prelude::*;

use super::field::{Weighted, divide, of_field};
use super::mode::CloudShading;
use crate::sheets::canvas::Canvas;
use crate::sheets::classified::ClassifiedVoxels;
use crate::sheets::frame::SheetFrame;
use crate::sheets::intensity::{RayValues, Reduction};
use crate::sheets::place::Place;
use crate::sheets::plane::Plane;
use crate::sheets::tile::{MAX_CHANNELS, SheetScratch};

/// One value per ray through a mesh.
#[derive(Debug)]
pub(crate) struct MeshValues<'a, K>(pub RayValues<'a, K>);

impl<K: Reduction> CloudShading<2> for MeshValues<'_, K> {
    type Payload<'m> = Weighted;

    const HALO: u8 = 0;

    fn payload(_: &ClassifiedVoxels) -> Weighted {
        Weighted
    }

    #[inline(always)]
    fn taken<S: Simd>(&self, simd: S, planes: &mut [Plane; MAX_CHANNELS]) {
        divide(simd, planes);
    }

    #[inline(always)]
    fn shade<S: Simd>(
        &self,
        simd: S,
        frame: &SheetFrame<'_>,
        near: usize,
        place: &Place,
        (canvas, scratch): (&mut Canvas, &mut SheetScratch),
    ) {
        let [weights, values] = of_field(&scratch.planes);
        let Some((mut interval, span)) = self.0.interval(frame, (near, place), (values, None)) else {
            return;
        };
        interval.weights = Some(weights);
        self.0.keep(simd, (&interval, span), place, canvas);
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, canvas: &mut Canvas) {
        self.0.finish(simd, canvas);
    }
}
