//! Every reader against cut and changed files, and against headers that promise gigabytes.

use std::time::{Duration, Instant};

use crate::common::gaussian_files::{
    cloud, compressed_ply, extension, gltf, gunzip, read_as, sog_files, spz_4, written, zip,
};
use crate::common::{Random, check_memory, gzip};
use splatvol_testing::alone;

/// A reader must finish with a small malformed file within this time, on a busy machine.
const PATIENCE: Duration = Duration::from_secs(1);
/// Memory that all malformed files together may take at their worst moment.
const MEMORY: u64 = 128 << 20;

/// A small file of each format.
fn files() -> Vec<(&'static str, Vec<u8>)> {
    let folder = tempfile::tempdir().unwrap();
    let small = cloud(3, 1);
    let ply = written(folder.path(), "a.ply", &small);
    let spz = written(folder.path(), "a.spz", &small);
    let plain = gunzip(&spz);
    let range = [&[8u8, 8][..], &(-2.0f32).to_le_bytes(), &2.0f32.to_le_bytes()].concat();
    let records = [
        extension(0xADBE_0003, &6u32.to_le_bytes()),
        extension(0xADBE_0001, &range),
    ]
    .concat();
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    let json = gltf(&small, "");
    glb.extend((20 + json.len() as u32).to_le_bytes());
    glb.extend((json.len() as u32).to_le_bytes());
    glb.extend(b"JSON");
    glb.extend(&json);
    let text = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
        property float f_dc_0\nproperty float f_dc_1\nproperty float f_dc_2\nproperty float opacity\n\
        property float scale_0\nproperty float scale_1\nproperty float scale_2\nproperty float rot_0\n\
        property float rot_1\nproperty float rot_2\nproperty float rot_3\nend_header\n\
        1 2 3 .1 .2 .3 0 -1 -2 -3 1 0 0 0\n";
    vec![
        ("trained.ply", ply),
        ("text.ply", text.as_bytes().to_vec()),
        ("compressed.ply", compressed_ply()),
        ("a.splat", written(folder.path(), "a.splat", &small)),
        ("a.ksplat", ksplat()),
        ("a.spz", spz),
        ("plain.spz", plain.clone()),
        ("four.spz", spz_4(&plain, &records)),
        ("one.sog", zip(&sog_files(1))),
        ("two.sog", zip(&sog_files(2))),
        ("a.gltf", json),
        ("a.glb", glb),
    ]
}

/// Three Gaussians at level 1 in one full bucket of two and a partial one.
fn ksplat() -> Vec<u8> {
    let mut bytes = vec![0; 4096 + 1024];
    bytes[1] = 1;
    bytes[4] = 1;
    bytes[16] = 3;
    bytes[20] = 1;
    let mut put = |at: usize, word: u32| bytes[4096 + at..4096 + at + 4].copy_from_slice(&word.to_le_bytes());
    for (at, word) in [
        (0, 3),
        (4, 3),
        (8, 2),
        (12, 2),
        (16, 4f32.to_bits()),
        (20, 12),
        (24, 32767),
        (32, 1),
        (36, 1),
    ] {
        put(at, word);
    }
    bytes.extend(1u32.to_le_bytes());
    for centre in [[1f32, 2.0, 3.0], [-1.0, -2.0, -3.0]] {
        bytes.extend(centre.iter().flat_map(|c| c.to_le_bytes()));
    }
    for _ in 0..3 {
        bytes.extend([0, 0].iter().chain(&[255, 127, 255, 255]));
        bytes.extend(
            [0.5f32, 1.0, 2.0, 0.6, 0.8, 0.0, 0.0]
                .iter()
                .flat_map(|n| half::f16::from_f32(*n).to_le_bytes()),
        );
        bytes.extend([255, 0, 51, 102]);
    }
    bytes
}

#[test]
fn buckets_of_a_ksplat() {
    let folder = tempfile::tempdir().unwrap();
    let loaded = read_as(folder.path(), "a.ksplat", &ksplat()).unwrap();
    let a = loaded.gaussians.attributes();
    // (0 - 32767) * 2 / 32767 from the centre of the bucket; 32767 is the centre, 65535 the end.
    let close = |found: [f32; 3], expected: [f32; 3]| {
        assert!(
            (glam::Vec3::from(found) - glam::Vec3::from(expected)).length() < 1e-3,
            "{found:?}"
        );
    };
    close(a.means[0], [-1.0, 2.0, 5.0]);
    close(a.means[1], [-1.0, 2.0, 5.0]);
    close(a.means[2], [-3.0, -2.0, -1.0]);
    close(a.scales[2], [0.5, 1.0, 2.0]);
    assert!((a.rotations[1][3] - 0.6).abs() < 1e-3 && (a.rotations[1][0] - 0.8).abs() < 1e-3);
    assert_eq!(a.opacities[0], 0.4);
}

