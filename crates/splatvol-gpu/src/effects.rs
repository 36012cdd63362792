//! Effects: clips and isosurfaces, as shaders read them.

use glam::{DAffine3, Vec3};
use splatvol_scene::transfer_function::linear_from_srgb;
use splatvol_scene::{Camera, Clip, Isosurface, Item, Keep, Scene};

/// Clips and isosurfaces of a volume, camera space: `effects` in WGSL.
#[derive(Debug, Clone, Default)]
pub(crate) struct Effects {
    pub data: Vec<[f32; 4]>,
    pub bodies: u32,
    pub isosurfaces: u32,
}

impl Effects {
    /// Those of an item of a scene. `range`: its smallest and largest value; `mean_spacing`: world length.
    pub(crate) fn new(
        (scene, item, isosurfaces): (&Scene, &Item, &[Isosurface]),
        camera: &Camera,
        (range, mean_spacing): ([f64; 2], f64),
    ) -> Self {
        let place = &item.world_from_item;
        let own = item.clips.iter().map(|clip| clip.transformed(place));
        let clips: Vec<Clip> = scene.clips.iter().cloned().chain(own).collect();
        let mut data = bodies(&clips, &camera.camera_from_world().inverse());
        for surface in isosurfaces {
            data.extend(of_isosurface(surface, (range, mean_spacing)));
        }
        Self {
            data,
            bodies: clips.len() as u32,
            isosurfaces: isosurfaces.len() as u32,
        }
    }

    /// The clips of a scene alone.
    pub(crate) fn clips(scene: &Scene, camera: &Camera) -> Self {
        Self {
            data: bodies(&scene.clips, &camera.camera_from_world().inverse()),
            bodies: scene.clips.len() as u32,
            isosurfaces: 0,
        }
    }

    pub(crate) fn is_none(&self) -> bool {
        self.data.is_empty()
    }

    /// Place of the first isosurface in the data.
    pub(crate) fn first_isosurface(&self) -> u32 {
        self.data.len() as u32 - 2 * self.isosurfaces
    }
}

/// Bodies, each with the places of its planes, then all planes.
fn bodies(clips: &[Clip], world_from_camera: &DAffine3) -> Vec<[f32; 4]> {
    let mut data = Vec::new();
    let mut at = clips.len();
    for clip in clips {
        let end = at + clip.planes.len();
        let keeps_inside = f32::from(u8::from(clip.keep == Keep::Inside));
        data.push([at as f32, end as f32, keeps_inside, 0.0]);
        at = end;
    }
    for plane in clips.iter().flat_map(|clip| &clip.planes) {
        let normal = world_from_camera.matrix3.transpose() * plane.normal();
        let length = normal.length();
        let [x, y, z] = (normal / length).as_vec3().to_array();
        data.push([
            x,
            y,
            z,
            (plane.distance(world_from_camera.translation) / length) as f32,
        ]);
    }
    data
}

/// Normalised value and extinction; linear colour.
fn of_isosurface(surface: &Isosurface, ([low, high], mean_spacing): ([f64; 2], f64)) -> [[f32; 4]; 2] {
    let range = if high > low { high - low } else { 1.0 };
    let extinction = -libm::log1p(-surface.opacity) / mean_spacing;
    let color = Vec3::from_array(surface.rgb.map(|c| linear_from_srgb(c) as f32));
    [
        [
            (surface.value as f32 - low as f32) / range as f32,
            extinction as f32,
            0.0,
            0.0,
        ],
        color.extend(0.0).to_array(),
    ]
}
