//! Legacy VTK structured points: real files, both codings, every type, other attributes, and malformed files.

use std::path::Path;

use crate::common::{Expected, assert_expected, flips, load, read_bytes, shared_volumes, truncations};
use glam::DVec3;
use splatvol_io::{IoError, Loaded, ReadOptions, read_volume};
use splatvol_scene::Samples;

#[test]
fn real_files_hold_what_is_known_of_them() {
    let Some(folder) = shared_volumes() else { return };
    let iron = load(&folder.join("ironProt.vtk"));
    let expected = Expected {
        dims: [68; 3],
        spacing: [1.0; 3],
        values: [0.0, 255.0, 13.1383],
        sample_type: "u8",
    };
    assert_expected("ironProt", &iron, &expected);
    assert_eq!(iron.description.format, "legacy VTK 1.0");
    let carotid = load(&folder.join("carotid.vtk"));
    let expected = Expected {
        dims: [76, 49, 45],
        spacing: [1.0; 3],
        values: [0.0, 580.0, 99.0491],
        sample_type: "f32",
    };
    assert_expected("carotid", &carotid, &expected);
    assert_eq!(carotid.volume.grid().origin(), DVec3::new(100.0, 80.0, 1.0));
    assert_eq!(carotid.description.stored_type, "f32, big-endian");
    // The velocity that follows the scalars.
    let speed = with_array(&folder.join("carotid.vtk"), "vectors:magnitude");
    let speed = speed.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(speed.volume.samples().len(), 76 * 49 * 45);
}

#[test]
fn other_data_sets_are_named() {
    let Some(volumes) = shared_volumes() else { return };
    let folder = volumes.with_file_name("meshes");
    if !folder.is_dir() {
        return;
    }
    let cases = [
        ("hexa.vtk", "UNSTRUCTURED_GRID"),
        ("notch_stress.vtk", "UNSTRUCTURED_GRID"),
        ("RectGrid2.vtk", "RECTILINEAR_GRID"),
        ("SampleStructGrid.vtk", "STRUCTURED_GRID"),
    ];
    for (name, kind) in cases {
        let error = read_volume(folder.join(name), &ReadOptions::default()).unwrap_err();
        assert!(matches!(error, IoError::Unsupported { .. }), "{error}");
        assert!(error.to_string().contains(&format!("data set {kind}")), "{error}");
    }
}

fn with_array(path: &Path, array: &str) -> Result<Loaded, IoError> {
    let options = ReadOptions {
        array: Some(array.to_owned()),
        ..ReadOptions::default()
    };
    read_volume(path, &options)
}

