//! Levels of detail: the volume, with more samples where its voxels are long ([`refine`]), and its halves, each with the
//! data that a transfer function needs.
//!
//! The level is chosen so that a voxel is 0.8 to 1.6 pixels wide in the middle of the volume. Within a quarter of
//! an octave of a change both levels are rendered and blended, so that the change is invisible. Where scale changes much
//! within the volume, levels follow each other in depth instead (`by_depth`). Minified volumes
//! are anti-aliased by their mips, and cost in proportion to their pixels. With a level bias of n octaves all widths are
//! `2^n` times as large: drafts have an eighth of the voxels per octave. Voxels that are classified first have levels of
//! their classes ([`ClassifiedMeans`]), labels with the surfaces on which light falls. Analytic gradients have none: they are
//! anti-aliased by the filter alone.

mod by_depth;
mod means;
mod memory;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::classification::ClassificationTable;
use crate::engine::RenderStatistics;
use crate::field::{FieldStore, FieldWork, SourceLevel, survey};
use crate::kernel::GaussianKernel;
use crate::mip;
use crate::refine::{self, LongLevel};
use crate::visibility::VisibleLevels;
use splatvol_scene::{
    Camera, Classification, Frame, Grid, ImageSize, Kernel, RenderSettings, SampleSource, SceneError,
    SheetKernel, SheetSettings, Shows, TransferFunction, Volume,
};

pub use by_depth::{LevelUntil, by_depth};
pub use means::{Classes, ClassifiedMeans, Surfaces};

use crate::shade_table::ShadeTable;

/// Smallest width of a voxel, pixels.
const FINEST: f64 = 0.8;
/// Octaves over which two levels are blended.
const BLEND: f64 = 0.25;

/// Which voxels a picture needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wanted {
    /// Voxels around visible values of the field.
    Visible,
    /// Voxels around values of the field at least as large as some visible one, which a larger value hides.
    Largest,
    /// Voxels around values of the field at least as small as some visible one.
    Smallest,
    /// All voxels: each contributes to the mean.
    All,
    /// Voxels that are visible themselves.
    Classified,
}

impl Wanted {
    /// The voxels that the settings need.
    pub fn of(settings: &RenderSettings<SheetSettings>) -> Self {
        match settings.method.shows {
            Shows::Mip => Self::Largest,
            Shows::MinimumIntensity => Self::Smallest,
            Shows::Mean => Self::All,
            Shows::Xray | Shows::Material(Classification::Pre) => Self::Classified,
            Shows::Material(Classification::Post) => Self::Visible,
        }
    }
}

/// How values are shown: what their classes are, and whether they are labels.
#[derive(Debug, Clone, Copy)]
pub struct VolumeLook<'a> {
    /// Colours and opacities of values.
    pub transfer_function: &'a TransferFunction,
    /// World length to which its opacities refer.
    pub unit_distance: f64,
    /// Whether values are labels: light falls on the shape of each.
    pub labels: bool,
}

/// A volume at one resolution.
#[derive(Debug)]
pub struct Level {
    /// Coefficients of the needed voxels.
    pub field: FieldStore,
    /// The transfer function as planes are shaded with it.
    pub table: ShadeTable,
    /// The transfer function as values are classified with it.
    pub classification: ClassificationTable,
    /// Bricks with visible voxels, if needed.
    pub visible: Vec<u32>,
    /// Classes of these bricks, where they are not those of this level's own samples.
    pub means: Option<ClassifiedMeans>,
    /// Smallest and largest visible value.
    pub hull: [f32; 2],
    /// Work of its last update.
    work: FieldWork,
    /// Cache key of all this.
    made_for: MadeFor,
}

/// What the data of a level are for.
#[derive(Debug)]
struct MadeFor {
    transfer_function: TransferFunction,
    unit_distance: f64,
    labels: bool,
    wanted: Wanted,
}

impl Level {
    fn new(
        source: SourceLevel,
        (kernel, prefilter): (Kernel, bool),
        look: VolumeLook<'_>,
        (wanted, stop): (Wanted, &AtomicBool),
    ) -> Self {
        let VolumeLook {
            transfer_function,
            unit_distance,
            labels,
        } = look;
        let range = source.value_range();
        let kernel = GaussianKernel::new(kernel);
        let field = match prefilter {
            true => FieldStore::new(source, &kernel),
            false => FieldStore::of_samples(source, &kernel),
        };
        let mut level = Self {
            field,
            table: ShadeTable::default(),
            classification: ClassificationTable::new(transfer_function, range, unit_distance),
            visible: Vec::new(),
            means: None,
            hull: [f32::INFINITY; 2],
            work: FieldWork::default(),
            made_for: MadeFor {
                transfer_function: transfer_function.clone(),
                unit_distance,
                labels,
                wanted,
            },
        };
        level.find(stop);
        level
    }

