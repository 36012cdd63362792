//! The anti-aliasing filters against pictures of 256 samples per pixel, and against the equations they implement.
//!
//! What 256 samples are weighted by is a low-pass itself: `ewa` agrees with the one of its own width. Against the plain mean that
//! is `pixel_sigma` 0.3; the default, 0.55, is wider, and loses to no filter at all on stripes that are still resolved.

use glam::{DVec2, DVec3};
use splatvol::{
    Absorption, Alignment, Camera, Classification, ColorPoint, Compositing, Filter, Frame, Grid, Image,
    ImageSize, Kernel, OpacityPoint, Projection, RenderSettings, Rescale, Samples, Scene, TransferFunction,
    Volume,
};
use splatvol_samples::{Sample, SampleSize};
use splatvol_testing::Comparison;

use crate::common;
use crate::support::noise;

/// The filter that EWA pictures are made with by default.
const EWA: Filter = Filter::Ewa { pixel_sigma: 0.55 };
/// As wide as a square pixel, whose variance is 1/12.
const BOX: Filter = Filter::Ewa { pixel_sigma: 0.3 };
/// Pixels of a picture of the ground, and of one inside the tunnel.
const GROUND: [u32; 2] = [48, 30];
const TUNNEL: [u32; 2] = [32, 20];

fn settings([width, height]: [u32; 2], filter: Filter) -> RenderSettings {
    RenderSettings {
        size: ImageSize::new(width, height).unwrap(),
        classification: Classification::Pre,
        alignment: Alignment::Affine,
        lighting: None,
        filter,
        ..RenderSettings::best()
    }
}

/// Samples per pixel along x and y.
const SAMPLES: usize = 16;

/// What a pixel takes of a picture of 256 samples per pixel: the mean of its own, or a Gaussian's of this standard deviation in
/// pixels, in linear premultiplied light.
fn low_passed(image: &Image, sigma: Option<f64>) -> Image {
    let [width, height] = <[u32; 2]>::from(image.size()).map(|side| side as usize);
    let reach = sigma.map_or(0.5, |sigma| 4.0 * sigma);
    let weight = |offset: f64| match sigma {
        None => 1.0,
        Some(sigma) => (-0.5 * (offset / sigma).powi(2)).exp(),
    };
    // Weights along one axis, beginning at a sample that may lie outside: what is there is nothing.
    let steps = (reach * SAMPLES as f64).round() as isize;
    let taps: Vec<(isize, f64)> = (-steps..steps)
        .map(|i| {
            (
                i + SAMPLES as isize / 2,
                weight((i as f64 + 0.5) / SAMPLES as f64),
            )
        })
        .collect();
    let total: f64 = taps.iter().map(|(_, w)| w).sum();
    let sum = |pixel: usize, side: usize, value: &dyn Fn(usize) -> [f64; 4]| {
        let mut sum = [0.0; 4];
        for (offset, w) in &taps {
            let at = (pixel * SAMPLES) as isize + offset;
            if (0..side as isize).contains(&at) {
                let value = value(at as usize);
                sum = std::array::from_fn(|c| sum[c] + w / total * value[c]);
            }
        }
        sum
    };
    let [columns, rows] = [width / SAMPLES, height / SAMPLES];
    let across: Vec<[f64; 4]> = (0..columns * height)
        .map(|i| {
            sum(i % columns, width, &|x| {
                image.pixel(x, i / columns).map(f64::from)
            })
        })
        .collect();
    let pixels = (0..columns * rows)
        .map(|i| sum(i / columns, height, &|y| across[y * columns + i % columns]).map(|v| v as f32))
        .collect();
    Image::from_pixels(ImageSize::new(columns as u32, rows as u32).unwrap(), pixels).unwrap()
}

/// A texture that lies on the ground, `minification` voxels a pixel at the middle of the picture and nothing else in it.
fn over_ground(scene: &Scene, minification: f64) -> Camera {
    let target = scene.volume.grid().bounds().centre();
    let fov_degrees = 30.0_f64;
    let pixels_per_radian = 0.5 * f64::from(GROUND[1]) / (0.5 * fov_degrees).to_radians().tan();
    let away = minification * pixels_per_radian * DVec3::new(0.1, -0.4, 0.9).normalize();
    Camera::new(
        target + away,
        target,
        DVec3::Y,
        Projection::Perspective { fov_degrees },
    )
    .unwrap()
}

fn sample_of(kind: Sample, dims: [usize; 3]) -> Scene {
    let volume = kind.generate(Some(SampleSize::Dims(dims))).unwrap();
    Scene::new(volume, kind.default_transfer_function().unwrap())
}

/// Stripes of voxels `ratio` times as long as wide (zwicker2001 figure 8: 1024 x 512 and 1024 x 256).
fn zebra(ratio: usize, side: usize) -> Scene {
    let dims = [side, side / ratio, 3];
    let stripes = sample_of(Sample::Zebra, dims);
    let grid = Grid::centred(dims, DVec3::new(1.0, ratio as f64, 1.0)).unwrap();
    let samples = stripes.volume.samples().clone();
    let volume = Volume::new(grid, samples, stripes.volume.rescale(), stripes.volume.unit()).unwrap();
    Scene::new(volume, stripes.transfer_function.clone())
}

/// Inside a tube, at its mouth.
fn tunnel() -> (Scene, Camera) {
    let scene = sample_of(Sample::Tunnel, [48, 48, 160]);
    let bounds = scene.volume.grid().bounds();
    let centre = bounds.centre();
    let mouth = DVec3::new(centre.x, centre.y, bounds.min.z);
    let projection = Projection::Perspective { fov_degrees: 60.0 };
    (scene, Camera::new(mouth, centre, DVec3::Y, projection).unwrap())
}

