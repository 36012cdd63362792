//! MetaImage: real files, layouts, geometry, malformed input.

use std::io::Write;

use crate::common::{Expected, assert_expected, flips, gzip, load, read_bytes, shared_volumes, truncations};
use glam::{DAffine3, DVec3};
use splatvol_io::{IoError, Loaded, ReadOptions, read_volume};
use splatvol_scene::{LengthUnit, Samples};

const VALUES: [i16; 12] = [0, 1, -2, 300, -400, 5, 6, 7, 8, 9, 32767, -32768];

fn little() -> Vec<u8> {
    VALUES.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// 3 x 2 x 2 shorts.
fn header(fields: &str, data_file: &str) -> String {
    format!("ObjectType = Image\nNDims = 3\nDimSize = 3 2 2\n{fields}\nElementDataFile = {data_file}\n")
}

fn local(fields: &str, data: &[u8]) -> Vec<u8> {
    [header(fields, "LOCAL").as_bytes(), data].concat()
}

fn read(bytes: &[u8]) -> Result<Loaded, IoError> {
    read_bytes(tempfile::tempdir().unwrap().path(), "a.mha", bytes)
}

const SHORTS: &str = "ElementType = MET_SHORT\nElementByteOrderMSB = False\nElementSpacing = 1 1 1";

#[test]
fn real_files_are_as_known() {
    let Some(folder) = shared_volumes() else { return };
    let cases = [
        (
            "LIDC2.mha",
            [256, 256, 133],
            [1.40625, 1.40625, 2.5],
            [0.0, 255.0, 7.0545],
        ),
        ("HeadMRVolume.mhd", [48, 62, 42], [4.0; 3], [0.0, 255.0, 24.4682]),
        (
            "frogtissue.mhd",
            [500, 470, 136],
            [1.0, 1.0, 1.5],
            [0.0, 29.0, 0.38421],
        ),
    ];
    for (name, dims, spacing, values) in cases {
        let loaded = load(&folder.join(name));
        let sample_type = "u8";
        assert_expected(
            name,
            &loaded,
            &Expected {
                dims,
                spacing,
                values,
                sample_type,
            },
        );
        let warnings = &loaded.description.warnings;
        match name {
            // The header declares 260020 bytes of compressed data, which make only 30963285 of the 31960000 samples
            // (a reader that stops there finds a mean of 0.3831); the file's 262087 make them all, with a right
            // checksum.
            "frogtissue.mhd" => assert_eq!(
                warnings[..],
                ["CompressedDataSize is 260020, there are 262087 bytes; all were used"]
            ),
            _ => assert!(warnings.is_empty(), "{warnings:?}"),
        }
    }
    // The first axis points left, the others anterior and inferior: in RAS+ that is -x, +y, -z.
    let chest = load(&folder.join("LIDC2.mha")).volume;
    let map = chest.grid().world_from_voxel();
    let expected = DAffine3::from_cols(
        DVec3::new(-1.40625, 0.0, 0.0),
        DVec3::new(0.0, 1.40625, 0.0),
        DVec3::new(0.0, 0.0, -2.5),
        DVec3::new(0.0, -360.0, 332.5),
    );
    assert!(map.abs_diff_eq(expected, 1e-10), "{map:?}");
}

#[test]
fn every_coding_gives_the_same_samples() {
    let big: Vec<u8> = VALUES.iter().flat_map(|v| v.to_be_bytes()).collect();
    let text = VALUES.map(|v| v.to_string()).join(" ");
    let geometry = "ElementSpacing = 1 1 1\nElementType = MET_SHORT\n";
    let cases = [
        ("ElementByteOrderMSB = False", little()),
        ("BinaryDataByteOrderMSB = True", big),
        (
            "BinaryDataByteOrderMSB = False\nCompressedData = True\nCompressedDataSize = 32",
            zlib(&little()),
        ),
        (
            "BinaryDataByteOrderMSB = False\nCompressedData = True",
            gzip(&little()),
        ),
        ("BinaryData = False", text.into_bytes()),
        (
            "ElementByteOrderMSB = False\nHeaderSize = -1",
            [&b"junk"[..], &little()].concat(),
        ),
        (
            "ElementByteOrderMSB = False\nHeaderSize = 4",
            [&b"junk"[..], &little()].concat(),
        ),
    ];
    for (fields, data) in cases {
        let loaded =
            read(&local(&format!("{geometry}{fields}"), &data)).unwrap_or_else(|e| panic!("{fields}: {e}"));
        assert_eq!(
            *loaded.volume.samples(),
            Samples::I16(VALUES.to_vec().into()),
            "{fields}"
        );
        assert_eq!(loaded.description.warnings, Vec::<String>::new(), "{fields}");
    }
}

#[test]
fn data_files_may_be_one_a_series_or_a_list() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a b.raw"), little()).unwrap();
    for (i, half) in little().chunks(12).enumerate() {
        std::fs::write(folder.path().join(format!("s{:02}.raw", i + 1)), half).unwrap();
    }
    for (data_file, files) in [
        ("a b.raw", 2),
        ("s%02d.raw 1 2 1", 3),
        ("LIST\ns01.raw\ns02.raw", 3),
    ] {
        let path = folder.path().join("a.mhd");
        std::fs::write(&path, header(SHORTS, data_file)).unwrap();
        let loaded = load(&path);
        assert_eq!(*loaded.volume.samples(), Samples::I16(VALUES.to_vec().into()));
        assert_eq!(loaded.description.files.len(), files);
    }
    for bad in [
        "absent.raw",
        "../a.raw",
        "/etc/hostname",
        "b.mhd",
        ".",
        "LIST",
        "s%02d.raw 1 1000000000 1",
        "",
    ] {
        let bytes = header(SHORTS, bad);
        assert!(
            read_bytes(folder.path(), "b.mhd", bytes.as_bytes()).is_err(),
            "{bad}"
        );
    }
}

