//! Headerless raw: real files, layouts given and guessed, sizes that do not match.

use std::path::Path;

use crate::common::{Expected, assert_expected, gzip, load, read_bytes, shared_volumes, truncations};
use glam::DVec3;
use sha2::{Digest, Sha256};
use splatvol_io::{Endian, IoError, Loaded, RawLayout, ReadOptions, SampleType, read_volume};
use splatvol_scene::Samples;

const LAYOUT: RawLayout = RawLayout {
    dims: [4, 3, 2],
    sample_type: SampleType::I16,
    spacing: DVec3::new(1.0, 2.0, 3.0),
    endian: Endian::Big,
    offset: 5,
};

fn with_layout(path: &Path, layout: RawLayout) -> Result<Loaded, IoError> {
    let options = ReadOptions {
        raw: Some(layout),
        ..ReadOptions::default()
    };
    read_volume(path, &options)
}

fn file(offset: usize) -> (Vec<u8>, Samples) {
    let values: Vec<i16> = (0..24).map(|i| i * 1000 - 12000).collect();
    let samples = values.iter().flat_map(|value| value.to_be_bytes());
    let bytes = std::iter::repeat_n(0xab, offset).chain(samples).collect();
    (bytes, Samples::I16(values.into()))
}

#[test]
fn real_files_are_read_by_their_names() {
    let Some(folder) = shared_volumes() else { return };
    let expected = |dims, values| Expected {
        dims,
        spacing: [1.0; 3],
        values,
        sample_type: "u8",
    };
    let neghip = load(&folder.join("neghip_64x64x64_uint8.raw"));
    assert_expected("neghip", &neghip, &expected([64; 3], [0.0, 255.0, 18.4028]));
    let Samples::U8(bytes) = neghip.volume.samples() else {
        panic!("not u8")
    };
    let sum: String = Sha256::digest(bytes)
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    assert_eq!(
        sum,
        "72cfeacbc7e5d6612198a169a3f2d6df09d78f67506ffa83b0f34498d9d85872"
    );
    let tooth = load(&folder.join("tooth_103x94x161_uint8.raw"));
    assert_expected("tooth", &tooth, &expected([103, 94, 161], [0.0, 255.0, 103.165]));
    assert_eq!(
        tooth.description.warnings,
        ["dims and type are taken from the file name: 103x94x161 u8"]
    );
    let nrrd = load(&folder.join("tooth.nrrd"));
    assert_eq!(tooth.volume.samples(), nrrd.volume.samples());
}

