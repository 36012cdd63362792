//! A camera flies through a volume: near it, within it and at wide angles, the same settings give the same picture.

use glam::{DAffine3, DVec3};
use splatvol::{
    Camera, Classification, Clip, Compositing, EngineConfig, Filter, FlatSettings, Image, ImageSize,
    Isosurface, Item, PointAttributes, PointLook, Points, Projection, RenderSettings, Renderer, Scene,
    SimdLevel,
};
use splatvol_reference::{ReferenceSettings, render_pixels};
use splatvol_samples::Sample;
use splatvol_testing::{Comparison, checked};

use super::support::{bits, generated, noise, rendered, renderer};

const PIXELS: u32 = 96;
/// Pixels of the reference lie this far apart.
const STRIDE: u32 = 6;

fn settings() -> RenderSettings {
    checked(FlatSettings {
        size: ImageSize::new(PIXELS, PIXELS).unwrap(),
        filter: Filter::Ewa { pixel_sigma: 0.55 },
        ..RenderSettings::balanced().into()
    })
}

/// Share 0 lies before the face, 1 behind the head; between them the camera passes through an eye.
fn on_the_way(scene: &Scene, share: f64, fov_degrees: f64) -> Camera {
    let bounds = scene.bounds().unwrap();
    let (centre, half) = (bounds.centre(), 0.5 * (bounds.max - bounds.min));
    let through = DVec3::new(0.35, 0.0, 0.12);
    let position = centre + half * (through + DVec3::Y * (2.2 - 4.4 * share));
    let projection = Projection::Perspective { fov_degrees };
    Camera::new(
        position,
        position + DVec3::new(-0.12, -1.0, -0.05),
        DVec3::Z,
        projection,
    )
    .unwrap()
}

fn pixels() -> Vec<(u32, u32)> {
    let along = || (STRIDE / 2..PIXELS).step_by(STRIDE as usize);
    along().flat_map(|y| along().map(move |x| (x, y))).collect()
}

fn picture(pixels: Vec<[f32; 4]>) -> Image {
    let side = PIXELS / STRIDE;
    Image::from_pixels(ImageSize::new(side, side).unwrap(), pixels).unwrap()
}

/// Some pixels of a frame, and the same by the reference.
fn both(renderer: &mut Renderer, scene: &Scene, camera: &Camera, settings: &RenderSettings) -> [Image; 2] {
    let frame = renderer.render(scene, camera, settings).unwrap();
    assert_eq!(renderer.statistics().engine, "sheets");
    let found = pixels()
        .iter()
        .map(|&(x, y)| frame.image.pixel(x as usize, y as usize))
        .collect();
    let options = ReferenceSettings {
        tolerance: 1e-4,
        ..ReferenceSettings::default()
    };
    let exact = render_pixels(scene, camera, settings, &options, &pixels()).unwrap();
    let expected = exact.iter().map(|pixel| pixel.rgba.map(|c| c as f32)).collect();
    [picture(found), picture(expected)]
}

