//! Effects: clips, isosurfaces and operators, as shaders read them.

use std::sync::Arc;

use glam::{DAffine3, Vec3};
use splatvol_scene::transfer_function::linear_from_srgb;
use splatvol_scene::{Camera, Clip, Isosurface, Item, Keep, Scene};

use crate::operators::Operators;

/// Clips, isosurfaces and operators of a volume or mesh, camera space: `effects` in WGSL.
#[derive(Debug, Clone, Default)]
pub(crate) struct Effects {
    pub data: Vec<[f32; 4]>,
    pub bodies: u32,
    pub isosurfaces: u32,
    /// Place of the first isosurface in the data.
    pub first_isosurface: u32,
    /// The function `operate`.
    pub operators: Arc<str>,
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
        let world_from_camera = camera.camera_from_world().inverse();
        let mut data = bodies(&clips, &world_from_camera);
        let first_isosurface = data.len() as u32;
        for surface in isosurfaces {
            data.extend(of_isosurface(surface, (range, mean_spacing)));
        }
        let operators = Operators::new(&item.operators, (&world_from_camera, range));
        data.extend(operators.data);
        Self {
            data,
            bodies: clips.len() as u32,
            isosurfaces: isosurfaces.len() as u32,
            first_isosurface,
            operators: operators.text,
        }
    }

    /// The clips of a scene alone.
    pub(crate) fn clips(scene: &Scene, camera: &Camera) -> Self {
        let data = bodies(&scene.clips, &camera.camera_from_world().inverse());
        Self {
            bodies: scene.clips.len() as u32,
            first_isosurface: data.len() as u32,
            data,
            ..Self::default()
        }
    }

    pub(crate) fn is_none(&self) -> bool {
        self.data.is_empty()
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
            ((surface.value - low) / range) as f32,
            extinction as f32,
            0.0,
            0.0,
        ],
        color.extend(0.0).to_array(),
    ]
}
