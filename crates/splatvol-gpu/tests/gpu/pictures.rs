//! Pictures of the GPU engine against those of the CPU engine, and requests that it refuses.

use splatvol::glam::{DAffine3, DQuat, DVec3};
use splatvol::samples::Sample;
use splatvol::{
    Camera, Classification, Clip, ColorPoint, Compositing, EngineConfig, Filter, FlatSettings, Frame, Grid,
    Item, LengthUnit, OpacityPoint, Projection, RenderSettings, Renderer, Rescale, Samples, Scene,
    TransferFunction, View, Volume,
};
use splatvol_gpu::{GpuConfig, GpuEngine};
use splatvol_testing::{Comparison, Random, Tolerance, assert_images, checked};

use super::common::{
    PROJECTIONS, assert_depths, both, camera, compare, gpu, scene, share_within_a_level, sized,
};

/// Law 3, as far as the cuts of both engines' kernels allow: docs/numerics.md, "The GPU's planes", has what is measured.
#[test]
fn pictures_are_the_cpu_s() {
    let Some(mut gpu) = gpu() else { return };
    let mut cpu = Renderer::new(EngineConfig::default()).unwrap();
    for (sample, decibels, share) in [
        (Sample::Head, 59.0, 0.975),
        (Sample::Ball, 68.0, 0.995),
        (Sample::MarschnerLobb, 50.0, 0.85),
    ] {
        let scene = scene(sample, 32);
        for projection in PROJECTIONS {
            let camera = camera(&scene, projection);
            for (name, settings) in [
                ("fast", RenderSettings::fast()),
                ("balanced", RenderSettings::balanced()),
                ("draft", RenderSettings::draft()),
            ] {
                let settings = sized(settings, 64);
                let own = gpu.render(&scene, &camera, &settings).unwrap();
                let wanted = cpu.render(&scene, &camera, &settings).unwrap();
                let what = format!("gpu-{}-{name}", sample.name());
                // At half of the resolution edges are as steep, and twice as long.
                let (decibels, share) = match name {
                    "draft" => (decibels - 8.0, share - 0.06),
                    _ => (decibels, share),
                };
                assert_images(&what, &own.image, &wanted.image, Tolerance::psnr(decibels));
                let found = share_within_a_level(&own.image, &wanted.image);
                assert!(found >= share, "{what} {projection:?}: {found:.3}");
                assert_depths(&own, &wanted, 1e-3);
            }
        }
    }
}

/// Law 3 of the preset `best`, whose kernels are cut where they are nothing: all but a thousandth of the pixels within a level.
#[test]
fn the_best_pictures_are_the_cpu_s() {
    let Some(mut gpu) = gpu() else { return };
    let mut cpu = Renderer::new(EngineConfig::default()).unwrap();
    for sample in [Sample::Head, Sample::Ball, Sample::MarschnerLobb] {
        let scene = scene(sample, 32);
        for (projection, filter) in [
            (PROJECTIONS[0], Filter::None),
            (PROJECTIONS[1], Filter::Ewa { pixel_sigma: 0.5 }),
        ] {
            let camera = camera(&scene, projection);
            let settings = checked(FlatSettings {
                filter,
                ..sized(RenderSettings::best(), 64).into()
            });
            let what = format!("gpu-best-{}", sample.name());
            let shot = (&scene, &camera, &settings);
            compare((&mut gpu, &mut cpu), shot, &what, (65.0, 0.999, 1e-3));
        }
    }
}

/// Law 3 where voxels are four and more pixels wide, for which the CPU splats onto coarse rasters.
#[test]
fn enlarged_pictures_are_the_cpu_s() {
    let Some((mut gpu, mut cpu)) = both() else { return };
    for (sample, best, fast) in [
        (Sample::Head, (72.0, 0.998), (53.0, 0.9)),
        (Sample::MarschnerLobb, (57.0, 0.93), (49.0, 0.7)),
    ] {
        let scene = scene(sample, 32);
        let camera = Camera::framing(&scene.bounds().unwrap(), View::Top, PROJECTIONS[0], 1.0).unwrap();
        for (name, settings, (decibels, share)) in [
            ("best", RenderSettings::best(), best),
            ("fast", RenderSettings::fast(), fast),
        ] {
            let shot = (&scene, &camera, &sized(settings, 200));
            let what = format!("gpu-enlarged-{}-{name}", sample.name());
            compare((&mut gpu, &mut cpu), shot, &what, (decibels, share, 1e-3));
        }
    }
}

