//! The store against the whole-volume solver and the cell-by-cell store, and against itself.

use std::sync::Arc;

use glam::DVec3;
use splatvol_scene::{
    ColorPoint, Grid, Kernel, LengthUnit, OpacityPoint, Rescale, Samples, TransferFunction, Volume,
};
use splatvol_testing::random::Random;

use super::by_cell::BrickStore;
use super::*;
use crate::classification::ClassificationTable;
use crate::coefficients::{Coefficients, Use};

fn kernel(sigma: f64, radius: f64) -> GaussianKernel {
    GaussianKernel::new(Kernel::Gaussian { sigma, radius })
}

fn volume(dims: [usize; 3], samples: Samples, rescale: Rescale) -> Arc<Volume> {
    let grid = Grid::centred(dims, DVec3::ONE).unwrap();
    Arc::new(Volume::new(grid, samples, rescale, LengthUnit::Unknown).unwrap())
}

/// Smooth waves with noise, 0..1.
fn waves(dims: [usize; 3], noise: f64, seed: u64) -> Vec<f64> {
    let mut random = Random::new(seed);
    (0..dims.iter().product::<usize>())
        .map(|i| {
            let [x, y, z] = [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])].map(|c| c as f64);
            let wave = (0.21 * x).sin() * (0.17 * y + 1.0).cos() * (0.13 * z).cos();
            ((0.5 + 0.5 * wave) * (1.0 - noise) + noise * random.unit()).clamp(0.0, 1.0)
        })
        .collect()
}

fn waves_u8(dims: [usize; 3], noise: f64, seed: u64) -> Samples {
    Samples::U8(
        waves(dims, noise, seed)
            .into_iter()
            .map(|v| (v * 255.0) as u8)
            .collect(),
    )
}

/// Levels of a transfer function over the value range as 0..1.
fn levels(volume: &Volume, opacity: &[(f64, f64)]) -> VisibleLevels {
    let [low, high] = volume.value_range();
    let opacity = opacity
        .iter()
        .map(|&(v, o)| OpacityPoint::new(low + v * (high - low), o))
        .collect();
    let tf = TransferFunction::new(vec![ColorPoint::new(0.0, [1.0; 3])], opacity, Some(1.0)).unwrap();
    VisibleLevels::new(&ClassificationTable::new(&tf, volume.value_range(), 1.0))
}

/// All lattice points: coefficient less background, NaN where not needed.
fn dense(store: &FieldStore) -> Vec<f32> {
    let [nx, ny, nz] = store.dims();
    let mut all = vec![f32::NAN; nx * ny * nz];
    let mut out = [0.0; BRICK_VOXELS];
    for index in 0..store.len() {
        store.decode(index, &mut out);
        scatter(&mut all, [nx, ny, nz], store.first(index), &out);
    }
    all
}

fn scatter(all: &mut [f32], [nx, ny, nz]: [usize; 3], first: [u32; 3], values: &[f32; BRICK_VOXELS]) {
    for (i, value) in values.iter().enumerate() {
        let [x, y, z] = [i % 8, i / 8 % 8, i / 64];
        let [x, y, z] = [
            first[0] as usize + x,
            first[1] as usize + y,
            first[2] as usize + z,
        ];
        if x < nx && y < ny && z < nz {
            all[(z * ny + y) * nx + x] = *value;
        } else {
            assert!(value.is_nan(), "beyond the lattice");
        }
    }
}

#[test]
fn coefficients_are_those_of_the_whole_volume() {
    for (dims, sigma, radius) in [
        ([90, 45, 50], 0.64, 2.0),
        ([150, 40, 37], 0.74, 3.0),
        ([1, 40, 2], 0.64, 2.0),
        ([13, 1, 1], 0.64, 2.0),
        ([62, 30, 30], 0.64, 2.0),
    ] {
        for noise in [0.1, 1.0] {
            let rescale = Rescale {
                slope: -3.0,
                intercept: 11.0,
            };
            let data: Vec<i16> = waves(dims, noise, 3)
                .into_iter()
                .map(|v| (v * 4000.0) as i16 - 1024)
                .collect();
            let volume = volume(dims, Samples::I16(data.into()), rescale);
            let kernel = kernel(sigma, radius);
            let (exact, _) = Coefficients::new(&volume, Use::Field(Some(&kernel)));
            let mut store = FieldStore::new(volume.clone(), &kernel);
            assert_eq!((store.dims(), store.margin()), (exact.dims, exact.margin));
            store.update(&levels(&volume, &[(-0.1, 0.5), (1.1, 0.5)]));
            assert_eq!(store.background(), 0.0);
            let (low, high) = exact
                .values
                .iter()
                .fold((0.0f32, 0.0f32), |(a, b), &v| (a.min(v), b.max(v)));
            // Sixteen bits of a brick's range, and what the halo leaves.
            let demanded = (high - low) / 131_000.0 + 1e-5;
            let mut worst = 0.0f32;
            for (i, (a, b)) in dense(&store).iter().zip(&exact.values).enumerate() {
                worst = worst.max((a - b).abs());
                assert!((a - b).abs() < demanded, "{dims:?} {i}: {a} {b}");
            }
            println!(
                "{dims:?} sigma {sigma}, noise {noise}: {worst:.1e}, coefficients {low:.1} to {high:.1}"
            );
        }
    }
}

