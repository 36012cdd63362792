//! Colours, palettes, bits and look-up tables of DICOM.

use splatvol_io::ReadOptions;
use splatvol_scene::Samples;

use super::{one, one_with};
use crate::common::dicom_file::{BIG, DicomFile, EXPLICIT, element, items};

/// Red, green and blue of 3 x 2 pixels.
const RGB: [[u8; 3]; 6] = [
    [255, 0, 0],
    [0, 255, 0],
    [0, 0, 255],
    [10, 20, 30],
    [100, 100, 100],
    [255, 255, 255],
];

fn colored(photometric: &str, bytes: Vec<u8>) -> DicomFile {
    let mut file = DicomFile::slice(EXPLICIT, [0.0; 3], 1, &[0; 6]);
    file.text(0x0028_0004, b"CS", photometric);
    for (tag, value) in [
        (0x0028_0002, 3),
        (0x0028_0100, 8),
        (0x0028_0101, 8),
        (0x0028_0102, 7),
    ] {
        file.short(tag, value);
    }
    file.set(0x7fe0_0010, b"OB", bytes);
    file
}

fn channel(file: &DicomFile, channel: usize) -> Vec<u8> {
    let options = ReadOptions {
        channel: Some(channel),
        ..ReadOptions::default()
    };
    let loaded = one_with(file, &options).unwrap();
    assert!(loaded.description.warnings.iter().all(|w| !w.contains("channel")));
    match loaded.volume.samples() {
        Samples::U8(samples) => samples.to_vec(),
        other => panic!("{}", other.type_name()),
    }
}

fn of_rgb(channel: usize) -> Vec<u8> {
    RGB.iter().map(|pixel| pixel[channel]).collect()
}

#[test]
fn pixels_and_planes_of_colours_are_channels_to_choose_from() {
    let mixed = colored("RGB", RGB.concat());
    let mut planes = colored("RGB", [0, 1, 2].map(of_rgb).concat());
    planes.short(0x0028_0006, 1);
    for file in [mixed, planes] {
        for index in 0..3 {
            assert_eq!(channel(&file, index), of_rgb(index));
        }
        let loaded = one(&file).unwrap();
        assert_eq!(loaded.description.channels, ["red", "green", "blue"]);
        assert!(
            loaded
                .description
                .warnings
                .iter()
                .any(|w| w.starts_with("channel 0 is read"))
        );
    }
    let error = one(&colored("HSV", RGB.concat())).unwrap_err().to_string();
    assert!(error.contains("3 samples as HSV"), "{error}");
}

#[test]
fn bytes_that_are_written_as_big_endian_words_are_turned_back() {
    let mut file = colored("RGB", RGB.concat());
    file.syntax = BIG;
    for (tag, value) in [
        (0x0028_0002, 3),
        (0x0028_0010, 2),
        (0x0028_0011, 3),
        (0x0028_0100, 8),
        (0x0028_0101, 8),
        (0x0028_0102, 7),
        (0x0028_0103, 0),
    ] {
        file.short(tag, value);
    }
    assert_eq!(channel(&file, 0), of_rgb(0));
    let words = RGB
        .concat()
        .chunks_exact(2)
        .flat_map(|pair| [pair[1], pair[0]])
        .collect();
    file.set(0x7fe0_0010, b"OW", words);
    for index in 0..3 {
        assert_eq!(channel(&file, index), of_rgb(index));
    }
}

#[test]
fn luminance_and_chrominance_become_colours() {
    // Red, and greys: their chrominances are 128.
    let full = [
        [76, 85, 255],
        [10, 128, 128],
        [200, 128, 128],
        [0, 128, 128],
        [255, 128, 128],
        [1, 128, 128],
    ];
    let file = colored("YBR_FULL", full.concat());
    for (index, expected) in [
        [254, 10, 200, 0, 255, 1],
        [0, 10, 200, 0, 255, 1],
        [0, 10, 200, 0, 255, 1],
    ]
    .iter()
    .enumerate()
    {
        assert_eq!(channel(&file, index), expected, "{index}");
    }
    let mut halved = colored("YBR_FULL_422", vec![7, 8, 128, 128, 9, 10, 128, 128]);
    halved.short(0x0028_0011, 2);
    assert_eq!(channel(&halved, 1), [7, 8, 9, 10]);
    halved.short(0x0028_0011, 3);
    assert!(one(&halved).unwrap_err().to_string().contains("Columns"));
}

#[test]
fn palettes_are_looked_up() {
    let mut file = DicomFile::slice(EXPLICIT, [0.0; 3], 1, &[0, 5, 6, 7, 8, 9]);
    file.text(0x0028_0004, b"CS", "PALETTE COLOR");
    let words = |numbers: [u16; 3]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>();
    for (index, entries) in [[100, 200, 300], [1, 2, 3], [7, 7, 7]].into_iter().enumerate() {
        file.set(0x0028_1101 + index as u32, b"US", words([3, 6, 16]));
        file.set(0x0028_1201 + index as u32, b"OW", words(entries));
    }
    let loaded = one(&file).unwrap();
    let Samples::U16(red) = loaded.volume.samples() else {
        panic!("not words");
    };
    assert_eq!(red[..], [100, 100, 100, 200, 300, 300]);
    file.set(0x0028_1201, b"OW", vec![1, 0]);
    let error = one(&file).unwrap_err().to_string();
    assert!(
        error.contains("(0028,1201)") && error.contains("3 entries"),
        "{error}"
    );
}

#[test]
fn bits_are_read_from_the_lowest_on_without_gaps_between_frames() {
    let mut file = DicomFile::slice(EXPLICIT, [0.0; 3], 1, &[0; 6]);
    for (tag, value) in [(0x0028_0100, 1), (0x0028_0101, 1), (0x0028_0102, 0)] {
        file.short(tag, value);
    }
    file.text(0x0028_0008, b"IS", "2");
    // Frames of six bits: 1 0 0 1 1 0, then 0 1 1 0 1 0.
    file.set(0x7fe0_0010, b"OB", vec![0b1001_1001, 0b0000_0101]);
    let options = |time| ReadOptions {
        time: Some(time),
        ..ReadOptions::default()
    };
    for (time, expected) in [[1, 0, 0, 1, 1, 0], [0, 1, 1, 0, 1, 0]].into_iter().enumerate() {
        let loaded = one_with(&file, &options(time)).unwrap();
        let Samples::U8(samples) = loaded.volume.samples() else {
            panic!("not bytes");
        };
        assert_eq!(samples[..], expected, "{time}");
    }
}

#[test]
fn tables_of_modalities_give_the_values() {
    let mut file = DicomFile::slice(EXPLICIT, [0.0; 3], 1, &[0, 1, 2, 3, 4, 5]);
    let words = |numbers: &[u16]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>();
    let table = [
        element(EXPLICIT, 0x0028_3002, b"US", &words(&[4, 1, 16])),
        element(EXPLICIT, 0x0028_3006, b"US", &words(&[10, 20, 40, 80])),
    ];
    file.set(0x0028_3000, b"SQ", items(&[table.concat()]));
    let loaded = one(&file).unwrap();
    let Samples::F32(samples) = loaded.volume.samples() else {
        panic!("not real numbers");
    };
    assert_eq!(samples[..], [10.0, 10.0, 20.0, 40.0, 80.0, 80.0]);
    assert!(loaded.description.stored_type.ends_with("by a look-up table"));
}
