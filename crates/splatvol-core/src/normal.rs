//! The normal distribution: density and cumulative distribution.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Standard normal density.
pub fn density(x: f64) -> f64 {
    libm::exp(-0.5 * x * x) / (2.0 * PI).sqrt()
}

/// Standard normal cumulative distribution.
pub fn cumulative(x: f64) -> f64 {
    0.5 * libm::erfc(-x * FRAC_1_SQRT_2)
}

/// Share of the mass within `cut` standard deviations.
pub fn mass_within(cut: f64) -> f64 {
    libm::erf(cut * FRAC_1_SQRT_2)
}
