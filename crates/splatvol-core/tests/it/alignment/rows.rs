//! Table 1 of mueller1998, corrected: row 3 has `y_v`, `z_v` where `x_v`, `y_v` are printed outside of dy, and no
//! squares in the sums; row 4 has `z_v z_k + y_p y_v` in its denominator and `y_v^2 + z_v^2` under its root;
//! integrals are taken in arc length. Rows are written for the plane of the axis and the splat, with the direction
//! across it added.

use glam::{DMat3, DVec2, DVec3};
use splatvol_core::splats::CameraView;
use splatvol_scene::{Alignment, Filter, Stretch};

use super::model::{Kernel, Random, SIGMA, Way, cloud, line, pixel, profile, project, ray, through, view};

/// A quarter of a level of eight bits.
const QUARTER: f64 = 0.25 / 256.0;

/// A splat of a cubic grid in the paper's coordinates: y radial, x across.
struct Splat {
    kernel: Kernel,
    /// The plane of the axis and the splat.
    radial: DVec2,
    y_v: f64,
    z_v: f64,
    z_k: f64,
}

impl Splat {
    /// `h(x, y, z)`.
    fn h(&self, x: f64, y: f64, z: f64) -> f64 {
        let variance = self.kernel.covariance.x_axis.x;
        self.kernel.height() * (-0.5 * (x * x + y * y + z * z) / variance).exp()
    }

    /// x, y, z of a point.
    fn paper(&self, point: DVec3) -> (f64, f64, f64) {
        let across = DVec2::new(-self.radial.y, self.radial.x);
        let plane = point.truncate();
        (plane.dot(across), plane.dot(self.radial), point.z)
    }

    fn integral(&self, d: DVec3, density: impl Fn(f64, f64, f64) -> f64) -> f64 {
        let wide = self.kernel.widest() * (self.z_v / self.z_k).max(1.0) * 1.5;
        line(d, self.kernel.u, wide, |point| {
            let (x, y, z) = self.paper(point);
            density(x, y, z)
        })
    }

    fn row_1(&self, d: DVec3) -> f64 {
        self.integral(d, |x, y, z| {
            let s = (self.z_k / z).min(1.0);
            s * s * self.h(s * x, s * (y - self.y_v), z - self.z_v)
        })
    }

    fn row_2(&self, d: DVec3) -> f64 {
        let s = (self.z_k / self.z_v).min(1.0);
        self.integral(d, |x, y, z| {
            s * s * self.h(s * x, s * (y - self.y_v), z - self.z_v)
        })
    }

    fn row_3(&self, d: DVec3) -> f64 {
        let s = (self.z_k / self.z_v).min(1.0);
        let far = self.y_v.hypot(self.z_v);
        self.integral(d, |x, y, z| {
            let (dy, dz) = (y - self.y_v, z - self.z_v);
            let across = (-dz * self.y_v + dy * self.z_v) / far;
            let along = (dz * self.z_v + dy * self.y_v) / far;
            s * s * self.h(s * x, s * across, along)
        })
    }

    /// Parallel traversal: the footprint's integrals run along its normal.
    fn parallel(&self, x: f64, y: f64) -> f64 {
        let s = (self.z_k / self.z_v).min(1.0);
        let unit = DVec3::Z;
        through(DVec3::ZERO, unit, self.kernel.widest(), |point| {
            s * s * self.h(s * x, s * y, point.z)
        })
    }

    fn row_4(&self, d: DVec3) -> f64 {
        // The ray's coordinates on the plane `z = z_k`, as in the paper.
        let (x_p, y_p, z_k) = self.paper(d * self.z_k);
        let below = self.z_v * z_k + y_p * self.y_v;
        let y = (self.z_v * y_p - self.y_v * z_k) / below * self.y_v.hypot(self.z_v);
        // In the other direction the disc is met at the same parameter of the ray.
        let x = x_p * (self.y_v * self.y_v + self.z_v * self.z_v) / below;
        self.parallel(x, y)
    }

    fn row_5(&self, d: DVec3) -> f64 {
        let (x_p, y_p, z_k) = self.paper(d * self.z_k);
        self.parallel(x_p * self.z_v / z_k, y_p * self.z_v / z_k - self.y_v)
    }
}

