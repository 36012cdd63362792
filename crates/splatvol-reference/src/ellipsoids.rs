//! Clouds of Gaussian ellipsoids: the emission-absorption integral of a sum of kernels, point by point.
//!
//! Along the ray `x(t)` through a pixel's centre
//!
//! `C = int e(t) exp(-int_0^t k(s) ds) dt`, `k(t) = sum_i m_i N(x(t); u_i, V_i)`,
//! `e(t) = sum_i m_i c_i N(x(t); u_i, V_i)`,
//!
//! by the midpoint rule with steps that are short against the narrowest kernel on the ray (zwicker2001 eq. 1 and 9,
//! with no low-pass, no footprint and no order of splats).
//!
//! Samples of a field, of mass m and coefficient a, are integrated the same way ([`field_picture`]): with
//! `W = sum_i m_i N(x; u_i, V_i)` and `S = sum_i m_i a_i N(x; u_i, V_i)` the field is `v = S / W`, with
//! `k = min(W, 1) kappa(v)` and `e = k c(v)`.

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;
use splatvol_scene::{Camera, Image, ImageSize, TransferFunction};

/// A kernel of material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ellipsoid {
    /// Centre, world.
    pub centre: DVec3,
    /// Covariance, world, not singular.
    pub covariance: DMat3,
    /// Extinction integrated over space, world length squared.
    pub mass: f64,
    /// Linear rgb.
    pub color: [f64; 3],
}

/// A sample of a field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Centre, world.
    pub centre: DVec3,
    /// Covariance, world, not singular.
    pub covariance: DMat3,
    /// The volume that it stands for, world.
    pub mass: f64,
    /// Coefficient of its kernel.
    pub coefficient: f64,
}

/// Standard deviations beyond which a kernel is left out.
const CUT: f64 = 6.0;
/// Steps per standard deviation of the narrowest kernel on a ray.
const STEPS_PER_SIGMA: f64 = 24.0;

/// A kernel on a ray: `peak exp(-(t - middle)^2 / (2 sigma^2))`.
struct OnRay {
    peak: f64,
    middle: f64,
    sigma: f64,
    color: [f64; 3],
}

impl Ellipsoid {
    /// The mass of a kernel whose line integral through its centre, along a direction of length one, is
    /// `optical_depth`.
    pub fn mass_of_peak(covariance: DMat3, direction: DVec3, optical_depth: f64) -> f64 {
        let along = direction.dot(covariance.inverse() * direction);
        // int N = 1 / (2 pi sqrt(|V| d^T V^-1 d)).
        optical_depth * std::f64::consts::TAU * (covariance.determinant() * along).sqrt()
    }

    fn on_ray(&self, origin: DVec3, direction: DVec3) -> Option<OnRay> {
        let conic = self.covariance.inverse();
        let from = origin - self.centre;
        let along = direction.dot(conic * direction);
        let middle = -direction.dot(conic * from) / along;
        let nearest = from + direction * middle;
        let squared = nearest.dot(conic * nearest);
        let norm = (std::f64::consts::TAU.powi(3) * self.covariance.determinant()).sqrt();
        (squared < CUT * CUT).then(|| OnRay {
            peak: self.mass / norm * (-0.5 * squared).exp(),
            middle,
            sigma: along.sqrt().recip(),
            color: self.color,
        })
    }
}

/// A picture of kernels: premultiplied linear rgb, and alpha.
pub fn picture(ellipsoids: &[Ellipsoid], camera: &Camera, size: ImageSize) -> Image {
    picture_of(ellipsoids, camera, size, |extinction, emission| {
        (extinction, emission)
    })
}

/// A picture of a field's samples, classified behind their kernels, unlit. Opacities refer to `unit_distance`, world.
pub fn field_picture(
    samples: &[Sample],
    (transfer_function, unit_distance): (&TransferFunction, f64),
    camera: &Camera,
    size: ImageSize,
) -> Image {
    let weighted = |sample: &Sample| Ellipsoid {
        centre: sample.centre,
        covariance: sample.covariance,
        mass: sample.mass,
        color: [sample.coefficient, 0.0, 0.0],
    };
    let ellipsoids: Vec<Ellipsoid> = samples.iter().map(weighted).collect();
    picture_of(&ellipsoids, camera, size, |weight, [sum, ..]| {
        let value = sum / weight;
        let extinction = weight.min(1.0) * transfer_function.extinction(value, unit_distance);
        let color = transfer_function.linear_color(value);
        (extinction, color.map(|level| extinction * level))
    })
}

