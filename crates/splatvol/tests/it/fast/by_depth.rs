//! Several levels behind each other: close to a volume, its far voxels would be many to a pixel.

use glam::DVec3;
use splatvol::{Camera, Classification, Projection, RenderSettings, Scene, Shows};
use splatvol::{Filter, FlatSettings, Image, ImageSize};
use splatvol_reference::{ReferenceSettings, render_pixels};
use splatvol_samples::Sample;
use splatvol_testing::{Comparison, checked};

use super::support::{fast, framing, generated, opaque, rendered, renderer};

/// Close to a volume, with levels by depth as if the picture were smaller.
pub(crate) fn views(
    settings: RenderSettings,
) -> impl Iterator<Item = (String, Scene, Camera, RenderSettings)> {
    let translucent = generated(Sample::Shells, 48);
    let looks = [
        (
            "opaque",
            opaque(&translucent),
            Shows::Material(Classification::Post),
        ),
        (
            "translucent",
            translucent.clone(),
            Shows::Material(Classification::Post),
        ),
        ("pre", translucent, Shows::Material(Classification::Pre)),
    ];
    looks.into_iter().map(move |(name, scene, shows)| {
        let settings = checked(FlatSettings {
            level_bias: 4.0,
            ..settings.with_shows(shows).into()
        });
        let camera = framing(&scene, PERSPECTIVE, 1.0, 5.0);
        (format!("levels-{name}"), scene, camera, settings)
    })
}

const PERSPECTIVE: Projection = Projection::Perspective { fov_degrees: 30.0 };
const PIXELS: u32 = 64;

/// A camera at the edge of a volume, that looks through all of it.
fn close(scene: &Scene) -> Camera {
    let bounds = scene.bounds().unwrap();
    let size = bounds.max - bounds.min;
    let eye = bounds.centre() + DVec3::new(0.1, -0.5, 0.05) * size;
    let target = bounds.centre() + DVec3::new(-0.1, 0.5, 0.0) * size;
    let projection = Projection::Perspective { fov_degrees: 70.0 };
    Camera::new(eye, target, DVec3::Z, projection).unwrap()
}

fn reference(scene: &Scene, camera: &Camera, settings: &RenderSettings) -> Image {
    let pixels: Vec<_> = (0..PIXELS * PIXELS).map(|i| (i % PIXELS, i / PIXELS)).collect();
    let options = ReferenceSettings {
        tolerance: 1e-4,
        ..ReferenceSettings::default()
    };
    let exact = render_pixels(scene, camera, settings, &options, &pixels).unwrap();
    let pixels = exact.iter().map(|pixel| pixel.rgba.map(|c| c as f32));
    Image::from_pixels(settings.size, pixels.collect()).unwrap()
}

/// Of a smooth field every level shows nearly the same, so that the reference, which knows none, is what levels behind
/// each other must add up to: nothing twice, nothing left out.
#[test]
fn levels_of_a_smooth_field_add_up_to_the_reference() {
    let ball = generated(Sample::Ball, 128);
    for (name, scene, floor) in [("fog", ball.clone(), 52.0), ("surface", opaque(&ball), 40.0)] {
        let camera = close(&scene);
        let settings = checked(FlatSettings {
            filter: Filter::None,
            lighting: None,
            ..fast(PIXELS, PIXELS).into()
        });
        let (frame, statistics) = rendered(&mut renderer(), &scene, &camera, &settings);
        let figures = Comparison::of(&frame.image, &reference(&scene, &camera, &settings));
        println!(
            "{name}: {:.2} dB, largest {:.3}, {} levels",
            figures.psnr, figures.max_error, statistics.levels
        );
        assert_eq!(statistics.levels, 3, "{name}");
        assert!(figures.psnr > floor, "{name}: {:.2} dB", figures.psnr);
    }
}

/// Against four by four times as many pixels, which show the volume itself almost everywhere.
#[test]
fn near_voxels_keep_their_detail_and_far_ones_are_few() {
    let scene = opaque(&generated(Sample::Shells, 160));
    let camera = close(&scene);
    let settings = fast(PIXELS, PIXELS);
    let mut renderer = renderer();
    let (found, statistics) = rendered(&mut renderer, &scene, &camera, &settings);
    let large = RenderSettings {
        size: ImageSize::new(4 * PIXELS, 4 * PIXELS).unwrap(),
        ..settings
    };
    let (finer, finer_statistics) = rendered(&mut renderer, &scene, &camera, &large);
    let expected = quarter(&finer.image);
    let figures = Comparison::of(&found.image, &expected);
    println!(
        "{:.2} dB, {} of {} voxels",
        figures.psnr, statistics.voxels, finer_statistics.voxels
    );
    assert!(figures.psnr > 27.0, "{:.2} dB", figures.psnr);
    assert!(2 * statistics.voxels < finer_statistics.voxels);
}

/// Means of four by four pixels.
fn quarter(image: &Image) -> Image {
    let size = ImageSize::new(PIXELS, PIXELS).unwrap();
    let width = 4 * PIXELS as usize;
    let mean = |i: usize| {
        let (x, y) = (4 * (i % PIXELS as usize), 4 * (i / PIXELS as usize));
        let mut sum = [0.0; 4];
        for at in 0..16 {
            let pixel = image.pixels[(y + at / 4) * width + x + at % 4];
            for (sum, value) in sum.iter_mut().zip(pixel) {
                *sum += value / 16.0;
            }
        }
        sum
    };
    let pixels = (0..size.pixel_count()).map(mean);
    Image::from_pixels(size, pixels.collect()).unwrap()
}
