//! Cells that are collapsed, blanked or all in one place: kernels that are legal, and work that grows as the mesh does.

use super::super::tree::Tree;
use super::*;

/// A polar grid: its axis is collapsed, it ends at the angle where it begins, layers grow from a wall on.
fn polar(dims: [usize; 3]) -> Vec<DVec3> {
    let wall = dims[0] as f64 / 4.0;
    block(dims, |u| {
        let from_wall = u.x - wall;
        let radius = wall + from_wall.signum() * (1.15f64.powf(from_wall.abs()) - 1.0);
        let innermost = wall - (1.15f64.powf(wall) - 1.0);
        let angle = std::f64::consts::TAU * u.y / (dims[1] - 1) as f64;
        let radius = if u.x == 0.0 { 0.0 } else { radius - innermost };
        DVec3::new(radius * angle.cos(), radius * angle.sin(), 0.5 * u.z)
    })
}

/// The polar grid with everything inside the wall blanked, except the axis, in the lower half.
fn post(dims: [usize; 3]) -> Mesh {
    let points = polar(dims);
    let is_blanked = |n: usize| {
        let [i, k] = [n % dims[0], n / (dims[0] * dims[1])];
        (2..dims[0] / 4).contains(&i) && k < dims[2] / 2
    };
    let field = MeshField {
        name: "f".to_owned(),
        association: Association::Point,
        values: points.iter().map(|p| p.x as f32).collect(),
    };
    let positions = points.iter().map(|p| p.as_vec3().to_array()).collect();
    let blanked = (0..points.len()).map(is_blanked).collect();
    let topology = Topology::Structured(vec![dims]);
    Mesh::new(positions, topology, blanked, field, DAffine3::IDENTITY).unwrap()
}

fn assert_legal(kernels: &MeshKernels, samples: usize) {
    assert!(kernels.len() <= MOST_PER_SAMPLE * samples);
    assert!(kernels.masses.iter().all(|mass| mass.is_finite() && *mass > 0.0));
    assert!(kernels.positions.iter().flatten().all(|v| v.is_finite()));
    assert!(kernels.covariances.iter().flatten().all(|v| v.is_finite()));
    assert!(kernels.gradients.iter().flatten().all(|v| v.is_finite()));
}

/// Kernels that are looked at for the sums of all kernels at all centres.
fn work(kernels: &MeshKernels) -> usize {
    let samples: Vec<Sample> = (0..kernels.len())
        .map(|n| {
            let [xx, xy, xz, yy, yz, zz] = kernels.covariances[n].map(f64::from);
            Sample {
                position: DVec3::from_array(kernels.positions[n].map(f64::from)),
                covariance: DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]),
                mass: f64::from(kernels.masses[n]),
                gradient: DVec3::ZERO,
                value: 0.0,
                valid: true,
            }
        })
        .collect();
    let tree = Tree::new(&samples);
    tree.work(&tree.places(|_| true))
}

#[test]
fn collapsed_and_blanked_cells_make_no_more_work_than_others() {
    let found = [[16, 13, 8], [16, 25, 8], [16, 25, 16]].map(|dims| {
        let kernels = kernels(&post(dims), SIGMA);
        assert_legal(&kernels, dims.iter().product());
        let work = work(&kernels);
        println!(
            "{dims:?}: {} kernels, {:?}, {work}",
            kernels.len(),
            kernels.resampling
        );
        (kernels.len() as f64, work as f64)
    });
    for pair in found.windows(2) {
        let (kernels, work) = (pair[1].0 / pair[0].0, pair[1].1 / pair[0].1);
        assert!(
            work < 1.5 * kernels,
            "{work} times the work for {kernels} times the kernels"
        );
    }
}

/// A constant within the polar grid, away from its ends, its axis and its seam.
#[test]
fn a_constant_stays_constant_around_what_is_collapsed() {
    let dims = [16, 25, 12];
    let points = polar(dims);
    let mesh = mesh(&points, Topology::Structured(vec![dims]), Association::Point);
    let found = kernels(&mesh, SIGMA);
    assert_legal(&found, points.len());
    let sum_at = |at: DVec3| {
        let term = |n: usize| {
            let [xx, xy, xz, yy, yz, zz] = found.covariances[n].map(f64::from);
            let covariance = DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]);
            let offset = at - DVec3::from_array(found.positions[n].map(f64::from));
            let peak = ((2.0 * std::f64::consts::PI).powi(3) * covariance.determinant()).sqrt();
            f64::from(found.masses[n]) / peak * (-0.5 * offset.dot(covariance.inverse() * offset)).exp()
        };
        (0..found.len()).map(term).sum::<f64>()
    };
    let mut random = Random::new(3);
    let mut largest = 0.0f64;
    for _ in 0..100 {
        let radius = 1.0 + 1.5 * random.unit();
        let angle = 1.2 + 3.8 * random.unit();
        let at = DVec3::new(
            radius * angle.cos(),
            radius * angle.sin(),
            0.5 * (3.5 + 4.0 * random.unit()),
        );
        largest = largest.max((sum_at(at) - 1.0).abs());
    }
    println!("{:?}, largest {largest}", found.resampling);
    assert!(largest < 0.01, "{largest}");
}

/// Cells without volume have no kernels; others beside them do.
#[test]
fn cells_that_are_all_in_one_place_have_no_kernels() {
    let dims = [9, 8, 7];
    for kept in [0.0, 4.0] {
        let points = block(dims, |u| if u.x < kept { u } else { DVec3::new(kept, 3.0, 3.0) });
        for topology in [
            Topology::Structured(vec![dims]),
            Topology::Unstructured(hexahedra(dims)),
            Topology::Unstructured(tetrahedra(dims)),
        ] {
            for association in [Association::Point, Association::Cell] {
                let found = kernels(&mesh(&points, topology.clone(), association), SIGMA);
                assert_legal(&found, points.len());
                assert_eq!(found.is_empty(), kept == 0.0, "{association:?} {kept}");
            }
        }
    }
}

/// A hostile file's mesh: one point of an even block lies very far away.
#[test]
fn one_point_far_away_makes_no_work_of_all_pairs() {
    for far in [1e3, 1e6, 2e9] {
        let dims = [24, 25, 40];
        let mut points = block(dims, |u| u * 0.1);
        points[13_330].z = far;
        let field = MeshField {
            name: "f".to_owned(),
            association: Association::Point,
            values: points.iter().map(|p| p.x as f32).collect(),
        };
        let positions = points.iter().map(|p| p.as_vec3().to_array()).collect();
        let topology = Topology::Structured(vec![dims]);
        let mesh = Mesh::new(positions, topology, Vec::new(), field, DAffine3::IDENTITY).unwrap();
        let kernels = kernels(&mesh, SIGMA);
        assert_legal(&kernels, points.len());
        let per_kernel = work(&kernels) / kernels.len();
        println!(
            "{far}: {} kernels, {:?}, {per_kernel}",
            kernels.len(),
            kernels.resampling
        );
        assert!(
            per_kernel < 2 * 512,
            "{far}: {per_kernel} kernels looked at for each of 16 places"
        );
    }
}
