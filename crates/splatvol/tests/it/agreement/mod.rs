//! The engine against the reference: four fields, both projections, lit and unlit, every mode.
//!
//! Pictures have 256 x 256 pixels; the reference integrates a lattice of them, every pixel with
//! `SPLATVOL_EVERY_PIXEL=1`.

mod demands;
mod presets;

use crate::common::{PROJECTIONS, settings};
use glam::{DMat3, DVec3, EulerRot};
use splatvol::{
    Camera, Classification, ColorPoint, Compositing, EngineConfig, Filter, FlatSettings, Grid, Image,
    ImageSize, OpacityPoint, Projection, RenderSettings, Renderer, Scene, TransferFunction, View,
};
use splatvol_reference::{ReferenceSettings, render_pixels};
use splatvol_samples::{Sample, SampleSize};
use splatvol_testing::fields::{MarschnerLobb, Noise};
use splatvol_testing::{Comparison, Tolerance, assert_images, checked, sample};

const PIXELS: u32 = 256;

fn every_pixel() -> bool {
    std::env::var_os("SPLATVOL_EVERY_PIXEL").is_some()
}

fn shells() -> TransferFunction {
    let colors = vec![
        ColorPoint::new(0.0, [0.2, 0.4, 0.8]),
        ColorPoint::new(0.5, [0.9, 0.5, 0.2]),
        ColorPoint::new(1.0, [1.0, 0.95, 0.8]),
    ];
    let opacities = vec![
        OpacityPoint::new(0.3, 0.0),
        OpacityPoint::new(0.5, 0.1),
        OpacityPoint::new(0.7, 0.6),
    ];
    TransferFunction::new(colors, opacities, None).unwrap()
}

fn scenes() -> Vec<(&'static str, Scene)> {
    let surface = vec![OpacityPoint::new(0.47, 0.0), OpacityPoint::new(0.53, 0.6)];
    let surface = TransferFunction::new(vec![ColorPoint::new(0.0, [0.9, 0.7, 0.4])], surface, None).unwrap();
    let grid = |dims, spacing| {
        let direction = DMat3::from_euler(EulerRot::XYZ, 0.3, 0.5, -0.2);
        Grid::new(dims, DVec3::new(-10.0, 3.0, 5.0), spacing, direction).unwrap()
    };
    let generated = |kind: Sample, longest| kind.generate(Some(SampleSize::Longest(longest))).unwrap();
    let noise = Noise::new(7, 40, DVec3::new(1.2, 1.2, 0.6));
    vec![
        (
            "marschner-lobb",
            Scene::new(
                sample(&MarschnerLobb::default(), &MarschnerLobb::grid(41)),
                surface,
            ),
        ),
        (
            "head",
            Scene::new(
                generated(Sample::Head, 48),
                Sample::Head.default_transfer_function().unwrap(),
            ),
        ),
        ("ball", Scene::new(generated(Sample::Ball, 32), shells())),
        (
            "noise",
            Scene::new(
                sample(&noise, &grid([32, 40, 18], DVec3::new(1.0, 0.8, 2.1))),
                shells(),
            ),
        ),
    ]
}

/// Engine and reference, with settings of its own, on a lattice of every fourth pixel.
fn compare_with(
    scene: &Scene,
    projection: Projection,
    settings: &RenderSettings,
    of_reference: &RenderSettings,
) -> (Image, Image) {
    pictures(scene, &camera(scene, projection), (settings, of_reference), 4)
}

/// Engine and reference on the same lattice of pixels.
fn compare(scene: &Scene, camera: &Camera, settings: &RenderSettings, stride: u32) -> (Image, Image) {
    pictures(scene, camera, (settings, settings), stride)
}

fn pictures(
    scene: &Scene,
    camera: &Camera,
    (settings, of_reference): (&RenderSettings, &RenderSettings),
    stride: u32,
) -> (Image, Image) {
    let stride = if every_pixel() { 1 } else { stride };
    let side = (PIXELS - stride / 2).div_ceil(stride);
    let along = || (0..side).map(|i| stride / 2 + i * stride);
    let pixels: Vec<(u32, u32)> = along().flat_map(|y| along().map(move |x| (x, y))).collect();
    let frame = Renderer::new(EngineConfig::default())
        .unwrap()
        .render(scene, camera, settings)
        .unwrap();
    let options = ReferenceSettings {
        tolerance: 1e-5,
        ..ReferenceSettings::default()
    };
    let exact = render_pixels(scene, camera, of_reference, &options, &pixels).unwrap();
    let size = ImageSize::new(side, side).unwrap();
    let found = pixels
        .iter()
        .map(|&(x, y)| frame.image.pixel(x as usize, y as usize))
        .collect();
    let expected = exact.iter().map(|pixel| pixel.rgba.map(|c| c as f32)).collect();
    (
        Image::from_pixels(size, found).unwrap(),
        Image::from_pixels(size, expected).unwrap(),
    )
}

