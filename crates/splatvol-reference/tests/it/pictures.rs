//! Rays through the reference against closed forms.

use glam::{DAffine3, DMat3, DVec3};
use splatvol_reference::{PixelResult, Reconstruction, Reference, ReferenceSettings, render, render_pixels};
use splatvol_scene::{
    Camera, Classification, Compositing, Filter, FlatSettings, Grid, ImageSize, Kernel, LengthUnit, Lighting,
    Projection, RenderSettings, Rescale, Samples, Scene, TransferFunction, Volume,
};
use splatvol_testing::fields::{Ball, Constant, Noise, Ramp};
use splatvol_testing::transfer::{band_extinction, constant_extinction, linear_extinction};
use splatvol_testing::{Random, checked, sample};

/// Kernel of these tests, voxels; their tolerances are its ripple.
const SIGMA: f64 = 0.7;

const ORANGE: [f64; 3] = [1.0, 0.5, 0.25];

/// Unlit, unfiltered pictures of 9 x 9 pixels: pixel (4, 4) looks along the view axis.
fn settings(compositing: Compositing, classification: Classification) -> RenderSettings {
    checked(FlatSettings {
        size: ImageSize::new(9, 9).unwrap(),
        compositing,
        classification,
        filter: Filter::None,
        kernel: Kernel::Gaussian {
            sigma: SIGMA,
            radius: 3.0,
        },
        lighting: None,
        ..RenderSettings::best().into()
    })
}

fn post() -> RenderSettings {
    settings(Compositing::ImageSheets, Classification::Post)
}

/// Camera at `position` looking along `direction`, 9 world units (pixels of side 1) high.
fn orthographic(position: DVec3, direction: DVec3) -> Camera {
    let up = if direction.z.abs() > 0.9 * direction.length() {
        DVec3::Y
    } else {
        DVec3::Z
    };
    Camera::new(
        position,
        position + direction,
        up,
        Projection::Orthographic { height: 9.0 },
    )
    .unwrap()
}

fn centre_pixel(scene: &Scene, camera: &Camera, settings: &RenderSettings) -> PixelResult {
    render_pixels(scene, camera, settings, &ReferenceSettings::default(), &[(4, 4)]).unwrap()[0]
}

fn linear_orange() -> [f64; 3] {
    constant_extinction(0.1, ORANGE).linear_color(0.0)
}

fn assert_near(name: &str, actual: f64, expected: f64, tolerance: f64) {
    assert!(
        (actual - expected).abs() <= tolerance,
        "{name}: {actual}, expected {expected}, off by {:e}",
        actual - expected
    );
}

fn constant_box(dims: [usize; 3], spacing: DVec3, extinction: f64) -> Scene {
    let grid = Grid::centred(dims, spacing).unwrap();
    Scene::new(
        sample(&Constant(1.0), &grid),
        constant_extinction(extinction, ORANGE),
    )
}

#[test]
fn a_box_of_n_samples_is_n_spacings_thick() {
    let spacing = DVec3::new(0.5, 1.0, 2.0);
    let scene = constant_box([16, 12, 10], spacing, 0.3);
    for (direction, thickness) in [(DVec3::X, 8.0), (DVec3::Y, 12.0), (-DVec3::Z, 20.0)] {
        let camera = orthographic(-50.0 * direction, direction);
        for classification in [Classification::Post, Classification::Pre] {
            let pixel = centre_pixel(
                &scene,
                &camera,
                &settings(Compositing::ImageSheets, classification),
            );
            let tau = 0.3 * thickness;
            // The kernel's ripple: between samples a sum of h is up to 2.5e-4 per axis below 1.
            assert_near("optical depth", pixel.optical_depth, tau, 7e-4 * tau);
            let alpha = -(-pixel.optical_depth).exp_m1();
            for c in 0..3 {
                assert_near("colour", pixel.rgba[c], alpha * linear_orange()[c], 1e-6);
            }
            assert_near("alpha", pixel.rgba[3], alpha, 1e-12);
            // Mean of z weighted by T kappa, for a slab with sharp faces.
            let mean = 50.0 - 0.5 * thickness + 1.0 / 0.3 - thickness * (-tau).exp() / alpha;
            // The soft faces let the light come from 0.15 voxels nearer.
            let voxel = (direction * spacing).length();
            assert_near("depth", pixel.depth, mean, 0.15 * voxel);
        }
    }
}

