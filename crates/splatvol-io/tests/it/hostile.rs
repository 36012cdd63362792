//! Files that lie or are absurd: an error that names the field, or the data, in time that grows as the file does.

use std::io::Write as _;
use std::path::Path;
use std::time::{Duration, Instant};

use crate::common::dicom_file::{DicomFile, EXPLICIT, element};
use splatvol_io::{Data, DataOptions, IoError, Loaded, LoadedMesh, LoadedPoints, ReadOptions};

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// What took minutes when it grew with the square of the file's length.
const PATIENCE: Duration = Duration::from_secs(5);

/// What reading a file of these bytes gives.
fn read<T>(
    (name, bytes): (&str, impl AsRef<[u8]>),
    reader: impl Fn(&Path, &ReadOptions) -> Result<T, IoError>,
) -> Result<T, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    timed(&path, reader)
}

fn volume(path: &Path, options: &ReadOptions) -> Result<Loaded, IoError> {
    splatvol_io::read_volume(path, options)
}

fn mesh(path: &Path, options: &ReadOptions) -> Result<LoadedMesh, IoError> {
    splatvol_io::read_mesh(path, options)
}

fn points(path: &Path, options: &ReadOptions) -> Result<LoadedPoints, IoError> {
    splatvol_io::read_points(path, options)
}

fn timed<T>(path: &Path, reader: impl Fn(&Path, &ReadOptions) -> Result<T, IoError>) -> Result<T, String> {
    let start = Instant::now();
    let result = reader(path, &ReadOptions::default());
    let took = start.elapsed();
    assert!(took < PATIENCE, "{}: {took:?}", path.display());
    result.map_err(|error| error.to_string())
}

#[track_caller]
fn assert_names<T>(result: Result<T, String>, words: &[&str]) {
    let error = result.err().expect("it is refused");
    for word in words {
        assert!(error.contains(word), "no {word:?} in {error}");
    }
}

#[test]
fn dicom_lengths_and_places_that_nothing_can_have_are_refused() {
    for spacing in ["1e200\\1e200", "1e-200\\1e-200", "0.5\\1e300"] {
        let mut slice = DicomFile::slice(EXPLICIT, [0.0; 3], 1, &[0; 6]);
        slice.text(0x0028_0030, b"DS", spacing);
        assert_names(read(("a.dcm", slice.bytes()), volume), &["PixelSpacing", "mm"]);
    }
    let slice = DicomFile::slice(EXPLICIT, [1e300, 0.0, 0.0], 1, &[0; 6]);
    assert_names(
        read(("a.dcm", slice.bytes()), volume),
        &["ImagePositionPatient", "mm"],
    );
    // A thickness of no use is not used.
    let mut slice = DicomFile::slice(EXPLICIT, [0.0; 3], 1, &[0; 6]);
    slice.text(0x0018_0050, b"DS", "1e-300");
    let loaded = read(("a.dcm", slice.bytes()), volume).unwrap();
    let warnings = loaded.description.warnings.join("; ");
    assert!(warnings.contains("SliceThickness is 1e-300"), "{warnings}");
    assert!(loaded.volume.grid().mean_spacing() > 0.1);
}

#[test]
fn dicom_frames_are_found_in_linear_time() {
    // As many other elements as frames: each frame looks for a dozen of its own.
    const COUNT: usize = 8000;
    let mut slice = DicomFile::slice(EXPLICIT, [0.0; 3], 1, &[0; 6]);
    slice.text(0x0028_0008, b"IS", &COUNT.to_string());
    slice.text(0x0020_0032, b"DS", "");
    slice.pixels(&vec![7; 6 * COUNT]);
    let private = (0..20_000u32).flat_map(|i| element(EXPLICIT, 0x0009_0000 + i, b"CS", b"AB"));
    let body = [private.collect::<Vec<u8>>(), slice.dataset()].concat();
    let loaded = read(("a.dcm", slice.with_body(&body)), volume).unwrap();
    assert_eq!(loaded.volume.grid().dims(), [3, 2, COUNT]);
}

#[test]
fn frames_without_bytes_take_no_memory() {
    let mut slice = DicomFile::slice("1.2.840.10008.1.2.5", [0.0; 3], 1, &[0; 6]);
    slice.text(0x0028_0008, b"IS", "100000");
    let bytes = slice.encapsulated(&vec![Vec::new(); 100_000]);
    assert_names(read(("a.dcm", bytes), volume), &["frames"]);
}

#[test]
fn decimal_commas_are_not_two_numbers() {
    let vtk = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 3 3\nORIGIN 0 0 0\n\
        SPACING 1 1 1\nPOINT_DATA 27\nSCALARS a float 1\nLOOKUP_TABLE default\n";
    let numbers: Vec<String> = (1..=27).map(|i| format!("{i},5")).collect();
    let text = format!("{vtk}{}\n", numbers.join(" "));
    assert_names(read(("a.vtk", text), volume), &["\"1,5\"", "decimal point"]);
    let numbers: Vec<String> = (1..=27).map(|i| format!("{i}.5")).collect();
    assert!(read(("a.vtk", format!("{vtk}{}\n", numbers.join(", "))), volume).is_ok());
}

