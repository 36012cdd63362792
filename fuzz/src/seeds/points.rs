//! Points: PLY, PCD, LAS, LAZ, tables.

use std::io::Cursor;

use super::ending;
use crate::common::{small_meshes, small_points};
use crate::input::Input;

fn of_name(ends: &[&str]) -> Vec<Input> {
    ending(small_points::files(), ends)
}

pub(crate) fn pcd() -> Vec<Input> {
    of_name(&[".pcd"])
}

pub(crate) fn ply() -> Vec<Input> {
    let mut seeds = of_name(&[".ply"]);
    seeds.extend(ending(small_meshes::files(), &[".ply"]));
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
