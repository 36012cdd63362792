//! Ready: levels with what their looks need, in views on common planes; within the budget of each volume that is read in chunks.
//!
//! Bricks of such a volume that may be visible, as far as its index tells, and that the picture can show, are solved when
//! their pages are brought.

use std::ops::Range;

use splatvol_core::bin::TileRect;
use splatvol_core::chunk_memory::{ChunkMemory, PictureNeeds};
use splatvol_core::engine::{RenderStatistics, Task};
use splatvol_core::level::{Level, Pyramid, Wanted};
use splatvol_core::plan::{GridView, Reach, on_common_planes};
use splatvol_core::prepared::PreparedVolumes;
use splatvol_scene::{Camera, RenderSettings, SceneError, SheetSettings};

use crate::atlas::CHUNKS_TOGETHER;
use crate::shown::Shown;

/// Bytes of a pixel on the host: frame, the frame of a coarser level, what comes from the device, codes of the file.
const PIXEL: u64 = 24 + 24 + 24 + 8;
/// Bytes of a brick in the plan: its place, that of the picture before, and the pages that it meets.
const BRICK: u64 = 320;
/// Share of the progress that reading takes, where bricks are solved when they are brought.
const READING: f64 = 0.5;

/// Levels of volumes, each in its view.
pub(super) struct Ready<'p> {
    pub levels: Vec<&'p Level>,
    pub views: Vec<GridView>,
    /// Of each volume that is read in chunks.
    memories: Vec<Option<ChunkMemory>>,
}

impl<'p> Ready<'p> {
    /// Each volume at one of its levels.
    ///
    /// # Errors
    /// A stopped picture, samples that cannot be read, and a budget that is too small.
    pub(super) fn new(
        prepared: &'p mut PreparedVolumes,
        (camera, shown, levels): (&Camera, &[Shown<'_>], &[usize]),
        task: Task<'_>,
    ) -> Result<Self, SceneError> {
        let mut ready = Self {
            levels: Vec::new(),
            views: Vec::new(),
            memories: Vec::new(),
        };
        // Labels have no coefficients, whatever their settings.
        let Some(main) = shown.iter().find(|own| !own.labels).or(shown.first()) else {
            return Ok(ready);
        };
        let pyramids = prepared.of_scene(shown.iter().map(|own| &own.volume), &main.settings);
        for ((pyramid, own), &level) in pyramids.iter_mut().zip(shown).zip(levels) {
            let memory = memory_of((own, level..level + 1), pyramid, shown.len())?;
            ready.memories.push(memory);
        }
        let mut classified = Vec::with_capacity(shown.len());
        for ((pyramid, own), &level) in pyramids.iter_mut().zip(shown).zip(levels) {
            classified.push(pyramid.classify(level, own.look(), Wanted::of(&own.settings), task.stop)?);
        }
        ready.views = views(camera, shown, &classified);
        for (at, level) in classified.into_iter().enumerate() {
            let memory = ready.memories[at].as_ref();
            restrict((&mut *level, memory), &ready.views[at], &shown[at].settings)?;
            ready.levels.push(level);
        }
        Ok(ready)
    }

    /// Counts what was done for the levels, and what they have.
    pub(super) fn count(&self, shown: &[Shown<'_>], statistics: &mut RenderStatistics) {
        for (own, level) in shown.iter().zip(&self.levels) {
            count(own, level, statistics);
        }
    }

    /// Share of a picture's progress that is left to reading chunks.
    pub(super) fn reading_share(&self) -> f64 {
        match self.levels.iter().any(|level| level.field.is_lazy()) {
            true => READING,
            false => 0.0,
        }
    }

    /// Counts what was read.
    ///
    /// # Errors
    /// Samples that could not be read.
    pub(super) fn finish(self, statistics: &mut RenderStatistics) -> Result<(), SceneError> {
        for (level, memory) in self.levels.into_iter().zip(&self.memories) {
            finish((&[level], memory.as_ref()), statistics)?;
        }
        Ok(())
    }
}

/// Memory for a picture of some levels of a volume, if it is read in chunks.
///
/// # Errors
/// A budget that is too small, a level that cannot be made.
pub(super) fn memory_of(
    (own, levels): (&Shown<'_>, Range<usize>),
    pyramid: &mut Pyramid,
    volumes: usize,
) -> Result<Option<ChunkMemory>, SceneError> {
    let needs = PictureNeeds {
        bytes: own.settings.size.pixel_count() as u64 * PIXEL + 3 * CHUNKS_TOGETHER,
        threads: rayon::current_num_threads(),
        volumes,
        levels: levels.len(),
    };
    ChunkMemory::of_picture((&own.volume, levels), pyramid, needs, Wanted::of(&own.settings))
}

/// Leaves the bricks of a level that a picture can show, if it is read in chunks.
///
/// # Errors
/// More of them than the budget has room for.
pub(super) fn restrict(
    (level, memory): (&mut Level, Option<&ChunkMemory>),
    view: &GridView,
    settings: &RenderSettings<SheetSettings>,
) -> Result<(), SceneError> {
    let Some(memory) = memory else {
        return Ok(());
    };
    memory.give(level)?;
    if !level.field.is_lazy() {
        return Ok(());
    }
    // Kernels end at a box along the grid's axes, whose corners are farther away than footprints.
    let spacing = level.field.source().grid().spacing().max_element();
    let corner = 3f64.sqrt() * settings.method.kernel.radius * spacing;
    let reach = Reach::new(view, TileRect::of(settings.size)).beyond(corner);
    level.restrict(&|first| reach.meets(first));
    let bytes = level.field.len() as u64 * BRICK;
    if bytes <= memory.plan() {
        return Ok(());
    }
    Err(SceneError::Source {
        name: "memory".to_owned(),
        level: level.field.source().of().1,
        first: [0; 3],
        reason: format!(
            "the bricks that this picture may show take {bytes} bytes to plan on the GPU, and a quarter of the budget, {}, is for \
             that; more memory or the engine cpu will do, which plans a picture in blocks",
            memory.plan()
        ),
    })
}

/// Counts what was read of some levels of a volume.
///
/// # Errors
/// Samples that could not be read.
pub(super) fn finish(
    (levels, memory): (&[&Level], Option<&ChunkMemory>),
    statistics: &mut RenderStatistics,
) -> Result<(), SceneError> {
    if let Some(error) = levels.iter().find_map(|level| level.field.failure()) {
        return Err(error);
    }
    if let Some(memory) = memory {
        memory.count(levels, statistics);
    }
    Ok(())
}

/// Counts what was done for a level, and what it has.
pub(super) fn count(own: &Shown<'_>, level: &Level, statistics: &mut RenderStatistics) {
    level.count_work(statistics);
    statistics.active_bricks += match own.mode().splats_classes() {
        true => level.visible.len(),
        false => level.field.len(),
    };
}

/// Views of the levels, on common planes.
fn views(camera: &Camera, shown: &[Shown<'_>], classified: &[&mut Level]) -> Vec<GridView> {
    let grids: Vec<_> = shown
        .iter()
        .zip(classified)
        .map(|(own, level)| (level.field.source().grid(), own.settings, own.sampling()))
        .collect();
    on_common_planes(&grids, camera)
}
