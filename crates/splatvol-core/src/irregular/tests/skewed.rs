//! Meshes whose cells change shape within a kernel: ripple of a constant and error of a linear field.

use super::ripple::{Ripple, ripple};
use super::*;

type Place = Box<dyn Fn(DVec3) -> DVec3>;

/// Linear between `steps` of unit indices; the last step goes on.
fn piecewise(t: f64, steps: &[f64]) -> f64 {
    let last = steps.len() - 1;
    let whole = (t.floor().max(0.0) as usize).min(last);
    steps[..whole].iter().sum::<f64>() + (t - whole as f64) * steps[whole]
}

/// Spacing 1, then 8 from index 7 on.
fn jump(t: f64) -> f64 {
    if t < 7.0 { t } else { 7.0 + 8.0 * (t - 7.0) }
}

/// Structured places by name, and how many samples along the axes.
fn places() -> Vec<(&'static str, Place)> {
    let tangent = 70f64.to_radians().tan();
    let layers = [0.02, 0.02, 0.02, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64, 1.0];
    vec![
        (
            "jump 1:8 twice",
            Box::new(|u: DVec3| DVec3::new(jump(u.x), u.y, jump(u.z))),
        ),
        (
            "boundary layer 1:50",
            Box::new(move |u: DVec3| DVec3::new(u.x, u.y, piecewise(u.z, &layers))),
        ),
        (
            "shear 70 degrees at once",
            Box::new(move |u: DVec3| DVec3::new(u.x + tangent * (u.z - 6.0).max(0.0), u.y, u.z)),
        ),
        (
            "zigzag of 70 degrees",
            Box::new(move |u: DVec3| {
                let within = u.z.rem_euclid(2.0);
                DVec3::new(u.x + tangent * within.min(2.0 - within), u.y, u.z)
            }),
        ),
    ]
}

const DIMS: [usize; 3] = [14, 9, 14];

fn measure(
    points: &[DVec3],
    topology: Topology,
    association: Association,
    place: &Place,
) -> (Ripple, MeshKernels) {
    let mesh = mesh(points, topology, association);
    let kernels = kernels(&mesh, SIGMA);
    (ripple(&kernels, DIMS, 3.5, place), kernels)
}

#[test]
fn a_constant_stays_constant_on_skewed_structured_cells() {
    for (name, place) in places() {
        let points = block(DIMS, &place);
        // Cells take four times as long to measure: one case has them.
        let associations = match name {
            "boundary layer 1:50" => vec![Association::Point, Association::Cell],
            _ => vec![Association::Point],
        };
        for association in associations {
            let (found, kernels) = measure(&points, Topology::Structured(vec![DIMS]), association, &place);
            println!("{name} {association:?}: {:?}, {found:?}", kernels.resampling);
            assert!(
                found.largest < 0.015 && found.mean < 0.006,
                "{name} {association:?}: {found:?}"
            );
            assert!(found.linear < 0.06, "{name} {association:?}: {found:?}");
            assert!(kernels.resampling.added > 0 && !kernels.resampling.limited);
            assert!(kernels.gradients.iter().flatten().all(|slope| slope.is_finite()));
        }
    }
}

/// Splits every second tetrahedron into four around a point near one of its edges: three of the four are slivers.
fn split(points: &mut Vec<DVec3>, cells: &Cells) -> Cells {
    let mut random = Random::new(5);
    let mut all = Cells::default();
    for cell in 0..cells.len() {
        let own: [u32; 4] = std::array::from_fn(|n| cells.points(cell)[n]);
        if random.unit() < 0.5 {
            all.push(CellKind::Tetra, &own).unwrap();
            continue;
        }
        let weights = [0.05, 0.1, 0.4, 0.45];
        let inner = points.len() as u32;
        let place = (0..4).map(|n| weights[n] * points[own[n] as usize]).sum();
        points.push(place);
        for replaced in 0..4 {
            let mut corners = own;
            corners[replaced] = inner;
            all.push(CellKind::Tetra, &corners).unwrap();
        }
    }
    all
}

