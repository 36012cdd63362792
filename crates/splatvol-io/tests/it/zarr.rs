//! OME-Zarr folders written here: versions 2 and 3, orders, shards, levels, channels, times.

use std::path::Path;

use crate::common::{Random, gzip};
use glam::DVec3;
use serde_json::{Value, json};
use splatvol_io::{IoError, Loaded, ReadOptions, open_volume, read_volume};
use splatvol_scene::{LengthUnit, Samples};

fn write(folder: &Path, name: &str, bytes: impl AsRef<[u8]>) {
    let path = folder.join(name);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, bytes).unwrap();
}

fn read(folder: &Path, change: impl Fn(&mut ReadOptions)) -> Result<Loaded, IoError> {
    let mut options = ReadOptions::default();
    change(&mut options);
    read_volume(folder, &options)
}

fn words(loaded: &Loaded) -> Vec<u16> {
    match loaded.volume.samples() {
        Samples::U16(samples) => samples.to_vec(),
        other => panic!("{}", other.type_name()),
    }
}

/// Sample at (t, c, z, y, x).
fn value([t, c, z, y, x]: [usize; 5]) -> u16 {
    (10_000 * t + 1000 * c + 100 * z + 10 * y + x) as u16
}

/// Expected samples of a volume of `dims` at (t, c).
fn expected(t: usize, c: usize, [nx, ny, nz]: [usize; 3]) -> Vec<u16> {
    let at = |i: usize| value([t, c, i / (nx * ny), i / nx % ny, i % nx]);
    (0..nx * ny * nz).map(at).collect()
}

fn axes() -> Value {
    json!([
        {"name": "t", "type": "time"}, {"name": "c", "type": "channel"},
        {"name": "z", "type": "space", "unit": "micrometer"}, {"name": "y", "type": "space", "unit": "micrometer"},
        {"name": "x", "type": "space", "unit": "micrometer"}
    ])
}

fn scales() -> Value {
    let level = |path: &str, step: f64| {
        json!({"path": path, "coordinateTransformations": [
            {"type": "scale", "scale": [1.0, 1.0, 2.0 * step, 0.5 * step, 0.25 * step]},
            {"type": "translation", "translation": [0.0, 0.0, 7.0, 8.0, 9.0]}
        ]})
    };
    json!([{"version": "0.4", "axes": axes(), "datasets": [level("0", 1.0), level("1", 2.0)],
        "coordinateTransformations": [{"type": "scale", "scale": [1.0, 1.0, 1.0, 1.0, 10.0]}]}])
}

/// Version 2: two times, two channels, 5 x 3 x 4 and a level of half of it; big-endian, chunks of 2 x 2 x 2, gzip.
fn version_2(folder: &Path, order: &str) {
    let omero = json!({"channels": [{"label": "DAPI"}, {"label": "GFP"}]});
    let attributes = json!({"multiscales": scales(), "omero": omero});
    write(folder, ".zgroup", "{\"zarr_format\": 2}");
    write(folder, ".zattrs", attributes.to_string());
    for (level, [nx, ny, nz]) in [("0", [5usize, 3, 4]), ("1", [3, 2, 2])] {
        let array = json!({"zarr_format": 2, "shape": [2, 2, nz, ny, nx], "chunks": [1, 2, 2, 2, 2], "dtype": ">u2",
            "compressor": {"id": "gzip", "level": 1}, "fill_value": 77, "order": order, "filters": null});
        write(folder, &format!("{level}/.zarray"), array.to_string());
        for t in 0..2 {
            for (z, y, x) in numbers([nz.div_ceil(2), ny.div_ceil(2), nx.div_ceil(2)]) {
                let sample = |i: usize| {
                    let [a, b, c, d] = [i >> 3 & 1, i >> 2 & 1, i >> 1 & 1, i & 1];
                    let [dc, dz, dy, dx] = if order == "C" { [a, b, c, d] } else { [d, c, b, a] };
                    value([t, dc, 2 * z + dz, 2 * y + dy, 2 * x + dx])
                };
                let bytes: Vec<u8> = (0..16).flat_map(|i| sample(i).to_be_bytes()).collect();
                write(folder, &format!("{level}/{t}.0.{z}.{y}.{x}"), gzip(&bytes));
            }
        }
    }
}

fn numbers([a, b, c]: [usize; 3]) -> impl Iterator<Item = (usize, usize, usize)> {
    (0..a * b * c).map(move |i| (i / (b * c), i / c % b, i % c))
}

