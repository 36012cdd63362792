//! A renderer adds shutters, sampled edges, parts and progress to any engine's pictures.

use std::sync::Mutex;

use crate::common;
use glam::DVec3;
use splatvol::{
    Camera, Control, Coverage, Engine, FlatSettings, Frame, Grid, ImageSize, LengthUnit, MemoryUse, Motion,
    MotionBlur, RenderSettings, RenderStatistics, Renderer, Rescale, Samples, Scene, SceneError, Shot, Task,
    TileRect, TransferFunction, View, Volume,
};
use splatvol_testing::checked;

/// White left of a line through the picture's middle that leans by a pixel in ten, black right of it: one sample per
/// pixel.
#[derive(Debug)]
struct Edge;

/// Position of the line in a row, share of the picture's width.
fn line(row: usize, size: [usize; 2]) -> f64 {
    0.5 + 0.1 * ((row as f64 + 0.5) - 0.5 * size[1] as f64) / size[0] as f64
}

impl Engine for Edge {
    fn check(&self, shot: Shot<'_>) -> Result<(), SceneError> {
        shot.settings.validate()
    }

    fn render(
        &mut self,
        shot: Shot<'_>,
        frame: &mut Frame,
        task: Task<'_>,
    ) -> Result<RenderStatistics, SceneError> {
        let size = <[u32; 2]>::from(shot.settings.size).map(|side| side as usize);
        for (i, pixel) in frame.image.pixels.iter_mut().enumerate() {
            let [x, y] = [i % size[0], i / size[0]];
            let own = TileRect {
                x0: x,
                y0: y,
                x1: x + 1,
                y1: y + 1,
            };
            if task.wants(&own) {
                let at = (x as f64 + 0.5) / size[0] as f64;
                *pixel = if at < line(y, size) { [1.0; 4] } else { [0.0; 4] };
            }
        }
        task.report(1.0);
        task.go_on()?;
        Ok(RenderStatistics {
            engine: "edge",
            ..RenderStatistics::default()
        })
    }

    fn memory(&self) -> MemoryUse {
        MemoryUse {
            tiles: 42,
            ..MemoryUse::default()
        }
    }
}

fn settings(coverage: Coverage) -> RenderSettings {
    RenderSettings {
        size: ImageSize::new(40, 30).unwrap(),
        coverage,
        ..RenderSettings::default()
    }
}

fn picture(settings: &RenderSettings, control: &Control<'_>) -> (Frame, RenderStatistics) {
    let mut renderer = Renderer::with_engine(Edge);
    let mut frame = Frame::empty(settings.size);
    let (scene, camera) = subject();
    renderer
        .render_with(&scene, &camera, settings, &mut frame, control)
        .expect("an engine that renders anything");
    (frame, renderer.statistics().clone())
}

fn subject() -> (Scene, Camera) {
    let grid = Grid::centred([2; 3], DVec3::ONE).unwrap();
    let samples = Samples::U8(vec![0, 0, 0, 0, 1, 1, 1, 1].into());
    let volume = Volume::new(grid, samples, Rescale::default(), LengthUnit::Unknown).unwrap();
    let camera = Camera::framing(&volume.grid().bounds(), View::Iso, common::PROJECTIONS[0], 1.0).unwrap();
    let look = TransferFunction::gray_ramp([0.0, 1.0], 0.5).unwrap();
    (Scene::new(volume, look), camera)
}

#[test]
fn edges_are_means_of_the_engine_s_samples() {
    let (plain, _) = picture(&settings(Coverage::Off), &Control::default());
    let (sampled, statistics) = picture(&settings(Coverage::ADAPTIVE), &Control::default());
    assert_eq!(statistics.engine, "edge");
    assert_eq!(statistics.memory.tiles, 42);
    assert!(statistics.sampled_pixels >= 30 && statistics.sampled_pixels < 200);
    let (mut worst_plain, mut worst_sampled) = (0.0f64, 0.0f64);
    for y in 0..30 {
        let at = 40.0 * line(y, [40, 30]);
        for x in 0..40 {
            let share = (at - x as f64).clamp(0.0, 1.0);
            let error = |frame: &Frame| (f64::from(frame.image.pixels[y * 40 + x][0]) - share).abs();
            worst_plain = worst_plain.max(error(&plain));
            worst_sampled = worst_sampled.max(error(&sampled));
        }
    }
    // A line that leans by a tenth crosses four rows of four samples with an error of an eighth and what it leans.
    assert!(
        worst_plain > 0.4 && worst_sampled < 0.18,
        "{worst_plain} {worst_sampled}"
    );
}

#[test]
fn parts_of_sampled_pictures_are_put_together_to_the_bit() {
    let settings = settings(Coverage::ADAPTIVE);
    let (whole, _) = picture(&settings, &Control::default());
    let parts = [[0, 0, 19, 30], [19, 0, 40, 13], [19, 13, 40, 30]];
    let mut together = Frame::empty(settings.size);
    for [x0, y0, x1, y1] in parts {
        let control = Control {
            part: Some(TileRect { x0, y0, x1, y1 }),
            ..Control::default()
        };
        let (part, _) = picture(&settings, &control);
        for (own, other) in together.image.pixels.iter_mut().zip(&part.image.pixels) {
            *own = std::array::from_fn(|c| own[c] + other[c]);
        }
    }
    assert_eq!(together.image.pixels, whole.image.pixels);
}

#[test]
fn a_shutter_takes_the_mean_and_progress_runs_once() {
    let (mut scene, camera) = subject();
    scene.items[0].motion = Some(Motion::Linear(DVec3::X));
    let settings = checked(FlatSettings {
        motion_blur: MotionBlur::Subframes { count: 3 },
        ..settings(Coverage::Off).into()
    });
    let heard = Mutex::new(Vec::new());
    let hear = |share: f64| heard.lock().unwrap().push(share);
    let control = Control {
        progress: Some(&hear),
        ..Control::default()
    };
    let mut frame = Frame::empty(settings.size);
    let mut renderer = Renderer::with_engine(Edge);
    renderer
        .render_with(&scene, &camera, &settings, &mut frame, &control)
        .unwrap();
    let heard = heard.into_inner().unwrap();
    assert!(heard.is_sorted() && heard.len() >= 4, "{heard:?}");
    assert_eq!((heard[0], heard[heard.len() - 1]), (0.0, 1.0));
    let (still, _) = picture(&self::settings(Coverage::Off), &Control::default());
    for (a, b) in frame.image.pixels.iter().zip(&still.image.pixels) {
        assert!((a[0] - b[0]).abs() < 1e-6);
    }
}

#[test]
fn what_an_engine_refuses_is_refused_by_its_renderer() {
    let (scene, camera) = subject();
    let wrong = checked(FlatSettings {
        sheet_thickness: -1.0,
        ..settings(Coverage::Off).into()
    });
    let error = Renderer::with_engine(Edge)
        .render(&scene, &camera, &wrong)
        .unwrap_err();
    assert!(error.to_string().starts_with("sheet thickness: -1"), "{error}");
}
