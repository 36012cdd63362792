//! Ripple of constant fields, gradients of linear ones, volumes of cells; f64, seeded.

use glam::{DAffine3, DMat3, DVec3};
use splatvol_scene::{Association, CellKind, Cells, Mesh, MeshField, Topology};
use splatvol_testing::Random;

use super::*;

mod degenerate;
mod ripple;
mod skewed;

const SIGMA: f64 = 0.74;
const SLOPE: DVec3 = DVec3::new(0.7, -1.3, 0.4);

/// A mesh of a linear field.
fn mesh(points: &[DVec3], topology: Topology, association: Association) -> Mesh {
    let linear = |p: DVec3| (SLOPE.dot(p) + 2.0) as f32;
    let values = match (association, &topology) {
        (Association::Point, _) => points.iter().map(|&p| linear(p)).collect(),
        (Association::Cell, Topology::Unstructured(cells)) => {
            let centre = |cell| {
                let own = cells.points(cell);
                own.iter().map(|&p| points[p as usize]).sum::<DVec3>() / own.len() as f64
            };
            (0..cells.len()).map(|cell| linear(centre(cell))).collect()
        }
        (Association::Cell, Topology::Structured(blocks)) => {
            assert_eq!(blocks.len(), 1);
            cell_centres(points, blocks[0]).into_iter().map(linear).collect()
        }
    };
    let field = MeshField {
        name: "f".to_owned(),
        association,
        values,
    };
    let positions = points.iter().map(|p| p.as_vec3().to_array()).collect();
    Mesh::new(positions, topology, vec![], field, DAffine3::IDENTITY).unwrap()
}

/// Centres of the cells of a block.
fn cell_centres(points: &[DVec3], dims: [usize; 3]) -> Vec<DVec3> {
    let cells = hexahedra(dims);
    let centre = |cell| {
        cells
            .points(cell)
            .iter()
            .map(|&p| points[p as usize])
            .sum::<DVec3>()
            / 8.0
    };
    (0..cells.len()).map(centre).collect()
}

/// Points of a block of `dims` at `place(i, j, k)`.
fn block(dims: [usize; 3], place: impl Fn(DVec3) -> DVec3) -> Vec<DVec3> {
    let count: usize = dims.iter().product();
    let at = |n: usize| {
        DVec3::new(
            (n % dims[0]) as f64,
            (n / dims[0] % dims[1]) as f64,
            (n / dims[0] / dims[1]) as f64,
        )
    };
    (0..count).map(|n| place(at(n))).collect()
}

/// Each cube of a block as six tetrahedra.
fn tetrahedra(dims: [usize; 3]) -> Cells {
    let mut cells = Cells::default();
    let stride = [1, dims[0], dims[0] * dims[1]];
    let paths = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    for k in 0..dims[2] - 1 {
        for j in 0..dims[1] - 1 {
            for i in 0..dims[0] - 1 {
                let first = i + stride[1] * j + stride[2] * k;
                for path in paths {
                    let second = first + stride[path[0]];
                    let third = second + stride[path[1]];
                    let points = [first, second, third, third + stride[path[2]]].map(|p| p as u32);
                    cells.push(CellKind::Tetra, &points).unwrap();
                }
            }
        }
    }
    cells
}

/// Points of a lattice moved by up to `jitter`.
fn jittered(dims: [usize; 3], jitter: f64) -> Vec<DVec3> {
    let mut random = Random::new(11);
    let mut points = block(dims, |u| u);
    for p in &mut points {
        *p += random.point(DVec3::splat(-jitter), DVec3::splat(jitter));
    }
    points
}

#[test]
fn gradients_of_linear_fields_are_exact() {
    let dims = [7, 6, 5];
    let points = jittered(dims, 0.25);
    for topology in [
        Topology::Structured(vec![dims]),
        Topology::Unstructured(tetrahedra(dims)),
        Topology::Unstructured(hexahedra(dims)),
    ] {
        let kernels = kernels(&mesh(&points, topology, Association::Point), SIGMA);
        // Points of a structured grid that are moved that far are resampled.
        assert!(kernels.len() >= points.len());
        for gradient in &kernels.gradients {
            let error = (DVec3::from_array(gradient.map(f64::from)) - SLOPE).length();
            // Values are f32 of magnitude 10.
            assert!(error < 2e-5, "{gradient:?}");
        }
    }
    let kernels = kernels(
        &mesh(
            &points,
            Topology::Unstructured(tetrahedra(dims)),
            Association::Cell,
        ),
        SIGMA,
    );
    for gradient in &kernels.gradients {
        let error = (DVec3::from_array(gradient.map(f64::from)) - SLOPE).length();
        assert!(error < 2e-4, "{gradient:?}");
    }
}

/// Corners and edge midpoints of one cell of a kind, its volume, and its second moments about the centre per
/// volume.
fn one_cell(kind: CellKind) -> (Vec<DVec3>, f64) {
    let v = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let square = [
        v(0.0, 0.0, 0.0),
        v(1.0, 0.0, 0.0),
        v(1.0, 1.0, 0.0),
        v(0.0, 1.0, 0.0),
    ];
    let (mut points, volume) = match kind.linear() {
        CellKind::Tetra => (vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z], 1.0 / 6.0),
        CellKind::Pyramid => (square.into_iter().chain([v(0.3, 0.6, 1.0)]).collect(), 1.0 / 3.0),
        CellKind::Wedge => {
            let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y];
            (
                triangle
                    .into_iter()
                    .chain(triangle.map(|p| p + DVec3::Z))
                    .collect(),
                0.5,
            )
        }
        CellKind::Voxel => (
            (0..8)
                .map(|c| v((c & 1) as f64, (c >> 1 & 1) as f64, (c >> 2) as f64))
                .collect(),
            1.0,
        ),
        _ => (
            square
                .into_iter()
                .chain(square.map(|p| p + DVec3::Z))
                .collect::<Vec<_>>(),
            1.0,
        ),
    };
    for [a, b] in reference_cell::edges(kind) {
        points.push(0.5 * (points[a] + points[b]));
    }
    let centre = points.iter().sum::<DVec3>() / points.len() as f64;
    points.resize(kind.point_count(), centre);
    (points, volume)
}

