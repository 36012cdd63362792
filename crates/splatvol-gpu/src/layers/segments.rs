//! Segments: levels of a volume behind each other in one picture, as `splatvol_cpu::sheets::levels` has them.
//!
//! Each segment adds its intervals behind what the canvas has: a level, or two of them side by side, whose shares of their
//! extinctions change from interval to interval.

use splatvol_core::engine::{RenderStatistics, Shot, Task};
use splatvol_core::level::{Level, Wanted};
use splatvol_core::plan::{Ramp, Rays, Segment};
use splatvol_scene::{Frame, SceneError, Shows};

use super::ready::{count, finish, memory_of, restrict};
use super::{Layer, LayerStore, Passes, Surface};
use crate::atlas::Assembler;
use crate::gather::Gather;
use crate::layout::FrameData;
use crate::march::March;
use crate::shown::{Placed, Shown};

impl LayerStore {
    /// The segments of a scene of one volume, nearest first; none where one level is enough.
    ///
    /// # Errors
    /// Samples that cannot be read.
    pub(crate) fn segments(
        &mut self,
        shot: &Shot<'_>,
        placed: &Placed<'_>,
    ) -> Result<Vec<Segment>, SceneError> {
        let [own] = &placed.shown[..] else {
            return Ok(Vec::new());
        };
        let composites = matches!(own.settings.method.shows, Shows::Material(_));
        // Lit faces of clips are found along the whole ray.
        if placed.has_clouds() || !composites || own.effects.bodies > 0 || !own.has_levels() {
            return Ok(Vec::new());
        }
        match self
            .prepared
            .of_scene(std::iter::once(&own.volume), &own.settings)
        {
            [pyramid] => pyramid.segments(&own.volume, (shot.camera, &own.settings), own.sampling()),
            _ => Ok(Vec::new()),
        }
    }

    /// Renders the segments of a scene of one volume.
    ///
    /// # Errors
    /// A stopped picture, samples that cannot be read, or a device that fails.
    pub(crate) async fn behind_each_other(
        &mut self,
        (shot, placed): (&Shot<'_>, &Placed<'_>),
        segments: &[Segment],
        (mut surface, frame, task): (Surface<'_>, &mut Frame, Task<'_>),
        statistics: &mut RenderStatistics,
    ) -> Result<(), SceneError> {
        surface.canvas.clear(surface.gpu, &surface.pipelines.clear)?;
        for (at, segment) in segments.iter().enumerate() {
            task.go_on()?;
            let share = |done: f64| (task.progress)((at as f64 + done) / segments.len() as f64);
            let part = Task {
                progress: &share,
                ..task
            };
            self.add(
                (shot, &placed.shown[0]),
                segment,
                (&mut surface, part),
                statistics,
            )?;
        }
        surface.canvas.resolve(surface.gpu, frame, 0.0).await
    }

    /// Adds a segment behind what the canvas has.
    fn add(
        &mut self,
        (shot, own): (&Shot<'_>, &Shown<'_>),
        Segment { level, view, next }: &Segment,
        (surface, task): (&mut Surface<'_>, Task<'_>),
        statistics: &mut RenderStatistics,
    ) -> Result<(), SceneError> {
        let look = own.look();
        let wanted = Wanted::of(&own.settings);
        let pyramids = self
            .prepared
            .of_scene(std::iter::once(&own.volume), &own.settings);
        let levels: Vec<usize> = (*level..level + 1 + usize::from(next.is_some())).collect();
        let of_chunks = memory_of((own, *level..level + levels.len()), &mut pyramids[0], 1)?;
        let mut classified: Vec<&mut Level> = match next {
            None => vec![pyramids[0].classify(*level, look, wanted, task.stop)?],
            Some(_) => pyramids[0]
                .classify_all::<2>(*level, look, wanted, task.stop)?
                .into(),
        };
        let views = std::iter::once(view).chain(next.as_ref().map(|(view, _)| view));
        for (level, view) in classified.iter_mut().zip(views.clone()) {
            restrict((level, of_chunks.as_ref()), view, &own.settings)?;
        }
        let classified: Vec<&Level> = classified.into_iter().map(|level| &*level).collect();
        for level in &classified {
            count(own, level, statistics);
        }
        let Surface {
            gpu,
            pipelines,
            canvas,
        } = surface;
        let shown = vec![own; levels.len()];
        let assembler = Assembler {
            gpu,
            pass: &pipelines.assemble,
            task: task.unseen(&|_| {}),
        };
        let at = self.on_device.reside(assembler, (&shown, &levels), &classified)?;
        let layers: Vec<Layer<'_>> = views
            .zip(classified.iter().zip(&at))
            .map(|(view, (level, &at))| Layer {
                shown: own,
                level,
                view,
                resident: &self.on_device.resident[at],
            })
            .collect();
        let passes: Vec<Passes> = layers
            .iter()
            .map(|layer| layer.passes(gpu, pipelines, next.is_some()))
            .collect::<Result<_, _>>()?;
        let mixture = match next {
            None => None,
            Some(_) => Some(pipelines.mixture(gpu)?),
        };
        let shared = (*gpu, &**pipelines, *canvas);
        let mut marches: Vec<March<'_>> = layers
            .iter()
            .zip(&passes)
            .map(|(layer, passes)| layer.march(shared, passes))
            .collect();
        statistics.sheets += view.end_shown() - view.first_shown();
        let (Some((_, ramp)), Some(mixture)) = (next, mixture) else {
            marches[0].add(task)?;
            return finish((&classified, of_chunks.as_ref()), statistics);
        };
        fade(&mut marches, *ramp);
        let rays = Rays::new(&shot.camera.screen_from_camera(own.settings.size));
        let mut both = Gather {
            gpu,
            canvas,
            data: FrameData::seen(&own.settings, &rays),
            volumes: &marches,
            clouds: Vec::new(),
            mixture: &mixture,
            clear: &shared.1.clear,
        };
        both.add(task)?;
        finish((&classified, of_chunks.as_ref()), statistics)
    }
}

/// Lets the first of two levels fade into the second.
fn fade(marches: &mut [March<'_>], ramp: Ramp) {
    let step = ramp.share(ramp.first + 1) - ramp.share(ramp.first);
    for (march, is_next) in marches.iter_mut().zip([false, true]) {
        let next = ramp.share(march.picture.first_plane());
        march.share = match is_next {
            false => [1.0 - next, -step],
            true => [next, step],
        };
    }
}
