//! Phong lighting, as engines and reference both compute it.
//!
//! A directional light over two-sided surfaces, both fixed to the camera: l points to the light, `v = -z` to the
//! viewer (also in perspective), `h = (l + v) / |l + v|`. With g the gradient of the value field in camera space,
//! in value ranges per mean voxel spacing, `n = g / |g|` and the *surfaceness* `a = |g|^2 / (|g|^2 + floor^2)`:
//!
//! `lit = c (ambient + diffuse (1 - a + a |n.l|)) + specular a |n.h|^power`
//!
//! Where there is no surface (a = 0) light leaves equally in all directions, the isotropic phase function: flat
//! noisy regions do not flicker with the direction of tiny gradients, as they do in plain Phong. White light.

use serde::{Deserialize, Serialize};

/// Strengths of the Phong terms (linear light).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Lighting {
    /// Towards the light, camera space (x right, y down, z forward), any length; the default is a headlight.
    pub direction: [f64; 3],
    /// Share of the colour that needs no light.
    pub ambient: f64,
    /// Share of the colour under full light.
    pub diffuse: f64,
    /// White highlight.
    pub specular: f64,
    /// Exponent of the highlight, at least 1.
    pub specular_power: f64,
    /// Gradient, in value ranges per mean voxel spacing, that counts as half a surface.
    pub gradient_floor: f64,
}

impl Default for Lighting {
    fn default() -> Self {
        Self {
            direction: [0.0, 0.0, -1.0],
            ambient: 0.25,
            diffuse: 0.75,
            specular: 0.15,
            specular_power: 20.0,
            gradient_floor: 0.01,
        }
    }
}