/// Reads in time, with an error that names the file.
fn read_in_time(folder: &std::path::Path, name: &str, bytes: &[u8]) -> bool {
    let start = Instant::now();
    let result = read_as(folder, name, bytes);
    assert!(start.elapsed() < PATIENCE, "{name}: {:?}", start.elapsed());
    match result {
        Ok(_) => true,
        Err(error) => {
            assert!(
                error.to_string().contains(name),
                "the message does not name the file: {error}"
            );
            false
        }
    }
}

#[test]
fn cut_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files() {
        assert!(read_in_time(folder.path(), name, &bytes), "{name}");
        for length in (0..bytes.len()).filter(|n| n % 7 == 0 || n + 40 > bytes.len()) {
            let whole = match name {
                "a.splat" => length > 0 && length % 32 == 0,
                // The end of the line, and digits of the last number.
                "text.ply" => length + 1 >= bytes.len(),
                _ => false,
            };
            let read = read_in_time(folder.path(), name, &bytes[..length]);
            assert_eq!(read, whole, "{name} cut at {length} of {}", bytes.len());
        }
    }
}

#[test]
fn changed_files_are_answered_in_time() {
    alone!();
    let rounds = std::env::var("SPLATVOL_MUTATIONS")
        .ok()
        .and_then(|rounds| rounds.parse().ok())
        .unwrap_or(600);
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random(5);
    for (name, original) in files() {
        let mut refused = 0;
        for _ in 0..rounds {
            let mut bytes = original.clone();
            for _ in 0..1 + random.next() % 4 {
                let at = (random.next() % bytes.len() as u64) as usize;
                match random.next() % 4 {
                    0 => bytes[at] = random.next() as u8,
                    1 => bytes[at] = [0, 255, 127, 128, b'9', b'-'][(random.next() % 6) as usize],
                    2 => drop(bytes.drain(at..(at + 3).min(bytes.len()))),
                    _ => {
                        let value = (random.next() >> (random.next() % 60)).to_le_bytes();
                        let length = (bytes.len() - at).min(4);
                        bytes[at..at + length].copy_from_slice(&value[..length]);
                    }
                }
                if bytes.is_empty() {
                    bytes.push(0);
                }
            }
            refused += u64::from(!read_in_time(folder.path(), name, &bytes));
        }
        println!("{name}: {refused} of {rounds} refused");
        let least = if name == "a.ksplat" { 0 } else { rounds / 20 };
        assert!(refused > least, "{name}: only {refused} of {rounds} were refused");
    }
    check_memory(MEMORY);
}

#[test]
fn promises_of_gigabytes_cost_nothing() {
    alone!();
    let folder = tempfile::tempdir().unwrap();
    let billion = 4_000_000_000u32.to_le_bytes();
    for (name, mut bytes) in files() {
        match name {
            "plain.spz" | "four.spz" => bytes[8..12].copy_from_slice(&billion),
            "a.ksplat" => bytes[4096..4100].copy_from_slice(&billion),
            "a.gltf" | "trained.ply" | "text.ply" | "compressed.ply" => {
                let replace = |from: &str, to: &str, bytes: &mut Vec<u8>| {
                    if let Some(at) = bytes.windows(from.len()).position(|w| w == from.as_bytes()) {
                        bytes.splice(at..at + from.len(), to.bytes());
                    }
                };
                replace("vertex 3", "vertex 400000000000", &mut bytes);
                replace("vertex 1", "vertex 400000000000", &mut bytes);
                replace("\"count\":3", "\"count\":400000000000", &mut bytes);
            }
            _ => continue,
        }
        assert!(!read_in_time(folder.path(), name, &bytes), "{name}");
    }
    let mut header = b"NGSP\x03\0\0\0\0\0\0\0\0\x0c\0\0".to_vec();
    header[8..12].copy_from_slice(&billion);
    assert!(!read_in_time(
        folder.path(),
        "bomb.spz",
        &gzip(&[&header[..], &[0; 1 << 20]].concat())
    ));
    let mut files = sog_files(2);
    let meta = String::from_utf8(files[0].1.clone()).unwrap();
    files[0].1 = meta.replace("\"count\":5", "\"count\":4000000000").into_bytes();
    assert!(!read_in_time(folder.path(), "bomb.sog", &zip(&files)));
    // The header of a picture of 16384 x 16384 pixels, and nothing else.
    let mut files = sog_files(2);
    let picture = &mut files[1].1;
    picture[21..25].copy_from_slice(&[0xff, 0xff, 0xff, 0x1f]);
    assert!(!read_in_time(folder.path(), "picture.sog", &zip(&files)));
    check_memory(MEMORY);
}
