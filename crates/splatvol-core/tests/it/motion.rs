//! Footprints of splats in motion against f64 sums over the shutter.

use glam::{DAffine3, DMat3, DVec2, DVec3};
use splatvol_core::splats::{
    CameraView, Chunk, Footprint, GaussianProfile, KernelShape, Moving, Path, Profile, Projection,
    SplatCloud, Warp, whitening,
};
use splatvol_scene::{Alignment, Filter, ImageSize, Motion, ScreenFromCamera};
use splatvol_testing::Random;

const CUT: f64 = 4.05;
const STEPS: u32 = 4000;

/// The Gaussian less its value at the cut, of height 1.
fn profile(squared: f64) -> f64 {
    let edge = (-0.5 * CUT * CUT).exp();
    (((-0.5 * squared).exp() - edge) / (1.0 - edge)).max(0.0)
}

/// Mean over the shutter.
fn mean(value: impl Fn(f64) -> f64) -> f64 {
    (0..STEPS)
        .map(|i| value((f64::from(i) + 0.5) / f64::from(STEPS) - 0.5))
        .sum::<f64>()
        / f64::from(STEPS)
}

fn value(footprint: &Footprint, pixel: DVec2) -> f64 {
    let profile = GaussianProfile::new(CUT);
    let Warp::Moving(moving) = footprint.warp else {
        panic!("{footprint:?}")
    };
    let passage = footprint.passage(&moving, pixel.as_vec2().to_array());
    let value = profile.mean_along(passage.across_squared, passage.along, passage.length);
    f64::from(footprint.weight * passage.gain * value)
}

#[test]
fn affine_footprints_are_the_mean_of_the_moving_gaussian() {
    let mut random = Random::new(11);
    let mut worst: f64 = 0.0;
    for case in 0..600 {
        // A conic by its axes, widths of 0.4 to 12 pixels.
        let angle = random.range(0.0, 3.2);
        let widths = [0; 2].map(|_| random.range(-0.9, 2.5).exp());
        let (s, c) = angle.sin_cos();
        let whiten = |d: DVec2| DVec2::new((c * d.x + s * d.y) / widths[0], (c * d.y - s * d.x) / widths[1]);
        let [p, q] = widths.map(|w| 1.0 / (w * w));
        let conic = [c * c * p + s * s * q, s * c * (p - q), s * s * p + c * c * q].map(|v| v as f32);
        let length = random.range(-5.0, 5.0).exp();
        let heading = random.range(0.0, 6.3);
        let displacement = DVec2::from_angle(heading) * length;
        let centre = DVec2::new(random.range(0.0, 90.0), random.range(0.0, 90.0))
            .as_vec2()
            .as_dvec2();
        let ([a, b, c], moved) = (whitening(conic), displacement.as_vec2());
        let footprint = Footprint {
            centre: centre.as_vec2().to_array(),
            bounds: [0.0; 4],
            weight: 1.0,
            opacity: 1.0,
            depth: 5.0,
            depth_sigma: 1.0,
            clip: f32::NEG_INFINITY,
            warp: Warp::Moving(Moving {
                path: Path::Affine {
                    whitening: [a, b, c],
                    slope: [0.0; 2],
                    displacement: [a * moved.x + b * moved.y, c * moved.y],
                    depth_change: 0.0,
                },
                capsule: false,
            }),
        };
        let at = random.range(-0.6, 0.6) * displacement;
        let reach = random.range(0.0, 4.0);
        let pixel = centre + at + DVec2::from_angle(random.range(0.0, 6.3)) * reach * widths[case % 2];
        let expected = mean(|t| profile(whiten(pixel - centre - t * displacement).length_squared()));
        let peak = mean(|t| profile(whiten(-t * displacement).length_squared()));
        let error = (value(&footprint, pixel) - expected).abs() / peak;
        worst = worst.max(error);
        assert!(
            error < 1e-4,
            "{case}: {error:e} of the peak, length {length}, {widths:?}"
        );
    }
    println!("worst error: {worst:e} of the moving footprint's peak");
}

/// A cloud of one splat in space, and the world's covariance of it.
fn cloud(position: DVec3, linear: DMat3) -> SplatCloud {
    SplatCloud {
        world_from_local: DAffine3::from_mat3_translation(linear, position),
        positions: vec![[0.0; 3]],
        payloads: vec![[1.0; 4]],
        gradients: Vec::new(),
        shape: KernelShape::Sphere { sigma: 0.74 },
        covariances: Vec::new(),
        peaks_from: usize::MAX,
        mass: linear.determinant().abs(),
        spacing: 1.0,
        chunks: Chunk::of(&[[0.0; 3]], 0, 0.74).into_iter().collect(),
    }
}

