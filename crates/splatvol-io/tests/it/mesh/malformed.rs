//! Files that are cut, changed, or lie: errors, quickly, without much memory.

use std::path::Path;
use std::time::{Duration, Instant};

use splatvol_io::{IoError, LoadedMesh, ReadOptions, read_mesh};

use super::real_files;

fn read_bytes(folder: &Path, name: &str, bytes: &[u8]) -> Result<LoadedMesh, IoError> {
    let path = folder.join(name);
    std::fs::write(&path, bytes).expect("a file");
    let start = Instant::now();
    let generous = ReadOptions {
        max_bytes: 64 << 30,
        ..ReadOptions::default()
    };
    let result = read_mesh(&path, &generous);
    let time = start.elapsed();
    assert!(time < Duration::from_secs(1), "{name}: {time:?}");
    result
}

/// These bytes with text replaced.
fn changed(bytes: &[u8], from: &str, to: &str) -> Vec<u8> {
    let at = bytes
        .windows(from.len())
        .position(|window| window == from.as_bytes());
    let at = at.unwrap_or_else(|| panic!("no {from}"));
    [&bytes[..at], to.as_bytes(), &bytes[at + from.len()..]].concat()
}

#[test]
fn cut_real_files_give_errors() {
    let Some(data) = real_files() else { return };
    let folder = tempfile::tempdir().unwrap();
    for name in [
        "RectGrid2.vtk",
        "notch_stress.vtk",
        "CylinderQuadratic.vtk",
        "can.vtu",
        "cth.vtr",
    ] {
        let bytes = std::fs::read(data.join(name)).unwrap();
        for part in 1..5 {
            let cut = &bytes[..bytes.len() * part / 20];
            assert!(read_bytes(folder.path(), name, cut).is_err(), "{name} {part}");
        }
    }
    let solution = std::fs::read(data.join("combq.bin")).unwrap();
    let grid = std::fs::read(data.join("combxyz.bin")).unwrap();
    for (grid, solution) in [
        (&grid[..grid.len() - 1], &solution[..]),
        (&grid[..], &solution[..99]),
    ] {
        std::fs::write(folder.path().join("q.bin"), solution).unwrap();
        assert!(read_bytes(folder.path(), "xyz.bin", grid).is_err());
    }
}

#[test]
fn numbers_that_lie_give_errors() {
    let Some(data) = real_files() else { return };
    let folder = tempfile::tempdir().unwrap();
    let cases = [
        ("hexa.vtk", "POINTS 12167", "POINTS 999999999999", "need"),
        (
            "hexa.vtk",
            "POINTS 12167",
            "POINTS 18446744073709551615",
            "bytes are needed",
        ),
        ("hexa.vtk", "CELLS 10648 95832", "CELLS 10648 95831", "cell 10647"),
        ("hexa.vtk", "CELLS 10648 95832", "CELLS 7 95832", "CELLS"),
        ("hexa.vtk", "CELL_TYPES 10648", "CELL_TYPES 10647", "keyword"),
        ("hexa.vtk", "UNSTRUCTURED_GRID", "STRUCTURED_GRID", "DIMENSIONS"),
        ("RectGrid2.vtk", "47 33 11", "47 33 12", "DIMENSIONS"),
        (
            "RectGrid2.vtk",
            "X_COORDINATES 47",
            "X_COORDINATES 48",
            "sample 47",
        ),
        ("office.binary.vtk", "21 20 20", "21 20 2000", "mesh dims"),
        ("notch_stress.vtk", "CELLS 2193", "CELLS 2192", "CONNECTIVITY"),
        (
            "cth.vtr",
            "0 128 0 64 0 64",
            "0 999999 0 999999 0 999999",
            "bytes are needed",
        ),
        (
            "cth.vtr",
            "Extent=\"0 128 0 64 0 64\"",
            "Extent=\"0 127 0 64 0 64\"",
            "",
        ),
        (
            "can.vtu",
            "NumberOfPoints=\"6724\"",
            "NumberOfPoints=\"99999999\"",
            "bytes of data",
        ),
        (
            "can.vtu",
            "NumberOfCells=\"4800\"",
            "NumberOfCells=\"-1\"",
            "NumberOfCells",
        ),
    ];
    for (name, from, to, words) in cases {
        let bytes = std::fs::read(data.join(name)).unwrap();
        // The whole extent is not read.
        let bytes = if to.starts_with("0 9") {
            changed(&bytes, "WholeExtent=\"0 128 0 64 0 64\"", "")
        } else {
            bytes
        };
        match read_bytes(folder.path(), name, &changed(&bytes, from, to)) {
            Ok(_) => assert!(words.is_empty(), "{name}: {to} was read"),
            Err(error) => assert!(error.to_string().contains(words), "{name} {to}: {error}"),
        }
    }
}

#[test]
fn changed_bytes_never_panic() {
    let Some(data) = real_files() else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut state = 12345u64;
    let mut next = move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize
    };
    for name in ["CylinderQuadratic.vtk", "office.binary.vtk", "can.vtu", "cth.vtr"] {
        let bytes = std::fs::read(data.join(name)).unwrap();
        for _ in 0..25 {
            let mut bytes = bytes.clone();
            for _ in 0..1 + next() % 6 {
                // Mostly in the header, where it hurts.
                let at = if next() % 3 == 0 {
                    next() % bytes.len()
                } else {
                    next() % 4000
                };
                bytes[at] = next() as u8;
            }
            let _ = read_bytes(folder.path(), name, &bytes);
        }
    }
}