#[test]
fn values_of_rays_are_the_cpu_s() {
    let Some(mut gpu) = gpu() else { return };
    let mut cpu = Renderer::new(EngineConfig::default()).unwrap();
    for compositing in [Compositing::Mip, Compositing::MinimumIntensity, Compositing::Mean] {
        for (name, preset, decibels, share) in [
            ("fast", RenderSettings::fast(), [48.0, 38.0], [0.9, 0.5]),
            ("best", RenderSettings::best(), [65.0, 65.0], [0.999, 0.999]),
        ] {
            let settings = checked(FlatSettings {
                compositing,
                ..sized(preset, 64).into()
            });
            for (i, sample) in [Sample::Head, Sample::MarschnerLobb].into_iter().enumerate() {
                let scene = scene(sample, 32);
                let camera = camera(&scene, PROJECTIONS[i]);
                let what = format!("gpu-{compositing:?}-{name}-{}", sample.name());
                let shot = (&scene, &camera, &settings);
                compare((&mut gpu, &mut cpu), shot, &what, (decibels[i], share[i], 1e-3));
            }
        }
    }
}

/// Voxels are classified, then splatted.
const CLASSIFIED_FIRST: [(&str, Classification, Compositing); 2] = [
    ("pre", Classification::Pre, Compositing::ImageSheets),
    ("xray", Classification::Post, Compositing::Xray),
];

/// X-rays and pre-classified pictures, lit and cut, of voxels and of their means.
#[test]
fn voxels_that_are_classified_first_are_the_cpu_s() {
    let Some(mut gpu) = gpu() else { return };
    let mut cpu = Renderer::new(EngineConfig::default()).unwrap();
    for (look, classification, compositing) in CLASSIFIED_FIRST {
        for (name, preset, size, decibels, share) in [
            ("fast", RenderSettings::fast(), 64, 50.0, 0.91),
            ("best", RenderSettings::best(), 64, 62.0, 0.98),
            // A pixel is three voxels, so levels are means.
            ("far", RenderSettings::balanced(), 13, 38.0, 0.55),
        ] {
            let settings = checked(FlatSettings {
                classification,
                compositing,
                ..sized(preset, size).into()
            });
            for (i, projection) in PROJECTIONS.into_iter().enumerate() {
                let mut scene = scene(Sample::Head, 32);
                let camera = camera(&scene, projection);
                if i > 0 {
                    let centre = scene.bounds().unwrap().centre();
                    scene.clips.push(Clip::plane(centre, [0.31, 1.0, 0.113]).unwrap());
                }
                let what = format!("gpu-{look}-{name}-{i}");
                let shot = (&scene, &camera, &settings);
                compare((&mut gpu, &mut cpu), shot, &what, (decibels, share, 1e-2));
            }
        }
    }
}

/// Two balls of labels, one within the other.
fn labels() -> Scene {
    let edge = 30;
    let label = |i: usize| {
        let place = [i % edge, i / edge % edge, i / (edge * edge)];
        let from_middle = place.map(|at| at as f64 - 14.5);
        let distance = from_middle.iter().map(|d| d * d).sum::<f64>().sqrt();
        3 * u8::from(distance < 12.0) - 2 * u8::from(distance < 7.0)
    };
    let samples: Vec<u8> = (0..edge * edge * edge).map(label).collect();
    let grid = Grid::centred([edge; 3], [1.0; 3]).unwrap();
    let unit = LengthUnit::Millimetre;
    let volume = Volume::new(grid, Samples::U8(samples.into()), Rescale::default(), unit).unwrap();
    let colors = vec![
        ColorPoint::new(1.0, [0.9, 0.2, 0.1]),
        ColorPoint::new(3.0, [0.2, 0.5, 0.9]),
    ];
    let opacities = vec![
        OpacityPoint::new(0.0, 0.0),
        OpacityPoint::new(1.0, 0.9),
        OpacityPoint::new(3.0, 0.2),
    ];
    Scene::from(Item::labels(
        volume,
        TransferFunction::new(colors, opacities, Some(1.0)).unwrap(),
    ))
}

