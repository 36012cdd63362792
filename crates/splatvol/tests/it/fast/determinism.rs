//! Determinism: identical bytes for any number of threads, any size of tiles and any instructions.

use splatvol::{Camera, EngineConfig, Frame, Projection, RenderSettings, Renderer, Scene, SimdLevel};
use splatvol_samples::Sample;

use super::by_depth;
use super::slices::{slices, tilted};
use super::support::{bits, fast, framing, generated, name_of, noise, opaque, rendered};
use crate::common::PROJECTIONS;

struct View {
    name: String,
    scene: Scene,
    camera: Camera,
    settings: RenderSettings,
}

/// Two volumes, opaque and translucent, in both projections: whole, close, and so far that two levels are blended;
/// long voxels, and several levels behind each other.
fn views() -> Vec<View> {
    let mut views = Vec::new();
    for (name, translucent) in [("shells", generated(Sample::Shells, 48)), ("noise", noise())] {
        let looks = [("opaque", opaque(&translucent)), ("translucent", translucent)];
        for (look, scene) in looks {
            for projection in PROJECTIONS {
                // Nearer than this a perspective camera's footprints differ too much in size for one raster.
                let close = if matches!(projection, Projection::Perspective { .. }) {
                    1.3
                } else {
                    2.5
                };
                for zoom in [0.34, 1.0, close] {
                    views.push(View {
                        name: format!("{name}-{look}-{}-{zoom}", name_of(projection)),
                        camera: framing(&scene, projection, SIZE[0] as f64 / SIZE[1] as f64, zoom),
                        scene: scene.clone(),
                        settings: settings(),
                    });
                }
            }
        }
    }
    for (angle, is_perspective) in [(30.0, true), (55.0, false)] {
        let scene = slices(7.0);
        views.push(View {
            name: format!("slices-{angle}"),
            camera: tilted(&scene, angle, is_perspective),
            scene,
            settings: settings(),
        });
    }
    views.extend(
        by_depth::views(settings()).map(|(name, scene, camera, settings)| View {
            name,
            scene,
            camera,
            settings,
        }),
    );
    views
}

/// Neither is a multiple of any tile's edge.
const SIZE: [u32; 2] = [168, 136];

fn settings() -> RenderSettings {
    fast(SIZE[0], SIZE[1])
}

/// Largest difference of a channel, and how many pixels differ at all.
fn difference(a: &Frame, b: &Frame) -> (f32, usize) {
    let pairs = a.image.pixels.iter().zip(&b.image.pixels);
    let apart = |(a, b): (&[f32; 4], &[f32; 4])| (0..4).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
    pairs.map(apart).fold((0.0, 0), |(most, count), d| {
        (most.max(d), count + usize::from(d > 0.0))
    })
}

fn frames(config: EngineConfig, views: &[View]) -> Vec<Frame> {
    let mut renderer = Renderer::new(config).unwrap();
    let frame = |view: &View| rendered(&mut renderer, &view.scene, &view.camera, &view.settings).0;
    views.iter().map(frame).collect()
}

/// Frames of this configuration must be those expected, to the bit.
fn demand(config: EngineConfig, views: &[View], expected: &[Frame]) {
    for ((view, expected), found) in views.iter().zip(expected).zip(frames(config, views)) {
        let (most, count) = difference(&found, expected);
        assert!(
            bits(&found) == bits(expected),
            "{config:?} {}: {count} pixels differ, by up to {most:.2e}",
            view.name
        );
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let views = views();
    let threads = |threads| EngineConfig {
        threads: Some(threads),
        ..EngineConfig::default()
    };
    let expected = frames(threads(1), &views);
    for count in [2, 7] {
        demand(threads(count), &views, &expected);
    }
}

#[test]
fn tiles_do_not_change_a_bit() {
    let views = views();
    let expected = frames(EngineConfig::default(), &views);
    for edge in [16, 32, 48, 64] {
        let config = EngineConfig {
            tile_edge: Some(edge),
            ..EngineConfig::default()
        };
        demand(config, &views, &expected);
    }
}

/// Multiplications and additions are not fused, because not all processors can do so.
#[test]
fn instructions_do_not_change_a_bit() {
    let views = views();
    let expected = frames(EngineConfig::default(), &views);
    for simd in SimdLevel::ALL {
        if !simd.is_available() {
            splatvol_recorded::skip(&format!("this processor has no {simd:?}"));
            continue;
        }
        let config = EngineConfig {
            simd: Some(simd),
            ..EngineConfig::default()
        };
        demand(config, &views, &expected);
    }
}
