//! Against surfaces whose spacing and normals are known, and the bunny, whose triangles know theirs.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use splatvol_testing::Random;

use super::*;

fn stored(points: &[DVec3]) -> Vec<[f32; 3]> {
    points.iter().map(|p| p.as_vec3().to_array()).collect()
}

fn sphere(count: usize, seed: u64) -> Vec<DVec3> {
    let mut random = Random::new(seed);
    (0..count).map(|_| random.direction()).collect()
}

/// Angles in degrees between what was estimated and what is true; above 90 where a normal points the wrong way.
fn angles(normals: &[[f32; 3]], truth: &[DVec3]) -> Vec<f64> {
    normals
        .iter()
        .zip(truth)
        .map(|(n, t)| {
            DVec3::from_array(n.map(f64::from))
                .dot(*t)
                .clamp(-1.0, 1.0)
                .acos()
                .to_degrees()
        })
        .collect()
}

fn worst(angles: &[f64]) -> f64 {
    angles.iter().copied().fold(0.0, f64::max)
}

#[test]
fn normals_of_a_sphere_point_out_of_it() {
    let truth = sphere(20_000, 1);
    let normals = estimate_normals(&stored(&truth), 12);
    let angles = angles(&normals, &truth);
    let mean = angles.iter().sum::<f64>() / angles.len() as f64;
    println!("sphere: mean {mean:.3}, largest {:.3} degrees", worst(&angles));
    // Neighbours reach .03 from the point, where the sphere has turned by 1.7 degrees; an uneven dozen tilts by no more.
    assert!(mean < 0.6, "{mean}");
    assert!(worst(&angles) < 4.0, "{}", worst(&angles));
}

#[test]
fn radii_of_a_sphere_follow_its_density() {
    for count in [2_000, 20_000] {
        let radii = estimate_radii(&stored(&sphere(count, 2)), 8);
        let spacing = (4.0 * PI / count as f64).sqrt();
        let mut relative: Vec<f64> = radii.iter().map(|r| f64::from(*r) / spacing).collect();
        relative.sort_by(f64::total_cmp);
        let median = relative[count / 2];
        // Neighbours of a random point are a Poisson process of the sphere's density: estimates scatter by 1 / sqrt(8).
        assert!((median - 1.0).abs() < 0.08, "{count}: {median}");
        assert!(relative[0] > 0.3 && relative[count - 1] < 2.5, "{relative:?}");
    }
}

#[test]
fn a_flat_grid_has_its_spacing_and_one_normal() {
    let side = 40;
    let plane: Vec<DVec3> = (0..side * side)
        .map(|i| DVec3::new(f64::from(i % side), f64::from(i / side), 5.0) * 0.25)
        .collect();
    let radii = estimate_radii(&stored(&plane), 8);
    for (radius, p) in radii.iter().zip(&plane) {
        let inside = [p.x, p.y].iter().all(|c| (0.25..=9.5).contains(c));
        // Five of the neighbours are at 1 and sqrt 2 spacings: a density of 8 / (2 pi) where 1 would be right. At the
        // border half of them, in a corner three quarters, are missing.
        let relative = f64::from(*radius) / 0.25;
        let range = if inside { 0.9..1.2 } else { 0.9..2.3 };
        assert!(range.contains(&relative), "{p}: {relative}");
    }
    let up = vec![DVec3::Z; plane.len()];
    assert!(worst(&angles(&estimate_normals(&stored(&plane), 8), &up)) < 1e-3);
    let below = Orientation::Towards(DVec3::new(3.0, 3.0, -9.0));
    let down = Neighborhoods::new(&stored(&plane), 8).normals(below);
    assert!(worst(&angles(&down, &vec![-DVec3::Z; plane.len()])) < 1e-3);
}

