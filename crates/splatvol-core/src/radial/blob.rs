//! Generalised Kaiser-Bessel window of order m = 2, a "blob": Lewitt 1990 (Multidimensional digital image
//! representations using generalized Kaiser-Bessel window functions, J. Opt. Soc. Am. A 7(10)), window and line
//! integral.
//!
//! `h(r) = w I_2(alpha sqrt w) / I_2(alpha)`, `w = 1 - (r / a)^2`, and with `w` at `rho`
//! `int h dz = a sqrt(2 pi / alpha) w^(5/4) I_5/2(alpha sqrt w) / I_2(alpha)`.
//!
//! We write `I_v(x) = (x / 2)^v sum_k (x^2 / 4)^k / (k! Gamma(k + v + 1))`, so that both are entire functions of w
//! and alpha may be zero; the normalisation includes the factor `(alpha / 2)^2 / I_2(alpha)`.

use std::f64::consts::PI;

use super::quadrature::integral;

/// A blob without its normalisation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Blob {
    pub(super) radius: f64,
    pub(super) alpha: f64,
}

impl Blob {
    pub(super) fn value(&self, r: f64) -> f64 {
        let w = self.window(r * r);
        w * w * series(0.25 * self.alpha * self.alpha * w, 2.0) / 2.0
    }

    /// Half of the line integral.
    fn half_chord(&self, rho2: f64) -> f64 {
        let w = self.window(rho2);
        // Gamma(7/2) = 15 sqrt(pi) / 8.
        let first = 8.0 / (15.0 * PI.sqrt());
        let sum = first * series(0.25 * self.alpha * self.alpha * w, 2.5);
        0.5 * self.radius * PI.sqrt() * w * w * w.sqrt() * sum
    }

    /// `int_0^z h dz` at the squared distance from the axis, z within the support.
    pub(super) fn half_line(&self, rho2: f64, z: f64) -> f64 {
        if rho2 + z * z >= self.radius * self.radius {
            return self.half_chord(rho2);
        }
        integral(0.0, z, |z| self.value((rho2 + z * z).sqrt()))
    }

    fn window(&self, r2: f64) -> f64 {
        (1.0 - r2 / (self.radius * self.radius)).max(0.0)
    }
}

/// `sum_k y^k Gamma(v + 1) / (k! Gamma(k + v + 1))`.
fn series(y: f64, order: f64) -> f64 {
    let (mut term, mut sum, mut k) = (1.0, 1.0, 1.0);
    while term > 1e-17 * sum {
        term *= y / (k * (k + order));
        sum += term;
        k += 1.0;
    }
    sum
}
