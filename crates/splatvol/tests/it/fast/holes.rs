//! Missing samples, and data without the prefilter: against the reference, against closed forms, and against the
//! picture without them.

use glam::DVec3;
use splatvol::{
    Camera, Classification, Compositing, Filter, FlatSettings, Grid, LengthUnit, Projection, RenderSettings,
    Rescale, Samples, Scene, View, Volume,
};
use splatvol_samples::{Sample, SampleSize};
use splatvol_testing::transfer::constant_extinction;
use splatvol_testing::{Comparison, Random, Tolerance, assert_images, sample};
use splatvol_testing::{checked, fields::Constant};

use super::agreement::pictures;
use super::support::{fast, framing, generated, noise, render, renderer, translucent};
use crate::common::PROJECTIONS;

/// The scene's volume without the samples at these voxels.
fn without(scene: &Scene, missing: impl Fn([usize; 3]) -> bool) -> Scene {
    let single = scene.single_volume().unwrap();
    let grid = single.volume.grid();
    let [nx, ny, _] = grid.dims();
    let samples = (0..grid.sample_count()).map(|i| {
        let at = [i % nx, i / nx % ny, i / (nx * ny)];
        let value = single.volume.value(i) as f32;
        // Both kinds of values that are not finite.
        let none = if i.is_multiple_of(2) {
            f32::NAN
        } else {
            f32::INFINITY
        };
        if missing(at) { none } else { value }
    });
    let samples = Samples::F32(samples.collect());
    let volume = Volume::new(grid.clone(), samples, Rescale::default(), LengthUnit::Unknown).unwrap();
    Scene::new(volume, single.transfer_function.clone())
}

/// Missing samples.
#[derive(Debug, Clone, Copy)]
enum Missing {
    None,
    /// One of fifty.
    Some,
    /// All samples on one side of a plane across the volume.
    Half,
    /// All samples outside the ellipsoid in the volume's box.
    Outside,
}

impl Missing {
    fn of(self, scene: &Scene) -> Scene {
        let dims = scene.single_volume().unwrap().volume.grid().dims();
        let from_middle = |at: [usize; 3]| [0, 1, 2].map(|a| (2 * at[a] + 1) as f64 / dims[a] as f64 - 1.0);
        match self {
            Self::None => scene.clone(),
            Self::Some => {
                let mut random = Random::new(31);
                let chosen: Vec<bool> = (0..dims.iter().product()).map(|_| random.unit() < 0.02).collect();
                without(scene, |[x, y, z]| chosen[(z * dims[1] + y) * dims[0] + x])
            }
            Self::Half => without(scene, |at| {
                let [x, y, z] = from_middle(at);
                x + 0.5 * y + 0.3 * z > 0.1
            }),
            Self::Outside => without(scene, |at| {
                from_middle(at).into_iter().map(|c| c * c).sum::<f64>() > 0.8
            }),
        }
    }
}

/// PSNR in dB, one below the measured values: `fast` lit and unlit, `best` lit and unlit, `fast` and `best` unlit
/// without the prefilter.
type Floors = [f64; 6];

/// Demands that a picture is this many decibels from the reference.
fn assert_agrees(name: &str, (scene, settings): (&Scene, &RenderSettings), floor: f64) {
    let (found, expected) = pictures(scene, PROJECTIONS[0], settings);
    let figures = Comparison::of(&found, &expected);
    println!("{name}: {:.2} dB, largest {:.4}", figures.psnr, figures.max_error);
    let demanded = Tolerance::psnr(floor).max_error(0.2).bias(0.02);
    assert_images(name, &found, &expected, demanded);
}

#[test]
fn holes_and_plain_data_agree_with_the_reference() {
    let head = generated(Sample::Head, 40);
    let cases: [(&str, Scene, Missing, Floors); 6] = [
        (
            "noise",
            noise(),
            Missing::None,
            [38.9, 51.1, 61.1, 68.9, 52.9, 70.6],
        ),
        (
            "noise",
            noise(),
            Missing::Some,
            [37.9, 50.1, 57.6, 68.3, 52.6, 70.1],
        ),
        (
            "noise",
            noise(),
            Missing::Half,
            [39.1, 50.6, 61.2, 68.5, 53.1, 70.2],
        ),
        (
            "noise",
            noise(),
            Missing::Outside,
            [48.8, 53.0, 64.2, 68.0, 55.0, 64.3],
        ),
        (
            "head",
            head.clone(),
            Missing::Some,
            [41.1, 47.5, 58.4, 71.5, 51.4, 71.4],
        ),
        ("head", head, Missing::Half, [42.3, 45.9, 56.2, 55.6, 44.2, 51.9]),
    ];
    for (field, scene, missing, floors) in cases {
        let scene = missing.of(&scene);
        let [fast, best] = [fast(256, 256), RenderSettings::best()].map(|settings| {
            checked(FlatSettings {
                size: fast(256, 256).size,
                filter: Filter::None,
                ..settings.into()
            })
        });
        let unlit = |settings| RenderSettings {
            lighting: None,
            ..settings
        };
        let plain = |settings| {
            checked(FlatSettings {
                prefilter: false,
                ..unlit(settings).into()
            })
        };
        let all = [fast, unlit(fast), best, unlit(best), plain(fast), plain(best)];
        let names = [
            "fast",
            "fast-unlit",
            "best",
            "best-unlit",
            "fast-plain",
            "best-plain",
        ];
        for ((settings, floor), name) in all.into_iter().zip(floors).zip(names) {
            assert_agrees(
                &format!("holes-{field}-{missing:?}-{name}"),
                (&scene, &settings),
                floor,
            );
        }
    }
}

