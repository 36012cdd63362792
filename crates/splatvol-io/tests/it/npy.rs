//! Arrays and archives of numpy: a real file, every type, both orders, round trips, and malformed files.

use std::io::{Cursor, Write};
use std::path::Path;

use crate::common::{Expected, assert_expected, flips, load, read_bytes, shared_volumes, truncations};
use glam::DVec3;
use splatvol_io::{IoError, Loaded, ReadOptions, WriteOptions, read_volume, write_volume};
use splatvol_scene::{Grid, LengthUnit, Rescale, Samples, Volume};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

#[test]
fn stent_is_read_from_its_archive() {
    let Some(folder) = shared_volumes() else { return };
    let stent = load(&folder.join("stent.npz"));
    let expected = Expected {
        dims: [128, 128, 256],
        spacing: [1.0; 3],
        values: [0.0, 2000.0, 35.3982],
        sample_type: "i16",
    };
    assert_expected("stent", &stent, &expected);
    assert_eq!(stent.description.stored_type, "i16, little-endian");
}

fn npy(version: u8, descr: &str, fortran: bool, shape: &str, data: &[u8]) -> Vec<u8> {
    let order = if fortran { "True" } else { "False" };
    let text = format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}\n");
    let length = text.len() as u32;
    let length = &length.to_le_bytes()[..if version == 1 { 2 } else { 4 }];
    [b"\x93NUMPY", &[version, 0][..], length, text.as_bytes(), data].concat()
}

#[test]
fn every_type_is_read_in_both_byte_orders() {
    let folder = tempfile::tempdir().unwrap();
    macro_rules! check {
        ($($code:literal $type:ty => $variant:ident $stored:ty;)*) => {$(
            let values: Vec<$type> = vec![<$type>::MIN, 1 as $type, <$type>::MAX, 7 as $type, 0 as $type, 100 as $type];
            let expected = Samples::$variant(values.iter().map(|&value| value as $stored).collect());
            let little: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
            let big: Vec<u8> = values.iter().flat_map(|value| value.to_be_bytes()).collect();
            for (version, mark, data) in [(1, '<', &little), (2, '>', &big), (3, '<', &little)] {
                let bytes = npy(version, &format!("{mark}{}", $code), false, "(1, 2, 3)", data);
                let loaded = read_bytes(folder.path(), "a.npy", &bytes).unwrap();
                assert_eq!(loaded.volume.samples(), &expected, "{mark}{}", $code);
                assert_eq!(loaded.volume.grid().dims(), [3, 2, 1]);
            }
        )*};
    }
    check! {
        "u1" u8 => U8 u8;
        "i1" i8 => I8 i8;
        "u2" u16 => U16 u16;
        "i2" i16 => I16 i16;
        "u4" u32 => U32 u32;
        "i4" i32 => I32 i32;
        "u8" u64 => F64 f64;
        "i8" i64 => F64 f64;
        "f4" f32 => F32 f32;
    }
    let read = |descr: &str, data: &[u8]| {
        let bytes = npy(1, descr, false, "(2,)", data);
        read_bytes(folder.path(), "a.npy", &bytes).map(|loaded| loaded.volume.samples().clone())
    };
    assert_eq!(
        read(">f8", &[1.5f64.to_be_bytes(), 2.5f64.to_be_bytes()].concat()).unwrap(),
        Samples::F64(vec![1.5, 2.5].into())
    );
    assert_eq!(read("|b1", &[0, 1]).unwrap(), Samples::U8(vec![0, 1].into()));
    // Binary16: 1.5, and the smallest positive number.
    assert_eq!(
        read("<f2", &[0x00, 0x3e, 0x01, 0x00]).unwrap(),
        Samples::F32(vec![1.5, 2f32.powi(-24)].into())
    );
    for refused in ["|O", "<c16", "<U3", "|S4", "<M8[ns]", "<f16", "", "<", "é"] {
        assert!(read(refused, &[0; 64]).is_err(), "{refused}");
    }
}

