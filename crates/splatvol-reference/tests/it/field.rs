//! The reconstructed field against closed forms.

use glam::{DMat3, DVec3};
use splatvol_reference::{Reconstruction, ReferenceError};
use splatvol_scene::{Grid, Kernel, LengthUnit, Rescale, Samples, Volume};
use splatvol_testing::fields::{MarschnerLobb, Ramp};
use splatvol_testing::{Field, Random, sample};

fn kernel(sigma: f64, radius: f64) -> Kernel {
    Kernel::Gaussian { sigma, radius }
}

/// Box of seeded random samples, unit spacing; `missing` of them are NaN.
fn random_volume(dims: [usize; 3], missing: &[usize]) -> Volume {
    let mut random = Random::new(11);
    let mut samples: Vec<f64> = (0..dims.iter().product::<usize>())
        .map(|_| random.range(-3.0, 5.0))
        .collect();
    for &index in missing {
        samples[index] = f64::NAN;
    }
    let grid = Grid::centred(dims, DVec3::ONE).unwrap();
    Volume::new(
        grid,
        Samples::F64(samples.into()),
        Rescale::default(),
        LengthUnit::Unknown,
    )
    .unwrap()
}

fn voxels(dims: [usize; 3]) -> impl Iterator<Item = (usize, DVec3)> {
    let position = move |index: usize| {
        let [nx, ny, _] = dims;
        let ijk = [index % nx, index / nx % ny, index / (nx * ny)];
        (index, DVec3::from_array(ijk.map(|i| i as f64)))
    };
    (0..dims.iter().product()).map(position)
}

#[test]
fn prefiltered_field_interpolates_every_sample() {
    for (kernel, tolerance) in [
        (kernel(0.7, 3.5), 1e-12),
        (kernel(0.6, 2.0), 1e-12),
        (kernel(1.0, 3.0), 1e-9),
    ] {
        let dims = [9, 6, 4];
        let volume = random_volume(dims, &[]);
        let field = Reconstruction::new(&volume, &kernel, true).unwrap();
        for (index, at) in voxels(dims) {
            let difference = field.value(at) - volume.value(index);
            assert!(
                difference.abs() < tolerance * 100.0,
                "{kernel:?} at {at}: {difference}"
            );
        }
    }
}

#[test]
fn thin_boxes_are_solved_too() {
    for dims in [[1, 1, 1], [5, 1, 1], [1, 2, 7]] {
        let volume = random_volume(dims, &[]);
        let field = Reconstruction::new(&volume, &kernel(0.7, 3.0), true).unwrap();
        for (index, at) in voxels(dims) {
            assert!((field.value(at) - volume.value(index)).abs() < 1e-11);
        }
    }
}

#[test]
fn a_kernel_that_cannot_be_inverted_is_an_error() {
    // Cut after one neighbour, an axis of n samples has eigenvalues 1 + 2 g(1) cos(j pi / (n + 1)). All are
    // positive for g(1) = 1/2.
    let half = 1.0 / (2.0 * 2f64.ln()).sqrt();
    let volume = random_volume([5, 1, 1], &[]);
    assert!(Reconstruction::new(&volume, &kernel(half, 1.5 * half), true).is_ok());
    // With the mirrored ends 3 samples are an axis of 5. g(1) = 1 / sqrt 3: 1 + 2 / sqrt 3 cos(5 pi / 6) = 0.
    let sigma = 1.0 / 3f64.ln().sqrt();
    let volume = random_volume([3, 1, 1], &[]);
    let error = Reconstruction::new(&volume, &kernel(sigma, 1.5 * sigma), true).unwrap_err();
    assert!(
        matches!(error, ReferenceError::SingularKernel { count: 5, .. }),
        "{error}"
    );
}

