//! Each kind of data is recognised, and shows what it should while noise stays invisible.

use super::*;
use crate::{Grid, LengthUnit, Rescale, Samples};
use glam::DVec3;

const SIZE: usize = 48;

/// Volume of a function of the voxel's place in -1..1 and a random number in 0..1.
fn volume(samples: impl Fn(Vec<f64>) -> Samples, value: impl Fn(DVec3, f64) -> f64) -> Volume {
    let mut seed = 7u64;
    let mut values = Vec::with_capacity(SIZE * SIZE * SIZE);
    for i in 0..SIZE * SIZE * SIZE {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let voxel = [i % SIZE, i / SIZE % SIZE, i / SIZE / SIZE];
        let place = DVec3::from_array(voxel.map(|v| 2.0 * v as f64 / (SIZE as f64 - 1.0) - 1.0));
        values.push(value(place, (seed >> 11) as f64 / (1u64 << 53) as f64));
    }
    let grid = Grid::centred([SIZE; 3], DVec3::ONE).unwrap();
    Volume::new(grid, samples(values), Rescale::default(), LengthUnit::Unknown).unwrap()
}

fn f32s(values: Vec<f64>) -> Samples {
    Samples::F32(values.into_iter().map(|v| v as f32).collect())
}

fn i16s(values: Vec<f64>) -> Samples {
    Samples::I16(values.into_iter().map(|v| v.round() as i16).collect())
}

fn u8s(values: Vec<f64>) -> Samples {
    Samples::U8(values.into_iter().map(|v| v.round() as u8).collect())
}

/// Soft ball of value `soft` with a dense core, in noisy air.
fn ball(place: DVec3, air: f64, soft: f64, dense: f64) -> f64 {
    match place.length() {
        r if r < 0.3 => dense,
        r if r < 0.7 => soft,
        _ => air,
    }
}

#[test]
fn materials_show_and_noisy_air_does_not() {
    for (make, noise) in [(u8s as fn(Vec<f64>) -> Samples, 8.0), (f32s, 12.0)] {
        let volume = volume(make, |p, u| ball(p, 10.0, 80.0, 200.0) + noise * u);
        let (tf, choice) = TransferFunction::automatic(&volume, None);
        assert_eq!(choice.kind, ValueKind::Materials, "{}", choice.reason);
        assert_eq!(tf.opacity(10.0 + noise), 0.0, "{:?}", tf.opacities());
        let (soft, dense) = (tf.opacity(80.0 + 0.5 * noise), tf.opacity(200.0 + 0.5 * noise));
        assert!(
            soft > 0.005 && soft < 0.2 && dense > 3.0 * soft && dense > 0.3,
            "{soft} {dense}"
        );
        assert_ne!(tf.color(80.0), tf.color(200.0));
    }
}

#[test]
fn a_bright_background_is_transparent_too() {
    let volume = volume(f32s, |p, u| ball(p, 250.0, 150.0, 20.0) - 5.0 * u);
    let (tf, choice) = TransferFunction::automatic(&volume, None);
    assert_eq!(choice.kind, ValueKind::Materials);
    assert!(choice.reason.contains("negated"), "{}", choice.reason);
    assert_eq!(tf.opacity(245.0), 0.0);
    assert!(tf.opacity(18.0) > tf.opacity(148.0) && tf.opacity(148.0) > 0.0);
}

#[test]
fn hounsfield_units_give_tissue_and_bone() {
    let volume = volume(i16s, |p, u| ball(p, -1000.0, 40.0, 900.0) + 30.0 * u);
    let (tf, choice) = TransferFunction::automatic(&volume, None);
    assert_eq!(choice.kind, ValueKind::Hounsfield);
    assert_eq!(tf.opacity(-900.0), 0.0);
    assert!(tf.opacity(40.0) > 0.001 && tf.opacity(40.0) < 0.2);
    assert!(tf.opacity(900.0) >= 0.3);
}

#[test]
fn numbers_in_reasons_have_four_significant_digits() {
    for (value, text) in [
        (0.0, "0"),
        (87.183_412, "87.18"),
        (-1000.0, "-1000"),
        (123_456.7, "123457"),
        (0.001_5, "0.0015"),
        (2.345_67e-7, "2.346e-7"),
        (1e200, "1.000e200"),
    ] {
        assert_eq!(short(value), text);
    }
}