#[test]
fn a_constant_stays_constant_on_skewed_unstructured_cells() {
    let identity: Place = Box::new(|u| u);
    let x: Place = Box::new(|u: DVec3| DVec3::new(jump(u.x), u.y, u.z));
    let mut split_points = block(DIMS, |u| u);
    let slivers = split(&mut split_points, &tetrahedra(DIMS));
    type Case<'a> = (&'a str, &'a Place, Vec<DVec3>, Cells, &'a [Association]);
    let cases: [Case; 3] = [
        (
            "tetra jump 1:8",
            &x,
            block(DIMS, &x),
            tetrahedra(DIMS),
            &[Association::Point],
        ),
        (
            "hexa jump 1:8",
            &x,
            block(DIMS, &x),
            hexahedra(DIMS),
            &[Association::Point],
        ),
        ("slivers", &identity, split_points, slivers, &[Association::Point]),
    ];
    for (name, place, points, cells, associations) in cases {
        for &association in associations {
            let (found, kernels) =
                measure(&points, Topology::Unstructured(cells.clone()), association, place);
            println!("{name} {association:?}: {:?}, {found:?}", kernels.resampling);
            assert!(
                found.largest < 0.03 && found.mean < 0.01,
                "{name} {association:?}: {found:?}"
            );
            assert!(found.linear < 0.08, "{name} {association:?}: {found:?}");
        }
    }
}

/// Kernels are those of the samples where cells vary slowly, or are flat and sheared alike.
#[test]
fn even_meshes_are_not_resampled() {
    let tangent = 80f64.to_radians().tan();
    let places: [Place; 3] = [
        Box::new(move |u: DVec3| DVec3::new(u.x + tangent * u.z, u.y, 0.02 * u.z)),
        Box::new(|u: DVec3| DVec3::new(1.3f64.powf(u.x), u.y, 0.02 * 1.15f64.powf(u.z))),
        Box::new(|u: DVec3| {
            DVec3::new(
                (6.0 + u.x) * (0.1 * u.y).cos(),
                (6.0 + u.x) * (0.1 * u.y).sin(),
                u.z,
            )
        }),
    ];
    for place in &places {
        let points = block(DIMS, place);
        for topology in [
            Topology::Structured(vec![DIMS]),
            Topology::Unstructured(hexahedra(DIMS)),
        ] {
            for association in [Association::Point, Association::Cell] {
                let mesh = mesh(&points, topology.clone(), association);
                let found = kernels(&mesh, SIGMA);
                assert_eq!(found.resampling, Resampling::default());
                assert_eq!(found.len(), mesh.field().values.len());
            }
        }
    }
    for cells in [tetrahedra(DIMS), hexahedra(DIMS)] {
        for association in [Association::Point, Association::Cell] {
            let mesh = mesh(
                &jittered(DIMS, 0.25),
                Topology::Unstructured(cells.clone()),
                association,
            );
            assert_eq!(kernels(&mesh, SIGMA).resampling, Resampling::default());
        }
    }
}

/// Spacings drawn from six decades: never more kernels than allowed, and all of them legal.
#[test]
fn hostile_meshes_make_no_more_kernels_than_allowed() {
    let dims = [7, 6, 5];
    let mut random = Random::new(3);
    let mut lines = || {
        let mut at = 0.0;
        let mut step = || {
            at += 10f64.powf(6.0 * random.unit());
            at
        };
        std::array::from_fn::<f64, 8, _>(|_| step())
    };
    let (x, y, z) = (lines(), lines(), lines());
    let points = block(dims, |u| {
        DVec3::new(x[u.x as usize], y[u.y as usize], z[u.z as usize])
    });
    for topology in [
        Topology::Structured(vec![dims]),
        Topology::Unstructured(tetrahedra(dims)),
        Topology::Unstructured(hexahedra(dims)),
    ] {
        for association in [Association::Point, Association::Cell] {
            let mesh = mesh(&points, topology.clone(), association);
            let found = kernels(&mesh, SIGMA);
            println!("{association:?}: {:?}", found.resampling);
            assert!(found.len() <= MOST_PER_SAMPLE * mesh.field().values.len());
            assert!(found.masses.iter().all(|mass| mass.is_finite() && *mass > 0.0));
            assert!(found.covariances.iter().flatten().all(|v| v.is_finite()));
        }
    }
}
