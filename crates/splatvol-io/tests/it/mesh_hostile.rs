//! Meshes of every format that are cut, contradict themselves, or are absurd: refused by name or read, in little memory.

use std::path::Path;

use crate::common::{check_memory, generous, small_meshes};
use splatvol_io::{Data, DataOptions, IoError, ReadOptions, read_data, read_mesh, read_volume};
use splatvol_testing::alone;

/// Memory of all tests at their worst moment.
const MEMORY: u64 = 96 << 20;
/// Discs that the triangles of a small file may become.
const DISCS: usize = 262_144;

/// What a file of these bytes is read as.
fn read(name: &str, bytes: &[u8]) -> Result<Data, IoError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    let options = DataOptions {
        read: generous(),
        ..DataOptions::default()
    };
    read_data(&path, &options).map(|loaded| loaded.data)
}

/// A small file with a text of it replaced.
fn changed(name: &str, from: &str, to: &str) -> Vec<u8> {
    let files = small_meshes::files();
    let (_, bytes) = files.into_iter().find(|(other, _)| *other == name).unwrap();
    let at = bytes
        .windows(from.len())
        .position(|window| window == from.as_bytes());
    let at = at.unwrap_or_else(|| panic!("{name}: no {from:?}"));
    [&bytes[..at], to.as_bytes(), &bytes[at + from.len()..]].concat()
}

/// The error of the changed file, which names it.
#[track_caller]
fn refused(name: &str, from: &str, to: &str) -> String {
    let error = match read(name, &changed(name, from, to)) {
        Ok(_) => panic!("{name}: {to} was read"),
        Err(error) => error.to_string(),
    };
    assert!(error.contains(name), "{name}, {to}: {error}");
    error
}

/// Asserts that the changed file is refused, by its name and these words.
#[track_caller]
fn assert_refused((name, from, to, words): (&str, &str, &str, &str)) {
    let error = refused(name, from, to);
    assert!(error.contains(words), "{name}, {to}: no {words:?} in {error}");
}

/// Numbers of points, or of discs, and of cells.
fn counts(data: &Data) -> [usize; 2] {
    match data {
        Data::Mesh(mesh) => [mesh.positions().len(), mesh.cell_count()],
        Data::Points(points) => [points.len(), 0],
        other => panic!("{other:?}"),
    }
}

#[test]
fn small_meshes_are_read_and_cut_ones_are_refused_or_no_larger() {
    alone!();
    for (name, bytes) in small_meshes::files() {
        let whole = counts(&read(name, &bytes).unwrap_or_else(|error| panic!("{error}")));
        let mut refused = 0;
        for length in (0..bytes.len()).step_by(7) {
            match read(name, &bytes[..length]) {
                Ok(cut) => {
                    let cut = counts(&cut);
                    assert!(
                        cut[0] <= whole[0] && cut[1] <= whole[1],
                        "{name}: cut at {length}"
                    );
                }
                Err(error) => {
                    assert!(error.to_string().contains(name), "{error}");
                    refused += 1;
                }
            }
        }
        // The first half has no mesh.
        assert!(refused > bytes.len() / 14, "{name}: {refused} refused");
    }
    check_memory(MEMORY);
}

#[test]
fn cut_grids_and_solutions_are_refused_or_read_with_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    for [(solution_name, solution), (grid_name, grid)] in small_meshes::plot3d() {
        let [solution_path, grid_path] = [solution_name, grid_name].map(|name| folder.path().join(name));
        let read = |grid: &[u8], solution: &[u8]| {
            std::fs::write(&solution_path, solution).unwrap();
            std::fs::write(&grid_path, grid).unwrap();
            read_mesh(&grid_path, &generous())
        };
        let whole = read(&grid, &solution).unwrap();
        assert!(whole.description.warnings.is_empty());
        assert_eq!(whole.mesh.positions().len() % 27, 0);
        let short = |bytes: &[u8]| bytes[..bytes.len() - 1].to_vec();
        for (grid, solution) in [(short(&grid), solution.clone()), (grid.clone(), short(&solution))] {
            // A number that is not there is missing, and no point may be.
            match read(&grid, &solution) {
                Ok(cut) => {
                    let warnings = cut.description.warnings.join("; ");
                    assert!(warnings.contains("1 bytes are missing at the end"), "{warnings}");
                }
                Err(error) => assert!(error.to_string().contains("finite coordinates"), "{error}"),
            }
        }
        for (grid, solution) in [
            (&grid[..grid.len() / 2], &solution[..]),
            (&grid[..], &solution[..99]),
        ] {
            assert!(read(grid, solution).is_err());
        }
    }
}

