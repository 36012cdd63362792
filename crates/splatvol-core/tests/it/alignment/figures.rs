//! The figures that mueller1998 gives, and our own.

use glam::{DMat3, DVec3};
use splatvol_core::splats::{CameraView, Footprint, GaussianProfile, Profile, Projection};
use splatvol_scene::{Alignment, Filter, Stretch};

use super::model::{Kernel, SIGMA, cloud, profile, project, raster, ray, view};

/// Largest error of a footprint, share of the peak.
fn largest(view: &CameraView, footprint: &Footprint, kernel: &Kernel) -> f64 {
    let peak = kernel.along(kernel.u);
    raster(footprint, 48)
        .map(|pixel| {
            let found = f64::from(footprint.integral(profile(), None, pixel));
            (found - kernel.along(ray(view, pixel))).abs() / peak
        })
        .fold(0.0, f64::max)
}

/// Error of a sphere 60 degrees off axis.
fn far_off_axis(alignment: Alignment, sigma_per_depth: f64) -> f64 {
    let view = view(1000.0);
    let u = DVec3::new(60f64.to_radians().tan(), 0.0, 1.0) * (SIGMA / sigma_per_depth);
    let cloud = cloud(u, DMat3::IDENTITY);
    let projection = project(&cloud, &view, (Filter::None, alignment, Stretch::Box));
    let kernel = Kernel::of(&projection, &cloud);
    largest(&view, &projection.project(0).expect("in sight"), &kernel)
}

#[test]
fn affine_footprints_err_by_a_hundredth_and_a_tenth() {
    for (sigma_per_depth, low, high) in [(0.001, 0.0009, 0.0011), (0.01, 0.009, 0.011), (0.1, 0.085, 0.115)] {
        let error = far_off_axis(Alignment::Affine, sigma_per_depth);
        println!("affine, sigma/z {sigma_per_depth}: {:.3} %", error * 100.0);
        assert!((low..=high).contains(&error), "{sigma_per_depth}: {error}");
    }
}

#[test]
fn exact_footprints_do_not_err() {
    for sigma_per_depth in [0.0001, 0.001, 0.01, 0.03, 0.1] {
        let error = 256.0 * far_off_axis(Alignment::Exact, sigma_per_depth);
        println!("exact, sigma/z {sigma_per_depth}: {error:.4} levels");
        assert!(error <= 0.25, "{sigma_per_depth}: {error}");
    }
}

/// mueller1998 section 4.2: across rays before `z_s = z_k + 70`, parallel to the picture behind it.
#[test]
fn the_switch_is_across_rays_before_z_s_and_parallel_to_the_picture_behind() {
    let view = view(200.0);
    for (behind, same, other) in [
        (-50.0, Alignment::Ray, Alignment::Grid),
        (69.0, Alignment::Ray, Alignment::Grid),
        (71.0, Alignment::Grid, Alignment::Ray),
        (500.0, Alignment::Grid, Alignment::Ray),
    ] {
        let u = DVec3::new(0.4, 0.2, 1.0) * (200.0 + behind);
        let cloud = cloud(u, DMat3::IDENTITY);
        let of = |alignment| {
            let projection = project(&cloud, &view, (Filter::Swan, alignment, Stretch::Box));
            projection.project(0).expect("in sight")
        };
        assert_eq!(of(Alignment::SWITCH), of(same), "{behind}");
        assert_ne!(of(Alignment::SWITCH), of(other), "{behind}");
    }
}

/// The set-up of figures 9 and 10: 512^3 voxels, a picture of 512^2 pixels, a cone of 30 degrees, exp(-1.38 r^2)
/// cut at 2.
struct Paper {
    focal: f64,
    view: CameraView,
    profile: GaussianProfile,
    sigma: f64,
}

impl Paper {
    fn new() -> Self {
        let focal = 256.0 / 30f64.to_radians().tan();
        let sigma = (0.5 / 1.38f64).sqrt();
        Self {
            focal,
            view: view(focal),
            profile: GaussianProfile::new(2.0 / sigma),
            sigma,
        }
    }

    /// Error of an alignment against the trapezoid, levels of 256, at `y, z`.
    fn levels(&self, alignment: Alignment, [y, z]: [f64; 2]) -> f64 {
        let grid = DMat3::from_diagonal(DVec3::splat(self.sigma / SIGMA));
        let cloud = cloud(DVec3::new(0.0, y, z), grid);
        let projection = |alignment, stretch| {
            Projection::new(&cloud, &self.view, (Filter::Swan, alignment), &self.profile)
                .with_stretch(stretch)
        };
        let truth = projection(Alignment::Exact, Stretch::Trapezoid)
            .project(0)
            .expect("in sight");
        let footprint = projection(alignment, Stretch::Box).project(0).expect("in sight");
        let at = |footprint: &Footprint, pixel| f64::from(footprint.integral(&self.profile, None, pixel));
        let peak = raster(&truth, 61)
            .map(|pixel| at(&truth, pixel))
            .fold(0.0, f64::max);
        let error = raster(&truth, 61).map(|pixel| (at(&footprint, pixel) - at(&truth, pixel)).abs());
        256.0 * error.fold(0.0, f64::max) / peak
    }
}

/// Figure 9 and its text: below 1 level on the axis; far off axis near `z_k`, below 2 for the footprint across the
/// ray and above 25 for that along the grid; below 8 for both far off and far away.
#[test]
fn figure_9() {
    let paper = Paper::new();
    // The paper's voxels are a unit apart; those of `cloud` are so in units of sigma.
    let z_k = paper.focal * paper.sigma / SIGMA;
    let columns = [[0.0, z_k], [256.0, z_k], [256.0, z_k + 400.0]];
    let [grid, across] =
        [Alignment::Grid, Alignment::Ray].map(|alignment| columns.map(|at| paper.levels(alignment, at)));
    println!(
        "grid {grid:.3?}, ray {across:.3?} levels; cut {}",
        paper.profile.cut()
    );
    assert!(grid[0] < 0.5 && across[0] < 0.5, "{grid:?} {across:?}");
    assert!((25.5..28.5).contains(&grid[1]), "{grid:?}");
    assert!(across[1] < 0.5, "{across:?}");
    for far in [grid[2], across[2]] {
        assert!((7.0..8.5).contains(&far), "{grid:?} {across:?}");
    }
}

/// The depth from which the footprint along the grid is no worse than that across the ray: the paper finds
/// `z_k + 70`.
#[test]
fn z_s() {
    let paper = Paper::new();
    let z_k = paper.focal * paper.sigma / SIGMA;
    let mut found = None;
    for step in 0..=52 {
        let behind = 10.0 * f64::from(step);
        let at = [256.0, z_k + behind];
        let [grid, across] = [Alignment::Grid, Alignment::Ray].map(|alignment| paper.levels(alignment, at));
        if step % 5 == 0 {
            println!("z_k + {behind}: grid {grid:.2}, ray {across:.2} levels");
        }
        if grid <= across + 0.05 {
            found.get_or_insert(behind);
        }
        // From there on they are equally bad: both have the height of a ray along the axis.
        assert!(
            found.is_none() || (grid - across).abs() < 0.1,
            "z_k + {behind}: {grid} {across}"
        );
    }
    println!("z_s = z_k + {found:?}");
    assert!(
        found.is_some_and(|behind| (300.0..450.0).contains(&behind)),
        "{found:?}"
    );
}