#[test]
fn a_linear_ramp_is_reproduced_inside() {
    let grid = Grid::new(
        [16, 14, 12],
        DVec3::new(5.0, -3.0, 1.0),
        DVec3::new(0.5, 1.0, 2.0),
        DMat3::from_rotation_x(0.4),
    )
    .unwrap();
    let ramp = Ramp {
        offset: 2.0,
        gradient: DVec3::new(0.3, -0.2, 0.1),
    };
    let volume = sample(&ramp, &grid);
    let field = Reconstruction::new(&volume, &kernel(0.7, 3.5), true).unwrap();
    let [low, high] = volume.value_range();
    let mut random = Random::new(2);
    for _ in 0..200 {
        let at = random.point(DVec3::splat(4.0), DVec3::new(11.0, 9.0, 7.0));
        let exact = ramp.value(grid.world_from_voxel().transform_point3(at));
        let error = (field.value(at) - exact) / (high - low);
        assert!(error.abs() < 2e-4, "{at}: {error}");
        // Gradient: S in value ranges per voxel.
        let exact = grid.world_from_voxel().matrix3.transpose() * ramp.gradient / (high - low);
        let error = (field.sums(at).grad_s - exact).length();
        assert!(error < 3e-3 * exact.length() + 1e-3, "{at}: {error}");
    }
}

#[test]
fn gradients_are_those_of_the_sums() {
    const STEP: f64 = 1e-5;
    let dims = [7, 8, 9];
    let field = Reconstruction::new(&random_volume(dims, &[100, 201]), &kernel(0.8, 6.0), false).unwrap();
    let covariance = DMat3::from_cols(
        DVec3::new(0.9, 0.2, -0.1),
        DVec3::new(0.2, 0.8, 0.15),
        DVec3::new(-0.1, 0.15, 1.1),
    );
    let plain = |at: DVec3| field.sums(at);
    let filtered = |at: DVec3| field.filtered_sums(at, covariance);
    let mut random = Random::new(4);
    for _ in 0..100 {
        let at = random.point(DVec3::splat(-1.5), DVec3::new(7.5, 8.5, 9.5));
        for sums in [&plain as &dyn Fn(DVec3) -> _, &filtered] {
            let slope = |axis: DVec3| (sums(at + STEP * axis).s - sums(at - STEP * axis).s) / (2.0 * STEP);
            let numeric = DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
            let error = (numeric - sums(at).grad_s).length();
            assert!(error < 1e-7, "{at}: {error}");
        }
    }
}

#[test]
fn a_vanishing_low_pass_leaves_the_field() {
    let field = Reconstruction::new(&random_volume([7, 8, 9], &[]), &kernel(0.7, 3.0), true).unwrap();
    let own = DMat3::from_diagonal(DVec3::splat(0.49));
    let mut random = Random::new(6);
    for _ in 0..100 {
        let at = random.point(DVec3::splat(-2.0), DVec3::new(8.0, 9.0, 10.0));
        let (plain, filtered) = (field.sums(at), field.filtered_sums(at, own));
        assert!((plain.s - filtered.s).abs() < 1e-12 && (plain.w - filtered.w).abs() < 1e-12);
        assert!((plain.grad_s - filtered.grad_s).length() < 1e-11);
    }
}

#[test]
fn missing_samples_have_no_weight() {
    let dims = [7, 7, 7];
    let centre = 3 + 7 * (3 + 7 * 3);
    let whole = Reconstruction::new(&random_volume(dims, &[]), &kernel(0.7, 3.0), false).unwrap();
    let holed = Reconstruction::new(&random_volume(dims, &[centre]), &kernel(0.7, 3.0), false).unwrap();
    let at = DVec3::new(3.2, 2.9, 3.4);
    let offset = at - DVec3::splat(3.0);
    let g = |t: f64| (-0.5 * (t / 0.7f64).powi(2)).exp();
    let lattice: f64 = (-3..=3).map(|j| g(f64::from(j))).sum();
    let weight = g(offset.x) * g(offset.y) * g(offset.z) / lattice.powi(3);
    assert!((whole.sums(at).w - holed.sums(at).w - weight).abs() < 1e-12);
    // A constant with a hole stays that constant, prefiltered or not, up to the ripple of the filled hole.
    let grid = Grid::centred(dims, DVec3::ONE).unwrap();
    let mut samples = vec![2.5; 343];
    samples[centre] = f64::INFINITY;
    samples[0] = 1.5;
    let volume = Volume::new(
        grid,
        Samples::F64(samples.into()),
        Rescale::default(),
        LengthUnit::Unknown,
    )
    .unwrap();
    for prefilter in [false, true] {
        let field = Reconstruction::new(&volume, &kernel(0.7, 3.0), prefilter).unwrap();
        assert!((field.value(at) - 2.5).abs() < 1e-3, "{}", field.value(at));
        // The same voxel in the continued lattice.
        assert_eq!(field.coefficients()[(4 * 9 + 4) * 9 + 4], 0.0);
    }
}

