//! Files whose samples have to be unpacked.

use std::path::{Path, PathBuf};

use splatvol_io::ReadOptions;

use super::cases::{Case, DIMS, bytes, cases, mgh, write};

pub(crate) fn packed(bytes: &[u8], zlib: bool) -> Vec<u8> {
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
pub(crate) fn packed_vti(folder: &Path, shorts: &[u8]) -> Vec<PathBuf> {
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
    let encode = |bytes: &[u8]| base64::engine::general_purpose::STANDARD.encode(bytes);
    let text = encode(&plain);
    // Another array behind it; the header is encoded by itself.
    let (header, data) = (encode(&words), encode(&blocks.concat()));
    let other = format!(
        "format=\"appended\" offset=\"0\"/><DataArray type=\"UInt16\" Name=\"b\" format=\"appended\" offset=\"{}\">",
        header.len() + data.len()
    );
    let both = format!("<AppendedData encoding=\"base64\">\n _{header}{data}{text}</AppendedData>");
    let lz4: Vec<Vec<u8>> = shorts.chunks(size).map(lz4_flex::block::compress).collect();
    let numbers = [2, size, shorts.len() - size, lz4[0].len(), lz4[1].len()];
    let words = numbers.map(|number| (number as u64).to_be_bytes()).concat();
    let inline = encode(&[words, lz4.concat()].concat());
    vec![
        write(
            folder,
            "base64.vti",
            &[&document(
                " compressor=\"vtkZLibDataCompressor\"",
                &other,
                both.as_bytes(),
            )],
        ),
        write(
            folder,
            "lz4.vti",
            &[&document(
                " compressor=\"vtkLZ4DataCompressor\"",
                &format!("format=\"binary\">{inline}"),
                b"",
            )],
        ),
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

/// Finite half-precision numbers of random bits: none has the largest exponent.
fn halves(shorts: &[u8]) -> Vec<u8> {
    let mut bits = shorts.to_vec();
    bits.iter_mut().step_by(2).for_each(|high| *high &= 0xbf);
    bits
}

/// An archive of an array of big-endian numbers.
pub(crate) fn npz(shorts: &[u8], kind: &str) -> Vec<u8> {
    use std::io::Write;

    let [nx, ny, nz] = DIMS;
    let text = format!("{{'descr': '>{kind}', 'fortran_order': False, 'shape': ({nz}, {ny}, {nx}), }}");
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

/// Digits, and numbers as text, several at each sample; runs of bytes.
fn parsed_cases(folder: &Path, shorts: &[u8], text: &str) -> Vec<Case> {
    let [nx, ny, _] = DIMS;
    let of = |name: &str, parts: &[&[u8]], component: Option<usize>| Case {
        path: write(folder, name, parts),
        options: ReadOptions {
            component,
            ..ReadOptions::default()
        },
    };
    let nrrd = |sizes: &str, more: &str| {
        format!("NRRD0005\ntype: uint16\nsizes: {sizes}\nendian: big\n{more}\n\n").into_bytes()
    };
    let digits: String = shorts[..nx * ny * 22]
        .iter()
        .enumerate()
        .map(|(i, byte)| format!("{byte:02x}{}", if i % 30 == 29 { "\n" } else { "" }))
        .collect();
    let vectors = format!("3 {nx} {ny} 11");
    let words: Vec<&str> = text.split_ascii_whitespace().take(3 * nx * ny * 11).collect();
    let words = words.join(" ") + "\n";
    let vtk = format!(
        "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS {nx} {ny} 11\nPOINT_DATA {}\nVECTORS v unsigned_short\n",
        nx * ny * 11
    );
    let extent = format!("0 {} 0 {} 0 10", nx - 1, ny - 1);
    let vti = format!(
        "<?xml version=\"1.0\"?><VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\"><ImageData WholeExtent=\"{extent}\" Origin=\"0 0 0\" Spacing=\"1 1 2\"><Piece Extent=\"{extent}\"><PointData><DataArray type=\"UInt16\" Name=\"a\" NumberOfComponents=\"3\" format=\"ascii\">{words}</DataArray></PointData></Piece></ImageData></VTKFile>"
    );
    // Runs of three equal bytes, the last of fewer.
    let runs: Vec<u8> = (0..(nx * ny).div_ceil(3))
        .flat_map(|run| [(nx * ny - 3 * run).min(3) as u8, shorts[run]])
        .collect();
    let slc = format!("11111 {nx} {ny} 2 8 1 1 2 1 0 0 1 0 0 X");
    let length = format!("{} X", runs.len());
    let slices = [slc.as_bytes(), length.as_bytes(), &runs, length.as_bytes(), &runs];
    let hex = nrrd(&format!("{nx} {ny} 11"), "dimension: 3\nencoding: hex");
    let kinds = "dimension: 4\nkinds: vector space space space\nencoding: ascii";
    let bytes = words.as_bytes();
    // Vectors have to be named.
    let named = |array: &str, case: Case| Case {
        options: ReadOptions {
            array: Some(array.to_owned()),
            ..ReadOptions::default()
        },
        ..case
    };
    vec![
        named("v:1", of("y.vtk", &[vtk.as_bytes(), bytes], None)),
        named("a:magnitude", of("z.vti", &[vti.as_bytes()], None)),
        of("w.nrrd", &[&hex, digits.as_bytes()], None),
        of("x.nrrd", &[&nrrd(&vectors, kinds), bytes], Some(2)),
        of("a.slc", &slices, None),
    ]
}

/// Text in several files, and components of samples in two.
fn torn_cases(folder: &Path, shorts: &[u8], text: &str) -> Vec<Case> {
    let [nx, ny, _] = DIMS;
    let of = |name: &str, header: &str, parts: Vec<Vec<u8>>, component: Option<usize>| {
        let mut list = String::new();
        for (part, bytes) in parts.iter().enumerate() {
            let own = format!("{name}.{part}");
            write(folder, &own, &[bytes]);
            list += &format!("{own}\n");
        }
        let header = format!("NRRD0005\ntype: uint16\nendian: big\n{header}\ndata file: LIST\n{list}");
        Case {
            path: write(folder, name, &[header.as_bytes()]),
            options: ReadOptions {
                component,
                ..ReadOptions::default()
            },
        }
    };
    // Four files for three volumes; two files, the first of which ends within a sample's four numbers.
    let (written, torn) = (3 * nx * ny * 8, 4 * nx * ny * 7);
    let words: Vec<&str> = text.split_ascii_whitespace().take(written).collect();
    let texts = words.chunks(written / 4).map(|part| part.join("\n").into_bytes());
    let halves = shorts[..2 * torn].chunks(torn).map(<[u8]>::to_vec);
    let volumes =
        format!("encoding: ascii\ndimension: 4\nsizes: {nx} {ny} 8 3\nkinds: space space space vector");
    let vectors =
        format!("encoding: raw\ndimension: 4\nsizes: 4 {nx} {ny} 7\nkinds: vector space space space");
    vec![
        of("texts.nhdr", &volumes, texts.collect(), Some(1)),
        of("torn.nhdr", &vectors, halves.collect(), Some(2)),
    ]
}

/// Files whose samples are compressed, in several files, or between others.
pub(crate) fn packed_cases(folder: &Path) -> Vec<Case> {
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
        plain(write(folder, "s.npz", &[&npz(&shorts, "u2")])),
        plain(write(folder, "h.npz", &[&npz(&halves(&shorts), "f2")])),
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
    // The second ends with its last digit, which a warning says.
    for (name, text) in [("u.vtk", &text[..]), ("v.vtk", text.trim_end())] {
        cases.push(plain(write(folder, name, &[head.as_bytes(), text.as_bytes()])));
    }
    // Behind an array of more than is searched at first.
    let (count, far) = (nx * ny * nz, vec![0; 3 * nx * ny * nz]);
    let head = format!(
        "# vtk DataFile Version 2.0\ntitle\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS {whole}\nPOINT_DATA {count}\nFIELD all 2\nfar 3 {count} unsigned_char\n"
    );
    let wanted = format!("\nb 1 {count} unsigned_short\n");
    cases.push(Case {
        path: write(
            folder,
            "far.vtk",
            &[head.as_bytes(), &far, wanted.as_bytes(), &shorts],
        ),
        options: ReadOptions {
            array: Some("b".to_owned()),
            ..ReadOptions::default()
        },
    });
    cases.extend(parsed_cases(folder, &shorts, &text));
    cases.extend(torn_cases(folder, &shorts, &text));
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
