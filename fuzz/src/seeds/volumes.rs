//! Volumes on regular grids, in files.

use std::io::Write;

use splatvol::{Grid, LengthUnit, Rescale, Samples, Volume};
use splatvol_io::{WriteOptions, write_volume};

use super::{ending, written};
use crate::common::dicom_file::{BIG, DicomFile, EXPLICIT, IMPLICIT, element, items};
use crate::common::{codecs, coded_files, small_volumes, vti_file};
use crate::input::Input;

fn of_name(ends: &[&str]) -> Vec<Input> {
    ending(small_volumes::files(), ends)
}

/// A ball of 8 x 8 x 8.
fn volume() -> Volume {
    let at = |i: usize| [i % 8, i / 8 % 8, i / 64].map(|c| c as f64 - 3.5);
    let value = |i: usize| 100.0 - at(i).iter().map(|c| c * c).sum::<f64>();
    let samples: Vec<i16> = (0..512).map(|i| value(i) as i16).collect();
    let grid = Grid::centred([8, 8, 8], [1.0, 1.0, 2.0]).unwrap();
    Volume::new(
        grid,
        Samples::I16(samples.into()),
        Rescale::default(),
        LengthUnit::Millimetre,
    )
    .unwrap()
}

fn of_writer(name: &str, compress: bool) -> Input {
    written(name, |path| {
        write_volume(path, &volume(), &WriteOptions { compress }).unwrap();
    })
}

pub(crate) fn nrrd() -> Vec<Input> {
    let header =
        "NRRD0005\ntype: uchar\ndimension: 3\nsizes: 4 3 2\nspacings: 1 1 2\nencoding: raw\ndata file: ";
    let list = format!("{header}LIST 2\ns0.raw\ns1.raw\n");
    let numbered = format!("{header}s%d.raw 0 1 1 2\n");
    let parts = || {
        [("s0.raw", 0u8), ("s1.raw", 50)]
            .map(|(name, first)| (name.to_owned(), (first..first + 12).collect()))
    };
    let detached = |name: &str, text: String| {
        let mut files = vec![(name.to_owned(), text.into_bytes())];
        files.extend(parts());
        Input::files(name, files)
    };
    let mut seeds = of_name(&[".nrrd"]);
    seeds.extend([of_writer("packed.nrrd", true), of_writer("plain.nrrd", false)]);
    seeds.extend([detached("list.nhdr", list), detached("numbers.nhdr", numbered)]);
    seeds
}

pub(crate) fn metaimage() -> Vec<Input> {
    let head =
        "ObjectType = Image\nNDims = 3\nDimSize = 4 3 2\nElementType = MET_UCHAR\nElementSpacing = 1 1 2\n";
    let samples: Vec<u8> = (0..24).collect();
    let packed = zlib(&samples);
    let sizes = format!("CompressedData = True\nCompressedDataSize = {}\n", packed.len());
    let local = [head, &sizes, "ElementDataFile = LOCAL\n"].concat();
    let detached = format!("{head}ElementDataFile = b.raw\n");
    let list = format!("{head}ElementDataFile = LIST\nb.raw\nc.raw\n");
    let file = |name: &str, bytes: &[u8]| (name.to_owned(), bytes.to_vec());
    let mut seeds = of_name(&[".mha"]);
    seeds.push(Input::file("packed.mha", [local.as_bytes(), &packed].concat()));
    seeds.push(Input::files(
        "a.mhd",
        vec![file("a.mhd", detached.as_bytes()), file("b.raw", &samples)],
    ));
    seeds.push(Input::files(
        "l.mhd",
        vec![
            file("l.mhd", list.as_bytes()),
            file("b.raw", &samples[..12]),
            file("c.raw", &samples[12..]),
        ],
    ));
    seeds
}

fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

pub(crate) fn nifti() -> Vec<Input> {
    let mut seeds = of_name(&[".nii", ".nii.gz"]);
    let mut pair = crate::common::nifti_file::NiftiFile::new(&[3, 2, 4], 4);
    pair.single = false;
    let samples: Vec<u8> = (0..48).collect();
    let header = pair.bytes(&[]);
    seeds.push(Input::files(
        "a.hdr",
        vec![("a.hdr".to_owned(), header), ("a.img".to_owned(), samples)],
    ));
    seeds
}

