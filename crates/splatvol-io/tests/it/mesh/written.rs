//! Files written here, byte by byte: codings that no real file at hand has.

use std::io::Write;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use splatvol_io::{is_mesh, read_mesh};
use splatvol_scene::{CellKind, Topology};

use super::{array, read};

const DIMS: [usize; 3] = [4, 3, 2];

/// Coordinates of a sheared block, all of x first.
fn coordinates() -> [Vec<f64>; 3] {
    let at = |n: usize| {
        let (i, j, k) = (n % 4, n / 4 % 3, n / 12);
        [i as f64 + 0.5 * j as f64, 2.0 * j as f64, k as f64 * 1.25]
    };
    [0, 1, 2].map(|axis| (0..24).map(|n| at(n)[axis]).collect())
}

/// Style of a written PLOT3D file.
#[derive(Clone, Copy, Debug)]
struct Style {
    little: bool,
    records: bool,
    several: bool,
    wide: bool,
    blanked: bool,
}

impl Style {
    fn integer(self, value: i32) -> Vec<u8> {
        if self.little {
            value.to_le_bytes().to_vec()
        } else {
            value.to_be_bytes().to_vec()
        }
    }

    fn real(self, value: f64) -> Vec<u8> {
        match (self.wide, self.little) {
            (true, true) => value.to_le_bytes().to_vec(),
            (true, false) => value.to_be_bytes().to_vec(),
            (false, true) => (value as f32).to_le_bytes().to_vec(),
            (false, false) => (value as f32).to_be_bytes().to_vec(),
        }
    }

    fn record(self, bytes: &[u8]) -> Vec<u8> {
        let mark = if self.records {
            self.integer(bytes.len() as i32)
        } else {
            Vec::new()
        };
        [&mark, bytes, &mark].concat()
    }

    fn head(self) -> Vec<u8> {
        let grids = if self.several { 2 } else { 1 };
        let dims: Vec<u8> = (0..grids)
            .flat_map(|_| DIMS)
            .flat_map(|n| self.integer(n as i32))
            .collect();
        let count = if self.several {
            self.record(&self.integer(grids))
        } else {
            Vec::new()
        };
        [count, self.record(&dims)].concat()
    }

    fn grid(self) -> Vec<u8> {
        let mut bytes = self.head();
        for block in 0..if self.several { 2 } else { 1 } {
            let shift = 10.0 * f64::from(block);
            let reals = coordinates()
                .concat()
                .into_iter()
                .flat_map(|c| self.real(c + shift));
            let marks = (0..24).flat_map(|n| self.integer(i32::from(n != 5)));
            let blanks: Vec<u8> = if self.blanked { marks.collect() } else { Vec::new() };
            bytes.extend(self.record(&[reals.collect(), blanks].concat()));
        }
        bytes
    }

    fn solution(self) -> Vec<u8> {
        let mut bytes = self.head();
        for _ in 0..if self.several { 2 } else { 1 } {
            bytes.extend(self.record(&[0.5, 0.0, 1e4, 0.0].map(|v| self.real(v)).concat()));
            // rho = 2, momentum (6, 0, 8), e = n: pressure 0.4 (n - 25).
            let variables = [
                [2.0; 24],
                [6.0; 24],
                [0.0; 24],
                [8.0; 24],
                std::array::from_fn(|n| n as f64),
            ];
            let reals = variables.concat().into_iter().flat_map(|v| self.real(v));
            bytes.extend(self.record(&reals.collect::<Vec<_>>()));
        }
        bytes
    }
}