#[test]
fn labels_are_the_cpu_s() {
    let Some(mut gpu) = gpu() else { return };
    let mut cpu = Renderer::new(EngineConfig::default()).unwrap();
    let scene = labels();
    let (fast, best) = (RenderSettings::fast(), RenderSettings::best());
    // From afar voxels are means, and the light on them a share.
    for (name, preset, pixels, bounds) in [
        ("fast", fast, 64, (70.0, 0.999, 1e-2)),
        ("best", best, 64, (70.0, 0.999, 1e-2)),
        ("far", fast, 14, (38.0, 0.6, 1e-2)),
        ("far-best", best, 14, (65.0, 0.99, 1e-2)),
    ] {
        let camera = camera(&scene, PROJECTIONS[0]);
        let settings = sized(preset, pixels);
        let what = format!("gpu-labels-{name}");
        let shot = (&scene, &camera, &settings);
        compare((&mut gpu, &mut cpu), shot, &what, bounds);
        assert_eq!(cpu.statistics().level > 0, pixels < 30, "{name}");
    }
}

/// A head of which a ball and some scattered samples are missing.
fn head_with_holes() -> Scene {
    let scene = scene(Sample::Head, 32);
    let single = scene.single_volume().unwrap();
    let (volume, look) = (single.volume, single.transfer_function.clone());
    let value = |i: usize| {
        let place = [i % 32, i / 32 % 32, i / 1024].map(|at| at as f64);
        let from_hole = [place[0] - 12.0, place[1] - 6.0, place[2] - 18.0];
        let is_missing =
            from_hole.iter().map(|d| d * d).sum::<f64>() < 36.0 || (i * 7919).is_multiple_of(101);
        if is_missing {
            f32::NAN
        } else {
            volume.value(i) as f32
        }
    };
    let samples: Vec<f32> = (0..32 * 32 * 32).map(value).collect();
    let grid = volume.grid().clone();
    let unit = LengthUnit::Millimetre;
    let volume = Volume::new(grid, Samples::F32(samples.into()), Rescale::default(), unit).unwrap();
    Scene::new(volume, look)
}

#[test]
fn missing_samples_are_the_cpu_s() {
    let Some(mut gpu) = gpu() else { return };
    let mut cpu = Renderer::new(EngineConfig::default()).unwrap();
    let whole = head_with_holes();
    let mut cut = whole.clone();
    let centre = whole.bounds().unwrap().centre();
    cut.clips.push(Clip::plane(centre, [0.31, 1.0, 0.113]).unwrap());
    let shows = |preset, compositing| {
        checked(FlatSettings {
            compositing,
            ..sized(preset, 64).into()
        })
    };
    let (fast, best) = (RenderSettings::fast(), RenderSettings::best());
    for (name, scene, settings, decibels, share) in [
        ("fast", &whole, sized(fast, 64), 50.0, 0.92),
        ("best", &whole, sized(best, 64), 80.0, 0.999),
        ("cut", &cut, sized(fast, 64), 50.0, 0.95),
        ("mip", &whole, shows(fast, Compositing::Mip), 48.0, 0.86),
        ("best-mip", &whole, shows(best, Compositing::Mip), 78.0, 0.999),
        ("best-mean", &whole, shows(best, Compositing::Mean), 95.0, 0.999),
        ("xray", &whole, shows(fast, Compositing::Xray), 50.0, 0.93),
    ] {
        for projection in PROJECTIONS {
            let camera = camera(scene, projection);
            let what = format!("gpu-holes-{name}");
            let shot = (scene, &camera, &settings);
            compare((&mut gpu, &mut cpu), shot, &what, (decibels, share, 2e-3));
        }
    }
}

