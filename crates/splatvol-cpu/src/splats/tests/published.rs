//! Pictures against an independent implementation of the published algorithm in f64.

use glam::{DAffine3, DMat3, DVec3};
use splatvol_scene::transfer_function::srgb_from_linear;
use splatvol_scene::{Camera, Frame, Gaussians, Projection};

use super::{
    BlendMode, CloudSettings, LowPass, Pixel, Published, Renderer, attributes, cloud, perspective, settings,
};

/// Pictures agree to 95 dB and more, except one where two large splats are so close in depth that f32 swaps them.
const LEAST_PSNR: f64 = 58.0;

fn renderer() -> Renderer {
    Renderer::new(2, None).expect("the processor's best instructions")
}

/// Premultiplied display colour and opacity, as the reader of a PNG gets them.
pub(super) fn display(pixel: [f32; 4]) -> [f64; 4] {
    let [r, g, b, alpha] = pixel.map(f64::from);
    let encode = |c: f64| {
        if alpha > 0.0 {
            alpha * srgb_from_linear(c / alpha)
        } else {
            0.0
        }
    };
    [encode(r), encode(g), encode(b), alpha]
}

/// PSNR of premultiplied display colours and opacity, and the largest error of depths relative to the depth.
pub(super) fn errors(frame: &Frame, expected: &[Pixel]) -> (f64, f64) {
    let (mut squares, mut worst_depth) = (0.0, 0.0f64);
    for (index, (pixel, expected)) in frame.image.pixels.iter().zip(expected).enumerate() {
        let alpha = 1.0 - expected.through;
        let want = [expected.color.x, expected.color.y, expected.color.z, alpha];
        squares += display(*pixel)
            .iter()
            .zip(want)
            .map(|(a, b)| (a - b).powi(2))
            .sum::<f64>();
        if alpha > 0.1 {
            let depth = expected.depth_sum / alpha;
            worst_depth = worst_depth.max((f64::from(frame.depth[index]) / depth - 1.0).abs());
            let tau = -expected.through.ln();
            assert!(
                (f64::from(frame.optical_depth[index]) - tau).abs() < 0.1 + 0.1 * tau,
                "{index}"
            );
        }
    }
    let mean = squares / (4 * expected.len()) as f64;
    let covered = expected.iter().filter(|pixel| pixel.through < 0.99).count();
    assert!(
        covered * 10 > expected.len(),
        "a picture of {covered} pixels tests nothing"
    );
    (-10.0 * mean.max(1e-30).log10(), worst_depth)
}

fn demand(name: &str, clouds: &[&Gaussians], camera: &Camera, settings: &CloudSettings) {
    let frame = renderer().render(clouds, camera, settings);
    let (psnr, depth) = errors(&frame, &Published::of(settings).render(clouds, camera));
    println!("{name}: {psnr:.1} dB, depth {depth:.1e}");
    assert!(psnr >= LEAST_PSNR, "{name}: {psnr:.1} dB");
    assert!(depth < 0.02, "{name}: depth {depth}");
}

#[test]
fn every_degree_of_harmonics_and_every_camera_is_the_published_picture() {
    let cameras = [
        ("wide", perspective(DVec3::new(1.6, 1.1, 0.7), 100.0)),
        ("far", perspective(DVec3::new(5.0, -3.0, 2.0), 25.0)),
        ("close", perspective(DVec3::new(0.9, 0.9, 0.3), 60.0)),
        ("inside", perspective(DVec3::new(0.2, -0.3, 0.1), 75.0)),
        (
            "orthographic",
            Camera::new(
                DVec3::new(3.0, 2.0, 1.0),
                DVec3::ZERO,
                DVec3::Z,
                Projection::Orthographic { height: 2.2 },
            )
            .unwrap(),
        ),
    ];
    for degree in 0..=3 {
        let gaussians = cloud(u64::from(degree) + 3, 1500, degree, [0.004, 0.12]);
        for (name, camera) in &cameras {
            demand(
                &format!("degree {degree}, {name}"),
                &[&gaussians],
                camera,
                &settings(203, 150),
            );
        }
    }
}