/// PSNR in dB, one below the measured values: pre-classified lit and unlit, X-ray.
type ColorFloors = [f64; 3];

#[test]
fn classified_holes_agree_with_the_reference() {
    let ball = Sample::Ball.generate(Some(SampleSize::Longest(32))).unwrap();
    let ball = Scene::new(ball, translucent());
    let head = generated(Sample::Head, 40);
    let cases: [(&str, Scene, Missing, ColorFloors); 5] = [
        ("ball", ball.clone(), Missing::Some, [64.0, 63.0, 65.3]),
        ("ball", ball, Missing::Half, [63.8, 63.0, 64.3]),
        ("head", head.clone(), Missing::None, [51.0, 48.7, 54.2]),
        ("head", head.clone(), Missing::Some, [51.2, 48.7, 54.0]),
        ("head", head, Missing::Half, [52.1, 49.8, 53.8]),
    ];
    for (field, scene, missing, floors) in cases {
        let scene = missing.of(&scene);
        let lit = checked(FlatSettings {
            filter: Filter::None,
            classification: Classification::Pre,
            ..fast(256, 256).into()
        });
        let unlit = RenderSettings {
            lighting: None,
            ..lit
        };
        let xray = checked(FlatSettings {
            compositing: Compositing::Xray,
            ..unlit.into()
        });
        for ((settings, floor), name) in [lit, unlit, xray]
            .into_iter()
            .zip(floors)
            .zip(["lit", "unlit", "xray"])
        {
            assert_agrees(
                &format!("holes-{field}-{missing:?}-pre-{name}"),
                (&scene, &settings),
                floor,
            );
        }
    }
}

/// PSNR in dB, one below the measured values: maximum, minimum and mean of `fast`, and of `best`.
type ValueFloors = [f64; 6];

#[test]
fn values_of_rays_agree_with_the_reference() {
    let cases: [(Missing, bool, ValueFloors); 4] = [
        (Missing::None, false, [59.6, 67.0, 74.0, 90.8, 97.7, 102.0]),
        (Missing::Some, true, [52.1, 55.7, 70.2, 84.7, 92.6, 98.8]),
        (Missing::Half, true, [52.8, 58.6, 68.5, 84.5, 96.1, 72.5]),
        (Missing::Half, false, [58.1, 66.6, 70.6, 91.7, 96.5, 78.1]),
    ];
    for (missing, prefilter, floors) in cases {
        let scene = missing.of(&noise());
        let mut floors = floors.into_iter();
        for (preset, settings) in [("fast", fast(256, 256)), ("best", RenderSettings::best())] {
            for compositing in [Compositing::Mip, Compositing::MinimumIntensity, Compositing::Mean] {
                let settings = checked(FlatSettings {
                    size: fast(256, 256).size,
                    filter: Filter::None,
                    prefilter,
                    compositing,
                    ..settings.into()
                });
                let name = format!("holes-noise-{missing:?}-{preset}-{compositing:?}-{prefilter}");
                assert_agrees(&name, (&scene, &settings), floors.next().unwrap());
            }
        }
    }
}