type Row = fn(&Splat, DVec3) -> f64;

const WAYS: [(Alignment, Stretch, Row); 5] = [
    (Alignment::Exact, Stretch::Trapezoid, Splat::row_1),
    (Alignment::Exact, Stretch::Box, Splat::row_2),
    (Alignment::RayIdeal, Stretch::Box, Splat::row_3),
    (Alignment::Ray, Stretch::Box, Splat::row_4),
    (Alignment::Grid, Stretch::Box, Splat::row_5),
];

/// Largest difference from a row, share of the peak, of a splat at this direction and depth.
fn row_error(
    random: &mut Random,
    view: &CameraView,
    d: DVec3,
    z: f64,
    way: Way,
    row: fn(&Splat, DVec3) -> f64,
) -> f64 {
    let cloud = cloud(d * z, DMat3::IDENTITY);
    let projection = project(&cloud, view, way);
    let footprint = projection.project(0).expect("in sight");
    let kernel = Kernel::of(&projection, &cloud);
    let y_v = kernel.u.truncate().length();
    let splat = Splat {
        kernel,
        radial: if y_v > 0.0 {
            kernel.u.truncate() / y_v
        } else {
            DVec2::Y
        },
        y_v,
        z_v: kernel.u.z,
        // Where pixels are as far apart as voxels; without the filter, nothing is stretched.
        z_k: if way.0 == Filter::Swan {
            view.screen.scale
        } else {
            1e9
        },
    };
    let peak = row(&splat, kernel.u / kernel.u.z);
    (0..24)
        .map(|_| {
            let pixel = pixel(random, &footprint);
            let found = f64::from(footprint.integral(profile(), None, pixel));
            (found - row(&splat, ray(view, pixel))).abs() / peak
        })
        .fold(0.0, f64::max)
}

#[test]
fn footprints_are_the_rows_of_table_1() {
    for (alignment, stretch, row) in WAYS {
        for filter in [Filter::None, Filter::Swan] {
            if filter == Filter::None && stretch == Stretch::Trapezoid {
                continue;
            }
            let mut random = Random(7);
            let mut worst = 0.0f64;
            for _ in 0..60 {
                let focal = random.magnitude(6.0, 600.0).round();
                let view = view(focal);
                // From before the distance k to far behind it, with a standard deviation of at most a tenth of the
                // distance.
                let z = random.magnitude(0.5, 5.0) * focal.max(2.0 * SIGMA / 0.1);
                let d = {
                    let degrees = random.within(0.0, 60.0);
                    random.along(degrees)
                };
                worst = worst.max(row_error(
                    &mut random,
                    &view,
                    d,
                    z,
                    (filter, alignment, stretch),
                    row,
                ));
            }
            println!(
                "{alignment:?} {stretch:?} {filter:?}: {:.4} levels",
                worst * 256.0
            );
            assert!(worst <= QUARTER, "{alignment:?} {stretch:?} {filter:?}: {worst}");
        }
    }
}

/// Any ellipsoid, from near to so far away that 32 bits would not tell rays apart, filtered and not.
#[test]
fn exact_footprints_are_line_integrals() {
    let mut random = Random(11);
    let mut worst = 0.0f64;
    for case in 0..300u32 {
        let view = view(1000.0);
        let z = SIGMA / random.magnitude(1e-5, 0.1);
        let degrees = if case.is_multiple_of(3) {
            60.0
        } else {
            random.within(0.0, 60.0)
        };
        let cloud = cloud(random.along(degrees) * z, random.ellipsoid(4.0));
        let pixel_sigma = 0.5;
        for filter in [Filter::None, Filter::Ewa { pixel_sigma }] {
            for alignment in [Alignment::Exact, Alignment::RayIdeal] {
                let projection = project(&cloud, &view, (filter, alignment, Stretch::Box));
                let footprint = projection.project(0).expect("in sight");
                let mut kernel = Kernel::of(&projection, &cloud);
                let added = (filter.pixel_sigma() * kernel.u.z / view.screen.scale).powi(2);
                kernel.covariance += DMat3::from_diagonal(DVec3::new(added, added, 0.0));
                let peak = kernel.along(kernel.u);
                for _ in 0..8 {
                    let pixel = pixel(&mut random, &footprint);
                    let found = f64::from(footprint.integral(profile(), None, pixel));
                    let error = (found - kernel.along(ray(&view, pixel))).abs() / peak;
                    worst = worst.max(error);
                }
            }
        }
    }
    println!("exact: {:.4} levels", worst * 256.0);
    assert!(worst <= QUARTER, "{} levels", worst * 256.0);
}