    fn update(&mut self, look: VolumeLook<'_>, wanted: Wanted, stop: &AtomicBool) {
        let VolumeLook {
            transfer_function,
            unit_distance,
            labels,
        } = look;
        let old = &mut self.made_for;
        let same = old.transfer_function == *transfer_function && old.unit_distance == unit_distance;
        self.work = FieldWork::default();
        if same && old.wanted == wanted && old.labels == labels {
            return;
        }
        if !same {
            old.transfer_function.clone_from(transfer_function);
            old.unit_distance = unit_distance;
            let range = self.field.source().value_range();
            self.classification = ClassificationTable::new(transfer_function, range, unit_distance);
        }
        (old.wanted, old.labels) = (wanted, labels);
        self.means = None;
        self.find(stop);
    }

    /// Adds the bricks on which the last update worked.
    pub fn count_work(&self, statistics: &mut RenderStatistics) {
        statistics.searched_bricks += self.work.searched;
        statistics.solved_bricks += self.work.solved;
    }

    /// Where bricks are solved when they are opened, leaves those that a picture needs, given their first lattice
    /// points.
    pub fn restrict(&mut self, keep: &(dyn Fn([u32; 3]) -> bool + Sync)) {
        let wanted = self.made_for.wanted;
        if wanted == Wanted::Classified {
            let visible = VisibleLevels::new(&self.classification);
            self.field.visible_bricks(&visible, &mut self.visible);
            let field = &self.field;
            self.visible.retain(|&brick| keep(field.brick_first(brick)));
        } else {
            self.field.restrict(keep);
        }
    }

    /// Finds the needed voxels.
    fn find(&mut self, stop: &AtomicBool) {
        let visible = VisibleLevels::new(&self.classification);
        self.hull = visible.hull().unwrap_or([f32::INFINITY; 2]);
        let wanted = self.made_for.wanted;
        if wanted == Wanted::Classified {
            self.field.visible_bricks(&visible, &mut self.visible);
        } else {
            match wanted {
                Wanted::Largest => self.field.update_unless(stop, &visible.and_larger()),
                Wanted::Smallest => self.field.update_unless(stop, &visible.and_smaller()),
                Wanted::All => self.field.update_unless(stop, &VisibleLevels::all()),
                Wanted::Visible | Wanted::Classified => self.field.update_unless(stop, &visible),
            }
            self.work = self.field.work();
            self.table
                .update(&self.classification, &visible, self.field.background());
        }
    }
}

/// Whether coefficients interpolate the samples; classified voxels have no coefficients.
fn interpolates(settings: &RenderSettings<SheetSettings>) -> bool {
    settings.method.prefilter || settings.method.splats_colors()
}

/// A volume's levels, made on demand.
#[derive(Debug)]
pub struct Pyramid {
    kernel: SheetKernel,
    /// Whether coefficients interpolate the samples.
    prefilter: bool,
    /// Whether long voxels are refined.
    refines: bool,
    /// The source's own levels.
    own: Vec<SourceLevel>,
    /// Levels made so far: the source's own, refined where their voxels are long, and further halves of the last.
    sources: Vec<SourceLevel>,
    levels: Vec<Option<Level>>,
}

/// Level to render, and the share of the next coarser one to blend in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detail {
    /// 0 is the volume itself, each further one half of it.
    pub level: usize,
    /// Share of the next coarser level, 0 to 1.
    pub coarser: f32,
}

impl Detail {
    /// The full resolution.
    pub const FINEST: Self = Self {
        level: 0,
        coarser: 0.0,
    };

    /// Detail of a volume with this finest grid for a camera, `bias` octaves coarser than the picture asks.
    pub fn new(grid: &Grid, camera: &Camera, (size, bias): (ImageSize, f64)) -> Self {
        let centre = grid.bounds().centre();
        let depth = camera.camera_from_world().transform_point3(centre).z;
        let scale = camera.screen_from_camera(size).scale_at(depth);
        let octaves = bias + libm::log2(FINEST / (scale * grid.mean_spacing()));
        let most = most_halves(grid) as f64;
        if !octaves.is_finite() || octaves <= -BLEND {
            return Self::FINEST;
        }
        let level = octaves.ceil().clamp(0.0, most);
        let into = if level < most {
            (1.0 + (octaves - level) / BLEND).clamp(0.0, 1.0)
        } else {
            0.0
        };
        Self {
            level: level as usize,
            coarser: into as f32,
        }
    }
}

/// How often a grid can be halved.
fn most_halves(grid: &Grid) -> usize {
    let longest = grid.dims().into_iter().max().unwrap_or(1);
    longest.ilog2().saturating_sub(3) as usize
}