#[test]
fn the_background_is_that_of_the_faces_or_the_least_value() {
    let bright = volume(f32s, |p, u| ball(p, 250.0, 150.0, 20.0) - 5.0 * u);
    let level = TransferFunction::background_of(&bright);
    assert!((245.0..=250.0).contains(&level), "{level}");
    let everywhere = volume(f32s, |p, u| 30.0 * u + 10.0 * p.x);
    let least = everywhere.value_range()[0];
    assert_eq!(TransferFunction::background_of(&everywhere), least);
}

#[test]
fn labels_keep_their_values_apart() {
    let volume = volume(u8s, |p, _| match p.length() {
        r if r < 0.2 => 30.0,
        r if r < 0.5 => 3.0,
        r if r < 0.8 => 2.0,
        _ => 0.0,
    });
    let (tf, choice) = TransferFunction::automatic(&volume, None);
    assert_eq!(
        (choice.kind, choice.classification),
        (ValueKind::Labels, Classification::Pre)
    );
    assert!(choice.reason.starts_with("4 whole numbers"), "{}", choice.reason);
    let (_, continuous) = TransferFunction::automatic_continuous(&volume, None);
    assert_eq!(
        (continuous.kind, continuous.classification),
        (ValueKind::Materials, Classification::Post)
    );
    assert_eq!(tf.opacity(0.0), 0.0);
    let colors = [2.0, 3.0, 30.0].map(|label| tf.color(label));
    assert!(colors[0] != colors[1] && colors[1] != colors[2] && colors[0] != colors[2]);
    for label in [2.0, 3.0, 30.0] {
        assert!(tf.opacity(label) > 0.02);
        assert_eq!(tf.color(label), tf.color(label + 0.3));
    }
}

#[test]
fn signed_data_diverge_around_zero() {
    let volume = volume(f32s, |p, u| {
        let lobe = |x: f64| (-40.0 * (p - DVec3::new(x, 0.0, 0.0)).length_squared()).exp();
        9.0 * lobe(-0.4) - 6.0 * lobe(0.4) + 0.1 * (u - 0.5)
    });
    let (tf, choice) = TransferFunction::automatic(&volume, None);
    assert_eq!(choice.kind, ValueKind::Signed);
    assert_eq!(tf.opacity(0.06), 0.0);
    assert!(tf.opacity(8.0) > 0.3 && tf.opacity(-5.0) > 0.0);
    let (positive, negative) = (tf.color(8.0), tf.color(-8.0));
    assert!(positive[0] > positive[2] && negative[2] > negative[0]);
}

#[test]
fn a_masked_map_of_noise_shows_its_peak_alone() {
    // A sum of four uniform numbers is nearly normal; its standard deviation here is 1.
    let volume = volume(f32s, |p, u| {
        let noise = [1.0, 7.0, 31.0, 127.0]
            .iter()
            .map(|factor| (u * factor).fract() - 0.5)
            .sum::<f64>();
        let peak = 12.0 * (-30.0 * (p - DVec3::new(0.3, 0.2, 0.0)).length_squared()).exp();
        if p.length() < 0.9 { 1.7 * noise + peak } else { 0.0 }
    });
    let (tf, choice) = TransferFunction::automatic(&volume, None);
    assert_eq!(choice.kind, ValueKind::Signed, "{}", choice.reason);
    assert_eq!([tf.opacity(1.9), tf.opacity(-1.9)], [0.0, 0.0]);
    assert!(tf.opacity(8.0) > 0.2, "{:?}", tf.opacities());
}

#[test]
fn soft_material_that_hides_nothing_is_denser() {
    let opacity = |soft_at: f64| {
        let volume = volume(f32s, |p, u| {
            let core = (p - DVec3::splat(0.5)).length() < 0.38;
            let soft = (p - DVec3::splat(soft_at)).length() < 0.45;
            match (core, soft) {
                (true, _) => 120.0 + 100.0 * u,
                (false, true) => 30.0 + 30.0 * u,
                _ => 4.0 * u,
            }
        });
        let (tf, choice) = TransferFunction::automatic(&volume, None);
        assert_eq!(choice.kind, ValueKind::Materials, "{}", choice.reason);
        tf.opacity(45.0)
    };
    let (around, beside) = (opacity(0.5), opacity(-0.45));
    assert!(beside > 0.06 && beside > 2.0 * around, "{around} {beside}");
}