/// Several volumes share planes: their extinctions add up.
#[test]
fn volumes_together_are_the_cpu_s() {
    let Some(mut gpu) = gpu() else { return };
    let mut cpu = Renderer::new(EngineConfig::default()).unwrap();
    let head = scene(Sample::Head, 32);
    let place = |scene: Scene, at: DAffine3| scene.items.into_iter().next().unwrap().at(at);
    let span = head.bounds().unwrap().max[0] - head.bounds().unwrap().min[0];
    let of_ball = scene(Sample::Ball, 24);
    let scale = span / (of_ball.bounds().unwrap().max[0] - of_ball.bounds().unwrap().min[0]);
    let turned = DAffine3::from_scale_rotation_translation(
        DVec3::splat(0.7 * scale),
        DQuat::from_rotation_z(0.4),
        DVec3::new(0.2 * span, -0.3 * span, 0.1 * span),
    );
    let mut both = head.clone();
    both.items.push(place(of_ball, turned));
    let mut with_labels = both.clone();
    // Their voxels are as large as the head's.
    let moved = DAffine3::from_scale_rotation_translation(
        DVec3::splat(span / 32.0),
        DQuat::IDENTITY,
        DVec3::new(-0.2 * span, 0.1 * span, 0.3 * span),
    );
    with_labels.items.push(place(labels(), moved));
    let mut cut = with_labels.clone();
    let centre = head.bounds().unwrap().centre();
    cut.clips.push(Clip::plane(centre, [0.31, 1.0, 0.113]).unwrap());
    let pre = checked(FlatSettings {
        classification: Classification::Pre,
        ..sized(RenderSettings::fast(), 64).into()
    });
    for (name, scene, settings, decibels, share) in [
        ("fast", &both, sized(RenderSettings::fast(), 64), 48.0, 0.95),
        ("best", &both, sized(RenderSettings::best(), 64), 78.0, 0.999),
        (
            "best-labels",
            &with_labels,
            sized(RenderSettings::best(), 64),
            75.0,
            0.999,
        ),
        ("cut", &cut, sized(RenderSettings::fast(), 64), 45.0, 0.92),
        ("pre", &with_labels, pre, 50.0, 0.9),
        ("far", &with_labels, sized(RenderSettings::fast(), 13), 32.0, 0.55),
    ] {
        let camera = camera(scene, PROJECTIONS[0]);
        let what = format!("gpu-together-{name}");
        let shot = (scene, &camera, &settings);
        compare((&mut gpu, &mut cpu), shot, &what, (decibels, share, 2e-3));
    }
}

/// A camera at a place in a scene's box, as shares of its edges.
fn camera_within(scene: &Scene, from: DVec3, to: DVec3) -> Camera {
    let bounds = scene.bounds().unwrap();
    let [eye, target] = [from, to].map(|share| bounds.min + share * (bounds.max - bounds.min));
    let projection = Projection::Perspective { fov_degrees: 60.0 };
    Camera::new(eye, target, [0.0, 0.0, 1.0], projection).unwrap()
}

/// Where all is dense, a picture shows the values at one place, of which it has the errors: pictures from many places are
/// compared.
#[test]
fn fast_pictures_from_within_are_mostly_the_cpu_s() {
    let Some(mut gpu) = gpu() else { return };
    let mut cpu = Renderer::new(EngineConfig::default()).unwrap();
    for (name, scene) in [("head", scene(Sample::Head, 32)), ("holes", head_with_holes())] {
        let mut random = Random::new(5);
        let mut found: Vec<f64> = (0..16)
            .map(|_| {
                let mut place = || DVec3::new(random.unit(), random.unit(), random.unit());
                let (from, to) = (0.1 + 0.8 * place(), place());
                let camera = camera_within(&scene, from, to);
                let settings = sized(RenderSettings::fast(), 64);
                let own = gpu.render(&scene, &camera, &settings).unwrap();
                let wanted = cpu.render(&scene, &camera, &settings).unwrap();
                Comparison::of(&own.image, &wanted.image).psnr
            })
            .collect();
        found.sort_by(f64::total_cmp);
        println!("gpu-within-{name}: {found:.1?} dB");
        assert!(found[0] > 30.0 && found[8] > 48.0, "{name}: {found:.1?}");
    }
}

