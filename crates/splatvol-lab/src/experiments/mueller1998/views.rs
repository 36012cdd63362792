//! Views of figures 5 and 6.

use glam::DVec3;
use splatvol::{Camera, Projection, RenderSettings, Scene};
use splatvol_samples::Sample;

use super::scenes::scene;
use crate::experiments::ground::Ground;
use crate::{LabError, Workbench};

/// Something to look at.
pub(super) struct View {
    /// The paper's.
    pub(super) figure: &'static str,
    /// The scene.
    pub(super) scene: Scene,
    /// The camera.
    pub(super) camera: Camera,
    /// Pixels.
    pub(super) size: [u32; 2],
    /// Samples per pixel along each axis of the picture that counts as right.
    pub(super) samples: u32,
}

/// Depth where pixels are as far apart as voxels (eq. 3).
pub(super) fn z_k(view: &View, settings: &RenderSettings) -> Result<f64, LabError> {
    let screen = view.camera.screen_from_camera(settings.size);
    Ok(screen.scale * view.scene.single_volume()?.volume.grid().mean_spacing())
}

/// The view's camera this many steps farther on: a step is a hundredth of the longest side.
pub(super) fn forward(view: &View, steps: f64) -> Result<Camera, LabError> {
    let camera = &view.camera;
    let bounds = view.scene.bounds()?;
    let longest = (bounds.max - bounds.min).max_element();
    let way = 0.01 * steps * longest * (camera.target() - camera.position()).normalize();
    let (position, target) = (camera.position() + way, camera.target() + way);
    Ok(Camera::new(position, target, camera.up(), camera.projection())?)
}

/// Figure 5: from the mouth of the tube.
pub(super) fn tunnel_view(bench: &Workbench<'_>) -> Result<View, LabError> {
    let (dims, side) = bench.choose(([160, 160, 300], 240), ([80, 80, 150], 120));
    let scene = scene(Sample::Tunnel, dims)?;
    let bounds = scene.bounds()?;
    let centre = bounds.centre();
    let mouth = DVec3::new(centre.x, centre.y, bounds.min.z);
    let projection = Projection::Perspective { fov_degrees: 90.0 };
    Ok(View {
        figure: "Fig. 5",
        scene,
        camera: Camera::new(mouth, centre, DVec3::Y, projection)?,
        size: [side, side],
        samples: bench.choose(6, 4),
    })
}

/// Figure 6: from low before the landscape's edge.
pub(super) fn terrain_view(bench: &Workbench<'_>, ground: Ground) -> Result<View, LabError> {
    let (dims, size) = bench.choose(([512, 512, 103], [272, 170]), ([160, 160, 32], [100, 62]));
    let scene = ground.scene(bench, dims)?;
    let bounds = scene.bounds()?;
    let side = dims[0] as f64;
    let target = bounds.centre() - DVec3::Z * 0.1 * side;
    let position = target + side * DVec3::new(0.0, -0.62, 0.3);
    let projection = Projection::Perspective { fov_degrees: 40.0 };
    Ok(View {
        figure: "Fig. 6",
        scene,
        camera: Camera::new(position, target, DVec3::Z, projection)?,
        size,
        samples: bench.choose(6, 4),
    })
}