pub(crate) fn mgh() -> Vec<Input> {
    of_name(&[".mgh", ".mgz"])
}

pub(crate) fn slc() -> Vec<Input> {
    of_name(&[".slc"])
}

pub(crate) fn vti() -> Vec<Input> {
    let mut seeds = of_name(&[".vti"]);
    let styles = vti_file::Style::all().into_iter().step_by(3);
    seeds.extend(styles.map(|style| Input::file("styles.vti", vti_file::file(style))));
    seeds
}

pub(crate) fn legacy_vtk() -> Vec<Input> {
    let mut seeds = of_name(&[".vtk"]);
    let head = "# vtk DataFile Version 3.0\ntitle\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 2 2\nORIGIN 0 0 0\n\
        SPACING 1 1 2\n";
    let data: Vec<u8> = (0..12u16).flat_map(|i| (i * 300).to_be_bytes()).collect();
    let scalars = format!("{head}POINT_DATA 12\nSCALARS a short 1\nLOOKUP_TABLE default\n");
    let field = format!("{head}CELL_DATA 2\nFIELD FieldData 1\nb 1 2 short\n");
    seeds.push(Input::file(
        "binary.vtk",
        [scalars.as_bytes(), &data, b"\n"].concat(),
    ));
    seeds.push(Input::file(
        "cells.vtk",
        [field.as_bytes(), &data[..4], b"\n"].concat(),
    ));
    seeds
}

pub(crate) fn npy() -> Vec<Input> {
    let array = of_writer("a.npy", false);
    let member = |name: &str| (name.to_owned(), array.files[0].1.clone());
    let archive = crate::common::gaussian_files::zip(&[member("first.npy"), member("second.npy")]);
    let mut seeds = of_name(&[".npy"]);
    seeds.extend([array.clone(), Input::file("a.npz", archive)]);
    seeds
}

pub(crate) fn tiff() -> Vec<Input> {
    let mut seeds = of_name(&[".tif"]);
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut encoder = tiff::encoder::TiffEncoder::new(&mut bytes)
        .unwrap()
        .with_compression(tiff::encoder::Compression::Deflate(
            tiff::encoder::DeflateLevel::Fast,
        ));
    let rgb: Vec<u8> = (0..72).collect();
    for _ in 0..2 {
        encoder
            .write_image::<tiff::encoder::colortype::RGB8>(6, 4, &rgb)
            .unwrap();
    }
    seeds.push(Input::file("rgb.tif", bytes.into_inner()));
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut encoder = tiff::encoder::TiffEncoder::new_big(&mut bytes).unwrap();
    let floats: Vec<f32> = (0..24u8).map(f32::from).collect();
    for _ in 0..2 {
        let mut image = encoder
            .new_image::<tiff::encoder::colortype::Gray32Float>(6, 4)
            .unwrap();
        let text = "ImageJ=1.53\nimages=2\nslices=2\nspacing=2.5\nunit=micron\nloop=false\n";
        image
            .encoder()
            .write_tag(tiff::tags::Tag::ImageDescription, text)
            .unwrap();
        image.write_data(&floats).unwrap();
    }
    seeds.push(Input::file("big.tif", bytes.into_inner()));
    seeds
}

/// A folder of pictures.
pub(crate) fn slices() -> Vec<Input> {
    let picture = |first: u8, depth: png::BitDepth| {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 4, 3);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(depth);
        let samples = if depth == png::BitDepth::Sixteen { 24 } else { 12 };
        let data: Vec<u8> = (first..first + samples).collect();
        encoder.write_header().unwrap().write_image_data(&data).unwrap();
        bytes
    };
    let folder = |depth| {
        let files = (0..3u8).map(|i| (format!("slice{i}.png"), picture(20 * i, depth)));
        Input::files("", files.collect())
    };
    let photographs = |text: &str| {
        let files = (0..2).map(|i| (format!("slice{i}.jpg"), codecs::stream(text)));
        Input::files("", files.collect())
    };
    vec![
        folder(png::BitDepth::Eight),
        folder(png::BitDepth::Sixteen),
        photographs(codecs::JPEG),
        photographs(codecs::JPEG_COLORS),
    ]
}