#[test]
fn nothing_changes_outside_the_reach_of_a_missing_sample() {
    let scene = generated(Sample::Head, 96);
    let camera = framing(&scene, PROJECTIONS[0], 1.0, 1.0);
    let grid = scene.single_volume().unwrap().volume.grid().clone();
    // A voxel that is seen in the middle of the picture.
    let surface = render(&scene, &camera, &fast(300, 300)).depth[150 * 300 + 150];
    let (start, along) = camera
        .screen_from_camera(fast(300, 300).size)
        .ray(glam::DVec2::splat(150.5));
    let seen = camera
        .camera_from_world()
        .inverse()
        .transform_point3(start + along * f64::from(surface));
    let hole = grid
        .world_from_voxel()
        .inverse()
        .transform_point3(seen)
        .round()
        .to_array()
        .map(|c| c as usize);
    let holed = without(&scene, |at| at == hole);
    for settings in [RenderSettings::default(), RenderSettings::best()] {
        let settings = RenderSettings {
            size: fast(300, 300).size,
            ..settings
        };
        // Samples of 32 bits, too.
        let whole = render(&without(&scene, |_| false), &camera, &settings);
        let mut renderer = renderer();
        let mut found = renderer.render(&holed, &camera, &settings).unwrap();
        assert_eq!(renderer.statistics().engine, "sheets");
        let screen = camera.screen_from_camera(settings.size);
        let voxel = DVec3::from_array(hole.map(|c| c as f64));
        let at = camera
            .camera_from_world()
            .transform_point3(grid.world_from_voxel().transform_point3(voxel));
        let scale = screen.scale_at(at.z);
        let centre = screen.project(at);
        let reach = 5.0 * grid.mean_spacing() * scale;
        let mut changed = 0;
        for (i, (found, whole)) in found.image.pixels.iter_mut().zip(&whole.image.pixels).enumerate() {
            let pixel = glam::DVec2::new((i % 300) as f64 + 0.5, (i / 300) as f64 + 0.5);
            if pixel.distance(centre) < reach {
                changed += usize::from(found != whole);
                *found = *whole;
            }
        }
        let figures = Comparison::of(&found.image, &whole.image);
        println!("{changed} pixels within reach, {:.1} dB outside", figures.psnr);
        assert!(changed > 10 && figures.psnr > 70.0);
    }
}

#[test]
fn fog_ends_half_way_to_what_is_missing() {
    let grid = Grid::centred([40, 40, 40], DVec3::ONE).unwrap();
    let whole = Scene::new(sample(&Constant(1.0), &grid), constant_extinction(0.05, [1.0; 3]));
    // A gap in the fog along the view, a layer of two voxels among it.
    let gap = without(&whole, |[_, y, _]| (9..25).contains(&y) || (30..32).contains(&y));
    let towards = DVec3::new(0.0, -100.0, 0.0);
    for projection in [
        Projection::Orthographic { height: 30.0 },
        Projection::Perspective { fov_degrees: 15.0 },
    ] {
        let camera = Camera::new(towards, DVec3::ZERO, DVec3::Z, projection).unwrap();
        for base in [RenderSettings::default(), RenderSettings::best()] {
            for prefilter in [true, false] {
                let settings = checked(FlatSettings {
                    size: fast(64, 64).size,
                    lighting: None,
                    prefilter,
                    ..base.into()
                });
                let frame = render(&gap, &camera, &settings);
                let found = f64::from(frame.optical_depth[32 * 64 + 32]);
                let exact = 0.05 * 22.0;
                println!("{:?} {prefilter}: {found} {exact}", base.method);
                assert!((found / exact - 1.0).abs() < 0.02, "{found} {exact}");
            }
        }
    }
}

#[test]
fn a_volume_of_hardly_any_samples_shows_what_there_is() {
    let scene = generated(Sample::Head, 40);
    let camera = framing(&scene, PROJECTIONS[0], 1.0, 1.0);
    // Air, and a corner of it with another sample, so that values differ.
    let air = without(&scene, |at| at.iter().any(|&c| c > 3));
    let bone = without(&scene, |at| at.iter().any(|&c| !(16..24).contains(&c)));
    for settings in [RenderSettings::default(), RenderSettings::best()] {
        let settings = RenderSettings {
            size: fast(128, 128).size,
            ..settings
        };
        let seen = |scene: &Scene| {
            let frame = renderer().render(scene, &camera, &settings).unwrap();
            assert!(frame.image.pixels.iter().flatten().all(|c| c.is_finite()));
            frame.image.pixels.iter().filter(|p| p[3] > 0.0).count()
        };
        assert_eq!(seen(&air), 0);
        let seen = seen(&bone);
        println!("{seen} pixels of 8^3 samples");
        assert!((10..3000).contains(&seen), "{seen}");
    }
}

#[test]
fn missing_samples_around_the_eye_are_left_out() {
    let scene = noise();
    let bounds = scene.bounds().unwrap();
    let projection = Projection::Perspective { fov_degrees: 60.0 };
    let camera = Camera::new(bounds.centre(), bounds.centre() + DVec3::Y, DVec3::Z, projection).unwrap();
    let framed = Camera::framing(&bounds, View::Iso, projection, 1.0).unwrap();
    let holed = Missing::Some.of(&scene);
    for settings in [fast(96, 96), RenderSettings::best()] {
        let settings = RenderSettings {
            size: fast(96, 96).size,
            lighting: None,
            ..settings
        };
        for camera in [camera, framed] {
            let [found, whole] = [&holed, &scene].map(|scene| render(scene, &camera, &settings).image);
            let figures = Comparison::of(&found, &whole);
            // One of fifty samples is filled from its surroundings, and covers less.
            println!("{:.1} dB, largest {}", figures.psnr, figures.max_error);
            assert!(figures.psnr > 20.0);
        }
    }
}