fn camera(scene: &Scene, projection: Projection) -> Camera {
    Camera::framing(&scene.bounds().unwrap(), View::Iso, projection, 1.0).unwrap()
}

fn name_of(projection: Projection) -> &'static str {
    match projection {
        Projection::Perspective { .. } => "perspective",
        Projection::Orthographic { .. } => "orthographic",
    }
}

/// Checks one picture and prints its figures. Demands are those on the lattice; all pixels together have larger extremes.
fn check(name: &str, (actual, expected): &(Image, Image)) {
    let (psnr, largest, bias) = demands::of(name);
    let tolerance = match every_pixel() {
        true => Tolerance::psnr(psnr - 3.0).bias(2.0 * bias),
        false => Tolerance::psnr(psnr).max_error(largest).bias(bias),
    };
    let comparison = Comparison::of(actual, expected);
    println!(
        "{name}: {:.1} dB, largest {:.4}, bias {:.1e}, coarse share {:.2}",
        comparison.psnr,
        comparison.max_error,
        comparison.bias.into_iter().fold(0.0, |m: f64, b| m.max(b.abs())),
        comparison.coarse_share
    );
    assert_images(name, actual, expected, tolerance);
}

#[test]
fn post_classified_pictures_agree() {
    for (name, scene) in scenes() {
        for projection in PROJECTIONS {
            for lit in [true, false] {
                let base = settings(PIXELS);
                let settings = RenderSettings {
                    lighting: base.lighting.filter(|_| lit),
                    ..base
                };
                let images = compare(&scene, &camera(&scene, projection), &settings, 4);
                let light = if lit { "lit" } else { "unlit" };
                let name = format!("{name}-{}-{light}", name_of(projection));
                check(&name, &images);
            }
        }
    }
}

#[test]
fn pre_classified_pictures_agree() {
    for (name, scene) in scenes() {
        for projection in PROJECTIONS {
            let settings = checked(FlatSettings {
                classification: Classification::Pre,
                ..settings(PIXELS).into()
            });
            let images = compare(&scene, &camera(&scene, projection), &settings, 8);
            let name = format!("{name}-{}-pre", name_of(projection));
            check(&name, &images);
        }
    }
}

#[test]
fn x_rays_agree() {
    for (name, scene) in scenes() {
        for projection in PROJECTIONS {
            let settings = checked(FlatSettings {
                compositing: Compositing::Xray,
                ..settings(PIXELS).into()
            });
            let images = compare(&scene, &camera(&scene, projection), &settings, 8);
            let name = format!("{name}-{}-xray", name_of(projection));
            check(&name, &images);
        }
    }
}

#[test]
fn values_of_rays_agree() {
    for (name, scene) in scenes() {
        for projection in PROJECTIONS {
            for (mode, compositing) in [
                ("mip", Compositing::Mip),
                ("minip", Compositing::MinimumIntensity),
                ("mean", Compositing::Mean),
            ] {
                let settings = checked(FlatSettings {
                    compositing,
                    ..settings(PIXELS).into()
                });
                let images = compare(&scene, &camera(&scene, projection), &settings, 8);
                let name = format!("{name}-{}-{mode}", name_of(projection));
                check(&name, &images);
            }
        }
    }
}

#[test]
fn point_sampled_and_wide_filtered_pictures_agree() {
    let (_, scene) = scenes().swap_remove(3);
    for (filter, label) in [(Filter::None, "none"), (Filter::Ewa { pixel_sigma: 3.0 }, "wide")] {
        for projection in PROJECTIONS {
            let settings = checked(FlatSettings {
                filter,
                ..settings(PIXELS).into()
            });
            let images = compare(&scene, &camera(&scene, projection), &settings, 8);
            let name = format!("noise-{}-{label}", name_of(projection));
            check(&name, &images);
        }
    }
}

#[test]
fn the_plain_kernel_agrees() {
    let (_, scene) = scenes().swap_remove(1);
    let settings = checked(FlatSettings {
        prefilter: false,
        ..settings(PIXELS).into()
    });
    let images = compare(&scene, &camera(&scene, PROJECTIONS[0]), &settings, 8);
    check("head-perspective-plain", &images);
}