#[test]
fn cells_of_every_kind_have_their_volume() {
    let map = DMat3::from_cols(
        DVec3::new(2.0, 0.1, 0.0),
        DVec3::new(0.5, 1.0, -0.3),
        DVec3::new(0.0, 0.2, 3.0),
    );
    for kind in CellKind::ALL {
        let (points, volume) = one_cell(kind);
        let points: Vec<DVec3> = points.into_iter().map(|p| map * p).collect();
        let mut cells = Cells::default();
        cells
            .push(kind, &(0..points.len() as u32).collect::<Vec<_>>())
            .unwrap();
        let expected = volume * map.determinant();
        // The map of a pyramid is not affine in the coordinates of a cube: midpoints give its volume to 1/64.
        let tolerance = if kind.linear() == CellKind::Pyramid {
            0.02
        } else {
            1e-5
        };
        for association in [Association::Point, Association::Cell] {
            let found = kernels(
                &mesh(&points, Topology::Unstructured(cells.clone()), association),
                SIGMA,
            );
            let mass: f64 = found.masses.iter().map(|&m| f64::from(m)).sum();
            assert!(
                (mass / expected - 1.0).abs() < tolerance,
                "{kind:?} {association:?}: {mass} {expected}"
            );
        }
    }
}

#[test]
fn a_tetrahedron_has_the_covariance_of_a_tetrahedron() {
    let corners = [
        DVec3::ZERO,
        DVec3::new(2.0, 0.3, 0.0),
        DVec3::new(0.4, 1.0, 0.2),
        DVec3::new(0.1, -0.2, 3.0),
    ];
    let mut cells = Cells::default();
    cells.push(CellKind::Tetra, &[0, 1, 2, 3]).unwrap();
    let found = kernels(
        &mesh(&corners, Topology::Unstructured(cells), Association::Cell),
        SIGMA,
    );
    let centre = corners.iter().sum::<DVec3>() / 4.0;
    let moments = corners
        .iter()
        .fold(DMat3::ZERO, |sum, &c| sum + outer(c - centre, c - centre))
        * 0.05;
    let expected = symmetric(&(moments * 12.0 * (1.15 * SIGMA).powi(2)));
    for (found, expected) in found.covariances[0].into_iter().zip(expected) {
        assert!((found - expected).abs() < 1e-5 * 10.0, "{found} {expected}");
    }
}

#[test]
fn what_is_missing_or_blanked_has_no_kernel_and_blocks_share_their_border() {
    let dims = [6, 5, 5];
    let points = block(dims, |u| u);
    let mut values = vec![1.0; 150];
    values[7] = f32::NAN;
    let field = |values: Vec<f32>| MeshField {
        name: "f".to_owned(),
        association: Association::Point,
        values,
    };
    let local = |points: &[DVec3]| points.iter().map(|p| p.as_vec3().to_array()).collect::<Vec<_>>();
    let blanked = (0..150).map(|n| n == 40 || n == 41).collect();
    let topology = Topology::Structured(vec![dims]);
    let mesh = Mesh::new(
        local(&points),
        topology,
        blanked,
        field(values),
        DAffine3::IDENTITY,
    )
    .unwrap();
    let found = kernels(&mesh, SIGMA);
    assert_eq!(found.len(), 147);
    assert!(
        found.masses.iter().all(|mass| (mass - 1.0).abs() < 1e-2),
        "{:?}",
        found.masses
    );
    // The same block twice, the second beginning where the first ends.
    let second: Vec<DVec3> = points.iter().map(|p| *p + 5.0 * DVec3::X).collect();
    let both = [points, second].concat();
    let topology = Topology::Structured(vec![dims; 2]);
    let mesh = Mesh::new(
        local(&both),
        topology,
        vec![],
        field(vec![1.0; 300]),
        DAffine3::IDENTITY,
    )
    .unwrap();
    let found = kernels(&mesh, SIGMA);
    let mass: f32 = found.masses.iter().sum();
    assert!((mass - 11.0 * 25.0).abs() < 0.1, "{mass}");
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let dims = [9, 8, 7];
    let mesh = mesh(
        &jittered(dims, 0.2),
        Topology::Unstructured(tetrahedra(dims)),
        Association::Point,
    );
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| kernels(&mesh, SIGMA))
    };
    assert_eq!(with(1), with(3));
}

/// The cubes of a block.
fn hexahedra(dims: [usize; 3]) -> Cells {
    let mut cells = Cells::default();
    let (dy, dz) = (dims[0], dims[0] * dims[1]);
    for k in 0..dims[2] - 1 {
        for j in 0..dims[1] - 1 {
            for i in 0..dims[0] - 1 {
                let first = i + dy * j + dz * k;
                let base = [first, first + 1, first + 1 + dy, first + dy];
                let points: Vec<u32> = base
                    .into_iter()
                    .chain(base.map(|p| p + dz))
                    .map(|p| p as u32)
                    .collect();
                cells.push(CellKind::Hexahedron, &points).unwrap();
            }
        }
    }
    cells
}
