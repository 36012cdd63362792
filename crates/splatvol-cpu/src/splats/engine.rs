//! The engine: all stages, and buffers that are kept between frames.

use std::ops::Range;
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};

use glam::DAffine3;
use rayon::prelude::*;
use splatvol_core::bin::TileGrid;
use splatvol_core::clock::Instant;
use splatvol_core::cloud_view::near_of_gaussians;
use splatvol_core::engine::StageSeconds;
use splatvol_core::splats::SplatCloud;
use splatvol_scene::{Camera, Frame, Gaussians, ImageSize};

use super::bin::{Bins, Counted};
use super::blend::{CutGaussian, Integral, Light, Published};
use super::composite::{Place, Scratch};
use super::cover::TILE;
use super::kernels::LitKernels;
use super::order::Keys;
use super::project::{ProjectedSplat, Rect, Target};
use super::resolve::{TileRows, fill, tile_rows};
use super::settings::{BlendMode, CloudSettings, Near, sane};
use super::view::CloudView;
use super::wanted::WantedTiles;
use super::work::{AnyBlend, Composition, Content, Projection, SeenCloud, SplatWork};
use crate::room::grow;
use crate::run::Run;

/// Splats that a thread projects at a time.
const CHUNK: usize = 4096;
/// Parts per thread, at least, in which splats are sorted and binned.
const PARTS_PER_THREAD: usize = 2;
/// Most splats of such a part; a thread checks for cancellation after each part.
const PART: usize = 1 << 16;

/// A cloud to splat; clouds are listed in the order in which equal depths are drawn.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Cloud<'a> {
    /// 3-D Gaussians, and where their own world lies.
    Gaussians(&'a Gaussians, DAffine3),
    /// Kernels with covariances of their own.
    Kernels(&'a SplatCloud),
}

impl Cloud<'_> {
    /// Number of splats.
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Gaussians(gaussians, _) => gaussians.len(),
            Self::Kernels(cloud) => cloud.len(),
        }
    }

    fn world_from_local(&self) -> DAffine3 {
        match self {
            Self::Gaussians(gaussians, world_from_item) => *world_from_item * *gaussians.world_from_local(),
            Self::Kernels(cloud) => cloud.world_from_local,
        }
    }

    /// The near limit, camera depth, world length; `None` for a cloud without one of its own.
    fn near(&self, settings: &CloudSettings) -> Option<f64> {
        match settings.near {
            Near::World(near) => Some(sane(near)),
            Near::OfGaussians(near) => {
                matches!(self, Self::Gaussians(..)).then(|| near_of_gaussians(near, &self.world_from_local()))
            }
        }
    }
}

/// Renders splats one by one; keeps its memory between frames.
#[derive(Debug, Default)]
pub(crate) struct SplatEngine {
    splats: Vec<ProjectedSplat>,
    rects: Vec<Rect>,
    keys: Keys,
    bins: Bins,
}

/// A piece of a cloud, and the target of its splats.
struct Chunk<'a> {
    cloud: usize,
    range: Range<usize>,
    target: Target<'a>,
}

impl SplatEngine {
    /// Bytes that are kept for the next frame.
    pub(crate) fn bytes(&self) -> usize {
        self.splats.capacity() * size_of::<ProjectedSplat>()
            + self.rects.capacity() * size_of::<Rect>()
            + self.keys.bytes()
            + self.bins.bytes()
    }

    /// Renders all clouds together into a frame, whose memory is reused if it has the size. After cancellation the
    /// frame's contents are undefined.
    ///
    /// Draws only the first 2^32 - 1 splats.
    pub(crate) fn render(
        &mut self,
        run: Run<'_>,
        clouds: &[Cloud<'_>],
        (camera, settings): (&Camera, &CloudSettings),
        frame: &mut Frame,
    ) -> StageSeconds {
        if let Ok(held) = run.task.held(settings.size).size()
            && !frame.fits(held)
        {
            *frame = Frame::empty(held);
        }
        let pool = run.pool;
        let drawn = |profile| Clouds {
            seen: seen(clouds, (camera, settings), profile),
            clouds,
        };
        pool.install(|| match settings.blend_mode {
            BlendMode::Published { background } => self.draw(
                run,
                AnyBlend::Published(Published::new(background)),
                &drawn(None),
                (frame, settings.size),
            ),
            BlendMode::Light { cut, termination } => {
                let profile = CutGaussian::new(cut);
                self.draw(
                    run,
                    AnyBlend::Light(Light::new(profile, termination)),
                    &drawn(Some(profile)),
                    (frame, settings.size),
                )
            }
            BlendMode::Integral { cut } => {
                let profile = CutGaussian::new(cut);
                self.draw(
                    run,
                    AnyBlend::Integral(Integral::new(profile)),
                    &drawn(Some(profile)),
                    (frame, settings.size),
                )
            }
        })
        .unwrap_or_default()
    }

    /// Runs all stages; `None` if the picture is cancelled before the last.
    fn draw(
        &mut self,
        run: Run<'_>,
        blend: AnyBlend,
        drawn: &Clouds<'_>,
        (frame, size): (&mut Frame, ImageSize),
    ) -> Option<StageSeconds> {
        let start = Instant::now();
        let Self {
            splats,
            rects,
            keys,
            bins,
        } = self;
        let stop = run.task.stop;
        let count = drawn.clouds.iter().map(Cloud::len).sum::<usize>();
        let count = count.min(u32::MAX as usize);
        let parts = (PARTS_PER_THREAD * run.pool.current_num_threads()).max(count.div_ceil(PART));
        grow(splats, count, stop)?;
        grow(rects, count, stop)?;
        keys.resize(count, stop)?;
        let project = |chunk: &mut Chunk<'_>| {
            let first = chunk.target.first;
            if run.task.is_stopped() {
                return first..first;
            }
            let mut visible = 0;
            run.instructions.splats(SplatWork::Project(Projection {
                blend,
                cloud: &drawn.seen[chunk.cloud],
                range: chunk.range.clone(),
                target: &mut chunk.target,
                visible: &mut visible,
            }));
            first..first + visible
        };
        let grid = TileGrid::new(size, TILE);
        let wanted = WantedTiles::new(&run.task, &grid);
        let mut chunks = chunks((drawn.clouds, &wanted), splats, rects, keys);
        let ranges: Vec<Range<usize>> = chunks.par_iter_mut().with_max_len(1).map(project).collect();
        let order = keys.sort(&ranges, parts, stop)?;
        let counted = Counted::new((grid, &wanted), (order, rects), parts, stop)?;
        let tiling = Tiling {
            run,
            blend,
            splats,
            grid,
            wanted: &wanted,
            done: AtomicUsize::new(0),
        };
        let bin = start.elapsed().as_secs_f64();
        let mut tiles = tile_rows(frame, &run.task.held(size), &grid);
        bins.for_each(counted, |lists| {
            tiles[lists.tiles.clone()]
                .par_iter_mut()
                .enumerate()
                .with_max_len(1)
                .for_each_init(Scratch::default, |scratch, (place, rows)| {
                    let tile = lists.tiles.start + place;
                    tiling.render(tile, lists.of(tile), rows, scratch);
                });
        });
        Some(StageSeconds {
            bin,
            tiles: start.elapsed().as_secs_f64() - bin,
            ..StageSeconds::default()
        })
    }
}

