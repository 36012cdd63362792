//! Colours of Gaussians seen from a direction: `max(0, 1/2 + sum_lm c_lm Y_lm(d))`.
//!
//! Real spherical harmonics to degree 3 as polynomials of a unit vector, with the signs of the published
//! implementation: those of quantum mechanics, with the Condon-Shortley phase. Sloan 2008, "Stupid Spherical
//! Harmonics Tricks", appendix A2.

use crate::Gaussians;

/// Harmonics of the highest degree.
const COUNT: usize = (Gaussians::MAX_DEGREE as usize + 1).pow(2);
/// Largest value of a colour; larger ones count as this.
const BRIGHTEST: f32 = 1e4;

/// Values of the harmonics in a direction (unit), in the order l = 0, 1, ..., m = -l..l; above `degree` left at zero.
#[inline(always)]
fn basis(degree: u32, [x, y, z]: [f32; 3]) -> [f32; COUNT] {
    let mut values = [0.0; COUNT];
    values[0] = 0.282_094_8;
    if degree >= 1 {
        const C: f32 = 0.488_602_52;
        values[1..4].copy_from_slice(&[-C * y, C * z, -C * x]);
    }
    let [xx, yy, zz] = [x * x, y * y, z * z];
    if degree >= 2 {
        const C: f32 = 1.092_548_5;
        let zonal = 0.315_391_57 * (2.0 * zz - xx - yy);
        let sectoral = 0.546_274_24 * (xx - yy);
        values[4..9].copy_from_slice(&[C * x * y, -C * y * z, zonal, -C * x * z, sectoral]);
    }
    if degree >= 3 {
        let ring = 4.0 * zz - xx - yy;
        values[9..16].copy_from_slice(&[
            -0.590_043_6 * y * (3.0 * xx - yy),
            2.890_611_4 * x * y * z,
            -0.457_045_8 * y * ring,
            0.373_176_34 * z * (2.0 * zz - 3.0 * xx - 3.0 * yy),
            -0.457_045_8 * x * ring,
            1.445_305_7 * z * (xx - yy),
            -0.590_043_6 * x * (xx - 3.0 * yy),
        ]);
    }
    values
}

/// Display colour of a Gaussian with coefficients `harmonics`, `(degree + 1)^2` of them, from a direction.
#[inline(always)]
pub fn color(degree: u32, harmonics: &[[f32; 3]], direction: [f32; 3]) -> [f32; 3] {
    let values = basis(degree, direction);
    let mut sum = [0.5f32; 3];
    for (value, coefficients) in values.iter().zip(harmonics) {
        for (sum, coefficient) in sum.iter_mut().zip(coefficients) {
            *sum += value * coefficient;
        }
    }
    // Sums of huge coefficients may be NaN, which is not above 0.
    sum.map(|channel| {
        if channel > 0.0 {
            channel.min(BRIGHTEST)
        } else {
            0.0
        }
    })
}
