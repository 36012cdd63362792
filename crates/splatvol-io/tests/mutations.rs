//! Every reader against seeded mutations of small files, and against headers that promise gigabytes: any answer will
//! do that comes in time, without a panic and without the memory.
//!
//! `SPLATVOL_MUTATIONS=100000 cargo test -p splatvol-io --test mutations` goes on for longer.
#![allow(clippy::unwrap_used, reason = "panics are how tests fail")]

mod common;
#[path = "dicom/file.rs"]
mod dicom_file;
#[path = "nifti/file.rs"]
mod nifti_file;

use common::{Random, gzip, read_bytes};
use glam::{DMat3, DQuat, DVec3};
use nifti_file::NiftiFile;
use splatvol_scene::{Grid, LengthUnit, Rescale, Samples, Volume};

/// Memory that all malformed files together may take at their worst moment.
const MEMORY: u64 = 96 << 20;

/// A number where a text header has one.
const NUMBERS: &[&str] = &[
    "0",
    "-1",
    "1e39",
    "nan",
    "inf",
    "65535",
    "65536",
    "4294967296",
    "9223372036854775807",
    "18446744073709551616",
    "999999999999999999999999999999999999",
];

fn files() -> Vec<(&'static str, Vec<u8>)> {
    let shorts: Vec<u8> = (0..48).collect();
    let nrrd = |encoding: &str, data: &[u8]| {
        let header = format!(
            "NRRD0005\n# c\ntype: short\ndimension: 4\nspace: left-posterior-superior\nsizes: 1 3 2 4\n\
             space directions: none (1,0,0) (0,2,0.5) (0,-0.5,2)\nkinds: vector domain domain domain\n\
             endian: big\nencoding: {encoding}\nspace origin: (1,2,3)\nbyte skip: 0\nline skip: 0\n\
             space units: \"mm\" \"mm\" \"mm\"\n\n"
        );
        [header.as_bytes(), data].concat()
    };
    let text = b"1 2 3 4 5 6 7 8 9 10 11 12 -1 -2 -3 -4 -5 -6 -7 -8 -9 -10 -11 -12";
    let mha = "ObjectType = Image\nNDims = 3\nBinaryData = True\nElementByteOrderMSB = False\n\
               TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 1 2 3\nElementSpacing = 1 1 1.5\nHeaderSize = 0\n\
               ElementNumberOfChannels = 1\nDimSize = 3 2 4\nElementType = MET_SHORT\nElementDataFile = LOCAL\n";
    let mut nifti = NiftiFile::new(&[3, 2, 4], 4);
    nifti.set_sform(1, DMat3::IDENTITY, DVec3::ONE);
    nifti.set_qform(1, DQuat::IDENTITY, DVec3::ONE, 1.0);
    let nifti_1 = nifti.bytes(&shorts);
    nifti.wide = true;
    nifti.big = true;
    let nifti_2 = nifti.bytes(&shorts);
    let vti = "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" \
               header_type=\"UInt64\">\n<ImageData WholeExtent=\"0 2 0 1 0 1\" Origin=\"0 0 0\" Spacing=\"1 1 2\">\n\
               <Piece Extent=\"0 2 0 1 0 1\"><PointData Scalars=\"a\"><DataArray type=\"Float32\" Name=\"a\" \
               format=\"ascii\">1 2 3 4 5 6 7 8 9 10 11 12</DataArray></PointData></Piece></ImageData></VTKFile>\n";
    let appended = "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt32\">\n\
               <ImageData WholeExtent=\"0 2 0 1 0 1\" Origin=\"0 0 0\" Spacing=\"1 1 2\"><Piece Extent=\"0 2 0 1 0 1\">\
               <PointData Scalars=\"a\"><DataArray type=\"UInt8\" Name=\"a\" format=\"appended\" offset=\"0\"/>\
               </PointData></Piece></ImageData><AppendedData encoding=\"raw\">_\x0c\x00\x00\x00123456789abc</AppendedData>\
               </VTKFile>\n";
    let vtk = "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 2 2\nORIGIN 0 0 0\n\
               SPACING 1 1 2\nPOINT_DATA 12\nSCALARS a float 1\nLOOKUP_TABLE default\n1 2 3 4 5 6 7 8 9 10 11 12\n";
    let numpy = "{'descr': '<i2', 'fortran_order': False, 'shape': (4, 2, 3), }";
    let numpy = format!("{numpy:<117}\n");
    let numpy = [
        b"\x93NUMPY\x01\x00",
        &(numpy.len() as u16).to_le_bytes()[..],
        numpy.as_bytes(),
        &shorts,
    ]
    .concat();
    let words = [1, 2, 3, 4, 5, 6];
    let dicom = |syntax| dicom_file::DicomFile::slice(syntax, [1.0, 2.0, 3.0], 1, &words).bytes();
    let mut tiff = Vec::new();
    let mut encoder = tiff::encoder::TiffEncoder::new(std::io::Cursor::new(&mut tiff))
        .unwrap()
        .with_compression(tiff::encoder::Compression::Lzw);
    for _ in 0..3 {
        encoder
            .write_image::<tiff::encoder::colortype::Gray16>(3, 2, &words)
            .unwrap();
    }
    let mut mgh = Vec::new();
    for number in [1, 3, 2, 4, 1, 4, 0] {
        mgh.extend(i32::to_be_bytes(number));
    }
    mgh.extend([0, 1]);
    for number in [
        1.0, 1.0, 2.0, -1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0, 5.0, 6.0, 7.0,
    ] {
        mgh.extend(f32::to_be_bytes(number));
    }
    mgh.resize(284, 0);
    mgh.extend(&shorts);
    let slc = b"11111\n3 2 2 8\n1.0 1.0 2.0\n1 6 0 1\n1 1 X...6 X\x83abc\x03d8 X\x01a\x85edcba";
    vec![
        ("explicit.dcm", dicom(dicom_file::EXPLICIT)),
        ("implicit.dcm", dicom(dicom_file::IMPLICIT)),
        ("pages.tif", tiff),
        ("plain.mgh", mgh.clone()),
        ("packed.mgz", gzip(&mgh)),
        ("runs.slc", slc.to_vec()),
        ("raw.nrrd", nrrd("raw", &shorts)),
        ("gzip.nrrd", nrrd("gzip", &gzip(&shorts))),
        ("text.nrrd", nrrd("ascii", text)),
        ("hex.nrrd", nrrd("hex", "0a".repeat(48).as_bytes())),
        ("local.mha", [mha.as_bytes(), &shorts].concat()),
        ("one.nii", nifti_1.clone()),
        ("one.nii.gz", gzip(&nifti_1)),
        ("two.nii", nifti_2),
        ("ascii.vti", vti.as_bytes().to_vec()),
        ("appended.vti", appended.as_bytes().to_vec()),
        ("ascii.vtk", vtk.as_bytes().to_vec()),
        ("shorts.npy", numpy),
    ]
}

