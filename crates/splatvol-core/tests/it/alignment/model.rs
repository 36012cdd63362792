//! Kernels, rays and line integrals in 64 bits, and one splat to compare with them.

use std::sync::LazyLock;

use glam::{DAffine3, DMat3, DVec2, DVec3};
use splatvol_core::splats::{
    CameraView, Chunk, Footprint, GaussianProfile, KernelShape, Projection, SplatCloud,
};
use splatvol_scene::{Alignment, Filter, ImageSize, ScreenFromCamera, Stretch};

/// Numbers that look random, the same in every run.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Even between two numbers.
    pub(crate) fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Even on a logarithmic scale.
    pub(crate) fn magnitude(&mut self, low: f64, high: f64) -> f64 {
        self.within(low.ln(), high.ln()).exp()
    }

    /// A direction so many degrees off the axis, per depth.
    pub(crate) fn along(&mut self, degrees: f64) -> DVec3 {
        let turn = self.within(0.0, std::f64::consts::TAU);
        let radius = degrees.to_radians().tan();
        DVec3::new(radius * turn.cos(), radius * turn.sin(), 1.0)
    }

    /// A matrix that makes ellipsoids with axes from `1 / most` to 1 of spheres, in any direction.
    pub(crate) fn ellipsoid(&mut self, most: f64) -> DMat3 {
        let axes = DVec3::from_array([0; 3].map(|_| 1.0 / self.magnitude(1.0, most)));
        let [a, b, c] = [0; 3].map(|_| self.within(0.0, std::f64::consts::TAU));
        DMat3::from_euler(glam::EulerRot::ZYX, a, b, c) * DMat3::from_diagonal(axes / axes.max_element())
    }
}

/// Standard deviation of the kernels, local units.
pub(crate) const SIGMA: f64 = 0.6;

/// A cloud of one splat at `u` in camera space, whose grid has this matrix.
pub(crate) fn cloud(u: DVec3, grid: DMat3) -> SplatCloud {
    let local = (grid.inverse() * u).as_vec3().to_array();
    SplatCloud {
        world_from_local: DAffine3::from_mat3(grid),
        positions: vec![local],
        payloads: vec![[1.0; 4]],
        gradients: Vec::new(),
        shape: KernelShape::Sphere { sigma: SIGMA },
        covariances: Vec::new(),
        peaks_from: usize::MAX,
        mass: grid.determinant().abs(),
        spacing: grid.determinant().abs().cbrt(),
        chunks: Chunk::of(&[local], 0, SIGMA as f32).into_iter().collect(),
    }
}

/// A view with this focal length in pixels, 60 degrees to all sides and more.
pub(crate) fn view(focal: f64) -> CameraView {
    let side = (4.0 * focal).ceil().max(16.0);
    CameraView {
        camera_from_world: DAffine3::IDENTITY,
        screen: ScreenFromCamera {
            perspective: true,
            scale: focal,
            centre: DVec2::splat(0.5 * side),
        },
        size: ImageSize::new(side as u32, side as u32).expect("a size"),
        near: 1e-6,
    }
}

/// The kernels' profile: what the Gaussian loses at the cut is less than the tolerances here.
pub(crate) fn profile() -> &'static GaussianProfile {
    static PROFILE: LazyLock<GaussianProfile> = LazyLock::new(|| GaussianProfile::new(5.0));
    &PROFILE
}

/// Filter, alignment and stretch of a splat.
pub(crate) type Way = (Filter, Alignment, Stretch);

/// The only splat's projection.
pub(crate) fn project<'a>(
    cloud: &'a SplatCloud,
    view: &CameraView,
    (filter, alignment, stretch): Way,
) -> Projection<'a> {
    Projection::new(cloud, view, (filter, alignment), profile()).with_stretch(stretch)
}

/// A Gaussian in camera space.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Kernel {
    /// The centre, rounded as in the footprint.
    pub(crate) u: DVec3,
    /// Covariance.
    pub(crate) covariance: DMat3,
    pub(crate) mass: f64,
}

impl Kernel {
    pub(crate) fn of(projection: &Projection<'_>, cloud: &SplatCloud) -> Self {
        let grid = cloud.world_from_local.matrix3;
        Self {
            u: projection.centre(0).as_dvec3(),
            covariance: grid * grid.transpose() * SIGMA.powi(2),
            mass: cloud.mass,
        }
    }

    /// Height at the centre.
    pub(crate) fn height(&self) -> f64 {
        self.mass / ((2.0 * std::f64::consts::PI).powi(3) * self.covariance.determinant()).sqrt()
    }

    /// Largest standard deviation.
    pub(crate) fn widest(&self) -> f64 {
        let c = self.covariance;
        (c.x_axis.x + c.y_axis.y + c.z_axis.z).sqrt()
    }

    /// Density at an offset from the centre.
    pub(crate) fn density(&self, offset: DVec3) -> f64 {
        self.height() * (-0.5 * offset.dot(self.covariance.inverse() * offset)).exp()
    }

    /// Line integral along `d` from the eye.
    pub(crate) fn along(&self, d: DVec3) -> f64 {
        let inverse = self.covariance.inverse();
        let height = self.height();
        // Where the ray is deepest in the kernel, and how long it stays there.
        let unit = d.normalize();
        let squared = unit.dot(inverse * unit);
        let middle = unit * (unit.dot(inverse * self.u) / squared);
        through(middle, unit, squared.sqrt().recip(), |point| {
            let offset = point - self.u;
            height * (-0.5 * offset.dot(inverse * offset)).exp()
        })
    }
}

/// Integral in arc length of a density along the ray `d` from the eye, where it passes the centre `u`: the
/// trapezoidal rule, which for Gaussians is as exact as the arithmetic.
pub(crate) fn line(d: DVec3, u: DVec3, widest: f64, density: impl Fn(DVec3) -> f64) -> f64 {
    let unit = d.normalize();
    let middle = unit.dot(u);
    through(unit * middle, unit, widest, density)
}

/// Integral of a density along a line.
pub(crate) fn through(point: DVec3, unit: DVec3, widest: f64, density: impl Fn(DVec3) -> f64) -> f64 {
    const STEPS: i32 = 160;
    let step = 8.0 * widest / f64::from(STEPS);
    (-STEPS..=STEPS)
        .map(|i| density(point + unit * (f64::from(i) * step)) * step)
        .sum()
}

/// The ray of a pixel, per depth.
pub(crate) fn ray(view: &CameraView, pixel: [f32; 2]) -> DVec3 {
    let [x, y] = pixel.map(f64::from);
    ((DVec2::new(x, y) - view.screen.centre) / view.screen.scale).extend(1.0)
}

/// A pixel at random in a footprint.
pub(crate) fn pixel(random: &mut Random, footprint: &Footprint) -> [f32; 2] {
    let [x0, y0, x1, y1] = footprint.bounds.map(f64::from);
    [random.within(x0, x1) as f32, random.within(y0, y1) as f32]
}

/// All pixels of a fine raster over a footprint.
pub(crate) fn raster(footprint: &Footprint, steps: u32) -> impl Iterator<Item = [f32; 2]> {
    let [x0, y0, x1, y1] = footprint.bounds;
    let at = move |low: f32, high: f32, i: u32| low + (high - low) * (i as f32 + 0.5) / steps as f32;
    (0..steps * steps).map(move |i| [at(x0, x1, i % steps), at(y0, y1, i / steps)])
}