#[test]
fn a_rotated_box_is_as_thick_as_its_chord() {
    // Rays that enter and leave through opposite faces, far from edges: across a soft face the coverage is
    // symmetric, so that the optical depth is that of the sharp chord.
    let mut random = Random::new(8);
    for _ in 0..6 {
        let rotation = DMat3::from_axis_angle(random.direction(), random.range(0.0, 6.0));
        let spacing = DVec3::new(0.8, 1.0, 1.3);
        let grid = Grid::from_affine(
            [24, 26, 12],
            DAffine3::from_mat3_translation(rotation * DMat3::from_diagonal(spacing), DVec3::ZERO)
                * DAffine3::from_translation(-0.5 * DVec3::new(23.0, 25.0, 11.0)),
        )
        .unwrap();
        let scene = Scene::new(sample(&Constant(3.0), &grid), constant_extinction(0.05, ORANGE));
        let tilt = random.range(0.0, 0.3);
        let direction = rotation * DVec3::new(tilt, -0.5 * tilt, 1.0);
        let chord = 12.0 * 1.3 * direction.length();
        let pixel = centre_pixel(&scene, &orthographic(-40.0 * direction, direction), &post());
        assert_near("optical depth", pixel.optical_depth, 0.05 * chord, 1e-4 * chord);
    }
}

#[test]
fn an_eye_inside_sees_what_is_in_front_of_it() {
    let scene = constant_box([20, 20, 20], DVec3::ONE, 0.2);
    for projection in [
        Projection::Perspective { fov_degrees: 40.0 },
        Projection::Orthographic { height: 9.0 },
    ] {
        let camera = Camera::new(
            DVec3::new(0.0, 0.0, 3.0),
            DVec3::new(0.0, 0.0, 10.0),
            DVec3::Y,
            projection,
        )
        .unwrap();
        for filter in [Filter::None, Filter::Ewa { pixel_sigma: 0.4 }] {
            let settings = checked(FlatSettings {
                filter,
                ..post().into()
            });
            let pixel = centre_pixel(&scene, &camera, &settings);
            assert_near("optical depth", pixel.optical_depth, 0.2 * 7.0, 2e-4);
        }
    }
}

#[test]
fn perspective_rays_are_longer_away_from_the_axis() {
    let scene = constant_box([60, 60, 8], DVec3::ONE, 0.1);
    let projection = Projection::Perspective { fov_degrees: 60.0 };
    let camera = Camera::new(DVec3::new(0.0, 0.0, -24.0), DVec3::ZERO, DVec3::Y, projection).unwrap();
    let reference = Reference::new(&scene, &camera, &post(), &ReferenceSettings::default()).unwrap();
    let focal = 4.5 / 30f64.to_radians().tan();
    for (x, y) in [(4, 4), (0, 4), (8, 8), (3, 1)] {
        let [dx, dy] = [x, y].map(|i: u32| (f64::from(i) - 4.0) / focal);
        let chord = 8.0 * (1.0 + dx * dx + dy * dy).sqrt();
        assert_near(
            "optical depth",
            reference.pixel(x, y).optical_depth,
            0.1 * chord,
            3e-4,
        );
    }
}

#[test]
fn a_quadratic_ball_has_the_closed_form_of_its_chords() {
    let ball = Ball {
        centre: DVec3::new(0.3, -0.2, 0.1),
        radius: 14.0,
    };
    let grid = Grid::centred([34, 34, 34], DVec3::ONE).unwrap();
    let volume = sample(&ball, &grid);
    let [low, high] = volume.value_range();
    assert!(low == 0.0 && high > 0.99);
    // Extinction only above 0.2: a ball of radius R sqrt(0.8) whose rim is not the samples' kink.
    let transfer_function = linear_extinction([0.2, 1.0], 0.2, ORANGE);
    let visible = Ball {
        radius: ball.radius * 0.8f64.sqrt(),
        ..ball
    };
    let scene = Scene::new(volume, transfer_function);
    let mut random = Random::new(5);
    for offset in [0.0, 4.0, 8.0, 11.0] {
        let direction = random.direction();
        let aside = direction.any_orthonormal_vector();
        let camera = orthographic(ball.centre + offset * aside - 40.0 * direction, direction);
        let exact = 0.2 * visible.line_integral(offset);
        let pixel = centre_pixel(&scene, &camera, &post());
        assert_near("post", pixel.optical_depth, exact, 3e-4 * exact);
        // Without the prefilter chords are blurred: L + sigma^2 / 2 (L'' + L' / b).
        let root = (visible.radius.powi(2) - offset * offset).sqrt();
        let laplacian = -4.0 / visible.radius.powi(2) * (2.0 * root - offset * offset / root);
        let exact = exact + 0.2 * 0.5 * SIGMA * SIGMA * laplacian;
        let pixel = centre_pixel(
            &scene,
            &camera,
            &settings(Compositing::ImageSheets, Classification::Pre),
        );
        assert_near("pre", pixel.optical_depth, exact, 2.5e-3);
    }
}