/// A grid that is not cubic is first warped to a cubic one: the disc lies across the ray there.
#[test]
fn discs_of_ellipsoids_lie_across_the_ray_in_the_cubic_grid() {
    let mut random = Random(13);
    let view = view(1000.0);
    let mut worst = 0.0f64;
    for _ in 0..200 {
        let grid = random.ellipsoid(4.0);
        let degrees = random.within(0.0, 60.0);
        let u = random.along(degrees) * (SIGMA / random.magnitude(1e-3, 0.1));
        let cloud = cloud(u, grid);
        let projection = project(&cloud, &view, (Filter::None, Alignment::Ray, Stretch::Box));
        let footprint = projection.project(0).expect("in sight");
        let kernel = Kernel::of(&projection, &cloud);
        let local = grid.inverse();
        let centre = local * kernel.u;
        let peak = kernel.along(kernel.u);
        for _ in 0..8 {
            let pixel = pixel(&mut random, &footprint);
            let d = local * ray(&view, pixel);
            // The point of the ray on the plane through the centre, and what lies along the central ray from there on.
            let point = d * (centre.length_squared() / d.dot(centre));
            let expected = through(grid * point, kernel.u.normalize(), kernel.widest(), |point| {
                kernel.density(point - kernel.u)
            });
            let found = f64::from(footprint.integral(profile(), None, pixel));
            worst = worst.max((found - expected).abs() / peak);
        }
    }
    println!("ray, ellipsoids: {:.4} levels", worst * 256.0);
    assert!(worst <= QUARTER, "{} levels", worst * 256.0);
}

/// Sections of exact and trapezoid footprints add up to the whole, and each is the integral between its depths.
#[test]
fn sections_are_integrals_between_depths() {
    let mut random = Random(17);
    for stretch in [Stretch::Box, Stretch::Trapezoid] {
        let focal = 12.0;
        let view = view(focal);
        let z = 1.5 * focal;
        let cloud = cloud(random.along(40.0) * z, DMat3::IDENTITY);
        let projection = project(&cloud, &view, (Filter::Swan, Alignment::Exact, stretch));
        let footprint = projection.project(0).expect("in sight");
        let kernel = Kernel::of(&projection, &cloud);
        let depths = [z - 9.0, z - 0.9, z - 0.2, z + 0.5, z + 1.4, z + 9.0];
        for _ in 0..40 {
            let pixel = pixel(&mut random, &footprint);
            let d = ray(&view, pixel);
            let whole = f64::from(footprint.integral(profile(), None, pixel));
            let mut sum = 0.0;
            for pair in depths.windows(2) {
                let section = [pair[0] as f32, pair[1] as f32];
                let found = f64::from(footprint.integral(profile(), Some(section), pixel));
                let expected = between(&kernel, d, focal, stretch, [pair[0], pair[1]]);
                assert!(
                    (found - expected).abs() <= QUARTER * kernel.height(),
                    "{stretch:?} {pair:?}: {found} {expected}"
                );
                sum += found;
            }
            assert!(
                (sum - whole).abs() < QUARTER * kernel.height(),
                "{stretch:?}: {sum} {whole}"
            );
        }
    }
}

/// The integral of a stretched kernel along a ray between two depths.
fn between(kernel: &Kernel, d: DVec3, z_k: f64, stretch: Stretch, [near, far]: [f64; 2]) -> f64 {
    let steps = 2000;
    let step = (far - near) / f64::from(steps);
    (0..steps)
        .map(|i| {
            let z = near + (f64::from(i) + 0.5) * step;
            let offset = d * z - kernel.u;
            let at = if stretch == Stretch::Box { kernel.u.z } else { z };
            let s = (z_k / at).min(1.0);
            s * s * kernel.density(DVec3::new(s * offset.x, s * offset.y, offset.z)) * d.length() * step
        })
        .sum()
}