/// The tiles of a frame.
struct Tiling<'a> {
    run: Run<'a>,
    blend: AnyBlend,
    splats: &'a [ProjectedSplat],
    grid: TileGrid,
    wanted: &'a WantedTiles,
    done: AtomicUsize,
}

impl Tiling<'_> {
    /// Renders the splats of a list into a tile's rows, unless the tile is not wanted.
    fn render(&self, tile: usize, entries: &[AtomicU32], rows: &mut TileRows<'_>, scratch: &mut Scratch) {
        let Self { run, blend, grid, .. } = self;
        let rect = grid.rect(tile);
        if run.task.is_stopped() {
            return;
        }
        if self.wanted.has(tile) {
            if entries.is_empty() {
                fill(blend.empty(), rows);
            } else {
                let place = Place {
                    tile: [tile % grid.columns, tile / grid.columns],
                    blocks: rows.blocks(),
                    stop: run.task.stop,
                };
                run.instructions.splats(SplatWork::Composite(Composition {
                    blend: *blend,
                    splats: self.splats,
                    entries,
                    place,
                    scratch,
                    rows,
                }));
            }
            if !run.task.is_stopped() {
                run.task.show(&rect, || rows.colors());
            }
        }
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        run.task.report(done as f64 / grid.len() as f64);
    }
}

/// Clouds, each with its view.
struct Clouds<'a> {
    clouds: &'a [Cloud<'a>],
    seen: Vec<SeenCloud<'a>>,
}

/// Clouds before a camera.
fn seen<'a>(
    clouds: &[Cloud<'a>],
    (camera, settings): (&Camera, &CloudSettings),
    profile: Option<CutGaussian>,
) -> Vec<SeenCloud<'a>> {
    let nearest = clouds
        .iter()
        .filter_map(|cloud| cloud.near(settings))
        .reduce(f64::min);
    let lighting = settings.lighting.as_ref();
    let seen = |cloud: &Cloud<'a>| {
        let near = cloud.near(settings).or(nearest).unwrap_or(0.0);
        SeenCloud {
            view: CloudView::new(
                &cloud.world_from_local(),
                near,
                (camera, settings.size),
                settings.low_pass,
            ),
            content: match *cloud {
                Cloud::Gaussians(gaussians, _) => Content::Gaussians(gaussians),
                Cloud::Kernels(cloud) => Content::Kernels(LitKernels::new(cloud, lighting, camera, profile)),
            },
        }
    };
    clouds.iter().map(seen).collect()
}

/// Clouds in chunks, one after the other, for the wanted tiles.
fn chunks<'a>(
    (clouds, wanted): (&[Cloud<'_>], &'a WantedTiles),
    mut splats: &'a mut [ProjectedSplat],
    mut rects: &'a mut [Rect],
    keys: &'a Keys,
) -> Vec<Chunk<'a>> {
    let mut chunks = Vec::new();
    let mut first = 0;
    for (cloud, content) in clouds.iter().enumerate() {
        for start in (0..content.len()).step_by(CHUNK) {
            let count = CHUNK.min(content.len() - start).min(splats.len());
            let (own_splats, rest) = splats.split_at_mut(count);
            splats = rest;
            let (own_rects, rest) = rects.split_at_mut(count);
            rects = rest;
            chunks.push(Chunk {
                cloud,
                range: start..start + count,
                target: Target {
                    first,
                    wanted,
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
