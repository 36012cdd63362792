//! NIfTI: real files, all 48 orientations, header variants, malformed input.

mod malformed;

use std::path::Path;

use crate::common::nifti_file::NiftiFile;
use crate::common::{Expected, assert_expected, flips, gzip, load, read_bytes, shared_volumes, truncations};
use glam::{DMat3, DQuat, DVec3};
use splatvol_io::{IoError, Loaded, ReadOptions, axis_codes, read_volume};
use splatvol_scene::{LengthUnit, Rescale, Samples};

fn read(bytes: &[u8]) -> Result<Loaded, IoError> {
    read_bytes(tempfile::tempdir().unwrap().path(), "a.nii", bytes)
}

#[test]
fn real_files_are_as_known() {
    let Some(folder) = shared_volumes() else { return };
    type Case = (
        &'static str,
        [usize; 3],
        [f64; 3],
        [f64; 3],
        &'static str,
        &'static str,
    );
    let cases: [Case; 8] = [
        (
            "chris_t1.nii.gz",
            [188, 256, 190],
            [0.88; 3],
            [0.0, 255.0, 44.9493],
            "u8",
            "RAS",
        ),
        (
            "MNI152_2009_template.nii.gz",
            [193, 229, 193],
            [1.0; 3],
            [0.0, 1570.0, 167.102],
            "i16",
            "RAS",
        ),
        (
            "FLAIR.nii.gz",
            [124, 160, 140],
            [1.0; 3],
            [0.0, 255.0, 41.486],
            "u8",
            "RAS",
        ),
        (
            "shear.nii.gz",
            [306, 422, 54],
            [0.482422, 0.482422, 2.37081],
            [-1024.0, 789.0, -799.913],
            "u8",
            "RAS",
        ),
        (
            "avg152T1_RL_nifti.nii.gz",
            [91, 109, 91],
            [2.0; 3],
            [0.0, 255.0, 82.8972],
            "u8",
            "RAS",
        ),
        (
            "zstat1.nii.gz",
            [64, 64, 21],
            [4.0, 4.0, 6.0],
            [-7.70817, 15.6414, 0.0668],
            "f32",
            "RAS",
        ),
        (
            "anatomical.nii",
            [33, 41, 25],
            [2.0; 3],
            [-610.0, 30393.0, 8401.07],
            "i16",
            "LAS",
        ),
        (
            "dwi_b0.nii.gz",
            [81, 106, 76],
            [2.0; 3],
            [0.0, 12645.7, 330.907],
            "f64",
            "RAS",
        ),
    ];
    for (name, dims, spacing, values, sample_type, axes) in cases {
        let loaded = load(&folder.join(name));
        assert_expected(
            name,
            &loaded,
            &Expected {
                dims,
                spacing,
                values,
                sample_type,
            },
        );
        assert_eq!(axis_codes(loaded.volume.grid()), axes, "{name}");
    }
}

#[test]
fn the_same_scan_as_nrrd_has_the_same_voxels_at_the_same_places() {
    let Some(folder) = shared_volumes() else { return };
    let nifti = load(&folder.join("FLAIR.nii.gz")).volume;
    let nrrd = load(&folder.join("FLAIR.nrrd")).volume;
    assert_eq!(nifti.samples(), nrrd.samples());
    for (a, b) in nifti.grid().corners().into_iter().zip(nrrd.grid().corners()) {
        assert!(a.distance(b) < 1e-3, "{a} {b}");
    }
}

/// Samples in the order of RAS+, and the map of that order.
fn reoriented(loaded: &Loaded) -> (Vec<f64>, [usize; 3], DVec3, DVec3) {
    let grid = loaded.volume.grid();
    let (dims, map) = (grid.dims(), grid.world_from_voxel());
    let codes = axis_codes(grid);
    let place = |pair: &str| codes.find(|c| pair.contains(c)).unwrap();
    let axis = ["LR", "PA", "IS"].map(place);
    let forward = axis.map(|a| "RAS".contains(codes.as_bytes()[a] as char));
    let dims_ras = axis.map(|a| dims[a]);
    let stored = |ras: [usize; 3]| {
        let mut voxel = [0; 3];
        for i in 0..3 {
            voxel[axis[i]] = if forward[i] {
                ras[i]
            } else {
                dims_ras[i] - 1 - ras[i]
            };
        }
        voxel
    };
    let mut values = Vec::new();
    for s in 0..dims_ras[2] {
        for a in 0..dims_ras[1] {
            for r in 0..dims_ras[0] {
                let [x, y, z] = stored([r, a, s]);
                values.push(loaded.volume.value(x + dims[0] * (y + dims[1] * z)));
            }
        }
    }
    let world = |ras| map.transform_point3(DVec3::from_array(stored(ras).map(|i| i as f64)));
    (values, dims_ras, world([0; 3]), world(dims_ras.map(|n| n - 1)))
}

