//! Constant fields stay constant.

use super::*;

/// Errors of a set of kernels on constant and linear fields.
#[derive(Debug)]
pub(super) struct Ripple {
    /// Largest deviation from 1 of the sum of all kernels.
    pub(super) largest: f64,
    /// The root of its mean square.
    pub(super) mean: f64,
    /// Largest error of the linear field that the kernels carry, relative to its range over the places.
    pub(super) linear: f64,
}

/// Measures at random indices at least `margin` cells inside of a block.
pub(super) fn ripple(
    kernels: &MeshKernels,
    dims: [usize; 3],
    margin: f64,
    place: impl Fn(DVec3) -> DVec3,
) -> Ripple {
    let ready: Vec<(DVec3, DMat3, f64)> = (0..kernels.len())
        .map(|i| {
            let [xx, xy, xz, yy, yz, zz] = kernels.covariances[i].map(f64::from);
            let v = DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]);
            let peak = f64::from(kernels.masses[i])
                / ((2.0 * std::f64::consts::PI).powi(3) * v.determinant()).sqrt();
            (
                DVec3::from_array(kernels.positions[i].map(f64::from)),
                v.inverse(),
                peak,
            )
        })
        .collect();
    let mut random = Random::new(7);
    let mut coordinate = |size: usize| margin + random.unit() * (size as f64 - 1.0 - 2.0 * margin);
    let (mut largest, mut squares, mut linear) = (0.0f64, 0.0, 0.0f64);
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    const PLACES: usize = 400;
    for _ in 0..PLACES {
        let at = place(DVec3::new(
            coordinate(dims[0]),
            coordinate(dims[1]),
            coordinate(dims[2]),
        ));
        let (mut sum, mut field) = (0.0, 0.0);
        for ((p, inverse, peak), value) in ready.iter().zip(&kernels.values) {
            let d = at - *p;
            let weight = peak * (-0.5 * d.dot(*inverse * d)).exp();
            sum += weight;
            field += weight * f64::from(*value);
        }
        let expected = SLOPE.dot(at) + 2.0;
        range = [range[0].min(expected), range[1].max(expected)];
        linear = linear.max((field - expected).abs());
        largest = largest.max((sum - 1.0).abs());
        squares += (sum - 1.0).powi(2);
    }
    Ripple {
        largest,
        mean: (squares / PLACES as f64).sqrt(),
        linear: linear / (range[1] - range[0]),
    }
}

/// Geometric spacing from the index.
fn geometric(t: f64, ratio: f64) -> f64 {
    (ratio.powf(t) - 1.0) / (ratio - 1.0)
}

#[test]
fn a_constant_stays_constant_on_structured_grids() {
    let dims = [14, 13, 12];
    let stretched = |u: DVec3| {
        DVec3::new(
            geometric(u.x, 1.1),
            geometric(u.y, 1.05),
            5.0 * geometric(u.z, 1.15),
        )
    };
    let steep = |u: DVec3| DVec3::new(geometric(u.x, 1.3), u.y, 5.0 * u.z);
    let sheared = |u: DVec3| DVec3::new(u.x + 0.7 * u.y + 0.3 * u.z, u.y - 0.5 * u.z, 3.0 * u.z);
    let curved = |u: DVec3| {
        let (r, angle) = (6.0 + 0.5 * u.x, 0.09 * u.y);
        DVec3::new(
            r * angle.cos(),
            r * angle.sin(),
            0.6 * u.z + 0.4 * (0.3 * u.x).sin(),
        )
    };
    type Place<'a> = &'a dyn Fn(DVec3) -> DVec3;
    let cases: [(&str, Place, f64); 4] = [
        ("stretched", &stretched, 0.01),
        ("ratio 1.3", &steep, 0.03),
        ("sheared", &sheared, 0.001),
        ("curvilinear", &curved, 0.01),
    ];
    for (name, place, limit) in cases {
        for association in [Association::Point, Association::Cell] {
            let mesh = mesh(&block(dims, place), Topology::Structured(vec![dims]), association);
            let Ripple { largest, mean, .. } = ripple(&kernels(&mesh, SIGMA), dims, 3.5, place);
            println!("{name} {association:?}: largest {largest:.5}, rms {mean:.5}");
            assert!(largest < limit, "{name} {association:?}: {largest}");
        }
    }
}

#[test]
fn a_constant_stays_constant_on_unstructured_cells() {
    let dims = [12, 12, 12];
    for (jitter, limit) in [(0.0, 0.005), (0.15, 0.02), (0.25, 0.03)] {
        let points = jittered(dims, jitter);
        for (name, cells) in [("tetra", tetrahedra(dims)), ("hexa", hexahedra(dims))] {
            for association in [Association::Point, Association::Cell] {
                let mesh = mesh(&points, Topology::Unstructured(cells.clone()), association);
                let Ripple { largest, mean, .. } = ripple(&kernels(&mesh, SIGMA), dims, 3.5, |u| u);
                println!("{name} jitter {jitter} {association:?}: largest {largest:.5}, rms {mean:.5}");
                assert!(largest < limit, "{name} {jitter} {association:?}: {largest}");
            }
        }
    }
}