#[test]
fn pictures_from_within_are_the_cpu_s() {
    let Some(mut gpu) = gpu() else { return };
    let mut cpu = Renderer::new(EngineConfig::default()).unwrap();
    let scene = scene(Sample::Head, 32);
    let camera = camera_within(&scene, DVec3::splat(0.45), DVec3::ONE);
    let settings = sized(RenderSettings::best(), 64);
    let shot = (&scene, &camera, &settings);
    // Relative to depths of a tenth of the planes' distance.
    let limits = (65.0, 0.999, 1e-2);
    compare((&mut gpu, &mut cpu), shot, "gpu-within-best", limits);
    for (look, classification, compositing) in CLASSIFIED_FIRST {
        let settings = checked(FlatSettings {
            classification,
            compositing,
            ..sized(RenderSettings::best(), 64).into()
        });
        let what = format!("gpu-within-{look}");
        let shot = (&scene, &camera, &settings);
        compare((&mut gpu, &mut cpu), shot, &what, (53.0, 0.93, 1e-1));
    }
}

#[test]
fn pictures_are_repeated_to_the_bit_after_an_edit_and_back() {
    let Some(mut gpu) = gpu() else { return };
    let scene = scene(Sample::Head, 32);
    let camera = camera(&scene, PROJECTIONS[0]);
    let settings = sized(RenderSettings::fast(), 48);
    let first = gpu.render(&scene, &camera, &settings).unwrap();
    let mut other = scene.clone();
    *other.transfer_function_mut().unwrap() = splatvol_testing::transfer::constant_extinction(0.02, [0.4; 3]);
    let between = gpu.render(&other, &camera, &settings).unwrap();
    assert_ne!(first.image.pixels, between.image.pixels);
    // A renderer of another size between them.
    gpu.render(&scene, &camera, &sized(settings, 20)).unwrap();
    let again = gpu.render(&scene, &camera, &settings).unwrap();
    assert_eq!(first.image.pixels, again.image.pixels);
    assert_eq!(first.depth, again.depth);
    assert_eq!(gpu.statistics().engine, "gpu");
}

/// Close to a volume its levels lie behind each other, each fading into the next.
#[test]
fn levels_behind_each_other_are_the_cpu_s() {
    let Some(mut gpu) = gpu() else { return };
    let mut cpu = Renderer::new(EngineConfig::default()).unwrap();
    // Of thin shells, close, the cuts of kernels show more.
    for (sample, of_values, of_classes) in [(Sample::Ball, 53.0, 70.0), (Sample::Shells, 44.0, 62.0)] {
        let scene = scene(sample, 96);
        let bounds = scene.bounds().unwrap();
        let size = bounds.max - bounds.min;
        let eye = bounds.centre() + DVec3::new(0.1, -0.5, 0.05) * size;
        let target = bounds.centre() + DVec3::new(-0.1, 0.5, 0.0) * size;
        let wide = Projection::Perspective { fov_degrees: 70.0 };
        let camera = Camera::new(eye, target, DVec3::Z, wide).unwrap();
        let fast = sized(RenderSettings::fast(), 64);
        let pre = checked(FlatSettings {
            classification: Classification::Pre,
            ..fast.into()
        });
        for (name, settings, decibels) in [("post", fast, of_values), ("pre", pre, of_classes)] {
            let own = gpu.render(&scene, &camera, &settings).unwrap();
            let wanted = cpu.render(&scene, &camera, &settings).unwrap();
            assert_eq!(gpu.statistics().levels, cpu.statistics().levels);
            assert!(gpu.statistics().levels > 1);
            let what = format!("gpu-by-depth-{}-{name}", sample.name());
            assert_images(&what, &own.image, &wanted.image, Tolerance::psnr(decibels));
            let again = gpu.render(&scene, &camera, &settings).unwrap();
            assert_eq!(own.image.pixels, again.image.pixels, "{what}");
        }
    }
}