#[test]
fn the_contiguous_axis_is_x() {
    let folder = tempfile::tempdir().unwrap();
    let data: Vec<u8> = (0..24).collect();
    let read = |fortran, shape| {
        let loaded = read_bytes(folder.path(), "a.npy", &npy(1, "|u1", fortran, shape, &data)).unwrap();
        assert_eq!(loaded.volume.samples(), &Samples::U8(data.clone().into()));
        (loaded.volume.grid().dims(), loaded.description.orientation)
    };
    assert_eq!(read(false, "(2, 3, 4)").0, [4, 3, 2]);
    assert!(
        read(false, "(2, 3, 4)")
            .1
            .starts_with("C order: axes are (z, y, x)")
    );
    assert_eq!(read(true, "(2, 3, 4)").0, [2, 3, 4]);
    assert!(
        read(true, "(2, 3, 4)")
            .1
            .starts_with("Fortran order: axes are (x, y, z)")
    );
    assert_eq!(read(false, "(4, 6)").0, [6, 4, 1]);
    assert_eq!(read(true, "(4, 6)").0, [4, 6, 1]);
    assert_eq!(read(false, "(24,)").0, [24, 1, 1]);
}

fn volume(samples: Samples, rescale: Rescale) -> Volume {
    let grid = Grid::centred([3, 2, 1], DVec3::ONE).unwrap();
    Volume::new(grid, samples, rescale, LengthUnit::Unknown).unwrap()
}

fn round_trip(volume: &Volume) -> Samples {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.npy");
    write_volume(&path, volume, &WriteOptions::default()).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let header = u16::from_le_bytes([bytes[8], bytes[9]]) as usize + 10;
    assert_eq!((header % 64, bytes[header - 1]), (0, b'\n'));
    let loaded = load(&path);
    assert_eq!(loaded.volume.grid().dims(), [3, 2, 1]);
    assert!(loaded.description.warnings.is_empty());
    loaded.volume.samples().clone()
}

#[test]
fn what_is_written_is_read_again() {
    let all = [
        Samples::U8(vec![0, 1, 2, 3, 4, 255].into()),
        Samples::I8(vec![-128, 1, 2, 3, 4, 127].into()),
        Samples::U16(vec![0, 1, 2, 3, 4, 65_535].into()),
        Samples::I16(vec![-32_768, 1, 2, 3, 4, 32_767].into()),
        Samples::U32(vec![0, 1, 2, 3, 4, u32::MAX].into()),
        Samples::I32(vec![i32::MIN, 1, 2, 3, 4, i32::MAX].into()),
        Samples::F32(vec![-1e30, 1.5, 2.0, 3.0, 4.0, 1e30].into()),
        Samples::F64(vec![-1e300, 1.5, 2.0, 3.0, 4.0, 1e-300].into()),
    ];
    for samples in all {
        assert_eq!(round_trip(&volume(samples.clone(), Rescale::default())), samples);
    }
    let rescale = Rescale {
        slope: 0.5,
        intercept: -1024.0,
    };
    let real = round_trip(&volume(Samples::I16(vec![0, 1, 2, 3, 4, 4096].into()), rescale));
    assert_eq!(
        real,
        Samples::F32(vec![-1024.0, -1023.5, -1023.0, -1022.5, -1022.0, 1024.0].into())
    );
    let real = round_trip(&volume(Samples::U32(vec![0, 1, 2, 3, 4, 5].into()), rescale));
    assert!(matches!(real, Samples::F64(_)));
}

/// An archive of named files.
fn npz(files: &[(&str, Vec<u8>)], method: CompressionMethod) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        archive
            .start_file(*name, SimpleFileOptions::default().compression_method(method))
            .unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

fn arrays() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("times.npy", npy(1, "<f4", false, "(2,)", &[0; 8])),
        ("note.txt", b"text".to_vec()),
        (
            "first.npy",
            npy(1, "|u1", false, "(1, 2, 3)", &[1, 2, 3, 4, 5, 6]),
        ),
        (
            "second.npy",
            npy(1, "|u1", false, "(3, 2, 1)", &[6, 5, 4, 3, 2, 1]),
        ),
    ]
}

fn with_array(folder: &Path, array: &str) -> Result<Loaded, IoError> {
    let options = ReadOptions {
        array: Some(array.to_owned()),
        ..ReadOptions::default()
    };
    read_volume(folder.join("a.npz"), &options)
}

