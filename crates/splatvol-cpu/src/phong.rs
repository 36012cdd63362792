//! Phong: light on a gradient, one at a time or sixteen at once.
//!
//! The model of `splatvol_scene::lighting` in f32:
//! `c (ambient + diffuse (1 - s + s |n . l|)) + specular s |n . h|^power`, where the surfaceness
//! `s = g^2 / (g^2 + floor^2)` fades from homogeneous material, lit from all sides, to a surface.

use std::ops::Mul;

use fearless_simd::{f32x16, prelude::*};
use splatvol_scene::Lighting;

use crate::simd::math::{LEAST_EXPONENT, exp2, log2};

/// Least squared gradient, in value ranges per voxel: smaller ones have no direction.
const LEAST_SQUARED: f32 = 1e-12;
/// Squared gradient, relative to that of half a surface, below which light finds no surface at all.
const FLAT: f32 = 1e-6;
/// Largest whole power that is raised by squaring; beyond, logarithms are as fast.
const MOST_SQUARED: f32 = 256.0;

/// Effect of lighting on a colour c: `c diffuse + specular`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lit {
    pub diffuse: f32,
    pub specular: f32,
}

impl Lit {
    /// No lighting.
    pub(crate) const PLAIN: Self = Self {
        diffuse: 1.0,
        specular: 0.0,
    };
}

/// The Phong model of `splatvol_scene::lighting` in f32.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Phong {
    ambient: f32,
    diffuse: f32,
    specular: f32,
    power: f32,
    /// Least base of the specular power.
    least_shining: f32,
    floor_squared: f32,
    towards_light: [f32; 3],
    half_way: [f32; 3],
    /// Mean voxel spacing: gradients per world length to gradients per voxel.
    spacing: f32,
}

impl Phong {
    /// The model for gradients given per world length.
    pub(crate) fn new(lighting: &Lighting, mean_spacing: f64) -> Self {
        let light = glam::DVec3::from_array(lighting.direction).normalize();
        let half_way = (light - glam::DVec3::Z).normalize();
        Self {
            ambient: lighting.ambient as f32,
            diffuse: lighting.diffuse as f32,
            specular: lighting.specular as f32,
            power: lighting.specular_power as f32,
            least_shining: libm::exp2(f64::from(LEAST_EXPONENT) / lighting.specular_power) as f32,
            floor_squared: lighting.gradient_floor.powi(2) as f32,
            towards_light: light.as_vec3().to_array(),
            half_way: half_way.as_vec3().to_array(),
            spacing: mean_spacing as f32,
        }
    }

    /// Diffuse and specular factors of sixteen pixels with these gradients (camera space, per world length).
    #[inline(always)]
    pub(crate) fn lanes<S: Simd>(&self, simd: S, gradient: [f32x16<S>; 3]) -> (f32x16<S>, f32x16<S>) {
        let [x, y, z] = gradient;
        let per_voxel = self.spacing * self.spacing;
        let squared = ((x * x + y * y + z * z) * per_voxel).max(f32x16::splat(simd, LEAST_SQUARED));
        // One division for both the inverse length and the surfaceness.
        let (length, floored) = (squared.sqrt(), squared + self.floor_squared);
        let quotient = f32x16::splat(simd, 1.0) / (length * floored);
        let surface = squared * length * quotient;
        let inverse = floored * quotient * self.spacing;
        let facing = (dot(gradient, self.towards_light).abs() * inverse).min(f32x16::splat(simd, 1.0));
        let diffuse = (surface * (facing - 1.0) + 1.0) * self.diffuse + self.ambient;
        if self.specular == 0.0 {
            return (diffuse, f32x16::splat(simd, 0.0));
        }
        let shining = (dot(gradient, self.half_way).abs() * inverse).min(f32x16::splat(simd, 1.0));
        (diffuse, self.gloss(simd, shining) * surface * self.specular)
    }

    /// `shining^power`; whole powers by squaring.
    #[inline(always)]
    fn gloss<S: Simd>(&self, simd: S, shining: f32x16<S>) -> f32x16<S> {
        // Where the power would be below 2^-100, it is 2^-100: not denormal.
        let base = shining.max(f32x16::splat(simd, self.least_shining));
        if self.power.fract() != 0.0 || self.power > MOST_SQUARED {
            return exp2(simd, log2(simd, base) * self.power);
        }
        raised(base, self.power as u32, f32x16::splat(simd, 1.0))
    }

    /// Scalar version, for one pixel or splat.
    #[inline(always)]
    fn gloss_of(&self, shining: f32) -> f32 {
        let base = shining.max(self.least_shining);
        if self.power.fract() != 0.0 || self.power > MOST_SQUARED {
            return libm::powf(base, self.power);
        }
        raised(base, self.power as u32, 1.0)
    }

    /// Surfaceness of a gradient of this length, per world length.
    pub(crate) fn surfaceness(&self, gradient: f32) -> f32 {
        let squared = (gradient * self.spacing).powi(2);
        squared / (squared + self.floor_squared).max(LEAST_SQUARED)
    }

    /// Lighting of a surface of this surfaceness, with this normal (camera space, length 1).
    pub(crate) fn on_surface(&self, normal: [f32; 3], surfaceness: f32) -> Lit {
        let dot = |b: [f32; 3]| {
            (normal[0] * b[0] + normal[1] * b[1] + normal[2] * b[2])
                .abs()
                .min(1.0)
        };
        let facing = dot(self.towards_light);
        let shining = dot(self.half_way);
        Lit {
            diffuse: (surfaceness * (facing - 1.0) + 1.0) * self.diffuse + self.ambient,
            specular: self.gloss_of(shining) * surfaceness * self.specular,
        }
    }

    /// Lighting of material with this gradient (camera space, per world length).
    #[inline(always)]
    pub(crate) fn at(&self, gradient: [f32; 3]) -> Lit {
        let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let gradient = gradient.map(|g| g * self.spacing);
        let squared = dot(gradient, gradient);
        if squared <= FLAT * self.floor_squared {
            return Lit {
                diffuse: self.ambient + self.diffuse,
                specular: 0.0,
            };
        }
        let surface = squared / (squared + self.floor_squared);
        let inverse = 1.0 / squared.sqrt();
        let facing = (dot(gradient, self.towards_light) * inverse).abs().min(1.0);
        let shining = (dot(gradient, self.half_way) * inverse).abs().min(1.0);
        Lit {
            diffuse: self.ambient + self.diffuse * (1.0 - surface + surface * facing),
            specular: if self.specular == 0.0 {
                0.0
            } else {
                self.specular * surface * self.gloss_of(shining)
            },
        }
    }
}

/// A whole power, by squaring.
#[inline(always)]
fn raised<T: Copy + Mul<Output = T>>(base: T, power: u32, one: T) -> T {
    let (mut exponent, mut square, mut product) = (power, base, one);
    loop {
        if exponent & 1 != 0 {
            product = product * square;
        }
        exponent >>= 1;
        if exponent == 0 {
            return product;
        }
        square = square * square;
    }
}

#[inline(always)]
fn dot<S: Simd>(a: [f32x16<S>; 3], [x, y, z]: [f32; 3]) -> f32x16<S> {
    a[0] * x + a[1] * y + a[2] * z
}
