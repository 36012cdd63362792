//! Pixels in runs (PS3.5, annex G), coded here: what recorded series show, without them.

use splatvol_scene::Samples;

use super::one;
use crate::common;
use crate::common::dicom_file::{DicomFile, EXPLICIT};

const SIZE: [usize; 2] = [19, 7];

/// Words with runs, and with bytes that never repeat.
fn words() -> Vec<u16> {
    let word = |i: usize| {
        if (i / 20).is_multiple_of(2) {
            0x0a0b
        } else {
            (i * 37 % 4096) as u16
        }
    };
    (0..SIZE[0] * SIZE[1]).map(word).collect()
}

/// A plane of bytes in runs of two or more, and literally otherwise.
fn packed(plane: &[u8]) -> Vec<u8> {
    let mut coded = Vec::new();
    for run in plane.chunk_by(|a, b| a == b) {
        for part in run.chunks(128) {
            match part.len() {
                1 => coded.extend([0, part[0]]),
                length => coded.extend([(257 - length) as u8, part[0]]),
            }
        }
    }
    // A byte that means nothing (G.3.1), and padding.
    coded.push(128);
    coded.resize(coded.len().next_multiple_of(2), 0);
    coded
}

/// A frame: the number of planes, where they begin, and the planes, the highest byte first.
pub(crate) fn frame(words: &[u16]) -> Vec<u8> {
    let planes = [1, 0].map(|byte| {
        packed(
            &words
                .iter()
                .map(|word| word.to_le_bytes()[byte])
                .collect::<Vec<_>>(),
        )
    });
    let mut head = [0u32; 16];
    head[..3].copy_from_slice(&[2, 64, 64 + planes[0].len() as u32]);
    let head = head.iter().flat_map(|number| number.to_le_bytes());
    head.chain(planes.concat()).collect()
}

/// The head of a file of the words.
fn picture(syntax: &'static str) -> DicomFile {
    DicomFile::picture(syntax, SIZE.map(|size| size as u16), 12)
}

fn encapsulated(frame: Vec<u8>) -> Vec<u8> {
    picture("1.2.840.10008.1.2.5").encapsulated(&[frame])
}

#[test]
fn runs_and_literals_are_unpacked() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = encapsulated(frame(&words()));
    let loaded = common::read_bytes(folder.path(), "a.dcm", &bytes).unwrap();
    let mut native = picture(EXPLICIT);
    native.pixels(&words());
    assert_eq!(loaded.volume.samples(), one(&native).unwrap().volume.samples());
    assert_eq!(loaded.volume.samples(), &Samples::U16(words().into()));
}

#[test]
fn cut_and_changed_runs_are_answered() {
    let bytes = encapsulated(frame(&words()));
    common::truncations("cut.dcm", &bytes, bytes.len());
    common::flips("changed.dcm", &bytes, bytes.len());
    let mut planes = frame(&words());
    planes[0] = 3;
    let folder = tempfile::tempdir().unwrap();
    let bytes = encapsulated(planes);
    let error = common::read_bytes(folder.path(), "a.dcm", &bytes)
        .unwrap_err()
        .to_string();
    assert!(error.contains("RLE segments"), "{error}");
}
