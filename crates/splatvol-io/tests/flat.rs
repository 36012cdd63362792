//! Samples that lie uncompressed in one file, read box by box: those of the same file in memory.
#![allow(clippy::unwrap_used, reason = "panics are how tests fail")]

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;
use splatvol_io::{
    Endian, Opened, PyramidOptions, RawLayout, ReadOptions, SampleType, open_volume, read_volume,
    write_pyramid,
};
use splatvol_scene::{ChunkBuffer, ChunkSource, Samples, SourceError, VoxelBox};

const DIMS: [usize; 3] = [301, 37, 35];

/// Bytes from a seed; as floats, none is missing.
fn bytes(count: usize, size: usize, float: bool) -> Vec<u8> {
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

fn swapped(data: &[u8], size: usize) -> Vec<u8> {
    data.chunks(size)
        .flat_map(|word| word.iter().rev().copied())
        .collect()
}

struct Case {
    path: PathBuf,
    options: ReadOptions,
}

fn write(folder: &Path, name: &str, parts: &[&[u8]]) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, parts.concat()).unwrap();
    path
}

/// An MGH file of two time points, with parameters behind them.
fn mgh(shorts: &[u8]) -> Vec<u8> {
    let mut header = vec![0u8; 284];
    let sizes = DIMS.map(|n| n as i32);
    let numbers = [1, sizes[0], sizes[1], sizes[2], 2, 4];
    for (index, number) in numbers.into_iter().enumerate() {
        header[4 * index..4 * index + 4].copy_from_slice(&number.to_be_bytes());
    }
    [&header, shorts, shorts, b"parameters"].concat()
}

/// Files of VTK, whose samples lie behind those of another array.
fn vtk_cases(folder: &Path) -> Vec<Case> {
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

/// A file of each format and layout.
fn cases(folder: &Path) -> Vec<Case> {
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

#[test]
fn boxes_hold_what_the_file_holds_in_memory() {
    let folder = tempfile::tempdir().unwrap();
    for Case { path, options } in cases(folder.path()) {
        let name = path.display();
        let memory = read_volume(&path, &options).unwrap_or_else(|error| panic!("{name}: {error}"));
        let opened = open_volume(&path, &options)
            .unwrap()
            .unwrap_or_else(|| panic!("{name} is not opened"));
        assert_eq!(opened.description, memory.description, "{name}");
        assert_eq!(opened.unit, memory.volume.unit(), "{name}");
        let layout = opened.source.levels()[0].clone();
        assert_eq!(layout.grid, *memory.volume.grid(), "{name}");
        assert_eq!(layout.rescale, memory.volume.rescale(), "{name}");
        let (mut buffer, mut found) = (ChunkBuffer::default(), Samples::U8(Vec::new().into()));
        let whole = VoxelBox::whole(&layout.grid);
        splatvol_scene::chunks::read_by_chunks(&*opened.source, 0, whole, &mut found, &mut buffer).unwrap();
        assert!(found == *memory.volume.samples(), "{name}: chunks");
        opened
            .source
            .read_region(0, whole, &mut found, &mut buffer)
            .unwrap();
        assert!(found == *memory.volume.samples(), "{name}: whole");
        let part = VoxelBox {
            first: [3, 5, 30],
            size: [290, 7, 5],
        };
        opened
            .source
            .read_region(0, part, &mut found, &mut buffer)
            .unwrap();
        let mut expected = layout.element.filled(part.len(), 0.0);
        splatvol_scene::chunks::copy_box(memory.volume.samples(), whole, &mut expected, part);
        assert!(found == expected, "{name}: part");
    }
}

/// The files of a folder and of those in it, with their bytes.
fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut all = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            match path.is_dir() {
                true => folders.push(path),
                false => all.push((
                    path.strip_prefix(folder).unwrap().to_owned(),
                    std::fs::read(&path).unwrap(),
                )),
            }
        }
    }
    all.sort();
    all
}

