//! Compressed pixels: what recorded series show, without them.

use splatvol_io::ReadOptions;
use splatvol_scene::Samples;

use crate::common::coded_files::{COLORS, Coded, FRAMES};
use crate::common::{Random, read_bytes, shared_volumes};

/// The samples of a channel as words; `None` reads grey values.
fn decoded(coded: &Coded, channel: Option<usize>) -> Vec<u16> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("coded.dcm");
    std::fs::write(&path, coded.file()).unwrap();
    let options = ReadOptions {
        channel,
        ..ReadOptions::default()
    };
    let loaded = splatvol_io::read_volume(&path, &options).unwrap_or_else(|error| panic!("{error}"));
    let [columns, rows] = coded.size.map(usize::from);
    assert_eq!(loaded.volume.grid().dims(), [columns, rows, 1], "{}", coded.name);
    match loaded.volume.samples() {
        Samples::U8(samples) => samples.iter().copied().map(u16::from).collect(),
        Samples::U16(samples) => samples.to_vec(),
        other => panic!("{}: {}", coded.name, other.type_name()),
    }
}

#[track_caller]
fn assert_decoded(coded: &Coded, found: &[u16], channel: usize) {
    let expected = coded.samples(channel);
    assert_eq!(found.len(), expected.len(), "{}", coded.name);
    let differences = found.iter().zip(&expected).map(|(a, b)| a.abs_diff(*b));
    let error = differences.max().unwrap_or(0);
    println!("{}, channel {channel}: {error} of {}", coded.name, coded.error);
    assert!(error <= coded.error, "{}: {found:?} {expected:?}", coded.name);
}

#[test]
fn every_compression_gives_what_was_compressed() {
    for coded in &FRAMES {
        assert_decoded(coded, &decoded(coded, None), 0);
    }
}

#[test]
fn every_compression_of_colours_gives_its_channels() {
    for coded in &COLORS {
        for channel in 0..3 {
            assert_decoded(coded, &decoded(coded, Some(channel)), channel);
        }
    }
}

/// Damages the compressed pixels of files: other authors' decoders get malformed bytes. Half of the changes hit the decoder's
/// headers. Returns how many of them were refused.
fn damaged(files: &[Vec<u8>]) -> usize {
    let rounds = std::env::var("SPLATVOL_MUTATIONS")
        .ok()
        .and_then(|rounds| rounds.parse().ok())
        .unwrap_or(60);
    let mut random = Random(11);
    let folder = tempfile::tempdir().unwrap();
    let mut refused = 0;
    for original in files {
        let pixels = original.windows(4).position(|tag| tag == [0xe0, 0x7f, 0x10, 0]);
        let pixels = pixels.unwrap();
        for round in 0..rounds {
            let mut bytes = original.clone();
            let all = bytes.len() - pixels;
            let span = if round % 2 == 0 { all.min(200) } else { all };
            for _ in 0..1 + random.next() % 3 {
                bytes[pixels + random.next() as usize % span] = random.next() as u8;
            }
            refused += usize::from(read_bytes(folder.path(), "changed.dcm", &bytes).is_err());
        }
    }
    refused
}

#[test]
fn changed_compressed_pixels_are_answered() {
    let files: Vec<Vec<u8>> = FRAMES.iter().chain(&COLORS).map(Coded::file).collect();
    assert!(damaged(&files) > files.len());
}

#[test]
fn cut_compressed_pixels_are_answered() {
    let folder = tempfile::tempdir().unwrap();
    for coded in FRAMES.iter().chain(&COLORS) {
        let bytes = coded.file();
        // Behind the fragment follows a mark of eight bytes: without it, and with half of the pixels, no more is read.
        for length in [bytes.len() - 9, bytes.len() / 2 + 200] {
            let cut = read_bytes(folder.path(), "cut.dcm", &bytes[..length]);
            assert!(cut.is_err(), "{}: cut at {length}", coded.name);
        }
    }
}

#[test]
fn changed_pixels_of_recorded_series_are_answered() {
    let Some(folder) = shared_volumes() else { return };
    let files = ["rle", "jpeg", "jpegls", "j2k"].map(|coding| {
        let name = format!("dicom_transfer_syntaxes/compressed_{coding}/IM-0001-0001-0001.dcm");
        std::fs::read(folder.join(name)).unwrap()
    });
    assert!(damaged(&files) > 0);
}
