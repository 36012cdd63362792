//! Effect of the filters on one footprint, on one layer and on the energy of a picture, against their equations.

use glam::{DVec2, DVec3};
use splatvol::{
    Absorption, Camera, ColorPoint, Compositing, Filter, FlatSettings, Frame, Grid, Kernel, LengthUnit,
    OpacityPoint, Projection, Rescale, Samples, Scene, TransferFunction, Volume,
};
use splatvol_testing::checked;

use super::{EWA, settings};
use crate::common;
use crate::fast::support::noise;

/// A volume of one opacity, given as optical depth per voxel.
fn uniform(dims: [usize; 3], spacing: DVec3, values: Vec<u8>, depth: f64) -> Scene {
    let grid = Grid::centred(dims, spacing).unwrap();
    let volume = Volume::new(
        grid,
        Samples::U8(values.into()),
        Rescale::default(),
        LengthUnit::default(),
    )
    .unwrap();
    let opacity = -(-depth).exp_m1();
    let look = TransferFunction::new(
        vec![ColorPoint::new(0.0, [1.0; 3])],
        vec![OpacityPoint::new(0.0, 0.0), OpacityPoint::new(1.0, opacity)],
        Some(1.0),
    );
    Scene::new(volume, look.unwrap())
}

/// Second moments of the response to one voxel, pixels squared, along x and y of the picture, measured with 4 x 4
/// shifts of the pixels.
fn moments(scene: &Scene, camera_at: impl Fn(DVec2) -> Camera, filter: Filter) -> DVec2 {
    const PIXELS: u32 = 33;
    let (mut mass, mut first, mut second) = (0.0, DVec2::ZERO, DVec2::ZERO);
    for shift in 0..16 {
        let moved = DVec2::new(f64::from(shift % 4), f64::from(shift / 4)) / 4.0;
        let settings = checked(FlatSettings {
            compositing: Compositing::Xray,
            ..settings([PIXELS; 2], filter).into()
        });
        let frame = common::render(scene, &camera_at(moved), &settings);
        for (i, &tau) in frame.optical_depth.iter().enumerate() {
            let pixel = DVec2::new((i as u32 % PIXELS).into(), (i as u32 / PIXELS).into());
            // Away from the camera's axis; the picture's y points down, the camera's up.
            let at = pixel + 0.5 - 0.5 * f64::from(PIXELS) + DVec2::new(moved.x, -moved.y);
            mass += f64::from(tau);
            first += f64::from(tau) * at;
            second += f64::from(tau) * at * at;
        }
    }
    assert!(mass > 0.0);
    second / mass - (first / mass) * (first / mass)
}

#[test]
fn ewa_is_not_too_wide_along_the_major_axis() {
    let (sigma, radius) = Kernel::default().gaussian().unwrap();
    for ratio in [2.0, 4.0] {
        for minification in [2.0, 4.0, 8.0] {
            let mut values = vec![0; 3 * 3 * 3];
            values[13] = 1;
            let scene = uniform([3; 3], DVec3::new(1.0, ratio, 1.0), values, 0.5);
            let camera = |shift: DVec2| {
                let aside = minification * DVec3::new(shift.x, shift.y, 0.0);
                let height = 33.0 * minification;
                let projection = Projection::Orthographic { height };
                Camera::new(aside + 100.0 * DVec3::Z, aside, DVec3::Y, projection).unwrap()
            };
            let widest = |filter| moments(&scene, camera, filter).y.sqrt();
            // The kernel is cut where r = radius, and its value there is subtracted: its variance in f64.
            let kernel = (sigma * ratio / minification).powi(2) * kept_variance(radius / sigma);
            let ideal = |low_pass: f64| (kernel + low_pass * low_pass).sqrt();
            let [ewa, swan] = [widest(EWA), widest(Filter::Swan)];
            let figure = (ewa / ideal(0.55), swan / ideal(0.55));
            println!(
                "{ratio}:1, minified {minification}: ewa {:.3}, swan {:.3} of the ideal; of a box pixel's {:.3}, {:.3}",
                figure.0,
                figure.1,
                ewa / ideal(12_f64.sqrt().recip()),
                swan / ideal(12_f64.sqrt().recip()),
            );
            assert!((0.95..1.05).contains(&figure.0), "{figure:?}");
            assert!(figure.1 > figure.0, "{figure:?}");
        }
    }
}

/// Variance of a planar Gaussian of variance 1 that is cut at `cut` and lowered to 0 there.
fn kept_variance(cut: f64) -> f64 {
    let edge = (-0.5 * cut * cut).exp();
    let (mut mass, mut second) = (0.0, 0.0);
    for step in 0..20_000 {
        let r = (f64::from(step) + 0.5) / 20_000.0 * cut;
        let value = (-0.5 * r * r).exp() - edge;
        mass += value * r;
        second += 0.5 * value * r * r * r;
    }
    second / mass
}