#[test]
fn levels_channels_and_times_are_chosen() {
    for order in ["C", "F"] {
        let folder = tempfile::tempdir().unwrap();
        version_2(folder.path(), order);
        let first = read(folder.path(), |_| ()).unwrap();
        assert_eq!(words(&first), expected(0, 0, [5, 3, 4]), "{order}");
        assert_eq!(first.description.levels, [[5, 3, 4], [3, 2, 2]]);
        assert_eq!(
            (first.description.times, &first.description.channels[..]),
            (2, &["DAPI".to_owned(), "GFP".to_owned()][..])
        );
        assert_eq!(first.volume.grid().spacing(), DVec3::new(2.5, 0.5, 2.0));
        assert_eq!(first.volume.grid().origin(), DVec3::new(90.0, 8.0, 7.0));
        assert_eq!(first.volume.unit(), LengthUnit::Micrometre);
        let other = read(folder.path(), |options| {
            (options.level, options.channel, options.time) = (1, Some(1), Some(1));
        });
        let other = other.unwrap();
        assert_eq!(words(&other), expected(1, 1, [3, 2, 2]), "{order}");
        assert_eq!(other.volume.grid().spacing(), DVec3::new(5.0, 1.0, 4.0));
        let error = read(folder.path(), |options| options.level = 2)
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("to choose from: 0: 5 x 3 x 4, 1: 3 x 2 x 2"),
            "{error}"
        );
        let error = read(folder.path(), |options| options.channel = Some(2))
            .unwrap_err()
            .to_string();
        assert!(error.contains("to choose from: 0: DAPI, 1: GFP"), "{error}");
    }
}

#[test]
fn chunks_that_are_absent_are_fill_and_cut_ones_errors() {
    let folder = tempfile::tempdir().unwrap();
    version_2(folder.path(), "C");
    let chunk = folder.path().join("0/0.0.0.0.0");
    let bytes = std::fs::read(&chunk).unwrap();
    std::fs::remove_file(&chunk).unwrap();
    let mut wanted = expected(0, 0, [5, 3, 4]);
    for (z, y, x) in numbers([2, 2, 2]) {
        wanted[x + 5 * (y + 3 * z)] = 77;
    }
    assert_eq!(words(&read(folder.path(), |_| ()).unwrap()), wanted);
    for length in 0..bytes.len() {
        std::fs::write(&chunk, &bytes[..length]).unwrap();
        let error = read(folder.path(), |_| ()).unwrap_err().to_string();
        assert!(error.contains("0.0.0.0.0"), "{error}");
    }
}

/// Version 3: shards of 4 x 4 x 4 with chunks of 2 x 2 x 2, x and z swapped, a checksum behind each.
#[test]
fn shards_of_version_3_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    let scale = json!({"type": "scale", "scale": [1.0, 1.0, 1.0]});
    let image = json!({"axes": [{"name": "z", "type": "space"}, {"name": "y", "type": "space"}, {"name": "x", "type": "space"}],
        "datasets": [{"path": "s0", "coordinateTransformations": [scale]}]});
    let group = json!({"zarr_format": 3, "node_type": "group", "attributes": {"ome": {"version": "0.5", "multiscales": [image]}}});
    write(root, "zarr.json", group.to_string());
    let inner = json!([{"name": "transpose", "configuration": {"order": [2, 1, 0]}},
        {"name": "bytes", "configuration": {"endian": "little"}}, {"name": "crc32c"}]);
    let sharding = json!({"name": "sharding_indexed", "configuration": {"chunk_shape": [2, 2, 2], "codecs": inner,
        "index_codecs": [{"name": "bytes", "configuration": {"endian": "little"}}, {"name": "crc32c"}]}});
    let array = json!({"zarr_format": 3, "node_type": "array", "shape": [3, 4, 6], "data_type": "uint16", "fill_value": 5,
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [4, 4, 4]}}, "codecs": [sharding],
        "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}}});
    write(root, "s0/zarr.json", array.to_string());
    for shard in 0..2 {
        let (mut bytes, mut index) = (Vec::new(), Vec::new());
        for (z, y, x) in numbers([2, 2, 2]) {
            // One chunk is left out.
            if (shard, z, y, x) == (0, 0, 1, 1) {
                index.extend([0xff; 16]);
                continue;
            }
            let sample = |i: usize| {
                value([
                    0,
                    0,
                    2 * z + (i & 1),
                    2 * y + (i >> 1 & 1),
                    4 * shard + 2 * x + (i >> 2),
                ])
            };
            let chunk: Vec<u8> = (0..8).flat_map(|i| sample(i).to_le_bytes()).collect();
            index.extend((bytes.len() as u64).to_le_bytes());
            index.extend(20u64.to_le_bytes());
            bytes.extend(&chunk);
            bytes.extend(crc32c(&chunk).to_le_bytes());
        }
        let sum = crc32c(&index);
        bytes.extend(index);
        bytes.extend(sum.to_le_bytes());
        write(root, &format!("s0/c/0/0/{shard}"), bytes);
    }
    let mut wanted = expected(0, 0, [6, 4, 3]);
    for (z, y, x) in numbers([2, 2, 2]) {
        wanted[x + 2 + 6 * (y + 2 + 4 * z)] = 5;
    }
    let loaded = read(root, |_| ()).unwrap();
    assert_eq!(words(&loaded), wanted);
    assert_eq!(loaded.description.format, "OME-Zarr 0.5 (Zarr 3)");
    let path = root.join("s0/c/0/0/0");
    let whole = std::fs::read(&path).unwrap();
    for at in 0..whole.len() {
        let mut changed = whole.clone();
        changed[at] ^= 0x40;
        std::fs::write(&path, changed).unwrap();
        assert!(read(root, |_| ()).is_err(), "{at}");
    }
}