#[test]
fn eight_storage_orders_of_one_scan_are_one_object() {
    let Some(folder) = shared_volumes() else { return };
    let reference = reoriented(&load(&folder.join("nifti_space/RAS.nii.gz")));
    for name in ["LPI", "PSR", "ASL", "IAR", "SPL", "ILP", "ARS"] {
        let loaded = load(&folder.join(format!("nifti_space/{name}.nii.gz")));
        assert_eq!(axis_codes(loaded.volume.grid()), name);
        let (values, dims, first, last) = reoriented(&loaded);
        assert_eq!(dims, reference.1, "{name}");
        assert!(values == reference.0, "{name}: voxels differ");
        assert!(
            first.distance(reference.2) < 1e-3 && last.distance(reference.3) < 1e-3,
            "{name}"
        );
        let statistics = loaded.volume.statistics();
        assert!((statistics.max - 92.5539).abs() < 1e-3 && (statistics.mean - 33.6484).abs() < 1e-3);
    }
}

/// All signed permutations: the world direction of each voxel axis.
fn signed_permutations() -> Vec<DMat3> {
    let units = [DVec3::X, DVec3::Y, DVec3::Z];
    let mut all = Vec::new();
    for [a, b, c] in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
        for signs in 0..8 {
            let sign = |bit: usize| if signs >> bit & 1 == 1 { -1.0 } else { 1.0 };
            all.push(DMat3::from_cols(
                units[a] * sign(0),
                units[b] * sign(1),
                units[c] * sign(2),
            ));
        }
    }
    all
}

#[test]
fn all_48_orientations_put_every_voxel_where_it_belongs() {
    let spacing = DVec3::new(1.5, 2.0, 0.5);
    let offset = DVec3::new(-10.0, 20.0, 4.0);
    let mut seen = std::collections::HashSet::new();
    for directions in signed_permutations() {
        for (with_sform, wide) in [(true, false), (false, false), (true, true), (false, true)] {
            let dims = [3, 4, 5];
            let mut file = NiftiFile::new(&dims, 16);
            file.wide = wide;
            file.pixdim[1..4].copy_from_slice(&spacing.to_array());
            let linear = directions * DMat3::from_diagonal(spacing);
            if with_sform {
                file.set_sform(2, linear, offset);
            } else {
                let handedness = directions.determinant();
                let rotation = directions * DMat3::from_diagonal(DVec3::new(1.0, 1.0, handedness));
                file.set_qform(1, DQuat::from_mat3(&rotation), offset, handedness);
            }
            // A sample tells its own place: x + 100 y + 10000 z of world, in quarters.
            let mut data = Vec::new();
            for z in 0..dims[2] {
                for y in 0..dims[1] {
                    for x in 0..dims[0] {
                        let world = linear * DVec3::new(x as f64, y as f64, z as f64) + offset;
                        let marker = world.dot(DVec3::new(1.0, 100.0, 10000.0)) as f32;
                        data.extend(marker.to_le_bytes());
                    }
                }
            }
            let loaded = read(&file.bytes(&data)).unwrap();
            let map = loaded.volume.grid().world_from_voxel();
            for index in 0..loaded.volume.samples().len() {
                let voxel = [index % 3, index / 3 % 4, index / 12].map(|i| i as f64);
                let world = map.transform_point3(DVec3::from_array(voxel));
                let marker = world.dot(DVec3::new(1.0, 100.0, 10000.0));
                assert!(
                    (marker - loaded.volume.value(index)).abs() < 0.05,
                    "{directions:?} {with_sform}"
                );
            }
            seen.insert(axis_codes(loaded.volume.grid()));
        }
    }
    assert_eq!(seen.len(), 48);
}