/// X-rays of several volumes: optical depths are the sums of each volume's own, and pictures the CPU's.
#[test]
fn x_rays_of_volumes_add_up() {
    let Some(mut gpu) = gpu() else { return };
    let mut cpu = Renderer::new(EngineConfig::default()).unwrap();
    let settings = checked(FlatSettings {
        compositing: Compositing::Xray,
        ..sized(RenderSettings::fast(), 64).into()
    });
    let of_shells = scene(Sample::Shells, 32);
    let mut of_ball = scene(Sample::Ball, 24);
    *of_ball.transfer_function_mut().unwrap() =
        splatvol_testing::transfer::constant_extinction(0.1, [0.2, 0.6, 0.9]);
    let span = |scene: &Scene| scene.bounds().unwrap().max[0] - scene.bounds().unwrap().min[0];
    let beside = DAffine3::from_scale_rotation_translation(
        DVec3::splat(0.6 * span(&of_shells) / span(&of_ball)),
        DQuat::from_rotation_z(0.4),
        DVec3::new(0.2, -0.3, 0.1) * span(&of_shells),
    );
    let ball = of_ball.items.remove(0).at(beside);
    let both = Scene::of_items(vec![of_shells.items[0].clone(), ball.clone()]).unwrap();
    let camera = camera(&both, PROJECTIONS[0]);
    let mut own = |scene: &Scene| gpu.render(scene, &camera, &settings).unwrap();
    let [of_shells, of_ball, of_both] = [&of_shells, &Scene::from(ball), &both].map(&mut own);
    let seen = |frame: &Frame| frame.optical_depth.iter().filter(|&&depth| depth > 0.01).count();
    assert!(
        seen(&of_shells) > 400 && seen(&of_ball) > 100,
        "{} {}",
        seen(&of_shells),
        seen(&of_ball)
    );
    // The planes of both are those of the finer one.
    let parts = of_shells.optical_depth.iter().zip(&of_ball.optical_depth);
    for ((a, b), found) in parts.zip(&of_both.optical_depth) {
        assert!((a + b - found).abs() < 2e-3 * (1.0 + found), "{a} + {b}: {found}");
    }
    let wanted = cpu.render(&both, &camera, &settings).unwrap();
    assert_images("gpu-x-rays", &of_both.image, &wanted.image, Tolerance::psnr(42.0));
}

/// Pages that another look leaves as they are stay on the device; others come, go, and change.
#[test]
fn edited_pictures_are_those_of_a_new_engine() {
    let Some(mut kept) = gpu() else { return };
    let mut scene = scene(Sample::Head, 40);
    let camera = camera(&scene, PROJECTIONS[0]);
    let settings = sized(RenderSettings::fast(), 48);
    let looks = [[0.2, 1.0], [0.22, 1.0], [0.6, 1.0], [0.22, 1.0], [0.1, 1.0]];
    for (at, range) in looks.into_iter().enumerate() {
        let color = [0.9, 0.2 * at as f64, 0.3];
        *scene.transfer_function_mut().unwrap() =
            splatvol_testing::transfer::linear_extinction(range, 2.0, color);
        let Some(mut fresh) = gpu() else { return };
        let wanted = fresh.render(&scene, &camera, &settings).unwrap();
        let found = kept.render(&scene, &camera, &settings).unwrap();
        assert_eq!(found.image.pixels, wanted.image.pixels, "{at}");
        assert_eq!(found.depth, wanted.depth, "{at}");
    }
}

