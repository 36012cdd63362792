//! Motion blur of footprints against the mean of many pictures.

use glam::{DMat3, DVec3, EulerRot};
use splatvol::{
    Absorption, Alignment, Camera, Classification, Compositing, EngineConfig, Filter, FlatSettings, Frame,
    Grid, ImageSize, Kernel, LengthUnit, Motion, MotionBlur, RenderSettings, Renderer, Rescale, Samples,
    Scene, Volume,
};
use splatvol_samples::{Sample, SampleSize};
use splatvol_testing::{Comparison, sample};
use splatvol_testing::{checked, fields::Noise};

use crate::common::{self, PROJECTIONS};
use crate::fast::support::{bits, framing, translucent};

fn settings(pixels: u32, motion_blur: MotionBlur) -> RenderSettings {
    checked(FlatSettings {
        classification: Classification::Pre,
        filter: Filter::None,
        termination: 0.0,
        motion_blur,
        ..common::settings(pixels).into()
    })
}

/// A look in which each voxel absorbs little light.
fn faint(volume: Volume) -> Scene {
    let mut look = translucent();
    look.unit_distance = Some(20.0 * volume.grid().mean_spacing());
    Scene::new(volume, look)
}

fn ball() -> Scene {
    faint(Sample::Ball.generate(Some(SampleSize::Longest(18))).unwrap())
}

fn small_noise() -> Scene {
    let direction = DMat3::from_euler(EulerRot::XYZ, 0.3, 0.5, -0.2);
    let grid = Grid::new([16, 20, 12], DVec3::ZERO, DVec3::new(1.0, 0.8, 1.5), direction).unwrap();
    faint(sample(&Noise::new(7, 40, DVec3::splat(1.2)), &grid))
}

/// A tenth of the volume's diagonal.
fn linear(scene: &Scene) -> Motion {
    let far = 0.1 * scene.bounds().unwrap().diagonal();
    Motion::Linear(far * DVec3::new(0.6, 0.3, -0.74))
}

/// Twenty degrees about an axis beside the centre.
fn spin(scene: &Scene) -> Motion {
    let bounds = scene.bounds().unwrap();
    Motion::Spin {
        axis: DVec3::new(0.2, 0.1, 1.0),
        centre: bounds.centre() + 0.5 * bounds.diagonal() * DVec3::X,
        angle: 20_f64.to_radians(),
    }
}

fn moving(scene: &Scene, motion: Motion) -> Scene {
    scene.clone().with_motion(&motion)
}

fn psnr(a: &Frame, b: &Frame) -> f64 {
    Comparison::of(&a.image, &b.image).psnr
}