/// Pieces of a file: text, and numbers in the requested coding.
#[derive(Clone)]
enum Part {
    Text(&'static str),
    Bytes(Vec<u8>),
    Shorts(Vec<i16>),
    Floats(Vec<f32>),
}

fn join<T: ToString>(values: &[T]) -> Vec<u8> {
    let words: Vec<String> = values.iter().map(T::to_string).collect();
    (words.join(" ") + "\n").into_bytes()
}

fn build(binary: bool, parts: &[Part]) -> Vec<u8> {
    let coding = if binary { "BINARY" } else { "ASCII" };
    let mut bytes = format!("# vtk DataFile Version 5.1\na title\n{coding}\n").into_bytes();
    for part in parts {
        match (part, binary) {
            (Part::Text(text), _) => bytes.extend(text.as_bytes()),
            (Part::Bytes(values), true) => bytes.extend(values),
            (Part::Bytes(values), false) => bytes.extend(join(values)),
            (Part::Shorts(values), true) => bytes.extend(values.iter().flat_map(|v| v.to_be_bytes())),
            (Part::Shorts(values), false) => bytes.extend(join(values)),
            (Part::Floats(values), true) => bytes.extend(values.iter().flat_map(|v| v.to_be_bytes())),
            (Part::Floats(values), false) => bytes.extend(join(values)),
        }
    }
    bytes
}

const SCALARS: [i16; 12] = [10, -11, 12, -13, 14, 15, 16, 17, 18, 19, 20, 30_000];

/// All parts that may surround the scalars, cell data first as VTK itself writes them.
fn parts() -> Vec<Part> {
    use Part::{Bytes, Floats, Shorts, Text};
    let floats = |count: usize| Floats((0..count).map(|i| i as f32 * 0.5).collect());
    vec![
        Text("DATASET STRUCTURED_POINTS\nFIELD FieldData 1\nTIME 1 1 float\n"),
        Floats(vec![0.25]),
        Text(
            "\nDIMENSIONS 3 2 2\nSPACING 1 2 3\nORIGIN -1 0 5e-1\nCELL_DATA 2\nSCALARS per%20cell unsigned_char 1\n",
        ),
        Text("LOOKUP_TABLE default\n"),
        Bytes(vec![65, 66]),
        Text("\nMETADATA\nINFORMATION 1\nNAME a LOCATION b\nDATA 1\n\nPOINT_DATA 12\nVECTORS flow float\n"),
        floats(36),
        Text("\nscalars height short\nlookup_table default\n"),
        Shorts(SCALARS.to_vec()),
        Text("\nMETADATA\nINFORMATION 0\n\nLOOKUP_TABLE palette 1\n"),
        Bytes(vec![1, 0, 0, 1]),
        Text("\nTEXTURE_COORDINATES uv 2 float\n"),
        floats(24),
        Text("\nTENSORS stress float\n"),
        floats(108),
        Text("\nFIELD more 2\nsingle 1 12 float\n"),
        floats(12),
        Text("\nMETADATA\nINFORMATION 0\n\npairs 2 12 short\n"),
        Shorts((0..24).collect()),
        Text("\nNORMALS last float\n"),
        floats(36),
    ]
}

#[test]
fn arrays_are_found_among_others_in_both_codings() {
    let folder = tempfile::tempdir().unwrap();
    for binary in [false, true] {
        let loaded = read_bytes(folder.path(), "a.vtk", &build(binary, &parts())).unwrap();
        assert_eq!(loaded.volume.samples(), &Samples::I16(SCALARS.to_vec().into()));
        let grid = loaded.volume.grid();
        assert_eq!(
            (grid.dims(), grid.spacing()),
            ([3, 2, 2], DVec3::new(1.0, 2.0, 3.0))
        );
        assert_eq!(grid.origin(), DVec3::new(-1.0, 0.0, 0.5));
        let read = |array: &str| with_array(&folder.path().join("a.vtk"), array).unwrap();
        let halves: Vec<f32> = (0..12).map(|i| i as f32 * 0.5).collect();
        assert_eq!(read("single").volume.samples(), &Samples::F32(halves.into()));
        assert_eq!(
            read("pairs:1").volume.samples(),
            &Samples::I16((0..12).map(|i| 2 * i + 1).collect())
        );
        let thirds: Vec<f32> = (0..12).map(|i| (3 * i + 2) as f32 * 0.5).collect();
        assert_eq!(read("last:2").volume.samples(), &Samples::F32(thirds.into()));
        let cells = read("per cell");
        assert_eq!(cells.volume.samples(), &Samples::U8(vec![65, 66].into()));
        assert_eq!(cells.volume.grid().origin(), DVec3::new(-0.5, 1.0, 2.0));
        let text = with_array(&folder.path().join("a.vtk"), "absent")
            .unwrap_err()
            .to_string();
        for name in [
            "no array `absent`",
            "`per cell` (1 x",
            "`flow` (3 x",
            "`stress` (9 x",
            "`pairs` (2 x",
        ] {
            assert!(text.contains(name), "{text}");
        }
    }
}

#[test]
fn what_follows_the_scalars_does_not_disturb() {
    let folder = tempfile::tempdir().unwrap();
    for (binary, tail) in [(true, "\nGARBAGE"), (false, "\nVECTORS v float\n1 2"), (true, "")] {
        let mut parts = parts();
        parts.truncate(9);
        let mut bytes = build(binary, &parts);
        bytes.extend(tail.as_bytes());
        let loaded = read_bytes(folder.path(), "a.vtk", &bytes).unwrap();
        assert_eq!(loaded.volume.samples(), &Samples::I16(SCALARS.to_vec().into()));
        assert!(loaded.description.warnings.is_empty());
    }
    // Cells that come first do not replace points that cannot be read, unless they are requested.
    let mut parts = parts();
    parts.truncate(5);
    let mut bytes = build(true, &parts);
    bytes.extend(b"\nPOINT_DATA 12\nSCALARS\n");
    assert!(read_bytes(folder.path(), "a.vtk", &bytes).is_err());
    let cells = with_array(&folder.path().join("a.vtk"), "per cell").unwrap();
    assert_eq!(cells.volume.samples(), &Samples::U8(vec![65, 66].into()));
    assert!(cells.description.warnings[0].contains("only the first arrays"));
}

#[test]
fn colours_are_bytes_in_both_codings() {
    let folder = tempfile::tempdir().unwrap();
    let grid = "DATASET STRUCTURED_POINTS\nDIMENSIONS 5 2 1\nORIGIN 0 0 0\nSPACING 1 1 1\nPOINT_DATA 10\n";
    let (colors, next) = (
        "COLOR_SCALARS rgb 1\n",
        "\nSCALARS other short\nLOOKUP_TABLE default\n",
    );
    // As VTK reads them, but for those outside, which are the nearest here.
    let text = "0 1 0.5 0.2 0.999 0.0025 0.00235 0.996 -1 7";
    let bytes = [0, 255, 128, 51, 255, 1, 1, 254, 0, 255];
    for binary in [false, true] {
        let values = if binary { bytes.to_vec() } else { text.into() };
        let head = build(binary, &[Part::Text(grid), Part::Text(colors)]);
        let tail = build(binary, &[Part::Shorts((0..10).collect())]);
        let tail = &tail[build(binary, &[]).len()..];
        let file = [&head, &values[..], next.as_bytes(), tail].concat();
        std::fs::write(folder.path().join("a.vtk"), file).unwrap();
        let read = |array: &str| with_array(&folder.path().join("a.vtk"), array).unwrap();
        assert_eq!(read("rgb").volume.samples(), &Samples::U8(bytes.to_vec().into()));
        // What follows is found.
        assert_eq!(read("other").volume.samples(), &Samples::I16((0..10).collect()));
    }
}

#[test]
fn every_type_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let read = |binary: bool, name: &str, data: &[u8]| {
        let coding = if binary { "BINARY" } else { "ASCII" };
        let mut bytes = format!(
            "# vtk DataFile Version 2.0\r\n\r\n{coding}\r\nDATASET STRUCTURED_POINTS\r\nDIMENSIONS 3 1 1\r\n\
             POINT_DATA 3\r\nSCALARS a {name}\r\nLOOKUP_TABLE default\r\n"
        )
        .into_bytes();
        bytes.extend(data);
        read_bytes(folder.path(), "a.vtk", &bytes).map(|loaded| loaded.volume.samples().clone())
    };
    macro_rules! check {
        ($($name:literal $type:ty => $variant:ident $stored:ty;)*) => {$(
            let values: [$type; 3] = [<$type>::MIN, <$type>::MAX, 5 as $type];
            let expected = Samples::$variant(values.iter().map(|&value| value as $stored).collect());
            let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_be_bytes()).collect();
            assert_eq!(read(true, $name, &bytes).unwrap(), expected, "{}", $name);
            assert_eq!(read(false, $name, &join(&values)).unwrap(), expected, "{}", $name);
        )*};
    }
    check! {
        "char" i8 => I8 i8;
        "unsigned_char" u8 => U8 u8;
        "short" i16 => I16 i16;
        "unsigned_short" u16 => U16 u16;
        "int" i32 => I32 i32;
        "vtkIdType" i32 => I32 i32;
        "unsigned_int" u32 => U32 u32;
        "long" i64 => F64 f64;
        "vtktypeint64" i64 => F64 f64;
        "unsigned_long" u64 => F64 f64;
        "float" f32 => F32 f32;
    }
    let doubles: Vec<u8> = [1e300, -1.0, 0.5f64]
        .iter()
        .flat_map(|value| value.to_be_bytes())
        .collect();
    assert_eq!(
        read(true, "double", &doubles).unwrap(),
        Samples::F64(vec![1e300, -1.0, 0.5].into())
    );
    assert_eq!(
        read(false, "DOUBLE 1", b"1e300 -1 .5").unwrap(),
        Samples::F64(vec![1e300, -1.0, 0.5].into())
    );
    assert_eq!(
        read(true, "bit", &[0b1010_0000]).unwrap(),
        Samples::U8(vec![1, 0, 1].into())
    );
    assert_eq!(
        read(false, "bit", b"1 0 1").unwrap(),
        Samples::U8(vec![1, 0, 1].into())
    );
    for (name, data) in [
        ("string", &b"a b c"[..]),
        ("float 3", b"1 2 3 4 5 6 7 8 9"),
        ("float 0", b"1 2 3"),
        ("float x", b"1 2 3"),
        ("unsigned_char", b"1 2 256"),
        ("short", b"1 99999 3"),
        ("float", b"1 2 1e39"),
        ("float", b"1 2"),
        ("float", b"1 two 3"),
        ("", b"1 2 3"),
    ] {
        assert!(read(false, name, data).is_err(), "{name}");
    }
}

