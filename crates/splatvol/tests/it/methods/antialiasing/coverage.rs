//! Coverage: edges against the mean of 256 samples per pixel, and against how much of a pixel is covered.

use glam::DVec3;
use splatvol::{
    Classification, Compositing, Coverage, EngineConfig, Filter, FlatSettings, Grid, ImageSize,
    RenderSettings, Renderer, Scene, TransferFunction,
};
use splatvol_testing::{Comparison, sample};
use splatvol_testing::{checked, fields::Ball};

use super::{GROUND, SAMPLES, TUNNEL, common, inner, low_passed, settings, tunnel};

/// The opaque tunnel, where no filter of footprints is right: several samples at edges supply the missing accuracy.
#[test]
fn edges_of_opaque_material_are_right() {
    let (scene, camera) = tunnel();
    for (name, base) in [
        (
            "whole footprints",
            checked(FlatSettings {
                compositing: Compositing::AxisSheets,
                ..settings(TUNNEL, Filter::None).into()
            }),
        ),
        (
            "image sheets",
            checked(FlatSettings {
                size: ImageSize::new(TUNNEL[0], TUNNEL[1]).unwrap(),
                classification: Classification::Pre,
                lighting: None,
                filter: Filter::None,
                ..RenderSettings::balanced().into()
            }),
        ),
    ] {
        let fine = TUNNEL.map(|side| SAMPLES as u32 * side);
        let size = ImageSize::new(fine[0], fine[1]).unwrap();
        let samples = common::render(&scene, &camera, &RenderSettings { size, ..base }).image;
        let truth = inner(&low_passed(&samples, None));
        let quality = |filter, coverage| {
            let settings = checked(FlatSettings {
                filter,
                coverage,
                ..base.into()
            });
            Comparison::of(&inner(&common::render(&scene, &camera, &settings).image), &truth).psnr
        };
        let ewa = Filter::Ewa { pixel_sigma: 0.3 };
        let [none, filtered, covered] = [
            quality(Filter::None, Coverage::Off),
            quality(ewa, Coverage::Off),
            quality(ewa, Coverage::ADAPTIVE),
        ];
        println!("tunnel, {name}: none {none:.1}, ewa {filtered:.1}, ewa and coverage {covered:.1} dB");
        assert!(covered > none + 6.0 && covered > filtered + 6.0, "{covered}");
    }
}

fn ball() -> Scene {
    let grid = Grid::centred([24, 24, 24], DVec3::ONE).unwrap();
    let field = Ball {
        centre: DVec3::ZERO,
        radius: 8.0,
    };
    let transfer_function = TransferFunction::isosurface(0.4, 0.2, [0.9, 0.6, 0.2]).unwrap();
    Scene::new(sample(&field, &grid), transfer_function)
}

/// In every engine, edges are those of a picture of as many samples everywhere, and other pixels are as they were.
#[test]
fn edges_alone_are_sampled() {
    let scene = ball();
    let camera = common::orthographic(DVec3::ZERO, DVec3::new(0.4, 0.3, 1.0), 40.0);
    let size = ImageSize::new(GROUND[0], GROUND[1]).unwrap();
    for base in [
        RenderSettings::best(),
        RenderSettings::balanced(),
        checked(FlatSettings {
            compositing: Compositing::Mip,
            ..RenderSettings::balanced().into()
        }),
        RenderSettings::ewa2001(),
    ] {
        let base = RenderSettings { size, ..base };
        let plain = common::render(&scene, &camera, &base);
        let samples = 4;
        let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
        let coverage = Coverage::Adaptive {
            samples,
            contrast: 0.01,
        };
        let covered = renderer
            .render(&scene, &camera, &RenderSettings { coverage, ..base })
            .unwrap();
        let sampled = renderer.statistics().sampled_pixels;
        let [width, height] = GROUND;
        let fine = ImageSize::new(samples * width, samples * height).unwrap();
        let fine = common::render(&scene, &camera, &RenderSettings { size: fine, ..base });
        let mut found = 0;
        for y in 0..height as usize {
            for x in 0..width as usize {
                let at = y * width as usize + x;
                let mut mean = [0.0; 4];
                for sy in 0..4 {
                    for sx in 0..4 {
                        let sample = fine.image.pixel(4 * x + sx, 4 * y + sy);
                        mean = std::array::from_fn(|c| mean[c] + f64::from(sample[c]) / 16.0);
                    }
                }
                let [was, is] = [&plain, &covered].map(|frame| frame.image.pixel(x, y));
                let off = |pixel: [f32; 4]| {
                    (0..4)
                        .map(|c| (f64::from(pixel[c]) - mean[c]).abs())
                        .fold(0.0, f64::max)
                };
                if is == was {
                    continue;
                }
                found += 1;
                assert!(off(is) < 1e-5, "{x} {y}: {is:?} {mean:?}");
                if base.method.compositing() == Compositing::ImageSheets {
                    let transmittance = (-covered.optical_depth[at]).exp();
                    assert!((transmittance - (1.0 - is[3])).abs() < 1e-4, "{x} {y}");
                }
            }
        }
        assert!(found > 40 && found <= sampled, "{found} {sampled}");
        assert!(sampled < u64::from(width * height) / 2, "{sampled}");
    }
}

#[test]
fn sums_need_no_coverage_and_samples_have_bounds() {
    let refused = |settings: RenderSettings, words: &str| {
        let text = settings.validate().unwrap_err().to_string();
        assert!(text.contains(words), "{text}");
    };
    for compositing in [Compositing::Xray, Compositing::Mean] {
        let coverage = Coverage::ADAPTIVE;
        refused(
            checked(FlatSettings {
                compositing,
                coverage,
                ..FlatSettings::default()
            }),
            "sums",
        );
    }
    for (samples, contrast, words) in [(1, 0.1, "2 to 8"), (9, 0.1, "2 to 8"), (4, -0.1, "0 to 1")] {
        let coverage = Coverage::Adaptive { samples, contrast };
        refused(
            RenderSettings {
                coverage,
                ..RenderSettings::default()
            },
            words,
        );
    }
}
