//! The engine: all stages, and buffers that are kept between frames.

use std::ops::Range;

use fearless_simd::{Level, dispatch};
use glam::DAffine3;
use rayon::prelude::*;
use splatvol_scene::transfer_function::srgb_from_linear;
use splatvol_scene::{Camera, Frame, Gaussians};

use super::bin::{Bins, Counted, TileGrid};
use super::composite::{self, Scratch};
use super::order::Keys;
use super::project::{self, Rect, Splat, Target};
use super::resolve::{Background, fill, resolve, tile_rows};
use super::settings::{SplatSettings, sane};
use super::view::View;

/// Gaussians that a thread projects at a time.
const CHUNK: usize = 4096;
/// Parts per thread in which splats are sorted and binned.
const PARTS_PER_THREAD: usize = 2;

/// Gaussians in a scene.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Placed<'a> {
    /// The data.
    pub gaussians: &'a Gaussians,
    /// Where their own world lies.
    pub world_from_item: DAffine3,
}

impl Placed<'_> {
    pub(crate) fn world_from_local(&self) -> DAffine3 {
        self.world_from_item * *self.gaussians.world_from_local()
    }
}

#[cfg(test)]
impl<'a> From<&'a Gaussians> for Placed<'a> {
    fn from(gaussians: &'a Gaussians) -> Self {
        Self {
            gaussians,
            world_from_item: DAffine3::IDENTITY,
        }
    }
}

/// Renders with the threads of the pool that it is called from; keeps its memory between frames.
#[derive(Debug, Default)]
pub(crate) struct SplatEngine {
    splats: Vec<Splat>,
    rects: Vec<Rect>,
    keys: Keys,
    bins: Bins,
}

/// A piece of a cloud, and where its splats go.
struct Chunk<'a> {
    cloud: usize,
    range: Range<usize>,
    target: Target<'a>,
}

impl SplatEngine {
    /// Bytes that are kept for the next frame.
    #[cfg(test)]
    pub(crate) fn memory(&self) -> usize {
        self.splats.capacity() * size_of::<Splat>()
            + self.rects.capacity() * size_of::<Rect>()
            + self.keys.bytes()
            + self.bins.bytes()
    }

    /// A picture of all clouds together, into a frame whose memory is used again if it has the size.
    ///
    /// Draws the first 2^32 - 1 Gaussians if there should be more.
    pub(crate) fn render_into(
        &mut self,
        level: Level,
        clouds: &[Placed<'_>],
        (camera, settings): (&Camera, &SplatSettings),
        frame: &mut Frame,
    ) {
        if frame.image.size() != settings.size
            || frame.depth.len() != settings.size.pixel_count()
            || frame.optical_depth.len() != settings.size.pixel_count()
        {
            *frame = Frame::empty(settings.size);
        }
        let Self {
            splats,
            rects,
            keys,
            bins,
        } = self;
        let parts = PARTS_PER_THREAD * rayon::current_num_threads();
        let count = clouds
            .iter()
            .map(|cloud| cloud.gaussians.len())
            .sum::<usize>()
            .min(u32::MAX as usize);
        grow(splats, count);
        grow(rects, count);
        keys.resize(count);
        let views: Vec<View> = clouds
            .iter()
            .map(|cloud| View::new(cloud, camera, settings))
            .collect();
        let mut chunks = chunks(clouds, splats, rects, keys);
        let project = |chunk: &mut Chunk<'_>| {
            let (view, range) = (&views[chunk.cloud], chunk.range.clone());
            let cloud = clouds[chunk.cloud].gaussians;
            let first = chunk.target.first;
            let target = &mut chunk.target;
            let count = dispatch!(level, simd => project::project(simd, view, cloud, range, target));
            first..first + count
        };
        let ranges: Vec<Range<usize>> = chunks.par_iter_mut().with_max_len(1).map(project).collect();
        let order = keys.sort(&ranges, parts);
        let grid = TileGrid::new(settings.size);
        let counted = Counted::new(grid, order, rects, parts);
        let (background, empty) = background(settings);
        let mut tiles = tile_rows(frame, grid.columns, grid.rows);
        bins.for_each(counted, |lists| {
            tiles[lists.tiles.clone()]
                .par_iter_mut()
                .enumerate()
                .with_max_len(1)
                .for_each_init(Scratch::default, |scratch, (place, rows)| {
                    let tile = lists.tiles.start + place;
                    let entries = lists.of(tile);
                    if entries.is_empty() {
                        fill(empty, rows);
                        return;
                    }
                    let (place, alive) = ([tile % grid.columns, tile / grid.columns], rows.blocks());
                    dispatch!(level, simd => {
                        composite::composite(simd, splats, entries, place, alive, scratch);
                        resolve(simd, &scratch.blocks, &background, rows);
                    });
                });
        });
    }
}

/// Room for `count` values.
fn grow<T: Clone + Default>(values: &mut Vec<T>, count: usize) {
    if values.len() < count {
        values.reserve_exact(count - values.len());
        values.resize(count, T::default());
    }
}

/// Clouds in chunks, one after the other.
fn chunks<'a>(
    clouds: &[Placed<'_>],
    mut splats: &'a mut [Splat],
    mut rects: &'a mut [Rect],
    keys: &'a Keys,
) -> Vec<Chunk<'a>> {
    let mut chunks = Vec::new();
    let mut first = 0;
    for (cloud, Placed { gaussians, .. }) in clouds.iter().enumerate() {
        for start in (0..gaussians.len()).step_by(CHUNK) {
            let count = CHUNK.min(gaussians.len() - start).min(splats.len());
            let (own_splats, rest) = splats.split_at_mut(count);
            splats = rest;
            let (own_rects, rest) = rects.split_at_mut(count);
            rects = rest;
            chunks.push(Chunk {
                cloud,
                range: start..start + count,
                target: Target {
                    first,
                    splats: own_splats,
                    rects: own_rects,
                    keys: &keys.keys[first..first + count],
                },
            });
            first += count;
        }
    }
    chunks
}

/// Display colour behind everything, and the pixel where nothing lies before it.
fn background(settings: &SplatSettings) -> (Background, [f32; 4]) {
    let [r, g, b, alpha] = settings.background.map(|value| sane(f64::from(value)));
    let alpha = alpha.min(1.0) as f32;
    let background = Background {
        color: [r, g, b].map(|channel| srgb_from_linear(channel) as f32),
        alpha,
    };
    let [r, g, b] = [r, g, b].map(|channel| channel as f32 * alpha);
    (background, [r, g, b, alpha])
}
