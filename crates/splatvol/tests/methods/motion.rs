//! Motion blur of footprints against the mean of many pictures.

use glam::DVec3;
use splatvol::{
    Alignment, Camera, Classification, Compositing, Filter, Frame, MotionBlur, Projection, RenderSettings,
    Scene, TransferFunction,
};
use splatvol_samples::{Sample, SampleSize};
use splatvol_testing::Comparison;

use crate::common::{self, PROJECTIONS};
use crate::support::{bits, framing, generated, name_of, noise, translucent};

fn settings(pixels: u32, motion_blur: MotionBlur) -> RenderSettings {
    RenderSettings {
        classification: Classification::Pre,
        filter: Filter::None,
        termination: 0.0,
        motion_blur,
        ..common::settings(pixels)
    }
}

/// The scene, of which a look through all of it keeps more than half of the light.
fn faint(scene: Scene) -> Scene {
    let mut look: TransferFunction = translucent();
    look.unit_distance = Some(60.0 * scene.volume.grid().mean_spacing());
    Scene {
        transfer_function: look,
        ..scene
    }
}

fn scenes() -> [(&'static str, Scene); 2] {
    let ball = Sample::Ball.generate(Some(SampleSize::Longest(24))).unwrap();
    [
        ("ball", faint(Scene::new(ball, translucent()))),
        ("noise", faint(noise())),
    ]
}

fn centre(scene: &Scene) -> DVec3 {
    scene.volume.grid().bounds().centre()
}

/// A tenth of the volume's diagonal, and a sixth of a turn.
fn motions(scene: &Scene) -> [(&'static str, splatvol::Motion); 2] {
    let far = 0.1 * scene.volume.grid().bounds().diagonal();
    [
        (
            "linear",
            splatvol::Motion::Linear(far * DVec3::new(0.6, 0.3, -0.74)),
        ),
        (
            "spin",
            splatvol::Motion::Spin {
                axis: DVec3::new(0.2, 0.1, 1.0),
                centre: centre(scene),
                angle: 20_f64.to_radians(),
            },
        ),
    ]
}

fn moving(scene: &Scene, motion: splatvol::Motion) -> Scene {
    Scene {
        motion: Some(motion),
        ..scene.clone()
    }
}

fn psnr(a: &Frame, b: &Frame) -> f64 {
    Comparison::of(&a.image, &b.image).psnr
}

#[test]
fn exact_blur_is_the_mean_of_256_pictures() {
    let mut failed = Vec::new();
    for (name, scene) in scenes() {
        for (kind, motion) in motions(&scene) {
            let scene = moving(&scene, motion);
            for projection in PROJECTIONS {
                let camera = framing(&scene, projection, 1.0, 0.8);
                let frame = |motion_blur| common::render(&scene, &camera, &settings(64, motion_blur));
                let mean = frame(MotionBlur::Subframes { count: 256 });
                let [exact, capsule, none] = [MotionBlur::Exact, MotionBlur::Capsule, MotionBlur::None]
                    .map(|m| psnr(&frame(m), &mean));
                println!(
                    "{name} {kind} {}: exact {exact:.1} dB, capsule {capsule:.1} dB, none {none:.1} dB",
                    name_of(projection)
                );
                if exact < 40.0 || exact < none + 6.0 || exact < capsule {
                    failed.push(format!("{name} {kind} {projection:?}: {exact:.1}"));
                }
            }
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}
