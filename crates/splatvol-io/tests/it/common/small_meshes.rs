//! Small valid meshes: legacy VTK, VTK XML, PLY and PLOT3D.
#![allow(
    dead_code,
    unreachable_pub,
    clippy::unwrap_used,
    reason = "a module of tests, used in part; panics are how they fail"
)]

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// Files of one mesh each, by name. Those of VTK have eight points, mostly the corners of a cube, with values in an array `T`.
pub fn files() -> Vec<(&'static str, Vec<u8>)> {
    [legacy(), xml(), ply()].concat()
}

/// Corners of a cube, x fastest.
fn corners() -> Vec<[f32; 3]> {
    (0..8u8)
        .map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f32::from))
        .collect()
}

fn texts<T: ToString>(values: impl IntoIterator<Item = T>) -> String {
    values
        .into_iter()
        .map(|value| value.to_string())
        .collect::<Vec<_>>()
        .join(" ")
}

/// The head of a legacy file.
fn head(coding: &str, kind: &str) -> String {
    format!("# vtk DataFile Version 3.0\ntitle\n{coding}\nDATASET {kind}\n")
}

const SCALARS: &str = "POINT_DATA 8\nSCALARS T float 1\nLOOKUP_TABLE default\n";

fn legacy() -> Vec<(&'static str, Vec<u8>)> {
    let points = format!("POINTS 8 float\n{}\n", texts(corners().into_flattened()));
    let values = format!("{SCALARS}1 2 3 4 5 6 7 8\n");
    let file = |name: &'static str, kind: &str, body: &str| {
        (
            name,
            format!("{}{body}{values}", head("ASCII", kind)).into_bytes(),
        )
    };
    let cells = "CELLS 2 14\n8 0 1 3 2 4 5 7 6\n4 0 1 2 4\nCELL_TYPES 2\n12 10\n";
    let axes = "DIMENSIONS 2 2 2\nX_COORDINATES 2 float\n0 1\nY_COORDINATES 2 float\n0 2\nZ_COORDINATES 2 float\n0 4\n";
    let mut binary = head("BINARY", "UNSTRUCTURED_GRID").into_bytes();
    binary.extend(b"POINTS 8 float\n");
    binary.extend(
        corners()
            .into_flattened()
            .iter()
            .flat_map(|value| value.to_be_bytes()),
    );
    binary.extend(b"\nCELLS 1 9\n");
    binary.extend(
        [8u32, 0, 1, 3, 2, 4, 5, 7, 6]
            .iter()
            .flat_map(|value| value.to_be_bytes()),
    );
    binary.extend(b"\nCELL_TYPES 1\n\0\0\0\x0c\n");
    binary.extend(SCALARS.as_bytes());
    binary.extend((0..8u8).flat_map(|value| f32::from(value).to_be_bytes()));
    vec![
        file("cells.vtk", "UNSTRUCTURED_GRID", &format!("{points}{cells}")),
        file("axes.vtk", "RECTILINEAR_GRID", axes),
        file(
            "block.vtk",
            "STRUCTURED_GRID",
            &format!("DIMENSIONS 2 2 2\n{points}"),
        ),
        file(
            "faces.vtk",
            "POLYDATA",
            &format!("{points}POLYGONS 2 9\n4 0 1 3 2\n3 4 5 6\n"),
        ),
        ("binary.vtk", binary),
    ]
}

/// How arrays of an XML file are coded.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Coding {
    Text,
    Base64,
    Zlib,
    Lz4,
}

impl Coding {
    fn floats(self, name: &str, components: usize, values: &[f32]) -> String {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.array("Float32", name, components, &texts(values), &bytes)
    }

    fn integers(self, name: &str, values: &[i32]) -> String {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.array("Int32", name, 1, &texts(values), &bytes)
    }

    fn array(self, kind: &str, name: &str, components: usize, text: &str, bytes: &[u8]) -> String {
        let start = format!("<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\"");
        if self == Self::Text {
            return format!("{start} format=\"ascii\">{text}</DataArray>\n");
        }
        let words = |numbers: &[usize]| -> Vec<u8> {
            numbers.iter().flat_map(|n| (*n as u32).to_le_bytes()).collect()
        };
        let packed = match self {
            Self::Zlib => {
                let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
                encoder.write_all(bytes).unwrap();
                encoder.finish().unwrap()
            }
            Self::Lz4 => lz4_flex::block::compress(bytes),
            _ => {
                let all = [words(&[bytes.len()]), bytes.to_vec()].concat();
                return format!("{start} format=\"binary\">{}</DataArray>\n", STANDARD.encode(all));
            }
        };
        let header = words(&[1, bytes.len(), 0, packed.len()]);
        format!(
            "{start} format=\"binary\">{}{}</DataArray>\n",
            STANDARD.encode(header),
            STANDARD.encode(packed)
        )
    }

