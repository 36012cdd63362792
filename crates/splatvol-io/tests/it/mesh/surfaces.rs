//! Surfaces of VTK: flat cells of unstructured grids, and colours by values.

use std::path::Path;

use splatvol_io::{
    DataKind, DataOptions, IoError, LoadedPoints, ReadOptions, data_kind, read_data, read_points,
};

/// Two squares side by side in every kind of flat cell that has corners of its own; the second one lies higher.
fn legacy(cells: &str, types: &str, data: &str) -> String {
    let points = "POINTS 8 float\n0 0 0 1 0 0 1 1 0 0 1 0 2 0 5 3 0 5 3 1 5 2 1 5\n";
    let lists: Vec<&str> = cells.split(';').collect();
    let words: usize = lists.iter().map(|list| list.split_whitespace().count()).sum();
    let (count, cells) = (lists.len(), lists.join("\n"));
    format!(
        "# vtk DataFile Version 3.0\nflat\nASCII\nDATASET UNSTRUCTURED_GRID\n{points}CELLS {count} {words}\n{cells}\n\
         CELL_TYPES {count}\n{types}\n{data}"
    )
}

const XML: &str = r#"<VTKFILE_ type="UnstructuredGrid" version="0.1" byte_order="LittleEndian"><UnstructuredGrid>
    <Piece NumberOfPoints="4" NumberOfCells="2">
    <PointData Scalars="t"><DataArray type="Float32" Name="t" format="ascii">0 1 1 0</DataArray></PointData>
    <CellData><DataArray type="Int32" Name="part" format="ascii">7 9</DataArray></CellData>
    <Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 1 1 0 0 1 0</DataArray></Points>
    <Cells><DataArray type="Int64" Name="connectivity" format="ascii">0 1 2 0 2 3</DataArray>
    <DataArray type="Int64" Name="offsets" format="ascii">3 6</DataArray>
    <DataArray type="UInt8" Name="types" format="ascii">5 5</DataArray></Cells></Piece></UnstructuredGrid></VTKFILE_>"#;

fn write(folder: &Path, name: &str, text: &str) -> std::path::PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, text.replace("VTKFILE_", "VTKFile")).unwrap();
    path
}

fn load(name: &str, text: &str, array: Option<&str>) -> Result<LoadedPoints, IoError> {
    let folder = tempfile::tempdir().unwrap();
    let path = write(folder.path(), name, text);
    let kind = data_kind(&path, &DataOptions::default()).unwrap();
    assert_eq!(kind, DataKind::Points, "{text}");
    let options = ReadOptions {
        array: array.map(str::to_owned),
        ..ReadOptions::default()
    };
    read_points(&path, &options)
}

fn area(loaded: &LoadedPoints) -> f64 {
    let radii = loaded.points.attributes().radii.iter();
    radii.map(|radius| f64::from(*radius).powi(2)).sum()
}

/// Colours of the discs, those of the first square and those of the second.
fn colors(loaded: &LoadedPoints) -> [Vec<[u8; 4]>; 2] {
    let places = loaded.points.positions().iter();
    let of = |high: bool| {
        let pairs = places.clone().zip(&loaded.points.attributes().colors);
        pairs
            .filter(|(place, _)| (place[2] > 2.0) == high)
            .map(|(_, color)| *color)
            .collect()
    };
    [of(false), of(true)]
}

/// Ends of viridis.
const LOW: [u8; 4] = [68, 1, 84, 255];
const HIGH: [u8; 4] = [253, 231, 37, 255];

#[test]
fn flat_cells_of_every_kind_are_a_surface() {
    for (cells, types) in [
        ("3 0 1 2;3 0 2 3;4 4 5 6 7", "5 5 9"),
        ("4 0 1 2 3;4 4 5 7 6", "7 8"),
        ("4 0 1 3 2;1 0;2 0 1;4 4 5 7 6", "6 1 3 6"),
        ("6 0 1 2 4 5 6;6 0 2 3 4 5 6;8 4 5 6 7 0 1 2 3", "22 22 23"),
        ("8 0 1 2 3 4 5 6 7;4 4 5 6 7", "36 9"),
    ] {
        let loaded = load("a.vtk", &legacy(cells, types, ""), None).unwrap();
        assert!((area(&loaded) - 2.0).abs() < 1e-3, "{types}: {}", area(&loaded));
        assert!(loaded.points.attributes().colors.is_empty());
    }
    assert!((area(&load("a.vtu", XML, None).unwrap()) - 1.0).abs() < 1e-3);
}

