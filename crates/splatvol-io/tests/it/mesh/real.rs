use splatvol_io::{ReadOptions, is_mesh, read_mesh};
use splatvol_scene::{Association, CellKind, Topology};

use super::{array, read, real_files};

/// Expected contents of a file: points, cells, low and high corner.
struct Expected {
    file: &'static str,
    points: usize,
    cells: usize,
    bounds: [[f64; 3]; 2],
    /// Array (none: the default), whether it belongs to cells, range.
    arrays: &'static [(Option<&'static str>, bool, [f32; 2])],
}

const FILES: [Expected; 9] = [
    Expected {
        file: "combxyz.bin",
        points: 57 * 33 * 25,
        cells: 56 * 32 * 24,
        bounds: [[0.0, -5.66214, 23.3312], [16.51, 5.66214, 36.195]],
        arrays: &[
            (None, false, [0.19781, 0.71042]),
            (Some("Momentum"), false, [0.0, 446.74]),
            (Some("energy"), false, [0.0, 0.0]),
        ],
    },
    Expected {
        file: "RectGrid2.vtk",
        points: 47 * 33 * 11,
        cells: 46 * 32 * 10,
        bounds: [[-1.22396, -1.25, 0.0], [1.17188, 1.25, 0.9]],
        arrays: &[
            (None, false, [0.0, 10.396]),
            (Some("vectors"), false, [0.0, 10.396]),
        ],
    },
    Expected {
        file: "cth.vtr",
        points: 129 * 65 * 65,
        cells: 128 * 64 * 64,
        bounds: [[-7.5, -3.0, -3.0], [4.0, 3.0, 3.0]],
        arrays: &[
            (Some("Pressure"), true, [-2.3595e10, 1.1204e11]),
            (Some("Void Volume Fraction"), true, [0.0, 1.0]),
            (Some("X Velocity"), true, [-86619.0, 3.2748e5]),
            (Some("Z Velocity"), true, [-88307.0, 1.3286e5]),
        ],
    },
    Expected {
        file: "hexa.vtk",
        points: 12167,
        cells: 10648,
        bounds: [[0.0; 3], [0.95652; 3]],
        arrays: &[(None, false, [0.75306, 17.321])],
    },
    Expected {
        file: "can.vtu",
        points: 6724,
        cells: 4800,
        bounds: [[-12.1696, -3.60042, -18.3355], [6.00287, 5.5622, -13.4565]],
        arrays: &[
            (None, true, [0.021583, 2.8939]),
            (Some("DISPL"), false, [2.4611, 18.594]),
            (Some("ACCL"), false, [2.4035e5, 2.0194e8]),
        ],
    },
    Expected {
        file: "office.binary.vtk",
        points: 21 * 20 * 20,
        cells: 20 * 19 * 19,
        bounds: [[0.01; 3], [4.5, 4.5, 2.5]],
        arrays: &[
            (None, false, [-3.8696, 0.71856]),
            (Some("vectors"), false, [0.0, 0.80494]),
        ],
    },
    Expected {
        file: "SampleStructGrid.vtk",
        points: 20 * 30 * 40,
        cells: 19 * 29 * 39,
        bounds: [[0.0, 0.0, 1e-5], [0.98497, 0.73499, 0.485]],
        arrays: &[(None, false, [0.0, 1.3046])],
    },
    Expected {
        file: "notch_stress.vtk",
        points: 12717,
        cells: 2192,
        bounds: [[0.0; 3], [0.4, 0.1, 0.01]],
        arrays: &[
            (Some("Nodal Stress-0"), false, [-1.4536e5, 8.1078e6]),
            (Some("Nodal Stress"), false, [0.0, 8.1098e6]),
            (Some("Nodal Stress-normed"), false, [3206.6, 8.1098e6]),
        ],
    },
    Expected {
        file: "CylinderQuadratic.vtk",
        points: 2814,
        cells: 1522,
        bounds: [[-0.01, -0.01, 0.0], [0.01, 0.01, 0.1]],
        arrays: &[
            (None, false, [-98.439, 7234.5]),
            (Some("velocity"), false, [0.0, 1.0044]),
            (Some("velocity_norm"), false, [0.0, 1.0044]),
        ],
    },
];

/// Equality to five digits, the precision of the figures.
fn close(a: f64, b: f64, scale: f64) -> bool {
    (a - b).abs() <= 1e-4 * scale.abs().max(b.abs())
}