#[test]
fn numbers_must_fit_the_type_that_a_ply_declares() {
    let ply = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
        property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
    assert!(read(("a.ply", format!("{ply}0 0 0 255 0 0\n")), points).is_ok());
    for red in ["256", "-1", "0.5", "1e3"] {
        assert_names(
            read(("a.ply", format!("{ply}0 0 0 {red} 0 0\n")), points),
            &["red", red, "U8"],
        );
    }
}

#[test]
fn attributes_and_namespaces_are_counted_before_they_are_compared() {
    let attributes: String = (0..60_000).map(|i| format!(" a{i}=\"0\"")).collect();
    let namespaces: String = (0..20_000).map(|i| format!(" xmlns:a{i}=\"u{i}\"")).collect();
    for crowd in [attributes, namespaces] {
        let text = format!("<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\"{crowd}></VTKFile>");
        assert_names(read(("a.vti", text), volume), &["attributes of one element"]);
    }
}

/// A data set of equal pieces of four points, which share arrays: each a cell with these corners, of this VTK type.
fn pieces(data_set: &str, count: usize, [corners, kind]: [&[i32]; 2]) -> Vec<u8> {
    let array = |name: &str, kind: &str, components: usize, offset: usize| {
        format!(
            "<DataArray Name=\"{name}\" type=\"{kind}\" NumberOfComponents=\"{components}\" format=\"appended\" \
             offset=\"{offset}\"/>"
        )
    };
    let lists = [
        array("offsets", "Int32", 1, 72),
        array("types", "Int32", 1, 80),
        array("connectivity", "Int32", 1, 88),
    ];
    let cells = match data_set {
        "PolyData" => ["Polys", "NumberOfPolys"],
        _ => ["Cells", "NumberOfCells"],
    };
    let piece = format!(
        "<Piece NumberOfPoints=\"4\" {}=\"1\"><PointData>{}</PointData><Points>{}</Points><{tag}>{}</{tag}></Piece>",
        cells[1],
        array("v", "Float32", 1, 0),
        array("p", "Float32", 3, 20),
        lists.concat(),
        tag = cells[0],
    );
    let mut bytes = format!(
        "<VTKFile type=\"{data_set}\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt32\"><{data_set}>\
         {}</{data_set}><AppendedData encoding=\"raw\">_",
        piece.repeat(count)
    )
    .into_bytes();
    let mut block = |words: &[[u8; 4]]| {
        bytes.extend((4 * words.len() as u32).to_le_bytes());
        bytes.extend(words.as_flattened());
    };
    block(&[0.0f32, 1.0, 2.0, 3.0].map(f32::to_le_bytes));
    let places = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    block(&places.map(f32::to_le_bytes));
    block(&[(corners.len() as i32).to_le_bytes()]);
    for words in [kind, corners] {
        block(&words.iter().map(|word| word.to_le_bytes()).collect::<Vec<_>>());
    }
    bytes.extend(b"</AppendedData></VTKFile>");
    bytes
}

#[test]
fn pieces_of_a_mesh_are_read_in_linear_time() {
    const PIECES: usize = 12_000;
    let any = |path: &Path, options: &ReadOptions| {
        let options = DataOptions {
            read: options.clone(),
            ..DataOptions::default()
        };
        splatvol_io::read_data(path, &options).map(|loaded| loaded.data)
    };
    let solid = pieces("UnstructuredGrid", PIECES, [&[0, 1, 2, 3], &[10]]);
    let Data::Mesh(mesh) = read(("a.vtu", solid), any).unwrap() else {
        panic!("no mesh");
    };
    assert_eq!(mesh.positions().len(), 4 * PIECES);
    // Surfaces: a disc for each triangle at least.
    for (name, data_set) in [("flat.vtu", "UnstructuredGrid"), ("a.vtp", "PolyData")] {
        let flat = pieces(data_set, PIECES, [&[0, 1, 2], &[5]]);
        let Data::Points(points) = read((name, flat), any).unwrap() else {
            panic!("no surface");
        };
        assert!(points.len() >= PIECES, "{name}");
    }
}

#[test]
fn a_shard_that_is_not_there_is_looked_for_once() {
    let folder = tempfile::tempdir().unwrap();
    let zarr = |shape: &str, outer: &str| {
        format!(
            r#"{{"zarr_format": 3, "node_type": "array", "shape": {shape}, "data_type": "uint8",
            "chunk_grid": {{"name": "regular", "configuration": {{"chunk_shape": {outer}}}}},
            "chunk_key_encoding": {{"name": "default"}}, "fill_value": 0, "codecs": [{{"name": "sharding_indexed",
            "configuration": {{"chunk_shape": [1, 1, 1], "codecs": [{{"name": "bytes"}}],
            "index_codecs": [{{"name": "bytes"}}]}}}}]}}"#
        )
    };
    std::fs::create_dir_all(folder.path().join("c/9/9")).unwrap();
    std::fs::write(folder.path().join("c/9/9/9"), [0]).unwrap();
    let metadata = zarr("[1, 8192, 8192]", "[1, 65536, 65536]");
    std::fs::write(folder.path().join("zarr.json"), metadata).unwrap();
    assert_names(timed(folder.path(), volume), &["shape", "chunks in 1 files"]);
    // An index that could be there: a million chunks in shards that are not.
    std::fs::write(folder.path().join("c/9/9/9"), vec![0; 1 << 20]).unwrap();
    let metadata = zarr("[1, 1024, 1024]", "[1, 1024, 1024]");
    std::fs::write(folder.path().join("zarr.json"), metadata).unwrap();
    let loaded = timed(folder.path(), volume).unwrap();
    assert_eq!(loaded.volume.grid().dims(), [1024, 1024, 1]);
}

