//! The participating medium: extinction and emission at a point in camera space.
//!
//! Post-classified: `kappa = q kappa_tf(v)` and `e = kappa c` with the colour of v, lit by `grad S`. Pre-classified:
//! `kappa = sum_k kappa_k h(x - k)`, `e = sum_k kappa_k c_k h(x - k)` with colours lit at the voxels. Both with the
//! EWA low-pass of the point's depth: the kernel's covariance is
//! `sigma^2 M M^T + (pixel_sigma / s(z))^2 diag(1, 1, 0)` in camera space. Gradients are those of the field with the
//! low-pass of that depth (its change with depth is not differentiated).

use glam::{DAffine3, DMat3, DVec3};
use splatvol_scene::{
    Camera, RenderSettings, Scene, ScreenFromCamera, SingleVolume, TransferFunction, Volume,
};

use crate::ReferenceError;
use crate::kernel::GaussianKernel;
use crate::lattice::{Lattice, LatticeSums};
use crate::reconstruction::{Reconstruction, Sums};
use crate::shading::{Shading, voxel_gradient};

/// Camera, grid and low-pass of one frame.
#[derive(Debug, Clone)]
pub(crate) struct ViewGeometry {
    pub(crate) camera_from_voxel: DAffine3,
    pub(crate) voxel_from_camera: DAffine3,
    pub(crate) screen_from_camera: ScreenFromCamera,
    pub(crate) kernel: GaussianKernel,
    pixel_sigma: f64,
    /// Camera-space gradient per mean voxel spacing of a gradient in voxel space.
    camera_from_voxel_gradient: DMat3,
}

impl ViewGeometry {
    /// `mean_spacing`: of the volume's own voxels, to which gradients refer; world length.
    pub(crate) fn new(
        volume: &Volume,
        mean_spacing: f64,
        camera: &Camera,
        settings: &RenderSettings,
    ) -> Result<Self, ReferenceError> {
        let grid = volume.grid();
        let camera_from_voxel = camera.camera_from_world() * grid.world_from_voxel();
        let voxel_from_camera = camera_from_voxel.inverse();
        Ok(Self {
            camera_from_voxel,
            voxel_from_camera,
            screen_from_camera: camera.screen_from_camera(settings.size),
            kernel: GaussianKernel::new(&settings.method.kernel())?,
            pixel_sigma: settings.method.filter().pixel_sigma(),
            camera_from_voxel_gradient: voxel_from_camera.matrix3.transpose() * mean_spacing,
        })
    }

    /// Covariance of the low-passed kernel at a camera depth, voxel space; `None` where it is the kernel's own.
    pub(crate) fn covariance(&self, depth: f64) -> Option<DMat3> {
        if self.pixel_sigma == 0.0 {
            return None;
        }
        let low_pass = self.pixel_sigma / self.screen_from_camera.scale_at(depth);
        let in_camera = DMat3::from_diagonal(DVec3::new(low_pass * low_pass, low_pass * low_pass, 0.0));
        let linear = self.voxel_from_camera.matrix3;
        let own = DMat3::from_diagonal(DVec3::splat(self.kernel.sigma * self.kernel.sigma));
        Some(own + linear * in_camera * linear.transpose())
    }
}

/// Properties of the medium at one point of a ray.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct MediumSample {
    /// Reconstructed value, data units; NaN where nothing is known of it (no sample near, or pre-classified).
    pub(crate) value: f64,
    /// Coverage q.
    pub(crate) coverage: f64,
    /// Extinction kappa per world length.
    pub(crate) extinction: f64,
    /// Emission `kappa c`, linear light, per world length.
    pub(crate) emission: [f64; 3],
}

/// The field a ray integrates.
#[derive(Debug, Clone)]
pub(crate) enum Medium {
    /// Data, classified at each point.
    Post(Box<PostClassified>),
    /// Classified and lit voxels: extinction and emission per voxel.
    Pre(Lattice<4>),
}

/// The data field with its looks.
#[derive(Debug, Clone)]
pub(crate) struct PostClassified {
    reconstruction: Reconstruction,
    transfer_function: TransferFunction,
    unit_distance: f64,
    shading: Option<Shading>,
}

impl Medium {
    /// The data of a volume, classified at each point with a look.
    pub(crate) fn post(
        volume: &Volume,
        look: &SingleVolume<'_>,
        settings: &RenderSettings,
    ) -> Result<Self, ReferenceError> {
        Ok(Self::Post(Box::new(PostClassified {
            reconstruction: Reconstruction::new(
                volume,
                &settings.method.kernel(),
                settings.method.prefilter(),
            )?,
            transfer_function: look.transfer_function.clone(),
            unit_distance: look.unit_distance(),
            shading: settings.lighting.map(Shading::new),
        })))
    }

    /// The voxels of a scene, classified and, with `shading`, lit by central differences.
    pub(crate) fn pre(
        scene: &Scene,
        geometry: &ViewGeometry,
        shading: Option<Shading>,
    ) -> Result<Self, ReferenceError> {
        let single = scene.single_volume()?;
        let (volume, unit_distance) = (single.volume, single.unit_distance());
        let classify = |index: usize| {
            let value = volume.value(index);
            if !value.is_finite() {
                return [0.0; 4];
            }
            let extinction = single.transfer_function.extinction(value, unit_distance);
            let color = single.transfer_function.linear_color(value);
            let gradient = geometry.camera_from_voxel_gradient * voxel_gradient(volume, index);
            let [r, g, b] = shading.map_or(color, |shading| shading.lit(color, gradient));
            [extinction, extinction * r, extinction * g, extinction * b]
        };
        Ok(Self::Pre(Lattice {
            dims: volume.grid().dims(),
            payload: (0..volume.grid().sample_count()).map(classify).collect(),
        }))
    }

    /// Extinction and emission at a camera-space point.
    pub(crate) fn sample(&self, geometry: &ViewGeometry, camera: DVec3) -> MediumSample {
        let voxel = geometry.voxel_from_camera.transform_point3(camera);
        let covariance = geometry.covariance(camera.z);
        match self {
            Self::Post(field) => {
                let sums = field.sums(voxel, covariance);
                let gradient = geometry.camera_from_voxel_gradient * sums.grad_s;
                field.sample(&sums, gradient)
            }
            Self::Pre(lattice) => {
                let LatticeSums { sums, .. } = match covariance {
                    None => lattice.sums(&geometry.kernel, voxel),
                    Some(covariance) => lattice.filtered_sums(&geometry.kernel, covariance, voxel),
                };
                let [extinction, r, g, b] = sums;
                MediumSample {
                    value: f64::NAN,
                    coverage: 1.0,
                    extinction,
                    emission: [r, g, b],
                }
            }
        }
    }
}

impl PostClassified {
    fn sums(&self, voxel: DVec3, covariance: Option<DMat3>) -> Sums {
        match covariance {
            None => self.reconstruction.sums(voxel),
            Some(covariance) => self.reconstruction.filtered_sums(voxel, covariance),
        }
    }

    fn sample(&self, sums: &Sums, gradient: DVec3) -> MediumSample {
        let coverage = sums.coverage();
        if coverage == 0.0 {
            return MediumSample {
                value: f64::NAN,
                ..MediumSample::default()
            };
        }
        let value = self.reconstruction.data_value(sums);
        let extinction = coverage * self.transfer_function.extinction(value, self.unit_distance);
        let color = self.transfer_function.linear_color(value);
        let color = self.shading.map_or(color, |shading| shading.lit(color, gradient));
        MediumSample {
            value,
            coverage,
            extinction,
            emission: color.map(|c| extinction * c),
        }
    }
}