#[test]
fn real_files_hold_what_other_readers_find_in_them() {
    let Some(folder) = real_files() else { return };
    for expected in &FILES {
        let path = folder.join(expected.file);
        assert!(is_mesh(&path).unwrap(), "{}", expected.file);
        for &(name, of_cells, range) in expected.arrays {
            let start = std::time::Instant::now();
            let loaded = read(&path, name);
            let mesh = &loaded.mesh;
            println!("{} {:?} {:?}", expected.file, mesh.field().name, start.elapsed());
            assert_eq!(mesh.positions().len(), expected.points, "{}", expected.file);
            assert_eq!(mesh.cell_count(), expected.cells, "{}", expected.file);
            assert_eq!(
                mesh.field().association == Association::Cell,
                of_cells,
                "{}",
                expected.file
            );
            let scale = f64::from(range[1].abs().max(range[0].abs()));
            for (found, wanted) in mesh.value_range().into_iter().zip(range) {
                let text = format!("{}: {found} for {wanted}", expected.file);
                assert!(close(found.into(), wanted.into(), 0.01 * scale), "{text}");
            }
            let bounds = mesh.bounds();
            for (found, wanted) in [bounds.min, bounds.max].into_iter().zip(expected.bounds) {
                let same = (0..3).all(|axis| close(found[axis], wanted[axis], 0.1));
                assert!(same, "{}: {found} for {wanted:?}", expected.file);
            }
            let known = ["may be cut short", "list more points", "9180 values are missing"];
            let odd = |text: &&String| !known.iter().any(|known| text.contains(known));
            assert_eq!(loaded.description.warnings.iter().find(odd), None);
        }
    }
}

#[test]
fn kinds_of_cells_are_those_that_other_readers_count() {
    let Some(folder) = real_files() else { return };
    let count = |file: &str, kind: CellKind| match read(&folder.join(file), None).mesh.topology() {
        Topology::Unstructured(cells) => cells.kinds().iter().filter(|&&k| k == kind).count(),
        Topology::Structured(_) => 0,
    };
    assert_eq!(count("hexa.vtk", CellKind::Hexahedron), 10648);
    assert_eq!(count("can.vtu", CellKind::Hexahedron), 4800);
    assert_eq!(count("notch_stress.vtk", CellKind::Hexahedron), 2188);
    assert_eq!(count("notch_stress.vtk", CellKind::Wedge), 4);
    assert_eq!(count("CylinderQuadratic.vtk", CellKind::QuadraticTetra), 1522);
}

#[test]
fn cans_and_plates_are_shells_and_solids_are_not() {
    let Some(folder) = real_files() else { return };
    let thickness = |name: &str| {
        let options = ReadOptions::default();
        read_mesh(folder.join(name), &options)
            .unwrap()
            .mesh
            .shell_thickness()
    };
    let can = thickness("can.vtu").unwrap();
    assert!((0.05..0.5).contains(&can), "{can}");
    // 0.01 thick.
    let plate = thickness("notch_stress.vtk").unwrap();
    assert!((0.007..0.0101).contains(&plate), "{plate}");
    for name in [
        "hexa.vtk",
        "CylinderQuadratic.vtk",
        "office.binary.vtk",
        "cth.vtr",
        "RectGrid2.vtk",
    ] {
        assert_eq!(thickness(name), None, "{name}");
    }
}

#[test]
fn arrays_are_listed_and_the_solution_finds_its_grid() {
    let Some(folder) = real_files() else { return };
    let error = read_mesh(folder.join("cth.vtr"), &array("pressure"))
        .unwrap_err()
        .to_string();
    assert!(error.contains("`Pressure` (1 x Float32, cell data)"), "{error}");
    assert!(error.contains("`Mass for Body, Nose`"), "{error}");
    // The file marks an array; that one is the default.
    assert_eq!(
        read(&folder.join("cth.vtr"), None).mesh.field().name,
        "Mass for Body, Nose"
    );
    let cells = read_mesh(folder.join("SampleStructGrid.vtk"), &array("scalars:0")).unwrap();
    assert_eq!(cells.arrays.len(), 2);
    let by_grid = read(&folder.join("combxyz.bin"), Some("velocity:1"));
    let by_solution = read(&folder.join("combq.bin"), Some("velocity:1"));
    assert_eq!(by_grid.mesh, by_solution.mesh);
    assert_eq!(by_grid.mesh.field().name, "velocity:1");
    // Energy is zero in this file: pressure is minus the kinetic energy's share.
    let pressure = read(&folder.join("combxyz.bin"), Some("pressure")).mesh;
    let speed = read(&folder.join("combxyz.bin"), Some("velocity")).mesh;
    let density = read(&folder.join("combxyz.bin"), None).mesh;
    let values =
        |index: usize| [&pressure, &speed, &density].map(|mesh| f64::from(mesh.field().values[index]));
    for index in (0..density.positions().len()).step_by(97) {
        let [pressure, speed, density] = values(index);
        let expected = -0.2 * density * speed * speed;
        assert!(
            (pressure - expected).abs() <= 1e-5 * expected.abs(),
            "{pressure} {expected}"
        );
    }
}
