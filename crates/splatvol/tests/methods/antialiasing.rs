//! The anti-aliasing filters against pictures of 256 samples per pixel, and against the equations they implement.

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
/// The paper's identity matrix (zwicker2001 section 4.5).
const PAPER: Filter = Filter::Ewa { pixel_sigma: 1.0 };

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

/// Means of `n` x `n` pixels, in linear premultiplied light.
fn reduced(image: &Image, n: usize) -> Image {
    let [width, height] = <[u32; 2]>::from(image.size()).map(|side| side as usize / n);
    let size = ImageSize::new(width as u32, height as u32).unwrap();
    let mean = |x: usize, y: usize| {
        let mut sum = [0.0; 4];
        for i in 0..n * n {
            let pixel = image.pixel(x * n + i % n, y * n + i / n);
            sum = std::array::from_fn(|c| sum[c] + f64::from(pixel[c]));
        }
        sum.map(|v| (v / (n * n) as f64) as f32)
    };
    let pixels = (0..width * height).map(|i| mean(i % width, i / width)).collect();
    Image::from_pixels(size, pixels).unwrap()
}

/// A texture that lies on the ground, seen from above its near edge: minified three to six times, and foreshortened; its slices
/// are what is most nearly parallel to the picture.
fn over_ground(scene: &Scene) -> Camera {
    let bounds = scene.volume.grid().bounds();
    let side = bounds.max.y - bounds.min.y;
    let near = DVec3::new(0.1 * side, bounds.min.y - 0.15 * side, 0.7 * side);
    let target = bounds.centre() - DVec3::new(0.0, 0.1 * side, 0.0);
    Camera::new(
        near,
        target,
        DVec3::Z,
        Projection::Perspective { fov_degrees: 40.0 },
    )
    .unwrap()
}

fn sample_of(kind: Sample, dims: [usize; 3]) -> Scene {
    let volume = kind.generate(Some(SampleSize::Dims(dims))).unwrap();
    Scene::new(volume, kind.default_transfer_function().unwrap())
}

/// Stripes of voxels `ratio` times as long as wide (zwicker2001 figure 8: 1024 x 512 and 1024 x 256).
fn zebra(ratio: usize) -> Scene {
    let dims = [192, 192 / ratio, 3];
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

/// Decibels of filters against a picture of 256 samples per pixel.
fn quality<const N: usize>(
    scene: &Scene,
    camera: &Camera,
    compositing: Compositing,
    filters: [Filter; N],
) -> [f64; N] {
    const SIZE: [u32; 2] = [64, 40];
    let of = |size, filter| {
        let settings = RenderSettings {
            compositing,
            ..settings(size, filter)
        };
        common::render(scene, camera, &settings).image
    };
    let truth = reduced(&of(SIZE.map(|side| 16 * side), Filter::None), 16);
    filters.map(|filter| Comparison::of(&of(SIZE, filter), &truth).psnr)
}

#[test]
fn filters_against_256_samples_per_pixel() {
    let checkers = sample_of(Sample::CheckerSheet, [240, 240, 1]);
    let ground = |scene: Scene| {
        let camera = over_ground(&scene);
        (scene, camera)
    };
    let mut failed = Vec::new();
    for (name, (scene, camera), compositing, anisotropic) in [
        ("checker-sheet", ground(checkers), Compositing::AxisSheets, false),
        ("zebra 2:1", ground(zebra(2)), Compositing::AxisSheets, true),
        ("zebra 4:1", ground(zebra(4)), Compositing::AxisSheets, true),
        ("tunnel", tunnel(), Compositing::ImageSheets, false),
    ] {
        let filters = [Filter::None, Filter::Swan, EWA, PAPER];
        let [none, swan, ewa, paper] = quality(&scene, &camera, compositing, filters);
        println!("{name}: none {none:.1} dB, swan {swan:.1}, ewa .55 {ewa:.1}, ewa 1 {paper:.1}");
        if ewa < none + 6.0 || (anisotropic && ewa <= swan) {
            failed.push(format!(
                "{name}: none {none:.1}, swan {swan:.1}, ewa {ewa:.1}, ewa 1 {paper:.1}"
            ));
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
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
            assert!((0.93..1.05).contains(&figure.0), "{figure:?}");
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
