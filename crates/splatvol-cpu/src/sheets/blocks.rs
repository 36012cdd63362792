//! Blocks: pictures of volumes that are read in chunks, within a budget of bytes.
//!
//! A picture is planned before anything is read:
//!
//! | part of the budget | bytes |
//! |---|---|
//! | the picture | [`PIXEL`] per pixel, and the memory of each thread |
//! | plan of a block | [`BRICK`] per brick that it may show, at most a quarter of the rest |
//! | samples, solved chunks | half of what remains, each; all for samples where voxels are classified first |
//!
//! The picture is drawn block by block, each of whole tiles, as few as the plan allows. Tiles next to each other follow
//! each other, so that chunks they share are still there. Neither blocks nor memory change a pixel: a brick has the same
//! place among those that a tile opens, and the same coefficients, whenever it is solved.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use splatvol_core::bin::{TileGrid, TileRect};
use splatvol_core::engine::RenderStatistics;
use splatvol_core::level::{Level, Pyramid, Wanted};
use splatvol_core::plan::{GridView, Reach};
use splatvol_scene::{ChunkSource, ChunkedVolume, ImageSize, Reservation, SceneError, Volume};

use crate::run::Run;

/// Bytes of a pixel: frame, tile, the frame of a coarser level, codes of the file.
const PIXEL: u64 = 24 + 24 + 24 + 8;
/// Bytes of a brick in the plan of a block.
const BRICK: u64 = 160;
/// Bytes of a pixel of a thread's tile, and pixels around the tile, in all its buffers.
const TILE: (u64, u64) = (80, 96);
/// Bytes with which a thread solves a chunk, its samples not counted, and samples that it reads for that.
const SOLVE: (u64, u64) = (3 << 19, 400_000);
/// Chunks of samples that must fit per thread, and bytes of solved chunks.
const LEAST: (u64, u64) = (8, 400_000);

/// A block of whole tiles.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Block {
    pub rect: TileRect,
    /// Whether it is the first of its picture.
    pub is_first: bool,
}

impl Block {
    /// The tiles of a block, neighbours near each other.
    pub(crate) fn tiles(&self, grid: &TileGrid) -> Vec<u32> {
        let inside = |tile: &u32| {
            let rect = grid.rect(*tile as usize);
            let own = &self.rect;
            rect.x0 >= own.x0 && rect.x1 <= own.x1 && rect.y0 >= own.y0 && rect.y1 <= own.y1
        };
        let mut tiles: Vec<u32> = (0..grid.len() as u32).filter(inside).collect();
        let along_curve = |tile: &u32| {
            let (x, y) = (*tile as usize % grid.columns, *tile as usize / grid.columns);
            (0..usize::BITS / 2).fold(0usize, |code, bit| {
                code | (x >> bit & 1) << (2 * bit) | (y >> bit & 1) << (2 * bit + 1)
            })
        };
        tiles.sort_by_key(along_curve);
        tiles
    }
}

/// The picture, as far as memory depends on it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Needs {
    /// The pixels that the frame holds.
    pub held: TileRect,
    pub threads: usize,
    pub tile_edge: usize,
    /// Volumes that share the picture.
    pub volumes: usize,
    /// Levels of each that are drawn at once.
    pub levels: usize,
}

impl Needs {
    fn picture(&self, element: u64) -> u64 {
        let edge = self.tile_edge as u64 + TILE.1;
        let thread = edge * edge * TILE.0 + SOLVE.0 + SOLVE.1 * element;
        let [width, height] = self.held.sides().map(|side| side as u64);
        let all = width * height * PIXEL + self.threads as u64 * thread;
        all / self.volumes.max(1) as u64
    }
}

/// Memory of a volume in chunks for one picture.
#[derive(Debug)]
pub(crate) struct Room {
    volume: Arc<ChunkedVolume>,
    _picture: Reservation,
    field: u64,
    plan: u64,
}

impl Room {
    /// Divides the budget of a volume, if it is read in chunks, for a picture of some of its levels; what those beside them
    /// solved is kept as far as there is room, as they may be drawn again. Where the picture before had another division,
    /// it is freed.
    ///
    /// # Errors
    /// A budget that is too small, with the one that would be enough; a level that cannot be made.
    pub(crate) fn of_picture(
        (volume, levels): (&Volume, Range<usize>),
        pyramid: &mut Pyramid,
        needs: Needs,
        wanted: Wanted,
    ) -> Result<Option<Self>, SceneError> {
        let last = levels.end - 1;
        pyramid.grid(last)?;
        Self::new(volume, (pyramid, levels.clone()), needs, wanted).or_else(|_| {
            pyramid.free_solved();
            Self::new(volume, (pyramid, levels), needs, wanted)
        })
    }