#[test]
fn plot3d_is_read_in_every_layout() {
    let folder = tempfile::tempdir().unwrap();
    let (grid, solution) = (folder.path().join("a.xyz"), folder.path().join("a.q"));
    for bits in 0..32u8 {
        let [little, records, several, wide, blanked] = [0, 1, 2, 3, 4].map(|bit| bits >> bit & 1 == 1);
        let style = Style {
            little,
            records,
            several,
            wide,
            blanked,
        };
        std::fs::write(&grid, style.grid()).unwrap();
        std::fs::write(&solution, style.solution()).unwrap();
        assert!(
            is_mesh(&grid).unwrap() && is_mesh(&solution).unwrap(),
            "{style:?}"
        );
        let pressure = read(&grid, Some("Pressure")).mesh;
        let blocks = if several { 2 } else { 1 };
        assert_eq!(
            pressure.topology(),
            &Topology::Structured(vec![DIMS; blocks]),
            "{style:?}"
        );
        assert_eq!(
            pressure.field().values[24 * (blocks - 1) + 10],
            0.4f32 * (10.0 - 25.0)
        );
        let shown: Vec<bool> = (0..24 * blocks).map(|n| n % 24 == 5).collect();
        assert_eq!(
            pressure.blanked(),
            if blanked { shown } else { vec![] },
            "{style:?}"
        );
        let last = glam::DVec3::new(4.0, 4.0, 1.25) + if several { 10.0 } else { 0.0 };
        assert!(
            (pressure.bounds().max - last).length() < 1e-6,
            "{style:?} {:?}",
            pressure.bounds()
        );
        let speed = read(&solution, Some("velocity")).mesh;
        assert_eq!(speed.value_range(), [5.0, 5.0], "{style:?}");
        assert_eq!(read(&solution, Some("velocity:2")).mesh.value_range(), [4.0, 4.0]);
    }
    std::fs::rename(&solution, folder.path().join("other.bin")).unwrap();
    let error = read_mesh(&grid, &array("density")).unwrap_err().to_string();
    assert!(error.contains("name the solution"), "{error}");
    let mut options = array("density");
    options.solution = Some(folder.path().join("other.bin"));
    assert_eq!(read_mesh(&grid, &options).unwrap().mesh.value_range(), [2.0, 2.0]);
    // The density is the same everywhere: without a request, an array that varies is shown.
    options.array = None;
    let shown = read_mesh(&grid, &options).unwrap();
    assert_eq!(shown.mesh.field().name, "energy");
    assert_eq!(shown.arrays.len(), 5);
}

/// One array as VTK writes it.
fn encoded(bytes: &[u8], compressor: &str, words: usize) -> Vec<u8> {
    let word = |n: usize| {
        if words == 8 {
            (n as u64).to_le_bytes().to_vec()
        } else {
            (n as u32).to_le_bytes().to_vec()
        }
    };
    let packed = match compressor {
        "vtkZLibDataCompressor" => {
            let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
            encoder.write_all(bytes).expect("memory");
            encoder.finish().expect("memory")
        }
        "vtkLZ4DataCompressor" => lz4_flex::block::compress(bytes),
        _ => return [word(bytes.len()), bytes.to_vec()].concat(),
    };
    [word(1), word(bytes.len()), word(0), word(packed.len()), packed].concat()
}

/// A .vtu of a wedge, a triangle and a pyramid; cell values 1, 2, 3.
fn unstructured(compressor: &str, words: usize, format: &str) -> Vec<u8> {
    let points: Vec<f64> = (0..27)
        .map(|n| f64::from(n * n % 11) + 1e-9 * f64::from(n))
        .collect();
    let connectivity: [i64; 14] = [0, 1, 2, 3, 4, 5, 0, 1, 2, 4, 5, 6, 7, 8];
    let arrays: [(&str, &str, Vec<u8>); 5] = [
        (
            "Float64\" NumberOfComponents=\"3",
            "",
            points.iter().flat_map(|v| v.to_le_bytes()).collect(),
        ),
        (
            "Int64",
            "connectivity",
            connectivity.iter().flat_map(|v| v.to_le_bytes()).collect(),
        ),
        (
            "Int64",
            "offsets",
            [6i64, 9, 14].iter().flat_map(|v| v.to_le_bytes()).collect(),
        ),
        ("UInt8", "types", vec![13, 5, 14]),
        (
            "Float32",
            "T",
            [1f32, 2.0, 3.0].iter().flat_map(|v| v.to_le_bytes()).collect(),
        ),
    ];
    let mut appended = Vec::new();
    let elements = arrays.map(|(kind, name, bytes)| {
        let data = encoded(&bytes, compressor, words);
        let text = STANDARD.encode(&data);
        let start = format!("<DataArray type=\"{kind}\" Name=\"{name}\"");
        if format == "binary" {
            return format!("{start} format=\"binary\">{text}</DataArray>");
        }
        let offset = appended.len();
        appended.extend(if format == "raw" { data } else { text.into_bytes() });
        format!("{start} format=\"appended\" offset=\"{offset}\"/>")
    });
    let [points, connectivity, offsets, types, values] = elements;
    let kind = if words == 8 { "UInt64" } else { "UInt32" };
    let head = format!(
        "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"{kind}\" \
         compressor=\"{compressor}\"><UnstructuredGrid><Piece NumberOfPoints=\"9\" NumberOfCells=\"3\">\
         <CellData>{values}</CellData><Points>{points}</Points><Cells>{connectivity}{offsets}{types}</Cells>\
         </Piece></UnstructuredGrid>"
    );
    let tail = match format {
        "binary" => Vec::new(),
        _ => [
            format!("<AppendedData encoding=\"{format}\">_").into_bytes(),
            appended,
            b"</AppendedData>".to_vec(),
        ]
        .concat(),
    };
    [head.into_bytes(), tail, b"</VTKFile>".to_vec()].concat()
}