#[test]
fn all_that_each_cell_by_itself_needs_is_there_and_little_else() {
    for (dims, noise) in [
        ([70, 45, 40], 0.05),
        ([70, 45, 40], 0.4),
        ([1, 60, 50], 0.1),
        ([64, 9, 2], 0.0),
    ] {
        let volume = volume(dims, waves_u8(dims, noise, 11), Rescale::default());
        let kernel = kernel(0.64, 2.0);
        let (coefficients, _) = Coefficients::new(&volume, Use::Field(Some(&kernel)));
        let mut store = FieldStore::new(volume.clone(), &kernel);
        for opacity in [
            vec![(0.6, 0.0), (0.9, 0.5)],
            vec![
                (0.2, 0.0),
                (0.22, 0.5),
                (0.24, 0.0),
                (0.7, 0.0),
                (0.72, 0.5),
                (0.74, 0.0),
            ],
            vec![(0.98, 0.0), (0.99, 0.5)],
            vec![(0.5, 0.0)],
        ] {
            let levels = levels(&volume, &opacity);
            store.update(&levels);
            let old = BrickStore::new(&volume, &coefficients, &levels, store.background());
            let mut all = vec![f32::NAN; coefficients.values.len()];
            for (&first, values) in old.first.iter().zip(&old.values) {
                scatter(&mut all, coefficients.dims, first, values);
            }
            let mut borderline = 0;
            for (i, (new, old)) in dense(&store).iter().zip(&all).enumerate() {
                // In the outer half, a difference at the tolerance itself may fall on either side of it.
                let decided = (old.abs() - crate::visibility::TOLERANCE).abs() > 1e-4;
                assert!(
                    new.is_finite() || old.is_nan() || !decided,
                    "{dims:?} {opacity:?} {i}"
                );
                borderline += usize::from(!decided);
            }
            assert!(
                store.needed_voxels() <= old.needed + old.needed / 20 + borderline + 100,
                "{dims:?} {opacity:?}: {} {}",
                store.needed_voxels(),
                old.needed
            );
            assert_eq!(
                store.needed_voxels(),
                dense(&store).iter().filter(|v| v.is_finite()).count()
            );
        }
    }
}

#[test]
fn edits_leave_what_a_new_store_would_hold() {
    let mut random = Random::new(21);
    for (dims, noise) in [([150, 40, 70], 0.1), ([40, 80, 33], 0.02), ([70, 70, 1], 0.5)] {
        let volume = volume(dims, waves_u8(dims, noise, 2), Rescale::default());
        let kernel = kernel(0.64, 2.0);
        let fresh = FieldStore::new(volume.clone(), &kernel);
        let mut frugal = fresh.clone();
        frugal.keep_all = false;
        let mut stores = [fresh.clone(), frugal];
        let mut bottom = 0.5;
        for edit in 0..14 {
            // Small shifts, jumps, and everything visible.
            bottom = if edit % 4 == 3 {
                random.unit()
            } else {
                bottom + random.range(-0.03, 0.03)
            };
            let width = random.range(0.01, 0.5);
            let end = if edit == 9 { 0.5 } else { 0.0 };
            let opacity = [(bottom, end), (bottom + width, 0.5), (bottom + 2.0 * width, end)];
            let levels = levels(&volume, &opacity);
            let mut new = fresh.clone();
            new.update(&levels);
            for store in &mut stores {
                store.update(&levels);
                assert_eq!(store.background(), new.background());
                assert_eq!(
                    (store.len(), store.needed_voxels()),
                    (new.len(), new.needed_voxels())
                );
                assert!((0..new.len()).all(|i| store.first(i) == new.first(i)));
                let same = dense(store)
                    .iter()
                    .zip(dense(&new))
                    .all(|(a, b)| a.to_bits() == b.to_bits());
                assert!(same, "{dims:?} edit {edit}");
            }
            assert!(stores[1].bytes() <= stores[0].bytes());
        }
    }
}

#[test]
fn missing_samples_stay_missing_and_do_not_spread() {
    let dims = [30, 20, 20];
    let data = |middle: f32| {
        let mut data = vec![3.0f32; 12_000];
        data[0] = 5.0;
        data[(10 * 20 + 9) * 30 + 8] = middle;
        volume(dims, Samples::F32(data.into()), Rescale::default())
    };
    let kernel = kernel(0.64, 2.0);
    let [missing, filled] = [f32::NAN, 3.0].map(|middle| {
        let volume = data(middle);
        let mut store = FieldStore::new(volume.clone(), &kernel);
        store.update(&levels(&volume, &[(-0.1, 0.5), (1.1, 0.5)]));
        dense(&store)
    });
    let middle = (11 * 22 + 10) * 32 + 9;
    for (i, (missing, filled)) in missing.iter().zip(filled).enumerate() {
        assert!(
            if i == middle {
                *missing == f32::INFINITY
            } else {
                (missing - filled).abs() < 1e-4
            },
            "{i}: {missing} {filled}"
        );
    }
}

