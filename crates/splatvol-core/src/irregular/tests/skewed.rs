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
        ("jump 1:8", Box::new(|u: DVec3| DVec3::new(jump(u.x), u.y, u.z))),
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
        (
            "kinks of 65 degrees every third layer",
            Box::new(move |u: DVec3| {
                let within = u.z.rem_euclid(6.0);
                let shift = 65f64.to_radians().tan() * within.min(6.0 - within);
                DVec3::new(u.x + shift, u.y, u.z)
            }),
        ),
    ]
}

const DIMS: [usize; 3] = [14, 13, 14];

fn measure(
    points: &[DVec3],
    topology: Topology,
    association: Association,
    place: &Place,
) -> (Ripple, Kernels) {
    let mesh = mesh(points, topology, association);
    let kernels = kernels(&mesh, SIGMA);
    (ripple(&kernels, DIMS, 3.5, place), kernels)
}

#[test]
fn skewed_structured_cells() {
    for (name, place) in places() {
        let points = block(DIMS, &place);
        for association in [Association::Point, Association::Cell] {
            let (found, kernels) = measure(&points, Topology::Structured(vec![DIMS]), association, &place);
            println!("{name} {association:?}: {} kernels, {found:?}", kernels.len());
        }
    }
}

/// Every second tetrahedron in four, around a point near one of its edges: three of the four are slivers.
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
fn skewed_unstructured_cells() {
    let identity: Place = Box::new(|u| u);
    let x: Place = Box::new(|u: DVec3| DVec3::new(jump(u.x), u.y, u.z));
    let flat: Place = Box::new(|u: DVec3| DVec3::new(u.x, u.y, 0.02 * u.z));
    let mut cases: Vec<(&str, &Place, Vec<DVec3>, Cells)> = vec![
        ("tetra jump 1:8", &x, block(DIMS, &x), tetrahedra(DIMS)),
        ("hexa jump 1:8", &x, block(DIMS, &x), hexahedra(DIMS)),
        (
            "tetra jitter 0.4",
            &identity,
            jittered(DIMS, 0.4),
            tetrahedra(DIMS),
        ),
        (
            "tetra flat 1:50 jitter 0.3",
            &flat,
            jittered(DIMS, 0.3).into_iter().map(&flat).collect(),
            tetrahedra(DIMS),
        ),
    ];
    let mut points = block(DIMS, |u| u);
    let slivers = split(&mut points, &tetrahedra(DIMS));
    cases.push(("tetra slivers", &identity, points, slivers));
    for (name, place, points, cells) in cases {
        for association in [Association::Point, Association::Cell] {
            let (found, kernels) =
                measure(&points, Topology::Unstructured(cells.clone()), association, place);
            println!("{name} {association:?}: {} kernels, {found:?}", kernels.len());
        }
    }
}
