//! Kernels of other things among Gaussians: against f64, and without effect where they do not reach.

use glam::{DAffine3, DMat3, DVec3};
use splatvol_core::splats::{Gather, Splat, SplatCloud};
use splatvol_scene::{Camera, Frame, Gaussians, Lighting, Projection};

use super::published::{display, errors};
use super::robust::bits;
use super::{CloudSettings, Published, Random, Renderer, cloud, perspective, settings};
use crate::splats::Cloud;

/// Discs, needles and balls, from thin to opaque, in the cube -1..1.
pub(super) fn kernels(seed: u64, count: usize) -> Vec<Splat> {
    let mut random = Random(seed);
    let kernel = |index: usize| {
        let sigma = random.between(0.005_f64.ln(), 0.1_f64.ln()).exp();
        let axes = match index % 3 {
            0 => DVec3::new(sigma, sigma, 0.0),
            1 => DVec3::new(4.0 * sigma, 0.1 * sigma, 0.1 * sigma),
            _ => DVec3::splat(sigma),
        };
        let turn = glam::DQuat::from_rotation_arc(DVec3::Z, random.vector().normalize());
        let axes = DMat3::from_quat(turn) * DMat3::from_diagonal(axes);
        let mass = random.between(0.1, 40.0) * sigma * sigma;
        let [r, g, b] = [(); 3].map(|()| mass * random.unit());
        Splat {
            centre: random.vector(),
            covariance: axes * axes.transpose(),
            payload: [mass, r, g, b].map(|value| value as f32),
            gradient: DVec3::ZERO,
        }
    };
    (0..count).map(kernel).collect()
}

pub(super) fn gathered(splats: &[Splat]) -> SplatCloud {
    let mut gather = Gather::around(DVec3::new(0.1, 0.0, -0.2), 0.1);
    gather.add_splats(splats.len(), |index| splats[index]);
    gather.finish().cloud
}

/// A white ball of a standard deviation and a mass in the middle.
pub(super) fn ball(sigma: f64, mass: f64) -> Splat {
    Splat {
        centre: DVec3::ZERO,
        covariance: DMat3::from_diagonal(DVec3::splat(sigma * sigma)),
        payload: [mass as f32; 4],
        gradient: DVec3::ZERO,
    }
}

fn render(
    gaussians: Option<&Gaussians>,
    kernels: &SplatCloud,
    camera: &Camera,
    settings: &CloudSettings,
) -> Frame {
    let own = gaussians.map(|cloud| Cloud::Gaussians(cloud, DAffine3::IDENTITY));
    let clouds: Vec<Cloud<'_>> = own.into_iter().chain([Cloud::Kernels(kernels)]).collect();
    let mut frame = Frame::empty(settings.size);
    let mut renderer = Renderer::new(2, None).expect("the processor's best instructions");
    renderer.render_clouds(&clouds, camera, settings, &mut frame);
    frame
}

#[test]
fn kernels_among_gaussians_are_as_thick_as_rays_through_them() {
    let orthographic = Projection::Orthographic { height: 2.4 };
    let cameras = [
        ("wide", perspective(DVec3::new(1.6, 1.1, 0.7), 100.0)),
        ("far", perspective(DVec3::new(5.0, -3.0, 2.0), 25.0)),
        (
            "orthographic",
            Camera::new(DVec3::new(3.0, 2.0, 1.0), DVec3::ZERO, DVec3::Z, orthographic).unwrap(),
        ),
    ];
    let gaussians = cloud(41, 700, 1, [0.004, 0.12]);
    let splats = kernels(43, 900);
    let cloud = gathered(&splats);
    let settings = settings(203, 150);
    for (name, camera) in &cameras {
        for gaussians in [None, Some(&gaussians)] {
            let frame = render(gaussians, &cloud, camera, &settings);
            let all: Vec<&Gaussians> = gaussians.into_iter().collect();
            let expected = Published::of(&settings).render_with(&all, &splats, camera);
            let (psnr, depth) = errors(&frame, &expected);
            println!("{name}, {} clouds: {psnr:.1} dB, depth {depth:.1e}", all.len());
            assert!(psnr >= 58.0, "{name}: {psnr:.1} dB");
            assert!(depth < 0.02, "{name}: depth {depth}");
        }
    }
}

