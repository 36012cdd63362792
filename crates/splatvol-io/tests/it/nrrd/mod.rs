//! NRRD: real files, every encoding and layout, geometry, round trips, malformed input.

mod malformed;

use std::path::Path;

use crate::common::{
    Expected, Random, assert_expected, flips, gzip, load, read_bytes, shared_volumes, truncations,
};
use glam::{DAffine3, DMat3, DVec3};
use splatvol_io::{IoError, Loaded, ReadOptions, WriteOptions, read_volume, write_volume};
use splatvol_scene::{Grid, LengthUnit, Rescale, Samples, Volume};

/// A header of 3 x 2 x 2 samples of `extra` fields, ended by a blank line.
fn header(extra: &str) -> String {
    format!("NRRD0004\n# made for a test\ndimension: 3\nsizes: 3 2 2\n{extra}\nkey:=value: with colon\n\n")
}

fn attached(extra: &str, data: &[u8]) -> Vec<u8> {
    [header(extra).as_bytes(), data].concat()
}

fn read(bytes: &[u8]) -> Result<Loaded, IoError> {
    read_bytes(tempfile::tempdir().unwrap().path(), "a.nrrd", bytes)
}

fn read_fields(fields: &str, data: &[u8]) -> Result<Loaded, IoError> {
    read(
        format!("NRRD0005\n{fields}\n\n")
            .bytes()
            .chain(data.iter().copied())
            .collect::<Vec<_>>()
            .as_slice(),
    )
}

fn refused(result: Result<Loaded, IoError>) -> String {
    result.unwrap_err().to_string()
}

const VALUES: [i16; 12] = [0, 1, -2, 300, -400, 5, 6, 7, 8, 9, 32767, -32768];

fn little() -> Vec<u8> {
    VALUES.iter().flat_map(|v| v.to_le_bytes()).collect()
}

#[test]
fn real_files_are_as_known() {
    let Some(folder) = shared_volumes() else { return };
    let cases = [
        (
            "FLAIR.nrrd",
            [124, 160, 140],
            [1.0; 3],
            [0.0, 255.0, 41.486],
            "u8",
        ),
        (
            "tooth.nrrd",
            [103, 94, 161],
            [1.0; 3],
            [0.0, 255.0, 103.165],
            "u8",
        ),
        (
            "headsq/quarter.nhdr",
            [64, 64, 93],
            [3.2, 3.2, 1.5],
            [0.0, 3926.0, 507.687],
            "i16",
        ),
    ];
    for (name, dims, spacing, values, sample_type) in cases {
        let loaded = load(&folder.join(name));
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
    }
    let tooth = load(&folder.join("tooth.nrrd"));
    let raw = std::fs::read(folder.join("tooth_103x94x161_uint8.raw")).unwrap();
    assert_eq!(*tooth.volume.samples(), Samples::U8(raw.into()));
    // 93 slice files; the space is left-handed, so that slices go down in world.
    let head = load(&folder.join("headsq/quarter.nhdr"));
    assert_eq!(head.description.files.len(), 94);
    assert!(
        head.volume
            .grid()
            .world_from_voxel()
            .matrix3
            .z_axis
            .abs_diff_eq(DVec3::new(0.0, 0.0, -1.5), 1e-12)
    );
    assert!(
        head.description.orientation.contains("3D-left-handed"),
        "{}",
        head.description.orientation
    );
}

#[test]
fn every_encoding_and_byte_order_gives_the_same_samples() {
    let big: Vec<u8> = VALUES.iter().flat_map(|v| v.to_be_bytes()).collect();
    let text = VALUES.map(|v| v.to_string()).join(" \n");
    let hex: String = little().iter().map(|byte| format!("{byte:02X}")).collect();
    let skipped = gzip(&[&b"12345"[..], &little()].concat());
    let cases: [(&str, Vec<u8>); 9] = [
        ("type: short\nencoding: raw\nendian: little", little()),
        ("type: int16_t\nencoding: RAW\nendian: big", big),
        (
            "type: signed short int\nencoding: gz\nendian: little",
            gzip(&little()),
        ),
        ("type: int16\nencoding: ascii", text.into_bytes()),
        ("type: int16\nencoding: hex\nendian: little", hex.into_bytes()),
        (
            "type: int16\nencoding: raw\nendian: little\nbyte skip: -1",
            [&b"junk"[..], &little()].concat(),
        ),
        (
            "type: int16\nencoding: raw\nendian: little\nbyteskip: 3",
            [&b"abc"[..], &little()].concat(),
        ),
        (
            "type: int16\nencoding: raw\nendian: little\nline skip: 2",
            [&b"abc\n\n"[..], &little()].concat(),
        ),
        (
            "type: int16\nencoding: gzip\nendian: little\nline skip: 1\nbyte skip: 5",
            [&b"x\n"[..], &skipped].concat(),
        ),
    ];
    for (fields, data) in cases {
        let loaded = read(&attached(fields, &data)).unwrap_or_else(|error| panic!("{fields}: {error}"));
        assert_eq!(
            *loaded.volume.samples(),
            Samples::I16(VALUES.to_vec().into()),
            "{fields}"
        );
        // The only warning is that no spacing is given.
        assert_eq!(loaded.description.warnings, ["no spacing: 1 is used"], "{fields}");
    }
}

