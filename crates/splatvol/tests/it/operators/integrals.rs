//! Gradient opacity and two-dimensional transfer functions against integrals along rays, in f64, of the field itself.

use glam::DVec3;
use splatvol::{
    Camera, GradientOpacity, GradientOpacityPoint, Image, Region, RenderSettings, Scene, TransferFunction2d,
};
use splatvol_testing::compare::Comparison;

use super::support::{SIDE, cameras, gaussian, solid, unlit};
use crate::common::{render, world_ray};

const SIGMA: f64 = 7.0;
const PIXELS: u32 = 96;
/// Steps per voxel.
const STEPS: f64 = 40.0;

/// The picture of a medium given by extinction and linear colour of value and gradient magnitude.
fn integrate(camera: &Camera, settings: &RenderSettings, medium: impl Fn(f64, f64) -> (f64, DVec3)) -> Image {
    let half = 0.5 * SIDE as f64;
    let mut image = Image::filled(settings.size, [0.0; 4]);
    for (i, pixel) in image.pixels.iter_mut().enumerate() {
        let (origin, direction) = world_ray(camera, settings, i % PIXELS as usize, i / PIXELS as usize);
        let length = direction.length();
        let (mut through, mut color) = (1.0, DVec3::ZERO);
        let middle = -origin.dot(direction) / (length * length);
        let count = (2.0 * half * 1.8 * STEPS) as i32;
        let step = 1.0 / (STEPS * length);
        for n in 0..count {
            let t = middle + (f64::from(n - count / 2) + 0.5) * step;
            let p = origin + t * direction;
            if p.abs().max_element() > half {
                continue;
            }
            let value = (-0.5 * p.length_squared() / (SIGMA * SIGMA)).exp();
            let (extinction, own) = medium(value, value * p.length() / (SIGMA * SIGMA));
            let left = (-extinction / STEPS).exp();
            color += through * (1.0 - left) * own;
            through *= left;
        }
        *pixel = [color.x, color.y, color.z, 1.0 - through].map(|v| v as f32);
    }
    image
}

/// Pictures of a scene in both projections against integrals of a medium; PSNR of at least this many dB.
fn demand(name: &str, scene: &Scene, decibels: f64, medium: impl Fn(f64, f64) -> (f64, DVec3)) {
    let settings = unlit(PIXELS);
    for camera in cameras() {
        let expected = integrate(&camera, &settings, &medium);
        let found = render(scene, &camera, &settings);
        let psnr = Comparison::of(&found.image, &expected).psnr;
        println!("{name}: {psnr:.1} dB");
        assert!(psnr >= decibels, "{name}: {psnr}");
        let most = expected.pixels.iter().map(|p| p[3]).fold(0.0, f32::max);
        assert!(most > 0.3, "something is seen");
    }
}

#[test]
fn gradient_opacity_is_that_of_the_integral() {
    let points =
        [(0.02, 0.1), (0.06, 1.0)].map(|(gradient, factor)| GradientOpacityPoint { gradient, factor });
    let function = solid(0.2, 0.1);
    let scene =
        Scene::new(gaussian(SIGMA), function.clone()).with_operator(GradientOpacity::new(&points).unwrap());
    demand("gradient opacity", &scene, 45.0, |value, gradient| {
        let factor = (0.1 + 0.9 * (gradient - 0.02) / 0.04).clamp(0.1, 1.0);
        (function.extinction(value, 1.0) * factor, DVec3::ONE)
    });
}

#[test]
fn regions_are_those_of_the_integral() {
    let regions = [
        Region {
            value: [0.15, 0.45],
            gradient: [0.02, 0.09],
            rgb: [1.0, 0.2, 0.1],
            opacity: 0.15,
            softness: 0.6,
        },
        Region {
            value: [0.4, 1.2],
            gradient: [0.0, 0.05],
            rgb: [0.1, 0.4, 1.0],
            opacity: 0.3,
            softness: 0.4,
        },
    ];
    let function = TransferFunction2d::new(&regions, 1.0).unwrap();
    let scene = Scene::new(gaussian(SIGMA), function.marginal().unwrap()).with_operator(function);
    let weight = |[low, high]: [f64; 2], softness: f64, at: f64| {
        let half = 0.5 * (high - low);
        let t = ((half - (at - 0.5 * (low + high)).abs()) / (softness * half)).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    };
    demand("regions", &scene, 45.0, |value, gradient| {
        let (mut sum, mut color) = (0.0, DVec3::ZERO);
        for region in &regions {
            let own = -(1.0 - region.opacity).ln()
                * weight(region.value, region.softness, value)
                * weight(region.gradient, region.softness, gradient);
            sum += own;
            color += own * DVec3::from_array(region.rgb.map(splatvol::transfer_function::linear_from_srgb));
        }
        (sum, color / f64::max(sum, 1e-300))
    });
}