#[test]
fn solid_cells_among_flat_ones_are_a_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let data = "POINT_DATA 8\nSCALARS t float\nLOOKUP_TABLE default\n0 1 2 3 4 5 6 7\n";
    let text = legacy("4 0 1 2 5;3 0 1 2", "10 5", data);
    let path = write(folder.path(), "a.vtk", &text);
    assert_eq!(data_kind(&path, &DataOptions::default()).unwrap(), DataKind::Mesh);
}

#[test]
fn values_of_cells_colour_their_polygons() {
    let data = "CELL_DATA 3\nSCALARS part int\nLOOKUP_TABLE default\n8 0 2\n";
    // The line's value is nobody's colour, and not part of the range.
    let loaded = load("a.vtk", &legacy("4 0 1 2 3;2 0 1;4 4 5 6 7", "9 3 9", data), None).unwrap();
    let [low, high] = colors(&loaded);
    assert!(!low.is_empty() && low.iter().all(|color| *color == HIGH));
    assert!(!high.is_empty() && high.iter().all(|color| *color == LOW));
    assert!(
        loaded
            .description
            .stored_type
            .contains("coloured by `part` from 2 to 8")
    );
    let [both, _] = colors(&load("a.vtu", XML, Some("part")).unwrap());
    assert!(both.contains(&LOW) && both.contains(&HIGH) && both.len() > 2);
    assert!(both.iter().all(|color| *color == LOW || *color == HIGH));
}

#[test]
fn values_of_points_are_interpolated() {
    let loaded = load("a.vtu", XML, None).unwrap();
    // t is x: discs at the same x have the same colour, and green rises with it in viridis.
    let discs = loaded
        .points
        .positions()
        .iter()
        .zip(&loaded.points.attributes().colors);
    let mut discs: Vec<_> = discs.map(|(place, color)| (place[0], color[1])).collect();
    discs.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert!(discs.windows(2).all(|pair| pair[0].1 <= pair[1].1));
    assert!(discs[0].1 < 10 && discs[discs.len() - 1].1 > 220);
}

#[test]
fn arrays_are_chosen_by_name() {
    let error = load("a.vtu", XML, Some("u")).unwrap_err().to_string();
    assert!(
        error.contains("no array `u`") && error.contains("`part`"),
        "{error}"
    );
    let data = "POINT_DATA 8\nSCALARS t float\nLOOKUP_TABLE default\n1 1 1 1 1 1 1 1\nSCALARS u float\n\
        LOOKUP_TABLE default\n0 0 nan 0 1 1 1 1\n";
    let text = legacy("4 0 1 2 3;4 4 5 6 7", "9 9", data);
    // A constant that nobody asked for says nothing, and so does the surface.
    let plain = load("a.vtk", &text, None).unwrap();
    assert!(plain.points.attributes().colors.is_empty() && plain.description.warnings.is_empty());
    let asked = load("a.vtk", &text, Some("t")).unwrap();
    assert!(asked.description.warnings[0].contains("one value everywhere"));
    let missing = load("a.vtk", &text, Some("u")).unwrap();
    assert!(missing.description.warnings[0].starts_with("1 values of `u` are NaN"));
    assert!(colors(&missing)[0].contains(&[128, 128, 128, 255]));
    // Polygonal data: vertices and lines come before the polygons.
    let poly = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n0 0 0 1 0 0 1 1 0 0 1 0\n\
        VERTICES 1 2\n1 0\nPOLYGONS 1 4\n3 0 1 2\nTRIANGLE_STRIPS 1 4\n3 0 2 3\nCELL_DATA 3\nSCALARS part float\n\
        LOOKUP_TABLE default\n100 1 3\n";
    let [low, _] = colors(&load("a.vtk", poly, None).unwrap());
    assert!(low.contains(&LOW) && low.contains(&HIGH));
    // Other clouds have no arrays.
    let folder = tempfile::tempdir().unwrap();
    let path = write(folder.path(), "a.xyz", "0 0 0\n1 1 1\n");
    let options = ReadOptions {
        array: Some("t".to_owned()),
        ..ReadOptions::default()
    };
    assert!(
        read_points(&path, &options)
            .unwrap_err()
            .to_string()
            .contains("no such choice")
    );
}

#[test]
fn broken_flat_cells_are_refused() {
    let refused = |text: &str, why: &str| {
        let folder = tempfile::tempdir().unwrap();
        let path = write(folder.path(), "a.vtk", text);
        let error = read_data(&path, &DataOptions::default()).unwrap_err().to_string();
        assert!(error.contains(why) && error.contains("a.vtk"), "{error}");
    };
    refused(&legacy("4 0 1 2 8;3 0 1 2", "9 5", ""), "below 8");
    refused(&legacy("3 0 1 2;3 0 1 2", "5", ""), "expected 2 numbers");
    refused(&legacy("3 0 0 0", "5", ""), "at least one that has an area");
}
