//! One splat before one camera, by the engine's code and by the paper's equations in 64 bits.
//!
//! The screen covariance is `V = T V'' T^T` (eq. 20) with `T = J W`, of which the first two rows count (eq. 13, 21):
//! `J = [[1 / z, 0, -x / z^2], [0, 1 / z, -y / z^2]]` (eq. 25) times the pixels per unit of the plane z = 1.

use glam::{DAffine3, DMat2, DMat3, DVec2, DVec3};
use splatvol::{Alignment, Filter, ImageSize, ScreenFromCamera};
use splatvol_core::splats::{
    CameraView, Chunk, Footprint, GaussianProfile, KernelShape, Projection, SplatCloud, Warp,
};

use crate::LabError;

/// A kernel: centre in camera space, W (object to camera space), and the shape in object space.
#[derive(Debug, Clone, Copy)]
pub(super) struct Splat {
    /// Centre, camera space.
    pub centre: DVec3,
    /// W: object axes in camera space.
    pub camera_from_object: DMat3,
    /// Spheres, or spheres flattened along z of object space.
    pub shape: KernelShape,
}

/// Pixels per unit of the plane z = 1.
pub(super) const FOCAL: f64 = 1000.0;
/// Half the picture's side, pixels: 65 degrees to each side.
const HALF: f64 = 2145.0;

impl Splat {
    /// A sphere of standard deviation 1 in object space.
    pub(super) fn sphere(centre: DVec3, camera_from_object: DMat3) -> Self {
        let shape = KernelShape::Sphere { sigma: 1.0 };
        Self {
            centre,
            camera_from_object,
            shape,
        }
    }

    /// This splat, flattened by `flatness` along z of object space (section 5).
    pub(super) fn flattened(self, flatness: f64) -> Self {
        let shape = KernelShape::Flattened {
            sigma: 1.0,
            flatness,
            threshold: 0.0,
        };
        Self { shape, ..self }
    }

    /// The footprint that the engine draws.
    pub(super) fn footprint(
        &self,
        filter: Filter,
        alignment: Alignment,
        profile: &GaussianProfile,
    ) -> Result<Footprint, LabError> {
        let cloud = self.cloud();
        let size = ImageSize::new(2 * HALF as u32, 2 * HALF as u32)?;
        let view = CameraView {
            camera_from_world: DAffine3::IDENTITY,
            screen: ScreenFromCamera {
                perspective: true,
                scale: FOCAL,
                centre: DVec2::splat(HALF),
            },
            size,
            near: 1e-6,
        };
        let projection = Projection::new(&cloud, &view, (filter, alignment), profile);
        projection
            .project(0)
            .ok_or_else(|| LabError::Measurement(format!("the splat at {} is out of sight", self.centre)))
    }

    fn cloud(&self) -> SplatCloud {
        let frame = DAffine3::from_mat3(self.camera_from_object);
        let local = frame.inverse().transform_point3(self.centre).as_vec3().to_array();
        SplatCloud {
            world_from_local: frame,
            positions: vec![local],
            payloads: vec![[1.0; 4]],
            gradients: vec![[0.0, 0.0, 1.0]],
            shape: self.shape,
            covariances: Vec::new(),
            peaks_from: usize::MAX,
            mass: self.camera_from_object.determinant().abs(),
            spacing: self.camera_from_object.determinant().abs().cbrt(),
            chunks: Chunk::of(&[local], 0, 1.0).into_iter().collect(),
        }
    }

    /// The rows of T = J W that reach the screen, as columns of object axes, pixels.
    pub(super) fn pixels_from_object(&self) -> [DVec2; 3] {
        let DVec3 { x, y, z } = self.centre;
        let seen = |axis: DVec3| {
            FOCAL
                * DVec2::new(
                    axis.x / z - x * axis.z / (z * z),
                    axis.y / z - y * axis.z / (z * z),
                )
        };
        let w = self.camera_from_object;
        [w.x_axis, w.y_axis, w.z_axis].map(seen)
    }

    /// The screen covariance by the equations, without a low-pass, pixels squared; `flatness` as in section 5.
    pub(super) fn covariance(&self, flatness: f64) -> DMat2 {
        let [a, b, c] = self.pixels_from_object();
        square(a) + square(b) + square(c) * flatness.powi(-2)
    }

    /// The direction through the centre of the picture's pixel.
    pub(super) fn ray(pixel: DVec2) -> DVec3 {
        ((pixel - HALF) / FOCAL).extend(1.0)
    }
}

/// `v v^T`.
fn square(v: DVec2) -> DMat2 {
    DMat2::from_cols(v * v.x, v * v.y)
}

/// The covariance of an affine footprint, pixels squared: the inverse of its conic.
pub(super) fn covariance_of(footprint: &Footprint) -> Result<DMat2, LabError> {
    match footprint.warp {
        Warp::Affine { conic, .. } => {
            let [xx, xy, yy] = conic.map(f64::from);
            Ok(DMat2::from_cols_array(&[xx, xy, xy, yy]).inverse())
        }
        _ => Err(LabError::Measurement("the footprint is no ellipse".to_owned())),
    }
}

/// Standard deviations along the minor and the major axis.
pub(super) fn widths(covariance: DMat2) -> [f64; 2] {
    let mean = 0.5 * (covariance.x_axis.x + covariance.y_axis.y);
    let half = 0.5 * (covariance.x_axis.x - covariance.y_axis.y);
    let root = half.hypot(covariance.x_axis.y);
    [(mean - root).max(0.0).sqrt(), (mean + root).sqrt()]
}

/// Square root of the sum of squares of all entries.
pub(super) fn norm(m: DMat2) -> f64 {
    (m.x_axis.length_squared() + m.y_axis.length_squared()).sqrt()
}

/// A closed line: where an ellipse of this covariance has one standard deviation.
pub(super) fn outline(covariance: DMat2) -> Vec<[f64; 2]> {
    // The Cholesky factor takes the circle to the ellipse.
    let a = covariance.x_axis.x.sqrt();
    let b = covariance.x_axis.y / a;
    let c = (covariance.y_axis.y - b * b).max(0.0).sqrt();
    (0..=72)
        .map(|i| (f64::from(i) * 5.0).to_radians().sin_cos())
        .map(|(sin, cos)| [a * cos, b * cos + c * sin])
        .collect()
}