/// One voxel of value 1 in the middle of zeros, anisotropic and rotated.
fn single_voxel(extinction: f64) -> Scene {
    let rotation = DMat3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 0.9);
    let linear = rotation * DMat3::from_diagonal(DVec3::new(0.7, 1.0, 1.4));
    let map = DAffine3::from_mat3(linear) * DAffine3::from_translation(DVec3::splat(-6.0));
    let mut samples = vec![0u8; 13 * 13 * 13];
    samples[6 + 13 * (6 + 13 * 6)] = 255;
    let volume = Volume::new(
        Grid::from_affine([13; 3], map).unwrap(),
        Samples::U8(samples.into()),
        Rescale::default(),
        LengthUnit::Unknown,
    )
    .unwrap();
    Scene::new(volume, linear_extinction([0.0, 255.0], extinction, ORANGE))
}

/// Line integral through the low-passed kernel of the voxel at the world's origin: `origin` and unit `direction` in
/// camera space, from the covariance of docs/numerics.md by completing the square.
fn gaussian_line_integral(
    scene: &Scene,
    camera: &Camera,
    low_pass: f64,
    origin: DVec3,
    direction: DVec3,
) -> f64 {
    let linear = (camera.camera_from_world()
        * scene.single_volume().unwrap().volume.grid().world_from_voxel())
    .matrix3;
    let covariance = SIGMA * SIGMA * linear * linear.transpose()
        + DMat3::from_diagonal(DVec3::new(low_pass * low_pass, low_pass * low_pass, 0.0));
    let centre = camera.camera_from_world().transform_point3(DVec3::ZERO);
    let conic = covariance.inverse();
    let offset = origin - centre;
    let (a, b, c) = (
        direction.dot(conic * direction),
        direction.dot(conic * offset),
        offset.dot(conic * offset),
    );
    let lattice: f64 = (-6..=6)
        .map(|j| (-0.5 * (f64::from(j) / SIGMA).powi(2)).exp())
        .sum();
    let peak = (SIGMA / lattice).powi(3) * linear.determinant().abs() / covariance.determinant().sqrt();
    peak * (-0.5 * (c - b * b / a)).exp() * (std::f64::consts::TAU / a).sqrt()
}

#[test]
fn one_voxel_integrates_to_its_footprint() {
    let kernel = Kernel::Gaussian {
        sigma: SIGMA,
        radius: 5.6,
    };
    let scene = single_voxel(0.9);
    let camera = orthographic(DVec3::new(-10.0, 3.0, 2.0), DVec3::new(10.0, -3.1, -1.9));
    for pixel_sigma in [0.0, 0.5, 1.0] {
        for compositing in [Compositing::ImageSheets, Compositing::Xray] {
            let settings = checked(FlatSettings {
                kernel,
                filter: Filter::Ewa { pixel_sigma },
                ..settings(compositing, Classification::Pre).into()
            });
            let options = ReferenceSettings {
                tolerance: 1e-8,
                initial_step: 0.5,
            };
            let reference = Reference::new(&scene, &camera, &settings, &options).unwrap();
            for (x, y) in [(4, 4), (5, 4), (3, 6)] {
                let origin = DVec3::new(f64::from(x) - 4.0, f64::from(y) - 4.0, 0.0);
                // Pixels are 1 world unit wide, so that pixel_sigma is the low-pass in world length.
                let exact = 0.9 * gaussian_line_integral(&scene, &camera, pixel_sigma, origin, DVec3::Z);
                let pixel = reference.pixel(x, y);
                assert_near("optical depth", pixel.optical_depth, exact, 1e-6);
                let alpha = -(-exact).exp_m1();
                assert_near("red", pixel.rgba[0], alpha * linear_orange()[0], 1e-6);
                assert_near("blue", pixel.rgba[2], alpha * linear_orange()[2], 1e-6);
            }
        }
    }
}

