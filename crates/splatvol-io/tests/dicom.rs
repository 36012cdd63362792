//! DICOM: the series of the shared data against what pydicom reads of them.
#![allow(clippy::unwrap_used, reason = "panics are how tests fail")]

mod common;

use common::{Expected, assert_expected, load, shared_volumes};

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