/// The first bytes are the layout, see `target::raw_layout`.
pub(crate) fn raw() -> Vec<Input> {
    let file = |kind: u8, width: usize| {
        let mut bytes = vec![4, 3, 2, kind, 1, kind & 1, 7];
        bytes.extend((0..24 * width).map(|i| (i * 37) as u8));
        Input::file("a.raw", bytes)
    };
    vec![file(0, 1), file(1, 2), file(2, 4), file(3, 8)]
}

pub(crate) fn dicom() -> Vec<Input> {
    let words = [1, 2, 3, 4, 5, 6];
    let slice = |syntax, z: f64| DicomFile::slice(syntax, [1.0, 2.0, z], z as i32, &words);
    let file = |z: f64| (format!("{z}.dcm"), slice(EXPLICIT, z).bytes());
    let mut seeds = of_name(&[".dcm"]);
    seeds.push(Input::file("big.dcm", slice(BIG, 1.0).bytes()));
    seeds.push(Input::file("deflated.dcm", deflated(&slice(EXPLICIT, 1.0))));
    seeds.push(Input::files("", vec![file(1.0), file(2.0), file(3.0)]));
    seeds.push(Input::file("frames.dcm", frames().bytes()));
    seeds.push(Input::file("runs.dcm", runs()));
    let coded = coded_files::FRAMES.iter().chain(&coded_files::COLORS);
    seeds.extend(coded.map(|frame| Input::file("coded.dcm", frame.file())));
    let mut other = slice(IMPLICIT, 1.0);
    other.text(0x0028_1052, b"DS", "-1024");
    other.text(0x0028_1053, b"DS", "2.5");
    other.text(0x0018_0050, b"DS", "3");
    seeds.push(Input::file("scaled.dcm", other.bytes()));
    seeds
}

/// The data set as one stream.
fn deflated(slice: &DicomFile) -> Vec<u8> {
    let mut file = slice.clone();
    file.syntax = "1.2.840.10008.1.2.1.99";
    let mut encoder = flate2::write::DeflateEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(&slice.dataset()).unwrap();
    file.with_body(&encoder.finish().unwrap())
}

/// Three frames with places of their own.
fn frames() -> DicomFile {
    let mut file = DicomFile::slice(EXPLICIT, [0.0; 3], 1, &[0; 6]);
    file.text(0x0028_0008, b"IS", "3");
    file.text(0x0020_0032, b"DS", "");
    file.pixels(&(0..18).collect::<Vec<_>>());
    let frame = |z: u8| {
        let place = element(EXPLICIT, 0x0020_0032, b"DS", format!("0\\0\\{z} ").as_bytes());
        element(EXPLICIT, 0x0020_9113, b"SQ", &items(&[place]))
    };
    file.set(0x5200_9230, b"SQ", items(&[frame(1), frame(2), frame(3)]));
    let measures = element(EXPLICIT, 0x0028_0030, b"DS", b"0.5\\0.25");
    let orientation = element(EXPLICIT, 0x0020_0037, b"DS", b"1\\0\\0\\0\\1\\0 ");
    let shared = [
        element(EXPLICIT, 0x0020_9116, b"SQ", &items(&[orientation])),
        element(EXPLICIT, 0x0028_9110, b"SQ", &items(&[measures])),
    ];
    file.set(0x5200_9229, b"SQ", items(&[shared.concat()]));
    file
}

/// A frame of run lengths: a header of 64 bytes, then the high and the low bytes.
fn runs() -> Vec<u8> {
    let file = DicomFile::slice("1.2.840.10008.1.2.5", [0.0; 3], 1, &[0; 6]);
    let mut frame = vec![0; 64];
    for (place, number) in [(0, 2u32), (4, 64), (8, 66)] {
        frame[place..place + 4].copy_from_slice(&number.to_le_bytes());
    }
    frame.extend([0xfb, 0, 5, 1, 2, 3, 4, 5, 6, 0]);
    file.encapsulated(&[frame])
}
