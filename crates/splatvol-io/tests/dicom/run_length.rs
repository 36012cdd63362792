//! Pixels in runs (PS3.5, annex G), coded here: what recorded series show, without them.

use splatvol_scene::Samples;

use super::file::{DicomFile, EXPLICIT};
use super::{common, one};

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
fn frame(words: &[u16]) -> Vec<u8> {
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

/// A file whose pixels are one fragment.
fn encapsulated(syntax: &'static str, fragment: &[u8]) -> Vec<u8> {
    let mut file = DicomFile::slice(EXPLICIT, [0.0; 3], 1, &[0; 6]);
    file.short(0x0028_0011, SIZE[0] as u16);
    file.short(0x0028_0010, SIZE[1] as u16);
    file.syntax = syntax;
    let mut body = file.dataset();
    // The native pixels are last: twelve bytes of head, and as many of samples.
    body.truncate(body.len() - 24);
    body.extend([0xe0, 0x7f, 0x10, 0x00]);
    body.extend(b"OB\0\0");
    body.extend([0xff; 4]);
    for item in [&[][..], fragment] {
        body.extend([0xfe, 0xff, 0x00, 0xe0]);
        body.extend((item.len() as u32).to_le_bytes());
        body.extend(item);
    }
    body.extend([0xfe, 0xff, 0xdd, 0xe0, 0, 0, 0, 0]);
    file.with_body(&body)
}

#[test]
fn runs_and_literals_are_unpacked() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = encapsulated("1.2.840.10008.1.2.5", &frame(&words()));
    let loaded = common::read_bytes(folder.path(), "a.dcm", &bytes).unwrap();
    let mut native = DicomFile::slice(EXPLICIT, [0.0; 3], 1, &[0; 6]);
    native.short(0x0028_0011, SIZE[0] as u16);
    native.short(0x0028_0010, SIZE[1] as u16);
    native.pixels(&words());
    assert_eq!(loaded.volume.samples(), one(&native).unwrap().volume.samples());
    assert_eq!(loaded.volume.samples(), &Samples::U16(words().into()));
}

#[test]
fn cut_and_changed_runs_are_answered() {
    let bytes = encapsulated("1.2.840.10008.1.2.5", &frame(&words()));
    common::truncations("cut.dcm", &bytes, bytes.len());
    common::flips("changed.dcm", &bytes, bytes.len());
    let mut planes = frame(&words());
    planes[0] = 3;
    let folder = tempfile::tempdir().unwrap();
    let bytes = encapsulated("1.2.840.10008.1.2.5", &planes);
    let error = common::read_bytes(folder.path(), "a.dcm", &bytes)
        .unwrap_err()
        .to_string();
    assert!(error.contains("RLE segments"), "{error}");
}