/// One layer of voxels, seen from above, four of them across a pixel.
fn layer(depth: f64, filter: Filter, method: (Compositing, Absorption)) -> f64 {
    let mut values = vec![1; 96 * 96];
    values[0] = 0;
    let scene = uniform([96, 96, 1], DVec3::ONE, values, depth);
    let camera = common::orthographic(DVec3::ZERO, -DVec3::Z, 48.0);
    let settings = checked(FlatSettings {
        compositing: method.0,
        absorption: method.1,
        termination: 0.0,
        ..settings([12; 2], filter).into()
    });
    let image = common::render(&scene, &camera, &settings).image;
    let middle = (4..8).flat_map(|y| (4..8).map(move |x| (x, y)));
    middle.map(|(x, y)| f64::from(image.pixel(x, y)[3])).sum::<f64>() / 16.0
}

/// swan1997 section 4.3 lowers alpha as the area grows: opacities of 1, here spread over 16 times the area with a
/// sixteenth of it, leave `1 - prod(1 - w)`, `sum w = 1`, which is near `1 - 1/e`; lowered extinction keeps opaque what
/// is opaque.
#[test]
fn lowered_alpha_makes_opaque_data_translucent() {
    let voxel = (Compositing::PerSplat, Absorption::Linear);
    let sheet = (Compositing::AxisSheets, Absorption::Linear);
    let alpha = layer(1.0, Filter::SwanAlpha, voxel);
    let kept = layer(1.0, Filter::Swan, sheet);
    let exponential = layer(12.0, Filter::Swan, (Compositing::PerSplat, Absorption::Exp));
    // The product in f64: voxels within the kernel, a = 4, the kernel's lattice sum 1.
    let (sigma, radius) = Kernel::default().gaussian().unwrap();
    let (wide, reach) = (4.0 * sigma, 4.0 * radius);
    let edge = (-0.5 * (radius / sigma).powi(2)).exp();
    let offsets = || (-16..16).flat_map(|y| (-16..16).map(move |x| (f64::from(x) + 0.5, f64::from(y) + 0.5)));
    let weights: Vec<f64> = offsets()
        .map(|(x, y)| x.hypot(y))
        .filter(|r| *r < reach)
        .map(|r| (-0.5 * (r / wide).powi(2)).exp() - edge)
        .collect();
    let sum: f64 = weights.iter().sum();
    let expected = 1.0 - weights.iter().map(|w| 1.0 - w / sum).product::<f64>();
    println!(
        "alpha 1 composites to {alpha:.4} (equation: {expected:.4}), with swan {kept:.4}, {exponential:.6}"
    );
    assert!((alpha - expected).abs() < 0.005, "{alpha} {expected}");
    assert!((0.62..0.66).contains(&alpha), "{alpha}");
    assert!(kept > 0.99, "{kept}");
    assert!(exponential > 0.9999, "{exponential}");
}

fn energy(frame: &Frame, pixel_area: f64) -> f64 {
    frame.optical_depth.iter().map(|&tau| f64::from(tau)).sum::<f64>() * pixel_area
}

/// Extinction falls by `(k/d)^2` as the area grows by `(d/k)^2` (swan1997 eq. 4 and 8): X-rays of every kernel that the
/// footprint engine renders keep the energy of a picture of 64 samples per pixel.
#[test]
fn swan_keeps_the_energy_of_x_rays() {
    let scene = noise();
    let bounds = scene.bounds().unwrap();
    let direction = DVec3::new(0.4, -0.5, 0.8);
    let kernels = [
        Kernel::default(),
        Kernel::Gaussian {
            sigma: 0.64,
            radius: 2.0,
        },
        Kernel::Gaussian {
            sigma: 1.0,
            radius: 3.0,
        },
        Kernel::CrawfisMax,
        Kernel::CubicBspline,
        Kernel::KAISER_BESSEL,
    ];
    let mut rendered = 0;
    for camera in [
        common::orthographic(bounds.centre(), direction, 2.0 * bounds.diagonal()),
        common::perspective(bounds.centre(), direction, 5.0 * bounds.diagonal(), 20.0),
    ] {
        for kernel in kernels {
            let of = |pixels: u32, filter| {
                let settings = checked(FlatSettings {
                    compositing: Compositing::Xray,
                    prefilter: false,
                    kernel,
                    ..settings([pixels; 2], filter).into()
                });
                // Kernels that no engine renders are refused by name; other tests check that.
                settings.validate().ok()?;
                let area = 1.0 / f64::from(pixels * pixels);
                Some(energy(&common::render(&scene, &camera, &settings), area))
            };
            let Some(truth) = of(288, Filter::None) else {
                continue;
            };
            for filter in [Filter::Swan, EWA] {
                let ratio = of(36, filter).unwrap() / truth;
                println!("{} {filter:?}: {ratio:.6}", kernel.name());
                assert!((ratio - 1.0).abs() < 1e-3, "{kernel:?} {filter:?}: {ratio}");
                rendered += 1;
            }
        }
    }
    assert!(rendered >= 12, "{rendered}");
}
