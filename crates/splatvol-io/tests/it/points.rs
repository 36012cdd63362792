//! Readers of points against known figures of real files, and against small files made here.

use std::path::Path;

use glam::DVec3;
use splatvol_io::{IoError, LoadedPoints, ReadOptions, read_points};
use splatvol_recorded::recorded;

fn load(path: &Path) -> LoadedPoints {
    read_points(path, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn read_as(name: &str, bytes: &[u8]) -> Result<LoadedPoints, IoError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    read_points(&path, &ReadOptions::default())
}

/// World places of all points.
fn world(loaded: &LoadedPoints) -> Vec<DVec3> {
    let frame = loaded.points.world_from_local();
    let place = |p: &[f32; 3]| frame.transform_point3(DVec3::from_array(p.map(f64::from)));
    loaded.points.positions().iter().map(place).collect()
}

struct Known {
    name: &'static str,
    count: usize,
    bounds: [[f64; 3]; 2],
    colors: Option<[u8; 2]>,
    normals: bool,
}

/// Meshes, with the numbers of their triangles and the boxes of their vertices.
const MESHES: &[(&str, usize, [[f64; 3]; 2])] = &[
    (
        "ankylosaurus_mesh.ply",
        69_636,
        [[-0.430782, 0.948018, 2.60685], [0.579267, 1.29069, 3.21088]],
    ),
    (
        "bunny.ply",
        69_451,
        [
            [-0.0946899, 0.0329874, -0.0618736],
            [0.0610091, 0.187321, 0.0587997],
        ],
    ),
    (
        "horse.ply",
        96_966,
        [
            [-0.042003, -0.0916705, -0.076418],
            [0.042003, 0.0916705, 0.076418],
        ],
    ),
    (
        "beetle.ascii.ply",
        2053,
        [[-0.216734, 0.306086, -0.253812], [0.143533, 0.60904, 0.637839]],
    ),
    (
        "beetle.binary.ply",
        2053,
        [[-0.216734, 0.306086, -0.253812], [0.143533, 0.60904, 0.637839]],
    ),
];

/// The table that comes with the files; bounds have six digits.
const KNOWN: &[Known] = &[
    Known {
        name: "autzen_trim.laz",
        count: 110_000,
        bounds: [[636_002.0, 848_935.0, 406.26], [637_179.0, 849_498.0, 520.51]],
        colors: Some([40, 236]),
        normals: false,
    },
    Known {
        name: "1.2-with-color.las",
        count: 1065,
        bounds: [[635_620.0, 848_900.0, 406.59], [638_983.0, 853_535.0, 586.38]],
        colors: Some([39, 249]),
        normals: false,
    },
    Known {
        name: "1.2-with-color.copc.laz",
        count: 1065,
        bounds: [[635_620.0, 848_900.0, 406.59], [638_983.0, 853_535.0, 586.38]],
        colors: Some([39, 249]),
        normals: false,
    },
    Known {
        name: "autzen-utm.pcd",
        count: 1065,
        bounds: [[493_995.0, 4_877_430.0, 123.93], [494_994.0, 4_878_820.0, 178.73]],
        colors: Some([39, 249]),
        normals: false,
    },
];

#[test]
fn real_files_hold_what_is_known_of_them() {
    let Some(folder) = recorded("points") else { return };
    for known in KNOWN {
        let loaded = load(&folder.join(known.name));
        let (points, name) = (&loaded.points, known.name);
        println!("{name}: {:?}", loaded.description);
        assert!(loaded.description.warnings.is_empty(), "{name}");
        assert_eq!(points.len(), known.count, "{name}");
        let bounds = points.bounds();
        for (found, expected) in [bounds.min, bounds.max].into_iter().zip(known.bounds) {
            for (found, expected) in found.to_array().into_iter().zip(expected) {
                // Six digits, of which the last may be off by half.
                let tolerance = 0.51 * 10f64.powi(expected.abs().log10().floor() as i32 - 5);
                assert!((found - expected).abs() <= tolerance, "{name}: {bounds:?}");
            }
        }
        let colors = &points.attributes().colors;
        let channels = || colors.iter().flat_map(|c| &c[..3]).copied();
        let range = (!colors.is_empty()).then(|| [channels().min().unwrap(), channels().max().unwrap()]);
        assert_eq!(range, known.colors, "{name}");
        assert!(colors.iter().all(|c| c[3] == 255), "{name}");
        assert_eq!(
            points.attributes().normals.len(),
            if known.normals { known.count } else { 0 },
            "{name}"
        );
    }
}

#[test]
fn real_meshes_become_surfels_inside_their_boxes() {
    let Some(folder) = recorded("points") else { return };
    for &(name, triangles, [low, high]) in MESHES {
        let loaded = load(&folder.join(name));
        let stored = &loaded.description.stored_type;
        assert!(
            stored.contains(&format!("; {triangles} triangles as ")),
            "{name}: {stored}"
        );
        assert!(loaded.description.warnings.is_empty(), "{name}");
        let (low, high) = (DVec3::from_array(low), DVec3::from_array(high));
        let bounds = loaded.points.bounds();
        let near = 0.01 * low.distance(high);
        let inside = (bounds.min - low).min_element() >= -1e-6 && (high - bounds.max).min_element() >= -1e-6;
        assert!(inside, "{name}: {bounds:?}");
        let reach = (bounds.min - low)
            .max_element()
            .max((high - bounds.max).max_element());
        assert!(reach < near, "{name}: {bounds:?}");
        assert_eq!(
            loaded.points.attributes().normals.len(),
            loaded.points.len(),
            "{name}"
        );
    }
}

#[test]
fn files_of_the_same_points_agree() {
    let Some(folder) = recorded("points") else { return };
    let [text, binary] =
        ["beetle.ascii.ply", "beetle.binary.ply"].map(|name| load(&folder.join(name)).points);
    for (a, b) in text.positions().iter().zip(binary.positions()) {
        // The text has six decimals.
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6), "{a:?} {b:?}");
    }
    let sorted = |name: &str| {
        let loaded = load(&folder.join(name));
        let colors = loaded.points.attributes().colors.clone();
        let mut points: Vec<([i64; 3], [u8; 4])> = world(&loaded)
            .iter()
            .map(|p| p.to_array().map(|c| (c * 100.0).round() as i64))
            .zip(colors)
            .collect();
        points.sort_unstable();
        points
    };
    assert_eq!(sorted("1.2-with-color.las"), sorted("1.2-with-color.copc.laz"));
}

