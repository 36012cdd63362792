//! Phong lighting with surfaceness, and the gradients of pre-classified voxels.
//!
//! `lit = c (ambient + diffuse (1 - a + a |n.l|)) + specular a |n.h|^power`, `a = |g|^2 / (|g|^2 + floor^2)`,
//! `n = g / |g|`, `v = -z`, `h = (l + v) / |l + v|`; see `splatvol_scene::lighting`.

use glam::DVec3;
use splatvol_scene::{Lighting, Volume};

use crate::reconstruction::face_neighbours;

/// A light ready to use.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shading {
    lighting: Lighting,
    towards_light: DVec3,
    halfway: DVec3,
}

impl Shading {
    pub(crate) fn new(lighting: Lighting) -> Self {
        let towards_light = DVec3::from_array(lighting.direction).normalize();
        Self {
            lighting,
            towards_light,
            halfway: (towards_light - DVec3::Z).normalize(),
        }
    }

    /// Light leaving a point of colour `color` (linear) and gradient `gradient` (camera space, value ranges per mean
    /// voxel spacing).
    pub(crate) fn lit(&self, color: [f64; 3], gradient: DVec3) -> [f64; 3] {
        let light = &self.lighting;
        let squared = gradient.length_squared();
        let surfaceness = squared / (squared + light.gradient_floor.powi(2));
        let normal = gradient.try_normalize().unwrap_or(DVec3::ZERO);
        let facing = normal.dot(self.towards_light).abs();
        let body = light.ambient + light.diffuse * (1.0 - surfaceness + surfaceness * facing);
        let highlight =
            light.specular * surfaceness * normal.dot(self.halfway).abs().powf(light.specular_power);
        color.map(|c| c * body + highlight)
    }
}

/// Gradient of F at a voxel, value ranges per voxel: central differences, one-sided at the border; a missing
/// neighbour counts as the voxel's own value.
pub(crate) fn voxel_gradient(volume: &Volume, index: usize) -> DVec3 {
    let [low, high] = volume.value_range();
    let width = if high > low { high - low } else { 1.0 };
    let own = volume.value(index);
    let value = |neighbour: usize| {
        let value = volume.value(neighbour);
        if value.is_finite() { value } else { own }
    };
    let slope = |neighbours: [Option<usize>; 2]| match neighbours {
        [Some(lower), Some(upper)] => 0.5 * (value(upper) - value(lower)),
        [Some(lower), None] => own - value(lower),
        [None, Some(upper)] => value(upper) - own,
        [None, None] => 0.0,
    };
    DVec3::from_array(face_neighbours(index, volume.grid().dims()).map(slope)) / width
}