#[test]
fn every_coding_of_vtu_gives_the_same_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let path: &Path = &folder.path().join("a.vtu");
    let mut first = None;
    for compressor in ["", "vtkZLibDataCompressor", "vtkLZ4DataCompressor"] {
        for words in [4, 8] {
            for format in ["binary", "raw", "base64"] {
                std::fs::write(path, unstructured(compressor, words, format)).unwrap();
                let loaded = read(path, None);
                let mesh = loaded.mesh;
                let Topology::Unstructured(cells) = mesh.topology() else {
                    panic!("cells")
                };
                assert_eq!(cells.kinds(), [CellKind::Wedge, CellKind::Pyramid]);
                assert_eq!(mesh.field().values, [1.0, 3.0]);
                assert!(loaded.description.warnings[0].contains("1 cells of VTK type 5"));
                assert_eq!(
                    first.get_or_insert_with(|| mesh.clone()),
                    &mesh,
                    "{compressor} {words} {format}"
                );
            }
        }
    }
}

#[test]
fn plot3d_with_a_few_bytes_too_many_is_read_with_a_warning() {
    let style = Style {
        little: true,
        records: false,
        several: false,
        wide: false,
        blanked: false,
    };
    let folder = tempfile::tempdir().unwrap();
    let [grid, solution] = ["a.xyz", "a.q"].map(|name| folder.path().join(name));
    std::fs::write(&grid, [style.grid(), vec![7; 2]].concat()).unwrap();
    std::fs::write(&solution, [style.solution(), vec![7; 5]].concat()).unwrap();
    assert!(is_mesh(&grid).unwrap() && is_mesh(&solution).unwrap());
    let mesh = read(&grid, None);
    assert_eq!(
        mesh.description.warnings,
        [
            "grid: 2 more bytes than the dimensions ask for",
            "solution: 5 more bytes than the dimensions ask for"
        ]
    );
    assert_eq!(mesh.mesh.positions().len(), 24);
    let strict = splatvol_io::ReadOptions {
        strict: true,
        ..Default::default()
    };
    assert!(
        read_mesh(&grid, &strict)
            .unwrap_err()
            .to_string()
            .contains("2 more bytes")
    );
    let known = style.grid();
    std::fs::write(&grid, &known[..known.len() / 2]).unwrap();
    assert!(!is_mesh(&grid).unwrap());
}

#[test]
fn flat_grids_are_a_layer_of_cells() {
    let text = "# vtk DataFile Version 4.2\nflat\nASCII\nDATASET RECTILINEAR_GRID\nDIMENSIONS 3 1 2\n\
        X_COORDINATES 3 double\n0 2 4\nY_COORDINATES 1 double\n5\nZ_COORDINATES 2 double\n0 2\n\
        POINT_DATA 6\nSCALARS p float\nLOOKUP_TABLE default\n0 1 2 3 4 5\n\
        CELL_DATA 2\nSCALARS c float\nLOOKUP_TABLE default\n7 8\n";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flat.vtk");
    std::fs::write(&path, text).unwrap();
    let points = read(&path, Some("p")).mesh;
    assert_eq!(points.topology(), &Topology::Structured(vec![[3, 2, 2]]));
    assert_eq!(
        points.field().values,
        [0.0, 1.0, 2.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 3.0, 4.0, 5.0]
    );
    // The steps along x and z are 2, and so is the thickness.
    let bounds = points.bounds();
    assert_eq!(
        (bounds.min.to_array(), bounds.max.to_array()),
        ([0.0, 4.0, 0.0], [4.0, 6.0, 2.0])
    );
    let cells = read(&path, Some("c")).mesh;
    assert_eq!(
        (cells.cell_count(), cells.field().values.as_slice()),
        (2, &[7.0, 8.0][..])
    );
}
