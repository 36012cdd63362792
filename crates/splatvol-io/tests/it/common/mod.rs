//! Helpers for the tests of all formats.
#![allow(
    dead_code,
    unreachable_pub,
    clippy::unwrap_used,
    reason = "every test file uses its own part of these; panics are how tests fail"
)]

pub mod codecs;
pub mod coded_files;
pub mod dicom_file;
pub mod gaussian_files;
pub mod images;
pub mod nifti_file;
pub mod slices;
pub mod small_las;
pub mod small_meshes;
pub mod small_points;
pub mod small_volumes;
pub mod vti_file;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use glam::DVec3;
use splatvol_io::{IoError, Loaded, ReadOptions, read_volume};
use splatvol_recorded::{recorded, skip};

/// A reader must finish with a small malformed file within this time, on a busy machine.
const PATIENCE: Duration = Duration::from_secs(1);

/// The folder of real volumes, or `None` (with a line saying so) where it is absent.
pub fn shared_volumes() -> Option<PathBuf> {
    recorded("volumes")
}

/// Reads with default options.
pub fn load(path: &Path) -> Loaded {
    read_volume(path, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// Known contents of a real file.
pub struct Expected {
    /// Dimensions x y z.
    pub dims: [usize; 3],
    /// Spacing x y z.
    pub spacing: [f64; 3],
    /// Smallest value, largest value, mean.
    pub values: [f64; 3],
    /// Name of the sample type in memory.
    pub sample_type: &'static str,
}

/// Compares a loaded volume with its known figures. Spacing and values were noted with 6 digits, means with 4 decimals.
pub fn assert_expected(name: &str, loaded: &Loaded, expected: &Expected) {
    let volume = &loaded.volume;
    let statistics = volume.statistics();
    assert_eq!(volume.grid().dims(), expected.dims, "{name}: dims");
    assert_eq!(volume.samples().type_name(), expected.sample_type, "{name}: type");
    let spacing = volume.grid().spacing() / DVec3::from_array(expected.spacing);
    assert!(
        (spacing - 1.0).abs().max_element() < 1e-5,
        "{name}: spacing {:?}",
        volume.grid().spacing()
    );
    let found = [statistics.min, statistics.max, statistics.mean];
    for (found, expected) in found.into_iter().zip(expected.values) {
        let tolerance = 1e-5 * expected.abs() + 6e-5;
        assert!((found - expected).abs() <= tolerance, "{name}: {statistics:?}");
    }
}

/// Default options that do not depend on the memory of the machine.
pub fn generous() -> ReadOptions {
    ReadOptions {
        max_bytes: 64 << 30,
        ..ReadOptions::default()
    }
}

/// Reads `bytes` as a file called `name`, and fails if that takes long. A panic fails the test by itself.
pub fn read_bytes(folder: &Path, name: &str, bytes: &[u8]) -> Result<Loaded, IoError> {
    let path = folder.join(name);
    // A new file each time: some file systems write a truncated one to disk at once, which takes milliseconds.
    let _ = std::fs::remove_file(&path);
    std::fs::write(&path, bytes).unwrap();
    let start = Instant::now();
    let result = read_volume(&path, &generous());
    let elapsed = start.elapsed();
    assert!(
        elapsed < PATIENCE,
        "{name}: {elapsed:?} for {} bytes",
        bytes.len()
    );
    if let Err(error) = &result {
        let text = error.to_string();
        assert!(text.contains(name), "the message does not name the file: {text}");
    }
    result
}

/// Fails if this process has taken more than so many bytes at its worst moment, which Linux notes. Such tests begin with `alone!`.
pub fn check_memory(most: u64) {
    let Ok(status) = std::fs::read_to_string("/proc/self/status") else {
        skip("no /proc to read the memory from");
        return;
    };
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))
        .unwrap();
    let kilobytes: u64 = line.trim().trim_end_matches("kB").trim().parse().unwrap();
    println!("{kilobytes} kB at the worst moment");
    assert!(kilobytes << 10 < most, "{kilobytes} kB at the worst moment");
}

/// Every prefix of a file up to `header` bytes, then every 64th and the longest: each must give an error, or a volume
/// equal to the whole file's (the truncation took nothing essential).
pub fn truncations(name: &str, bytes: &[u8], header: usize) {
    let folder = tempfile::tempdir().unwrap();
    let whole = read_bytes(folder.path(), name, bytes).unwrap_or_else(|error| panic!("{error}"));
    let lengths = (0..bytes.len()).filter(|&n| n <= header || n % 64 == 0 || n + 1 == bytes.len());
    let mut refused = 0;
    for length in lengths {
        match read_bytes(folder.path(), name, &bytes[..length]) {
            Err(_) => refused += 1,
            Ok(loaded) => assert_eq!(
                loaded.volume.samples(),
                whole.volume.samples(),
                "{name}: cut at {length} gives other samples without an error"
            ),
        }
    }
    assert!(refused > 0, "{name}: no truncation was refused");
}

/// Flips bits of each of the first `header` bytes, four seeded ways each: any result will do, in time and without a
/// panic. Returns the number of files that were refused.
pub fn flips(name: &str, bytes: &[u8], header: usize) -> usize {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random(0x5eed);
    let mut refused = 0;
    for position in 0..header.min(bytes.len()) {
        for _ in 0..4 {
            let mut changed = bytes.to_vec();
            changed[position] ^= (random.next() % 255 + 1) as u8;
            refused += usize::from(read_bytes(folder.path(), name, &changed).is_err());
        }
    }
    refused
}

/// A seeded generator (splitmix64): the tests must give the same files everywhere.
pub struct Random(pub u64);

impl Random {
    /// The next 64 bits.
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number in [-1, 1).
    pub fn signed(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// gzip of `bytes`.
pub fn gzip(bytes: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}