/// What a pixel has of planes is made again where a dispatch ends; what it has of the picture, and of cuts, is kept.
#[test]
fn pictures_do_not_depend_on_how_they_are_divided() {
    let Some(mut whole) = gpu() else { return };
    let divided = GpuConfig {
        samples_per_dispatch: Some(1),
        ..GpuConfig::default()
    };
    let mut divided = Renderer::with_engine(GpuEngine::new(&divided).unwrap());
    let plain = scene(Sample::Head, 32);
    let camera = camera(&plain, PROJECTIONS[0]);
    let mut cut = plain.clone();
    cut.clips
        .push(Clip::plane(plain.bounds().unwrap().centre(), [0.4, 1.0, 0.2]).unwrap());
    let mean = checked(FlatSettings {
        compositing: Compositing::Mean,
        ..sized(RenderSettings::fast(), 40).into()
    });
    let [pre, xray] = CLASSIFIED_FIRST.map(|(_, classification, compositing)| {
        checked(FlatSettings {
            classification,
            compositing,
            ..sized(RenderSettings::fast(), 40).into()
        })
    });
    let mut together = cut.clone();
    together.items.push(plain.items[0].clone());
    for (scene, settings) in [
        (&plain, sized(RenderSettings::fast(), 40)),
        (&plain, sized(RenderSettings::best(), 40)),
        (&plain, mean),
        (&cut, pre),
        (&plain, xray),
        (&together, sized(RenderSettings::fast(), 40)),
        (&cut, sized(RenderSettings::fast(), 40)),
    ] {
        let [one, many] =
            [&mut whole, &mut divided].map(|renderer| renderer.render(scene, &camera, &settings).unwrap());
        assert!(one.image.pixels == many.image.pixels && one.depth == many.depth);
    }
}

/// A budget too small for all pages gives the same picture by turns.
#[test]
fn pictures_do_not_depend_on_the_budget() {
    let Some(mut whole) = gpu() else { return };
    let plain = scene(Sample::Head, 96);
    let camera = camera(&plain, PROJECTIONS[0]);
    let mut together = plain.clone();
    together.items.push(scene(Sample::Ball, 40).items[0].clone());
    for (scene, settings, slots) in [
        (&plain, sized(RenderSettings::fast(), 160), 100),
        (&plain, sized(RenderSettings::best(), 64), 100),
        (&together, sized(RenderSettings::fast(), 160), 100),
    ] {
        let taps = if settings == sized(RenderSettings::best(), 64) {
            6
        } else {
            4
        };
        let paged = GpuConfig {
            budget: Some(slots * (15usize + taps).pow(3) * 4),
            ..GpuConfig::default()
        };
        let mut paged = Renderer::with_engine(GpuEngine::new(&paged).unwrap());
        let [all, some] =
            [&mut whole, &mut paged].map(|renderer| renderer.render(scene, &camera, &settings).unwrap());
        assert!(all.image.pixels == some.image.pixels && all.depth == some.depth);
        let [most, least] = [&whole, &paged].map(|renderer| renderer.statistics().memory.device);
        assert!(3 * least < 2 * most, "{least} {most}");
        // And again, from the pages that the last picture left.
        let again = paged.render(scene, &camera, &settings).unwrap();
        assert!(again.image.pixels == some.image.pixels);
    }
}

#[test]
fn what_is_not_drawn_is_refused_by_name() {
    let Some(mut gpu) = gpu() else { return };
    let scene = scene(Sample::Ball, 16);
    let outside = camera(&scene, PROJECTIONS[0]);
    let fast = sized(RenderSettings::fast(), 16);
    let mut refused = |scene: &Scene, camera: &Camera, settings: &RenderSettings, word: &str| {
        let error = gpu.render(scene, camera, settings).unwrap_err().to_string();
        assert!(error.contains(word), "{word}: {error}");
    };
    refused(&scene, &outside, &sized(RenderSettings::swan1997(), 16), "sheets");
    let mut clipped = scene.clone();
    clipped
        .clips
        .push(Clip::plane([0.0; 3], [1.0, 0.0, 0.0]).unwrap());
    refused(&clipped, &outside, &sized(RenderSettings::best(), 16), "clips");
    let small = GpuConfig {
        budget: Some(30_000),
        ..GpuConfig::default()
    };
    let mut small = Renderer::with_engine(GpuEngine::new(&small).unwrap());
    let error = small.render(&scene, &outside, &fast).unwrap_err().to_string();
    assert!(error.contains("budget"), "{error}");
    let none = GpuConfig {
        adapter: Some("no such adapter".to_owned()),
        ..GpuConfig::default()
    };
    let error = GpuEngine::new(&none).unwrap_err().to_string();
    assert!(error.contains("no such adapter"), "{error}");
}