#[test]
fn counts_that_no_file_holds_are_refused_for_nothing() {
    alone!();
    for count in ["999999999", "999999999999", "18446744073709551615", "-1", "a"] {
        for (name, from) in [
            ("cells.vtk", "POINTS 8"),
            ("binary.vtk", "POINTS 8"),
            ("cells.vtk", "CELLS 2"),
            ("faces.vtk", "POLYGONS 2"),
            ("block.vtk", "DIMENSIONS 2"),
            ("axes.vtk", "X_COORDINATES 2"),
            ("text.vtu", "NumberOfPoints=\"8"),
            ("appended.vtu", "NumberOfPoints=\"4"),
            ("zlib.vtu", "NumberOfCells=\"2"),
            ("text.vtp", "NumberOfPolys=\"2"),
            ("text.vtr", "Piece Extent=\"0 1 0 1 0 1"),
            ("base64.vts", "Piece Extent=\"0 1 0 1 0 1"),
            ("faces.ply", "element vertex 4"),
            ("faces.ply", "element face 2"),
            ("big.ply", "element face 1"),
        ] {
            let kept = from.trim_end_matches(|c: char| c.is_ascii_digit());
            let error = refused(name, from, &format!("{kept}{count}"));
            let says = ["field", "bytes are needed", "bytes, found", "mesh dims"];
            assert!(says.iter().any(|words| error.contains(words)), "{error}");
        }
    }
    check_memory(MEMORY);
}

#[test]
fn cells_of_points_that_are_not_there_are_refused_by_number() {
    for case in [
        ("cells.vtk", "4 0 1 2 4\n", "4 0 1 2 8\n", "point of cell 1"),
        ("cells.vtk", "4 0 1 2 4\n", "4 0 1 2 -1\n", "whole number"),
        ("cells.vtk", "4 0 1 2 4\n", "5 0 1 2 4\n", "cell 1"),
        ("cells.vtk", "4 0 1 2 4\n", "400000000 0 1 2 4\n", "cell 1"),
        ("faces.vtk", "3 4 5 6\n", "3 4 5 8\n", "point of cell 1"),
        ("text.vtu", "7 6 0 1 2 4", "7 6 0 1 2 8", "point of cell 1"),
        ("text.vtu", "7 6 0 1 2 4", "7 6 0 1 2 -4", "connectivity"),
        ("text.vtu", ">8 12<", ">13 12<", "offset of cell 0"),
        ("text.vtu", ">8 12<", ">12 8<", "expected 8 numbers"),
        ("text.vtu", ">8 12<", ">8 13<", "expected 13 numbers"),
        ("text.vtp", "2 4 5 6<", "2 4 5 8<", "point of cell 1"),
        ("text.vtp", ">4 7<", ">8 7<", "offset of cell 0"),
        ("text.vtp", ">4 7<", ">7 4<", "expected 4 numbers"),
        ("faces.ply", "3 0 1 3\n", "3 0 1 4\n", "corner of face 1"),
        ("faces.ply", "3 0 1 3\n", "3 0 1 -3\n", "corner of face 1"),
        ("faces.ply", "3 0 1 3\n", "200 0 1 3\n", "faces.ply"),
    ] {
        assert_refused(case);
    }
}

