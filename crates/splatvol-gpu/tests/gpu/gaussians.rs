//! 3-D Gaussians on the GPU against the CPU engine's, as published.

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use splatvol::io::{ReadOptions, read_gaussians};
use splatvol::{
    Camera, EngineConfig, Frame, GaussianAttributes, GaussianMode, Gaussians, ImageSize, Item, Projection,
    RenderSettings, Renderer, Scene, View,
};
use splatvol_testing::random::Random;
use splatvol_testing::{Tolerance, assert_images};

use super::common::gpu;

fn signed(random: &mut Random) -> f32 {
    2.0 * random.unit() as f32 - 1.0
}

/// Gaussians of all shapes within a cube, with harmonics.
fn cloud(seed: u64, count: usize, degree: u32) -> Gaussians {
    let mut random = Random::new(seed);
    let mut made = GaussianAttributes::default();
    for _ in 0..count {
        made.means.push([(); 3].map(|()| signed(&mut random)));
        made.scales
            .push([(); 3].map(|()| 0.01 * (3.0 * random.unit() as f32).exp()));
        made.rotations.push([(); 4].map(|()| signed(&mut random) + 1e-3));
        made.opacities.push(random.unit() as f32);
        for k in 0..(degree + 1).pow(2) {
            let size = if k == 0 { 1.6 } else { 0.4 };
            made.harmonics.push([(); 3].map(|()| size * signed(&mut random)));
        }
    }
    Gaussians::new(made, degree, DAffine3::IDENTITY).unwrap()
}

fn sized(pixels: [u32; 2]) -> RenderSettings {
    RenderSettings {
        size: ImageSize::new(pixels[0], pixels[1]).unwrap(),
        gaussians: GaussianMode::Published,
        ..RenderSettings::default()
    }
}

fn assert_same(name: &str, own: &Frame, wanted: &Frame, decibels: f64) {
    assert_images(name, &own.image, &wanted.image, Tolerance::psnr(decibels));
    for (a, b) in own.depth.iter().zip(&wanted.depth) {
        assert_eq!(a.is_finite(), b.is_finite(), "{name}: {a} {b}");
    }
    let mean = |frame: &Frame| {
        let sum: f64 = frame.optical_depth.iter().copied().map(f64::from).sum();
        sum / frame.optical_depth.len() as f64
    };
    assert!((mean(own) / mean(wanted) - 1.0).abs() < 1e-3, "{name}");
}

#[test]
fn gaussians_are_the_cpu_s() {
    let Some(mut gpu) = gpu() else { return };
    let mut cpu = Renderer::new(EngineConfig::default()).unwrap();
    for (degree, antialiased) in [(0, false), (1, true), (2, false), (3, true)] {
        let cloud = cloud(7 + u64::from(degree), 3000, degree).with_antialiasing(antialiased);
        let mut scene = Scene::from(Item::gaussians(cloud));
        scene.background = [0.2, 0.4, 0.1, 0.5];
        for projection in [
            Projection::Perspective { fov_degrees: 50.0 },
            Projection::Orthographic { height: 2.6 },
        ] {
            // From outside, and with Gaussians behind the eye.
            for distance in [3.0, 0.4] {
                let eye = distance * DVec3::new(0.3, -0.9, 0.3);
                let camera = Camera::new(eye, DVec3::ZERO, DVec3::Z, projection).unwrap();
                let settings = sized([150, 101]);
                let own = gpu.render(&scene, &camera, &settings).unwrap();
                assert_eq!(gpu.statistics().engine, "gpu");
                let wanted = cpu.render(&scene, &camera, &settings).unwrap();
                let name = format!("gpu-gaussians-{degree}-{distance}");
                assert_same(&name, &own, &wanted, 80.0);
            }
        }
    }
}

#[test]
fn several_clouds_are_sorted_together_and_repeat_to_the_bit() {
    let Some(mut gpu) = gpu() else { return };
    let mut cpu = Renderer::new(EngineConfig::default()).unwrap();
    let cloud = Arc::new(cloud(3, 500, 1));
    let mut beside = Item::gaussians(Arc::clone(&cloud));
    beside.world_from_item = DAffine3::from_scale_rotation_translation(
        DVec3::splat(1.5),
        glam::DQuat::from_rotation_z(1.0),
        DVec3::new(0.3, 0.1, -0.2),
    );
    let one = Scene::from(Item::gaussians(Arc::clone(&cloud)));
    let both = Scene::of_items(vec![Item::gaussians(cloud), beside]).unwrap();
    let camera = Camera::framing(
        &both.bounds().unwrap(),
        View::Iso,
        Projection::Perspective { fov_degrees: 30.0 },
        1.0,
    )
    .unwrap();
    let settings = sized([96, 96]);
    let first = gpu.render(&both, &camera, &settings).unwrap();
    gpu.render(&one, &camera, &sized([33, 17])).unwrap();
    let again = gpu.render(&both, &camera, &settings).unwrap();
    assert_eq!(first.image.pixels, again.image.pixels);
    assert_eq!(first.depth, again.depth);
    let wanted = cpu.render(&both, &camera, &settings).unwrap();
    assert_same("gpu-gaussians-both", &first, &wanted, 80.0);
}

#[test]
fn a_scene_without_a_visible_gaussian_is_its_background() {
    let Some(mut gpu) = gpu() else { return };
    let scene = Scene::from(Item::gaussians(cloud(3, 50, 0)));
    let away = Camera::new(
        [9.0, 0.0, 0.0],
        [20.0, 0.0, 0.0],
        [0.0, 0.0, 1.0],
        Projection::Perspective { fov_degrees: 30.0 },
    )
    .unwrap();
    let frame = gpu.render(&scene, &away, &sized([40, 30])).unwrap();
    assert!(frame.image.pixels.iter().all(|pixel| *pixel == [0.0; 4]));
    assert!(frame.depth.iter().all(|depth| *depth == f32::INFINITY));
}

#[test]
fn recorded_gaussians_are_the_cpu_s() {
    let Some(mut gpu) = gpu() else { return };
    let Some(folder) = splatvol_recorded::recorded("gaussians") else {
        return;
    };
    let mut cpu = Renderer::new(EngineConfig::default()).unwrap();
    let mut seen = 0;
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|file| file.unwrap().path())
        .collect();
    files.sort();
    for path in files {
        let Ok(cloud) = read_gaussians(&path, &ReadOptions::default()) else {
            continue;
        };
        let scene = Scene::from(Item::gaussians(cloud.gaussians));
        let projection = Projection::Perspective { fov_degrees: 40.0 };
        let Ok(camera) = Camera::framing(&scene.bounds().unwrap(), View::Iso, projection, 1.0) else {
            continue;
        };
        let settings = sized([128, 128]);
        let own = gpu.render(&scene, &camera, &settings).unwrap();
        let wanted = cpu.render(&scene, &camera, &settings).unwrap();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        assert_images(&name, &own.image, &wanted.image, Tolerance::psnr(50.0));
        seen += 1;
    }
    assert!(seen > 0, "no file of Gaussians");
}
