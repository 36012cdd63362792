//! An operator that does nothing leaves the picture visually unchanged; the bytes do not depend on threads or
//! instructions; refusals.

use glam::DVec3;
use splatvol::{
    Bounds, BumpMap, Camera, Classification, Clip, Compositing, EngineConfig, EnvironmentMap, FlatSettings,
    Frame, Gradient, GradientOpacity, GradientOpacityPoint, Image, ImageSize, Isosurface, Keep,
    RenderSettings, Renderer, Scene, SimdLevel, SolidTexture, Stuff,
};
use splatvol_samples::{Sample, SampleSize};
use splatvol_testing::{checked, compare::Comparison};

use super::support::{Identity, ball, cameras, gaussian, solid, unlit};

fn generated(kind: Sample) -> Scene {
    let volume = kind.generate(Some(SampleSize::Longest(48))).unwrap();
    Scene::new(volume, kind.default_transfer_function().unwrap())
}

fn framing(scene: &Scene, projection: splatvol::Projection) -> Camera {
    Camera::framing(&scene.bounds().unwrap(), splatvol::View::Iso, projection, 1.0).unwrap()
}

#[test]
fn an_operator_that_does_nothing_changes_nothing_to_be_seen() {
    let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
    for (name, scene) in [
        ("head", generated(Sample::Head)),
        ("shells", generated(Sample::Shells)),
        ("marschner-lobb", generated(Sample::MarschnerLobb)),
        ("ball", Scene::new(ball(18.0), solid(0.0, 0.3))),
    ] {
        for (i, camera) in cameras().into_iter().enumerate() {
            let camera = if name == "ball" {
                camera
            } else {
                framing(&scene, camera.projection())
            };
            for lighting in [None, Some(splatvol::Lighting::default())] {
                let settings = RenderSettings {
                    lighting,
                    ..unlit(160)
                };
                let plain = renderer.render(&scene, &camera, &settings).unwrap();
                let operated = scene.clone().with_operator(Identity);
                let found = renderer.render(&operated, &camera, &settings).unwrap();
                let psnr = Comparison::of(&found.image, &plain.image).psnr;
                let lit = lighting.is_some();
                println!("{name} {i} lit {lit}: {psnr:.1} dB");
                assert!(psnr >= 50.0, "{name} {i} lit {lit}: {psnr}");
                let alpha = |frame: &Frame| frame.image.pixels.iter().map(|p| p[3]).sum::<f32>();
                assert!(alpha(&plain) > 100.0, "something is seen");
            }
        }
    }
}

/// Every operator, cuts of both kinds.
fn busy() -> Scene {
    let scene = Scene::new(gaussian(9.0), solid(0.2, 0.4));
    let bounds = scene.bounds().unwrap();
    let size = ImageSize::new(16, 8).unwrap();
    let pixels = (0..128)
        .map(|i| {
            let v = (i * 37 % 101) as f32 / 101.0;
            [v, 1.0 - v, 0.5, 1.0]
        })
        .collect();
    let image = Image::from_pixels(size, pixels).unwrap();
    let hole = Bounds {
        min: DVec3::new(-3.0, -40.0, -3.0),
        max: DVec3::new(4.0, 40.0, 5.0),
    };
    let points =
        [(0.0, 0.2), (0.05, 1.0)].map(|(gradient, factor)| GradientOpacityPoint { gradient, factor });
    scene
        .with_operator(GradientOpacity::new(&points).unwrap())
        .with_operator(SolidTexture::new(Stuff::Marble, &bounds, 0.1).unwrap())
        .with_operator(BumpMap::new(&image, &bounds, 0.02).unwrap())
        .with_operator(EnvironmentMap::new(&image, 0.3).unwrap())
        .with_clip(Clip::plane(DVec3::new(2.0, 0.0, 3.0), DVec3::new(-1.0, 0.3, -0.5)).unwrap())
        .with_clip(Clip::of_box(&hole, Keep::Outside).unwrap())
}

fn bits(frame: &Frame) -> Vec<u32> {
    let pixels = frame.image.pixels.iter().flatten();
    pixels
        .chain(&frame.depth)
        .chain(&frame.optical_depth)
        .map(|v| v.to_bits())
        .collect()
}

#[test]
fn threads_tiles_and_instructions_do_not_change_a_bit() {
    let surfaces = [(0.3, 0.4), (0.7, 1.0)].map(|(value, opacity)| Isosurface {
        value,
        rgb: [0.9, 0.6, 0.3],
        opacity,
    });
    let isosurfaces = Scene::of_isosurfaces(gaussian(9.0), &surfaces).unwrap();
    let settings = RenderSettings {
        size: ImageSize::new(150, 134).unwrap(),
        ..RenderSettings::default()
    };
    let frames = |config: EngineConfig| {
        let mut renderer = Renderer::new(config).unwrap();
        let mut frames = Vec::new();
        for scene in [&busy(), &isosurfaces] {
            for camera in cameras() {
                frames.push(bits(&renderer.render(scene, &camera, &settings).unwrap()));
            }
        }
        frames
    };
    let expected = frames(EngineConfig {
        threads: Some(1),
        ..EngineConfig::default()
    });
    let mut configs = vec![EngineConfig {
        threads: Some(3),
        ..EngineConfig::default()
    }];
    configs.extend([16, 48, 64].map(|edge| EngineConfig {
        threads: Some(2),
        tile_edge: Some(edge),
        ..EngineConfig::default()
    }));
    configs.extend(
        SimdLevel::ALL
            .into_iter()
            .filter(|simd| simd.is_available())
            .map(|simd| EngineConfig {
                simd: Some(simd),
                ..EngineConfig::default()
            }),
    );
    for config in configs {
        assert!(frames(config) == expected, "{config:?}");
    }
}

