//! The renderer: threads, and buffers that are kept between frames.

use std::ops::Range;

use fearless_simd::{Level, dispatch};
use rayon::prelude::*;
use splatvol_scene::transfer_function::srgb_from_linear;
use splatvol_scene::{Camera, Frame, Gaussians};

use crate::bin::{Bins, Counted, TileGrid};
use crate::order::Keys;
use crate::project::{self, Rect, Splat, Target};
use crate::resolve::{Background, fill, resolve, tile_rows};
use crate::settings::{GaussianSettings, sane};
use crate::tile::{self, Scratch};
use crate::view::View;

/// Gaussians that a thread projects at a time.
const CHUNK: usize = 4096;
/// Parts per thread in which splats are sorted and binned.
const PARTS_PER_THREAD: usize = 2;

/// Settings of a renderer's lifetime. They do not change pictures.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct RendererConfig {
    /// Worker threads; `None` takes one per logical processor.
    pub threads: Option<usize>,
    /// Instructions to use; `None` takes the best that the processor has.
    pub simd: Option<SimdLevel>,
}

/// Vector instructions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SimdLevel {
    /// What every processor of the architecture has: SSE2 on x86-64, NEON on 64-bit ARM.
    Baseline,
    /// AVX2 with FMA.
    Avx2,
    /// AVX-512.
    Avx512,
}

impl SimdLevel {
    /// All levels.
    pub const ALL: [Self; 3] = [Self::Baseline, Self::Avx2, Self::Avx512];

    /// Whether this processor has it.
    pub fn is_available(self) -> bool {
        self.level().is_some()
    }

    fn level(self) -> Option<Level> {
        match self {
            Self::Baseline => Some(Level::baseline()),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Self::Avx2 => Level::new().as_avx2().map(Level::Avx2),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Self::Avx512 => Level::new().as_avx512().map(Level::Avx512),
            #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
            Self::Avx2 | Self::Avx512 => None,
        }
    }
}

/// Why a renderer cannot start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RendererError {
    /// The operating system refused the threads.
    #[error("cannot start {threads:?} worker threads: {reason}")]
    Threads {
        /// Threads asked for.
        threads: Option<usize>,
        /// What the system said.
        reason: String,
    },
    /// Instructions that the processor lacks.
    #[error("this processor has no {simd:?} instructions")]
    Simd {
        /// What was asked for.
        simd: SimdLevel,
    },
}

/// Renders clouds of Gaussians; keeps its threads and its memory between frames.
#[derive(Debug)]
pub struct Renderer {
    pool: rayon::ThreadPool,
    level: Level,
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

impl Renderer {
    /// A renderer with threads of its own.
    ///
    /// # Errors
    /// Threads that the system refuses, or instructions that the processor lacks.
    pub fn new(config: RendererConfig) -> Result<Self, RendererError> {
        let level = match config.simd {
            None => Level::new(),
            Some(simd) => simd.level().ok_or(RendererError::Simd { simd })?,
        };
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(config.threads.unwrap_or(0))
            .thread_name(|index| format!("splatvol-gaussians-{index}"))
            .build()
            .map_err(|error| RendererError::Threads {
                threads: config.threads,
                reason: error.to_string(),
            })?;
        Ok(Self {
            pool,
            level,
            splats: Vec::new(),
            rects: Vec::new(),
            keys: Keys::default(),
            bins: Bins::default(),
        })
    }

    /// Bytes that are kept for the next frame.
    pub fn memory(&self) -> usize {
        self.splats.capacity() * size_of::<Splat>()
            + self.rects.capacity() * size_of::<Rect>()
            + self.keys.bytes()
            + self.bins.bytes()
    }

    /// A picture of all clouds together.
    pub fn render(&mut self, clouds: &[&Gaussians], camera: &Camera, settings: &GaussianSettings) -> Frame {
        let mut frame = Frame::empty(settings.size);
        self.render_into(clouds, camera, settings, &mut frame);
        frame
    }

    /// The same into a frame whose memory is used again if it has the size.
    ///
    /// Draws the first 2^32 - 1 Gaussians if there should be more.
    pub fn render_into(
        &mut self,
        clouds: &[&Gaussians],
        camera: &Camera,
        settings: &GaussianSettings,
        frame: &mut Frame,
    ) {
        if frame.image.size() != settings.size
            || frame.depth.len() != settings.size.pixel_count()
            || frame.optical_depth.len() != settings.size.pixel_count()
        {
            *frame = Frame::empty(settings.size);
        }
        let Self {
            pool,
            level,
            splats,
            rects,
            keys,
            bins,
        } = self;
        let level = *level;
        let parts = PARTS_PER_THREAD * pool.current_num_threads();
        pool.install(|| {
            let count = clouds
                .iter()
                .map(|cloud| cloud.len())
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
                let (view, cloud, range) = (&views[chunk.cloud], clouds[chunk.cloud], chunk.range.clone());
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
                            tile::composite(simd, splats, entries, place, alive, scratch);
                            resolve(simd, &scratch.blocks, &background, rows);
                        });
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
    clouds: &[&Gaussians],
    mut splats: &'a mut [Splat],
    mut rects: &'a mut [Rect],
    keys: &'a Keys,
) -> Vec<Chunk<'a>> {
    let mut chunks = Vec::new();
    let mut first = 0;
    for (cloud, gaussians) in clouds.iter().enumerate() {
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
fn background(settings: &GaussianSettings) -> (Background, [f32; 4]) {
    let [r, g, b, alpha] = settings.background.map(|value| sane(f64::from(value)));
    let alpha = alpha.min(1.0) as f32;
    let background = Background {
        color: [r, g, b].map(|channel| srgb_from_linear(channel) as f32),
        alpha,
    };
    let [r, g, b] = [r, g, b].map(|channel| channel as f32 * alpha);
    (background, [r, g, b, alpha])
}