#[test]
fn rows_of_the_matrix_are_the_directions_of_the_axes() {
    let fields = "ElementType = MET_UCHAR\nTransformMatrix = 0 1 0 0 0 1 1 0 0\nOffset = 10 20 30\n\
                  ElementSpacing = 2 3 4\nDistanceUnits = um\nAnatomicalOrientation = RAI";
    let volume = read(&local(fields, &[1; 12])).unwrap().volume;
    // In LPS, axis 0 runs along y, axis 1 along z, axis 2 along x.
    let expected = DAffine3::from_cols(
        DVec3::new(0.0, -2.0, 0.0),
        DVec3::new(0.0, 0.0, 3.0),
        DVec3::new(-4.0, 0.0, 0.0),
        DVec3::new(-10.0, -20.0, 30.0),
    );
    assert_eq!(volume.grid().world_from_voxel(), expected);
    assert_eq!(volume.unit(), LengthUnit::Micrometre);
}

#[test]
fn images_series_and_channels() {
    let image = "NDims = 2\nDimSize = 3 2\nElementType = MET_UCHAR\nElementSpacing = 2 8\nOffset = 1 2\n\
                 ElementDataFile = LOCAL\n";
    let volume = read(&[image.as_bytes(), &[1, 2, 3, 4, 5, 6]].concat())
        .unwrap()
        .volume;
    assert_eq!(volume.grid().dims(), [3, 2, 1]);
    assert_eq!(volume.grid().spacing(), DVec3::new(2.0, 8.0, 4.0));
    assert_eq!(volume.grid().origin(), DVec3::new(-1.0, -2.0, 0.0));

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mha");
    let data: Vec<u8> = (0..16).collect();
    let series = "NDims = 4\nDimSize = 2 2 2 2\nElementType = MET_UCHAR\nElementSpacing = 1 1 1 1\n\
                  TransformMatrix = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\nElementDataFile = LOCAL\n";
    std::fs::write(&path, [series.as_bytes(), &data].concat()).unwrap();
    let second = ReadOptions {
        time: Some(1),
        ..ReadOptions::default()
    };
    assert_eq!(
        *read_volume(&path, &second).unwrap().volume.samples(),
        Samples::U8((8..16).collect())
    );
    assert_eq!(*load(&path).volume.samples(), Samples::U8((0..8).collect()));
    let third = ReadOptions {
        time: Some(2),
        ..ReadOptions::default()
    };
    assert!(read_volume(&path, &third).is_err());

    let channels = "NDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementNumberOfChannels = 2\n\
                    ElementDataFile = LOCAL\n";
    std::fs::write(&path, [channels.as_bytes(), &data].concat()).unwrap();
    let error = read_volume(&path, &ReadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(error.contains("vectors of 2 components"), "{error}");
    let odd = ReadOptions {
        component: Some(1),
        ..ReadOptions::default()
    };
    assert_eq!(
        *read_volume(&path, &odd).unwrap().volume.samples(),
        Samples::U8(vec![1, 3, 5, 7, 9, 11, 13, 15].into())
    );
}

#[test]
fn bad_fields_are_named() {
    for (fields, name) in [
        ("ElementType = MET_SHORT_ARRAY", "ElementType"),
        ("ElementType = MET_LIGHT", "ElementType"),
        ("", "elementtype"),
        ("ElementType = MET_UCHAR\nElementSpacing = 1 1", "ElementSpacing"),
        (
            "ElementType = MET_UCHAR\nElementSpacing = 1 1 0",
            "ElementSpacing",
        ),
        (
            "ElementType = MET_UCHAR\nElementSpacing = 1 1 -1",
            "ElementSpacing",
        ),
        (
            "ElementType = MET_UCHAR\nElementSpacing = 1 1 nan",
            "ElementSpacing",
        ),
        ("ElementType = MET_UCHAR\nElementSpacing = 1 1 1e-40", "spacing"),
        ("ElementType = MET_UCHAR\nOffset = inf 0 0", "Offset"),
        (
            "ElementType = MET_UCHAR\nTransformMatrix = 1 0 0 0 1 0 0 1 0",
            "direction",
        ),
        (
            "ElementType = MET_UCHAR\nTransformMatrix = 1 0 0 0 1 0",
            "TransformMatrix",
        ),
        (
            "ElementType = MET_UCHAR\nCompressedData = maybe",
            "CompressedData",
        ),
        ("ElementType = MET_UCHAR\nHeaderSize = -2", "HeaderSize"),
        (
            "ElementType = MET_UCHAR\nElementNumberOfChannels = 0",
            "ElementNumberOfChannels",
        ),
        (
            "ElementType = MET_UCHAR\nElementNumberOfChannels = 1000000000",
            "components",
        ),
        ("ElementType = MET_UCHAR\nNDims = 3", "NDims"),
        ("no equals sign", "line"),
    ] {
        let error = read(&local(fields, &[1; 12])).unwrap_err().to_string();
        assert!(error.contains(name), "{fields}: {error}");
    }
}

#[test]
fn absurd_headers_are_refused_without_an_allocation() {
    // The 93-byte header and the 17 GB claim of public bug reports, and relatives.
    for fields in [
        "NDims = 3\nDimSize = 2600 2600 2600",
        "NDims = 3\nDimSize = 65535 65535 65535",
        "NDims = 3\nDimSize = 0 1 1",
        "NDims = 3\nDimSize = -1 1 1",
        "NDims = 3\nDimSize = 99999999999999999999 1 1",
        "NDims = 9\nDimSize = 1 1 1 1 1 1 1 1 1",
        "NDims = 1000000000\nDimSize = 1",
        "NDims = 0\nDimSize = ",
        "NDims = -3\nDimSize = 1 1 1",
        "NDims = 3\nDimSize = 1 1",
        "NDims = 4\nDimSize = 1 1 1 9223372036854775807",
        "NDims = 4\nDimSize = 1 1 1 0",
        "NDims = 3",
        "DimSize = 1 1 1",
        "ObjectType = Tube\nNDims = 3\nDimSize = 1 1 1",
    ] {
        for compressed in ["False", "True"] {
            let text = format!(
                "{fields}\nElementType = MET_UCHAR\nCompressedData = {compressed}\nElementDataFile = LOCAL\n"
            );
            assert!(
                read(&[text.as_bytes(), &zlib(&[0; 9])].concat()).is_err(),
                "{text}"
            );
        }
    }
    assert!(read(b"").is_err());
    assert!(read(b"NDims = 3\n").is_err());
}

#[test]
fn no_cut_and_no_flipped_byte_does_harm() {
    let raw = local(SHORTS, &little());
    let fields =
        format!("{SHORTS}\nCompressedData = True\nTransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 1 2 3");
    let zipped = local(&fields, &zlib(&little()));
    for bytes in [&raw, &zipped] {
        truncations("a.mha", bytes, bytes.len());
        let refused = flips("a.mha", bytes, bytes.len() - 24);
        assert!(refused > bytes.len(), "{refused}");
    }
}
