//! Determinism: identical bytes for any number of threads, any size of tiles and any instructions, frame after frame.

mod cases;

use crate::common::settings;
use cases::{Case, cases};
use splatvol::{
    Camera, Classification, Compositing, EngineConfig, FlatSettings, Frame, ImageSize, Projection,
    RenderSettings, Renderer, Scene, SimdLevel, View,
};
use splatvol_samples::{Sample, SampleSize};
use splatvol_testing::checked;

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
        checked(FlatSettings {
            classification: Classification::Pre,
            ..base.into()
        }),
        checked(FlatSettings {
            compositing: Compositing::Xray,
            ..base.into()
        }),
        checked(FlatSettings {
            compositing: Compositing::Mip,
            ..base.into()
        }),
        checked(FlatSettings {
            compositing: Compositing::MinimumIntensity,
            ..base.into()
        }),
        checked(FlatSettings {
            compositing: Compositing::Mean,
            ..base.into()
        }),
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

/// Every case's picture by an engine of its own configuration.
fn demand(cases: &[Case], expected: &[Vec<u32>], config: EngineConfig) {
    let mut renderer = Renderer::new(config).unwrap();
    for (case, expected) in cases.iter().zip(expected) {
        let found = bits(&case.frame(&mut renderer));
        let apart = found.iter().zip(expected).filter(|(a, b)| a != b).count();
        assert!(
            found == *expected,
            "{config:?}, {}: {apart} of {} numbers differ",
            case.name,
            expected.len()
        );
    }
}

/// Threads, tiles and instructions: the same bytes of every kind of scene.
#[test]
fn no_configuration_changes_a_bit_of_any_kind_of_picture() {
    let cases = cases();
    let one = EngineConfig {
        threads: Some(1),
        ..EngineConfig::default()
    };
    let mut renderer = Renderer::new(one).unwrap();
    let expected: Vec<_> = cases
        .iter()
        .map(|case| bits(&case.frame(&mut renderer)))
        .collect();
    for (case, bits) in cases.iter().zip(&expected) {
        assert!(
            bits.iter().any(|bits| *bits != 0),
            "{}: nothing is seen",
            case.name
        );
    }
    let [baseline, avx2, avx512] = [SimdLevel::Baseline, SimdLevel::Avx2, SimdLevel::Avx512]
        .map(|simd| simd.is_available().then_some(simd));
    println!("instructions: {baseline:?}, {avx2:?}, {avx512:?}");
    for (threads, edge, simd) in [
        (1, 16, baseline),
        (2, 48, avx2),
        (7, 32, avx512),
        (2, 64, baseline),
    ] {
        let config = EngineConfig {
            threads: Some(threads),
            tile_edge: Some(edge),
            simd,
            ..EngineConfig::default()
        };
        demand(&cases, &expected, config);
    }
}

#[test]
fn what_a_renderer_keeps_between_frames_does_not_show() {
    let scene = head();
    let projection = Projection::Orthographic { height: 1.0 };
    let camera = Camera::framing(&scene.bounds().unwrap(), View::Front, projection, 1.47).unwrap();
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
    let camera = Camera::framing(&scene.bounds().unwrap(), View::Front, projection, 1.0).unwrap();
    let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
    let wrong = checked(FlatSettings {
        sheet_thickness: 0.0,
        ..settings(16).into()
    });
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