fn mutate(bytes: &mut Vec<u8>, random: &mut Random) {
    let mut below = |limit: usize| (random.next() % limit.max(1) as u64) as usize;
    let position = below(bytes.len());
    match below(7) {
        0 => bytes[position] = below(256) as u8,
        1 => bytes[position] = [0, 0xff, 0x7f, 0x80, b'-', b'9', b' ', b'\n', b'('][below(9)],
        2 => bytes.truncate(position),
        3 => drop(bytes.drain(position..(position + 1 + below(16)).min(bytes.len()))),
        4 => {
            let end = (position + 1 + below(64)).min(bytes.len());
            let copy = bytes[position..end].to_vec();
            let to = below(bytes.len());
            bytes.splice(to..to, copy);
        }
        5 => {
            let number = NUMBERS[below(NUMBERS.len())];
            let digits: Vec<usize> = (0..bytes.len()).filter(|&i| bytes[i].is_ascii_digit()).collect();
            if !digits.is_empty() {
                let start = digits[below(digits.len())];
                let length = bytes[start..]
                    .iter()
                    .take_while(|byte| byte.is_ascii_digit())
                    .count();
                bytes.splice(start..start + length, number.bytes());
            }
        }
        _ => {
            let value = (below(1 << 30) as u64) << below(40);
            let value = value.to_le_bytes();
            let length = [1, 2, 4, 8][below(4)].min(bytes.len() - position);
            bytes[position..position + length].copy_from_slice(&value[..length]);
        }
    }
    if bytes.is_empty() {
        bytes.push(0);
    }
}

