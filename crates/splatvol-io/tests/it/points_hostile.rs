//! Every reader of points against truncated and mutated files, and headers with false claims: any result is accepted
//! if it comes within a second, without a panic and without excessive memory.

use std::path::Path;
use std::time::{Duration, Instant};

use crate::common::{Random, check_memory, small_las, small_points};
use splatvol_io::{
    DepthImageOptions, HeightFieldOptions, IoError, LoadedPoints, ReadOptions, read_depth_images,
    read_height_field, read_points,
};
use splatvol_recorded::recorded;
use splatvol_testing::alone;

const PATIENCE: Duration = Duration::from_secs(1);
/// Memory of the whole test at its worst moment.
const MEMORY: u64 = 400 << 20;

fn read(path: &Path) -> Result<LoadedPoints, IoError> {
    match path.extension().unwrap().to_str().unwrap() {
        "dem" | "tif" | "heights" => read_height_field(path, &HeightFieldOptions::default()),
        "json" => read_depth_images(path, &DepthImageOptions::default()),
        _ => read_points(path, &ReadOptions::default()),
    }
}

fn read_bytes(folder: &Path, name: &str, bytes: &[u8]) -> Result<LoadedPoints, IoError> {
    let path = folder.join(name);
    let _ = std::fs::remove_file(&path);
    std::fs::write(&path, bytes).unwrap();
    let start = Instant::now();
    let result = read(&path);
    let elapsed = start.elapsed();
    assert!(elapsed < PATIENCE, "{name}: {elapsed:?}");
    if let Err(error) = &result {
        assert!(error.to_string().contains(name), "{error}");
    }
    result
}

/// Small files of every format, and recorded LAS where there is any.
fn files() -> Vec<(&'static str, Vec<u8>)> {
    let mut files = small_points::files();
    files.extend(las_files());
    files
}

fn las_files() -> Vec<(&'static str, Vec<u8>)> {
    let mut files = small_las::files();
    if let Some(points) = recorded("points") {
        for name in ["1.2-with-color.las", "1.2-with-color.copc.laz"] {
            files.push((name, std::fs::read(points.join(name)).unwrap()));
        }
    }
    files
}

fn mutate(bytes: &mut Vec<u8>, random: &mut Random, head: usize) {
    let mut below = |limit: usize| (random.next() % limit.max(1) as u64) as usize;
    let range = if below(3) > 0 {
        head.min(bytes.len())
    } else {
        bytes.len()
    };
    let position = below(range);
    match below(5) {
        0 => bytes[position] = below(256) as u8,
        1 => bytes[position] = [0, 0xff, 0x7f, 0x80, b'-', b'9', b' ', b'\n'][below(8)],
        2 => bytes.truncate(position),
        3 => drop(bytes.drain(position..(position + 1 + below(16)).min(bytes.len()))),
        _ => {
            let value = ((below(1 << 30) as u64) << below(40)).to_le_bytes();
            let length = [1, 2, 4, 8][below(4)].min(bytes.len() - position);
            bytes[position..position + length].copy_from_slice(&value[..length]);
        }
    }
    if bytes.is_empty() {
        bytes.push(0);
    }
}

#[test]
fn cut_and_mutated_files_are_answered_in_time() {
    alone!();
    let rounds = std::env::var("SPLATVOL_MUTATIONS")
        .ok()
        .and_then(|n| n.parse().ok())
        .unwrap_or(400);
    let folder = tempfile::tempdir().unwrap();
    let npy = format!(
        "{:<117}\n",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }"
    );
    let floats: Vec<u8> = (1..7u8).flat_map(|i| f32::from(i).to_le_bytes()).collect();
    let npy = [b"\x93NUMPY\x01\x00\x76\x00", npy.as_bytes(), &floats].concat();
    std::fs::write(folder.path().join("depth.npy"), npy).unwrap();
    let mut random = Random(5);
    for (name, original) in files() {
        let whole = read_bytes(folder.path(), name, &original).unwrap_or_else(|error| panic!("{error}"));
        // A cut file is refused, or what was lost did not matter.
        let step = (original.len() / 200).max(1);
        for length in (0..original.len()).step_by(step) {
            if let Ok(cut) = read_bytes(folder.path(), name, &original[..length]) {
                // A text may lose whole lines, or the end of its last number.
                let text = name.starts_with("table") || name.starts_with("ascii");
                let shorter = text && cut.points.len() <= whole.points.len();
                assert!(shorter || cut.points == whole.points, "{name}: cut at {length}");
            }
        }
        let mut refused = 0;
        for _ in 0..rounds {
            let mut bytes = original.clone();
            for _ in 0..1 + random.next() % 3 {
                mutate(&mut bytes, &mut random, 400);
            }
            refused += usize::from(read_bytes(folder.path(), name, &bytes).is_err());
        }
        println!("{name}: {refused} of {rounds} refused");
        assert!(refused > rounds / 10, "{name}: only {refused} of {rounds}");
    }
    check_memory(MEMORY);
}

#[test]
fn promises_cost_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |name: &str, bytes: &[u8]| {
        let error = read_bytes(folder.path(), name, bytes).unwrap_err();
        println!("{error}");
    };
    for count in ["1000000000000", "18446744073709551615"] {
        for data in ["ascii", "binary", "binary_compressed"] {
            let pcd = format!(
                "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH {count}\nHEIGHT 1\nPOINTS {count}\n\
                 DATA {data}\n1 2 3\n"
            );
            refused("a.pcd", pcd.as_bytes());
        }
        for format in ["ascii", "binary_little_endian"] {
            let ply = format!(
                "ply\nformat {format} 1.0\nelement vertex {count}\nproperty float x\nproperty float y\n\
                 property float z\nend_header\n1 2 3\n"
            );
            refused("a.ply", ply.as_bytes());
        }
    }
    let steep = "0 1e30\n1e30 0\n";
    let options = HeightFieldOptions {
        height_scale: Some(1.0),
        ..HeightFieldOptions::default()
    };
    let path = folder.path().join("steep.csv");
    std::fs::write(&path, steep).unwrap();
    let error = read_height_field(&path, &options).unwrap_err().to_string();
    assert!(error.contains("another scale"), "{error}");
    for (name, mut bytes) in las_files() {
        // LAS 1.4 has its own count, which holds if the old one is zero.
        let large = bytes[25] == 4;
        let old: u32 = if large { 0 } else { u32::MAX };
        bytes[107..111].copy_from_slice(&old.to_le_bytes());
        if large {
            bytes[247..255].copy_from_slice(&1_000_000_000_000u64.to_le_bytes());
        }
        refused(name, &bytes);
    }
}