#[test]
fn coordinates_of_maps_keep_their_centimetres() {
    let Some(folder) = recorded("points") else { return };
    let loaded = load(&folder.join("autzen-utm.pcd"));
    let bytes = std::fs::read(folder.join("autzen-utm.pcd")).unwrap();
    let start = bytes.windows(12).position(|w| w == b"DATA binary\n").unwrap() + 12;
    // SIZE 8 8 8 2 1 1 1 1 1 4 1 2 8 2 2 2
    let stride = 52;
    let number = |at: usize| f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
    let mut worst: f64 = 0.0;
    for (index, place) in world(&loaded).into_iter().enumerate() {
        let row = start + index * stride;
        let stored = DVec3::new(number(row), number(row + 8), number(row + 16));
        worst = worst.max((place - stored).abs().max_element());
    }
    // 700 m from the origin, 24 bits resolve 60 micrometres.
    assert!(worst < 1e-4, "{worst}");
}

#[test]
fn columns_of_tables_are_told_apart() {
    let attributes = |text: &str| {
        let loaded = read_as("a.txt", text.as_bytes()).unwrap_or_else(|error| panic!("{error}: {text}"));
        (
            world(&loaded).iter().map(|p| p.to_array()).collect::<Vec<_>>(),
            loaded.points.attributes().clone(),
            loaded.description.warnings,
        )
    };
    let (positions, plain, _) = attributes("1 2 3\n4,5;6\n\n7\t8\t9\r\n");
    assert_eq!(positions, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]]);
    assert!(plain.colors.is_empty() && plain.normals.is_empty());
    assert_eq!(attributes("1 2 3 255 0 51\n").1.colors, [[255, 0, 51, 255]]);
    assert_eq!(attributes("1 2 3 0.5 0 0.25\n").1.colors, [[128, 0, 64, 255]]);
    assert_eq!(attributes("1 2 3 0.6 0 -0.8\n").1.normals, [[0.6, 0.0, -0.8]]);
    let (_, nine, _) = attributes("1 2 3 10 20 30 0 1 0\n");
    assert_eq!(
        (nine.colors, nine.normals),
        (vec![[10, 20, 30, 255]], vec![[0.0, 1.0, 0.0]])
    );
    let named = "# made by hand\nBlue,Red,radius,Green,Z,Y,X,what\n3,1,0.5,2,30,20,10,99\n";
    let (positions, named, _) = attributes(named);
    assert_eq!(positions, [[10.0, 20.0, 30.0]]);
    assert_eq!((named.colors, named.radii), (vec![[1, 2, 3, 255]], vec![0.5]));
    assert_eq!(
        attributes("//X Y Z Intensity\n1 2 3 10\n1 2 4 20\n").1.colors,
        [[128, 128, 128, 255], [255; 4]]
    );
    assert_eq!(attributes("3\n1 2 3 7 1 2 3\n1 2 3 8 4 5 6\n").2.len(), 1);
    for (bad, words) in [
        ("", "at least one row"),
        ("x y\n1 2\n", "names of columns"),
        ("1 2\n", "3, 4, 6, 7 or 9"),
        ("1 2 3\n1 2\n", "row 1"),
        ("1 2 3\n1 b 3\n", "row 1"),
        ("x y z\n1 2 3 4\n", "one for each name"),
        ("nan 1 2\n", "at least one point"),
    ] {
        let text = read_as("a.csv", bad.as_bytes()).unwrap_err().to_string();
        assert!(text.contains(words) && text.contains("a.csv"), "{text}");
    }
}

