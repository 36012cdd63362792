//! Enter: chunks are opened by the first plane that they reach, and splats are added to four planes at a time, with
//! any payload.

use fearless_simd::prelude::*;
use splatvol_core::bin::ProjectedBrick;
use splatvol_core::clock::Instant;

use super::open::{CloudView, OpenSplat};
use super::splat::FourPlanes;
use crate::sheets::activate::Window;
use crate::sheets::frame::SheetFrame;
use crate::sheets::place::Place;
use crate::sheets::ring::{Area, LANES};
use crate::sheets::tile::{SheetScratch, SheetWork};

/// The first plane that a splat reaches.
#[inline(always)]
fn first_plane(frame: &SheetFrame<'_>, splat: &OpenSplat) -> usize {
    let depth = f64::from(splat.centre[2] - splat.reach);
    ((depth - frame.stack.plane(0)) / frame.stack.spacing)
        .ceil()
        .max(0.0) as usize
}

impl CloudView<'_> {
    /// Whether any footprint of a splat reaches the tile.
    #[inline(always)]
    fn reaches(&self, frame: &SheetFrame<'_>, place: &Place, splat: &OpenSplat) -> bool {
        let [.., depth] = splat.centre;
        let first = f64::from(depth - splat.reach).max(f64::from(frame.sheets[0].depth));
        let last = f64::from(depth + splat.reach).max(first);
        let ends = [first, last].map(|depth| [depth as f32, self.screen.scale_at(depth) as f32]);
        let mut footing = place.footing(frame.principal());
        // On four planes at a time, a footprint may cover one block more than at the ends of its reach.
        for [first, end] in &mut footing.blocks {
            *first -= 1;
            *end += 1;
        }
        footing.blocks_of(splat, ends).is_some()
    }

    /// Opens the splats of a chunk that reach the tile, and queues each for the first plane that it reaches, from
    /// `sheet` on.
    #[inline(always)]
    pub(super) fn open_chunk(
        &self,
        frame: &SheetFrame<'_>,
        chunk: &ProjectedBrick,
        (place, sheet): (&Place, usize),
        scratch: &mut SheetScratch,
    ) {
        let chunk = &self.cloud.chunks[chunk.active.brick as usize];
        for index in chunk.first as usize..chunk.end as usize {
            let Some(splat) = self.open(index) else {
                continue;
            };
            if self.reaches(frame, place, &splat) {
                // A splat that rounding puts before the current plane enters here.
                let plane = first_plane(frame, &splat).max(sheet);
                scratch.waiting.add(&splat, plane);
            }
        }
    }
}

/// Window of a cloud, needed only to update the mask.
pub(super) fn window(frame: &SheetFrame<'_>, sheet: usize) -> Window {
    Window {
        blocks: 2,
        depth: frame.stack.plane(sheet) as f32,
        ..Window::default()
    }
}

/// Splats the queue of a sheet into it and the three behind it: N numbers of each splat's payload. `halo`: width,
/// in blocks, of the border around open pixels that those need, too.
#[inline(always)]
pub(super) fn enter<S: Simd, const N: usize>(
    simd: S,
    frame: &SheetFrame<'_>,
    (place, sheet, halo): (&Place, usize, u8),
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
            && mask.any(blocks.corners_around(halo))
        {
            let payload = std::array::from_fn(|channel| splat.payload[channel]);
            let rings = &mut ring.groups::<N>(0, 1);
            simd.vectorize(
                #[inline(always)]
                || planes.add(simd, (splat, payload), blocks, rings),
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