fn largest_change(a: &Image, b: &Image) -> f32 {
    let pairs = a.pixels.iter().flatten().zip(b.pixels.iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// Frames agree with the reference all the way, and from one to the next no pixel changes more than twice as much as
/// the reference's do.
#[test]
fn a_flight_through_the_head_is_smooth() {
    let scene = generated(Sample::Head, 48);
    let mut renderer = renderer();
    let mut before: Option<[Image; 2]> = None;
    let mut worst = f64::INFINITY;
    let mut most_zones = 0;
    for frame in 0..90 {
        let camera = on_the_way(&scene, f64::from(frame) / 89.0, 60.0);
        let images = both(&mut renderer, &scene, &camera, &settings());
        let statistics = renderer.statistics();
        most_zones = most_zones.max(statistics.zones);
        let psnr = Comparison::of(&images[0], &images[1]).psnr;
        worst = worst.min(psnr);
        let change = before.as_ref().map_or([0.0; 2], |before| {
            [0, 1].map(|i| largest_change(&before[i], &images[i]))
        });
        println!(
            "frame {frame}: {psnr:.1} dB, {} zones, {} voxels, change {:.3}, reference {:.3}",
            statistics.zones, statistics.voxels, change[0], change[1]
        );
        assert!(change[0] <= 2.0 * change[1] + 0.02, "frame {frame}: {change:?}");
        before = Some(images);
    }
    println!("at least {worst:.1} dB, at most {most_zones} zones");
    assert!(
        worst > 28.0 && most_zones > 2,
        "{worst:.1} dB, {most_zones} zones"
    );
}

/// Modes whose pictures the reference makes, too.
fn modes() -> [(&'static str, RenderSettings); 5] {
    let base = settings();
    [
        ("post", base),
        (
            "unlit",
            RenderSettings {
                lighting: None,
                ..base
            },
        ),
        (
            "pre",
            checked(FlatSettings {
                classification: Classification::Pre,
                ..base.into()
            }),
        ),
        (
            "mean",
            checked(FlatSettings {
                compositing: Compositing::Mean,
                ..base.into()
            }),
        ),
        (
            "x-ray",
            checked(FlatSettings {
                compositing: Compositing::Xray,
                ..base.into()
            }),
        ),
    ]
}

/// Every mode from within at wide angles; the look is translucent, so that the eye sees through the surrounding
/// material.
#[test]
fn every_mode_sees_from_within() {
    let head = generated(Sample::Head, 48);
    let mut renderer = renderer();
    for (scene_name, scene, floors) in [
        ("head", head, [35.0, 48.0, 47.0, 52.0, 44.0]),
        ("long voxels", noise(), [40.0, 43.0, 50.0, 40.0, 33.0]),
    ] {
        for fov in [60.0, 90.0, 120.0] {
            let camera = on_the_way(&scene, 0.45, fov);
            for ((mode, settings), floor) in modes().into_iter().zip(floors) {
                let [found, expected] = both(&mut renderer, &scene, &camera, &settings);
                let figures = Comparison::of(&found, &expected);
                println!(
                    "{scene_name}, {fov} degrees, {mode}: {:.1} dB, largest {:.3}, {} zones",
                    figures.psnr,
                    figures.max_error,
                    renderer.statistics().zones
                );
                assert!(
                    figures.psnr > floor,
                    "{scene_name} {fov} {mode}: {:.1} dB",
                    figures.psnr
                );
            }
        }
    }
}

/// Exact values of rays from within; their slopes are splatted along them.
#[test]
fn exact_values_of_rays_from_within() {
    let mut renderer = renderer();
    let (mean, largest) = ((Compositing::Mean, 80.0), (Compositing::Mip, 50.0));
    for (scene_name, scene, ways) in [
        ("head", generated(Sample::Head, 48), [mean, largest].as_slice()),
        ("long voxels", noise(), &[mean]),
    ] {
        for fov in [60.0, 90.0, 120.0] {
            let camera = on_the_way(&scene, 0.45, fov);
            for &(compositing, floor) in ways {
                let settings = checked(FlatSettings {
                    size: settings().size,
                    compositing,
                    ..RenderSettings::best().into()
                });
                let [found, expected] = both(&mut renderer, &scene, &camera, &settings);
                let psnr = Comparison::of(&found, &expected).psnr;
                println!("{scene_name}, {fov} degrees, {compositing:?}: {psnr:.1} dB");
                assert!(psnr > floor, "{scene_name} {fov} {compositing:?}: {psnr:.1} dB");
            }
        }
    }
}

/// Threads, tiles and instructions do not show where rasters differ by depth.
#[test]
fn zones_do_not_depend_on_what_runs_them() {
    let scene = generated(Sample::Head, 48);
    let camera = on_the_way(&scene, 0.3, 100.0);
    let frames = |config: EngineConfig| -> Vec<Vec<u32>> {
        let mut renderer = Renderer::new(config).unwrap();
        let frame = |(_, settings): (&str, RenderSettings)| {
            let size = ImageSize::new(200, 136).unwrap();
            let settings = RenderSettings { size, ..settings };
            let (frame, statistics) = rendered(&mut renderer, &scene, &camera, &settings);
            assert!(statistics.zones > 2, "{} zones", statistics.zones);
            bits(&frame)
        };
        // X-rays take footprints from the middle of a tile, whatever tiles are requested.
        modes().into_iter().map(frame).collect()
    };
    let expected = frames(EngineConfig::default());
    for threads in [1, 7] {
        let config = EngineConfig {
            threads: Some(threads),
            ..EngineConfig::default()
        };
        assert!(frames(config) == expected, "{threads} threads");
    }
    for edge in [16, 48, 64] {
        let config = EngineConfig {
            tile_edge: Some(edge),
            ..EngineConfig::default()
        };
        assert!(frames(config) == expected, "tiles of {edge} pixels");
    }
    for simd in SimdLevel::ALL.into_iter().filter(|simd| simd.is_available()) {
        let config = EngineConfig {
            simd: Some(simd),
            ..EngineConfig::default()
        };
        assert!(frames(config) == expected, "{simd:?}");
    }
}

/// Clips and isosurfaces are seen from within, too.
#[test]
fn cuts_and_surfaces_are_seen_from_within() {
    let scene = generated(Sample::Head, 48);
    let camera = on_the_way(&scene, 0.45, 90.0);
    let volume = scene.single_volume().unwrap().volume.clone();
    let [low, high] = volume.value_range();
    let surface = Isosurface {
        value: low + 0.6 * (high - low),
        rgb: [0.9, 0.8, 0.7],
        opacity: 0.9,
    };
    let surface = Scene::of_isosurfaces(volume, &[surface]).unwrap();
    let away = camera.target() - camera.position();
    let cut = scene
        .clone()
        .with_clip(Clip::plane(camera.position() + 10.0 * away, away).unwrap());
    let mut renderer = renderer();
    for (name, scene) in [("surface", surface), ("clip", cut)] {
        let (frame, statistics) = rendered(&mut renderer, &scene, &camera, &settings());
        let seen = frame.image.pixels.iter().filter(|pixel| pixel[3] > 0.5).count();
        let finite = frame.image.pixels.iter().flatten().all(|c| c.is_finite());
        println!("{name}: {seen} pixels, {} zones", statistics.zones);
        assert!(
            finite && seen > 1000 && statistics.zones > 1,
            "{name}: {seen} pixels"
        );
    }
}

/// A ball of points somewhere.
fn points(centre: DVec3, radius: f64) -> Item {
    let count = 400;
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let on_sphere = |i: usize| {
        let z = 1.0 - 2.0 * (i as f64 + 0.5) / f64::from(count);
        let (sin, cos) = (golden * i as f64).sin_cos();
        let across = (1.0 - z * z).sqrt();
        [across * cos, across * sin, z].map(|v| v as f32)
    };
    let normals: Vec<[f32; 3]> = (0..count as usize).map(on_sphere).collect();
    let attributes = PointAttributes {
        normals: normals.clone(),
        radii: vec![0.15; count as usize],
        ..PointAttributes::default()
    };
    let points = Points::new(normals, attributes, DAffine3::IDENTITY).unwrap();
    let place = DAffine3::from_translation(centre) * DAffine3::from_scale(DVec3::splat(radius));
    Item::points(points, PointLook::default()).at(place)
}

/// A volume seen from within keeps its values beside an item that does not reach its pixels, and each of the two has
/// zones of its own; where both are seen, the picture differs.
#[test]
fn layers_have_zones_of_their_own() {
    let head = generated(Sample::Head, 48);
    let camera = on_the_way(&head, 0.45, 90.0);
    let forward = (camera.target() - camera.position()).normalize();
    let side = forward.cross(DVec3::Z);
    let ball = || points(camera.position() + forward * 20.0 + side * 8.0, 5.0);
    let volume = || head.items[0].clone();
    let mut renderer = renderer();
    let mut picture = |items: Vec<Item>| {
        let scene = Scene::of_items(items).unwrap();
        let frame = renderer.render(&scene, &camera, &settings()).unwrap();
        (frame.image, renderer.statistics().clone())
    };
    let (alone, statistics) = picture(vec![volume()]);
    let zones = statistics.zones;
    let (ball_alone, _) = picture(vec![ball()]);
    let (both, statistics) = picture(vec![volume(), ball()]);
    assert_eq!(statistics.engine, "sheets");
    assert_eq!(statistics.zones, zones + 1);
    let mut counts = [0, 0];
    let edge = PIXELS as usize;
    // Beside the head the ball lies on the head's planes, which are farther apart: it is deeper there, and wider near
    // the eye.
    let is_reached = |x: usize, y: usize| {
        let around = |at: usize| at.saturating_sub(24)..(at + 25).min(edge);
        around(y).any(|y| around(x).any(|x| ball_alone.pixel(x, y)[3] > 0.0))
    };
    for (x, y) in (0..edge).flat_map(|y| (0..edge).map(move |x| (x, y))) {
        let (alone, both) = (alone.pixel(x, y), both.pixel(x, y));
        if !is_reached(x, y) {
            assert_eq!(alone, both);
            counts[0] += 1;
        } else if ball_alone.pixel(x, y)[3] > 0.5 && alone != both {
            counts[1] += 1;
        }
    }
    println!("{counts:?} pixels of {zones} zones");
    assert!(zones > 2 && counts[0] > 1000 && counts[1] > 50, "{counts:?}");
}
