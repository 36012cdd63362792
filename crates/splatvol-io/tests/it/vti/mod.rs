//! VTK XML image data: real files, every coding, geometry, choice of arrays, and malformed files.

mod malformed;

use std::path::Path;

use crate::common::vti_file::{File, IMAGE, Style, file, values};
use crate::common::{Expected, assert_expected, load, read_bytes, shared_volumes};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;
use sha2::{Digest, Sha256};
use splatvol_io::{IoError, Loaded, ReadOptions, read_volume};
use splatvol_scene::Samples;

fn expected(dims: [usize; 3], values: [f64; 3]) -> Expected {
    Expected {
        dims,
        spacing: [1.0; 3],
        values,
        sample_type: "u8",
    }
}

fn sha256(samples: &Samples) -> String {
    let Samples::U8(bytes) = samples else {
        panic!("not u8")
    };
    Sha256::digest(bytes)
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

#[test]
fn real_files_hold_what_is_known_of_them() {
    let Some(folder) = shared_volumes() else { return };
    let bonsai = load(&folder.join("bonsai.vti"));
    assert_expected("bonsai", &bonsai, &expected([256; 3], [0.0, 255.0, 13.7114]));
    assert_eq!(
        sha256(bonsai.volume.samples()),
        "288d2818cffb50d2e2c9e3b5b0a2520d09b0f5051bb63cca315f3fc7a894af80"
    );
    assert_eq!(
        bonsai.description.stored_type,
        "u8, little-endian, appended raw, zlib"
    );
    let engine = load(&folder.join("engine.vti"));
    assert_expected(
        "engine",
        &engine,
        &expected([256, 256, 128], [0.0, 255.0, 22.3488]),
    );
    assert_eq!(
        sha256(engine.volume.samples()),
        "15cf29cdde69cd6c8b5ab9eeef4d1bb21f276056da4111cb5069ebfbe5b6ff90"
    );
    let chest = load(&folder.join("LIDC2.vti"));
    let known = Expected {
        spacing: [1.40625, 1.40625, 2.5],
        ..expected([256, 256, 133], [0.0, 255.0, 7.0545])
    };
    assert_expected("LIDC2", &chest, &known);
    let meta_image = load(&folder.join("LIDC2.mha"));
    assert_eq!(chest.volume.samples(), meta_image.volume.samples());
    let hydrogen = load(&folder.join("hydrogen.vti"));
    let known = Expected {
        sample_type: "f32",
        ..expected([64; 3], [0.0, 1.0, 0.0185])
    };
    assert_expected("hydrogen", &hydrogen, &known);
    assert_eq!(
        hydrogen.description.stored_type,
        "f32, little-endian, inline base64, zlib"
    );
}

fn with_array(folder: &Path, bytes: &[u8], array: &str) -> Result<Loaded, IoError> {
    let path = folder.join("a.vti");
    std::fs::write(&path, bytes).unwrap();
    let options = ReadOptions {
        array: Some(array.to_owned()),
        ..ReadOptions::default()
    };
    read_volume(&path, &options)
}

#[test]
fn every_coding_gives_the_same_volume() {
    let folder = tempfile::tempdir().unwrap();
    for style in Style::all() {
        let bytes = file(style);
        let loaded = read_bytes(folder.path(), "a.vti", &bytes).unwrap_or_else(|e| panic!("{style:?}: {e}"));
        assert_eq!(
            loaded.volume.samples(),
            &Samples::I16(values().into()),
            "{style:?}"
        );
        let third = with_array(folder.path(), &bytes, "third").unwrap_or_else(|e| panic!("{style:?}: {e}"));
        assert_eq!(
            third.volume.samples(),
            &Samples::U8(vec![7; 24].into()),
            "{style:?}"
        );
    }
}

#[test]
fn header_and_data_may_be_encoded_apart() {
    let folder = tempfile::tempdir().unwrap();
    for wide in [false, true] {
        let style = Style { wide, ..Style::PLAIN };
        let mut file = File::new(style, IMAGE);
        file.point_i16("Name=\"a\"", &values());
        let bytes = String::from_utf8(file.bytes("")).unwrap();
        let plain: Vec<u8> = values().iter().flat_map(|value| value.to_le_bytes()).collect();
        let [header, data] = style.parts(&plain);
        let joint = STANDARD.encode([header.clone(), data.clone()].concat());
        let apart = STANDARD.encode(header) + &STANDARD.encode(data);
        let changed = bytes.replace(&joint, &apart);
        assert_ne!(bytes, changed);
        let loaded = read_bytes(folder.path(), "a.vti", changed.as_bytes()).unwrap();
        assert_eq!(loaded.volume.samples(), &Samples::I16(values().into()));
    }
}

#[test]
fn every_type_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, little: &[u8], big: bool| {
        let style = Style { big, ..Style::PLAIN };
        let mut file = File::new(style, "WholeExtent=\"0 1 0 0 0 0\"");
        file.point = file.array(
            &format!("type=\"{name}\" Name=\"a\""),
            little,
            little.len() / 2,
            "",
        );
        file.bytes("")
    };
    macro_rules! check {
        ($($name:literal $type:ty => $variant:ident $stored:ty;)*) => {$(
            let values: [$type; 2] = [<$type>::MAX, 3 as $type];
            let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
            for big in [false, true] {
                let loaded = read_bytes(folder.path(), "a.vti", &file($name, &bytes, big)).unwrap();
                let expected = Samples::$variant(values.iter().map(|&value| value as $stored).collect());
                assert_eq!(loaded.volume.samples(), &expected, "{}", $name);
            }
        )*};
    }
    check! {
        "Int8" i8 => I8 i8;
        "UInt8" u8 => U8 u8;
        "Int16" i16 => I16 i16;
        "UInt16" u16 => U16 u16;
        "Int32" i32 => I32 i32;
        "UInt32" u32 => U32 u32;
        "Int64" i64 => F64 f64;
        "UInt64" u64 => F64 f64;
        "Float32" f32 => F32 f32;
        "Float64" f64 => F64 f64;
    }
}

