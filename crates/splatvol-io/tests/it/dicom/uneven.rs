//! A tilted gantry whose slices lie at three distances, as scans of the head had them: close at the skull base, far above.

use crate::common::slices::assert_opens;
use glam::DVec3;
use splatvol_io::{ReadOptions, read_volume};
use splatvol_scene::volume::widen;
use splatvol_scene::with_samples;

use crate::common::dicom_file::{DicomFile, EXPLICIT};

/// Runs of slices: their distance along the table, millimetres, and their number.
const RUNS: [(f64, usize); 3] = [(1.08, 24), (4.0, 8), (7.0, 6)];
/// Angle between slices and the table's normal plane, radians.
const TILT: f64 = 0.3;
/// Columns and rows.
const SIZE: [usize; 2] = [7, 9];

/// A value that rises evenly in space, in patient coordinates.
fn value(place: DVec3) -> f64 {
    2000.0 + place.dot(DVec3::new(11.0, -7.0, 17.0))
}

/// Direction of columns; rows run along x.
fn down() -> DVec3 {
    DVec3::new(0.0, TILT.cos(), -TILT.sin())
}

fn slice(number: usize, height: f64) -> DicomFile {
    let corner = DVec3::new(-3.0, -4.0, height);
    let place =
        |index: usize| corner + DVec3::X * (index % SIZE[0]) as f64 + down() * (index / SIZE[0]) as f64;
    let samples: Vec<u16> = (0..SIZE[0] * SIZE[1])
        .map(|index| value(place(index)).round() as u16)
        .collect();
    let mut file = DicomFile::slice(EXPLICIT, corner.to_array(), number as i32, &[0; 6]);
    let down = down();
    file.text(
        0x0020_0037,
        b"DS",
        &format!("1\\0\\0\\0\\{:.9}\\{:.9}", down.y, down.z),
    );
    file.text(0x0028_0030, b"DS", "1\\1");
    file.short(0x0028_0010, SIZE[1] as u16);
    file.short(0x0028_0011, SIZE[0] as u16);
    file.pixels(&samples);
    file
}

fn heights() -> Vec<f64> {
    let steps = RUNS.iter().flat_map(|&(step, count)| vec![step; count]);
    let sums = steps.scan(0.0, |height, step| {
        *height += step;
        Some(*height)
    });
    std::iter::once(0.0).chain(sums).collect()
}

#[test]
fn three_distances_under_a_tilted_gantry_lie_where_they_were_taken() {
    let folder = tempfile::tempdir().unwrap();
    for (number, &height) in heights().iter().enumerate() {
        std::fs::write(
            folder.path().join(format!("{number:02}")),
            slice(number, height).bytes(),
        )
        .unwrap();
    }
    let loaded = read_volume(folder.path(), &ReadOptions::default()).unwrap();
    assert_opens(folder.path(), &ReadOptions::default(), &loaded);
    let warning = &loaded.description.warnings[0];
    let steps = RUNS
        .map(|(step, _)| format!("{:.4}", step * TILT.cos()))
        .join(", ");
    assert!(warning.contains(&format!("steps of {steps}")), "{warning}");
    assert!(
        loaded.description.orientation.contains("tilt"),
        "{}",
        loaded.description.orientation
    );

    // Everywhere the value of its place: nothing is sheared, and nothing creases where the distance changes.
    let grid = loaded.volume.grid();
    let [columns, rows, slices] = grid.dims();
    assert_eq!([columns, rows], SIZE);
    assert!(slices > heights().len());
    let values: Vec<f64> = with_samples!(loaded.volume.samples(), samples => {
        samples.iter().map(|&sample| widen(sample)).collect()
    });
    for (index, found) in values.iter().enumerate() {
        let voxel = DVec3::new(
            (index % columns) as f64,
            (index / columns % rows) as f64,
            (index / (columns * rows)) as f64,
        );
        let world = grid.world_from_voxel().transform_point3(voxel);
        let expected = value(world * DVec3::new(-1.0, -1.0, 1.0));
        assert!((found - expected).abs() < 1.0, "{voxel}: {found}, not {expected}");
    }

    let strict = ReadOptions {
        strict: true,
        ..ReadOptions::default()
    };
    let error = read_volume(folder.path(), &strict).unwrap_err().to_string();
    assert!(error.contains("not evenly spaced"), "{error}");
}