const PCD: &str = "# .PCD v0.7\nVERSION 0.7\nFIELDS rgb z _ x y normal_x normal_y normal_z\nSIZE 4 8 1 4 2 4 4 4\n\
    TYPE F F U F I F F F\nCOUNT 1 1 3 1 1 1 1 1\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 1 2 3 1 0 0 0\nPOINTS 2\nDATA ";

/// Two points as bytes of each field.
fn pcd_fields(point: usize) -> Vec<Vec<u8>> {
    let floats = |values: &[f32]| {
        values
            .iter()
            .map(|v| v.to_le_bytes().to_vec())
            .collect::<Vec<_>>()
    };
    let color = [0x00ff_8040_u32, 0x0010_2030][point].to_le_bytes().to_vec();
    let z = [1e6 + 0.125, -2.0f64][point].to_le_bytes().to_vec();
    let x = [0.5f32, f32::NAN][point].to_le_bytes().to_vec();
    let y = [-7i16, 9][point].to_le_bytes().to_vec();
    [vec![color, z, vec![1, 2, 3], x, y], floats(&[0.0, 0.0, 2.0])].concat()
}

fn assert_pcd(loaded: &LoadedPoints) {
    assert_eq!(world(loaded), [DVec3::new(0.5, -7.0, 1e6 + 0.125)]);
    assert_eq!(loaded.points.attributes().colors, [[0xff, 0x80, 0x40, 255]]);
    assert_eq!(loaded.points.attributes().normals, [[0.0, 0.0, 1.0]]);
    assert_eq!(loaded.viewpoint, Some(DVec3::new(1.0, 2.0, 3.0)));
    assert_eq!(loaded.description.warnings.len(), 1, "{:?}", loaded.description);
}

