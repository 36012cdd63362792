//! Small LAS and LAZ files.
#![allow(
    unreachable_pub,
    clippy::unwrap_used,
    reason = "a module of tests; panics are how they fail"
)]

use std::io::Cursor;

/// LAS 1.2 of coloured points, and LAZ 1.4 of extended ones.
pub fn files() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("generated.las", file(2, false)),
        ("generated.laz", file(7, true)),
    ]
}

fn file(format: u8, is_compressed: bool) -> Vec<u8> {
    let mut format = las::point::Format::new(format).unwrap();
    format.is_compressed = is_compressed;
    let has_time = format.has_gps_time;
    let mut builder = las::Builder::from(if format.is_extended { (1, 4) } else { (1, 2) });
    builder.point_format = format;
    let header = builder.into_header().unwrap();
    let mut writer = las::Writer::new(Cursor::new(Vec::new()), header).unwrap();
    for i in 0..60u16 {
        let point = las::Point {
            x: f64::from(i % 8),
            y: f64::from(i / 8),
            z: f64::from(i * i % 31) / 10.0,
            intensity: 300 * i,
            color: Some(las::Color::new(1000 * i, 500, 60_000)),
            gps_time: has_time.then_some(f64::from(i)),
            ..las::Point::default()
        };
        writer.write_point(point).unwrap();
    }
    writer.into_inner().unwrap().into_inner()
}
