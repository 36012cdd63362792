//! Memory of volumes that are read in chunks, for one picture.
//!
//! A picture is planned before anything is read:
//!
//! | part of the budget | bytes |
//! |---|---|
//! | the picture | what its engine says, and what each thread solves a chunk with |
//! | plan | for the bricks that it may show, a quarter of the rest |
//! | samples, solved chunks | half of what remains, each; all for samples where voxels are classified first |

use std::ops::Range;
use std::sync::Arc;

use splatvol_scene::{ChunkSource, ChunkedVolume, Reservation, SceneError, Volume};

use crate::engine::RenderStatistics;
use crate::level::{Level, Pyramid, Wanted};

/// Bytes with which a thread solves a chunk, its samples not counted, and samples that it reads for that.
const SOLVE: (u64, u64) = (3 << 19, 400_000);
/// Chunks of samples that must fit per thread, and bytes of solved chunks.
const LEAST: (u64, u64) = (8, 400_000);

/// The picture, as far as memory depends on it.
#[derive(Debug, Clone, Copy)]
pub struct PictureNeeds {
    /// Bytes of the picture and of its engine's threads.
    pub bytes: u64,
    /// Threads that read and solve chunks.
    pub threads: usize,
    /// Volumes that share the picture.
    pub volumes: usize,
    /// Levels of each that are drawn at once.
    pub levels: usize,
}

impl PictureNeeds {
    /// A volume's share, given the bytes of a sample.
    fn of_volume(&self, element: u64) -> u64 {
        let all = self.bytes + self.threads as u64 * (SOLVE.0 + SOLVE.1 * element);
        all / self.volumes.max(1) as u64
    }
}

/// Memory of a volume in chunks for one picture.
#[derive(Debug)]
pub struct ChunkMemory {
    volume: Arc<ChunkedVolume>,
    _picture: Reservation,
    field: u64,
    plan: u64,
}

impl ChunkMemory {
    /// Divides the budget of a volume, if it is read in chunks, for a picture of some of its levels; what those beside them
    /// solved is kept as far as there is room, as they may be drawn again. Where the picture before had another division,
    /// it is freed.
    ///
    /// # Errors
    /// A budget that is too small, with the one that would be enough; a level that cannot be made.
    pub fn of_picture(
        (volume, levels): (&Volume, Range<usize>),
        pyramid: &mut Pyramid,
        needs: PictureNeeds,
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
        needs: PictureNeeds,
        wanted: Wanted,
    ) -> Result<Option<Self>, SceneError> {
        let overview = (volume.samples().len() * volume.samples().bytes_per_sample()) as u64;
        let Some(volume) = volume.chunks() else {
            return Ok(None);
        };
        let (chunk, element) = pyramid.largest_chunk(levels.clone());
        let threads = needs.threads as u64;
        // Three more are on their way: stored, decoded, as samples.
        let picture = needs.of_volume(element) + 3 * threads * chunk;
        let taken = picture + overview;
        let least = threads * (LEAST.0 * chunk + LEAST.1);
        let budget = volume.budget();
        let rest = budget
            .limit()
            .checked_sub(taken)
            .filter(|&rest| rest - rest / 4 >= least)
            .ok_or_else(|| too_small(volume, taken + least + least / 2, needs))?;
        let plan = rest / 4;
        let field = match wanted {
            Wanted::Classified => 0,
            _ => (rest - plan) / 2,
        };
        let samples = rest - plan - field;
        let enough = taken + least + least / 2;
        let lent = pyramid.lend(levels.clone(), field);
        pyramid
            .give(levels, samples)
            .map_err(|_| too_small(volume, enough, needs))?;
        Ok(Some(Self {
            _picture: budget
                .try_reserve(picture + plan)
                .ok_or_else(|| too_small(volume, enough, needs))?,
            volume: Arc::clone(volume),
            field: (field - lent) / needs.levels as u64,
            plan: plan / needs.levels as u64,
        }))
    }

    /// Bytes for the plan of a level.
    pub fn plan(&self) -> u64 {
        self.plan
    }

    /// Keeps what the budget has for a level's solved chunks.
    ///
    /// # Errors
    /// Memory that is used otherwise.
    pub fn give(&self, level: &Level) -> Result<(), SceneError> {
        level.field.keep(self.field).map_err(|over| SceneError::Source {
            name: "memory".to_owned(),
            level: 0,
            first: [0; 3],
            reason: over.to_string(),
        })
    }

    /// Adds what was read and solved since the last picture.
    pub fn count(&self, levels: &[&Level], statistics: &mut RenderStatistics) {
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

/// A budget that is too small for a picture, with what it takes.
fn too_small(volume: &ChunkedVolume, wanted: u64, needs: PictureNeeds) -> SceneError {
    SceneError::Source {
        name: volume.source().identity().name,
        level: 0,
        first: [0; 3],
        reason: format!(
            "{} bytes of memory are too few for this picture: it takes {wanted} on {} threads; \
             fewer threads, a smaller picture or smaller chunks take less",
            volume.budget().limit(),
            needs.threads
        ),
    }
}
