//! Files that are longer than what is read of them at once: their headers, and their frames.

use splatvol_io::{IoError, ReadOptions, read_volume};
use splatvol_scene::Samples;

use super::run_length;
use crate::common;
use crate::common::dicom_file::{BIG, DicomFile, EXPLICIT};
use crate::common::slices::assert_opens;

/// Odd, so that frames of bytes begin and end within words.
const SIZE: [u16; 2] = [151, 133];
const FRAME: usize = SIZE[0] as usize * SIZE[1] as usize;
const FRAMES: usize = 9;

/// Frames of numbers of up to 12 bits.
fn words() -> Vec<u16> {
    let word = |i: usize| (i as u32).wrapping_mul(2_654_435_761) >> 20;
    (0..FRAME * FRAMES).map(|i| word(i / 3) as u16).collect()
}

/// A file of several frames, behind a long element of its maker's own.
fn file(syntax: &'static str, bits: u16) -> DicomFile {
    let mut file = DicomFile::picture(syntax, SIZE, bits);
    file.text(0x0028_0008, b"IS", &FRAMES.to_string());
    file.set(0x0009_1010, b"OB", vec![7; 300_001]);
    file
}

/// The frames, which have no places of their own: time points.
fn frames(bytes: &[u8]) -> Vec<Samples> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.dcm");
    std::fs::write(&path, bytes).unwrap();
    let frame = |time| {
        let options = ReadOptions {
            time: Some(time),
            ..ReadOptions::default()
        };
        let loaded = read_volume(&path, &options).unwrap();
        assert_opens(&path, &options, &loaded);
        assert_eq!(loaded.description.times, FRAMES);
        loaded.volume.samples().clone()
    };
    (0..FRAMES).map(frame).collect()
}

#[test]
fn long_headers_are_read_whole_and_frames_one_by_one() {
    let mut native = file(EXPLICIT, 12);
    native.pixels(&words());
    let expected: Vec<Samples> = words()
        .chunks(FRAME)
        .map(|frame| Samples::U16(frame.to_vec().into()))
        .collect();
    assert!(frames(&native.bytes()) == expected);
    let coded: Vec<Vec<u8>> = words().chunks(FRAME).map(run_length::frame).collect();
    let packed = file("1.2.840.10008.1.2.5", 12).encapsulated(&coded);
    assert!(frames(&packed) == expected);
}

#[test]
fn frames_of_bytes_in_words_may_begin_within_one() {
    let bytes: Vec<u8> = words().iter().map(|&word| word as u8).collect();
    let mut file = file(BIG, 8);
    let mut even = bytes.clone();
    even.resize(bytes.len().next_multiple_of(2), 0);
    even.chunks_exact_mut(2).for_each(|pair| pair.swap(0, 1));
    file.set(0x7fe0_0010, b"OW", even);
    let expected: Vec<Samples> = bytes
        .chunks(FRAME)
        .map(|frame| Samples::U8(frame.to_vec().into()))
        .collect();
    assert!(frames(&file.bytes()) == expected);
}

#[test]
fn cut_files_are_refused() {
    let mut file = file(EXPLICIT, 12);
    file.pixels(&words());
    let bytes = file.bytes();
    let folder = tempfile::tempdir().unwrap();
    for length in [
        1000,
        70_000,
        299_000,
        300_500,
        bytes.len() - 40_000,
        bytes.len() - 1,
    ] {
        let error = common::read_bytes(folder.path(), "a.dcm", &bytes[..length]).unwrap_err();
        assert!(
            matches!(error, IoError::Truncated { .. }) || matches!(error, IoError::Unsupported { .. }),
            "{length}: {error}"
        );
    }
}