#[test]
fn a_given_layout_is_followed() {
    let folder = tempfile::tempdir().unwrap();
    let (bytes, samples) = file(5);
    let path = folder.path().join("a.dat");
    std::fs::write(&path, &bytes).unwrap();
    let loaded = with_layout(&path, LAYOUT).unwrap();
    assert_eq!(loaded.volume.samples(), &samples);
    assert_eq!(loaded.volume.grid().dims(), [4, 3, 2]);
    assert_eq!(loaded.volume.grid().spacing(), DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(loaded.description.stored_type, "i16, big-endian");
    assert!(loaded.description.warnings.is_empty());
    let path = folder.path().join("a.raw.gz");
    std::fs::write(&path, gzip(&bytes)).unwrap();
    assert_eq!(with_layout(&path, LAYOUT).unwrap().volume.samples(), &samples);
}

#[test]
fn names_give_dims_and_type() {
    let folder = tempfile::tempdir().unwrap();
    let read = |name: &str, bytes: &[u8]| {
        read_bytes(folder.path(), name, bytes)
            .map(|loaded| (loaded.volume.grid().dims(), loaded.volume.samples().clone()))
    };
    let bytes = [1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0];
    let expected = ([3, 2, 1], Samples::U16(vec![1, 2, 3, 4, 5, 6].into()));
    for name in [
        "a_3x2x1_uint16.raw",
        "a-b-3X2X1-UShort.raw",
        "3x2x1.u16.raw",
        "x_1x2_3x2x1_v2_uint16.raw",
    ] {
        assert_eq!(read(name, &bytes).unwrap(), expected, "{name}");
    }
    assert_eq!(read("a_3x2x1_uint16.raw.gz", &gzip(&bytes)).unwrap(), expected);
    for name in [
        "a.raw",
        "a_3x2x1.raw",
        "a_3x2_uint16.raw",
        "uint16_3x2x1.raw",
        "a_3x2x1x1_uint16.raw",
    ] {
        let text = read(name, &bytes).unwrap_err().to_string();
        assert!(text.contains("layout"), "{name}: {text}");
    }
}

#[test]
fn a_wrong_size_names_the_layouts_that_fit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.raw");
    let cases = [
        (4 * 3 * 2, SampleType::U16, "fit 4x3x2 u8 or 4x3x1 u16"),
        (4 * 3 * 7, SampleType::U8, "fit 4x3x7 u8"),
        (4 * 3 * 2 * 4, SampleType::U8, "fit 4x3x2 f32 or 4x3x8 u8"),
        (27 * 2, SampleType::U8, "3x3x3 u16"),
        (
            4 * 3 * 2 + 352,
            SampleType::U8,
            "4x3x2 u8 after a header of 352 bytes",
        ),
        (1, SampleType::U8, "expected 24, for 4x3x2 u8"),
        (0, SampleType::U8, "expected 24, for 4x3x2 u8"),
    ];
    for (size, sample_type, hint) in cases {
        std::fs::write(&path, vec![1; size]).unwrap();
        let layout = RawLayout {
            sample_type,
            offset: 0,
            ..LAYOUT
        };
        let text = with_layout(&path, layout).unwrap_err().to_string();
        assert!(text.contains(hint), "{text}");
    }
    for (size, hint) in [(28, "decompressed size"), (20, "samples need")] {
        let gz = folder.path().join("a.raw.gz");
        std::fs::write(&gz, gzip(&vec![1; size])).unwrap();
        let layout = RawLayout {
            sample_type: SampleType::U8,
            offset: 0,
            ..LAYOUT
        };
        let text = with_layout(&gz, layout).unwrap_err().to_string();
        assert!(text.contains(hint), "{text}");
    }
}

#[test]
fn absurd_layouts_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (bytes, _) = file(5);
    let path = folder.path().join("a.raw");
    std::fs::write(&path, &bytes).unwrap();
    let layouts = [
        RawLayout {
            dims: [0, 3, 2],
            ..LAYOUT
        },
        RawLayout {
            dims: [usize::MAX; 3],
            ..LAYOUT
        },
        RawLayout {
            dims: [65_535; 3],
            ..LAYOUT
        },
        RawLayout {
            spacing: DVec3::new(1.0, f64::NAN, 1.0),
            ..LAYOUT
        },
        RawLayout {
            spacing: DVec3::new(1.0, 0.0, 1.0),
            ..LAYOUT
        },
        RawLayout {
            spacing: DVec3::new(1.0, 1e40, 1.0),
            ..LAYOUT
        },
        RawLayout {
            offset: u64::MAX,
            ..LAYOUT
        },
        RawLayout { offset: 6, ..LAYOUT },
    ];
    for layout in layouts {
        assert!(with_layout(&path, layout.clone()).is_err(), "{layout:?}");
    }
    assert!(with_layout(folder.path(), LAYOUT).is_err());
    assert!(with_layout(&folder.path().join("absent.raw"), LAYOUT).is_err());
}

#[test]
fn truncated_files_are_refused() {
    let bytes: Vec<u8> = (0..=255).cycle().take(512).collect();
    truncations("a_8x8x8_uint8.raw", &bytes, 16);
    truncations("a_8x8x8_uint8.raw.gz", &gzip(&bytes), 512);
}