#[test]
fn the_low_pass_grows_with_depth_in_perspective() {
    // Far away the low-pass hardly changes across the voxel, so that the orthographic closed form holds.
    let kernel = Kernel::Gaussian {
        sigma: SIGMA,
        radius: 5.6,
    };
    let scene = single_voxel(0.9);
    let settings = checked(FlatSettings {
        kernel,
        filter: Filter::Ewa { pixel_sigma: 1.0 },
        ..settings(Compositing::Xray, Classification::Pre).into()
    });
    for distance in [2000.0, 4000.0] {
        let projection = Projection::Perspective { fov_degrees: 0.2 };
        let position = distance * DVec3::new(0.6, 0.64, 0.48);
        let camera = Camera::new(position, DVec3::ZERO, DVec3::Z, projection).unwrap();
        let low_pass = distance / camera.screen_from_camera(settings.size).scale;
        let exact = 0.9 * gaussian_line_integral(&scene, &camera, low_pass, DVec3::ZERO, DVec3::Z);
        let actual = centre_pixel(&scene, &camera, &settings).optical_depth;
        assert_near("optical depth", actual, exact, 2e-3 * exact);
    }
}

/// A ramp of slope 1 per voxel along z, values 0 to 39, seen along z.
fn ramp_scene(transfer_function: TransferFunction) -> Scene {
    let ramp = Ramp {
        offset: 19.5,
        gradient: DVec3::Z,
    };
    let grid = Grid::centred([12, 12, 40], DVec3::ONE).unwrap();
    Scene::new(sample(&ramp, &grid), transfer_function)
}

#[test]
fn steps_and_spikes_of_the_transfer_function_are_integrated() {
    let camera = orthographic(DVec3::new(0.0, 0.0, -50.0), DVec3::Z);
    // The ramp's ripple moves the ends of a band by up to 1e-3 voxels.
    for (band, extinction) in [
        ([10.0, 25.0], 0.2),
        ([17.3, 17.31], 13.0),
        ([20.3, 20.300_1], 12.0),
    ] {
        let scene = ramp_scene(band_extinction(band, extinction, ORANGE));
        let pixel = centre_pixel(&scene, &camera, &post());
        let exact = extinction * (band[1] - band[0]);
        assert_near("optical depth", pixel.optical_depth, exact, 0.01 * exact);
        assert_near(
            "depth",
            pixel.depth,
            50.0 + band[0] - 19.5,
            0.5 * (band[1] - band[0]) + 0.01,
        );
    }
}

#[test]
fn a_surface_hides_what_is_behind_it() {
    let camera = orthographic(DVec3::new(0.0, 0.0, -50.0), DVec3::Z);
    let scene = ramp_scene(band_extinction([10.0, 99.0], 13.0, ORANGE));
    let pixel = centre_pixel(&scene, &camera, &post());
    assert_near("alpha", pixel.rgba[3], 1.0, 1e-12);
    assert_near("depth", pixel.depth, 50.0 + 10.0 - 19.5 + 1.0 / 13.0, 2e-3);
    assert_near(
        "optical depth stays exact",
        pixel.optical_depth,
        // To the box's face, half a voxel behind the last sample.
        13.0 * 29.5,
        0.05,
    );
}