/// Value of a field at a lattice position, and the weight of the remaining samples.
fn value_at(field: &Coefficients, sigma: f64, at: [f64; 3]) -> [f64; 2] {
    let [nx, ny, nz] = field.dims;
    let (mut sum, mut weight, mut all) = (0.0, 0.0, 0.0);
    let span = |a: usize, n: usize| (at[a] as usize).saturating_sub(4)..(at[a] as usize + 6).min(n);
    for z in span(2, nz) {
        for y in span(1, ny) {
            for x in span(0, nx) {
                let squared = [x, y, z]
                    .iter()
                    .zip(at)
                    .map(|(&p, at)| (p as f64 - at).powi(2))
                    .sum::<f64>();
                let h = (-0.5 * squared / (sigma * sigma)).exp();
                let value = f64::from(field.values[(z * ny + y) * nx + x]);
                all += h;
                if !value.is_nan() {
                    sum += h * value;
                    weight += h;
                }
            }
        }
    }
    [sum / weight, weight / all]
}

#[test]
fn what_can_be_seen_beside_missing_samples_and_without_the_prefilter_is_there() {
    let dims = [41, 30, 27];
    let mut random = Random::new(77);
    for (interpolates, holes) in [
        (true, 2),
        (true, 40),
        (true, 9000),
        (false, 0),
        (false, 40),
        (false, 9000),
    ] {
        let whole: Vec<f32> = waves(dims, 0.1, 4).into_iter().map(|v| v as f32).collect();
        let mut data = whole.clone();
        for _ in 0..holes {
            let at = (random.unit() * data.len() as f64) as usize;
            data[at] = if at.is_multiple_of(2) {
                f32::NAN
            } else {
                f32::INFINITY
            };
        }
        if holes > 1000 {
            // A whole region, with bricks of their own.
            for (i, value) in data.iter_mut().enumerate() {
                if i % dims[0] < 18 {
                    *value = f32::NAN;
                }
            }
        }
        let holed = volume(dims, Samples::F32(data.into()), Rescale::default());
        let kernel = kernel(0.64, 2.0);
        let (field, store) = match interpolates {
            true => (Some(&kernel), FieldStore::new(holed.clone(), &kernel)),
            false => (None, FieldStore::of_samples(holed.clone(), &kernel)),
        };
        let (field, _) = Coefficients::new(&holed, Use::Field(field));
        for band in [[0.2, 0.24], [0.5, 0.53], [0.8, 2.0]] {
            let mut store = store.clone();
            let levels = levels(
                &holed,
                &[
                    (band[0] - 0.001, 0.0),
                    (band[0], 0.5),
                    (band[1], 0.5),
                    (band[1] + 0.001, 0.0),
                ],
            );
            store.update(&levels);
            let there = dense(&store);
            let (mut seen, mut needed) = (0, 0);
            for _ in 0..40_000 {
                let at: [f64; 3] = std::array::from_fn(|a| 1.0 + random.unit() * (dims[a] - 1) as f64);
                let [value, share] = value_at(&field, 0.64, at);
                // Remaining samples with a smaller share hardly cover anything.
                if share < 0.05 || !levels.any(value as f32, value as f32) {
                    continue;
                }
                seen += 1;
                let all = (0..8usize).all(|i| {
                    let [x, y, z] = [0, 1, 2].map(|a| at[a] as usize + (i >> a & 1));
                    !there[(z * field.dims[1] + y) * field.dims[0] + x].is_nan()
                });
                needed += usize::from(all);
            }
            println!("{interpolates} {holes} {band:?}: {needed} of {seen}");
            // Isolated coefficients of noise may lie further outside than the overshoot allows for.
            let demanded = if holes > 1000 { 95 } else { 98 };
            assert!(
                seen > 50 && needed * 100 >= seen * demanded,
                "{interpolates} {holes} {band:?}: {needed} of {seen}"
            );
            for (value, coefficient) in there.iter().zip(&field.values) {
                let same = match coefficient.is_nan() {
                    true => *value == f32::INFINITY,
                    false => (value + store.background() - coefficient).abs() < 1e-4,
                };
                assert!(
                    value.is_nan() || same,
                    "{interpolates} {holes}: {value} {coefficient}"
                );
            }
            if (interpolates, holes) == (true, 2) {
                let without = volume(dims, Samples::F32(whole.clone().into()), Rescale::default());
                let mut without = FieldStore::new(without, &kernel);
                without.update(&levels);
                let [here, there] = [&store, &without].map(FieldStore::needed_voxels);
                assert!(here < there + 2 * 1000, "{band:?}: {here} {there}");
            }
        }
    }
}