#[test]
fn detached_data_may_be_one_file_a_series_or_a_list() {
    let folder = tempfile::tempdir().unwrap();
    let data = little();
    std::fs::write(folder.path().join("all of it.raw"), &data).unwrap();
    for (i, half) in data.chunks(12).enumerate() {
        std::fs::write(
            folder.path().join(format!("slice {:03}.raw.gz", 9 - i)),
            gzip(half),
        )
        .unwrap();
    }
    let fields = "NRRD0004\ntype: short\ndimension: 3\nsizes: 3 2 2\nendian: little\n";
    let cases = [
        ("encoding: raw\ndata file: all of it.raw\n", 2),
        ("encoding: gzip\ndatafile: slice %03d.raw.gz 9 8 -1\n", 3),
        ("encoding: gzip\ndata file: slice %03d.raw.gz 9 8 -1 2\n", 3),
        (
            "encoding: gzip\ndata file: LIST\nslice 009.raw.gz\nslice 008.raw.gz\n",
            3,
        ),
    ];
    for (rest, files) in cases {
        let path = folder.path().join("a.nhdr");
        std::fs::write(&path, format!("{fields}{rest}")).unwrap();
        let loaded = load(&path);
        assert_eq!(
            *loaded.volume.samples(),
            Samples::I16(VALUES.to_vec().into()),
            "{rest}"
        );
        assert_eq!(loaded.description.files.len(), files);
    }
    for bad in [
        "encoding: raw\ndata file: absent.raw\n",
        "encoding: raw\ndata file: ../a.raw\n",
        "encoding: raw\ndata file: /etc/hostname\n",
        "encoding: raw\ndata file: b.nhdr\n",
        "encoding: raw\ndata file: .\n",
        "encoding: gzip\ndata file: slice %03d.raw.gz 9 7 -1\n",
        "encoding: gzip\ndata file: slice %03d.raw.gz 1 1000000000 1\n",
        "encoding: gzip\ndata file: slice %03d.raw.gz 1 2 0\n",
        "encoding: gzip\ndata file: slice %n.raw.gz 1 2 1\n",
        "encoding: gzip\ndata file: slice %999999999d.raw.gz 1 2 1\n",
        "encoding: gzip\ndata file: s%d 0 9223372036854775807 1\n",
        "encoding: gzip\ndata file: s%d -9223372036854775808 9223372036854775807 1\n",
        "encoding: gzip\ndata file: LIST\n",
        "encoding: raw\n",
    ] {
        let text = refused(read_bytes(
            folder.path(),
            "b.nhdr",
            format!("{fields}{bad}").as_bytes(),
        ));
        assert!(text.contains("b.nhdr"), "{text}");
    }
    let missing = read_bytes(
        folder.path(),
        "b.nhdr",
        format!("{fields}encoding: raw\ndata file: c\n").as_bytes(),
    );
    assert!(matches!(missing, Err(IoError::MissingDataFile { .. })));
}

fn map(fields: &str) -> DAffine3 {
    let fields = format!("type: uchar\nencoding: raw\n{fields}");
    let loaded = read(&attached(&fields, &[1; 12])).unwrap_or_else(|error| panic!("{fields}: {error}"));
    loaded.volume.grid().world_from_voxel()
}

#[test]
fn spaces_become_right_anterior_superior() {
    let directions = "space directions: (2,0,0) (0,3,0.5) (0,-0.5,4)\nspace origin: (10,20,30)\n";
    let stored = DAffine3::from_cols(
        DVec3::new(2.0, 0.0, 0.0),
        DVec3::new(0.0, 3.0, 0.5),
        DVec3::new(0.0, -0.5, 4.0),
        DVec3::new(10.0, 20.0, 30.0),
    );
    for (space, signs) in [
        ("right-anterior-superior", [1.0, 1.0, 1.0]),
        ("RAS", [1.0, 1.0, 1.0]),
        ("left-anterior-superior", [-1.0, 1.0, 1.0]),
        ("left-posterior-superior", [-1.0, -1.0, 1.0]),
        ("LPS", [-1.0, -1.0, 1.0]),
        ("scanner-xyz", [1.0, 1.0, 1.0]),
        ("3D-right-handed", [1.0, 1.0, 1.0]),
        ("3D-left-handed", [1.0, 1.0, -1.0]),
    ] {
        let expected = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::from_array(signs))) * stored;
        assert_eq!(map(&format!("space: {space}\n{directions}")), expected, "{space}");
    }
    assert_eq!(map(&format!("space dimension: 3\n{directions}")), stored);
    let plain = map("spacings: 2 -3 4");
    assert_eq!(
        plain,
        DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(2.0, -3.0, 4.0)))
    );
}