#[test]
fn sides_spread_around_a_torus_and_over_thin_sheets() {
    let mut random = Random::new(3);
    let torus: Vec<(DVec3, DVec3)> = (0..30_000)
        .map(|_| {
            let (u, v) = (random.range(0.0, TAU), random.range(0.0, TAU));
            let ring = DVec3::new(u.cos(), u.sin(), 0.0);
            let normal = ring * v.cos() + DVec3::Z * v.sin();
            (ring + 0.3 * normal, normal)
        })
        .collect();
    let (points, truth): (Vec<_>, Vec<_>) = torus.into_iter().unzip();
    let angles_of_torus = angles(&estimate_normals(&stored(&points), 12), &truth);
    assert!(worst(&angles_of_torus) < 25.0, "{}", worst(&angles_of_torus));

    // Two sides of a lens, four spacings thick in its middle and sharp at its rim.
    let lens: Vec<(DVec3, DVec3)> = (0..30_000)
        .map(|i| {
            let (r, a) = (random.unit().sqrt(), random.range(0.0, TAU));
            let side = if i % 2 == 0 { 1.0 } else { -1.0 };
            let (x, y) = (r * a.cos(), r * a.sin());
            let normal = DVec3::new(0.06 * x, 0.06 * y, side).normalize();
            (DVec3::new(x, y, side * 0.03 * (1.0 - r * r)), normal)
        })
        .collect();
    let (points, truth): (Vec<_>, Vec<_>) = lens.into_iter().unzip();
    let normals = estimate_normals(&stored(&points), 12);
    let wrong = angles(&normals, &truth)
        .iter()
        .zip(&points)
        .filter(|(angle, p)| p.truncate().length() < 0.6 && **angle > 90.0)
        .count();
    assert_eq!(wrong, 0);
}

#[test]
fn parts_that_do_not_touch_are_turned_one_by_one() {
    let far = DVec3::new(7.0, -3.0, 1.0);
    let (one, two) = (sphere(3000, 4), sphere(3000, 5));
    let points: Vec<DVec3> = one.iter().copied().chain(two.iter().map(|p| *p + far)).collect();
    let truth = [one, two].concat();
    assert!(worst(&angles(&estimate_normals(&stored(&points), 10), &truth)) < 15.0);
}

#[test]
fn duplicates_change_nothing() {
    let points = stored(&sphere(2000, 6));
    let twice: Vec<[f32; 3]> = points.iter().flat_map(|p| [*p; 20]).collect();
    let every = |values: Vec<f32>| values.into_iter().step_by(20).collect::<Vec<_>>();
    assert_eq!(estimate_radii(&points, 8), every(estimate_radii(&twice, 8)));
    let normals = estimate_normals(&twice, 8);
    assert_eq!(
        estimate_normals(&points, 8),
        normals.iter().copied().step_by(20).collect::<Vec<_>>()
    );
    assert!(normals.chunks(20).all(|same| same.iter().all(|n| *n == same[0])));
}

#[test]
fn what_says_nothing_gives_radius_one_and_no_normal() {
    for points in [vec![], vec![[3.0, 4.0, 5.0]; 100], vec![[f32::NAN; 3]; 3]] {
        assert!(estimate_radii(&points, 8).iter().all(|r| *r == 1.0));
        assert!(estimate_normals(&points, 8).iter().all(|n| *n == [0.0; 3]));
    }
    let line: Vec<[f32; 3]> = (0..100).map(|i| [i as f32, 2.0 * i as f32, 0.0]).collect();
    assert!(estimate_normals(&line, 8).iter().all(|n| *n == [0.0; 3]));
    assert!(estimate_radii(&line, 8).iter().all(|r| *r > 2.0 && *r < 11.0));
    let two = [[0.0; 3], [1.0, 0.0, 0.0]];
    assert!(estimate_radii(&two, 8).iter().all(|r| r.is_finite() && *r > 0.0));
    assert_eq!(estimate_normals(&two, 0), vec![[0.0; 3]; 2]);
}

#[test]
fn the_unit_of_length_does_not_matter() {
    let points = sphere(2000, 7);
    let normals = estimate_normals(&stored(&points), 8);
    let radii = estimate_radii(&stored(&points), 8);
    for unit in [1e-30, 1e30] {
        let scaled = stored(&points.iter().map(|p| *p * unit).collect::<Vec<_>>());
        let truth: Vec<DVec3> = normals
            .iter()
            .map(|n| DVec3::from_array(n.map(f64::from)))
            .collect();
        assert!(worst(&angles(&estimate_normals(&scaled, 8), &truth)) < 0.1);
        for (a, b) in radii.iter().zip(estimate_radii(&scaled, 8)) {
            assert!((f64::from(b) / unit / f64::from(*a) - 1.0).abs() < 1e-5);
        }
    }
}