#[test]
fn fill_values_of_zarr_are_bits_too_and_must_fit() {
    let read_fill = |kind: &str, fill: &str| {
        let folder = tempfile::tempdir().unwrap();
        let metadata = format!(
            r#"{{"zarr_format": 3, "node_type": "array", "shape": [1, 2, 2], "data_type": "{kind}",
            "chunk_grid": {{"name": "regular", "configuration": {{"chunk_shape": [1, 1, 2]}}}},
            "chunk_key_encoding": {{"name": "default"}}, "fill_value": {fill}, "codecs": [{{"name": "bytes"}}]}}"#
        );
        std::fs::write(folder.path().join("zarr.json"), metadata).unwrap();
        std::fs::create_dir_all(folder.path().join("c/0/0")).unwrap();
        let one = if kind == "float32" {
            1.0f32.to_le_bytes()
        } else {
            1u32.to_le_bytes()
        };
        std::fs::write(folder.path().join("c/0/0/0"), [one, one].concat()).unwrap();
        timed(folder.path(), volume).map(|loaded| loaded.volume.value(3))
    };
    assert_eq!(
        read_fill("float32", "\"0x40490fdb\"").unwrap(),
        f64::from(std::f32::consts::PI)
    );
    assert_eq!(read_fill("int32", "-7").unwrap(), -7.0);
    assert_eq!(read_fill("int32", "3.0").unwrap(), 3.0);
    for (kind, fill) in [
        ("int32", "3000000000"),
        ("uint32", "-1"),
        ("int32", "0.5"),
        ("float32", "\"0x40\""),
        ("float32", "\"three\""),
    ] {
        assert_names(read_fill(kind, fill), &["fill_value"]);
    }
}

#[test]
fn containers_that_hold_almost_nothing_make_no_gaussians_and_no_grids() {
    // A gzip stream of zeros: 20 million Gaussians of 9 + 1 + 3 + 3 + 3 bytes.
    let mut header = b"NGSP".to_vec();
    header.extend(2u32.to_le_bytes());
    header.extend(20_000_000u32.to_le_bytes());
    header.extend([0, 12, 0, 0]);
    let bomb = gzip(&[header, vec![0; 20_000_000]].concat());
    let gaussians = |path: &Path, options: &ReadOptions| splatvol_io::read_gaussians(path, options).map(drop);
    assert_names(
        read(("a.spz", bomb), gaussians),
        &["number of Gaussians", "20000000"],
    );

    let axis: Vec<String> = (0..400).map(|i| i.to_string()).collect();
    let axis = format!(
        "<DataArray type=\"Float32\" format=\"ascii\">{}</DataArray>",
        axis.join(" ")
    );
    let grid = format!(
        "<VTKFile type=\"RectilinearGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt32\" \
         compressor=\"vtkZLibDataCompressor\"><RectilinearGrid WholeExtent=\"0 399 0 399 0 399\"><Piece \
         Extent=\"0 399 0 399 0 399\"><PointData><DataArray Name=\"a\" type=\"UInt8\" format=\"appended\" \
         offset=\"0\"/></PointData><Coordinates>{axis}{axis}{axis}</Coordinates></Piece></RectilinearGrid>\
         <AppendedData encoding=\"raw\">_"
    );
    let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    packed.write_all(&vec![0; 64_000_000]).unwrap();
    let packed = packed.finish().unwrap();
    let mut bytes = grid.into_bytes();
    for word in [1, 64_000_000, 0, packed.len() as u32] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend(packed);
    bytes.extend(b"</AppendedData></VTKFile>");
    assert_names(read(("a.vtr", bytes), mesh), &["points need 1536000000 bytes"]);
}

#[test]
fn choices_that_a_format_does_not_have_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.nrrd");
    std::fs::write(
        &path,
        "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n\nabcdefgh",
    )
    .unwrap();
    let refused = |change: &dyn Fn(&mut ReadOptions)| {
        let mut options = ReadOptions::default();
        change(&mut options);
        volume(&path, &options)
            .map(drop)
            .map_err(|error| error.to_string())
    };
    assert_eq!(refused(&|_| ()), Ok(()));
    assert_names(
        refused(&|options| options.array = Some("foo".into())),
        &["array", "foo"],
    );
    assert_names(
        refused(&|options| options.series = Some("bar".into())),
        &["series", "bar"],
    );
    assert_names(refused(&|options| options.level = 9), &["level", "9"]);
}
