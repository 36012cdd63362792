//! Robustness: identical bytes everywhere, no panic for any input, bounded memory.

use glam::{DAffine3, DVec3};
use splatvol_scene::{Camera, Frame, Gaussians, Projection};

use super::{
    BlendMode, CloudSettings, LowPass, Near, Random, Renderer, attributes, cloud, perspective, settings,
};
use crate::config::SimdLevel;

fn renderer(threads: usize, simd: Option<SimdLevel>) -> Renderer {
    Renderer::new(threads, simd).expect("instructions that are there")
}

pub(super) fn bits(frame: &Frame) -> Vec<u32> {
    let planes = frame.depth.iter().chain(&frame.optical_depth);
    let values = frame.image.pixels.iter().flatten().chain(planes);
    values.map(|value| value.to_bits()).collect()
}

#[test]
fn bytes_do_not_depend_on_threads_or_instructions() {
    let (a, b) = (cloud(1, 30_000, 1, [0.002, 0.05]), cloud(2, 9000, 3, [0.01, 0.3]));
    let camera = perspective(DVec3::new(1.7, 1.0, 0.4), 70.0);
    let settings = settings(333, 222);
    let expected = bits(&renderer(1, None).render(&[&a, &b], &camera, &settings));
    for threads in [2, 3, 7] {
        let found = renderer(threads, None).render(&[&a, &b], &camera, &settings);
        assert!(bits(&found) == expected, "{threads} threads");
    }
    for simd in SimdLevel::ALL {
        let Some(mut renderer) = Renderer::new(2, Some(simd)) else {
            assert!(!simd.is_available());
            continue;
        };
        let found = renderer.render(&[&a, &b], &camera, &settings);
        assert!(bits(&found) == expected, "{simd:?}");
    }
}

#[test]
fn buffers_of_other_frames_leave_no_trace() {
    let (many, few) = (cloud(3, 20_000, 0, [0.01, 0.2]), cloud(4, 50, 2, [0.01, 0.2]));
    let camera = perspective(DVec3::new(2.0, 1.0, 0.4), 60.0);
    let (large, small) = (settings(300, 200), settings(60, 90));
    let mut used = renderer(2, None);
    let mut frame = used.render(&[&many], &camera, &large);
    used.render_into(&[&few], &camera, &small, &mut frame);
    let fresh = renderer(2, None).render(&[&few], &camera, &small);
    assert!(bits(&frame) == bits(&fresh));
    used.render_into(&[], &camera, &small, &mut frame);
    assert!(bits(&frame) == bits(&Frame::empty(small.size)));
}

#[test]
fn equal_depths_are_drawn_in_the_order_of_the_file() {
    let mut made = attributes(5, 40, 0, [0.3, 0.3]);
    for (i, mean) in made.means.iter_mut().enumerate() {
        *mean = [0.0; 3];
        made.opacities[i] = 0.9;
        made.harmonics[i] = if i == 0 {
            [1.7, -1.7, -1.7]
        } else {
            [-1.7, 1.7, 1.7]
        };
    }
    let gaussians = Gaussians::new(made, 0, DAffine3::IDENTITY).unwrap();
    let camera = perspective(DVec3::new(0.05 + 4.0, 0.1, -0.1), 30.0);
    let frame = renderer(2, None).render(&[&gaussians], &camera, &settings(64, 64));
    let [r, g, _, _] = frame.image.pixel(32, 32);
    assert!(r > 5.0 * g && g > 0.0, "{r} {g}");
}