    fn file(self, kind: &str, attributes: &str, piece: &str, body: &str) -> Vec<u8> {
        let compressor = match self {
            Self::Zlib => " compressor=\"vtkZLibDataCompressor\"",
            Self::Lz4 => " compressor=\"vtkLZ4DataCompressor\"",
            _ => "",
        };
        let values = self.floats("T", 1, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
        format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"{kind}\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt32\"{compressor}>\n<{kind}{attributes}>\n<Piece {piece}>\n\
             <PointData Scalars=\"T\">{values}</PointData>\n{body}</Piece></{kind}></VTKFile>\n"
        )
        .into_bytes()
    }
}

fn xml() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("text.vtu", vtu(Coding::Text)),
        ("base64.vtu", vtu(Coding::Base64)),
        ("zlib.vtu", vtu(Coding::Zlib)),
        ("lz4.vtu", vtu(Coding::Lz4)),
        ("zlib.vtr", vtr(Coding::Zlib)),
        ("text.vtr", vtr(Coding::Text)),
        ("base64.vts", vts(Coding::Base64)),
        ("text.vtp", vtp(Coding::Text)),
        ("appended.vtu", appended()),
    ]
}

fn points(coding: Coding) -> String {
    format!(
        "<Points>{}</Points>\n",
        coding.floats("Points", 3, corners().as_flattened())
    )
}

fn vtu(coding: Coding) -> Vec<u8> {
    let types = coding.array("UInt8", "types", 1, "12 10", &[12, 10]);
    let cells = [
        coding.integers("connectivity", &[0, 1, 3, 2, 4, 5, 7, 6, 0, 1, 2, 4]),
        coding.integers("offsets", &[8, 12]),
        types,
    ];
    let body = format!("{}<Cells>{}</Cells>", points(coding), cells.concat());
    let piece = "NumberOfPoints=\"8\" NumberOfCells=\"2\"";
    coding.file("UnstructuredGrid", "", piece, &body)
}

fn vtr(coding: Coding) -> Vec<u8> {
    let axes: String = ["x", "y", "z"]
        .iter()
        .map(|axis| coding.floats(axis, 1, &[0.0, 1.5]))
        .collect();
    let body = format!("<Coordinates>{axes}</Coordinates>");
    coding.file(
        "RectilinearGrid",
        " WholeExtent=\"0 1 0 1 0 1\"",
        "Extent=\"0 1 0 1 0 1\"",
        &body,
    )
}

fn vts(coding: Coding) -> Vec<u8> {
    let whole = " WholeExtent=\"0 1 0 1 0 1\"";
    coding.file("StructuredGrid", whole, "Extent=\"0 1 0 1 0 1\"", &points(coding))
}

fn vtp(coding: Coding) -> Vec<u8> {
    let polygons = [
        coding.integers("connectivity", &[0, 1, 3, 2, 4, 5, 6]),
        coding.integers("offsets", &[4, 7]),
    ];
    let body = format!("{}<Polys>{}</Polys>", points(coding), polygons.concat());
    let piece = "NumberOfPoints=\"8\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"2\"";
    coding.file("PolyData", "", piece, &body)
}