impl Pyramid {
    /// Levels of a source, none of them made yet, for the kernel and prefilter of these settings.
    pub fn new(source: Arc<dyn SampleSource>, settings: &RenderSettings<SheetSettings>) -> Self {
        let level = |level| SourceLevel::new(Arc::clone(&source), level);
        Self {
            kernel: settings.method.kernel,
            prefilter: interpolates(settings),
            refines: refine::applies(settings),
            own: (0..source.levels()).map(level).collect(),
            sources: Vec::new(),
            levels: Vec::new(),
        }
    }

    /// Whether the levels are this volume's, for the kernel of these settings.
    pub fn is_of(&self, volume: &Arc<Volume>, settings: &RenderSettings<SheetSettings>) -> bool {
        let same = self.kernel == settings.method.kernel && self.prefilter == interpolates(settings);
        let is_long = || (0..self.own.len()).any(|number| LongLevel::of(&self.own, number).is_some());
        let refines = self.refines == refine::applies(settings) || !is_long();
        let (own, _) = self.own[0].of();
        same && refines && std::ptr::addr_eq(Arc::as_ptr(own), Arc::as_ptr(&volume.source()))
    }

    /// Memory held, bytes, the samples included.
    pub fn bytes(&self) -> usize {
        let own = self.own[0].of().0.bytes();
        let samples = own + self.made().map(|made| made.of().0.bytes()).sum::<usize>();
        let means = |level: &Level| level.means.as_ref().map_or(0, ClassifiedMeans::bytes);
        let levels = self.levels.iter().flatten();
        samples
            + levels
                .map(|level| level.field.bytes() + means(level))
                .sum::<usize>()
    }

    /// The samples of a level, or of the last one that can be made.
    ///
    /// # Errors
    /// Samples that cannot be read.
    fn source(&mut self, level: usize) -> Result<SourceLevel, SceneError> {
        while self.sources.len() <= level {
            let number = self.sources.len();
            let (before, made) = match self.own.get(number) {
                Some(own) => match LongLevel::of(&self.own, number).filter(|_| self.refines) {
                    Some(long) => {
                        survey(own, &AtomicBool::new(false))?;
                        (own, long.refined())
                    }
                    None => (own, Ok(own.clone())),
                },
                None => {
                    let last = &self.sources[number - 1];
                    survey(last, &AtomicBool::new(false))?;
                    let half = match last.chunks().filter(|_| !fits_halved(last)) {
                        Some(chunks) => mip::half_in_chunks((last, number), chunks),
                        None => mip::half(last).map(|half| Arc::new(half).into()),
                    };
                    (last, half)
                }
            };
            let next = match made {
                Ok(made) => made,
                Err(error @ SceneError::Source { .. }) => return Err(error),
                Err(_) => before.clone(),
            };
            self.sources.push(next);
            self.levels.push(None);
        }
        Ok(self.sources[level].clone())
    }

    /// Levels that are not the source's own, the finest first.
    fn made(&self) -> impl Iterator<Item = &SourceLevel> {
        let source = |level: &SourceLevel| Arc::clone(level.of().0);
        let own = source(&self.own[0]);
        // One that could not be made repeats the one before.
        let is_new = move |n: usize| {
            let level = source(&self.sources[n]);
            !Arc::ptr_eq(&level, &own) && (n == 0 || !Arc::ptr_eq(&level, self.sources[n - 1].of().0))
        };
        (0..self.sources.len())
            .filter(move |&n| is_new(n))
            .map(|n| &self.sources[n])
    }

    /// Grid of a level, or of the last one that can be made.
    ///
    /// # Errors
    /// As [`Pyramid::classify`].
    pub fn grid(&mut self, level: usize) -> Result<Grid, SceneError> {
        Ok(self.source(level)?.grid().clone())
    }

    /// A level, updated for a look.
    ///
    /// # Errors
    /// `stop`, set meanwhile, and samples that cannot be read; the level is forgotten then, for it may be half done.
    pub fn classify(
        &mut self,
        level: usize,
        look: VolumeLook<'_>,
        wanted: Wanted,
        stop: &AtomicBool,
    ) -> Result<&mut Level, SceneError> {
        let finest = self.finest();
        if wanted == Wanted::Classified && level > finest {
            if self.source(level)?.chunks().is_some() {
                return Err(MEANS_OF_CHUNKS);
            }
            self.own_level(finest, look, wanted, stop)?;
            self.own_level(level, look, wanted, stop)?;
            self.average((finest, level), look.labels, stop)?;
            return self.levels[level].as_mut().ok_or(SceneError::Stopped);
        }
        self.own_level(level, look, wanted, stop)
    }