#[test]
fn the_order_of_the_axes_in_the_file_does_not_matter() {
    let dims = [30usize, 22, 26];
    let value = |[x, y, z]: [usize; 3]| (((x * 31 + y * 17 + z * 7) % 97) + 3 * x * (y + z)) as u8;
    // Voxel axis `order[i]` runs along world axis i, against it where `flip[i]`.
    let stored = |order: [usize; 3], flip: [bool; 3]| {
        let mut stored_dims = [0; 3];
        let mut columns = [DVec3::ZERO; 3];
        let mut origin = DVec3::ZERO;
        for world in 0..3 {
            stored_dims[order[world]] = dims[world];
            columns[order[world]][world] = if flip[world] { -1.5 } else { 1.5 };
            if flip[world] {
                origin[world] = 1.5 * (dims[world] as f64 - 1.0);
            }
        }
        let mut samples = Vec::new();
        for i in 0..dims.iter().product() {
            let voxel = [
                i % stored_dims[0],
                i / stored_dims[0] % stored_dims[1],
                i / stored_dims[0] / stored_dims[1],
            ];
            samples.push(value(std::array::from_fn(|world| {
                let at = voxel[order[world]];
                if flip[world] { dims[world] - 1 - at } else { at }
            })));
        }
        let [x, y, z] = columns;
        let map = glam::DAffine3::from_mat3_translation(glam::DMat3::from_cols(x, y, z), origin);
        let grid = Grid::from_affine(stored_dims, map).unwrap();
        let volume = Volume::new(
            grid,
            Samples::U8(samples.into()),
            Rescale::default(),
            LengthUnit::Unknown,
        )
        .unwrap();
        TransferFunction::automatic(&volume, None)
    };
    let plain = stored([0, 1, 2], [false; 3]);
    for order in [[0, 1, 2], [1, 2, 0], [2, 1, 0], [0, 2, 1]] {
        for flip in [[false; 3], [true, true, false], [false, true, true]] {
            assert_eq!(stored(order, flip), plain, "{order:?} {flip:?}");
        }
    }
}

#[test]
fn a_field_that_fills_the_grid_is_cut_in_the_middle() {
    // Marschner-Lobb 1994, equation 3.
    let volume = volume(f32s, |p, _| {
        let rho = (12.0 * std::f64::consts::PI * (0.5 * std::f64::consts::PI * p.x.hypot(p.y)).cos()).cos();
        (1.0 - (0.5 * std::f64::consts::PI * p.z).sin() + 0.25 * (1.0 + rho)) / 2.5
    });
    let (tf, choice) = TransferFunction::automatic(&volume, None);
    assert_eq!(choice.kind, ValueKind::Continuous, "{}", choice.reason);
    assert_eq!(tf.opacity(0.4), 0.0);
    assert!(tf.opacity(0.6) >= 0.5);
}

#[test]
fn thin_bright_structures_are_found() {
    // A straight vessel two voxels wide: 0.1 % of the volume.
    let volume = volume(u8s, |p, u| {
        if (p.x - 0.1).hypot(p.y) < 0.05 {
            200.0
        } else {
            12.0 * u
        }
    });
    let (tf, choice) = TransferFunction::automatic(&volume, None);
    assert_eq!(choice.kind, ValueKind::Materials, "{}", choice.reason);
    assert_eq!(tf.opacity(12.0), 0.0);
    assert!(tf.opacity(200.0) > 0.5);
}

#[test]
fn odd_volumes_give_valid_functions() {
    let one = |samples: Samples| {
        let grid = Grid::centred([samples.len(), 1, 1], DVec3::ONE).unwrap();
        TransferFunction::automatic(
            &Volume::new(grid, samples, Rescale::default(), LengthUnit::Unknown).unwrap(),
            ColorMap::from_name("turbo").ok(),
        )
    };
    assert_eq!(one(Samples::F32(vec![3.0].into())).1.kind, ValueKind::Constant);
    one(Samples::U8(vec![0, 255].into()));
    one(Samples::F64(vec![-1e300, 0.0, 7e299].into()));
    one(Samples::F32(
        vec![f32::NAN, 1.0, 1.0 + f32::EPSILON, f32::INFINITY].into(),
    ));
    one(Samples::F64(vec![0.0, f64::MIN_POSITIVE, 0.0, 0.0, 0.0].into()));
    one(Samples::I32(vec![i32::MIN, i32::MAX, 0, 1, 2].into()));
    // One bright sample that the sparse survey is likely to miss.
    let mut lonely = vec![0.0f32; 100_000];
    lonely[77_777] = 1.0;
    let grid = Grid::centred([100, 100, 10], DVec3::ONE).unwrap();
    let volume = Volume::new(
        grid,
        Samples::F32(lonely.into()),
        Rescale::default(),
        LengthUnit::Unknown,
    )
    .unwrap();
    let (tf, choice) = TransferFunction::automatic(&volume, None);
    assert!(
        tf.opacity(1.0) > 0.0 && tf.opacity(0.0) == 0.0,
        "{choice:?} {tf:?}"
    );
}

