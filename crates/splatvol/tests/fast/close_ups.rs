//! Close-ups: orthographic zooms of one to sixteen, against the other method's pictures.

use splatvol::RenderSettings;
use splatvol_samples::Sample;
use splatvol_testing::Comparison;

use crate::common::PROJECTIONS;
use crate::support::{fast, framing, generated, rendered, renderer};

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

/// PSNR floors in dB by zoom, one below what was measured.
const FLOORS: [(f64, f64); 9] = [
    (1.0, 32.8),
    (1.5, 31.3),
    (2.0, 28.7),
    (3.0, 24.9),
    (4.0, 23.1),
    (6.0, 20.8),
    (8.0, 20.2),
    (12.0, 19.4),
    (16.0, 18.5),
];