#[test]
fn a_missing_sample_is_filled_with_its_finite_neighbours_mean() {
    // 0, 0, missing, 1, 1 -> filled with 1/2, so that the solution is that of 0, 0, 1/2, 1, 1.
    let volume = |middle: f64| {
        let grid = Grid::centred([5, 1, 1], DVec3::ONE).unwrap();
        let samples = Samples::F64(vec![0.0, 0.0, middle, 1.0, 1.0].into());
        Volume::new(grid, samples, Rescale::default(), LengthUnit::Unknown).unwrap()
    };
    let coefficients = |middle| {
        Reconstruction::new(&volume(middle), &Kernel::default(), true)
            .unwrap()
            .coefficients()
    };
    let (filled, holed) = (coefficients(0.5), coefficients(f64::NAN));
    // One mirrored sample on either side.
    assert_eq!(holed.len(), 7);
    assert!([1, 2, 4, 5].iter().all(|&i| (filled[i] - holed[i]).abs() < 1e-14));
    assert_eq!(holed[3], 0.0);
}

/// PSNR (peak 1) and largest error of the value at random points at least `margin` voxels inside the outer samples.
fn marschner_lobb_error(field: &Reconstruction, grid: &Grid, margin: f64) -> (f64, f64) {
    let signal = MarschnerLobb::default();
    let mut random = Random::new(1994);
    let last = grid.dims()[0] as f64 - 1.0;
    let (mut squares, mut largest) = (0.0, 0.0f64);
    const POINTS: usize = 20_000;
    for _ in 0..POINTS {
        let at = random.point(DVec3::splat(margin), DVec3::splat(last - margin));
        let exact = signal.value(grid.world_from_voxel().transform_point3(at));
        let error = field.value(at) - exact;
        squares += error * error;
        largest = largest.max(error.abs());
    }
    (-10.0 * (squares / POINTS as f64).log10(), largest)
}

#[test]
fn marschner_lobb_quality() {
    let grid = MarschnerLobb::grid(41);
    let volume = sample(&MarschnerLobb::default(), &grid);
    println!("PSNR dB / largest error     margin: one voxel     the kernel's radius     none");
    for sigma in [0.6, 0.65, 0.7] {
        for radius in [2.0, 2.5, 3.0, 3.5] {
            let field = Reconstruction::new(&volume, &kernel(sigma, radius), true).unwrap();
            let [voxel, reach, none] =
                [1.0, radius, 0.0].map(|margin| marschner_lobb_error(&field, &grid, margin));
            println!(
                "sigma {sigma:4.2} radius {radius:3.1}     {:.2} / {:.4}        {:.2} / {:.4}      {:.2} / {:.4}",
                voxel.0, voxel.1, reach.0, reach.1, none.0, none.1
            );
            if (sigma, radius) == (0.7, 3.5) {
                assert!((voxel.0 - 36.5).abs() < 0.5, "{}", voxel.0);
            }
        }
    }
    let plain = Reconstruction::new(&volume, &kernel(0.602, 2.0), false).unwrap();
    let (psnr, _) = marschner_lobb_error(&plain, &grid, 1.0);
    println!("exp(-1.38 r^2) cut at 2, no prefilter, margin one voxel: {psnr:.2} dB");
    assert!((psnr - 26.3).abs() < 0.5);
}