#[test]
fn both_versions_in_both_byte_orders_are_the_same_volume() {
    let values: Vec<i16> = (0..24).map(|i| i * 1000 - 12000).collect();
    for (wide, big, zipped) in [
        (false, false, false),
        (false, true, true),
        (true, false, true),
        (true, true, false),
    ] {
        let mut file = NiftiFile::new(&[2, 3, 4], 4);
        (file.wide, file.big) = (wide, big);
        file.scl_slope = 0.5;
        file.scl_inter = -7.0;
        file.pixdim = [1.0, 1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0];
        file.xyzt_units = 3;
        file.qform_code = 1;
        let data: Vec<u8> = values
            .iter()
            .flat_map(|v| if big { v.to_be_bytes() } else { v.to_le_bytes() })
            .collect();
        let bytes = file.bytes(&data);
        let folder = tempfile::tempdir().unwrap();
        let loaded = if zipped {
            read_bytes(folder.path(), "a.nii.gz", &gzip(&bytes)).unwrap()
        } else {
            read_bytes(folder.path(), "a.nii", &bytes).unwrap()
        };
        assert_eq!(*loaded.volume.samples(), Samples::I16(values.clone().into()));
        assert_eq!(
            loaded.volume.rescale(),
            Rescale {
                slope: 0.5,
                intercept: -7.0
            }
        );
        assert_eq!(loaded.volume.grid().spacing(), DVec3::new(1.0, 2.0, 3.0));
        assert_eq!(loaded.volume.unit(), LengthUnit::Micrometre);
        assert_eq!(loaded.description.warnings, Vec::<String>::new());
        assert_eq!(
            loaded.description.format,
            if wide { "NIfTI-2" } else { "NIfTI-1" }
        );
        let order = if big { "big" } else { "little" };
        let coding = if zipped { "gzip" } else { "raw" };
        assert_eq!(
            loaded.description.stored_type,
            format!("i16, {order}-endian, {coding}")
        );
    }
}

#[test]
fn a_pair_is_found_from_either_half() {
    let folder = tempfile::tempdir().unwrap();
    for (wide, zipped) in [(false, false), (true, true)] {
        let mut file = NiftiFile::new(&[2, 3], 2);
        (file.wide, file.single) = (wide, false);
        let (header, data) = (file.bytes(&[]), [1, 2, 3, 4, 5, 6]);
        let names = if zipped {
            ["b.hdr.gz", "b.img.gz"]
        } else {
            ["a.hdr", "a.img"]
        };
        for (name, bytes) in names.iter().zip([&header[..], &data]) {
            let bytes = if zipped { gzip(bytes) } else { bytes.to_vec() };
            std::fs::write(folder.path().join(name), bytes).unwrap();
        }
        let loaded = load(&folder.path().join(names[0]));
        assert_eq!(*loaded.volume.samples(), Samples::U8(data.to_vec().into()));
        assert_eq!(
            loaded.description.files,
            names.map(|name| folder.path().join(name))
        );
    }
    assert_eq!(load(&folder.path().join("a.img")).volume.grid().dims(), [2, 3, 1]);
    std::fs::remove_file(folder.path().join("a.img")).unwrap();
    let gone = read_volume(folder.path().join("a.hdr"), &ReadOptions::default());
    assert!(matches!(gone, Err(IoError::MissingDataFile { .. })));
}

fn with(bytes: &[u8], options: &ReadOptions) -> Result<Loaded, IoError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.nii");
    std::fs::write(&path, bytes).unwrap();
    read_volume(path, options)
}

fn warns_of_time(loaded: &Loaded) -> bool {
    let mut warnings = loaded.description.warnings.iter();
    warnings.any(|warning| warning == "time point 0 of 3 is read")
}

