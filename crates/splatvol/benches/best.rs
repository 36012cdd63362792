//! Cost of the exact method: first pictures of `best` against those of the default, projection by projection, at 512 x
//! 512 on one thread, including the preparation of the volume.
//!
//! ```text
//! cargo bench -p splatvol --bench best
//! ```
//!
//! Medians of alternating pictures; ratios are medians of those of neighbours. Other work on the machine shows in both.
#![allow(clippy::unwrap_used, reason = "a bench")]

use splatvol::{
    Camera, Classification, Compositing, EngineConfig, FlatSettings, ImageSize, Projection, RenderSettings,
    Renderer, Scene, View,
};
use splatvol_samples::{Sample, SampleSize};
use splatvol_testing::checked;

const ROUNDS: usize = 7;
const SIDE: u32 = 512;

/// Settings of a projection, from those of a preset.
fn projections(preset: RenderSettings) -> [(&'static str, RenderSettings); 6] {
    let preset = RenderSettings {
        size: ImageSize::new(SIDE, SIDE).unwrap(),
        ..preset
    };
    let of = |compositing| {
        checked(FlatSettings {
            compositing,
            lighting: None,
            ..preset.into()
        })
    };
    let classified = |settings: RenderSettings| {
        checked(FlatSettings {
            classification: Classification::Pre,
            ..settings.into()
        })
    };
    [
        ("post-classified", preset),
        ("pre-classified", classified(preset)),
        ("X-ray", classified(of(Compositing::Xray))),
        ("maximum", of(Compositing::Mip)),
        ("minimum", of(Compositing::MinimumIntensity)),
        ("mean", of(Compositing::Mean)),
    ]
}

/// Seconds of the first picture of a renderer.
fn first_picture(scene: &Scene, camera: &Camera, settings: &RenderSettings) -> f64 {
    let config = EngineConfig {
        threads: Some(1),
        ..EngineConfig::default()
    };
    let mut renderer = Renderer::new(config).unwrap();
    renderer.render(scene, camera, settings).unwrap();
    renderer.statistics().seconds.total
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() {
    // Test runners only ask which benches there are.
    if !std::env::args().any(|argument| argument == "--bench") {
        return;
    }
    for (name, sample) in [("head", Sample::Head), ("shells", Sample::Shells)] {
        let volume = sample.generate(Some(SampleSize::Longest(128))).unwrap();
        let scene = Scene::new(volume, sample.default_transfer_function().unwrap());
        let projection = Projection::Perspective { fov_degrees: 30.0 };
        let camera = Camera::framing(&scene.bounds().unwrap(), View::Iso, projection, 1.0).unwrap();
        let of_default = projections(RenderSettings::default());
        for ((way, default), (_, best)) in of_default.into_iter().zip(projections(RenderSettings::best())) {
            let pairs: Vec<[f64; 2]> = (0..ROUNDS)
                .map(|_| [&default, &best].map(|settings| first_picture(&scene, &camera, settings)))
                .collect();
            let of = |which: usize| 1e3 * median(pairs.iter().map(|pair| pair[which]).collect());
            println!(
                "{name} 128^3, {way}: default {:.0} ms, best {:.0} ms, {:.1} times that",
                of(0),
                of(1),
                median(pairs.iter().map(|[default, best]| best / default).collect())
            );
        }
    }
}