    fn new(
        volume: &Volume,
        (pyramid, levels): (&Pyramid, Range<usize>),
        needs: Needs,
        wanted: Wanted,
    ) -> Result<Option<Self>, SceneError> {
        let overview = (volume.samples().len() * volume.samples().bytes_per_sample()) as u64;
        let Some(volume) = volume.chunks() else {
            return Ok(None);
        };
        let layout = volume.layout(0);
        let element = layout.element.size() as u64;
        let chunk = layout.chunk.iter().map(|&edge| edge as u64).product::<u64>() * element;
        let threads = needs.threads as u64;
        // Three more are on their way: stored, decoded, as samples.
        let picture = needs.picture(element) + 3 * threads * chunk;
        let taken = picture + overview;
        let least = threads * (LEAST.0 * chunk + LEAST.1);
        let budget = volume.budget();
        let too_small = |wanted: u64| SceneError::Source {
            name: volume.source().identity().name,
            level: 0,
            first: [0; 3],
            reason: format!(
                "{} bytes of memory are too few for this picture: it takes {wanted} on {threads} threads; \
                 fewer threads, a smaller picture or smaller chunks take less",
                budget.limit()
            ),
        };
        let rest = budget
            .limit()
            .checked_sub(taken)
            .filter(|&rest| rest - rest / 4 >= least)
            .ok_or_else(|| too_small(taken + least + least / 2))?;
        let plan = rest / 4;
        let field = match wanted {
            Wanted::Classified => 0,
            _ => (rest - plan) / 2,
        };
        let samples = rest - plan - field;
        let enough = taken + least + least / 2;
        let lent = pyramid.lend(levels.clone(), field);
        pyramid
            .give(levels.end - 1, samples)
            .map_err(|_| too_small(enough))?;
        Ok(Some(Self {
            _picture: budget
                .try_reserve(picture + plan)
                .ok_or_else(|| too_small(enough))?,
            volume: Arc::clone(volume),
            field: (field - lent) / needs.levels as u64,
            plan: plan / needs.levels as u64,
        }))
    }

    /// Keeps what the budget has for solved chunks.
    fn give(&self, level: &Level) -> Result<(), SceneError> {
        level.field.keep(self.field).map_err(|over| SceneError::Source {
            name: "memory".to_owned(),
            level: 0,
            first: [0; 3],
            reason: over.to_string(),
        })
    }

    /// Blocks along each axis.
    fn divisions(&self, level: &Level, tiles: &TileGrid) -> usize {
        let bytes = level.field.candidates() as u64 * BRICK;
        let most = tiles.columns.max(tiles.rows).max(1);
        // Blocks overlap, and some show more than others.
        (1..most)
            .find(|&n| bytes / (n * n) as u64 * if n > 1 { 2 } else { 1 } <= self.plan)
            .unwrap_or(most)
    }

    /// Adds what was read and solved since the last picture.
    pub(crate) fn count(&self, levels: &[&Level], statistics: &mut RenderStatistics) {
        let counts = self.volume.source().take_counts();
        let of = &mut statistics.chunks;
        for level in levels {
            let number = level.field.source().of().1;
            let all: usize = self.volume.layout(number).counts().iter().product();
            statistics.solved_bricks += level.field.take_solved();
            of.all += all as u64;
        }
        of.touched += counts.chunks;
        of.reads += counts.reads;
        of.bytes += counts.bytes;
        of.most_reads = of.most_reads.max(counts.most);
        of.holes += counts.holes;
        of.planned_bytes = of.planned_bytes.max(self.volume.budget().most());
    }
}

/// The blocks of a picture; one, the whole, where no volume is read in chunks. Each level gets its memory.
///
/// # Errors
/// Memory that is used otherwise.
pub(crate) fn of_picture(
    rooms: &[(&Room, &Level)],
    size: ImageSize,
    run: &Run<'_>,
    tile_edge: usize,
) -> Result<Cow<'static, [Option<Block>]>, SceneError> {
    let lazy = rooms.iter().filter(|(_, level)| level.field.is_lazy());
    let tiles = TileGrid::new(size, tile_edge);
    for (room, level) in rooms {
        room.give(level)?;
    }
    let Some(divisions) = lazy.map(|(room, level)| room.divisions(level, &tiles)).max() else {
        // Nothing is allocated here: viewers render frame after frame.
        return Ok(Cow::Borrowed(&[None]));
    };
    let (whole, held) = (TileRect::of(size), run.task.held(size));
    let part = run.task.part.map_or(held, |part| part.overlap(&held));
    let ends = |count: usize, i: usize| i * count.div_ceil(divisions) * tile_edge;
    let mut blocks = Vec::new();
    for row in 0..divisions {
        for column in 0..divisions {
            // The part of the block that is wanted, out to the ends of its tiles.
            let low = |end: usize, part: usize| end.max(part / tile_edge * tile_edge);
            let high = |end: usize, part: usize, size: usize| {
                end.min(part.div_ceil(tile_edge).saturating_mul(tile_edge))
                    .min(size)
            };
            let rect = TileRect {
                x0: low(ends(tiles.columns, column), part.x0),
                y0: low(ends(tiles.rows, row), part.y0),
                x1: high(ends(tiles.columns, column + 1), part.x1, whole.x1),
                y1: high(ends(tiles.rows, row + 1), part.y1, whole.y1),
            };
            if rect.x0 < rect.x1 && rect.y0 < rect.y1 {
                blocks.push(Some(Block {
                    rect,
                    is_first: blocks.is_empty(),
                }));
            }
        }
    }
    Ok(Cow::Owned(blocks))
}

/// Leaves the bricks of a level that a block can show.
pub(crate) fn restrict(level: &mut Level, view: &GridView, block: Option<Block>) {
    if let Some(block) = block.filter(|_| level.field.is_lazy()) {
        let reach = Reach::new(view, block.rect);
        level.restrict(&|first| reach.meets(first));
    }
}
