//! Gaussians, as published and in sheets.

use glam::{DAffine3, DVec3};
use splatvol::{
    Camera, EngineConfig, Filter, FlatSettings, Frame, GaussianAttributes, GaussianMode, Gaussians, Item,
    Lighting, PointLook, RenderSettings, Renderer, Scene,
};
use splatvol_testing::{Comparison, checked};

use super::support::{self, cloud, picture, unlit};
use crate::common::{orthographic, perspective};

fn item(gaussians: Gaussians) -> Item {
    Item::gaussians(gaussians)
}

fn of(gaussians: GaussianMode, side: u32) -> RenderSettings {
    RenderSettings {
        gaussians,
        ..unlit(side, side)
    }
}

/// The opacity of a Gaussian is that of its peak, in both ways and from every side.
#[test]
fn a_gaussian_is_as_opaque_as_its_peak_from_every_side() {
    let attributes = GaussianAttributes {
        means: vec![[0.0; 3]],
        scales: vec![[0.5, 0.2, 0.9]],
        rotations: vec![[0.3, -0.2, 0.5, 0.7]],
        opacities: vec![0.7],
        harmonics: vec![[1.0; 3]],
    };
    let gaussian = Gaussians::new(attributes, 0, DAffine3::IDENTITY).unwrap();
    for direction in [DVec3::X, DVec3::Y, DVec3::new(1.0, -2.0, 0.5)] {
        for camera in [
            orthographic(DVec3::ZERO, direction, 6.0),
            perspective(DVec3::ZERO, direction, 12.0, 30.0),
        ] {
            for mode in [GaussianMode::Auto, GaussianMode::Volumetric] {
                let frame = picture(vec![item(gaussian.clone())], &camera, &of(mode, 101));
                let found = frame.image.pixel(50, 50)[3];
                assert!((found - 0.7).abs() < 0.005, "{mode:?} {direction}: {found}");
            }
        }
    }
}

/// Distant Gaussians are faint, not large: the low-pass widens them and lowers their optical depth by the same factor.
#[test]
fn small_gaussians_keep_their_energy() {
    let gaussians = cloud(1, [0.5, 0.5], 7);
    let energy = |height: f64| {
        let camera = orthographic(DVec3::ZERO, DVec3::Z, height);
        let settings = checked(FlatSettings {
            compositing: splatvol::Compositing::Xray,
            filter: Filter::Ewa { pixel_sigma: 0.5 },
            ..of(GaussianMode::Volumetric, 64).into()
        });
        let frame = picture(vec![item(gaussians.clone())], &camera, &settings);
        let sum: f64 = frame.optical_depth.iter().map(|d| f64::from(*d)).sum();
        sum * (height / 64.0).powi(2)
    };
    let (near, far) = (energy(8.0), energy(200.0));
    assert!((far / near - 1.0).abs() < 0.02, "{near} {far}");
}

/// Points beside Gaussians are splatted among them: the picture is that of the Gaussians alone where they do not reach.
#[test]
fn points_beside_gaussians_change_what_they_reach_alone() {
    let gaussians = item(cloud(3000, [0.02, 0.1], 11));
    let look = PointLook {
        color: [1.0, 0.8, 0.2],
        ..PointLook::default()
    };
    let points = || support::item(support::sphere(200), look, 0.3);
    let camera = perspective(DVec3::ZERO, DVec3::new(1.0, -2.0, 0.5), 7.0, 40.0);
    for mode in [GaussianMode::Auto, GaussianMode::Published] {
        let settings = RenderSettings {
            lighting: Some(Lighting::default()),
            ..of(mode, 160)
        };
        let alone = picture(vec![gaussians.clone()], &camera, &settings);
        let beside = picture(vec![points(), gaussians.clone()], &camera, &settings);
        let published = RenderSettings {
            gaussians: GaussianMode::Published,
            ..settings
        };
        let reach = picture(vec![points()], &camera, &published);
        let (mut same, mut changed) = (0, 0);
        for (index, reached) in reach.image.pixels.iter().enumerate() {
            let (a, b) = (alone.image.pixels[index], beside.image.pixels[index]);
            if reached[3] == 0.0 {
                assert!(a.map(f32::to_bits) == b.map(f32::to_bits), "{mode:?} {index}");
                same += 1;
            } else if a != b {
                changed += 1;
            }
        }
        assert!(same > 10_000 && changed > 200, "{mode:?} {same} {changed}");
    }
}