#[test]
fn pcd_gives_the_same_points_in_all_three_encodings() {
    let rows: Vec<u8> = (0..2).flat_map(|point| pcd_fields(point).concat()).collect();
    assert_pcd(&read_as("a.pcd", &[PCD.as_bytes(), b"binary\n", &rows].concat()).unwrap());
    let packed = f32::from_bits(0x00ff_8040);
    let text = format!("{PCD}ascii\n{packed:e} 1000000.125 1 2 3 0.5 -7 0 0 2\n0 -2 1 2 3 nan 9 0 0 2\n");
    assert_pcd(&read_as("a.pcd", text.as_bytes()).unwrap());

    let (first, second) = (pcd_fields(0), pcd_fields(1));
    let planes: Vec<u8> = first
        .iter()
        .zip(&second)
        .flat_map(|(a, b)| [a.clone(), b.clone()].concat())
        .collect();
    let stream: Vec<u8> = planes
        .chunks(32)
        .flat_map(|chunk| [&[chunk.len() as u8 - 1][..], chunk].concat())
        .collect();
    let lengths = [stream.len() as u32, planes.len() as u32]
        .map(u32::to_le_bytes)
        .concat();
    let file = [PCD.as_bytes(), b"binary_compressed\n", &lengths, &stream].concat();
    assert_pcd(&read_as("a.pcd", &file).unwrap());
}

#[test]
fn ply_of_any_order_and_type_is_read() {
    let header = "ply\nformat binary_big_endian 1.0\nelement face 1\nproperty list uchar int vertex_indices\n\
        element vertex 1\nproperty uchar alpha\nproperty double z\nproperty short y\nproperty float x\n\
        property ushort blue\nproperty ushort green\nproperty ushort red\nproperty float radius\nend_header\n";
    let face = [&[2u8][..], &7i32.to_be_bytes(), &8i32.to_be_bytes()].concat();
    let row = [
        &[255u8][..],
        &2.5f64.to_be_bytes(),
        &(-3i16).to_be_bytes(),
        &1.5f32.to_be_bytes(),
        &[0, 1, 0x80, 0, 0xff, 0xff],
        &0.25f32.to_be_bytes(),
    ]
    .concat();
    let loaded = read_as("a.ply", &[header.as_bytes(), &face, &row].concat()).unwrap();
    assert_eq!(world(&loaded), [DVec3::new(1.5, -3.0, 2.5)]);
    assert_eq!(loaded.points.attributes().colors[0][..3], [255, 128, 0]);
    assert_eq!(loaded.points.attributes().radii, [0.25]);
    let gaussians = header
        .replace("uchar alpha", "float f_dc_0")
        .replace("float radius", "float scale_0");
    let text = read_as("a.ply", gaussians.as_bytes()).unwrap_err().to_string();
    assert!(text.contains("Gaussians"), "{text}");
}

#[test]
fn faces_of_ply_are_a_surface_without_those_whose_corners_have_no_place() {
    let text = |faces: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
             element face 2\nproperty list uchar int vertex_index\nproperty uchar red\nproperty uchar green\n\
             property uchar blue\nend_header\n0 0 5\n1 0 5\nnan 1 5\n0 1 5\n{faces}"
        )
    };
    let loaded = read_as("a.ply", text("3 0 1 3 10 20 30\n3 1 2 3 9 9 9\n").as_bytes()).unwrap();
    let attributes = loaded.points.attributes();
    let area: f64 = attributes.radii.iter().map(|r| f64::from(*r).powi(2)).sum();
    assert!((area - 0.5).abs() < 1e-4, "{area}");
    assert!(attributes.colors.iter().all(|c| *c == [10, 20, 30, 255]));
    assert!(attributes.normals.iter().all(|n| *n == [0.0, 0.0, 1.0]));
    assert!(world(&loaded).iter().all(|p| p.z == 5.0));

    for (bad, words) in [
        ("4", "corner of face 0"),
        ("-1", "corner of face 0"),
        ("0.5", "a number of type I32"),
    ] {
        let error = read_as(
            "a.ply",
            text(&format!("3 0 1 {bad} 1 2 3\n3 0 0 0 1 2 3\n")).as_bytes(),
        )
        .unwrap_err();
        let text = error.to_string();
        assert!(text.contains(words), "{text}");
    }
}

#[test]
fn strict_reading_refuses_what_is_odd() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.xyz");
    std::fs::write(&path, "1 2 3\nnan 2 3\n").unwrap();
    let strict = ReadOptions {
        strict: true,
        ..ReadOptions::default()
    };
    assert!(matches!(read_points(&path, &strict), Err(IoError::Strict { .. })));
    let little = ReadOptions {
        max_bytes: 10,
        ..ReadOptions::default()
    };
    assert!(matches!(read_points(&path, &little), Err(IoError::Limit { .. })));
}