#[test]
fn series_vectors_colours_and_complex_numbers_are_chosen_from() {
    let time = |time| ReadOptions {
        time: Some(time),
        ..ReadOptions::default()
    };
    let component = |n| ReadOptions {
        component: Some(n),
        ..ReadOptions::default()
    };
    let data: Vec<u8> = (0..48).collect();
    let series = NiftiFile::new(&[2, 2, 2, 3], 2).bytes(&data[..24]);
    for n in 0..3 {
        let loaded = with(&series, &time(n)).unwrap();
        assert_eq!(
            *loaded.volume.samples(),
            Samples::U8(data[8 * n..8 * n + 8].to_vec().into())
        );
        assert!(!warns_of_time(&loaded), "{:?}", loaded.description.warnings);
    }
    assert!(warns_of_time(&with(&series, &ReadOptions::default()).unwrap()));
    assert!(with(&series, &time(3)).is_err());
    // Two time points of vectors of three components, one component after the other.
    let vectors = NiftiFile::new(&[2, 2, 2, 2, 3], 2).bytes(&data);
    let second = ReadOptions {
        time: Some(1),
        component: Some(2),
        ..ReadOptions::default()
    };
    assert_eq!(
        *with(&vectors, &second).unwrap().volume.samples(),
        Samples::U8(data[40..48].to_vec().into())
    );
    assert!(
        with(&vectors, &time(0))
            .unwrap_err()
            .to_string()
            .contains("vectors")
    );
    let colours = NiftiFile::new(&[2, 2], 128).bytes(&data[..12]);
    assert!(
        with(&colours, &time(0))
            .unwrap_err()
            .to_string()
            .contains("colours")
    );
    assert_eq!(
        *with(&colours, &component(1)).unwrap().volume.samples(),
        Samples::U8(vec![1, 4, 7, 10].into())
    );
    let floats: Vec<u8> = [1.0f32, 2.0, 3.0, 4.0]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let complex = NiftiFile::new(&[2], 32).bytes(&floats);
    assert!(
        with(&complex, &time(0))
            .unwrap_err()
            .to_string()
            .contains("complex")
    );
    assert_eq!(
        *with(&complex, &component(1)).unwrap().volume.samples(),
        Samples::F32(vec![2.0, 4.0].into())
    );
}

fn edited(edit: impl FnOnce(&mut NiftiFile)) -> Result<Loaded, IoError> {
    let mut file = NiftiFile::new(&[2, 3, 4], 2);
    edit(&mut file);
    read(&file.bytes(&[7; 24]))
}

#[test]
fn oddities_are_listed() {
    type Edit = fn(&mut NiftiFile);
    let cases: [(Edit, &str); 8] = [
        (|_| {}, "which side is left"),
        (|file| file.bitpix = 16, "bitpix"),
        (|file| file.pixdim[2] = -2.0, "pixdim[2]"),
        (|file| file.pixdim[2] = 0.0, "pixdim[2]"),
        (|file| file.xyzt_units = 5, "xyzt_units"),
        (|file| file.extension = vec![1, 0, 0, 0], "extension"),
        (|file| file.scl_slope = f64::NAN, "scl_slope"),
        (
            |file| {
                file.set_sform(1, DMat3::IDENTITY, DVec3::ZERO);
                file.set_qform(1, DQuat::IDENTITY, DVec3::X, 1.0);
            },
            "sform and qform differ by up to 1.000",
        ),
    ];
    for (edit, part) in cases {
        let warnings = edited(edit).unwrap().description.warnings;
        assert!(
            warnings.iter().any(|warning| warning.contains(part)),
            "{part}: {warnings:?}"
        );
    }
    // A valid extension gives no warning; neither do both forms if they agree.
    let loaded = edited(|file| {
        file.extension = [&[1, 0, 0, 0, 16, 0, 0, 0, 6, 0, 0, 0][..], &[9; 8]].concat();
        file.set_sform(1, DMat3::IDENTITY, DVec3::ONE);
        file.set_qform(1, DQuat::IDENTITY, DVec3::ONE, 1.0);
    });
    assert_eq!(loaded.unwrap().description.warnings, Vec::<String>::new());
}

#[test]
fn pairs_of_analyze_are_read_with_their_spacing_and_scale() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = NiftiFile::new(&[3, 2, 1], 4);
    file.single = false;
    file.pixdim = [0.0, 2.0, 3.0, 4.0, 0.0, 0.0, 0.0, 0.0];
    file.scl_slope = 0.5;
    // What Analyze has here is a history.
    file.qform_code = 7;
    file.sform_code = -9;
    let mut header = file.bytes(&[])[..348].to_vec();
    header[344..348].fill(0);
    std::fs::write(folder.path().join("a.img"), [1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0]).unwrap();
    let loaded = read_bytes(folder.path(), "a.hdr", &header).unwrap();
    assert_eq!(loaded.description.format, "Analyze 7.5");
    assert_eq!(loaded.volume.grid().dims(), [3, 2, 1]);
    assert_eq!(loaded.volume.value_range(), [0.5, 3.0]);
    assert_eq!(loaded.volume.grid().world_from_voxel().matrix3.y_axis.y, 3.0);
    assert!(!loaded.description.oriented);
    assert!(
        loaded.description.warnings[0].contains("which side is left"),
        "{:?}",
        loaded.description
    );
}
