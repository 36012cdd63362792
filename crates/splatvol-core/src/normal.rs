//! The normal distribution: density, cumulative distribution, and moments of its slabs.

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

/// Mass, mean and variance of the standard normal between two bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlabMoments {
    /// Mass between the bounds.
    pub mass: f32,
    /// Mean of that mass.
    pub mean: f32,
    /// Variance about that mean.
    pub variance: f32,
}

/// Slab moments from a table of the distribution: a splat asks for two entries per sheet.
///
/// `mass = Phi(b) - Phi(a)`, `mean = (phi(a) - phi(b)) / mass`,
/// `variance = 1 + (a phi(a) - b phi(b)) / mass - mean^2`; the distribution is cut at `cut` and renormalised.
#[derive(Debug, Clone)]
pub struct SlabTable {
    cut: f32,
    entries: Vec<[f32; 2]>,
}

impl SlabTable {
    /// Cells per standard deviation; linear interpolation then errs by less than 1e-6.
    const RESOLUTION: f64 = 512.0;

    /// Table of the distribution cut at `cut` standard deviations.
    pub fn new(cut: f64) -> Self {
        let cells = (2.0 * cut * Self::RESOLUTION).ceil() as usize;
        let inside = mass_within(cut);
        let entry = |i: usize| {
            let x = -cut + 2.0 * cut * i as f64 / cells as f64;
            [
                ((cumulative(x) - cumulative(-cut)) / inside) as f32,
                (density(x) / inside) as f32,
            ]
        };
        Self {
            cut: cut as f32,
            entries: (0..=cells).map(entry).collect(),
        }
    }

    /// Moments between `a` and `b`, standard deviations; `None` where the cut leaves nothing.
    #[inline]
    pub fn between(&self, a: f32, b: f32) -> Option<SlabMoments> {
        let (a, b) = (a.max(-self.cut), b.min(self.cut));
        if a >= b {
            return None;
        }
        let ([phi_a, density_a], [phi_b, density_b]) = (self.at(a), self.at(b));
        let mass = phi_b - phi_a;
        if mass <= 1e-9 {
            return None;
        }
        let mean = ((density_a - density_b) / mass).clamp(a, b);
        let variance = 1.0 + (a * density_a - b * density_b) / mass - mean * mean;
        Some(SlabMoments {
            mass,
            mean,
            variance: variance.clamp(0.0, 0.25 * (b - a) * (b - a)),
        })
    }

    #[inline]
    fn at(&self, x: f32) -> [f32; 2] {
        let last = self.entries.len() - 1;
        let position = (x + self.cut) * (last as f32 / (2.0 * self.cut));
        let cell = (position as usize).min(last - 1);
        let t = position - cell as f32;
        let ([p0, d0], [p1, d1]) = (self.entries[cell], self.entries[cell + 1]);
        [p0 + t * (p1 - p0), d0 + t * (d1 - d0)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slabs_have_the_moments_of_the_integral() {
        let table = SlabTable::new(4.0);
        for (a, b) in [(-4.0, 4.0), (-0.3, 0.4), (1.0, 1.1), (2.0, 9.0), (-3.9, -3.0)] {
            let slab = table.between(a as f32, b as f32).unwrap();
            let (mut mass, mut first, mut second) = (0.0, 0.0, 0.0);
            let (low, high) = (f64::max(a, -4.0), f64::min(b, 4.0));
            let steps = 20_000;
            for i in 0..steps {
                let x = low + (high - low) * (f64::from(i) + 0.5) / f64::from(steps);
                let share = density(x) * (high - low) / f64::from(steps) / mass_within(4.0);
                mass += share;
                first += share * x;
                second += share * x * x;
            }
            let mean = first / mass;
            assert!((f64::from(slab.mass) - mass).abs() < 2e-6, "{a} {b}");
            assert!(
                (f64::from(slab.mean) - mean).abs() < 2e-3,
                "{a} {b} {} {mean}",
                slab.mean
            );
            assert!(
                (f64::from(slab.variance) - (second / mass - mean * mean)).abs() < 2e-2,
                "{a} {b}"
            );
        }
        assert!(table.between(4.5, 6.0).is_none());
    }

    #[test]
    fn slabs_that_tile_the_line_share_out_all_mass() {
        let table = SlabTable::new(4.3);
        let total: f32 = (-60..60)
            .filter_map(|i| table.between(i as f32 * 0.1, (i + 1) as f32 * 0.1))
            .map(|s| s.mass)
            .sum();
        assert!((total - 1.0).abs() < 1e-6);
    }
}
