//! The field that coefficients stand for: against the analytic signal, trilinear interpolation and the reference.

use glam::DVec3;
use splatvol_core::coefficients::{Coefficients, Use};
use splatvol_core::kernel::GaussianKernel;
use splatvol_reference::Reconstruction;
use splatvol_scene::{Grid, Kernel, Volume};
use splatvol_testing::fields::{MarschnerLobb, Noise};
use splatvol_testing::{Field, Random, sample};

/// `S / W` at a voxel position, summed as docs/numerics.md writes it.
fn value(field: &Coefficients, kernel: &GaussianKernel, voxel: DVec3) -> f64 {
    let at = voxel + DVec3::from_array(field.margin.map(|m| m as f64));
    let [nx, ny, _] = field.dims;
    let range = |axis: usize| {
        let (low, high) = (
            (at[axis] - kernel.radius).ceil().max(0.0),
            (at[axis] + kernel.radius).floor(),
        );
        low as usize..=(high as usize).min(field.dims[axis] - 1)
    };
    let (mut sum, mut weight) = (0.0, 0.0);
    for z in range(2) {
        for y in range(1) {
            for x in range(0) {
                let offset = at - DVec3::new(x as f64, y as f64, z as f64);
                let h = (-0.5 * offset.length_squared() / kernel.sigma.powi(2)).exp();
                sum += h * f64::from(field.values[(z * ny + y) * nx + x]);
                weight += h;
            }
        }
    }
    sum / weight
}

fn trilinear(volume: &Volume, voxel: DVec3) -> f64 {
    let [nx, ny, nz] = volume.grid().dims();
    let base = voxel
        .floor()
        .min(DVec3::new(nx as f64, ny as f64, nz as f64) - 2.0);
    let t = voxel - base;
    (0..8)
        .map(|corner| {
            let pick = |axis: usize| corner >> axis & 1;
            let weight: f64 = (0..3)
                .map(|axis| if pick(axis) == 1 { t[axis] } else { 1.0 - t[axis] })
                .product();
            let index = |axis: usize| base[axis] as usize + pick(axis);
            weight * volume.value((index(2) * ny + index(1)) * nx + index(0))
        })
        .sum()
}

/// PSNR in dB (the signal's range is 0..1) and largest error over random points of the box of sample centres.
fn error_of(grid: &Grid, reconstruct: impl Fn(DVec3) -> f64) -> (f64, f64) {
    let signal = MarschnerLobb::default();
    let mut random = Random::new(41);
    let last = DVec3::from_array(grid.dims().map(|n| n as f64 - 1.0));
    let (mut squares, mut largest) = (0.0, 0.0f64);
    const POINTS: usize = 40_000;
    for _ in 0..POINTS {
        let voxel = random.point(DVec3::ZERO, last);
        let error = reconstruct(voxel) - signal.value(grid.world_from_voxel().transform_point3(voxel));
        squares += error * error;
        largest = largest.max(error.abs());
    }
    (-10.0 * (squares / POINTS as f64).log10(), largest)
}

#[test]
fn marschner_lobb_is_reconstructed_well_above_trilinear() {
    let grid = MarschnerLobb::grid(41);
    let volume = sample(&MarschnerLobb::default(), &grid);
    let [low, high] = volume.value_range();
    let kernel = GaussianKernel::new(Kernel::default());
    let figures = [Some(&kernel), None].map(|interpolate| {
        let (field, _) = Coefficients::new(&volume, Use::Field(interpolate));
        error_of(&grid, |voxel| low + (high - low) * value(&field, &kernel, voxel))
    });
    let linear = error_of(&grid, |voxel| trilinear(&volume, voxel));
    println!(
        "prefiltered {:.2?}, plain {:.2?}, trilinear {linear:.2?} (dB, largest error)",
        figures[0], figures[1]
    );
    assert!(figures[0].0 >= 35.5 && figures[0].1 < 0.083, "{figures:?}");
    assert!((28.8..29.3).contains(&linear.0), "{linear:?}");
    assert!(
        figures[1].0 < linear.0,
        "without the prefilter splatting blurs: {figures:?}"
    );
}

#[test]
fn the_field_is_that_of_the_reference() {
    let grid = Grid::centred([13, 1, 22], DVec3::new(1.0, 2.0, 0.5)).unwrap();
    let volume = sample(&Noise::new(3, 20, DVec3::splat(2.0)), &grid);
    let [low, high] = volume.value_range();
    for shape in [
        Kernel::default(),
        Kernel::Gaussian {
            sigma: 0.6,
            radius: 2.0,
        },
    ] {
        let kernel = GaussianKernel::new(shape);
        let reference = Reconstruction::new(&volume, &shape, true).unwrap();
        let (field, _) = Coefficients::new(&volume, Use::Field(Some(&kernel)));
        let mut random = Random::new(9);
        for _ in 0..500 {
            let voxel = random.point(DVec3::new(-0.4, 0.0, -0.4), DVec3::new(12.4, 0.0, 21.4));
            let found = low + (high - low) * value(&field, &kernel, voxel);
            let exact = reference.value(voxel);
            assert!(
                (found - exact).abs() < 5e-6 * (high - low),
                "{voxel}: {found} {exact}"
            );
        }
    }
}
