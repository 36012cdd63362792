//! DICOM: the series of the shared data against what pydicom reads from them.

mod coded;
mod colors;
mod large;
mod run_length;
mod uneven;

use std::io::Write;
use std::path::Path;

use crate::common::dicom_file::{BIG, DicomFile, EXPLICIT, IMPLICIT, element, items};
use crate::common::slices::assert_opens;
use crate::common::{self, Expected, assert_expected, load, shared_volumes};
use glam::DVec3;
use splatvol_io::{IoError, Loaded, ReadOptions, read_volume};
use splatvol_scene::{LengthUnit, Samples};

#[test]
fn shared_series_agree_with_pydicom() {
    let Some(folder) = shared_volumes() else { return };
    for (name, dims, spacing, values, sample_type) in [
        (
            "dicom_ct_phantom",
            [512, 512, 28],
            [0.451172, 0.451172, 5.0],
            [-1024.0, 782.0, -830.606],
            "u16",
        ),
        (
            "dicom_mr_oblique",
            [256, 256, 20],
            [0.859375, 0.859375, 7.000524],
            [0.0, 1059.0, 167.537],
            "i16",
        ),
    ] {
        let loaded = load(&folder.join(name));
        assert_opens(&folder.join(name), &ReadOptions::default(), &loaded);
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
    }
}

#[test]
fn all_codings_give_the_same_pixels() {
    let Some(folder) = shared_volumes() else { return };
    let folder = folder.join("dicom_transfer_syntaxes");
    let mut first = None;
    for (name, mean) in [
        ("anatomical", 127.017),
        ("anatomical_implicit", 127.079),
        ("compressed_rle", 127.047),
        ("compressed_jpeg", 127.047),
        ("compressed_jpegls", 127.047),
        ("compressed_j2k", 127.047),
    ] {
        let loaded = load(&folder.join(name));
        assert_opens(&folder.join(name), &ReadOptions::default(), &loaded);
        assert_expected(
            name,
            &loaded,
            &Expected {
                dims: [256, 256, 4],
                spacing: [1.0; 3],
                values: [0.0, 254.0, mean],
                sample_type: "u16",
            },
        );
        if name.starts_with("compressed") {
            let samples = loaded.volume.samples().clone();
            assert!(first.get_or_insert(samples.clone()) == &samples, "{name}");
        }
    }
}

const SAMPLES: [u16; 6] = [0, 1, 2, 3, 4, 0xf005];

/// Slices at these heights, numbered in this order, each with its number in every sample but the last.
fn series(folder: &Path, syntax: &'static str, heights: &[f64]) -> Vec<DicomFile> {
    let slice = |(i, &height): (usize, &f64)| {
        let file = DicomFile::slice(syntax, [10.0, 20.0, height], i as i32, &[i as u16; 6]);
        std::fs::write(folder.join(format!("s{i}")), file.bytes()).unwrap();
        file
    };
    heights.iter().enumerate().map(slice).collect()
}

fn read_in(folder: &Path, change: impl Fn(&mut ReadOptions)) -> Result<Loaded, IoError> {
    let mut options = ReadOptions::default();
    change(&mut options);
    let loaded = read_volume(folder, &options)?;
    assert_opens(folder, &options, &loaded);
    Ok(loaded)
}

fn one(file: &DicomFile) -> Result<Loaded, IoError> {
    one_with(file, &ReadOptions::default())
}

fn one_with(file: &DicomFile, options: &ReadOptions) -> Result<Loaded, IoError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("one.dcm");
    std::fs::write(&path, file.bytes()).unwrap();
    let loaded = read_volume(&path, options)?;
    assert_opens(&path, options, &loaded);
    Ok(loaded)
}

#[test]
fn slices_are_sorted_by_position_and_placed_in_ras() {
    for syntax in [EXPLICIT, IMPLICIT, BIG] {
        let folder = tempfile::tempdir().unwrap();
        series(folder.path(), syntax, &[4.0, 0.0, 2.0]);
        let loaded = load(folder.path());
        let volume = &loaded.volume;
        assert_eq!(volume.grid().dims(), [3, 2, 3]);
        assert_eq!(volume.unit(), LengthUnit::Millimetre);
        let Samples::U16(samples) = volume.samples() else {
            panic!("words")
        };
        assert_eq!([samples[0], samples[6], samples[12]], [1, 2, 0], "{syntax}");
        // LPS (10, 20, 0) is RAS (-10, -20, 0); spacing is 0.25 along x and 0.5 along y.
        let map = volume.grid().world_from_voxel();
        assert_eq!(map.transform_point3(DVec3::ZERO), DVec3::new(-10.0, -20.0, 0.0));
        assert_eq!(map.transform_point3(DVec3::ONE), DVec3::new(-10.25, -20.5, 2.0));
        assert!(
            loaded.description.warnings.is_empty(),
            "{:?}",
            loaded.description.warnings
        );
    }
}