#[test]
fn a_given_map_replaces_the_colors_only_and_the_choice_repeats() {
    let volume = volume(f32s, |p, u| ball(p, 10.0, 80.0, 200.0) + 5.0 * u);
    let map = ColorMap::from_name("viridis").unwrap();
    let (plain, choice) = TransferFunction::automatic(&volume, None);
    let (mapped, again) = TransferFunction::automatic(&volume, Some(map));
    assert_eq!(choice, again);
    assert_eq!(plain.opacities(), mapped.opacities());
    assert_eq!(mapped.color(choice.range[0]), map.rgb(0.0));
    assert_eq!(mapped.color(choice.range[1]), map.rgb(1.0));
}

#[test]
fn classic_scans_show_their_known_structures() {
    let Some(folder) = splatvol_recorded::recorded("volumes") else {
        return;
    };
    let load = |name: &str, dims| {
        let samples = Samples::U8(std::fs::read(folder.join(name)).unwrap().into());
        let grid = Grid::centred(dims, DVec3::ONE).unwrap();
        let volume = Volume::new(grid, samples, Rescale::default(), LengthUnit::Unknown).unwrap();
        let (tf, choice) = TransferFunction::automatic(&volume, None);
        assert_eq!(choice.kind, ValueKind::Materials, "{name}: {}", choice.reason);
        tf
    };
    // Air is 75 to 80, dentine about 160, enamel about 230.
    let tooth = load("tooth_103x94x161_uint8.raw", [103, 94, 161]);
    assert_eq!(tooth.opacity(85.0), 0.0);
    let (dentine, enamel) = (tooth.opacity(160.0), tooth.opacity(230.0));
    assert!(
        0.01 < dentine && dentine < enamel && enamel > 0.2,
        "{dentine} {enamel}"
    );
    // Half of the samples are 0 or 1, the atoms reach 255.
    let neghip = load("neghip_64x64x64_uint8.raw", [64; 3]);
    assert_eq!(neghip.opacity(1.0), 0.0);
    assert!(neghip.opacity(255.0) > 0.3);
}

#[test]
fn values_at_the_ends_of_their_type_have_a_look() {
    let f64s = |values: Vec<f64>| Samples::F64(values.into());
    for (low, high) in [(-1e308, 0.7e308), (0.0, f64::MAX), (f64::MIN, 0.0), (0.0, 1e300)] {
        let volume = volume(f64s, |place, _| if place.length() < 0.5 { high } else { low });
        let (tf, _) = TransferFunction::automatic(&volume, None);
        assert!(tf.opacities().iter().all(|point| point.value.is_finite()));
    }
}

#[test]
fn dense_tissue_without_bone_stays_below_full_opacity() {
    // Specks of contrast medium that rays cross in half a mean spacing, and one voxel of bone.
    let cubes = volume(i16s, |place, u| match u {
        _ if place.min_element() > 0.99 => 400.0,
        u if u < 1e-3 => 200.0,
        _ => -1000.0,
    });
    let flat = Grid::centred([SIZE; 3], DVec3::new(0.1, 1.0, 1.0)).unwrap();
    let samples = cubes.samples().clone();
    let volume = Volume::new(flat, samples, Rescale::default(), LengthUnit::Unknown).unwrap();
    let (tf, choice) = TransferFunction::automatic(&volume, None);
    assert_eq!(choice.kind, ValueKind::Hounsfield, "{}", choice.reason);
    assert!(tf.opacities().iter().all(|point| point.opacity <= 0.95));
}