#[test]
fn mutated_files_are_answered_in_time() {
    let rounds = std::env::var("SPLATVOL_MUTATIONS")
        .ok()
        .and_then(|rounds| rounds.parse().ok())
        .unwrap_or(1000);
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random(20_26);
    for (name, original) in files() {
        read_bytes(folder.path(), name, &original).unwrap_or_else(|error| panic!("{error}"));
        let mut refused = 0;
        for _ in 0..rounds {
            let mut bytes = original.clone();
            for _ in 0..1 + random.next() % 4 {
                mutate(&mut bytes, &mut random);
            }
            refused += usize::from(read_bytes(folder.path(), name, &bytes).is_err());
        }
        assert!(
            refused > rounds / 10,
            "{name}: only {refused} of {rounds} were refused"
        );
    }
    check_memory();
}

/// Linux keeps the largest resident size of a process.
fn check_memory() {
    let Ok(status) = std::fs::read_to_string("/proc/self/status") else {
        println!("skipped: no /proc to read the memory from");
        return;
    };
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))
        .unwrap();
    let kilobytes: u64 = line.trim().trim_end_matches("kB").trim().parse().unwrap();
    assert!(kilobytes << 10 < MEMORY, "{kilobytes} kB at the worst moment");
}

#[test]
fn promises_of_gigabytes_cost_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let sizes = ["2000 2000 4000", "65535 65535 65535"];
    for size in sizes {
        for encoding in ["raw", "gzip", "ascii", "hex"] {
            let header =
                format!("NRRD0004\ntype: uchar\ndimension: 3\nsizes: {size}\nencoding: {encoding}\n\n");
            let bomb = [header.as_bytes(), &gzip(&[0; 1 << 20])].concat();
            assert!(read_bytes(folder.path(), "a.nrrd", &bomb).is_err());
        }
        for compressed in ["True", "False"] {
            let header = format!(
                "NDims = 3\nDimSize = {size}\nCompressedData = {compressed}\nElementType = MET_DOUBLE\n\
                 ElementDataFile = LOCAL\n"
            );
            let bomb = [header.as_bytes(), &gzip(&[0; 1 << 20])].concat();
            assert!(read_bytes(folder.path(), "a.mha", &bomb).is_err());
        }
    }
    for datatype in [2, 64, 1792] {
        let nifti = NiftiFile::new(&[32767, 32767, 32767, 32767, 32767], datatype).bytes(&[0; 1 << 20]);
        assert!(read_bytes(folder.path(), "a.nii", &nifti).is_err());
        assert!(read_bytes(folder.path(), "a.nii.gz", &gzip(&nifti)).is_err());
    }
    check_memory();
}

#[test]
fn a_volume_of_one_sample_survives_every_format_that_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let grid = Grid::centred([1, 1, 1], DVec3::ONE).unwrap();
    let volume = Volume::new(
        grid,
        Samples::I16(vec![-7].into()),
        Rescale::default(),
        LengthUnit::Unknown,
    )
    .unwrap();
    for name in ["a.nrrd", "a.npy"] {
        let path = folder.path().join(name);
        splatvol_io::write_volume(&path, &volume, &splatvol_io::WriteOptions::default()).unwrap();
        assert_eq!(common::load(&path).volume.samples(), volume.samples());
    }
    let unknown = folder.path().join("a.dcm");
    assert!(splatvol_io::write_volume(&unknown, &volume, &splatvol_io::WriteOptions::default()).is_err());
}