#[test]
fn dense_clouds_of_small_splats_end_where_the_published_ones_do() {
    let mut made = attributes(11, 20_000, 1, [0.003, 0.03]);
    for opacity in &mut made.opacities {
        *opacity = opacity.sqrt();
    }
    let gaussians = Gaussians::new(made, 1, DAffine3::IDENTITY).unwrap();
    let camera = perspective(DVec3::new(2.5, 0.4, -1.0), 45.0);
    demand("dense", &[&gaussians], &camera, &settings(160, 128));
}

#[test]
fn needles_and_discs_are_cut_nowhere_else_than_published() {
    let mut made = attributes(13, 600, 2, [0.001, 0.4]);
    for (i, scale) in made.scales.iter_mut().enumerate() {
        *scale = if i % 2 == 0 {
            [0.5, 0.0005, 0.0005]
        } else {
            [0.3, 0.2, 0.0]
        };
    }
    let gaussians = Gaussians::new(made, 2, DAffine3::IDENTITY).unwrap();
    demand(
        "needles",
        &[&gaussians],
        &perspective(DVec3::new(2.0, 1.5, 1.0), 60.0),
        &settings(240, 200),
    );
}

#[test]
fn clouds_are_merged_wherever_they_lie() {
    let stretched = DAffine3::from_mat3_translation(
        DMat3::from_cols(
            DVec3::new(3.0, 0.5, 0.0),
            DVec3::new(0.2, -5.0, 1.0),
            DVec3::new(0.0, 0.4, 4.0),
        ),
        DVec3::new(1e4, -2e4, 5e3),
    );
    let moved = DAffine3::from_translation(DVec3::new(1e4 + 2.0, -2e4, 5e3));
    let a = cloud(17, 800, 3, [0.01, 0.1]).placed(stretched).unwrap();
    let b = cloud(19, 800, 1, [0.01, 0.4]).placed(moved).unwrap();
    let centre = DVec3::new(1e4, -2e4, 5e3);
    let camera = Camera::new(
        centre + DVec3::new(9.0, 4.0, 3.0),
        centre,
        DVec3::Z,
        Projection::Perspective { fov_degrees: 50.0 },
    )
    .unwrap();
    demand("two clouds", &[&a, &b], &camera, &settings(160, 160));
}

#[test]
fn antialiased_clouds_and_other_low_passes() {
    let gaussians = cloud(23, 6000, 0, [0.0005, 0.02]).with_antialiasing(true);
    let camera = perspective(DVec3::new(3.0, 1.0, 1.0), 45.0);
    demand("antialiased", &[&gaussians], &camera, &settings(128, 128));
    let wide = CloudSettings {
        low_pass: LowPass::Added(1.5),
        ..settings(128, 128)
    };
    demand(
        "wide low-pass",
        &[&gaussians.with_antialiasing(false)],
        &camera,
        &wide,
    );
}

#[test]
fn a_background_is_composited_in_display_space() {
    let gaussians = cloud(29, 300, 0, [0.02, 0.2]);
    let camera = perspective(DVec3::new(3.0, 1.0, 1.0), 45.0);
    let transparent = settings(96, 64);
    let background = [0.2, 0.5, 0.9, 1.0];
    let opaque = CloudSettings {
        blend_mode: BlendMode::Published { background },
        ..transparent
    };
    let mut renderer = renderer();
    let alone = renderer.render(&[&gaussians], &camera, &transparent);
    let over = renderer.render(&[&gaussians], &camera, &opaque);
    for (alone, over) in alone.image.pixels.iter().zip(&over.image.pixels) {
        let (alone, over) = (display(*alone), display(*over));
        for c in 0..3 {
            let under = srgb_from_linear(f64::from(background[c]));
            assert!((alone[c] + (1.0 - alone[3]) * under - over[c]).abs() < 2e-5);
        }
        assert!((over[3] - 1.0).abs() < 1e-6);
    }
}
