//! A flight of ninety frames through a head, 128^3, at 512 x 512: before its face, through an eye, within it, and out
//! again; with the default settings and with the best ones.
//!
//! ```text
//! cargo bench -p splatvol --bench flight
//! ```
//!
//! A line has the median of the frames, the slowest, and their ratio; each frame is rendered twice, and the shorter
//! time counts.
#![allow(clippy::unwrap_used, reason = "a bench")]

use glam::DVec3;
use splatvol::{Camera, EngineConfig, ImageSize, Projection, RenderSettings, Renderer, Scene};
use splatvol_samples::{Sample, SampleSize};

const FRAMES: usize = 90;

/// Share 0 lies before the face, 1 behind the head.
fn on_the_way(scene: &Scene, share: f64, fov_degrees: f64) -> Camera {
    let bounds = scene.bounds().unwrap();
    let (centre, half) = (bounds.centre(), 0.5 * (bounds.max - bounds.min));
    let position = centre + half * (DVec3::new(0.35, 0.0, 0.12) + DVec3::Y * (2.2 - 4.4 * share));
    let target = position + DVec3::new(-0.12, -1.0, -0.05);
    Camera::new(
        position,
        target,
        DVec3::Z,
        Projection::Perspective { fov_degrees },
    )
    .unwrap()
}

/// Seconds of each frame.
fn flight(scene: &Scene, settings: &RenderSettings, fov_degrees: f64) -> Vec<f64> {
    let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
    let mut once = |frame: usize| {
        let camera = on_the_way(scene, frame as f64 / (FRAMES - 1) as f64, fov_degrees);
        renderer.render(scene, &camera, settings).unwrap();
        renderer.statistics().seconds.total
    };
    // The first picture prepares the volume.
    once(0);
    (0..FRAMES).map(|frame| once(frame).min(once(frame))).collect()
}

fn main() {
    // Test runners only ask which benches there are.
    if !std::env::args().any(|argument| argument == "--bench") {
        return;
    }
    let volume = Sample::Head.generate(Some(SampleSize::Longest(128))).unwrap();
    let scene = Scene::new(volume, Sample::Head.default_transfer_function().unwrap());
    let size = ImageSize::new(512, 512).unwrap();
    for (name, settings) in [
        ("default", RenderSettings::balanced()),
        ("best", RenderSettings::best()),
    ] {
        let settings = RenderSettings { size, ..settings };
        for fov_degrees in [60.0, 90.0] {
            let mut seconds = flight(&scene, &settings, fov_degrees);
            seconds.sort_by(f64::total_cmp);
            let (median, slowest) = (seconds[FRAMES / 2], seconds[FRAMES - 1]);
            println!(
                "{name}, {fov_degrees} degrees: median {:.1} ms, slowest {:.1} ms, {:.2} times that",
                1e3 * median,
                1e3 * slowest,
                slowest / median
            );
        }
    }
}
