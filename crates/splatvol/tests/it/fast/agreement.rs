//! The fast engine against the reference: four fields, both projections, lit and unlit. Without a low-pass, because
//! the reference has no matched filter; the kernel and everything else are the fast method's.
//!
//! Pictures have 256 x 256 pixels; the reference integrates every fourth along both axes.

use splatvol::{
    Camera, ColorPoint, Filter, FlatSettings, Image, ImageSize, Kernel, OpacityPoint, Projection,
    RenderSettings, Scene, TransferFunction,
};
use splatvol_reference::{ReferenceSettings, render_pixels};
use splatvol_samples::{Sample, SampleSize};
use splatvol_testing::{Comparison, Tolerance, assert_images, sample};
use splatvol_testing::{checked, fields::MarschnerLobb};

use super::support::{fast, framing, generated, name_of, noise, render, translucent};
use crate::common::PROJECTIONS;

const PIXELS: u32 = 256;
const STRIDE: u32 = 4;

/// PSNR in dB, one below the measured value; largest error and bias, at most twice what is measured.
type Demand = (f64, f64, f64);

/// Perspective lit, unlit, orthographic lit, unlit.
type Demands = [Demand; 4];

fn scenes() -> Vec<(&'static str, Scene, Demands)> {
    let surface = vec![OpacityPoint::new(0.47, 0.0), OpacityPoint::new(0.53, 0.6)];
    let surface = TransferFunction::new(vec![ColorPoint::new(0.0, [0.9, 0.7, 0.4])], surface, None).unwrap();
    let ball = Sample::Ball.generate(Some(SampleSize::Longest(32))).unwrap();
    let marschner_lobb = sample(&MarschnerLobb::default(), &MarschnerLobb::grid(41));
    vec![
        (
            "marschner-lobb",
            Scene::new(marschner_lobb, surface),
            [
                (31.3, 0.7, 2.4e-02),
                (36.6, 0.7, 5.8e-03),
                (30.0, 0.6, 3.2e-02),
                (36.3, 0.6, 7.0e-03),
            ],
        ),
        (
            "head",
            generated(Sample::Head, 48),
            [
                (41.1, 0.2, 3.4e-03),
                (48.5, 0.11, 2.3e-03),
                (40.3, 0.17, 4.0e-03),
                (47.8, 0.14, 2.9e-03),
            ],
        ),
        (
            "ball",
            Scene::new(ball, translucent()),
            [
                (40.8, 0.24, 2.8e-03),
                (65.4, 0.0076, 4.5e-04),
                (40.0, 0.24, 2.1e-03),
                (63.9, 0.0098, 6.2e-04),
            ],
        ),
        (
            "noise",
            noise(),
            [
                (39.5, 0.29, 4.4e-03),
                (52.6, 0.07, 4.2e-04),
                (38.4, 0.27, 4.4e-03),
                (51.2, 0.083, 5.6e-04),
            ],
        ),
    ]
}

/// Engine and reference on the same lattice of pixels.
pub(crate) fn pictures(scene: &Scene, projection: Projection, settings: &RenderSettings) -> (Image, Image) {
    pictures_from(scene, &framing(scene, projection, 1.0, 1.0), settings)
}

/// The same from a camera.
pub(crate) fn pictures_from(scene: &Scene, camera: &Camera, settings: &RenderSettings) -> (Image, Image) {
    let side = (PIXELS - STRIDE / 2).div_ceil(STRIDE);
    let along = || (0..side).map(|i| STRIDE / 2 + i * STRIDE);
    let pixels: Vec<(u32, u32)> = along().flat_map(|y| along().map(move |x| (x, y))).collect();
    let frame = render(scene, camera, settings);
    let options = ReferenceSettings {
        tolerance: 1e-4,
        ..ReferenceSettings::default()
    };
    let exact = render_pixels(scene, camera, settings, &options, &pixels).unwrap();
    let size = ImageSize::new(side, side).unwrap();
    let found = pixels
        .iter()
        .map(|&(x, y)| frame.image.pixel(x as usize, y as usize));
    let expected = exact.iter().map(|pixel| pixel.rgba.map(|c| c as f32));
    (
        Image::from_pixels(size, found.collect()).unwrap(),
        Image::from_pixels(size, expected.collect()).unwrap(),
    )
}

#[test]
fn pictures_agree_with_the_reference() {
    for (name, scene, demands) in scenes() {
        let mut demands = demands.into_iter();
        for projection in PROJECTIONS {
            for lit in [true, false] {
                let base = fast(PIXELS, PIXELS);
                let settings = checked(FlatSettings {
                    filter: Filter::None,
                    lighting: base.lighting.filter(|_| lit),
                    ..base.into()
                });
                let (found, expected) = pictures(&scene, projection, &settings);
                let figures = Comparison::of(&found, &expected);
                let bias = figures.bias.into_iter().fold(0.0, |m: f64, b| m.max(b.abs()));
                let light = if lit { "lit" } else { "unlit" };
                let name = format!("fast-{name}-{}-{light}", name_of(projection));
                println!(
                    "{name}: {:.2} dB, largest {:.4}, bias {bias:.1e}, coarse share {:.2}",
                    figures.psnr, figures.max_error, figures.coarse_share
                );
                let (floor, largest, most_bias) = demands.next().unwrap();
                assert_images(
                    &name,
                    &found,
                    &expected,
                    Tolerance::psnr(floor).max_error(largest).bias(most_bias),
                );
            }
        }
    }
}

/// Kernels that are cut late have steep powers where pixels are large, more than numbers hold.
#[test]
fn kernels_that_are_cut_late_leave_no_holes_in_small_pictures() {
    let scene = generated(Sample::Head, 32);
    for projection in PROJECTIONS {
        let camera = framing(&scene, projection, 1.0, 1.0);
        for pixels in [24, 32, 48, 64, 96] {
            let [usual, late] = [2.0, 3.0].map(|radius| {
                let kernel = Kernel::Gaussian { sigma: 0.64, radius };
                let settings = checked(FlatSettings {
                    kernel,
                    ..fast(pixels, pixels).into()
                });
                render(&scene, &camera, &settings).image
            });
            assert!(late.pixels.iter().flatten().all(|value| value.is_finite()));
            let name = format!("fast-late-cut-{}-{pixels}", name_of(projection));
            println!("{name}: {:.2} dB", Comparison::of(&late, &usual).psnr);
            assert_images(&name, &late, &usual, Tolerance::psnr(45.0));
        }
    }
}
