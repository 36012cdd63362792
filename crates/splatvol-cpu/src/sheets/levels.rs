//! Levels of detail of a single volume: one, two that are blended, or several behind each other.
//!
//! Levels behind each other ([`splatvol_core::level::by_depth`]) are passes over the tiles, nearest first: of a level, then of two that lie side
//! by side as one fades into the next. A pass composites its intervals on the canvases that the passes before it left, and
//! skips the pixels that those finished. So two levels at most are in memory at once, and what near voxels hide is neither
//! read nor splatted. Only composited pictures have them: the largest value of a ray, its mean and its integral are of
//! one level.

use splatvol_core::clock::Instant;
use splatvol_core::engine::{RenderStatistics, Task};
use splatvol_core::level::{Detail, Wanted, blend};
use splatvol_core::plan::Segment;
use splatvol_core::refine::finest_grid;
use splatvol_scene::{Camera, Frame, Gradient, RenderSettings, SceneError, SheetSettings, Shows, Volume};

use super::engine::{SheetEngine, sampling};
use crate::route::VolumeScene;
use crate::run::{Pass, Run};

/// A camera, and how it looks.
type Shot<'a> = (&'a Camera, &'a RenderSettings<SheetSettings>);

/// Level of detail of a volume.
pub(super) fn detail(volume: &Volume, (camera, settings): Shot<'_>) -> Detail {
    match has_levels(settings) {
        true => Detail::new(
            &finest_grid(volume, settings),
            camera,
            (settings.size, settings.method.level_bias),
        ),
        false => Detail::FINEST,
    }
}

/// Whether pictures have levels of detail. Analytic gradients show the field as it is.
fn has_levels(settings: &RenderSettings<SheetSettings>) -> bool {
    Wanted::of(settings) == Wanted::Classified || settings.method.gradient != Gradient::Analytic
}

impl SheetEngine {
    /// Renders into a frame of the settings' size.
    ///
    /// # Errors
    /// A cancelled picture, or samples that cannot be read.
    pub(crate) fn render(
        &mut self,
        run: Run<'_>,
        scene: &VolumeScene<'_>,
        shot: Shot<'_>,
        frame: &mut Frame,
    ) -> Result<RenderStatistics, SceneError> {
        let start = Instant::now();
        let mut statistics = RenderStatistics {
            threads: run.pool.current_num_threads(),
            engine: "sheets",
            simd: run.instructions.name(),
            ..RenderStatistics::default()
        };
        run.pool.install(|| {
            let segments = self.segments(scene, shot)?;
            let target = (frame, &mut statistics);
            match segments.is_empty() {
                true => self.blended(run, scene, shot, target),
                false => self.behind_each_other(run, scene, (shot, &segments), target),
            }
        })?;
        statistics.seconds.total = start.elapsed().as_secs_f64();
        Ok(statistics)
    }

    /// The parts of the rays that levels show, behind each other; none where one level is enough.
    fn segments(
        &mut self,
        scene: &VolumeScene<'_>,
        (camera, settings): Shot<'_>,
    ) -> Result<Vec<Segment>, SceneError> {
        let composites = matches!(settings.method.shows, Shows::Material(_));
        // Lit faces of clips are found along the whole ray.
        if !composites || !scene.effects.clips.is_empty() || !has_levels(settings) {
            return Ok(Vec::new());
        }
        let [pyramid, ..] = self.prepared.of_scene(std::iter::once(&scene.volume), settings) else {
            return Ok(Vec::new());
        };
        pyramid.segments(&scene.volume, (camera, settings), sampling(settings))
    }

    /// Renders levels behind each other, nearest first.
    fn behind_each_other(
        &mut self,
        run: Run<'_>,
        scene: &VolumeScene<'_>,
        (shot, segments): (Shot<'_>, &[Segment]),
        (frame, statistics): (&mut Frame, &mut RenderStatistics),
    ) -> Result<(), SceneError> {
        statistics.level = segments[0].level;
        statistics.levels = 1 + segments[segments.len() - 1].level - segments[0].level;
        for (at, Segment { level, view, next }) in segments.iter().enumerate() {
            let share = |done: f64| (run.task.progress)((at as f64 + done) / segments.len() as f64);
            let run = Run {
                task: Task {
                    progress: &share,
                    ..run.task
                },
                pass: Pass {
                    is_first: at == 0,
                    is_last: at + 1 == segments.len(),
                },
                ..run
            };
            let target = (&mut *frame, &mut *statistics);
            match next {
                None => self.levels(run, scene, shot, (*level, Some([view]), None), target)?,
                Some((next, ramp)) => {
                    let both = (*level, Some([view, next]), Some(*ramp));
                    self.levels(run, scene, shot, both, target)?;
                }
            }
        }
        Ok(())
    }

    /// Renders one level, and a share of the next where levels change.
    fn blended(
        &mut self,
        run: Run<'_>,
        scene: &VolumeScene<'_>,
        shot: Shot<'_>,
        (frame, statistics): (&mut Frame, &mut RenderStatistics),
    ) -> Result<(), SceneError> {
        let detail = detail(&scene.volume, shot);
        statistics.level = detail.level;
        statistics.levels = 1 + usize::from(detail.coarser > 0.0);
        // The coarser level has a quarter of the pixels' voxels to splat.
        let finest_share = if detail.coarser > 0.0 { 0.75 } else { 1.0 };
        let finest = |done: f64| (run.task.progress)(finest_share * done);
        let coarser_share = |done: f64| (run.task.progress)(finest_share + (1.0 - finest_share) * done);
        let task = Task {
            progress: &finest,
            ..run.task
        };
        let own = (&mut *frame, &mut *statistics);
        let level = (detail.level, None::<[_; 1]>, None);
        self.levels(Run { task, ..run }, scene, shot, level, own)?;
        if detail.coarser > 0.0 {
            let mut coarser = self.coarser.take().unwrap_or_else(|| frame.clone());
            if coarser.image.size() != frame.image.size() {
                coarser = frame.clone();
            }
            let task = run.task.unseen(&coarser_share);
            let next = (&mut coarser, statistics);
            let level = (detail.level + 1, None::<[_; 1]>, None);
            self.levels(Run { task, ..run }, scene, shot, level, next)?;
            blend(frame, &coarser, detail.coarser);
            run.task.show_all(frame);
            self.coarser = Some(coarser);
        }
        Ok(())
    }
}
