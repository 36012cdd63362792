//! Close-ups: orthographic zooms of one to sixteen, against the other method's pictures.

use glam::{DMat3, DVec3, EulerRot};
use splatvol::{Grid, RenderSettings, Scene};
use splatvol_samples::Sample;
use splatvol_testing::fields::Noise;
use splatvol_testing::{Comparison, sample};

use super::support::{fast, framing, generated, rendered, renderer, translucent};
use crate::common::PROJECTIONS;

#[test]
fn close_ups_show_what_the_best_method_shows_at_no_more_voxels() {
    let scene = generated(Sample::Shells, 48);
    let settings = fast(128, 128);
    let best = RenderSettings {
        size: settings.size,
        ..RenderSettings::best()
    };
    let mut renderer = renderer();
    let mut voxels = Vec::new();
    for (zoom, floor) in FLOORS {
        let camera = framing(&scene, PROJECTIONS[1], 1.0, zoom);
        let (frame, statistics) = rendered(&mut renderer, &scene, &camera, &settings);
        let expected = renderer.render(&scene, &camera, &best).unwrap();
        let figures = Comparison::of(&frame.image, &expected.image);
        println!(
            "zoom {zoom}: {:.2} dB, largest {:.3}, ssim {:.4}, {} voxels",
            figures.psnr, figures.max_error, figures.ssim, statistics.voxels
        );
        assert!(figures.psnr > floor, "zoom {zoom}: {:.2} dB", figures.psnr);
        voxels.push(statistics.voxels);
    }
    for (i, pair) in voxels.windows(2).enumerate() {
        assert!(
            pair[1] <= pair[0],
            "more voxels after zoom {}: {voxels:?}",
            FLOORS[i].0
        );
    }
}

/// Footprints of voxels five times as long as wide: they must lie within their blocks, and their powers within floats.
#[test]
fn long_voxels_show_what_the_best_method_shows() {
    let direction = DMat3::from_euler(EulerRot::XYZ, 0.2, 0.3, 0.7);
    let spacing = DVec3::new(1.0, 1.0, 5.0);
    let grid = Grid::new([40, 40, 12], DVec3::ZERO, spacing, direction).unwrap();
    let field = Noise::new(3, 40, DVec3::new(0.5, 0.5, 0.2));
    let scene = Scene::new(sample(&field, &grid), translucent());
    let settings = RenderSettings {
        lighting: None,
        ..fast(96, 96)
    };
    let best = RenderSettings {
        size: settings.size,
        lighting: None,
        ..RenderSettings::best()
    };
    let mut renderer = renderer();
    for zoom in [0.7, 1.0, 1.5, 3.0, 6.0, 12.0] {
        let camera = framing(&scene, PROJECTIONS[1], 1.0, zoom);
        let frame = renderer.render(&scene, &camera, &settings).unwrap();
        let at_once = renderer.statistics().engine == "sheets";
        let expected = renderer.render(&scene, &camera, &best).unwrap();
        let figures = Comparison::of(&frame.image, &expected.image);
        println!(
            "zoom {zoom}, all sheets at once: {at_once}: {:.2} dB, largest {:.3}",
            figures.psnr, figures.max_error
        );
        assert!(figures.psnr > 29.0, "zoom {zoom}: {:.2} dB", figures.psnr);
    }
}

/// PSNR floors in dB by zoom, one below the measured values.
const FLOORS: [(f64, f64); 9] = [
    (1.0, 33.3),
    (1.5, 32.5),
    (2.0, 30.1),
    (3.0, 26.3),
    (4.0, 24.1),
    (6.0, 21.5),
    (8.0, 20.7),
    (12.0, 20.0),
    (16.0, 18.9),
];