#[test]
fn lighting_follows_the_angle_of_the_surface() {
    let lighting = Lighting {
        direction: [0.0, 0.0, -1.0],
        ..Lighting::default()
    };
    // Anisotropic voxels: the gradient must be mapped by the inverse transpose.
    let grid = Grid::new(
        [25, 25, 49],
        DVec3::new(-12.0, -12.0, -12.0),
        DVec3::new(1.0, 1.0, 0.5),
        DMat3::IDENTITY,
    )
    .unwrap();
    let gradient = DVec3::new(0.6, 0.0, 0.8);
    let volume = sample(
        &Ramp {
            offset: 0.0,
            gradient,
        },
        &grid,
    );
    let [low, high] = volume.value_range();
    let per_mean_spacing = grid.mean_spacing() / (high - low);
    // A band in the middle: the border's own gradient plays no part.
    let transfer_function = band_extinction([-2.0, 2.0], 0.8, ORANGE);
    let scene = Scene::new(volume, transfer_function);
    for (direction, cosine) in [(DVec3::Z, 0.8), (gradient, 1.0), (DVec3::X, 0.6)] {
        let surfaceness = 1.0 / (1.0 + (lighting.gradient_floor / per_mean_spacing).powi(2));
        let body = lighting.ambient + lighting.diffuse * (1.0 - surfaceness + surfaceness * cosine);
        let highlight = lighting.specular * surfaceness * cosine.powf(lighting.specular_power);
        for classification in [Classification::Post, Classification::Pre] {
            let settings = RenderSettings {
                lighting: Some(lighting),
                ..settings(Compositing::ImageSheets, classification)
            };
            let camera = orthographic(-40.0 * direction, direction);
            let pixel = centre_pixel(&scene, &camera, &settings);
            for c in 0..3 {
                let lit = linear_orange()[c] * body + highlight;
                assert_near("lit", pixel.rgba[c] / pixel.rgba[3], lit, 3e-3 * lit);
            }
        }
    }
}

#[test]
fn lighting_inside_is_exact() {
    // A band of a ramp, far from the border: |g| is known, the light aslant.
    let lighting = Lighting {
        direction: [1.0, 0.0, -1.0],
        gradient_floor: 0.02,
        ..Lighting::default()
    };
    let scene = ramp_scene(band_extinction([18.0, 21.0], 0.5, ORANGE));
    let camera = orthographic(DVec3::new(0.0, 0.0, -50.0), DVec3::Z);
    let settings = RenderSettings {
        lighting: Some(lighting),
        ..post()
    };
    let g: f64 = 1.0 / 39.0;
    let surfaceness = g * g / (g * g + 0.02 * 0.02);
    let (facing, halfway) = (45f64.to_radians().cos(), 22.5f64.to_radians().cos());
    let body = 0.25 + 0.75 * (1.0 - surfaceness + surfaceness * facing);
    let highlight = 0.15 * surfaceness * halfway.powf(20.0);
    let pixel = centre_pixel(&scene, &camera, &settings);
    for c in 0..3 {
        let lit = linear_orange()[c] * body + highlight;
        assert_near("lit", pixel.rgba[c] / pixel.rgba[3], lit, 3e-3 * lit);
    }
}

#[test]
fn mip_is_the_largest_value_on_the_ray() {
    let grid = Grid::centred([14, 14, 14], DVec3::ONE).unwrap();
    let volume = sample(&Noise::new(3, 40, DVec3::splat(2.0)), &grid);
    let range = volume.value_range();
    let scene = Scene::new(volume, linear_extinction(range, 2.0, ORANGE));
    let settings = settings(Compositing::Mip, Classification::Post);
    let field = Reconstruction::new(
        scene.single_volume().unwrap().volume,
        &settings.method.kernel(),
        true,
    )
    .unwrap();
    let mut random = Random::new(12);
    for _ in 0..8 {
        let direction = random.direction();
        let camera = orthographic(-30.0 * direction, direction);
        let pixel = centre_pixel(&scene, &camera, &settings);
        let largest = (0..60_000)
            .map(|i| (f64::from(i) * 1e-3 - 30.0) * direction + DVec3::splat(6.5))
            .map(|at| (at, field.sums(at)))
            .filter(|(_, sums)| sums.coverage() >= 0.5)
            .map(|(_, sums)| field.data_value(&sums))
            .fold(f64::NEG_INFINITY, f64::max);
        let extinction = scene
            .single_volume()
            .unwrap()
            .transfer_function
            .extinction(largest, 1.0);
        assert_near("optical depth", pixel.optical_depth, extinction, 1e-3);
        assert!(pixel.optical_depth > extinction - 1e-6, "misses the maximum");
        let red = -(-extinction).exp_m1() * linear_orange()[0];
        assert_near("colour", pixel.rgba[0], red, 1e-3);
    }
}

