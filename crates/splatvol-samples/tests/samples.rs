//! Facts that every sample keeps: same bytes for any number of threads, plausible ranges, symmetry.

use splatvol_samples::{Sample, SampleError, SampleSize, sample};
use splatvol_scene::{LengthUnit, Samples, Volume};

fn small(sample: Sample) -> Volume {
    sample
        .generate(Some(SampleSize::Longest(44)))
        .expect("44 voxels are allowed")
}

#[test]
fn bytes_do_not_depend_on_the_number_of_threads() {
    for sample in Sample::ALL {
        let expected = small(sample);
        for threads in [1, 2, 7] {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            let found = pool.install(|| small(sample));
            assert_eq!(
                found.samples(),
                expected.samples(),
                "{sample:?}, {threads} threads"
            );
        }
    }
}

#[test]
fn every_sample_is_found_by_name_and_has_a_visible_transfer_function() {
    for sample in Sample::ALL {
        assert_eq!(Sample::from_name(sample.name()).unwrap(), sample);
        let volume = small(sample);
        assert_eq!(volume.statistics().non_finite, 0);
        let transfer_function = sample.default_transfer_function().unwrap();
        let count = volume.samples().len();
        let visible = (0..count)
            .filter(|&i| transfer_function.opacity(volume.value(i)) > 0.01)
            .count();
        assert!(visible > count / 100, "{sample:?}: {visible} of {count} visible");
    }
    let error = sample("hed", None).unwrap_err();
    assert!(matches!(
        error,
        SampleError::UnknownName {
            nearest: Some("head"),
            ..
        }
    ));
}

#[test]
fn default_dims_are_those_of_the_papers() {
    let dims = |name| sample(name, None).unwrap().grid().dims();
    assert_eq!(dims("marschner-lobb"), [41, 41, 41]);
    assert_eq!(dims("checker-sheet"), [498, 398, 1]);
    assert_eq!(dims("tunnel"), [160, 160, 300]);
    assert_eq!(dims("zebra"), [1024, 512, 3]);
    let default = |sample: Sample| sample.default_dims();
    assert_eq!(default(Sample::Terrain), [512, 512, 103]);
    assert_eq!(default(Sample::Microtubules), [420, 468, 62]);
    assert_eq!(default(Sample::Nerve), [512, 512, 76]);
    assert_eq!(default(Sample::Tomato), [256; 3]);
    let nerve = sample("nerve", Some(SampleSize::Longest(64))).unwrap();
    assert_eq!(nerve.grid().spacing().to_array(), [1.0, 1.0, 5.0]);
}

#[test]
fn the_head_is_in_hounsfield_units_and_lies_in_ras() {
    let volume = sample("head", Some(SampleSize::Longest(128))).unwrap();
    assert_eq!(volume.unit(), LengthUnit::Millimetre);
    let at = |x: f64, y: f64, z: f64| {
        let world = glam::DVec3::new(x, y, z);
        let voxel = volume
            .grid()
            .world_from_voxel()
            .inverse()
            .transform_point3(world)
            .round();
        let [i, j, k] = voxel.to_array().map(|v| v as usize);
        volume.value((k * 128 + j) * 128 + i)
    };
    // Air before the face, brain, petrous bone, neck muscle below, vertex above.
    assert!(at(0.0, 132.0, 0.0) < -980.0);
    assert!(
        (0.0..60.0).contains(&at(30.0, -20.0, 60.0)),
        "{}",
        at(30.0, -20.0, 60.0)
    );
    assert!(at(0.0, -83.0, 4.0) > 300.0, "{}", at(0.0, -83.0, 4.0));
    assert!(at(0.0, 0.0, 130.0) < -980.0 && at(0.0, -30.0, -115.0) > -50.0);
    // The nose points forward.
    assert!(at(0.0, 112.0, -9.0) > -500.0 && at(0.0, -112.0, -9.0) < -900.0);
    let [low, high] = volume.value_range();
    assert!(
        (-1024.0..=-1000.0).contains(&low) && (1300.0..2200.0).contains(&high),
        "{low} {high}"
    );
}

#[test]
fn the_head_is_mirror_symmetric_but_for_texture() {
    let n = 64;
    let volume = sample("head", Some(SampleSize::Longest(n))).unwrap();
    let Samples::I16(data) = volume.samples() else {
        panic!("the head is i16");
    };
    let solid = |v: i16| v > -500;
    let rows = data.chunks_exact(n);
    let differing: usize = rows
        .map(|row| {
            (0..n / 2)
                .filter(|&x| solid(row[x]) != solid(row[n - 1 - x]))
                .count()
        })
        .sum();
    // Noise may turn a voxel on the threshold.
    assert!(differing * 2000 < data.len(), "{differing} voxels");
}