#[test]
fn meshes_without_cells_are_refused_by_name() {
    for case in [
        (
            "cells.vtk",
            "CELLS 2 14\n8 0 1 3 2 4 5 7 6\n4 0 1 2 4\nCELL_TYPES 2\n12 10\n",
            "CELLS 0 0\nCELL_TYPES 0\n",
            "cell",
        ),
        // Types that nobody knows.
        ("cells.vtk", "\n12 10\n", "\n199 200\n", "cell"),
        (
            "text.vtu",
            "NumberOfCells=\"2\"",
            "NumberOfCells=\"0\"",
            "expected 0 numbers",
        ),
        (
            "text.vtr",
            "Piece Extent=\"0 1 0 1 0 1\"",
            "Piece Extent=\"0 -1 0 1 0 1\"",
            "Extent",
        ),
        ("block.vtk", "DIMENSIONS 2 2 2", "DIMENSIONS 0 2 2", "mesh dims"),
        // Corners in one place.
        (
            "faces.vtk",
            "4 0 1 3 2\n3 4 5 6\n",
            "4 0 0 0 0\n3 4 4 4\n",
            "area",
        ),
    ] {
        assert_refused(case);
    }
    // Surfaces without faces are clouds of their points.
    for (name, from, to, points) in [
        ("faces.vtk", "POLYGONS 2 9\n4 0 1 3 2\n3 4 5 6\n", "", 8),
        ("text.vtp", "NumberOfPolys=\"2\"", "NumberOfPolys=\"0\"", 8),
        (
            "faces.ply",
            "element face 2\nproperty list uchar int vertex_indices\n",
            "",
            4,
        ),
    ] {
        let mut bytes = changed(name, from, to);
        if name == "faces.ply" {
            bytes.truncate(bytes.len() - "3 0 1 2\n3 0 1 3\n".len());
        }
        let data = read(name, &bytes).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(counts(&data), [points, 0], "{name}");
    }
}

/// One point far from the others: as many cells as before, and no more discs than small files may become.
#[test]
fn a_point_far_away_costs_no_memory() {
    alone!();
    for far in ["1e9", "-1e30", "1e-30"] {
        for (name, from, to) in [
            ("cells.vtk", "float\n0 0 0 ", "float\n0 FAR 0 "),
            ("block.vtk", "float\n0 0 0 ", "float\nFAR 0 0 "),
            (
                "axes.vtk",
                "Z_COORDINATES 2 float\n0 4\n",
                "Z_COORDINATES 2 float\nFAR 4\n",
            ),
            ("text.vtr", ">0 1.5<", ">FAR 1.5<"),
            ("text.vtu", ">0 0 0 1 0 0", ">0 FAR 0 1 0 0"),
            ("faces.vtk", "float\n0 0 0 ", "float\n0 FAR 0 "),
            ("text.vtp", ">0 0 0 1 0 0", ">0 FAR 0 1 0 0"),
            ("faces.ply", "\n0 0 1 0 1 0 9 9 9\n", "\n0 0 FAR 0 1 0 9 9 9\n"),
        ] {
            let data = read(name, &changed(name, from, &to.replace("FAR", far)));
            let data = data.unwrap_or_else(|error| panic!("{far}: {error}"));
            let whole = read(name, &changed(name, from, from)).unwrap();
            match data {
                Data::Mesh(_) => assert_eq!(counts(&data), counts(&whole), "{name}: {far}"),
                _ => assert!((1..=DISCS).contains(&counts(&data)[0]), "{name}: {far}"),
            }
        }
    }
    check_memory(MEMORY);
}

#[test]
fn points_that_are_nowhere_are_refused_by_name() {
    for nowhere in ["nan", "inf", "1e300"] {
        for (name, from, to) in [
            ("cells.vtk", "float\n0 0 0 ", "float\n0 NOWHERE 0 "),
            ("block.vtk", "float\n0 0 0 ", "float\nNOWHERE 0 0 "),
            ("text.vtu", ">0 0 0 1 0 0", ">0 NOWHERE 0 1 0 0"),
            ("faces.vtk", "float\n0 0 0 ", "float\n0 NOWHERE 0 "),
            ("text.vtp", ">0 0 0 1 0 0", ">0 NOWHERE 0 1 0 0"),
        ] {
            assert_refused((name, from, &to.replace("NOWHERE", nowhere), ""));
        }
    }
}

#[test]
fn meshes_are_no_volumes_and_their_data_sets_are_named() {
    let folder = tempfile::tempdir().unwrap();
    for (name, kind) in [
        ("cells.vtk", "UNSTRUCTURED_GRID"),
        ("axes.vtk", "RECTILINEAR_GRID"),
        ("block.vtk", "STRUCTURED_GRID"),
        ("faces.vtk", "POLYDATA"),
    ] {
        let path: &Path = &folder.path().join(name);
        std::fs::write(path, changed(name, kind, kind)).unwrap();
        let error = read_volume(path, &ReadOptions::default()).unwrap_err();
        assert!(matches!(error, IoError::Unsupported { .. }), "{error}");
        assert!(error.to_string().contains(&format!("data set {kind}")), "{error}");
    }
}