#[test]
fn minimum_and_mean_are_those_of_the_ray() {
    let grid = Grid::centred([14, 14, 14], DVec3::ONE).unwrap();
    let volume = sample(&Noise::new(4, 40, DVec3::splat(2.0)), &grid);
    let range = volume.value_range();
    let scene = Scene::new(volume, linear_extinction(range, 2.0, ORANGE));
    let smallest = settings(Compositing::MinimumIntensity, Classification::Post);
    let mean = settings(Compositing::Mean, Classification::Post);
    let field = Reconstruction::new(
        scene.single_volume().unwrap().volume,
        &smallest.method.kernel(),
        true,
    )
    .unwrap();
    let mut random = Random::new(13);
    for _ in 0..8 {
        let direction = random.direction();
        let camera = orthographic(-30.0 * direction, direction);
        let (mut least, mut sums) = (f64::INFINITY, [0.0; 3]);
        for i in 0..60_000 {
            let depth = f64::from(i) * 1e-3;
            let found = field.sums((depth - 30.0) * direction + DVec3::splat(6.5));
            let coverage = found.coverage();
            if coverage <= 0.0 {
                continue;
            }
            let value = field.data_value(&found);
            if coverage >= 0.5 {
                least = least.min(value);
            }
            for (sum, term) in sums.iter_mut().zip([1.0, value, depth]) {
                *sum += coverage * term;
            }
        }
        let pixel = centre_pixel(&scene, &camera, &smallest);
        let extinction = scene
            .single_volume()
            .unwrap()
            .transfer_function
            .extinction(least, 1.0);
        assert_near("smallest", pixel.optical_depth, extinction, 1e-3);
        assert!(pixel.optical_depth < extinction + 1e-6, "misses the minimum");
        let pixel = centre_pixel(&scene, &camera, &mean);
        let extinction = scene
            .single_volume()
            .unwrap()
            .transfer_function
            .extinction(sums[1] / sums[0], 1.0);
        assert_near("mean", pixel.optical_depth, extinction, 1e-4);
        assert_near("its depth", pixel.depth, sums[2] / sums[0], 1e-3);
    }
}

#[test]
fn frames_hold_the_pixels_and_nothing_where_nothing_is() {
    let scene = constant_box([4, 4, 4], DVec3::ONE, 0.5);
    let camera = orthographic(DVec3::new(0.0, 0.0, -20.0), DVec3::Z);
    let options = ReferenceSettings::default();
    let frame = render(&scene, &camera, &post(), &options).unwrap();
    let pixel = centre_pixel(&scene, &camera, &post());
    assert_eq!(frame.image.pixel(4, 4), pixel.rgba.map(|c| c as f32));
    assert_eq!(frame.depth[4 * 9 + 4], pixel.depth as f32);
    assert_eq!(frame.image.pixel(0, 0), [0.0; 4]);
    assert_eq!((frame.depth[0], frame.optical_depth[0]), (f32::INFINITY, 0.0));
}

#[test]
fn a_smaller_tolerance_changes_no_more_than_the_tolerance() {
    let grid = Grid::centred([16, 16, 16], DVec3::ONE).unwrap();
    let volume = sample(&Noise::new(9, 60, DVec3::splat(1.8)), &grid);
    let scene = Scene::new(volume, band_extinction([0.55, 0.6], 3.0, ORANGE));
    let camera = orthographic(DVec3::new(20.0, 15.0, 9.0), DVec3::new(-20.0, -15.0, -9.0));
    let settings = RenderSettings {
        lighting: Some(Lighting::default()),
        ..post()
    };
    let frame = |tolerance| {
        let options = ReferenceSettings {
            tolerance,
            initial_step: 0.5,
        };
        render(&scene, &camera, &settings, &options).unwrap()
    };
    let (coarse, fine) = (frame(1e-5), frame(1e-8));
    let pairs = coarse
        .image
        .pixels
        .iter()
        .flatten()
        .zip(fine.image.pixels.iter().flatten());
    let largest = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    println!("largest difference between tolerances 1e-5 and 1e-8: {largest:e}");
    assert!(largest < 1e-4 && fine.image.pixel(4, 4)[3] > 0.1, "{largest}");
}