#[test]
fn vectors_and_series_are_chosen_from_never_guessed() {
    let rgb: Vec<u8> = (0..24).collect();
    let fields = "type: uchar\nencoding: raw\ndimension: 4\nsizes: 3 2 2 2\n\
                  space: RAS\nspace directions: none (1,0,0) (0,1,0) (0,0,1)\nkinds: RGB-color domain domain domain";
    let text = refused(read_fields(fields, &rgb));
    assert!(text.contains("vectors of 3 components"), "{text}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.nrrd");
    let with = |fields: &str, data: &[u8], options: &ReadOptions| {
        std::fs::write(
            &path,
            [format!("NRRD0005\n{fields}\n\n").as_bytes(), data].concat(),
        )
        .unwrap();
        read_volume(&path, options)
    };
    let component = |n| ReadOptions {
        component: Some(n),
        ..ReadOptions::default()
    };
    let green = with(fields, &rgb, &component(1)).unwrap().volume;
    assert_eq!(green.grid().dims(), [2, 2, 2]);
    assert_eq!(
        *green.samples(),
        Samples::U8(vec![1, 4, 7, 10, 13, 16, 19, 22].into())
    );
    assert!(with(fields, &rgb, &component(3)).is_err());

    let series = "type: uchar\nencoding: raw\ndimension: 4\nsizes: 2 2 2 3\nspacings: 1 1 1 NaN\n\
                  kinds: space space space time";
    let time = |n| ReadOptions {
        time: Some(n),
        ..ReadOptions::default()
    };
    for n in 0..3 {
        let loaded = with(series, &rgb, &time(n)).unwrap();
        assert_eq!(
            *loaded.volume.samples(),
            Samples::U8(rgb[8 * n..8 * n + 8].to_vec().into())
        );
        // Who asks for a time point is not warned that it is read.
        assert!(loaded.description.warnings.is_empty());
        let zipped = series.replace("raw", "gzip");
        assert_eq!(
            with(&zipped, &gzip(&rgb), &time(n)).unwrap().volume.samples(),
            loaded.volume.samples()
        );
        let text: String = rgb.iter().map(|v| format!("{v} ")).collect();
        let ascii = series.replace("raw", "txt");
        assert_eq!(
            with(&ascii, text.as_bytes(), &time(n)).unwrap().volume.samples(),
            loaded.volume.samples()
        );
    }
    assert!(with(series, &rgb, &time(3)).is_err());
    let first = with(series, &rgb, &ReadOptions::default()).unwrap();
    assert_eq!(first.description.warnings, ["time point 0 of 3 is read"]);

    let unnamed = "type: uchar\nencoding: raw\ndimension: 4\nsizes: 3 2 2 2";
    assert!(refused(read_fields(unnamed, &rgb)).contains("4 spatial axes"));
    let between =
        "type: uchar\nencoding: raw\ndimension: 4\nsizes: 2 2 3 2\nkinds: domain domain vector domain";
    assert!(refused(read_fields(between, &rgb)).contains("between spatial axes"));
}

#[test]
fn components_behind_space_are_chosen_from_too() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.nrrd");
    let fields = "NRRD0004\ntype: uchar\nencoding: raw\ndimension: 4\nsizes: 2 1 1 3\nspacings: 1 1 1 NaN\n\
                  kinds: domain domain domain vector\n\n";
    std::fs::write(&path, [fields.as_bytes(), &[1, 2, 3, 4, 5, 6]].concat()).unwrap();
    assert!(read_volume(&path, &ReadOptions::default()).is_err());
    let last = ReadOptions {
        component: Some(2),
        ..ReadOptions::default()
    };
    assert_eq!(
        *read_volume(&path, &last).unwrap().volume.samples(),
        Samples::U8(vec![5, 6].into())
    );
    std::fs::write(&path, attached("type: uchar\nencoding: raw", &[1; 12])).unwrap();
    assert!(refused(read_volume(&path, &last)).contains("component 2"));
}