#[test]
fn pixels_that_kernels_do_not_reach_are_as_without_them() {
    let gaussians = cloud(47, 9000, 2, [0.01, 0.2]);
    let camera = perspective(DVec3::new(2.4, 1.1, 0.7), 60.0);
    let settings = settings(320, 200);
    let one = gathered(&[Splat {
        centre: DVec3::new(1.3, 0.5, 0.3),
        covariance: DMat3::from_diagonal(DVec3::splat(0.003)),
        payload: [0.05, 0.05, 0.03, 0.01],
        gradient: DVec3::ZERO,
    }]);
    let alone = Renderer::new(2, None)
        .unwrap()
        .render(&[&gaussians], &camera, &settings);
    let beside = render(Some(&gaussians), &one, &camera, &settings);
    let reach = render(None, &one, &camera, &settings);
    let (mut same, mut changed) = (0, 0);
    for (index, pixel) in reach.image.pixels.iter().enumerate() {
        let (a, b) = (alone.image.pixels[index], beside.image.pixels[index]);
        if pixel[3] == 0.0 {
            assert!(a.map(f32::to_bits) == b.map(f32::to_bits), "{index}");
            assert!(
                alone.depth[index].to_bits() == beside.depth[index].to_bits(),
                "{index}"
            );
            same += 1;
        } else if a != b {
            changed += 1;
        }
    }
    assert!(same > 10_000 && changed > 20, "{same} {changed}");
}

#[test]
fn light_falls_on_kernels_in_linear_light() {
    // A disc that faces a camera with its light; the same edge on to the light's half of the sphere.
    let disc = Splat {
        centre: DVec3::ZERO,
        covariance: DMat3::from_diagonal(DVec3::new(0.0, 0.04, 0.04)),
        payload: [5.0, 2.5, 1.0, 0.5],
        gradient: DVec3::X * 1e4,
    };
    let cloud = gathered(&[disc]);
    let orthographic = Projection::Orthographic { height: 2.0 };
    let camera = Camera::new(DVec3::X * 3.0, DVec3::ZERO, DVec3::Z, orthographic).unwrap();
    let plain = settings(64, 64);
    let lighting = Lighting {
        ambient: 0.2,
        diffuse: 0.5,
        specular: 0.0,
        direction: [0.0, 0.6, -0.8],
        ..Lighting::default()
    };
    let lit = CloudSettings {
        lighting: Some(lighting),
        ..plain
    };
    let [plain, lit] =
        [plain, lit].map(|settings| render(None, &cloud, &camera, &settings).image.pixel(32, 32));
    assert!(plain[3] > 0.9 && plain[3] == lit[3]);
    for channel in 0..3 {
        let share = f64::from(lit[channel] / plain[channel]);
        assert!((share - (0.2 + 0.5 * 0.8)).abs() < 1e-3, "{share}");
    }
    let [r, ..] = display(plain);
    let expected = splatvol_scene::transfer_function::srgb_from_linear(0.5) * f64::from(plain[3]);
    assert!((r - expected).abs() < 1e-4, "{r} {expected}");
}

#[test]
fn bytes_of_mixed_pictures_do_not_depend_on_threads_or_instructions() {
    let gaussians = cloud(59, 5000, 1, [0.01, 0.1]);
    let cloud = gathered(&kernels(61, 5000));
    let camera = perspective(DVec3::new(1.7, 1.0, 0.4), 70.0);
    let settings = CloudSettings {
        lighting: Some(Lighting::default()),
        ..settings(233, 122)
    };
    let clouds = [
        Cloud::Gaussians(&gaussians, DAffine3::IDENTITY),
        Cloud::Kernels(&cloud),
    ];
    let of = |threads, simd| {
        let mut frame = Frame::empty(settings.size);
        let mut renderer: Renderer = Renderer::new(threads, simd)?;
        renderer.render_clouds(&clouds, &camera, &settings, &mut frame);
        Some(bits(&frame))
    };
    let expected = of(1, None).expect("the processor's best instructions");
    assert!(of(7, None).as_ref() == Some(&expected));
    for simd in crate::config::SimdLevel::ALL {
        assert!(
            of(2, Some(simd)).is_none_or(|found| found == expected),
            "{simd:?}"
        );
    }
}
