//! Light on classified splats, fixed to the camera.

use glam::{DMat3, Mat3, Vec3};
use splatvol_core::splats::SplatCloud;
use splatvol_scene::{Camera, Lighting};

use crate::phong::Phong;

/// Lights splats by the gradients of their cloud.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SplatLight {
    phong: Phong,
    camera_from_local_gradient: Mat3,
}

impl SplatLight {
    /// Light of a frame.
    pub(crate) fn new(lighting: &Lighting, cloud: &SplatCloud, camera: &Camera) -> Self {
        let rotation: DMat3 = camera.camera_from_world().matrix3;
        Self {
            phong: Phong::new(lighting, cloud.spacing),
            camera_from_local_gradient: cloud.gradient_from_local(rotation).as_mat3(),
        }
    }

    /// Extinction and emission in this light.
    #[inline(always)]
    pub(crate) fn on(&self, [extinction, r, g, b]: [f32; 4], gradient: [f32; 3]) -> [f32; 4] {
        let gradient = self.camera_from_local_gradient * Vec3::from_array(gradient);
        let lit = self.phong.at(gradient.to_array());
        let shine = extinction * lit.specular;
        let [r, g, b] = [r, g, b].map(|e| e * lit.diffuse + shine);
        [extinction, r, g, b]
    }
}