/// Decibels without a filter, with swan and with ewa: against the mean of 256 samples per pixel, and against their mean by a
/// Gaussian of the default's width. The former's second moment is that of `pixel_sigma` 0.29, so ewa has 0.3 there.
fn quality(scene: &Scene, camera: &Camera, size: [u32; 2]) -> [[f64; 3]; 2] {
    let of = |size, filter| {
        let settings = RenderSettings {
            compositing: Compositing::AxisSheets,
            ..settings(size, filter)
        };
        common::render(scene, camera, &settings).image
    };
    let samples = of(size.map(|side| SAMPLES as u32 * side), Filter::None);
    [(None, BOX), (Some(EWA.pixel_sigma()), EWA)].map(|(sigma, ewa)| {
        let truth = inner(&low_passed(&samples, sigma));
        [Filter::None, Filter::Swan, ewa].map(|f| Comparison::of(&inner(&of(size, f)), &truth).psnr)
    })
}

/// A picture without its three outermost pixels, whose low-pass would reach beyond the samples.
fn inner(image: &Image) -> Image {
    let [width, height] = <[u32; 2]>::from(image.size());
    let pixels =
        (3..height - 3).flat_map(|y| (3..width - 3).map(move |x| image.pixel(x as usize, y as usize)));
    Image::from_pixels(ImageSize::new(width - 6, height - 6).unwrap(), pixels.collect()).unwrap()
}

#[test]
fn ewa_against_256_samples_per_pixel() {
    let mut failed = Vec::new();
    for minification in [6.0, 12.0] {
        let side = (70.0 * minification) as usize / 4 * 4;
        for (name, scene, anisotropic) in [
            (
                "checker-sheet",
                sample_of(Sample::CheckerSheet, [side, side, 1]),
                false,
            ),
            ("zebra 2:1", zebra(2, side), true),
            ("zebra 4:1", zebra(4, side), true),
        ] {
            let camera = over_ground(&scene, minification);
            let figures = quality(&scene, &camera, GROUND);
            println!(
                "{name} / {minification}, none, swan, ewa: box {:.1?}, gauss {:.1?}",
                figures[0], figures[1]
            );
            for [none, swan, ewa] in figures {
                if ewa < none + 6.0 || (anisotropic && ewa <= swan) {
                    failed.push(format!("{name} / {minification}: {none:.1} {swan:.1} {ewa:.1}"));
                }
            }
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

/// Low-passed extinction is not a low-passed picture: where opaque things end inside a pixel, or hide each other, the filter
/// cannot gain what it gains on the same things when they are faint.
#[test]
fn the_tunnel_is_filtered_as_far_as_it_is_faint() {
    let (opaque, camera) = tunnel();
    let mut faint = opaque.clone();
    faint.transfer_function.unit_distance = Some(1000.0 * opaque.unit_distance());
    let gains = [opaque, faint].map(|scene| {
        let figures = quality(&scene, &camera, TUNNEL);
        println!(
            "tunnel, none, swan, ewa: box {:.1?}, gauss {:.1?}",
            figures[0], figures[1]
        );
        figures.map(|[none, _, ewa]| ewa - none)
    });
    println!("gains {gains:.1?}");
    assert!(gains[0].iter().all(|gain| *gain > -0.5), "{gains:?}");
    assert!(gains[1].iter().all(|gain| *gain > 6.0), "{gains:?}");
}

/// A volume of one opacity, in optical depth per voxel.
fn uniform(dims: [usize; 3], spacing: DVec3, values: Vec<u8>, depth: f64) -> Scene {
    let grid = Grid::centred(dims, spacing).unwrap();
    let volume = Volume::new(
        grid,
        Samples::U8(values),
        Rescale::default(),
        splatvol::LengthUnit::default(),
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

/// Second moments of the response to one voxel, pixels squared, along x and y of the picture, measured with 4 x 4 shifts of the
/// pixels.
fn moments(scene: &Scene, camera_at: impl Fn(DVec2) -> Camera, filter: Filter) -> DVec2 {
    const PIXELS: u32 = 33;
    let (mut mass, mut first, mut second) = (0.0, DVec2::ZERO, DVec2::ZERO);
    for shift in 0..16 {
        let moved = DVec2::new(f64::from(shift % 4), f64::from(shift / 4)) / 4.0;
        let settings = RenderSettings {
            compositing: Compositing::Xray,
            ..settings([PIXELS; 2], filter)
        };
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
            // The kernel is cut where r = radius, and what it has there is taken off: its variance in f64.
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
    let settings = RenderSettings {
        compositing: method.0,
        absorption: method.1,
        termination: 0.0,
        ..settings([12; 2], filter)
    };
    let image = common::render(&scene, &camera, &settings).image;
    let middle = (4..8).flat_map(|y| (4..8).map(move |x| (x, y)));
    middle.map(|(x, y)| f64::from(image.pixel(x, y)[3])).sum::<f64>() / 16.0
}

/// swan1997 section 4.3 lowers alpha with the area: of opacities of 1, each now covering 16 pixels' worth of voxels with a
/// sixteenth of it, `1 - prod(1 - w / 16)` is left, near `1 - 1/e`; extinction keeps what is opaque.
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
/// footprint engine renders keep their energy, that of a picture of 64 samples per pixel.
#[test]
fn swan_keeps_the_energy_of_x_rays() {
    let scene = noise();
    let bounds = scene.volume.grid().bounds();
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
                let settings = RenderSettings {
                    compositing: Compositing::Xray,
                    prefilter: false,
                    kernel,
                    ..settings([pixels; 2], filter)
                };
                // Kernels that no engine renders are refused by name, which other tests hold.
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