#[test]
fn pyramids_of_flat_files_are_those_of_volumes_in_memory() {
    let folder = tempfile::tempdir().unwrap();
    for (n, Case { path, options }) in cases(folder.path()).into_iter().enumerate() {
        let opened = open_volume(&path, &options).unwrap().unwrap();
        let loaded = read_volume(&path, &options).unwrap();
        let in_memory = Opened {
            unit: loaded.volume.unit(),
            is_divided: false,
            description: loaded.description,
            source: Box::<dyn ChunkSource>::from(Arc::new(loaded.volume)).into(),
        };
        let write = |volume: &Opened, name: &str, memory: u64| {
            let output = folder.path().join(format!("{n}-{name}.ome.zarr"));
            let pyramid = PyramidOptions {
                chunk: 16,
                memory,
                ..PyramidOptions::default()
            };
            write_pyramid(volume, &output, &pyramid, &|_| ()).unwrap();
            files(&output)
        };
        let expected = write(&in_memory, "memory", 1 << 30);
        assert!(write(&opened, "flat", 16 << 20) == expected, "{}", path.display());
    }
}

#[test]
fn short_files_are_refused_and_those_that_shrink_are_named() {
    let folder = tempfile::tempdir().unwrap();
    for Case { path, options } in cases(folder.path()) {
        let file = match path.extension().and_then(|extension| extension.to_str()) {
            Some("nhdr") => folder.path().join("detached.raw"),
            Some("mhd") => folder.path().join("detached.zraw"),
            _ => path.clone(),
        };
        let whole = std::fs::read(&file).unwrap();
        let opened = open_volume(&path, &options).unwrap().unwrap();
        std::fs::write(&file, &whole[..whole.len() - 1000]).unwrap();
        let layout = opened.source.levels()[0].clone();
        let last = layout.counts().map(|count| count - 1);
        let error = opened
            .source
            .read(0, last, &mut ChunkBuffer::default())
            .unwrap_err();
        assert!(matches!(error, SourceError::Corrupt(_)), "{error}");
        let text = error.to_string();
        let name = file.file_name().unwrap().to_str().unwrap();
        assert!(text.contains(name) && text.contains("from byte"), "{text}");
        let error = open_volume(&path, &options).unwrap_err().to_string();
        assert!(error.contains(&*path.display().to_string()), "{error}");
        std::fs::write(&file, whole).unwrap();
    }
}

