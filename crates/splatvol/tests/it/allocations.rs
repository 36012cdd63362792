//! Frames of the fast method allocate nothing but a name of a few bytes once two have been rendered.

use std::sync::atomic::Ordering;

use crate::common::PROJECTIONS;
use crate::counting::{BYTES, COUNT, SIZES};
use glam::DVec3;
use splatvol::{
    Camera, Classification, Compositing, EngineConfig, FlatSettings, ImageSize, RenderSettings, Renderer,
    Scene, View,
};
use splatvol_samples::{Sample, SampleSize};
use splatvol_testing::{alone, checked};

/// A camera on a circle around the volume.
fn camera(scene: &Scene, frame: usize) -> Camera {
    let framing = Camera::framing(&scene.bounds().unwrap(), View::Iso, PROJECTIONS[0], 1.0).unwrap();
    let turn = glam::DQuat::from_axis_angle(DVec3::Z, 0.05 * frame as f64);
    let target = framing.target();
    let position = target + turn * (framing.position() - target);
    Camera::new(position, target, framing.up(), framing.projection()).unwrap()
}

#[test]
fn frames_of_a_moving_camera_allocate_nothing_but_a_name() {
    alone!();
    let volume = Sample::Shells.generate(Some(SampleSize::Longest(64))).unwrap();
    let scene = Scene::new(volume, Sample::Shells.default_transfer_function().unwrap());
    let post = RenderSettings {
        size: ImageSize::new(256, 256).unwrap(),
        ..RenderSettings::fast()
    };
    let modes = [
        ("post", post),
        (
            "pre",
            checked(FlatSettings {
                classification: Classification::Pre,
                ..post.into()
            }),
        ),
        (
            "xray",
            checked(FlatSettings {
                compositing: Compositing::Xray,
                ..post.into()
            }),
        ),
        (
            "mip",
            checked(FlatSettings {
                compositing: Compositing::Mip,
                ..post.into()
            }),
        ),
        (
            "minip",
            checked(FlatSettings {
                compositing: Compositing::MinimumIntensity,
                ..post.into()
            }),
        ),
        (
            "mean",
            checked(FlatSettings {
                compositing: Compositing::Mean,
                ..post.into()
            }),
        ),
    ];
    for (mode, settings) in modes {
        demand_no_allocations(mode, &scene, &settings);
    }
}

fn demand_no_allocations(mode: &str, scene: &Scene, settings: &RenderSettings) {
    // One of several threads may find no tile left in the first two frames, and allocate its memory later.
    let config = EngineConfig {
        threads: Some(1),
        ..EngineConfig::default()
    };
    let mut renderer = Renderer::new(config).unwrap();
    let cameras: Vec<Camera> = (0..22).map(|frame| camera(scene, frame)).collect();
    let mut frame = renderer.render(scene, &cameras[0], settings).unwrap();
    assert!(
        renderer.statistics().engine == "sheets",
        "{mode}: the fast engine rendered it"
    );
    renderer
        .render_into(scene, &cameras[1], settings, &mut frame)
        .unwrap();
    let (mut counts, mut bytes) = ([0; 20], [0; 20]);
    COUNT.store(0, Ordering::Relaxed);
    BYTES.store(0, Ordering::Relaxed);
    for (i, camera) in cameras[2..].iter().enumerate() {
        renderer.render_into(scene, camera, settings, &mut frame).unwrap();
        (counts[i], bytes[i]) = (COUNT.load(Ordering::Relaxed), BYTES.load(Ordering::Relaxed));
    }
    let total = COUNT.load(Ordering::Relaxed);
    let sizes: Vec<usize> = SIZES
        .iter()
        .map(|size| size.load(Ordering::Relaxed))
        .take(total)
        .collect();
    println!("{mode}: {total} allocations; after each frame {counts:?}, {bytes:?} bytes; sizes {sizes:?}");
    // The statistics hold the instructions' name as a string of its own: one allocation per frame, of its length.
    // Nothing else may be allocated; the queue of the thread pool takes a block every 63 frames, the first before
    // these.
    let name = renderer.statistics().simd.len();
    assert!(
        total <= 20 && sizes.iter().all(|&size| size == name),
        "{mode}: allocations of bytes: {sizes:?}"
    );
}
