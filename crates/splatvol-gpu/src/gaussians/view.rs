//! View: a cloud before a camera, as shaders read it.

use bytemuck::{Pod, Zeroable};
use glam::DAffine3;
use splatvol_core::cloud_view::{CloudView, LowPass, PUBLISHED_LOW_PASS, PUBLISHED_NEAR, near_of_gaussians};
use splatvol_core::engine::Shot;
use splatvol_scene::Gaussians;

/// A cloud before a camera: `View` in WGSL.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct ViewData {
    pub eye: [f32; 3],
    pub near: f32,
    pub eye_rest: [f32; 3],
    pub scale: f32,
    pub to_x: [f32; 3],
    pub low_pass: f32,
    pub to_y: [f32; 3],
    pub is_perspective: u32,
    pub to_z: [f32; 3],
    pub degree: u32,
    pub direction: [f32; 3],
    pub is_antialiased: u32,
    pub centre: [f32; 2],
    pub tangent_limit: [f32; 2],
    pub reference_tiles: [f32; 2],
    pub count: u32,
    pub before: u32,
}

/// A cloud before the camera; page and count are left open.
pub(super) fn view(own: &Gaussians, world_from_item: &DAffine3, shot: &Shot<'_>) -> ViewData {
    let world_from_local = *world_from_item * *own.world_from_local();
    let near = near_of_gaussians(PUBLISHED_NEAR, &world_from_local);
    let camera = (shot.camera, shot.settings.size);
    let view = CloudView::new(
        &world_from_local,
        near,
        camera,
        LowPass::Added(PUBLISHED_LOW_PASS),
    );
    let [to_x, to_y, to_z] = view.camera_from_local;
    ViewData {
        eye: view.eye[0],
        near: view.near,
        eye_rest: view.eye[1],
        scale: view.scale,
        to_x,
        low_pass: PUBLISHED_LOW_PASS,
        to_y,
        is_perspective: u32::from(view.perspective),
        to_z,
        degree: own.degree(),
        direction: view.direction.unwrap_or_default(),
        is_antialiased: u32::from(own.antialiased()),
        centre: view.centre,
        tangent_limit: view.tangent_limit,
        reference_tiles: view.reference_tiles.map(|n| n as f32),
        count: 0,
        before: 0,
    }
}