#[test]
fn texts_of_other_lengths_are_told_when_they_are_unpacked() {
    let folder = tempfile::tempdir().unwrap();
    let options = ReadOptions {
        unpack_in: Some(folder.path().to_owned()),
        ..ReadOptions::default()
    };
    let header = "NRRD0004\ntype: int16\ndimension: 3\nsizes: 2 2 2\nencoding: ascii\n\n";
    let of = |numbers: &str| write(folder.path(), "a.nrrd", &[header.as_bytes(), numbers.as_bytes()]);
    for (numbers, words) in [("1 2 3 4 5 6 7", "8 numbers"), ("1 2 3 4 5 6 7 x", "i16")] {
        let error = open_volume(of(numbers), &options).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    let path = of("1 2 3 4 5 6 7 8 9");
    let opened = open_volume(&path, &options).unwrap().unwrap();
    assert_eq!(
        opened.description,
        read_volume(&path, &options).unwrap().description
    );
    assert!(!opened.description.warnings.is_empty());
}

#[test]
fn integers_of_64_bits_become_floats() {
    let folder = tempfile::tempdir().unwrap();
    let [nx, ny, nz] = DIMS;
    let longs = bytes(nx * ny * nz, 8, true);
    let header = format!("NRRD0004\ntype: int64\ndimension: 3\nsizes: {nx} {ny} {nz}\n");
    let endian = "encoding: raw\nendian: little\n\n";
    let path = write(
        folder.path(),
        "a.nrrd",
        &[header.as_bytes(), endian.as_bytes(), &longs],
    );
    let memory = read_volume(&path, &ReadOptions::default()).unwrap();
    let opened = open_volume(&path, &ReadOptions::default()).unwrap().unwrap();
    let (mut buffer, mut found) = (ChunkBuffer::default(), Samples::U8(Vec::new().into()));
    let whole = VoxelBox::whole(memory.volume.grid());
    opened
        .source
        .read_region(0, whole, &mut found, &mut buffer)
        .unwrap();
    assert!(found == *memory.volume.samples());
    let strict = ReadOptions {
        strict: true,
        ..ReadOptions::default()
    };
    assert!(open_volume(&path, &strict).unwrap().is_none());
    for description in [&opened.description, &memory.description] {
        let warnings = &description.warnings;
        assert!(
            warnings.iter().any(|warning| warning.contains("2^53")),
            "{warnings:?}"
        );
    }
}

#[test]
fn compressed_files_are_read_whole() {
    let folder = tempfile::tempdir().unwrap();
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: gzip\n\n";
    let path = write(folder.path(), "a.nrrd", &[header.as_bytes(), b"none"]);
    assert!(open_volume(&path, &ReadOptions::default()).unwrap().is_none());
}

fn packed(bytes: &[u8], zlib: bool) -> Vec<u8> {
    use flate2::Compression;
    use flate2::write::{GzEncoder, ZlibEncoder};
    use std::io::Write;

    if zlib {
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(bytes).unwrap();
        return encoder.finish().unwrap();
    }
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// VTI files whose array is compressed in blocks, or text in base64.
fn packed_vti(folder: &Path, shorts: &[u8]) -> Vec<PathBuf> {
    use base64::Engine;

    let extent = DIMS.map(|n| format!("0 {}", n - 1)).join(" ");
    let document = |compressor: &str, array: &str, appended: &[u8]| {
        let xml = format!(
            "<?xml version=\"1.0\"?><VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"BigEndian\" header_type=\"UInt64\"{compressor}><ImageData WholeExtent=\"{extent}\" Origin=\"0 0 0\" Spacing=\"1 1 2\"><Piece Extent=\"{extent}\"><PointData Scalars=\"a\"><DataArray type=\"UInt16\" Name=\"a\" {array}</DataArray></PointData></Piece></ImageData>"
        );
        [xml.as_bytes(), appended, b"</VTKFile>"].concat()
    };
    let size = shorts.len() / 4 * 2 + 2;
    let blocks: Vec<Vec<u8>> = shorts.chunks(size).map(|block| packed(block, true)).collect();
    let numbers = [2, size, shorts.len() - size, blocks[0].len(), blocks[1].len()];
    let words = numbers.map(|number| (number as u64).to_be_bytes()).concat();
    let appended = [
        b"<AppendedData encoding=\"raw\">_".as_slice(),
        &words,
        &blocks.concat(),
        b"</AppendedData>",
    ]
    .concat();
    let plain = [&(shorts.len() as u64).to_be_bytes(), shorts].concat();
    let text = base64::engine::general_purpose::STANDARD.encode(plain);
    vec![
        write(
            folder,
            "q.vti",
            &[&document(
                " compressor=\"vtkZLibDataCompressor\"",
                "format=\"appended\" offset=\"0\">",
                &appended,
            )],
        ),
        write(
            folder,
            "r.vti",
            &[&document("", &format!("format=\"binary\">{text}"), b"")],
        ),
    ]
}

/// An archive of an array.
fn npz(shorts: &[u8]) -> Vec<u8> {
    use std::io::Write;

    let [nx, ny, nz] = DIMS;
    let text = format!("{{'descr': '>u2', 'fortran_order': False, 'shape': ({nz}, {ny}, {nx}), }}");
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    archive
        .start_file("a.npy", zip::write::SimpleFileOptions::default())
        .unwrap();
    let head = [b"\x93NUMPY\x01\x00".as_slice(), &118u16.to_le_bytes()].concat();
    archive.write_all(&head).unwrap();
    archive.write_all(format!("{text:<117}\n").as_bytes()).unwrap();
    archive.write_all(shorts).unwrap();
    archive.finish().unwrap().into_inner()
}

/// Files whose samples are compressed, in several files, or between others.
fn packed_cases(folder: &Path) -> Vec<Case> {
    let [nx, ny, nz] = DIMS;
    let shorts = bytes(nx * ny * nz, 2, false);
    let plain = |path| Case {
        path,
        options: ReadOptions::default(),
    };
    let nrrd = |dimension: usize, sizes: &str, encoding: &str, more: &str| {
        format!(
            "NRRD0005\ntype: uint16\ndimension: {dimension}\nsizes: {sizes}\nencoding: {encoding}\nendian: big\n{more}"
        )
    };
    let whole = format!("{nx} {ny} {nz}");
    let meta = format!(
        "ObjectType = Image\nNDims = 3\nDimSize = {whole}\nElementType = MET_SHORT\nCompressedData = True\nElementDataFile = LOCAL\n"
    );
    let nifti = cases(folder).into_iter().nth(7).unwrap();
    let list: String = (0..5).map(|part| format!("part{part}.gz\n")).collect();
    for (part, samples) in shorts.chunks_exact(shorts.len() / 5).enumerate() {
        write(folder, &format!("part{part}.gz"), &[&packed(samples, false)]);
    }
    let mut cases = vec![
        plain(write(
            folder,
            "k.nrrd",
            &[nrrd(3, &whole, "gzip", "\n").as_bytes(), &packed(&shorts, false)],
        )),
        plain(write(folder, "l.mha", &[meta.as_bytes(), &packed(&shorts, true)])),
        Case {
            path: write(
                folder,
                "m.nii.gz",
                &[&packed(&std::fs::read(&nifti.path).unwrap(), false)],
            ),
            options: nifti.options,
        },
        plain(write(folder, "p.mgz", &[&packed(&mgh(&shorts), false)])),
        plain(write(folder, "s.npz", &[&npz(&shorts)])),
        plain(write(
            folder,
            "n.nhdr",
            &[nrrd(3, &whole, "gzip", &format!("data file: LIST\n{list}")).as_bytes()],
        )),
    ];
    cases.extend(packed_vti(folder, &shorts).into_iter().map(plain));
    let text: String = shorts
        .chunks_exact(2)
        .enumerate()
        .map(|(i, word)| {
            let blank = if i % 9 == 8 { '\n' } else { ' ' };
            format!("{}{blank}", u16::from_be_bytes([word[0], word[1]]))
        })
        .collect();
    cases.push(plain(write(
        folder,
        "t.nrrd",
        &[nrrd(3, &whole, "ascii", "\n").as_bytes(), text.as_bytes()],
    )));
    let head = format!(
        "# vtk DataFile Version 2.0\ntitle\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS {whole}\nPOINT_DATA {}\nSCALARS v unsigned_short\nLOOKUP_TABLE default\n",
        nx * ny * nz
    );
    cases.push(plain(write(folder, "u.vtk", &[head.as_bytes(), text.as_bytes()])));
    // Three numbers a sample, of which one is read.
    let colours = nrrd(
        4,
        &format!("3 {nx} {ny} 11"),
        "gzip",
        "kinds: vector space space space\n\n",
    );
    let samples = &shorts[..3 * nx * ny * 11 * 2];
    cases.push(Case {
        path: write(folder, "o.nrrd", &[colours.as_bytes(), &packed(samples, false)]),
        options: ReadOptions {
            component: Some(1),
            ..ReadOptions::default()
        },
    });
    cases
}

#[test]
fn packed_samples_are_unpacked_where_that_is_allowed() {
    let folder = tempfile::tempdir().unwrap();
    let other = tempfile::tempdir().unwrap();
    for Case { path, options } in packed_cases(folder.path()) {
        let name = path.display();
        assert!(open_volume(&path, &options).unwrap().is_none(), "{name}");
        let allowed = ReadOptions {
            unpack_in: Some(other.path().to_owned()),
            // What is read box by box need not fit.
            max_bytes: 1000,
            ..options.clone()
        };
        let opened = open_volume(&path, &allowed).unwrap().unwrap();
        let loaded = read_volume(&path, &options).unwrap();
        assert_eq!(opened.description, loaded.description, "{name}");
        let layout = &opened.source.levels()[0];
        assert_eq!(&layout.grid, loaded.volume.grid(), "{name}");
        let whole = VoxelBox::whole(&layout.grid);
        let mut found = Samples::U8(Vec::new().into());
        opened
            .source
            .read_region(0, whole, &mut found, &mut ChunkBuffer::default())
            .unwrap();
        assert!(found == *loaded.volume.samples(), "{name}");
        drop(opened);
        assert_eq!(std::fs::read_dir(other.path()).unwrap().count(), 0, "{name}");
    }
}

#[test]
fn packed_samples_that_are_damaged_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for Case { path, options } in packed_cases(folder.path()) {
        let allowed = ReadOptions {
            unpack_in: Some(folder.path().to_owned()),
            ..options
        };
        let whole = std::fs::read(&path).unwrap();
        if path.extension().unwrap() == "nhdr" {
            std::fs::remove_file(folder.path().join("part3.gz")).unwrap();
        } else {
            std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
        }
        let error = open_volume(&path, &allowed).unwrap_err().to_string();
        assert!(!error.is_empty(), "{}", path.display());
    }
}