#[test]
fn an_array_is_chosen_by_name_or_by_its_axes() {
    let folder = tempfile::tempdir().unwrap();
    for method in [CompressionMethod::Stored, CompressionMethod::Deflated] {
        let loaded = read_bytes(folder.path(), "a.npz", &npz(&arrays(), method)).unwrap();
        assert_eq!(
            loaded.volume.samples(),
            &Samples::U8(vec![1, 2, 3, 4, 5, 6].into())
        );
        for name in ["second", "second.npy"] {
            let loaded = with_array(folder.path(), name).unwrap();
            assert_eq!(
                loaded.volume.samples(),
                &Samples::U8(vec![6, 5, 4, 3, 2, 1].into())
            );
        }
        let text = with_array(folder.path(), "third").unwrap_err().to_string();
        assert!(
            text.contains("no array `third`; there is times, first, second"),
            "{text}"
        );
    }
    let flat = npz(
        &[arrays()[0].clone(), arrays()[0].clone()]
            .map(|(_, b)| b)
            .into_iter()
            .enumerate()
            .map(|(i, b)| (["a.npy", "b.npy"][i], b))
            .collect::<Vec<_>>(),
        CompressionMethod::Stored,
    );
    let text = read_bytes(folder.path(), "a.npz", &flat).unwrap_err().to_string();
    assert!(text.contains("a (2,), b (2,)"), "{text}");
    let only = npz(&arrays()[..1], CompressionMethod::Stored);
    assert_eq!(
        read_bytes(folder.path(), "a.npz", &only)
            .unwrap()
            .volume
            .grid()
            .dims(),
        [2, 1, 1]
    );
}

#[test]
fn malformed_arrays_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let good = npy(1, "|u1", false, "(2, 3, 4)", &[1; 24]);
    let changed = |position: usize, value: u8| {
        let mut bytes = good.clone();
        bytes[position] = value;
        bytes
    };
    let cases = [
        (changed(6, 9), "version"),
        (changed(6, 0), "version"),
        (changed(8, 255), "header"),
        (changed(9, 255), "header"),
        (changed(8, 0), "header"),
        (npy(1, "|u1", false, "(2, 3, 4, 1)", &[1; 24]), "(2, 3, 4, 1)"),
        (npy(1, "|u1", false, "()", &[1; 24]), "()"),
        (npy(1, "|u1", false, "(0, 3, 4)", &[1; 24]), "shape"),
        (npy(1, "|u1", false, "(65536, 1, 1)", &[1; 24]), "shape"),
        (
            npy(1, "|u1", false, "(18446744073709551615, 1, 1)", &[1; 24]),
            "shape",
        ),
        (npy(1, "<f8", false, "(65535, 65535, 65535)", &[1; 24]), "needed"),
        (
            npy(1, "|u1", false, "(4000, 4000, 4000)", &[1; 24]),
            "samples need",
        ),
        (npy(1, "|u1", false, "(2, 3, 5)", &[1; 24]), "samples need"),
    ];
    for (bytes, expected) in cases {
        let text = read_bytes(folder.path(), "a.npy", &bytes)
            .unwrap_err()
            .to_string();
        assert!(text.contains(expected), "{expected}: {text}");
    }
    let lie = [b"\x93NUMPY\x02\x00", &u32::MAX.to_le_bytes()[..], b"{}"].concat();
    assert!(read_bytes(folder.path(), "a.npy", &lie).is_err());
    let excess = read_bytes(
        folder.path(),
        "a.npy",
        &npy(1, "|u1", false, "(2, 3, 3)", &[1; 24]),
    )
    .unwrap();
    assert_eq!(
        excess.description.warnings,
        ["there are more data than the header declares"]
    );
}

#[test]
fn an_archive_that_promises_too_much_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let bomb = npy(1, "|u1", false, "(4000, 4000, 4000)", &[0; 100]);
    for method in [CompressionMethod::Stored, CompressionMethod::Deflated] {
        let bytes = npz(&[("a.npy", bomb.clone())], method);
        let text = read_bytes(folder.path(), "a.npz", &bytes)
            .unwrap_err()
            .to_string();
        assert!(text.contains("samples need 64000000000 bytes"), "{text}");
    }
    let mut corrupt = npz(&arrays(), CompressionMethod::Stored);
    let at = corrupt
        .windows(6)
        .position(|window| window == [1, 2, 3, 4, 5, 6])
        .unwrap();
    corrupt[at] = 9;
    let text = read_bytes(folder.path(), "a.npz", &corrupt)
        .unwrap_err()
        .to_string();
    assert!(text.contains("checksum"), "{text}");
}

#[test]
fn truncated_and_damaged_files_never_panic() {
    let data: Vec<u8> = (0..=255).collect();
    let array = npy(1, "<i2", false, "(4, 4, 8)", &data);
    truncations("a.npy", &array, 100);
    assert!(flips("a.npy", &array, 90) > 100);
    for method in [CompressionMethod::Stored, CompressionMethod::Deflated] {
        let bytes = npz(&[("b.npy", array.clone())], method);
        truncations("a.npz", &bytes, 64);
        assert!(flips("a.npz", &bytes, bytes.len()) > 100);
    }
}
