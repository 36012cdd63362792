//! Every reader against seeded mutations of small files, and against headers that promise gigabytes: any answer will
//! do that comes in time, without a panic and without using that memory.
//!
//! `SPLATVOL_MUTATIONS=100000 cargo test -p splatvol-io mutat` goes on for longer.

use crate::common::nifti_file::NiftiFile;
use crate::common::{Random, check_memory, gzip, load, read_bytes, small_volumes};
use glam::DVec3;
use splatvol_scene::{Grid, LengthUnit, Rescale, Samples, Volume};
use splatvol_testing::alone;

/// Memory that all malformed files together may take at their worst moment.
const MEMORY: u64 = 96 << 20;

/// A number where a text header has one.
const NUMBERS: &[&str] = &[
    "0",
    "-1",
    "1e39",
    "nan",
    "inf",
    "65535",
    "65536",
    "4294967296",
    "9223372036854775807",
    "18446744073709551616",
    "999999999999999999999999999999999999",
];

fn mutate(bytes: &mut Vec<u8>, random: &mut Random) {
    let mut below = |limit: usize| (random.next() % limit.max(1) as u64) as usize;
    let position = below(bytes.len());
    match below(7) {
        0 => bytes[position] = below(256) as u8,
        1 => bytes[position] = [0, 0xff, 0x7f, 0x80, b'-', b'9', b' ', b'\n', b'('][below(9)],
        2 => bytes.truncate(position),
        3 => drop(bytes.drain(position..(position + 1 + below(16)).min(bytes.len()))),
        4 => {
            let end = (position + 1 + below(64)).min(bytes.len());
            let copy = bytes[position..end].to_vec();
            let to = below(bytes.len());
            bytes.splice(to..to, copy);
        }
        5 => {
            let number = NUMBERS[below(NUMBERS.len())];
            let digits: Vec<usize> = (0..bytes.len()).filter(|&i| bytes[i].is_ascii_digit()).collect();
            if !digits.is_empty() {
                let start = digits[below(digits.len())];
                let length = bytes[start..]
                    .iter()
                    .take_while(|byte| byte.is_ascii_digit())
                    .count();
                bytes.splice(start..start + length, number.bytes());
            }
        }
        _ => {
            let value = (below(1 << 30) as u64) << below(40);
            let value = value.to_le_bytes();
            let length = [1, 2, 4, 8][below(4)].min(bytes.len() - position);
            bytes[position..position + length].copy_from_slice(&value[..length]);
        }
    }
    if bytes.is_empty() {
        bytes.push(0);
    }
}

#[test]
fn mutated_files_are_answered_in_time() {
    alone!();
    let rounds = std::env::var("SPLATVOL_MUTATIONS")
        .ok()
        .and_then(|rounds| rounds.parse().ok())
        .unwrap_or(1000);
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random(20_26);
    for (name, original) in small_volumes::files() {
        read_bytes(folder.path(), name, &original).unwrap_or_else(|error| panic!("{error}"));
        let mut refused = 0;
        for _ in 0..rounds {
            let mut bytes = original.clone();
            for _ in 0..1 + random.next() % 4 {
                mutate(&mut bytes, &mut random);
            }
            refused += usize::from(read_bytes(folder.path(), name, &bytes).is_err());
        }
        assert!(
            refused > rounds / 10,
            "{name}: only {refused} of {rounds} were refused"
        );
    }
    check_memory(MEMORY);
}

#[test]
fn promises_of_gigabytes_cost_nothing() {
    alone!();
    let folder = tempfile::tempdir().unwrap();
    let sizes = ["2000 2000 4000", "65535 65535 65535"];
    for size in sizes {
        for encoding in ["raw", "gzip", "ascii", "hex"] {
            let header =
                format!("NRRD0004\ntype: uchar\ndimension: 3\nsizes: {size}\nencoding: {encoding}\n\n");
            let bomb = [header.as_bytes(), &gzip(&[0; 1 << 20])].concat();
            assert!(read_bytes(folder.path(), "a.nrrd", &bomb).is_err());
        }
        for compressed in ["True", "False"] {
            let header = format!(
                "NDims = 3\nDimSize = {size}\nCompressedData = {compressed}\nElementType = MET_DOUBLE\n\
                 ElementDataFile = LOCAL\n"
            );
            let bomb = [header.as_bytes(), &gzip(&[0; 1 << 20])].concat();
            assert!(read_bytes(folder.path(), "a.mha", &bomb).is_err());
        }
    }
    for datatype in [2, 64, 1792] {
        let nifti = NiftiFile::new(&[32767, 32767, 32767, 32767, 32767], datatype).bytes(&[0; 1 << 20]);
        assert!(read_bytes(folder.path(), "a.nii", &nifti).is_err());
        assert!(read_bytes(folder.path(), "a.nii.gz", &gzip(&nifti)).is_err());
    }
    check_memory(MEMORY);
}

#[test]
fn a_volume_of_one_sample_survives_every_format_that_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let grid = Grid::centred([1, 1, 1], DVec3::ONE).unwrap();
    let volume = Volume::new(
        grid,
        Samples::I16(vec![-7].into()),
        Rescale::default(),
        LengthUnit::Unknown,
    )
    .unwrap();
    for name in ["a.nrrd", "a.npy"] {
        let path = folder.path().join(name);
        splatvol_io::write_volume(&path, &volume, &splatvol_io::WriteOptions::default()).unwrap();
        assert_eq!(load(&path).volume.samples(), volume.samples());
    }
    let unknown = folder.path().join("a.dcm");
    assert!(splatvol_io::write_volume(&unknown, &volume, &splatvol_io::WriteOptions::default()).is_err());
}
