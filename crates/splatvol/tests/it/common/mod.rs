//! Cameras and settings that several tests share.

use glam::DVec3;
use splatvol::{
    Camera, Classification, Compositing, EngineConfig, Filter, FlatSettings, Frame, Grid, ImageSize,
    Projection, RenderSettings, Renderer, Scene,
};
use splatvol_testing::checked;

/// Central and parallel projection.
pub(crate) const PROJECTIONS: [Projection; 2] = [
    Projection::Perspective { fov_degrees: 30.0 },
    Projection::Orthographic { height: 1.0 },
];

/// Settings of a square picture, otherwise the defaults.
pub(crate) fn settings(pixels: u32) -> RenderSettings {
    RenderSettings {
        size: ImageSize::new(pixels, pixels).unwrap(),
        ..RenderSettings::best()
    }
}

/// The three ways to optical depth: post-classified, pre-classified, X-ray; unlit.
pub(crate) fn modes(pixels: u32) -> [(&'static str, RenderSettings); 3] {
    let base = RenderSettings {
        lighting: None,
        ..settings(pixels)
    };
    [
        ("post", base),
        (
            "pre",
            checked(FlatSettings {
                classification: Classification::Pre,
                ..base.into()
            }),
        ),
        (
            "xray",
            checked(FlatSettings {
                compositing: Compositing::Xray,
                ..base.into()
            }),
        ),
    ]
}

/// Settings without the low-pass.
pub(crate) fn unfiltered(settings: RenderSettings) -> RenderSettings {
    checked(FlatSettings {
        filter: Filter::None,
        ..settings.into()
    })
}

/// Orthographic camera looking along `direction` at `target`, showing `height` world units.
pub(crate) fn orthographic(target: DVec3, direction: DVec3, height: f64) -> Camera {
    let position = target - 500.0 * direction.normalize();
    let up = direction.any_orthonormal_vector();
    Camera::new(position, target, up, Projection::Orthographic { height }).unwrap()
}

/// Perspective camera at `distance` in front of `target`.
pub(crate) fn perspective(target: DVec3, direction: DVec3, distance: f64, fov_degrees: f64) -> Camera {
    let position = target - distance * direction.normalize();
    let up = direction.any_orthonormal_vector();
    Camera::new(position, target, up, Projection::Perspective { fov_degrees }).unwrap()
}

/// A frame by an engine of its own.
pub(crate) fn render(scene: &Scene, camera: &Camera, settings: &RenderSettings) -> Frame {
    let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
    renderer.render(scene, camera, settings).unwrap()
}

/// Ray of a pixel's centre in world space: a point, and the direction of unit camera depth.
pub(crate) fn world_ray(camera: &Camera, settings: &RenderSettings, x: usize, y: usize) -> (DVec3, DVec3) {
    let screen = camera.screen_from_camera(settings.size);
    let (origin, direction) = screen.ray(glam::DVec2::new(x as f64 + 0.5, y as f64 + 0.5));
    let world_from_camera = camera.camera_from_world().inverse();
    (
        world_from_camera.transform_point3(origin),
        world_from_camera.transform_vector3(direction),
    )
}

/// Length of a ray of unit camera depth in the grid's box (per depth), and how far from the other faces, in voxels, it
/// enters and leaves.
pub(crate) fn crossing(grid: &Grid, origin: DVec3, direction: DVec3) -> Option<(f64, f64)> {
    let voxel_from_world = grid.world_from_voxel().inverse();
    let (p, d) = (
        voxel_from_world.transform_point3(origin),
        voxel_from_world.transform_vector3(direction),
    );
    let low = DVec3::splat(-0.5);
    let high = DVec3::from_array(grid.dims().map(|n| n as f64 - 0.5));
    let (a, b) = ((low - p) / d, (high - p) / d);
    let (enter, leave) = (a.min(b).max_element(), a.max(b).min_element());
    let clear = |t: f64| {
        let at = p + t * d;
        let mut distances = (at - low).min(high - at).to_array();
        distances.sort_by(f64::total_cmp);
        // The nearest face is the one that is crossed.
        distances[1]
    };
    (enter < leave).then(|| (leave - enter, clear(enter).min(clear(leave))))
}