/// With true rays the closed form is exact for any motion in space, including towards the eye.
#[test]
fn true_rays_see_the_mean_of_the_moving_gaussian() {
    let size = ImageSize::new(200, 160).unwrap();
    let screen = ScreenFromCamera {
        perspective: true,
        scale: 120.0,
        centre: DVec2::new(100.0, 80.0),
    };
    let view = CameraView {
        camera_from_world: DAffine3::IDENTITY,
        screen,
        size,
        near: 0.5,
    };
    let mut random = Random::new(12);
    let kernel = GaussianProfile::new(CUT);
    let mut worst: f64 = 0.0;
    for case in 0..200 {
        let mut vector = |size: f64| DVec3::from_array([0; 3].map(|_| random.range(-size, size)));
        let position = vector(6.0) + 16.0 * DVec3::Z;
        let linear = DMat3::from_cols(
            DVec3::X + vector(0.4),
            1.4 * DVec3::Y + vector(0.4),
            0.8 * DVec3::Z + vector(0.3),
        );
        let displacement = vector(2.5);
        let splat = cloud(position, linear);
        let projection = Projection::new(&splat, &view, (Filter::None, Alignment::Exact), &kernel).moving(
            &Motion::Linear(displacement),
            [1; 3],
            &view,
            false,
        );
        let footprint = projection.project(0).unwrap();
        let whitening = (linear * 0.74).inverse();
        let at = |pixel: DVec2, t: f64| {
            let w = whitening * ((pixel - screen.centre) / screen.scale).extend(1.0);
            let c = whitening * (position + t * displacement);
            c.cross(w).length_squared() / w.length_squared()
        };
        let t = random.range(-0.6, 0.6);
        let near = screen.project(position + t * displacement);
        let pixel = near + DVec2::new(random.range(-8.0, 8.0), random.range(-8.0, 8.0));
        let expected = mean(|t| profile(at(pixel, t)));
        let middle = screen.project(position);
        let peak = mean(|t| profile(at(middle, t)));
        let still = Projection::new(&splat, &view, (Filter::None, Alignment::Exact), &kernel)
            .project(0)
            .unwrap();
        let gain = f64::from(still.weight * still.at(pixel.as_vec2().to_array()).gain);
        let error = (value(&footprint, pixel) / gain - expected).abs() / peak;
        worst = worst.max(error);
        assert!(error < 1e-4, "{case}: {error:e}");
        if expected > 1e-6 {
            let [x0, y0, x1, y1] = footprint.bounds.map(f64::from);
            let inside = (x0..=x1).contains(&pixel.x) && (y0..=y1).contains(&pixel.y);
            assert!(inside, "{case}: {pixel} outside {:?}", footprint.bounds);
        }
    }
    println!("worst error: {worst:e} of the moving footprint's peak");
}

/// The energy of the exact footprint is the still one's; that of the capsule grows as
/// `(1 + L l / E) / (1 + 2 L / pi s)`.
#[test]
fn energies_are_as_stated() {
    for cut in [2.0, 3.125, 4.05] {
        let profile = GaussianProfile::new(cut);
        let step = 0.02;
        let plane = 1.0 / f64::from(profile.peak());
        let half = cut as f32;
        let line: f64 = (0..4000)
            .map(|i| (f64::from(i) + 0.5) / 4000.0 * cut)
            .map(|x| 2.0 * f64::from(profile.whole((x * x) as f32)) * cut / 4000.0)
            .sum();
        for length in [0.05_f32, 0.4, 2.0, 10.0] {
            let footprint = |capsule| Footprint {
                centre: [0.0; 2],
                bounds: [0.0; 4],
                weight: 1.0,
                opacity: 1.0,
                depth: 1.0,
                depth_sigma: 1.0,
                clip: f32::NEG_INFINITY,
                warp: Warp::Moving(Moving {
                    path: Path::Affine {
                        whitening: [1.0, 0.0, 1.0],
                        slope: [0.0; 2],
                        displacement: [length, 0.0],
                        depth_change: 0.0,
                    },
                    capsule,
                }),
            };
            let (mut exact, mut capsule) = (0.0, 0.0);
            let across = (2.0 * half / step) as i32;
            let along = ((2.0 * half + length) / step) as i32;
            for j in 0..=across {
                for i in 0..=along {
                    let x = (i as f32 + 0.5) * step - half - 0.5 * length;
                    let y = (j as f32 + 0.5) * step - half;
                    let Warp::Moving(moving) = footprint(false).warp else {
                        unreachable!()
                    };
                    let passage = footprint(false).passage(&moving, [x, y]);
                    let seen = profile.mean_along(passage.across_squared, passage.along, passage.length);
                    exact += f64::from(seen * step * step);
                    let sample = footprint(true).at([x, y]);
                    capsule += f64::from(profile.whole(sample.squared) * step * step);
                }
            }
            let long = f64::from(length);
            assert!(
                (exact / plane - 1.0).abs() < 1e-4,
                "{cut} {length}: {}",
                exact / plane
            );
            let grown = capsule / plane;
            assert!(
                (grown / (1.0 + long * line / plane) - 1.0).abs() < 1e-3,
                "{grown}"
            );
            let dimmed = grown / (1.0 + 2.0 * long / (std::f64::consts::PI * cut));
            println!("cut {cut}, length {length}: capsule's energy {dimmed:.3}");
            assert!(dimmed > 1.0);
        }
    }
}