#[test]
fn exact_blur_is_the_mean_of_256_pictures() {
    let [perspective, orthographic] = PROJECTIONS;
    let mut failed = Vec::new();
    for (name, scene, motion, projection) in [
        ("ball, linear", ball(), linear(&ball()), perspective),
        ("ball, spin", ball(), spin(&ball()), orthographic),
        (
            "noise, linear",
            small_noise(),
            linear(&small_noise()),
            orthographic,
        ),
        ("noise, spin", small_noise(), spin(&small_noise()), perspective),
    ] {
        let scene = moving(&scene, motion);
        let camera = framing(&scene, projection, 1.0, 0.8);
        let frame = |motion_blur| common::render(&scene, &camera, &settings(56, motion_blur));
        let mean = frame(MotionBlur::Subframes { count: 256 });
        let [exact, capsule, none] =
            [MotionBlur::Exact, MotionBlur::Capsule, MotionBlur::None].map(|m| psnr(&frame(m), &mean));
        println!("{name}: exact {exact:.1} dB, capsule {capsule:.1} dB, none {none:.1} dB");
        if exact < 40.0 || exact < none + 6.0 || exact < capsule + 6.0 {
            failed.push(format!("{name}: {exact:.1}"));
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

/// Sum of the optical depth over the picture.
fn energy(frame: &Frame) -> f64 {
    frame.optical_depth.iter().map(|&tau| f64::from(tau)).sum()
}

#[test]
fn x_rays_keep_their_energy_and_capsules_gain() {
    let scene = small_noise();
    let camera = framing(&scene, PROJECTIONS[1], 1.0, 0.6);
    for filter in [Filter::default(), Filter::Swan, Filter::None] {
        for motion in [linear(&scene), spin(&scene)] {
            let scene = moving(&scene, motion);
            let frame = |motion_blur| {
                let settings = checked(FlatSettings {
                    compositing: Compositing::Xray,
                    // Whole footprints for the still picture, too.
                    alignment: Alignment::Affine,
                    filter,
                    ..settings(96, motion_blur).into()
                });
                energy(&common::render(&scene, &camera, &settings))
            };
            let still = frame(MotionBlur::None);
            let [exact, capsule] = [MotionBlur::Exact, MotionBlur::Capsule].map(|m| frame(m) / still - 1.0);
            println!(
                "{filter:?}: exact {:.4} %, capsule {:.1} %",
                100.0 * exact,
                100.0 * capsule
            );
            assert!(exact.abs() < 1e-3, "{filter:?}: {exact}");
            assert!((0.05..1.2).contains(&capsule), "{filter:?}: {capsule}");
        }
    }
}

/// mueller1998 eq. 11 on a voxel that nothing shines through: drawn apart by l, it keeps `A1 / (A1 + 2 l s)` of its opacity, `pi s
/// / (pi s + 2 l)` for a circle of radius s.
#[test]
fn a_capsule_of_an_opaque_voxel_is_dimmed_by_what_its_area_grows() {
    let edge = 15;
    let grid = Grid::new([edge; 3], DVec3::ZERO, DVec3::ONE, DMat3::IDENTITY).unwrap();
    let mut values = vec![0.0_f32; edge * edge * edge];
    values[(7 * edge + 7) * edge + 7] = 1.0;
    let volume = Volume::new(
        grid,
        Samples::F32(values.into()),
        Rescale::default(),
        LengthUnit::default(),
    );
    let mut look = translucent();
    look.unit_distance = Some(1e-3);
    let scene = Scene::new(volume.unwrap(), look);
    let (length, radius) = (3.0, 2.0);
    let camera = common::orthographic(DVec3::splat(7.0), DVec3::Z, 10.0);
    for absorption in [Absorption::Exp, Absorption::Linear] {
        let opacity = |motion_blur| {
            let settings = checked(FlatSettings {
                absorption,
                lighting: None,
                motion_blur,
                termination: 0.0,
                kernel: Kernel::Gaussian { sigma: 0.602, radius },
                size: ImageSize::new(41, 41).unwrap(),
                ..RenderSettings::mueller1998().into()
            });
            let motion = Motion::Linear(length * DVec3::X);
            common::render(&moving(&scene, motion), &camera, &settings)
                .image
                .pixels[20 * 41 + 20][3]
        };
        let still = opacity(MotionBlur::None);
        let found = f64::from(opacity(MotionBlur::Capsule));
        let expected = std::f64::consts::PI * radius / (std::f64::consts::PI * radius + 2.0 * length);
        println!("{absorption:?}: {found:.4}, {expected:.4} by eq. 11");
        assert!(still > 0.999, "{still}");
        assert!(
            (found - expected).abs() < 1e-3,
            "{absorption:?}: {found} {expected}"
        );
    }
}

#[test]
fn slow_motion_is_the_still_picture() {
    let scene = small_noise();
    let camera = framing(&scene, PROJECTIONS[0], 1.0, 1.0);
    for compositing in [
        Compositing::ImageSheets,
        Compositing::PerSplat,
        Compositing::AxisSheets,
    ] {
        for alignment in [Alignment::Affine, Alignment::Exact] {
            let frame = |motion: DVec3, motion_blur| {
                let settings = checked(FlatSettings {
                    compositing,
                    alignment,
                    filter: Filter::default(),
                    ..settings(64, motion_blur).into()
                });
                common::render(&moving(&scene, Motion::Linear(motion)), &camera, &settings)
            };
            let still = frame(DVec3::ZERO, MotionBlur::None);
            for blur in [MotionBlur::Exact, MotionBlur::Capsule] {
                assert!(
                    bits(&frame(DVec3::ZERO, blur)) == bits(&still),
                    "{compositing:?} {blur:?}"
                );
                let slow = psnr(&frame(DVec3::splat(1e-4), blur), &still);
                println!("{compositing:?} {alignment:?} {blur:?}: {slow:.1} dB");
                assert!(slow > 80.0, "{compositing:?} {alignment:?} {blur:?}: {slow}");
            }
        }
    }
}

/// A field of equal vectors is a linear motion; a camera that steps aside sees a linear motion the other way.
#[test]
fn motions_that_are_the_same_look_the_same() {
    let scene = small_noise();
    let camera = framing(&scene, PROJECTIONS[0], 1.0, 1.0);
    let step = DVec3::new(1.5, -0.5, 0.75);
    let beside = |t: f64| {
        let at = t * step;
        Camera::new(
            camera.position() + at,
            camera.target() + at,
            camera.up(),
            camera.projection(),
        )
        .unwrap()
    };
    let field = vec![step.as_vec3().to_array(); scene.single_volume().unwrap().volume.grid().sample_count()];
    let passing = Motion::Camera {
        opening: beside(0.5),
        closing: beside(-0.5),
    };
    let frame = |motion: Motion, blur| {
        let settings = settings(64, blur);
        common::render(&moving(&scene, motion), &camera, &settings)
    };
    let expected = frame(Motion::Linear(step), MotionBlur::Exact);
    for motion in [Motion::Field(field.into()), passing.clone()] {
        let found = psnr(&frame(motion, MotionBlur::Exact), &expected);
        assert!(found > 80.0, "{found}");
    }
    let count = MotionBlur::Subframes { count: 5 };
    let found = psnr(&frame(passing, count), &frame(Motion::Linear(step), count));
    assert!(found > 80.0, "{found}");
}

#[test]
fn pictures_of_motion_do_not_depend_on_threads() {
    let scene = moving(&small_noise(), spin(&small_noise()));
    let camera = framing(&scene, PROJECTIONS[0], 1.0, 1.2);
    for (blur, classification) in [
        (MotionBlur::Exact, Classification::Pre),
        (MotionBlur::Subframes { count: 3 }, Classification::Post),
    ] {
        let frame = |threads| {
            let config = EngineConfig {
                threads: Some(threads),
                ..EngineConfig::default()
            };
            let settings = checked(FlatSettings {
                classification,
                ..settings(72, blur).into()
            });
            let mut renderer = Renderer::new(config).unwrap();
            renderer.render(&scene, &camera, &settings).unwrap()
        };
        assert!(bits(&frame(1)) == bits(&frame(3)), "{blur:?}");
    }
}

#[test]
fn what_cannot_be_blurred_is_refused_with_a_reason() {
    let of = |flat: FlatSettings| RenderSettings::try_from(flat).unwrap_err().to_string();
    for blur in [MotionBlur::Exact, MotionBlur::Capsule] {
        let data = FlatSettings {
            classification: Classification::Post,
            ..settings(32, blur).into()
        };
        assert!(of(data).contains("before they are classified"));
        let mip = FlatSettings {
            compositing: Compositing::Mip,
            ..settings(32, blur).into()
        };
        assert!(of(mip).contains("no sum of footprints"));
    }
    let none = settings(32, MotionBlur::Subframes { count: 0 });
    let text = none.validate().unwrap_err().to_string();
    assert!(text.starts_with("sub-frames: 0"), "{text}");
}