#[test]
fn samples_are_masked_sign_extended_and_turned_round() {
    let mut file = DicomFile::slice(EXPLICIT, [0.0; 3], 1, &SAMPLES);
    // Overlay bits above the stored ones do not count.
    assert_eq!(
        one(&file).unwrap().volume.samples(),
        &Samples::U16(vec![0, 1, 2, 3, 4, 5].into())
    );
    file.text(0x0028_0004, b"CS", "MONOCHROME1");
    let inverted = one(&file).unwrap();
    assert_eq!(
        inverted.volume.samples(),
        &Samples::U16(vec![4095, 4094, 4093, 4092, 4091, 4090].into())
    );
    assert!(
        inverted
            .description
            .warnings
            .iter()
            .any(|text| text.contains("MONOCHROME1"))
    );
    file.text(0x0028_0004, b"CS", "MONOCHROME2");
    file.short(0x0028_0103, 1);
    file.pixels(&[0, 1, 0x7ff, 0x800, 0xfff, 5]);
    file.text(0x0028_1053, b"DS", "2");
    file.text(0x0028_1052, b"DS", "-1024");
    let signed = one(&file).unwrap().volume;
    assert_eq!(
        signed.samples(),
        &Samples::I16(vec![0, 1, 2047, -2048, -1, 5].into())
    );
    assert_eq!(
        (signed.statistics().min, signed.statistics().max),
        (-5120.0, 3070.0)
    );
}

