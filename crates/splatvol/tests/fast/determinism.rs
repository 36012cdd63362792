//! The same bytes for any number of threads and any size of tiles; the same picture for any instructions.

use splatvol::{Camera, EngineConfig, Frame, Projection, RenderSettings, Renderer, Scene, SimdLevel};
use splatvol_samples::Sample;

use crate::common::PROJECTIONS;
use crate::support::{bits, fast, framing, generated, name_of, noise, opaque, rendered};

struct View {
    name: String,
    scene: Scene,
    camera: Camera,
}

/// Two volumes, opaque and translucent, in both projections: whole, close, and so far that two levels are blended.
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
                    });
                }
            }
        }
    }
    views
}

/// Neither a multiple of any tile's edge.
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
    let frame = |view: &View| rendered(&mut renderer, &view.scene, &view.camera, &settings()).0;
    views.iter().map(frame).collect()
}

/// Frames of this configuration must lie within `limit` of those expected, any channel; to the bit for 0.
fn demand(config: EngineConfig, views: &[View], expected: &[Frame], limit: f32) {
    let mut worst = (0.0, 0, "");
    for ((view, expected), found) in views.iter().zip(expected).zip(frames(config, views)) {
        let (most, count) = difference(&found, expected);
        if most >= worst.0 {
            worst = (most, count, &view.name);
        }
        assert!(
            limit > 0.0 || bits(&found) == bits(expected),
            "{config:?} {}: {count} pixels differ, by up to {most:.2e}",
            view.name
        );
        assert!(
            most <= limit,
            "{config:?} {}: {count} pixels, by up to {most:.2e}",
            view.name
        );
    }
    println!(
        "{config:?}: largest difference {:.2e} ({} pixels of {})",
        worst.0, worst.1, worst.2
    );
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
        demand(threads(count), &views, &expected, 0.0);
    }
}

/// Compares every size of tiles with the default one.
fn compare_tiles(limit: f32) {
    let views = views();
    let expected = frames(EngineConfig::default(), &views);
    for edge in [16, 32, 48, 64] {
        let config = EngineConfig {
            tile_edge: Some(edge),
            ..EngineConfig::default()
        };
        demand(config, &views, &expected, limit);
    }
}

/// Tails of footprints far beyond their cut reach pixels in one tile and not in another.
#[test]
fn tiles_change_the_picture_by_little() {
    compare_tiles(TILE_LIMIT);
}

/// Largest difference between pictures in tiles of different sizes; 4.1e-4 was measured.
const TILE_LIMIT: f32 = 1e-3;

#[test]
#[ignore = "fails: see tiles_change_the_picture_by_little"]
fn tiles_do_not_change_a_bit() {
    compare_tiles(0.0);
}

/// Compares every kind of instructions that the processor has with the best.
fn compare_instructions(limit: f32) {
    let views = views();
    let expected = frames(EngineConfig::default(), &views);
    for simd in SimdLevel::ALL {
        if !simd.is_available() {
            println!("skipped: this processor has no {simd:?}");
            continue;
        }
        let config = EngineConfig {
            simd: Some(simd),
            ..EngineConfig::default()
        };
        demand(config, &views, &expected, limit);
    }
}

/// The mean extinction divides the difference of two 32-bit integrals by as little as 1e-4: rounding is amplified.
#[test]
fn instructions_change_the_picture_by_rounding_only() {
    compare_instructions(SIMD_LIMIT);
}

/// Largest difference between pictures by different instructions; 6.2e-4 was measured.
const SIMD_LIMIT: f32 = 8e-4;

#[test]
#[ignore = "fails: see instructions_change_the_picture_by_rounding_only"]
fn instructions_change_the_picture_by_less_than_a_hundred_thousandth() {
    compare_instructions(1e-5);
}