/// Clips that leave all of a pixel's material change no bit of it.
#[test]
fn clips_change_no_bit_where_they_cut_nothing() {
    let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
    let settings = RenderSettings {
        lighting: Some(splatvol::Lighting::default()),
        ..unlit(160)
    };
    for scene in [generated(Sample::Head), generated(Sample::Shells)] {
        let camera = framing(&scene, splatvol::Projection::default());
        let bounds = scene.bounds().unwrap();
        let larger = Bounds {
            min: bounds.min - DVec3::splat(60.0),
            max: bounds.max + DVec3::splat(60.0),
        };
        let beside = Bounds {
            min: bounds.max + DVec3::splat(60.0),
            max: bounds.max + DVec3::splat(70.0),
        };
        let plain = renderer.render(&scene, &camera, &settings).unwrap();
        let whole = scene
            .clone()
            .with_clip(Clip::of_box(&larger, Keep::Inside).unwrap())
            .with_clip(Clip::of_box(&beside, Keep::Outside).unwrap());
        assert!(renderer.render(&whole, &camera, &settings).unwrap() == plain);
    }
}

#[test]
fn a_flat_bump_map_and_a_mirror_without_share_change_no_bit() {
    let size = ImageSize::new(8, 4).unwrap();
    let image = Image::filled(size, [0.7, 0.7, 0.7, 1.0]);
    let scene = Scene::new(ball(18.0), solid(0.0, 0.9));
    let bounds = scene.bounds().unwrap();
    let same = scene
        .clone()
        .with_operator(BumpMap::new(&image, &bounds, 0.5).unwrap())
        .with_operator(EnvironmentMap::new(&image, 0.0).unwrap());
    let settings = RenderSettings {
        lighting: Some(splatvol::Lighting::default()),
        ..unlit(96)
    };
    let [camera, _] = cameras();
    let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
    let plain = renderer
        .render(&scene.with_operator(Identity), &camera, &settings)
        .unwrap();
    let found = renderer.render(&same, &camera, &settings).unwrap();
    assert!(Comparison::of(&found.image, &plain.image).max_error < 1e-6);
}

#[test]
fn what_cannot_be_shown_is_refused_with_the_reason() {
    let operated = Scene::new(ball(18.0), solid(0.0, 0.9)).with_operator(Identity);
    let clip = Clip::plane(DVec3::ZERO, DVec3::X).unwrap();
    let clipped = Scene::new(ball(18.0), solid(0.0, 0.9)).with_clip(clip);
    let base = unlit(32);
    let mip = checked(FlatSettings {
        compositing: Compositing::Mip,
        ..base.into()
    });
    let xray = checked(FlatSettings {
        compositing: Compositing::Xray,
        ..base.into()
    });
    let pre = checked(FlatSettings {
        classification: Classification::Pre,
        ..base.into()
    });
    let analytic = checked(FlatSettings {
        gradient: Gradient::Analytic,
        ..base.into()
    });
    let per_splat = checked(FlatSettings {
        compositing: Compositing::PerSplat,
        classification: Classification::Pre,
        prefilter: false,
        ..base.into()
    });
    let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
    let [camera, _] = cameras();
    for (scene, settings, words) in [
        (&clipped, per_splat, "whole footprints and sections of them"),
        (&operated, mip, "an operator (texture"),
        (&operated, xray, "X-rays have no sheets"),
        (&operated, pre, "use post-classification"),
        (&operated, analytic, "use gradients by differences"),
        (&clipped, mip, "a clip cannot be rendered: maximum, minimum"),
        (&clipped, analytic, "use gradients by differences"),
    ] {
        let error = renderer
            .render(scene, &camera, &settings)
            .unwrap_err()
            .to_string();
        assert!(error.contains(words), "{error}");
    }
    let analytic = |settings: RenderSettings| {
        checked(FlatSettings {
            gradient: Gradient::Analytic,
            ..settings.into()
        })
    };
    for settings in [base, xray, pre, analytic(xray), analytic(pre)] {
        assert!(renderer.render(&clipped, &camera, &settings).is_ok());
    }
    let none = Scene::of_isosurfaces(ball(18.0), &[]).unwrap_err().to_string();
    assert!(none.contains("isosurfaces"), "{none}");
}