#[test]
fn deflated_and_encapsulated_files_are_those_in_plain() {
    let mut file = DicomFile::slice("1.2.840.10008.1.2.1.99", [0.0; 3], 1, &SAMPLES);
    let plain = one(&DicomFile::slice(EXPLICIT, [0.0; 3], 1, &SAMPLES)).unwrap();
    let mut encoder = flate2::write::DeflateEncoder::new(Vec::new(), flate2::Compression::best());
    encoder.write_all(&file.dataset()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deflated.dcm");
    std::fs::write(&path, file.with_body(&encoder.finish().unwrap())).unwrap();
    assert_eq!(load(&path).volume.samples(), plain.volume.samples());
    file.syntax = "1.2.840.10008.1.2.4.110";
    let error = one(&file).unwrap_err().to_string();
    assert!(
        error.contains("JPEG XL, transfer syntax 1.2.840.10008.1.2.4.110"),
        "{error}"
    );
}

#[test]
fn the_largest_series_is_read_and_others_by_name() {
    let folder = tempfile::tempdir().unwrap();
    series(folder.path(), EXPLICIT, &[0.0, 1.0, 2.0]);
    for height in [0.0, 3.0] {
        let mut other = DicomFile::slice(EXPLICIT, [0.0, 0.0, height], 1, &[9; 6]);
        other.text(0x0020_000e, b"UI", "1.2.4");
        other.text(0x0020_0011, b"IS", "8");
        other.text(0x0008_103e, b"LO", "other");
        std::fs::write(folder.path().join(format!("o{height}")), other.bytes()).unwrap();
    }
    std::fs::write(folder.path().join("README.txt"), "no image").unwrap();
    let largest = read_in(folder.path(), |_| ()).unwrap();
    assert_eq!(largest.volume.grid().dims()[2], 3);
    assert!(largest.description.warnings[0].contains("8: other, 2 slices of 3 x 2, 1.2.4"));
    assert_eq!(largest.description.series.len(), 2);
    for name in ["8", "1.2.4", "other"] {
        let other = read_in(folder.path(), |options| options.series = Some(name.to_owned())).unwrap();
        assert_eq!(other.volume.grid().spacing().z, 3.0, "{name}");
        assert!(other.description.warnings.is_empty());
    }
    let error = read_in(folder.path(), |options| options.series = Some("9".to_owned())).unwrap_err();
    assert!(error.to_string().contains("7: test, 3 slices"), "{error}");
}

#[test]
fn missing_and_doubled_slices_are_told_and_times_chosen() {
    let folder = tempfile::tempdir().unwrap();
    series(folder.path(), EXPLICIT, &[0.0, 1.0, 2.0, 4.0, 5.0]);
    let uneven = load(folder.path());
    assert_eq!(uneven.volume.grid().dims(), [3, 2, 6]);
    let warning = &uneven.description.warnings[0];
    assert!(
        warning.contains("steps of 1.0000, 2.0000")
            && warning.contains("5 are resampled to 6 that lie 1.0000"),
        "{warning}"
    );
    let strict = read_in(folder.path(), |options| options.strict = true).unwrap_err();
    assert!(strict.to_string().contains("not evenly spaced"), "{strict}");
    let folder = tempfile::tempdir().unwrap();
    series(folder.path(), EXPLICIT, &[0.0, 1.0, 1.0]);
    let doubled = load(folder.path());
    assert!(doubled.description.warnings[0].starts_with("1 slices lie where another one lies"));
    let folder = tempfile::tempdir().unwrap();
    series(folder.path(), EXPLICIT, &[0.0, 1.0, 0.0, 1.0]);
    let second = read_in(folder.path(), |options| options.time = Some(1)).unwrap();
    assert_eq!(second.description.times, 2);
    let Samples::U16(samples) = second.volume.samples() else {
        panic!("words")
    };
    assert_eq!([samples[0], samples[6]], [2, 3]);
    assert!(read_in(folder.path(), |options| options.time = Some(2)).is_err());
}

#[test]
fn slices_with_scales_of_their_own_become_real_values() {
    let folder = tempfile::tempdir().unwrap();
    for (i, slope) in ["2", "0.5"].into_iter().enumerate() {
        let mut file = DicomFile::slice(EXPLICIT, [0.0, 0.0, i as f64], 1, &[4; 6]);
        file.text(0x0028_1053, b"DS", slope);
        std::fs::write(folder.path().join(i.to_string()), file.bytes()).unwrap();
    }
    let Samples::F32(samples) = load(folder.path()).volume.samples().clone() else {
        panic!("floats")
    };
    assert_eq!([samples[0], samples[6]], [8.0, 2.0]);
}

#[test]
fn frames_of_an_enhanced_image_lie_where_their_groups_say() {
    let mut file = DicomFile::slice(EXPLICIT, [0.0; 3], 1, &SAMPLES);
    file.text(0x0028_0008, b"IS", "3");
    file.pixels(&(0..18).collect::<Vec<u16>>());
    let group = |tag, elements: Vec<u8>| element(EXPLICIT, tag, b"SQ", &items(&[elements]));
    let text = |tag, value: &str| element(EXPLICIT, tag, b"DS", value.as_bytes());
    let frame = |height: &str| group(0x0020_9113, text(0x0020_0032, &format!("1\\2\\{height} ")));
    let shared = [
        group(0x0020_9116, text(0x0020_0037, "0\\1\\0\\0\\0\\1 ")),
        group(0x0028_9110, text(0x0028_0030, "3\\2 ")),
        group(
            0x0028_9145,
            [text(0x0028_1052, "-1"), text(0x0028_1053, "10")].concat(),
        ),
    ];
    file.set(0x5200_9229, b"SQ", items(&[shared.concat()]));
    // X = (0, 1, 0), Y = (0, 0, 1): the normal is (1, 0, 0), so heights are given by x.
    let frames: Vec<Vec<u8>> = ["5", "1", "3"]
        .into_iter()
        .map(|x| group(0x0020_9113, text(0x0020_0032, &format!("{x}\\2\\0 "))))
        .collect();
    file.set(0x5200_9230, b"SQ", items(&frames));
    let loaded = one(&file).unwrap();
    let volume = &loaded.volume;
    assert_eq!(volume.grid().dims(), [3, 2, 3]);
    let Samples::U16(samples) = volume.samples() else {
        panic!("words")
    };
    assert_eq!([samples[0], samples[6], samples[12]], [6, 12, 0]);
    let map = volume.grid().world_from_voxel();
    assert_eq!(map.transform_point3(DVec3::ZERO), DVec3::new(-1.0, -2.0, 0.0));
    assert_eq!(map.transform_point3(DVec3::ONE), DVec3::new(-3.0, -4.0, 3.0));
    assert_eq!(volume.statistics().max, 169.0);
    // Frames without places of their own lie in one place: three time points.
    file.set(0x5200_9230, b"SQ", items(&[frame("0"), frame("0"), frame("0")]));
    assert_eq!(one(&file).unwrap().description.times, 3);
}

#[test]
fn elements_without_the_representations_they_promise_are_read_with_a_warning() {
    let silent = DicomFile::slice(IMPLICIT, [0.0; 3], 1, &SAMPLES).dataset();
    let promised = DicomFile::slice(EXPLICIT, [0.0; 3], 1, &SAMPLES);
    let folder = tempfile::tempdir().unwrap();
    let loaded = common::read_bytes(folder.path(), "silent.dcm", &promised.with_body(&silent)).unwrap();
    assert_eq!(loaded.volume.samples(), one(&promised).unwrap().volume.samples());
    let warned = |loaded: &Loaded| {
        loaded
            .description
            .warnings
            .iter()
            .any(|w| w.contains("transfer syntax"))
    };
    assert!(warned(&loaded) && !warned(&one(&promised).unwrap()));
}

#[test]
fn cut_and_changed_files_are_refused() {
    let bytes = DicomFile::slice(EXPLICIT, [0.0; 3], 1, &SAMPLES).bytes();
    common::truncations("cut.dcm", &bytes, bytes.len());
    common::flips("changed.dcm", &bytes[..], bytes.len());
    // Every element that promises 4 GB.
    let folder = tempfile::tempdir().unwrap();
    for at in 132..bytes.len() - 4 {
        let mut changed = bytes.clone();
        changed[at..at + 4].copy_from_slice(&0xffff_fff0u32.to_le_bytes());
        let _ = common::read_bytes(folder.path(), "huge.dcm", &changed);
    }
}
