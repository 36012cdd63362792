//! Files of every format and layout whose samples lie in them as they are.

use std::path::{Path, PathBuf};

use glam::DVec3;
use splatvol_io::{Endian, RawLayout, ReadOptions, SampleType};

pub(crate) const DIMS: [usize; 3] = [301, 37, 35];

/// Bytes from a seed; as floats, none is missing.
pub(crate) fn bytes(count: usize, size: usize, float: bool) -> Vec<u8> {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut next = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as u32
    };
    (0..count)
        .flat_map(|_| {
            let value = next();
            match (float, size) {
                (true, 4) => (value as f32 / 1e9).to_le_bytes().to_vec(),
                (true, _) => (f64::from(value) / 1e9).to_le_bytes().to_vec(),
                (false, _) => value.to_le_bytes()[..size].to_vec(),
            }
        })
        .collect()
}

pub(crate) fn swapped(data: &[u8], size: usize) -> Vec<u8> {
    data.chunks(size)
        .flat_map(|word| word.iter().rev().copied())
        .collect()
}

pub(crate) struct Case {
    pub(crate) path: PathBuf,
    pub(crate) options: ReadOptions,
}

pub(crate) fn write(folder: &Path, name: &str, parts: &[&[u8]]) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, parts.concat()).unwrap();
    path
}

/// An MGH file of two time points, with parameters behind them.
pub(crate) fn mgh(shorts: &[u8]) -> Vec<u8> {
    let mut header = vec![0u8; 284];
    let sizes = DIMS.map(|n| n as i32);
    let numbers = [1, sizes[0], sizes[1], sizes[2], 2, 4];
    for (index, number) in numbers.into_iter().enumerate() {
        header[4 * index..4 * index + 4].copy_from_slice(&number.to_be_bytes());
    }
    [&header, shorts, shorts, b"parameters"].concat()
}

/// Files of VTK, whose samples lie behind those of another array.
pub(crate) fn vtk_cases(folder: &Path) -> Vec<Case> {
    let [nx, ny, nz] = DIMS;
    let count = nx * ny * nz;
    let (small, doubles) = (bytes(count, 1, false), bytes(count, 8, true));
    let head = format!(
        "# vtk DataFile Version 3.0\ntitle\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS {nx} {ny} {nz}\nORIGIN 1 2 3\nSPACING 1 2 0.5\nPOINT_DATA {count}\n"
    );
    let scalars = |kind: &str| format!("SCALARS values {kind} 1\nLOOKUP_TABLE default\n");
    let extent = format!("0 {} 0 {} 0 {}", nx - 1, ny - 1, nz - 1);
    let array = |name: &str, kind: &str, offset: usize| {
        format!("<DataArray type=\"{kind}\" Name=\"{name}\" format=\"appended\" offset=\"{offset}\"/>")
    };
    let xml = format!(
        "<?xml version=\"1.0\"?><VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\"><ImageData WholeExtent=\"{extent}\" Origin=\"0 0 0\" Spacing=\"1 1 2\"><Piece Extent=\"{extent}\"><PointData Scalars=\"second\">{}{}</PointData></Piece></ImageData><AppendedData encoding=\"raw\">\n _",
        array("first", "UInt8", 0),
        array("second", "Float64", 8 + count),
    );
    let word = |bytes: usize| (bytes as u64).to_le_bytes();
    let vti = [
        xml.as_bytes(),
        &word(count),
        &small,
        &word(8 * count),
        &doubles,
        b"\n</AppendedData></VTKFile>",
    ];
    vec![
        write(
            folder,
            "l.vtk",
            &[head.as_bytes(), scalars("unsigned_char").as_bytes(), &small],
        ),
        write(
            folder,
            "m.vtk",
            &[
                head.as_bytes(),
                scalars("double").as_bytes(),
                &swapped(&doubles, 8),
            ],
        ),
        write(folder, "n.vti", &vti),
    ]
    .into_iter()
    .map(|path| Case {
        path,
        options: ReadOptions::default(),
    })
    .collect()
}

/// Files with three numbers at each sample, of which one is read, or their length.
pub(crate) fn vector_cases(folder: &Path) -> Vec<Case> {
    let [nx, ny, nz] = DIMS;
    let count = nx * ny * nz;
    let (floats, shorts) = (bytes(3 * count, 4, true), bytes(3 * count, 2, false));
    let head = format!(
        "# vtk DataFile Version 3.0\ntitle\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS {nx} {ny} {nz}\nORIGIN 0 0 0\nSPACING 1 1 1\nPOINT_DATA {count}\nVECTORS wind float\n"
    );
    let extent = format!("0 {} 0 {} 0 {}", nx - 1, ny - 1, nz - 1);
    let xml = format!(
        "<?xml version=\"1.0\"?><VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\"><ImageData WholeExtent=\"{extent}\" Origin=\"0 0 0\" Spacing=\"1 1 1\"><Piece Extent=\"{extent}\"><PointData><DataArray type=\"UInt16\" Name=\"wind\" NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/></PointData></Piece></ImageData><AppendedData encoding=\"raw\">\n _"
    );
    let length = (shorts.len() as u64).to_le_bytes();
    let end = b"\n</AppendedData></VTKFile>";
    let paths = [
        write(folder, "v.vtk", &[head.as_bytes(), &swapped(&floats, 4)]),
        write(folder, "v.vti", &[xml.as_bytes(), &length, &shorts, end]),
    ];
    let of_path = |path: PathBuf| {
        ["wind:1", "wind:magnitude"].map(|array| Case {
            path: path.clone(),
            options: ReadOptions {
                array: Some(array.to_owned()),
                ..ReadOptions::default()
            },
        })
    };
    let nrrd = format!(
        "NRRD0005\ntype: uint16\ndimension: 4\nsizes: 3 {nx} {ny} {nz}\nkinds: vector domain domain domain\nencoding: raw\nendian: big\n\n"
    );
    let component = Case {
        path: write(folder, "v.nrrd", &[nrrd.as_bytes(), &shorts]),
        options: ReadOptions {
            component: Some(2),
            ..ReadOptions::default()
        },
    };
    let all = paths.into_iter().flat_map(of_path);
    all.chain([component]).collect()
}