/// Two pieces that share arrays behind the elements.
fn appended() -> Vec<u8> {
    let array = |name: &str, kind: &str, components: usize, offset: usize| {
        format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"appended\" \
             offset=\"{offset}\"/>"
        )
    };
    let piece = format!(
        "<Piece NumberOfPoints=\"4\" NumberOfCells=\"1\"><PointData Scalars=\"T\">{}</PointData><Points>{}</Points>\
         <Cells>{}{}{}</Cells></Piece>",
        array("T", "Float32", 1, 0),
        array("Points", "Float32", 3, 20),
        array("connectivity", "Int32", 1, 72),
        array("offsets", "Int32", 1, 92),
        array("types", "Int32", 1, 100)
    );
    let mut bytes = format!(
        "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt32\">\
         <UnstructuredGrid>{piece}{piece}</UnstructuredGrid><AppendedData encoding=\"raw\">_"
    )
    .into_bytes();
    let mut block = |words: &[[u8; 4]]| {
        bytes.extend((4 * words.len() as u32).to_le_bytes());
        bytes.extend(words.as_flattened());
    };
    block(&[0.0f32, 1.0, 2.0, 3.0].map(f32::to_le_bytes));
    block(&[0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0].map(f32::to_le_bytes));
    block(&[0i32, 1, 2, 3].map(i32::to_le_bytes));
    block(&[4i32].map(i32::to_le_bytes));
    block(&[10i32].map(i32::to_le_bytes));
    bytes.extend(b"</AppendedData></VTKFile>");
    bytes
}

/// Two triangles with colours and normals as text, and one of big-endian numbers with radii.
fn ply() -> Vec<(&'static str, Vec<u8>)> {
    let text = "ply\nformat ascii 1.0\ncomment made here\nelement vertex 4\nproperty float x\nproperty float y\n\
        property float z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty uchar red\n\
        property uchar green\nproperty uchar blue\nelement face 2\nproperty list uchar int vertex_indices\n\
        end_header\n0 0 0 0 0 1 255 0 0\n1 0 0 0 0 1 0 255 0\n0 1 0 0 0 1 0 0 255\n0 0 1 0 1 0 9 9 9\n\
        3 0 1 2\n3 0 1 3\n";
    let head = "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty double x\nproperty double y\n\
        property double z\nproperty float radius\nelement face 1\nproperty list uchar uint vertex_index\nend_header\n";
    let mut bytes = head.as_bytes().to_vec();
    for i in 0..3u8 {
        bytes.extend([i, i * i, 7].map(|c| f64::from(c).to_be_bytes()).as_flattened());
        bytes.extend(0.5f32.to_be_bytes());
    }
    bytes.extend([3, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 2]);
    vec![("faces.ply", text.as_bytes().to_vec()), ("big.ply", bytes)]
}

/// Grids of 3 x 3 x 3 and their solutions: one block, and two with marks of records.
pub fn plot3d() -> Vec<[(&'static str, Vec<u8>); 2]> {
    let styles = [(false, 1), (true, 1), (true, 2)].map(|(marks, blocks)| Plot3d { marks, blocks });
    let both = |style: Plot3d| [("a.q", style.solution()), ("a.xyz", style.grid())];
    styles.into_iter().map(both).collect()
}

#[derive(Clone, Copy)]
struct Plot3d {
    /// Lengths around records, as Fortran writes them.
    marks: bool,
    blocks: u32,
}

impl Plot3d {
    const SIZE: u32 = 3;

    fn record(self, words: &[[u8; 4]]) -> Vec<u8> {
        let mark = if self.marks {
            (4 * words.len() as u32).to_le_bytes().to_vec()
        } else {
            Vec::new()
        };
        [&mark, words.as_flattened(), &mark].concat()
    }

    fn head(self) -> Vec<u8> {
        let dims = [Self::SIZE.to_le_bytes()].repeat(3 * self.blocks as usize);
        let count = if self.blocks > 1 {
            self.record(&[self.blocks.to_le_bytes()])
        } else {
            Vec::new()
        };
        [count, self.record(&dims)].concat()
    }

    fn grid(self) -> Vec<u8> {
        let count = Self::SIZE.pow(3);
        let at = |n: u32, axis: u32| (n / Self::SIZE.pow(axis) % Self::SIZE) as f32;
        let reals: Vec<[u8; 4]> = (0..3)
            .flat_map(|axis| (0..count).map(move |n| at(n, axis).to_le_bytes()))
            .collect();
        let blocks = self.record(&reals).repeat(self.blocks as usize);
        [self.head(), blocks].concat()
    }

    fn solution(self) -> Vec<u8> {
        let count = Self::SIZE.pow(3);
        let reference = self.record(&[0.5f32, 0.0, 1e4, 0.0].map(f32::to_le_bytes));
        let reals: Vec<[u8; 4]> = (0..5 * count).map(|n| (2.0 + n as f32).to_le_bytes()).collect();
        let block = [reference, self.record(&reals)].concat();
        [self.head(), block.repeat(self.blocks as usize)].concat()
    }
}
