//! Show: a cloud's extinction and emission on planes, composited like classified voxels.

use fearless_simd::prelude::*;
use splatvol_core::bin::ProjectedBrick;

use super::open::{CloudView, OpenSplat};
use super::splat::FourPlanes;
use crate::clock::Instant;
use crate::sheets::activate::Window;
use crate::sheets::canvas::Canvas;
use crate::sheets::classified::Classified;
use crate::sheets::compose::{Emission, composite_planes};
use crate::sheets::mode::Mode;
use crate::sheets::place::Place;
use crate::sheets::ring::{Area, LANES};
use crate::sheets::tile::{SheetFrame, SheetScratch, SheetWork};

/// Clouds of classified splats.
#[derive(Debug)]
pub(crate) struct CloudEmission<'a> {
    pub view: CloudView<'a>,
}

impl CloudEmission<'_> {
    /// The first plane that a splat reaches.
    #[inline(always)]
    fn first_plane(frame: &SheetFrame<'_>, splat: &OpenSplat) -> usize {
        let depth = f64::from(splat.centre[2] - splat.reach);
        ((depth - frame.stack.plane(0)) / frame.stack.spacing)
            .ceil()
            .max(0.0) as usize
    }

    /// Whether any footprint of a splat reaches the tile.
    #[inline(always)]
    fn reaches(&self, frame: &SheetFrame<'_>, place: &Place, splat: &OpenSplat) -> bool {
        let [.., depth] = splat.centre;
        let first = f64::from(depth - splat.reach).max(f64::from(frame.sheets[0].depth));
        let last = f64::from(depth + splat.reach).max(first);
        let ends = [first, last].map(|depth| [depth as f32, self.view.screen.scale_at(depth) as f32]);
        place.footing(frame.principal()).blocks_of(splat, ends).is_some()
    }
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
        brick: &ProjectedBrick,
        (place, sheet): (&Place, usize),
        scratch: &mut SheetScratch,
    ) {
        let chunk = &self.view.cloud.chunks[brick.active.brick as usize];
        for index in chunk.first as usize..chunk.end as usize {
            let Some(splat) = self.view.open(index) else {
                continue;
            };
            if self.reaches(frame, place, &splat) {
                // What came before the plane at hand by a rounding comes now.
                let plane = Self::first_plane(frame, &splat).max(sheet);
                scratch.waiting.add(&splat, plane);
            }
        }
    }

    fn reset(&self, frame: &SheetFrame<'_>, scratch: &mut SheetScratch) {
        scratch.waiting.reset(frame.sheets.len());
    }

    fn waits(&self, scratch: &SheetScratch) -> bool {
        scratch.waiting.count > 0
    }

    /// All that matters of the window here is that the mask is up to date.
    fn window(&self, frame: &SheetFrame<'_>, _: &Place, sheet: usize) -> Window {
        Window {
            blocks: 2,
            depth: frame.stack.plane(sheet) as f32,
            ..Window::default()
        }
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
        let SheetScratch {
            waiting, ring, mask, ..
        } = scratch;
        let mut next = waiting.take(sheet);
        if next.is_none() {
            return;
        }
        let start = Instant::now();
        let planes = FourPlanes::new(frame, place, sheet);
        let behind = frame.stack.plane(sheet + LANES) as f32;
        let mut area = Area::EMPTY;
        while let Some(at) = next {
            let (splat, following) = waiting.splat(at);
            next = following;
            if let Some(blocks) = planes.footing.blocks_of(splat, planes.ends)
                && mask.any(blocks.corners())
            {
                let rings = &mut ring.groups::<4>(0, 1);
                simd.vectorize(
                    #[inline(always)]
                    || planes.add(simd, (splat, splat.payload), blocks, rings),
                );
                area = area.join(blocks.area());
                work.voxels += 1;
            }
            if splat.centre[2] + splat.reach > behind {
                waiting.again(at, sheet + LANES);
            } else {
                waiting.drop(at);
            }
        }
        for touched in &mut ring.touched {
            *touched = touched.join(area);
        }
        work.splat += start.elapsed();
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