#[test]
fn hostile_numbers_make_finite_pictures() {
    let mut random = Random(9);
    let extremes = [0.0, 1e-38, 1e-20, 1e-3, 1.0, 1e4, 1e15, 1e19, 1e30, 3e38];
    let mut pick = || extremes[(random.unit() * 9.99) as usize] * random.signed().signum();
    let mut made = attributes(6, 4000, 3, [0.01, 0.1]);
    for (i, mean) in made.means.iter_mut().enumerate() {
        if i % 3 == 0 {
            *mean = [(); 3].map(|()| pick() as f32);
        }
        made.scales[i] = [(); 3].map(|()| pick().abs() as f32);
        if i % 2 == 0 {
            made.opacities[i] = if i % 4 == 0 { 0.0 } else { 1.0 };
        }
        made.harmonics[16 * i + i % 16] = [(); 3].map(|()| pick() as f32);
    }
    let antialiased = Gaussians::new(made.clone(), 3, DAffine3::IDENTITY)
        .unwrap()
        .with_antialiasing(true);
    let huge = DAffine3::from_scale(DVec3::splat(1e30));
    let placed = Gaussians::new(made, 3, huge).unwrap();
    let orthographic = Projection::Orthographic { height: 2.0 };
    let cameras = [
        perspective(DVec3::new(2.0, 1.0, 0.4), 60.0),
        perspective(DVec3::ZERO, 179.9),
        perspective(DVec3::splat(1e25), 1e-3),
        Camera::new(DVec3::splat(2.0), DVec3::ZERO, DVec3::Z, orthographic).unwrap(),
    ];
    let mut renderer = renderer(2, None);
    for camera in &cameras {
        for low_pass in [0.3, 0.0, f32::NAN, -1.0, 1e30] {
            let settings = CloudSettings {
                low_pass: LowPass::Added(low_pass),
                near: Near::OfGaussians(if low_pass == 0.0 { f64::NAN } else { 0.2 }),
                blend_mode: BlendMode::Published {
                    background: [f32::NAN, f32::INFINITY, -1.0, 0.5],
                },
                ..settings(67, 45)
            };
            for clouds in [&[&antialiased][..], &[&placed], &[&antialiased, &placed]] {
                let frame = renderer.render(clouds, camera, &settings);
                assert!(frame.image.pixels.iter().flatten().all(|value| value.is_finite()));
                assert!(frame.optical_depth.iter().all(|tau| (0.0..10.0).contains(tau)));
            }
        }
    }
}

#[test]
fn what_lies_behind_the_eye_or_cannot_be_seen_is_not_drawn() {
    let size = settings(64, 48);
    let gaussians = cloud(7, 500, 0, [0.01, 0.2]);
    let away = Camera::new(
        DVec3::new(4.0, 0.0, 0.0),
        DVec3::new(9.0, 0.0, 0.0),
        DVec3::Z,
        Projection::Perspective { fov_degrees: 90.0 },
    );
    let mut invisible = attributes(7, 500, 0, [0.01, 0.2]);
    invisible.opacities.fill(1.0 / 256.0);
    let invisible = Gaussians::new(invisible, 0, DAffine3::IDENTITY).unwrap();
    let mut renderer = renderer(2, None);
    for (gaussians, camera) in [
        (&gaussians, away.unwrap()),
        (&invisible, perspective(DVec3::new(3.0, 0.0, 0.0), 50.0)),
    ] {
        let frame = renderer.render(&[gaussians], &camera, &size);
        assert!(bits(&frame) == bits(&Frame::empty(size.size)));
    }
}

#[test]
fn memory_is_bounded_however_large_the_splats() {
    let camera = perspective(DVec3::new(2.5, 1.0, 0.4), 60.0);
    let size = settings(1024, 1024);
    for scales in [[0.002, 0.01], [5.0, 9.0]] {
        let gaussians = cloud(8, 20_000, 0, scales);
        let mut renderer = renderer(2, None);
        let frame = renderer.render(&[&gaussians], &camera, &size);
        let bytes = renderer.engine.bytes() as f64 / gaussians.len() as f64;
        println!("{scales:?}: {bytes:.1} bytes per splat");
        assert!(bytes <= 160.0, "{bytes}");
        let covered = frame.image.pixels.iter().filter(|pixel| pixel[3] > 0.5).count();
        assert!(covered > 100_000, "{covered}");
    }
}