    /// Levels that follow each other from this one on, all of them updated.
    ///
    /// # Errors
    /// As [`Pyramid::classify`].
    pub fn classify_all<const N: usize>(
        &mut self,
        first: usize,
        look: VolumeLook<'_>,
        wanted: Wanted,
        stop: &AtomicBool,
    ) -> Result<[&mut Level; N], SceneError> {
        for level in first..first + N {
            self.classify(level, look, wanted, stop)?;
        }
        // Nothing is allocated here: viewers render frame after frame.
        let mut made = self.levels[first..first + N].iter_mut().flatten();
        let all: [_; N] = std::array::from_fn(|_| made.next());
        match all.iter().all(Option::is_some) {
            true => Ok(all.map(|level| level.expect("a level that was classified is there"))),
            false => Err(SceneError::Stopped),
        }
    }

    /// The coarsest level that the source has itself: all further ones are made of it.
    fn finest(&self) -> usize {
        self.own.len() - 1
    }

    /// Replaces the classes of a level's samples by means of those of another, unless that was done before.
    fn average(
        &mut self,
        (finest, level): (usize, usize),
        labels: bool,
        stop: &AtomicBool,
    ) -> Result<(), SceneError> {
        let (finer, coarser) = self.levels.split_at_mut(level);
        if let (Some(finest), Some(level)) = (&finer[finest], &mut coarser[0])
            && level.means.is_none()
        {
            let (visible, means) = ClassifiedMeans::new(finest, &level.field, (labels, stop))?;
            level.visible = visible;
            level.means = Some(means);
        }
        Ok(())
    }

    /// A level of its own samples, updated for a look.
    fn own_level(
        &mut self,
        level: usize,
        look: VolumeLook<'_>,
        wanted: Wanted,
        stop: &AtomicBool,
    ) -> Result<&mut Level, SceneError> {
        let source = self.source(level)?;
        survey(&source, stop)?;
        let slot = &mut self.levels[level];
        match slot.as_mut() {
            Some(level) => level.update(look, wanted, stop),
            None => {
                let method = (self.kernel.into(), self.prefilter);
                *slot = Some(Level::new(source, method, look, (wanted, stop)));
            }
        }
        let failure = slot.as_ref().and_then(|level| level.field.failure());
        if failure.is_some() || stop.load(Ordering::Relaxed) {
            *slot = None;
        }
        slot.as_mut().ok_or(failure.unwrap_or(SceneError::Stopped))
    }

    /// Forgets the levels whose samples could not be read.
    pub fn forget_failed(&mut self) {
        for slot in &mut self.levels {
            slot.take_if(|level| level.field.failure().is_some());
        }
    }
}

/// Share of a budget that a half of a level in chunks, and what is derived from it, may take.
const HALF_SHARE: u64 = 4;
/// Bytes that a sample of such a half takes: itself, and its coefficient.
const HALF_BYTES: u64 = 6;

/// Whether a half of a level in chunks is made in memory.
fn fits_halved(level: &SourceLevel) -> bool {
    let bytes = level.grid().sample_count() as u64 / 8 * HALF_BYTES;
    level
        .chunks()
        .is_none_or(|chunks| bytes <= chunks.budget().limit() / HALF_SHARE)
}

/// Of classified voxels, means are of all voxels of the volume, and in memory.
const MEANS_OF_CHUNKS: SceneError = SceneError::Combination {
    what: "voxels that are classified first, of a volume without the level of detail that this picture needs",
    why: "the level's classes are made in memory, and take more than a quarter of it; convert the volume to .ome.zarr, which has all levels",
};

/// Blends a share of another frame in; depths are weighted by opacity.
pub fn blend(frame: &mut Frame, other: &Frame, share: f32) {
    let mix = |a: f32, b: f32| a + (b - a) * share;
    for (depth, (b, (own, others))) in frame.depth.iter_mut().zip(
        other
            .depth
            .iter()
            .zip(frame.image.pixels.iter().zip(&other.image.pixels)),
    ) {
        let (own, others) = (own[3] * (1.0 - share), others[3] * share);
        let sum = |depth: f32, alpha: f32| if alpha > 0.0 { depth * alpha } else { 0.0 };
        *depth = if own + others > 0.0 {
            (sum(*depth, own) + sum(*b, others)) / (own + others)
        } else {
            f32::INFINITY
        };
    }
    for (a, b) in frame.image.pixels.iter_mut().zip(&other.image.pixels) {
        for (a, b) in a.iter_mut().zip(b) {
            *a = mix(*a, *b);
        }
    }
    for (a, b) in frame.optical_depth.iter_mut().zip(&other.optical_depth) {
        *a = mix(*a, *b);
    }
}
