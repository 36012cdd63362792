//! Real spherical harmonics to degree 3 with the constants and signs of the published implementation, and how
//! coefficients change when their frame is turned or mirrored.
//!
//! ```text
//! f(d) = sum_m c_m Y_m(d)      f'(R d) = f(d)      c'_j = sum_m c_m integral Y_j(R d) Y_m(d) dd
//! ```
//!
//! The harmonics of a degree are orthonormal and R maps them onto themselves; the integrand is a polynomial of at most
//! degree 6, for which four Gauss-Legendre nodes along z times eight angles are exact.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

/// The harmonic of degree 0, `1 / (2 sqrt(pi))`.
pub(crate) const DEGREE_0: f64 = 0.282_094_791_773_878_14;

/// Coefficients per colour of harmonics up to a degree.
pub(crate) fn harmonics_count(degree: u32) -> usize {
    (degree as usize + 1).pow(2)
}

/// All 16 harmonics in a unit direction, in the order l = 0, 1, 2, 3, m = -l..l.
pub(crate) fn basis(direction: DVec3) -> [f64; 16] {
    let DVec3 { x, y, z } = direction;
    let (xx, yy, zz) = (x * x, y * y, z * z);
    let d1 = (3.0 / (4.0 * PI)).sqrt();
    let d2 = (15.0 / PI).sqrt() / 2.0;
    let d3 = |number: f64| (number / PI).sqrt() / 4.0;
    [
        DEGREE_0,
        -d1 * y,
        d1 * z,
        -d1 * x,
        d2 * x * y,
        -d2 * y * z,
        (5.0 / PI).sqrt() / 4.0 * (2.0 * zz - xx - yy),
        -d2 * x * z,
        d2 / 2.0 * (xx - yy),
        -d3(17.5) * y * (3.0 * xx - yy),
        2.0 * d3(105.0) * x * y * z,
        -d3(10.5) * y * (4.0 * zz - xx - yy),
        d3(7.0) * z * (2.0 * zz - 3.0 * xx - 3.0 * yy),
        -d3(10.5) * x * (4.0 * zz - xx - yy),
        d3(105.0) * z * (xx - yy),
        -d3(17.5) * x * (xx - 3.0 * yy),
    ]
}

/// Matrices that turn coefficients along with their frame.
pub(crate) struct Turn([[f64; 16]; 16]);

impl Turn {
    /// Rotation of harmonics for an orthogonal matrix, which may mirror.
    pub(crate) fn new(new_from_old: DMat3) -> Self {
        let mut matrix = [[0.0; 16]; 16];
        for (direction, weight) in nodes() {
            let old = basis(direction);
            let new = basis(new_from_old * direction);
            for degree in 0..=3usize {
                let band = degree * degree..(degree + 1) * (degree + 1);
                for j in band.clone() {
                    for m in band.clone() {
                        matrix[j][m] += weight * new[j] * old[m];
                    }
                }
            }
        }
        Self(matrix)
    }

    /// Turns the coefficients of one Gaussian, of whole degrees.
    pub(crate) fn apply(&self, harmonics: &mut [[f32; 3]]) {
        let mut old = [[0.0; 3]; 16];
        for (old, new) in old.iter_mut().zip(harmonics.iter()) {
            *old = new.map(f64::from);
        }
        for degree in 0..=3usize {
            let band = degree * degree..(degree + 1) * (degree + 1);
            let Some(new) = harmonics.get_mut(band.clone()) else {
                return;
            };
            for (new, row) in new.iter_mut().zip(&self.0[band.clone()]) {
                let mut sum = [0.0; 3];
                for (weight, old) in row[band.clone()].iter().zip(&old[band.clone()]) {
                    for (sum, old) in sum.iter_mut().zip(old) {
                        *sum += weight * old;
                    }
                }
                *new = sum.map(|c| c as f32);
            }
        }
    }
}

/// Directions and weights that integrate polynomials of degree 7 over the sphere.
fn nodes() -> impl Iterator<Item = (DVec3, f64)> {
    // Gauss-Legendre with 4 nodes: z^2 = 3/7 -+ 2/7 sqrt(6/5), weights (18 +- sqrt(30)) / 36.
    let root = (6.0f64 / 5.0).sqrt() * 2.0 / 7.0;
    let inner = ((3.0 / 7.0 - root).sqrt(), (18.0 + 30f64.sqrt()) / 36.0);
    let outer = ((3.0 / 7.0 + root).sqrt(), (18.0 - 30f64.sqrt()) / 36.0);
    [
        (inner.0, inner.1),
        (-inner.0, inner.1),
        (outer.0, outer.1),
        (-outer.0, outer.1),
    ]
    .into_iter()
    .flat_map(|(z, weight)| {
        (0..8).map(move |step| {
            let (sin, cos) = (f64::from(step) * PI / 4.0 + 0.1).sin_cos();
            let radius = (1.0 - z * z).sqrt();
            (DVec3::new(radius * cos, radius * sin, z), weight * PI / 4.0)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    #[test]
    fn harmonics_are_orthonormal() {
        for j in 0..16 {
            for m in 0..16 {
                let sum: f64 = nodes().map(|(d, w)| w * basis(d)[j] * basis(d)[m]).sum();
                assert!(
                    (sum - f64::from(u8::from(j == m))).abs() < 1e-14,
                    "{j} {m}: {sum}"
                );
            }
        }
    }

    #[test]
    fn turned_coefficients_give_the_same_colour_in_the_turned_direction() {
        let rotation = DMat3::from_quat(DQuat::from_xyzw(0.1, -0.5, 0.7, 0.3).normalize());
        let mirror = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
        for matrix in [rotation, rotation * mirror] {
            let mut harmonics: Vec<[f32; 3]> = (0..16)
                .map(|i| [i as f32 - 7.0, (i * i % 11) as f32, 0.5])
                .collect();
            let old = harmonics.clone();
            Turn::new(matrix).apply(&mut harmonics);
            for direction in [DVec3::X, DVec3::new(1.0, 2.0, -3.0).normalize()] {
                for color in 0..3 {
                    let value = |c: &[[f32; 3]], d| -> f64 {
                        basis(d).iter().zip(c).map(|(y, c)| y * f64::from(c[color])).sum()
                    };
                    let difference = value(&old, direction) - value(&harmonics, matrix * direction);
                    assert!(difference.abs() < 1e-5, "{difference}");
                }
            }
        }
    }
}