#[test]
fn an_image_is_a_volume_of_one_slice() {
    let fields = "type: uchar\nencoding: raw\ndimension: 2\nsizes: 3 2\nspacings: 2 8\nunits: \"um\" \"um\"";
    let volume = read_fields(fields, &[1, 2, 3, 4, 5, 6]).unwrap().volume;
    assert_eq!(
        (volume.grid().dims(), volume.unit()),
        ([3, 2, 1], LengthUnit::Micrometre)
    );
    assert_eq!(volume.grid().spacing(), DVec3::new(2.0, 8.0, 4.0));
}

#[test]
fn units_missing_samples_and_long_integers_are_reported() {
    let fields = "type: float\nencoding: raw\nendian: little\ndimension: 3\nsizes: 2 1 1\nspacings: 1 1 1\n\
                  space units: \"cm\" \"cm\" \"cm\"";
    let data: Vec<u8> = [f32::NAN, 4.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let loaded = read_fields(fields, &data).unwrap();
    assert_eq!(
        loaded.description.warnings,
        [
            "length units are not kept: cm, cm, cm",
            "1 samples are NaN or infinite; they count as missing"
        ]
    );
    assert_eq!(loaded.volume.value_range(), [4.0, 4.0]);
    let fields =
        "type: unsigned long long\nencoding: raw\nendian: big\ndimension: 3\nsizes: 2 1 1\nspacings: 1 1 1";
    let data: Vec<u8> = [7u64, u64::MAX].iter().flat_map(|v| v.to_be_bytes()).collect();
    let loaded = read_fields(fields, &data).unwrap();
    assert_eq!(
        *loaded.volume.samples(),
        Samples::F64(vec![7.0, 18446744073709551616.0].into())
    );
    assert_eq!(loaded.description.warnings.len(), 1);
}

#[test]
fn strict_reading_makes_errors_of_warnings() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.nrrd");
    std::fs::write(
        &path,
        attached("type: uchar\nencoding: raw\nspacings: 1 1 1", &[1; 13]),
    )
    .unwrap();
    assert_eq!(
        load(&path).description.warnings,
        ["there are more data than the header declares"]
    );
    let strict = ReadOptions {
        strict: true,
        ..ReadOptions::default()
    };
    assert!(matches!(read_volume(&path, &strict), Err(IoError::Strict { .. })));
}

fn random_volume(random: &mut Random, samples: Samples, rescale: Rescale) -> Volume {
    loop {
        let mut vector = || DVec3::new(random.signed(), random.signed(), random.signed());
        let matrix = DMat3::from_cols(vector(), vector(), vector());
        let map = DAffine3::from_mat3_translation(matrix, 1e3 * vector());
        if let Ok(grid) = Grid::from_affine([4, 3, 2], map) {
            return Volume::new(grid, samples, rescale, LengthUnit::Millimetre).unwrap();
        }
    }
}

#[test]
fn written_volumes_read_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.nrrd");
    let mut random = Random(7);
    for round in 0..20 {
        let bits: Vec<u64> = (0..24).map(|_| random.next()).collect();
        macro_rules! cast {
            ($t:ty) => {
                bits.iter().map(|&b| b as $t).collect()
            };
        }
        let finite = |b: &u64| (*b as i64 as f64) * 1e-7;
        for samples in [
            Samples::U8(cast!(u8)),
            Samples::I8(cast!(i8)),
            Samples::U16(cast!(u16)),
            Samples::I16(cast!(i16)),
            Samples::U32(cast!(u32)),
            Samples::I32(cast!(i32)),
            Samples::F32(bits.iter().map(|b| finite(b) as f32).collect()),
            Samples::F64(bits.iter().map(finite).collect()),
        ] {
            let volume = random_volume(&mut random, samples, Rescale::default());
            write_volume(
                &path,
                &volume,
                &WriteOptions {
                    compress: round % 2 == 0,
                },
            )
            .unwrap();
            let loaded = load(&path);
            assert_eq!(loaded.volume.samples(), volume.samples());
            assert_eq!(loaded.volume.grid(), volume.grid());
            assert_eq!(loaded.volume.unit(), volume.unit());
            assert_eq!(loaded.description.warnings, Vec::<String>::new());
        }
    }
}

#[test]
fn rescaled_samples_are_written_as_real_values() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.nrrd");
    let rescale = Rescale {
        slope: 0.5,
        intercept: -1024.0,
    };
    let volume = random_volume(&mut Random(3), Samples::U16((0..24).collect()), rescale);
    write_volume(&path, &volume, &WriteOptions::default()).unwrap();
    let read = load(&path).volume;
    assert_eq!(read.samples().type_name(), "f32");
    assert!((0..24).all(|i| read.value(i) == volume.value(i)));
}
