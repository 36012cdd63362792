//! Footprints lie within their chunk's bounds, and do not explode beside the eye.

use glam::{DMat3, DVec3};
use splatvol_core::splats::{CameraView, Chunk, Footprint, KernelShape, Projection, SplatCloud};
use splatvol_scene::{Alignment, Filter, Stretch};

use super::model::{Kernel, Random, SIGMA, cloud, profile, project, ray, view};

const FILTERS: [Filter; 5] = [
    Filter::None,
    Filter::Ewa { pixel_sigma: 0.55 },
    Filter::Matched { pixel_sigma: 1.5 },
    Filter::Swan,
    Filter::SwanAlpha,
];

const ALIGNMENTS: [(Alignment, Stretch); 8] = [
    (Alignment::Sheet, Stretch::Box),
    (Alignment::Affine, Stretch::Box),
    (Alignment::Grid, Stretch::Box),
    (Alignment::Ray, Stretch::Box),
    (Alignment::RayIdeal, Stretch::Box),
    (Alignment::Exact, Stretch::Box),
    (Alignment::Exact, Stretch::Trapezoid),
    (Alignment::Auto { budget: 0.02 }, Stretch::Box),
];

/// A chunk of splats near the eye plane, some of them behind it.
fn chunk(random: &mut Random, case: u32) -> SplatCloud {
    let grid = random.ellipsoid(3.0);
    let spread = random.within(0.5, 6.0);
    let degrees = random.within(0.0, 70.0);
    let middle = random.along(degrees) * random.magnitude(0.3, 40.0);
    let mut cloud = cloud(middle, grid);
    let start = DVec3::from_array(cloud.positions[0].map(f64::from));
    cloud.positions = (0..60)
        .map(|_| {
            let offset = DVec3::from_array([0; 3].map(|_| random.within(-spread, spread)));
            (start + offset).as_vec3().to_array()
        })
        .collect();
    cloud.payloads = vec![[1.0; 4]; 60];
    cloud.chunks = Chunk::of(&cloud.positions, 0, SIGMA as f32).into_iter().collect();
    if case % 3 == 2 {
        cloud.shape = KernelShape::Flattened {
            sigma: SIGMA,
            flatness: f64::INFINITY,
            threshold: 0.0,
        };
        cloud.gradients = (0..60)
            .map(|_| [0; 3].map(|_| random.within(-1.0, 1.0) as f32))
            .collect();
    }
    cloud
}

/// The part of a footprint's box in the picture; `None` where it has none.
fn visible(view: &CameraView, [x0, y0, x1, y1]: [f32; 4]) -> Option<[f32; 4]> {
    let (width, height) = (view.size.width() as f32, view.size.height() as f32);
    let seen = [x0.max(0.0), y0.max(0.0), x1.min(width), y1.min(height)];
    (seen[0] < seen[2] && seen[1] < seen[3]).then_some(seen)
}

fn check(projection: &Projection<'_>, view: &CameraView, footprint: &Footprint) -> Result<bool, String> {
    let finite = footprint.weight.is_finite() && footprint.bounds.iter().all(|b| !b.is_nan());
    if !finite {
        return Err(format!("{footprint:?}"));
    }
    let Some(seen) = visible(view, footprint.bounds) else {
        return Ok(false);
    };
    let bounds = projection
        .bounds(&projection_chunk(projection))
        .ok_or("no bounds")?;
    let [x0, y0, x1, y1] = bounds.rect;
    let inside = seen[0] >= x0 && seen[1] >= y0 && seen[2] <= x1 && seen[3] <= y1;
    let deep = footprint.depth >= bounds.depth[0] && footprint.depth <= bounds.depth[1];
    if inside && deep {
        Ok(true)
    } else {
        Err(format!("{:?} {seen:?} {footprint:?}", bounds.rect))
    }
}

fn projection_chunk(projection: &Projection<'_>) -> Chunk {
    projection.chunks()[0]
}

#[test]
fn chunks_bound_their_footprints() {
    let mut random = Random(31);
    let mut seen = [0; ALIGNMENTS.len()];
    for case in 0..150 {
        let cloud = chunk(&mut random, case);
        let mut view = view(random.magnitude(4.0, 300.0).round());
        view.near = 0.25;
        for filter in FILTERS {
            for (index, (alignment, stretch)) in ALIGNMENTS.into_iter().enumerate() {
                for perspective in [true, false] {
                    view.screen.perspective = perspective;
                    let projection = project(&cloud, &view, (filter, alignment, stretch));
                    for splat in 0..cloud.len() {
                        let Some(footprint) = projection.project(splat) else {
                            continue;
                        };
                        match check(&projection, &view, &footprint) {
                            Ok(visible) => seen[index] += u32::from(visible),
                            Err(why) => panic!("{case} {filter:?} {alignment:?} {perspective}: {why}"),
                        }
                    }
                }
            }
        }
    }
    println!("{seen:?} footprints");
    assert!(seen.iter().all(|&count| count > 10_000), "{seen:?}");
}

/// A kernel that reaches before the near plane leaves the integral from there on, wherever its centre lies.
#[test]
fn kernels_beside_the_eye_are_cut_at_the_near_plane() {
    let mut view = view(60.0);
    view.near = 0.5;
    let mut random = Random(37);
    for z in [-1.2, -0.3, 0.0, 0.2, 0.5, 0.8, 1.6] {
        let u = DVec3::new(random.within(-1.0, 1.0), random.within(-1.0, 1.0), z);
        let cloud = cloud(u, DMat3::IDENTITY);
        let projection = project(&cloud, &view, (Filter::None, Alignment::Exact, Stretch::Box));
        let footprint = projection.project(0).unwrap();
        let kernel = Kernel::of(&projection, &cloud);
        for i in 0..400 {
            let pixel = [(i % 20) as f32 * 12.0 + 3.0, (i / 20) as f32 * 12.0 + 3.0];
            let d = ray(&view, pixel);
            let found = f64::from(footprint.integral(profile(), None, pixel));
            let steps = 1000;
            let step = 8.0 / f64::from(steps);
            let expected: f64 = (0..steps)
                .map(|i| {
                    let depth = view.near + (f64::from(i) + 0.5) * step;
                    kernel.density(d * depth - kernel.u) * d.length() * step
                })
                .sum();
            let [x0, y0, x1, y1] = footprint.bounds;
            let inside = pixel[0] >= x0 && pixel[0] <= x1 && pixel[1] >= y0 && pixel[1] <= y1;
            let peak = (2.0 * std::f64::consts::PI).sqrt() * SIGMA * kernel.height();
            if inside {
                assert!(
                    (found - expected).abs() <= 0.25 / 256.0 * peak,
                    "{z}: {found} {expected}"
                );
            } else {
                assert!(expected <= 1e-4 * peak, "{z} {pixel:?}: {expected}");
            }
        }
    }
}
