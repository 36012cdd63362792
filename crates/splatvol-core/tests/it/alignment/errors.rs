//! Estimates of errors bound errors, and `auto` keeps to its budget.

use glam::DVec3;
use splatvol_core::splats::{CameraView, Footprint, KernelShape, SplatCloud, Warp};
use splatvol_scene::{Alignment, Filter, Stretch};

use super::model::{Random, SIGMA, cloud, profile, project, raster, view};

const FILTERS: [Filter; 4] = [
    Filter::None,
    Filter::Ewa { pixel_sigma: 0.55 },
    Filter::Matched { pixel_sigma: 0.55 },
    Filter::Swan,
];

/// A random splat, sphere or ellipsoid or flattened along a gradient, up to 60 degrees off axis.
fn splat(random: &mut Random, case: u32) -> SplatCloud {
    let grid = if case.is_multiple_of(3) {
        random.ellipsoid(1.0)
    } else {
        random.ellipsoid(4.0)
    };
    let degrees = random.within(0.0, 60.0);
    let u = random.along(degrees) * (SIGMA / random.magnitude(1e-4, 0.1));
    let mut cloud = cloud(u, grid);
    if case % 4 == 3 {
        cloud.shape = KernelShape::Flattened {
            sigma: SIGMA,
            flatness: 4.0,
            threshold: 0.0,
        };
        cloud.gradients = vec![[0; 3].map(|_| random.within(-1.0, 1.0) as f32)];
    }
    cloud
}

/// Largest difference between two footprints, share of the first one's peak.
fn difference(truth: &Footprint, other: &Footprint) -> f64 {
    let at = |footprint: &Footprint, pixel| f64::from(footprint.integral(profile(), None, pixel));
    let peak = at(truth, truth.centre);
    [truth, other]
        .into_iter()
        .flat_map(|over| raster(over, 40).chain([over.centre]))
        .map(|pixel| (at(truth, pixel) - at(other, pixel)).abs() / peak)
        .fold(0.0, f64::max)
}

/// Error from rounding an affine footprint's centre to 32 bits, which matters where footprints are much smaller
/// than pixels.
fn rounding(footprint: &Footprint) -> f64 {
    let [x0, y0, x1, y1] = footprint.bounds.map(f64::from);
    let ulp = f64::from(x1.abs().max(y1.abs()) as f32 * f32::EPSILON);
    2e-5 + ulp * 10.0 / (x1 - x0).min(y1 - y0)
}

/// The error of an alignment, beyond rounding.
fn measured(cloud: &SplatCloud, view: &CameraView, filter: Filter, alignment: Alignment) -> f64 {
    let of = |alignment| {
        project(cloud, view, (filter, alignment, Stretch::Box))
            .project(0)
            .expect("in sight")
    };
    let exact = of(Alignment::Exact);
    difference(&exact, &of(alignment)) - rounding(&exact)
}

#[test]
fn estimates_bound_what_footprints_err_by() {
    let mut random = Random(23);
    let (mut looseness, mut count) = ([0.0; 3], 0);
    for case in 0..240 {
        let view = view(random.magnitude(20.0, 1000.0).round());
        let cloud = splat(&mut random, case);
        for filter in FILTERS {
            let projection = project(&cloud, &view, (filter, Alignment::Exact, Stretch::Box));
            let Some(errors) = projection.errors(0) else {
                continue;
            };
            // Swan's filter on screen differs from that in space, whose affine footprint `auto` uses.
            let affine = (filter != Filter::Swan && filter != Filter::Matched { pixel_sigma: 0.55 })
                .then_some((0, Alignment::Affine, errors.affine));
            let others = [(1, Alignment::Ray, errors.ray), (2, Alignment::Grid, errors.grid)];
            for (index, alignment, estimate) in affine.into_iter().chain(others) {
                if index == 2 && filter == (Filter::Matched { pixel_sigma: 0.55 }) {
                    continue;
                }
                // Two footprints differ by 1e-4 from rounding alone. Estimates serve to choose good footprints:
                // those that err by more are bad anyway.
                let found = measured(&cloud, &view, filter, alignment);
                assert!(
                    found <= estimate + 2e-4 || (estimate > 0.2 && found > 0.2),
                    "{case} {filter:?} {alignment:?}: {found} {estimate}"
                );
                if estimate < 0.2 && found > 1e-3 {
                    looseness[index] += (estimate / found).ln();
                    count += usize::from(index == 0);
                }
            }
        }
    }
    let mean = (looseness[0] / count as f64).exp();
    println!("affine: estimates are {mean:.2} times the errors on average, of {count}");
    assert!(mean < 2.0, "{mean}");
}

#[test]
fn auto_keeps_to_its_budget_and_uses_it() {
    let mut random = Random(29);
    let mut shares = Vec::new();
    for budget in [0.1 / 256.0, 1.0 / 256.0, 8.0 / 256.0] {
        let (mut affine, mut worst) = (0, 0.0f64);
        for case in 0..400 {
            let view = view(random.magnitude(20.0, 1000.0).round());
            let cloud = splat(&mut random, case);
            let filter = FILTERS[case as usize % FILTERS.len()];
            let way = (filter, Alignment::Auto { budget }, Stretch::Box);
            let footprint = project(&cloud, &view, way).project(0).expect("in sight");
            affine += u32::from(matches!(footprint.warp, Warp::Affine { .. }));
            worst = worst.max(measured(&cloud, &view, filter, Alignment::Auto { budget }));
        }
        println!("budget {budget:.5}: error {worst:.5}, affine {affine} of 400");
        assert!(worst <= budget + 2e-5, "{budget}: {worst}");
        shares.push(affine);
    }
    assert!(
        shares[0] > 0 && shares[0] < shares[1] && shares[1] < shares[2] && shares[2] < 400,
        "{shares:?}"
    );
}

#[test]
fn what_reaches_before_the_near_plane_is_not_affine() {
    let mut view = view(100.0);
    view.near = 1.0;
    let cloud = cloud(DVec3::new(0.3, 0.1, 2.0), glam::DMat3::IDENTITY);
    let way = (Filter::None, Alignment::Auto { budget: 1.0 }, Stretch::Box);
    let projection = project(&cloud, &view, way);
    assert!(projection.errors(0).is_none());
    let footprint = projection.project(0).expect("in sight");
    assert!(matches!(footprint.warp, Warp::Ray(_)));
    assert_eq!(footprint.clip, 1.0);
}