#[test]
fn extents_shift_the_origin_and_cells_lie_half_a_spacing_further() {
    let folder = tempfile::tempdir().unwrap();
    // Rows of the direction: voxel x runs along world y.
    let image =
        "WholeExtent=\"2 4 -1 0 5 5\" Origin=\"10 20 30\" Spacing=\"1 2 3\" Direction=\"0 -1 0 1 0 0 0 0 1\"";
    let mut file = File::new(Style::PLAIN, image);
    file.point_i16("Name=\"points\"", &[1, 2, 3, 4, 5, 6]);
    file.cell_u8("Name=\"cells\"", &[8, 9]);
    let bytes = file.bytes("");
    let points = read_bytes(folder.path(), "a.vti", &bytes).unwrap();
    let grid = points.volume.grid();
    assert_eq!(grid.dims(), [3, 2, 1]);
    assert_eq!(grid.origin(), DVec3::new(12.0, 22.0, 45.0));
    assert_eq!(grid.direction().x_axis, DVec3::Y);
    assert_eq!(grid.direction().y_axis, DVec3::NEG_X);
    let cells = with_array(folder.path(), &bytes, "cells").unwrap();
    let grid = cells.volume.grid();
    assert_eq!(grid.dims(), [2, 1, 1]);
    assert_eq!(grid.origin(), DVec3::new(11.0, 22.5, 45.0));
    assert!(cells.description.orientation.contains("cell data"));
}

#[test]
fn vectors_are_refused_unless_a_component_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = File::new(Style::PLAIN, "WholeExtent=\"0 1 0 0 0 0\"");
    file.point_i16("Name=\"flow:x\" NumberOfComponents=\"3\"", &[3, 4, 0, 6, 8, 24]);
    let bytes = file.bytes(" Scalars=\"flow:x\"");
    let refused = read_bytes(folder.path(), "a.vti", &bytes)
        .unwrap_err()
        .to_string();
    assert!(
        refused.contains("`flow:x` (3 x Int16, point data) is not a scalar"),
        "{refused}"
    );
    let read =
        |array: &str| with_array(folder.path(), &bytes, array).map(|loaded| loaded.volume.samples().clone());
    assert_eq!(read("flow:x:1").unwrap(), Samples::I16(vec![4, 8].into()));
    assert_eq!(
        read("flow:x:magnitude").unwrap(),
        Samples::F32(vec![5.0, 26.0].into())
    );
    for bad in ["flow:x", "flow:x:3", "flow:x:-1", "flow", "x:0"] {
        let text = read(bad).unwrap_err().to_string();
        assert!(text.contains("flow:x"), "{text}");
    }
    let options = ReadOptions {
        component: Some(2),
        ..ReadOptions::default()
    };
    let loaded = read_volume(folder.path().join("a.vti"), &options).unwrap();
    assert_eq!(loaded.volume.samples(), &Samples::I16(vec![0, 24].into()));
}
