//! The same bytes for any number of threads and any size of tiles, frame after frame.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

mod common;

use common::settings;
use splatvol::{
    Camera, Classification, Compositing, EngineConfig, Frame, ImageSize, Projection, RenderSettings,
    Renderer, Scene, View,
};
use splatvol_samples::{Sample, SampleSize};

fn head() -> Scene {
    let volume = Sample::Head.generate(Some(SampleSize::Longest(48))).unwrap();
    Scene::new(volume, Sample::Head.default_transfer_function().unwrap())
}

fn variants() -> Vec<RenderSettings> {
    let base = RenderSettings {
        size: ImageSize::new(200, 136).unwrap(),
        ..settings(1)
    };
    vec![
        base,
        RenderSettings {
            classification: Classification::Pre,
            ..base
        },
        RenderSettings {
            compositing: Compositing::Xray,
            ..base
        },
        RenderSettings {
            compositing: Compositing::Mip,
            ..base
        },
        RenderSettings {
            compositing: Compositing::MinimumIntensity,
            ..base
        },
        RenderSettings {
            compositing: Compositing::Mean,
            ..base
        },
    ]
}

fn bits(frame: &Frame) -> Vec<u32> {
    let colors = frame.image.pixels.iter().flatten();
    colors
        .chain(&frame.depth)
        .chain(&frame.optical_depth)
        .map(|value| value.to_bits())
        .collect()
}

fn frames(config: EngineConfig) -> Vec<Vec<u32>> {
    let scene = head();
    let mut renderer = Renderer::new(config).unwrap();
    let projection = Projection::Perspective { fov_degrees: 25.0 };
    let camera = Camera::framing(&scene.volume.grid().bounds(), View::Iso, projection, 1.47).unwrap();
    variants()
        .iter()
        .map(|settings| bits(&renderer.render(&scene, &camera, settings).unwrap()))
        .collect()
}

#[test]
fn threads_and_tiles_do_not_change_a_bit() {
    let expected = frames(EngineConfig {
        threads: Some(1),
        ..EngineConfig::default()
    });
    for threads in [2, 7] {
        let config = EngineConfig {
            threads: Some(threads),
            ..EngineConfig::default()
        };
        assert!(frames(config) == expected, "{threads} threads");
    }
    for edge in [16, 32, 48] {
        let config = EngineConfig {
            tile_edge: Some(edge),
            ..EngineConfig::default()
        };
        assert!(frames(config) == expected, "tiles of {edge} pixels");
    }
}

#[test]
fn what_a_renderer_keeps_between_frames_does_not_show() {
    let scene = head();
    let projection = Projection::Orthographic { height: 1.0 };
    let camera = Camera::framing(&scene.volume.grid().bounds(), View::Front, projection, 1.47).unwrap();
    let mut kept = Renderer::new(EngineConfig::default()).unwrap();
    for _ in 0..2 {
        for settings in variants() {
            let mut fresh = Renderer::new(EngineConfig::default()).unwrap();
            let (a, b) = (
                kept.render(&scene, &camera, &settings),
                fresh.render(&scene, &camera, &settings),
            );
            assert_eq!(bits(&a.unwrap()), bits(&b.unwrap()), "{settings:?}");
        }
    }
}

#[test]
fn settings_outside_their_domain_are_refused_by_name() {
    let scene = head();
    let projection = Projection::Orthographic { height: 1.0 };
    let camera = Camera::framing(&scene.volume.grid().bounds(), View::Front, projection, 1.0).unwrap();
    let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
    let mut wrong = settings(16);
    wrong.sheet_thickness = 0.0;
    let error = renderer.render(&scene, &camera, &wrong).unwrap_err().to_string();
    assert!(
        error.starts_with("sheet thickness: 0.0 is not allowed"),
        "{error}"
    );
    assert!(
        Renderer::new(EngineConfig {
            tile_edge: Some(20),
            ..EngineConfig::default()
        })
        .is_err()
    );
}