#[test]
fn a_stray_point_stays_small() {
    let mut points = stored(&sphere(5000, 8));
    points.push([40.0, 0.0, 0.0]);
    let radii = estimate_radii(&points, 8);
    let largest = radii[..5000].iter().copied().fold(0.0, f32::max);
    assert!(radii[5000] <= 2.0 * largest, "{} {largest}", radii[5000]);
}

#[test]
fn threads_do_not_matter() {
    let points = stored(&sphere(5000, 9));
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| (estimate_radii(&points, 8), estimate_normals(&points, 8)))
    };
    assert_eq!(with(1), with(3));
}

/// Vertices and the sums of their triangles' normals, which point inward in this file: its volume comes out negative.
fn bunny() -> Option<(Vec<[f32; 3]>, Vec<DVec3>)> {
    let path = splatvol_recorded::recorded("points")?.join("bunny.ply");
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines().skip_while(|line| *line != "end_header").skip(1);
    let numbers = |line: &str| -> Vec<f64> { line.split_whitespace().map(|w| w.parse().unwrap()).collect() };
    let vertices: Vec<DVec3> = lines
        .by_ref()
        .take(35_947)
        .map(numbers)
        .map(|v| DVec3::new(v[0], v[1], v[2]))
        .collect();
    let (mut normals, mut volume) = (vec![DVec3::ZERO; vertices.len()], 0.0);
    for face in lines.map(numbers).filter(|face| face.len() == 4) {
        let [a, b, c] = [1, 2, 3].map(|i| face[i] as usize);
        let normal = (vertices[b] - vertices[a]).cross(vertices[c] - vertices[a]);
        volume += normal.dot(vertices[a]);
        for corner in [a, b, c] {
            normals[corner] += normal;
        }
    }
    Some((
        stored(&vertices),
        normals
            .into_iter()
            .map(|n| n.normalize_or_zero() * f64::signum(volume))
            .collect(),
    ))
}

#[test]
fn the_bunnys_normals_point_out_of_it() {
    let Some((vertices, truth)) = bunny() else { return };
    let angles = angles(&estimate_normals(&vertices, 12), &truth);
    let with_triangles: Vec<f64> = angles
        .into_iter()
        .zip(&truth)
        .filter(|(_, t)| **t != DVec3::ZERO)
        .map(|(a, _)| a)
        .collect();
    let inward = with_triangles.iter().filter(|a| **a > 90.0).count();
    let mean = with_triangles.iter().sum::<f64>() / with_triangles.len() as f64;
    println!(
        "bunny: {inward} of {} point inward, mean {mean:.2} degrees",
        with_triangles.len()
    );
    assert_eq!(inward, 0);
    assert!(mean < 4.0, "{mean}");
}

/// A ring of scattered heights around a hole, as of tree tops in a sparse scan.
fn landscape(height: f32) -> Vec<[f32; 3]> {
    (0..900u32)
        .map(|i| {
            let hash = i.wrapping_mul(2_654_435_761) >> 8;
            [
                (i % 30) as f32,
                (i / 30) as f32,
                height * (hash % 1000) as f32 / 1000.0,
            ]
        })
        .collect()
}

#[test]
fn a_landscape_is_seen_from_above_and_a_block_from_outside() {
    let flat = landscape(4.0);
    let side = Orientation::of(&flat, DVec3::Z);
    assert_eq!(side, Orientation::Along(DVec3::Z));
    let normals = Neighborhoods::new(&flat, 8).normals(side);
    assert!(normals.iter().all(|normal| normal[2] >= 0.0));
    assert_eq!(Orientation::of(&landscape(20.0), DVec3::Z), Orientation::Outward);
    // The same, lying on its side.
    assert_eq!(Orientation::of(&flat, DVec3::Y), Orientation::Outward);
    assert_eq!(Orientation::of(&[[1.0; 3]], DVec3::Z), Orientation::Outward);
    assert_eq!(Orientation::of(&[], DVec3::Z), Orientation::Outward);
}
