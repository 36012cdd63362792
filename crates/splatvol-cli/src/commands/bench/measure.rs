//! Rendering frame after frame with one renderer, and timing it.

use std::time::{Duration, Instant};

use serde::Serialize;
use splatvol::{
    Camera, Content, Control, EngineChoice, EngineConfig, Frame, OpacityPoint, RenderSettings,
    RenderStatistics, Renderer, Scene, SceneError, TransferFunction,
};
use splatvol_document::orbited;

use super::process;
use crate::failure::{During, Failure, Step};

/// How often and from where.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Course {
    /// Measured frames, at least 1.
    pub(super) frames: u32,
    /// Frames before them.
    pub(super) warm_up: u32,
    /// Turn of the camera per frame, degrees; the first measured frame is not turned.
    #[serde(rename = "orbit_degrees")]
    pub(super) orbit: f64,
    /// Slide of the opacities per frame, percent of the data's range; the first measured frame's are those asked for.
    #[serde(rename = "slide_percent")]
    pub(super) slide: f64,
}

/// Subject of a case.
pub(super) struct Subject {
    pub(super) scene: Scene,
    /// Of the first measured frame: one, or those of the pictures of which it is the mean.
    pub(super) cameras: Vec<Camera>,
    pub(super) settings: RenderSettings,
    pub(super) threads: usize,
    pub(super) engine: EngineChoice,
}

/// Times of a case.
pub(super) struct Measured {
    /// Wall clock per frame, milliseconds.
    pub(super) wall_ms: Vec<f64>,
    /// Processor time of the process per frame, milliseconds; absent if the system does not report it.
    pub(super) cpu_ms: Option<Vec<f64>>,
    /// Statistics of the frame whose wall-clock time is the median.
    pub(super) statistics: RenderStatistics,
    /// The first measured frame.
    pub(super) first: Frame,
}

/// Renders all frames of a case; `progress` gets the finished share.
pub(super) fn measure(
    subject: &Subject,
    course: &Course,
    progress: &dyn Fn(f64),
) -> Result<Measured, Failure> {
    let config = EngineConfig {
        threads: Some(subject.threads),
        ..EngineConfig::default()
    };
    let mut renderer = Renderer::start(subject.engine, config).during(Step::Render)?;
    let all = f64::from(course.warm_up) + f64::from(course.frames);
    let mut done = 0.0;
    let mut next = || -> Result<_, Failure> {
        let place = done - f64::from(course.warm_up);
        let edited = match course.slide {
            0.0 => None,
            slide => Some(slid(&subject.scene, 0.01 * place * slide).during(Step::Render)?),
        };
        let scene = edited.as_ref().unwrap_or(&subject.scene);
        let timed = timed_frame(&mut renderer, (scene, subject), place * course.orbit)?;
        done += 1.0;
        progress(done / all);
        Ok(timed)
    };
    for _ in 0..course.warm_up {
        next()?;
    }
    let (first, times) = next()?;
    let mut frames = vec![times];
    for _ in 1..course.frames {
        frames.push(next()?.1);
    }
    let wall_ms: Vec<f64> = frames.iter().map(|times| times.wall_ms).collect();
    let cpu_ms = frames.iter().map(|times| times.cpu_ms).collect();
    let statistics = frames.swap_remove(median_index(&wall_ms)).statistics;
    Ok(Measured {
        wall_ms,
        cpu_ms,
        statistics,
        first,
    })
}

/// Times of a frame.
struct Times {
    wall_ms: f64,
    cpu_ms: Option<f64>,
    statistics: RenderStatistics,
}

/// The scene with the opacities of its volumes moved along the data values, by a share of their range.
fn slid(scene: &Scene, share: f64) -> Result<Scene, SceneError> {
    let mut scene = scene.clone();
    for item in &mut scene.items {
        if let Content::Volume {
            volume,
            transfer_function,
            labels: false,
            ..
        } = &mut item.content
        {
            let [low, high] = volume.value_range();
            let moved = |point: &OpacityPoint| OpacityPoint {
                value: point.value + share * (high - low),
                ..*point
            };
            *transfer_function = TransferFunction::new(
                transfer_function.colors().to_vec(),
                transfer_function.opacities().iter().map(moved).collect(),
                transfer_function.unit_distance,
            )?;
        }
    }
    Ok(scene)
}

fn timed_frame(
    renderer: &mut Renderer,
    (scene, subject): (&Scene, &Subject),
    turn: f64,
) -> Result<(Frame, Times), Failure> {
    let turned = |camera: &Camera| orbited(*camera, turn, 0.0);
    let cameras: Vec<Camera> = subject
        .cameras
        .iter()
        .map(turned)
        .collect::<Result<_, _>>()
        .during(Step::Render)?;
    let milliseconds = |time: Duration| 1e3 * time.as_secs_f64();
    let (start, cpu_before) = (Instant::now(), process::cpu_time());
    let frame = match &cameras[..] {
        [camera] => renderer.render(scene, camera, &subject.settings),
        cameras => {
            let mut mean = Frame::empty(subject.settings.size);
            let exposed = (scene, cameras, &subject.settings);
            renderer
                .expose(exposed.0, exposed.1, exposed.2, &mut mean, &Control::default())
                .map(|()| mean)
        }
    };
    let (wall, cpu_after) = (start.elapsed(), process::cpu_time());
    let cpu = cpu_after
        .zip(cpu_before)
        .map(|(after, before)| after.saturating_sub(before));
    let times = Times {
        wall_ms: milliseconds(wall),
        cpu_ms: cpu.map(milliseconds),
        statistics: renderer.statistics().clone(),
    };
    Ok((frame.during(Step::Render)?, times))
}

/// Which of the values, at least one, is the median; of an even number the larger one in the middle.
fn median_index(values: &[f64]) -> usize {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    order[values.len() / 2]
}

/// The median of at least one value; of an even number the larger one in the middle.
pub(super) fn median(values: &[f64]) -> f64 {
    values[median_index(values)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_a_measured_value() {
        assert_eq!(median(&[3.0]), 3.0);
        assert_eq!(median(&[9.0, 1.0, 5.0]), 5.0);
        assert_eq!(median_index(&[9.0, 1.0, 5.0, 2.0]), 2);
    }
}