/// A sphere of points has no hole when its discs are composited one by one, and is lit as in sheets.
#[test]
fn a_sphere_of_whole_splats_looks_as_in_sheets() {
    let sphere = || support::item(support::sphere(8000), PointLook::default(), 1.0);
    let camera = orthographic(DVec3::ZERO, DVec3::new(0.3, -1.0, 0.2), 3.0);
    let [whole, sheets] = [GaussianMode::Published, GaussianMode::Volumetric].map(|mode| {
        let settings = RenderSettings {
            lighting: Some(Lighting::default()),
            ..of(mode, 240)
        };
        picture(vec![sphere()], &camera, &settings)
    });
    // Well inside the outline, whose softness differs.
    let mut worst = 0.0f32;
    for y in 0..240 {
        for x in 0..240 {
            let place = DVec3::new(x as f64 - 119.5, y as f64 - 119.5, 0.0) / 80.0;
            if place.length() < 0.9 {
                let (a, b) = (whole.image.pixel(x, y), sheets.image.pixel(x, y));
                assert!(a[3] > 0.99, "{x} {y}: {}", a[3]);
                worst = worst.max((a[0] - b[0]).abs());
            }
        }
    }
    println!("largest difference {worst:.4}");
    assert!(worst < 0.03, "{worst}");
}

fn frames(mode: GaussianMode) -> Vec<Frame> {
    let scene = Scene::from(item(cloud(300, [0.05, 0.35], 21)));
    let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
    (0..16)
        .map(|step| {
            let angle = (40.0 + 0.5 * f64::from(step)).to_radians();
            let direction = DVec3::new(angle.cos(), angle.sin(), 0.2);
            let position = -6.0 * direction.normalize();
            let projection = splatvol::Projection::Perspective { fov_degrees: 30.0 };
            let camera = Camera::new(position, DVec3::ZERO, DVec3::Z, projection).unwrap();
            renderer.render(&scene, &camera, &of(mode, 64)).unwrap()
        })
        .collect()
}

/// Pixels that change, from one half degree to the next, by more than twice as much as before and after, and two
/// levels.
fn jumps(frames: &[Frame]) -> usize {
    let change = |frame: usize, pixel: usize, c: usize| {
        f64::from(frames[frame + 1].image.pixels[pixel][c] - frames[frame].image.pixels[pixel][c]).abs()
    };
    let count = frames[0].image.pixels.len();
    (1..frames.len() - 2)
        .map(|frame| {
            let jumps = |pixel: &usize| {
                (0..4).any(|c| {
                    let around = change(frame - 1, *pixel, c).max(change(frame + 1, *pixel, c));
                    change(frame, *pixel, c) > 2.0 * around + 2.0 / 255.0
                })
            };
            (0..count).filter(jumps).count()
        })
        .sum()
}

#[test]
fn sheets_do_not_pop_where_sorted_centres_do() {
    let [published, volumetric] =
        [GaussianMode::Auto, GaussianMode::Volumetric].map(|mode| jumps(&frames(mode)));
    println!("jumps of pixels along 8 degrees: 3dgs {published}, volumetric {volumetric}");
    assert_eq!(volumetric, 0);
    assert!(published > 50, "{published}");
}

/// Thin clouds, which hide nothing from each other, look alike in both ways except for the colour space in which they
/// are mixed.
#[test]
fn single_gaussians_look_alike_in_both_ways() {
    let mut attributes = cloud(12, [0.02, 0.05], 5).attributes().clone();
    attributes.harmonics.fill([1.7725; 3]);
    let white = Gaussians::new(attributes, 0, DAffine3::IDENTITY).unwrap();
    let camera = perspective(DVec3::ZERO, DVec3::new(0.5, 0.1, 1.0), 6.0, 30.0);
    let pictures = [GaussianMode::Auto, GaussianMode::Volumetric].map(|mode| {
        let settings = checked(FlatSettings {
            filter: Filter::Ewa {
                pixel_sigma: 0.3_f64.sqrt(),
            },
            ..of(mode, 256).into()
        });
        picture(vec![item(white.clone())], &camera, &settings).image
    });
    let figures = Comparison::of(&pictures[0], &pictures[1]);
    println!("white Gaussians in both ways: {:.1} dB", figures.psnr);
    assert!(figures.psnr > 25.0, "{}", figures.psnr);
}