#[test]
fn malformed_headers_name_the_field() {
    let folder = tempfile::tempdir().unwrap();
    let good = String::from_utf8(build(false, &parts())).unwrap();
    let cases = [
        ("Version 5.1", "Version 6.0", "magic"),
        ("Version 5.1", "Version", "magic"),
        ("ASCII", "TEXT", "coding"),
        ("STRUCTURED_POINTS", "POLYDATA", "POLYDATA"),
        ("STRUCTURED_POINTS", "CUBES", "DATASET"),
        ("DIMENSIONS 3 2 2", "DIMENSIONS 3 2", "DIMENSIONS"),
        ("DIMENSIONS 3 2 2", "DIMENSIONS 3 0 2", "DIMENSIONS"),
        ("DIMENSIONS 3 2 2", "DIMENSIONS 3 -2 2", "DIMENSIONS"),
        ("DIMENSIONS 3 2 2", "", "DIMENSIONS"),
        (
            "DIMENSIONS 3 2 2",
            "DIMENSIONS 3 2 9223372036854775807",
            "cell data",
        ),
        (
            "DIMENSIONS 3 2 2",
            "DIMENSIONS 3 2 99999999999999999999",
            "DIMENSIONS",
        ),
        ("DIMENSIONS 3 2 2", "EXTENT 0 2 0 1 0 1", "keyword"),
        ("SPACING 1 2 3", "SPACING 1 NaN 3", "spacing"),
        ("SPACING 1 2 3", "SPACING 0 2 3", "spacing"),
        ("SPACING 1 2 3", "SPACING 1 1e40 3", "spacing"),
        ("ORIGIN -1 0 5e-1", "ORIGIN -1 0 inf", "origin"),
        ("ORIGIN -1 0 5e-1", "ORIGIN -1 0", "ORIGIN"),
        ("POINT_DATA 12", "POINT_DATA 13", "point data"),
        ("CELL_DATA 2", "CELL_DATA 12", "cell data"),
        ("TIME 1 1 float", "TIME 1 18446744073709551615 float", "data"),
        ("TIME 1 1 float", "TIME 1 1 string", "strings"),
    ];
    for (from, to, field) in cases {
        assert!(good.contains(from), "{from} is not in the file");
        let bytes = good.replacen(from, to, 1).into_bytes();
        let error = read_bytes(folder.path(), "a.vtk", &bytes);
        let text = error.expect_err(to).to_string();
        assert!(text.contains(field), "{to}: {text}");
    }
    let vast = "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 65535 65535 1\n\
                POINT_DATA 4294836225\nSCALARS a float\nLOOKUP_TABLE default\n1234";
    let text = read_bytes(folder.path(), "a.vtk", vast.as_bytes())
        .unwrap_err()
        .to_string();
    assert!(text.contains("samples need 17179344900 bytes"), "{text}");
    let long = format!("# vtk DataFile Version 3.0\n{}", "x".repeat(10_000));
    let text = read_bytes(folder.path(), "a.vtk", long.as_bytes())
        .unwrap_err()
        .to_string();
    assert!(text.contains("title"), "{text}");
}