/// A picture whose extinction and emission are what `material` makes of the kernels' sums.
fn picture_of(
    ellipsoids: &[Ellipsoid],
    camera: &Camera,
    size: ImageSize,
    material: impl Fn(f64, [f64; 3]) -> (f64, [f64; 3]) + Sync,
) -> Image {
    let screen = camera.screen_from_camera(size);
    let world_from_camera = camera.camera_from_world().inverse();
    let mut image = Image::filled(size, [0.0; 4]);
    let width = size.width() as usize;
    image
        .pixels
        .par_iter_mut()
        .enumerate()
        .for_each(|(index, pixel)| {
            let at = DVec2::new((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
            let (origin, direction) = screen.ray(at);
            let direction = world_from_camera.transform_vector3(direction).normalize();
            let origin = world_from_camera.transform_point3(origin);
            *pixel = integral(ellipsoids, (origin, direction), &material).map(|value| value as f32);
        });
    image
}

/// Colour and opacity integrated along a ray from its origin.
fn integral(
    ellipsoids: &[Ellipsoid],
    (origin, direction): (DVec3, DVec3),
    material: impl Fn(f64, [f64; 3]) -> (f64, [f64; 3]),
) -> [f64; 4] {
    let met: Vec<OnRay> = ellipsoids
        .iter()
        .filter_map(|ellipsoid| ellipsoid.on_ray(origin, direction))
        .filter(|kernel| kernel.middle + CUT * kernel.sigma > 0.0)
        .collect();
    let bound = |pick: fn(f64, f64) -> f64, side: f64, start: f64| {
        met.iter()
            .map(|kernel| kernel.middle + side * CUT * kernel.sigma)
            .fold(start, pick)
    };
    let from = bound(f64::min, -1.0, f64::INFINITY).max(0.0);
    let to = bound(f64::max, 1.0, 0.0);
    let narrowest = met
        .iter()
        .map(|kernel| kernel.sigma)
        .fold(f64::INFINITY, f64::min);
    if met.is_empty() || to <= from {
        return [0.0; 4];
    }
    let steps = ((to - from) / narrowest * STEPS_PER_SIGMA).ceil();
    let step = (to - from) / steps;
    let (mut through, mut color) = (1.0, [0.0; 3]);
    for i in 0..steps as usize {
        let t = from + (i as f64 + 0.5) * step;
        let (mut density_sum, mut color_sum) = (0.0, [0.0; 3]);
        for kernel in &met {
            let z = (t - kernel.middle) / kernel.sigma;
            let density = kernel.peak * (-0.5 * z * z).exp();
            density_sum += density;
            for (sum, level) in color_sum.iter_mut().zip(kernel.color) {
                *sum += density * level;
            }
        }
        if density_sum <= 0.0 {
            continue;
        }
        let (extinction, emission) = material(density_sum, color_sum);
        if extinction > 0.0 {
            let opacity = -(-extinction * step).exp_m1();
            for (sum, emission) in color.iter_mut().zip(emission) {
                *sum += through * opacity * emission / extinction;
            }
            through *= 1.0 - opacity;
        }
    }
    let [r, g, b] = color;
    [r, g, b, 1.0 - through]
}

#[cfg(test)]
mod tests {
    use splatvol_scene::Projection;

    use super::*;

    /// One kernel's opacity is known: `1 - exp(-m / (2 pi sqrt|C|))` through its centre, C its section across the ray.
    #[test]
    fn a_kernel_alone_is_as_opaque_as_its_line_integral() {
        let covariance = DMat3::from_diagonal(DVec3::new(0.04, 0.25, 1.0));
        let ellipsoid = Ellipsoid {
            centre: DVec3::ZERO,
            covariance,
            mass: Ellipsoid::mass_of_peak(covariance, DVec3::Z, 1.3),
            color: [0.5, 0.25, 1.0],
        };
        let camera = Camera::new(
            DVec3::new(0.0, 0.0, -9.0),
            DVec3::ZERO,
            DVec3::Y,
            Projection::Orthographic { height: 4.0 },
        )
        .unwrap();
        let size = ImageSize::new(1, 1).unwrap();
        let found = picture(&[ellipsoid], &camera, size).pixels[0];
        let alpha = 1.0 - (-1.3f64).exp();
        for (found, expected) in found.into_iter().zip([0.5 * alpha, 0.25 * alpha, alpha, alpha]) {
            assert!((f64::from(found) - expected).abs() < 1e-6, "{found} {expected}");
        }
    }
}