/// CRC-32C by its definition: the remainder of polynomials, bit by bit.
fn crc32c(bytes: &[u8]) -> u32 {
    let mut crc = u32::MAX;
    for bit in bytes
        .iter()
        .flat_map(|byte| (0..8).map(move |i| u32::from(byte >> i & 1)))
    {
        let carry = (crc ^ bit) & 1;
        crc >>= 1;
        if carry == 1 {
            crc ^= 0x82f6_3b78;
        }
    }
    !crc
}

#[test]
fn metadata_that_promise_too_much_or_lead_out_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let array = |shape: Value, chunks: Value| json!({"zarr_format": 2, "shape": shape, "chunks": chunks, "dtype": "<f8", "compressor": null, "fill_value": 0, "order": "C"});
    write(folder.path(), "0.0.0", [0; 64]);
    for (shape, chunks) in [
        (json!([60000, 60000, 60000]), json!([1, 1, 1])),
        (json!([60000, 60000, 60000]), json!([60000, 60000, 60000])),
        (json!([400, 400, 200]), json!([400, 400, 200])),
        (json!([100, 100, 100]), json!([1, 1, 1])),
        (json!([0, 1, 1]), json!([1, 1, 1])),
        (json!([1, 1]), json!([1, 1, 1])),
        (json!([[1]]), json!([1])),
    ] {
        write(folder.path(), ".zarray", array(shape.clone(), chunks).to_string());
        let start = std::time::Instant::now();
        assert!(read(folder.path(), |_| ()).is_err(), "{shape}");
        assert!(start.elapsed().as_secs_f64() < 1.0);
    }
    write(
        folder.path(),
        ".zarray",
        array(json!([2, 2, 2]), json!([2, 2, 2])).to_string(),
    );
    assert!(read(folder.path(), |_| ()).is_ok());
    std::fs::remove_file(folder.path().join(".zarray")).unwrap();
    for path in ["../x", "/etc", ""] {
        let scales = json!([{"datasets": [{"path": path}]}]);
        write(
            folder.path(),
            ".zattrs",
            json!({"multiscales": scales}).to_string(),
        );
        let error = read(folder.path(), |_| ()).unwrap_err().to_string();
        assert!(error.contains("a folder inside this one"), "{error}");
    }
}

#[test]
fn changed_metadata_are_answered_in_time() {
    let folder = tempfile::tempdir().unwrap();
    version_2(folder.path(), "C");
    let mut random = Random(7);
    for name in [".zattrs", "0/.zarray"] {
        let path = folder.path().join(name);
        let original = std::fs::read(&path).unwrap();
        for _ in 0..500 {
            let mut bytes = original.clone();
            let at = random.next() as usize % bytes.len();
            let with: &[u8] = [
                &b"9"[..],
                b"-",
                b"99999999999",
                b"1e300",
                b"null",
                b"[",
                b"\"",
                b"",
            ][random.next() as usize % 8];
            bytes.splice(at..at + 1, with.iter().copied());
            std::fs::write(&path, bytes).unwrap();
            let start = std::time::Instant::now();
            let _ = read(folder.path(), |_| ());
            assert!(start.elapsed().as_secs_f64() < 1.0);
        }
        std::fs::write(&path, original).unwrap();
    }
}

#[test]
fn more_chunks_than_files_justify_are_refused_before_they_are_listed() {
    let folder = tempfile::tempdir().unwrap();
    let inner = json!({ "chunk_shape": [1, 1, 1], "codecs": [{ "name": "bytes" }] });
    let array = json!({ "zarr_format": 3, "node_type": "array", "shape": [1, 8192, 8192], "data_type": "uint8",
        "chunk_grid": { "name": "regular", "configuration": { "chunk_shape": [1, 65536, 65536] } },
        "chunk_key_encoding": { "name": "default" }, "fill_value": 0,
        "codecs": [{ "name": "sharding_indexed", "configuration": inner }] });
    write(folder.path(), "zarr.json", array.to_string());
    let error = open_volume(folder.path(), &ReadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("\"shape\"") && error.contains("chunks in 0 files"),
        "{error}"
    );
}
