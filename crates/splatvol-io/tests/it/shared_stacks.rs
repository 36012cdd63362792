//! TIFF, OME-Zarr, MGH and SLC: the shared data against what tifffile, zarr-python, nibabel and VTK read from
//! them.

use crate::common::{Expected, assert_expected, load, shared_volumes, small_volumes};
use splatvol_io::{ReadOptions, axis_codes, read_volume};
use splatvol_scene::Samples;

#[test]
fn shared_files_agree_with_other_readers() {
    let Some(folder) = shared_volumes() else {
        return;
    };
    for (name, dims, values, sample_type) in [
        ("100_fiberform.tif", [100, 100, 100], [0.0, 255.0, 64.4498], "u8"),
        (
            "mouse_brain_tiff",
            [271, 193, 220],
            [2.0, 11195.0, 82.1532],
            "u16",
        ),
        (
            "ome_zarr_v2_blosc_lz4.zarr",
            [100, 100, 2],
            [0.114586, 999.983, 501.247],
            "f64",
        ),
        (
            "ome_zarr_v2_blosc_lz4.zarr/0",
            [100, 100, 2],
            [0.114586, 999.983, 501.247],
            "f64",
        ),
        ("wm.mgz", [256, 256, 256], [0.0, 250.0, 4.7138], "u8"),
        ("neghip.slc", [66, 66, 66], [0.0, 255.0, 16.78], "u8"),
    ] {
        let loaded = load(&folder.join(name));
        let expected = Expected {
            dims,
            spacing: [1.0; 3],
            values,
            sample_type,
        };
        assert_expected(name, &loaded, &expected);
        println!(
            "{name}: {}, {}, {:?}, {}",
            loaded.description.format,
            loaded.description.stored_type,
            loaded.description.warnings,
            loaded.volume.unit().symbol()
        );
    }
    let codes = axis_codes(load(&folder.join("wm.mgz")).volume.grid());
    assert_eq!(codes, "LIA");
    assert_eq!(
        load(&folder.join("mouse_brain_tiff")).description.files.len(),
        220
    );
}

#[test]
fn the_inside_of_neghip_slc_is_the_raw_file() {
    let Some(folder) = shared_volumes() else {
        return;
    };
    let (slc, raw) = (
        load(&folder.join("neghip.slc")),
        load(&folder.join("neghip_64x64x64_uint8.raw")),
    );
    let (Samples::U8(slc), Samples::U8(raw)) = (slc.volume.samples(), raw.volume.samples()) else {
        panic!("both are bytes");
    };
    for (i, &sample) in raw.iter().enumerate() {
        let [x, y, z] = [i % 64, i / 64 % 64, i / 4096];
        assert_eq!(slc[x + 1 + 66 * (y + 1 + 66 * (z + 1))], sample, "{x} {y} {z}");
    }
}

#[test]
fn what_is_not_there_is_said() {
    let Some(folder) = shared_volumes() else {
        return;
    };
    let level = ReadOptions {
        level: 1,
        ..ReadOptions::default()
    };
    let error = read_volume(folder.join("ome_zarr_v2_blosc_lz4.zarr"), &level).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("level 1 was asked for; to choose from: 0: 100 x 100 x 2"),
        "{error}"
    );
    let time = ReadOptions {
        time: Some(1),
        ..ReadOptions::default()
    };
    assert!(read_volume(folder.join("wm.mgz"), &time).is_err());
    let series = ReadOptions {
        series: Some("7".to_owned()),
        ..ReadOptions::default()
    };
    let error = read_volume(folder.join("dicom_mr_oblique"), &series).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("series \"7\" was asked for; to choose from"),
        "{error}"
    );
}

#[test]
fn only_files_with_directions_say_how_a_volume_lies() {
    let Some(folder) = shared_volumes() else {
        return;
    };
    for (name, oriented) in [
        ("FLAIR.nii.gz", true),
        ("zstat1.nii.gz", true),
        ("FLAIR.nrrd", true),
        ("LIDC2.mha", true),
        ("wm.mgz", true),
        ("dicom_mr_oblique", true),
        ("headsq/quarter.nhdr", false),
        ("HeadMRVolume.mhd", false),
        ("hydrogen.vti", false),
        ("ironProt.vtk", false),
        ("stent.npz", false),
        ("neghip.slc", false),
        ("100_fiberform.tif", false),
        ("ome_zarr_v2_blosc_lz4.zarr", false),
    ] {
        let description = load(&folder.join(name)).description;
        assert_eq!(
            description.oriented, oriented,
            "{name}: {}",
            description.orientation
        );
    }
}

#[test]
fn generated_files_say_how_a_volume_lies_if_they_have_directions() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in small_volumes::files() {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let directed = ["dcm", "nrrd", "mha", "mgh", "mgz", "nii", "gz"];
        let expected = directed.iter().any(|end| name.ends_with(end));
        let description = load(&path).description;
        let found = description.oriented;
        assert_eq!(found, expected, "{name}: {}", description.orientation);
    }
}