/// A file of each format and layout.
pub(crate) fn cases(folder: &Path) -> Vec<Case> {
    let [nx, ny, nz] = DIMS;
    let count = nx * ny * nz;
    let (shorts, floats, doubles) = (
        bytes(count, 2, false),
        bytes(count, 4, true),
        bytes(count, 8, true),
    );
    let (small, volumes) = (bytes(count, 1, false), bytes(2 * count, 2, false));
    let space = "space: left-posterior-superior\nspace directions: (0.5,0,0) (0,0.7,0.1) (0,0,2)\nspace origin: (1,2,3)";
    let nrrd = |kind: &str, more: &str| {
        format!("NRRD0005\ntype: {kind}\ndimension: 3\nsizes: {nx} {ny} {nz}\nencoding: raw\n{space}\n{more}")
    };
    let meta = |kind: &str, more: &str| {
        format!(
            "ObjectType = Image\nNDims = 3\nDimSize = {nx} {ny} {nz}\nElementType = {kind}\nElementSpacing = 1 2 3\n{more}\n"
        )
    };
    let npy = |kind: &str, order: &str, shape: [usize; 3]| {
        let [a, b, c] = shape;
        let text = format!("{{'descr': '{kind}', 'fortran_order': {order}, 'shape': ({a}, {b}, {c}), }}");
        let text = format!("{text:<117}\n");
        [
            b"\x93NUMPY\x01\x00".as_slice(),
            &118u16.to_le_bytes(),
            text.as_bytes(),
        ]
        .concat()
    };
    let mut nifti = vec![0u8; 352];
    nifti[..4].copy_from_slice(&348i32.to_le_bytes());
    for (index, value) in [4, nx as i16, ny as i16, nz as i16, 2].into_iter().enumerate() {
        nifti[40 + 2 * index..42 + 2 * index].copy_from_slice(&value.to_le_bytes());
    }
    nifti[70..72].copy_from_slice(&512i16.to_le_bytes());
    nifti[72..74].copy_from_slice(&16i16.to_le_bytes());
    for (index, value) in [1.0f32, 0.5, 0.6, 0.7].into_iter().enumerate() {
        nifti[76 + 4 * index..80 + 4 * index].copy_from_slice(&value.to_le_bytes());
    }
    for (at, value) in [(108, 352.0f32), (112, 0.5), (116, -3.0)] {
        nifti[at..at + 4].copy_from_slice(&value.to_le_bytes());
    }
    nifti[344..348].copy_from_slice(b"n+1\0");
    write(folder, "detached.raw", &[b"headbytes", &floats]);
    write(folder, "detached.zraw", &[&swapped(&shorts, 2)]);
    let raw = RawLayout {
        dims: DIMS,
        sample_type: SampleType::I16,
        spacing: DVec3::new(1.0, 2.0, 3.0),
        endian: Endian::Big,
        offset: 7,
    };
    let plain = |path| Case {
        path,
        options: ReadOptions::default(),
    };
    let mut cases = vec![
        Case {
            path: write(folder, "a.bin", &[b"skipped", &shorts]),
            options: ReadOptions {
                raw: Some(raw),
                ..ReadOptions::default()
            },
        },
        plain(write(folder, &format!("b_{nx}x{ny}x{nz}_uint8.raw"), &[&small])),
        plain(write(
            folder,
            "c.nrrd",
            &[nrrd("uint16", "endian: big\n\n").as_bytes(), &shorts],
        )),
        plain(write(
            folder,
            "d.nhdr",
            &[nrrd("float", "endian: little\nbyte skip: 9\ndata file: detached.raw\n").as_bytes()],
        )),
        plain(write(
            folder,
            "e.nhdr",
            &[nrrd(
                "float",
                "endian: little\nbyte skip: -1\ndata file: detached.raw\n",
            )
            .as_bytes()],
        )),
        plain(write(
            folder,
            "f.mha",
            &[
                meta(
                    "MET_DOUBLE",
                    "ElementByteOrderMSB = False\nElementDataFile = LOCAL",
                )
                .as_bytes(),
                &doubles,
            ],
        )),
        plain(write(
            folder,
            "g.mhd",
            &[meta(
                "MET_SHORT",
                "ElementByteOrderMSB = True\nElementDataFile = detached.zraw",
            )
            .as_bytes()],
        )),
        Case {
            path: write(folder, "h.nii", &[&nifti, &volumes]),
            options: ReadOptions {
                time: Some(1),
                ..ReadOptions::default()
            },
        },
        plain(write(
            folder,
            "i.npy",
            &[&npy(">i2", "False", [nz, ny, nx]), &shorts],
        )),
        plain(write(
            folder,
            "j.npy",
            &[&npy("<f4", "True", [nx, ny, nz]), &floats],
        )),
        Case {
            path: write(folder, "k.mgh", &[&mgh(&shorts)]),
            options: ReadOptions {
                time: Some(1),
                ..ReadOptions::default()
            },
        },
    ];
    cases.extend(vtk_cases(folder));
    cases
}