#[test]
fn truncated_and_damaged_files_never_panic() {
    for binary in [false, true] {
        let bytes = build(binary, &parts());
        assert!(flips("a.vtk", &bytes, 450) > 100);
        let header =
            "DATASET STRUCTURED_POINTS\nDIMENSIONS 3 2 2\nPOINT_DATA 12\nSCALARS a short\nLOOKUP_TABLE b\n";
        let header = [Part::Text(header)];
        let length = build(binary, &header).len();
        let bytes = build(binary, &[&header[..], &[Part::Shorts(SCALARS.to_vec())]].concat());
        truncations("a.vtk", &bytes, length + 20);
    }
}

#[test]
fn a_last_number_that_may_be_cut_is_worth_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let text = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 1 1\n\
                POINT_DATA 2\nSCALARS a short 1\nLOOKUP_TABLE default\n12 345";
    let loaded = read_bytes(folder.path(), "a.vtk", text.as_bytes()).unwrap();
    assert_eq!(loaded.volume.samples(), &Samples::I16(vec![12, 345].into()));
    assert!(loaded.description.warnings[0].contains("right after the last number"));
    let loaded = read_bytes(folder.path(), "a.vtk", format!("{text}\n").as_bytes()).unwrap();
    assert!(loaded.description.warnings.is_empty());
}

#[test]
fn an_axis_with_one_sample_needs_no_spacing() {
    let folder = tempfile::tempdir().unwrap();
    let text = "# vtk DataFile Version 3.4\nflat\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 1\n\
        ORIGIN 0 0 3\nSPACING 0.5 2 0\nPOINT_DATA 4\nSCALARS a float 1\nLOOKUP_TABLE default\n1 2 3 4\n";
    let loaded = read_bytes(folder.path(), "a.vtk", text.as_bytes()).unwrap();
    let map = loaded.volume.grid().world_from_voxel();
    assert_eq!(map.matrix3.z_axis.z, 0.5);
    assert_eq!(map.translation.z, 3.0);
}
