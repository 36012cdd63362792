//! Points: PLY, PCD, LAS, LAZ, tables.

use std::io::Cursor;

use super::ending;
use crate::input::Input;
use crate::small_points;

fn of_name(ends: &[&str]) -> Vec<Input> {
    ending(small_points::files(), ends)
}

pub(crate) fn pcd() -> Vec<Input> {
    of_name(&[".pcd"])
}

pub(crate) fn ply() -> Vec<Input> {
    let mut seeds = of_name(&[".ply"]);
    let text = "ply\nformat ascii 1.0\ncomment made here\nelement vertex 4\nproperty float x\nproperty float y\n\
        property float z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty uchar red\n\
        property uchar green\nproperty uchar blue\nelement face 2\nproperty list uchar int vertex_indices\n\
        end_header\n0 0 0 0 0 1 255 0 0\n1 0 0 0 0 1 0 255 0\n0 1 0 0 0 1 0 0 255\n0 0 1 0 1 0 9 9 9\n\
        3 0 1 2\n3 0 1 3\n";
    seeds.push(Input::file("faces.ply", text));
    let head = "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty double x\nproperty double y\n\
        property double z\nproperty float radius\nelement face 1\nproperty list uchar uint vertex_index\nend_header\n";
    let mut bytes = head.as_bytes().to_vec();
    for i in 0..3u8 {
        bytes.extend([i, i * i, 7].map(|c| f64::from(c).to_be_bytes()).as_flattened());
        bytes.extend(0.5f32.to_be_bytes());
    }
    bytes.extend([3, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 2]);
    seeds.push(Input::file("big.ply", bytes));
    seeds
}

pub(crate) fn text() -> Vec<Input> {
    let mut seeds = of_name(&["table.csv"]);
    seeds.push(Input::file("a.xyz", "# x y z\n0 0 0\n1 2 3\n4 5 6\n"));
    seeds.push(Input::file(
        "a.pts",
        "3\n0 0 0 10 255 0 0\n1 1 1 20 0 255 0\n2 1 0 30 0 0 255\n",
    ));
    seeds.push(Input::file(
        "a.txt",
        "X;Y;Z;Nx;Ny;Nz\n0;0;0;0;0;1\n1;0;0;0;0;1\n0;1;0;0;0;1\n",
    ));
    seeds
}

pub(crate) fn las() -> Vec<Input> {
    let mut seeds = Vec::new();
    for format in [0, 2, 3, 7] {
        for compressed in [false, true] {
            seeds.push(las_file(format, compressed));
        }
    }
    seeds
}

fn las_file(format: u8, compressed: bool) -> Input {
    let mut format = las::point::Format::new(format).unwrap();
    format.is_compressed = compressed;
    let mut builder = las::Builder::from(if format.is_extended { (1, 4) } else { (1, 2) });
    let has_color = format.has_color;
    let has_time = format.has_gps_time;
    builder.point_format = format;
    let header = builder.into_header().unwrap();
    let mut writer = las::Writer::new(Cursor::new(Vec::new()), header).unwrap();
    for i in 0..6u8 {
        let color = has_color.then(|| las::Color::new(u16::from(i) * 9000, 500, 60_000));
        let point = las::Point {
            x: f64::from(i),
            y: f64::from(i * i % 7),
            z: f64::from(i % 3),
            intensity: 100,
            color,
            gps_time: has_time.then_some(1.0),
            ..las::Point::default()
        };
        writer.write_point(point).unwrap();
    }
    let bytes = writer.into_inner().unwrap().into_inner();
    Input::file(if compressed { "a.laz" } else { "a.las" }, bytes)
}
