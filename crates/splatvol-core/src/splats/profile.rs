//! Profile: the radial profile of a footprint.
//!
//! A ray that passes a kernel of unit variance at the distance r has the line integral `q(r^2)`. A footprint stores
//! its own height, so a [`Profile`] consists of `q(r^2) / q(0)` and of the peak `q(0)` of the kernel of unit
//! integral. The part of the kernel between two depths `t0` and `t1`, in standard deviations behind the point of
//! the ray nearest to the centre, is huang2000's kernel section as a function.

use crate::normal;

/// Line integrals of a radial kernel with unit variance and unit integral, by the squared distance in standard
/// deviations.
pub trait Profile: Sync {
    /// Cut of the profile, standard deviations.
    fn cut(&self) -> f32;

    /// Line integral through the centre.
    fn peak(&self) -> f32;

    /// Line integral at a squared distance, over that through the centre; zero beyond the cut.
    fn whole(&self, squared: f32) -> f32;

    /// The part of it between two depths, standard deviations.
    fn between(&self, squared: f32, near: f32, far: f32) -> f32;

    /// Mean of `whole(across^2 + x^2)` over x within half of `length` on either side of `along`: a footprint in
    /// motion. By Gauss-Legendre quadrature, unless the profile has a closed form.
    #[inline(always)]
    fn mean_along(&self, across_squared: f32, along: f32, length: f32) -> f32 {
        let Some([from, to]) = chord(self.cut(), across_squared, [along, length]) else {
            return 0.0;
        };
        let middle = 0.5 * (from + to);
        let halves = [[from, middle], [middle, to]];
        let sum: f32 = halves
            .into_iter()
            .map(|part| {
                let (centre, half) = (0.5 * (part[0] + part[1]), 0.5 * (part[1] - part[0]));
                GAUSS_LEGENDRE.iter().fold(0.0, |sum, &[node, weight]| {
                    let [left, right] = [centre - half * node, centre + half * node];
                    let ends =
                        self.whole(across_squared + left * left) + self.whole(across_squared + right * right);
                    sum + weight * half * ends
                })
            })
            .sum();
        // For so short a way, little would be left after rounding.
        if length > SHORT {
            sum / length
        } else {
            sum / (to - from).max(1e-20)
        }
    }

    /// That part as a share of the whole.
    #[inline(always)]
    fn share(&self, squared: f32, near: f32, far: f32) -> f32 {
        let whole = self.whole(squared);
        if whole > 0.0 {
            self.between(squared, near, far) / whole
        } else {
            0.0
        }
    }

    /// Whether the share between two depths is the same at every distance.
    fn is_separable(&self) -> bool;

    /// `whole` of a row of squared distances, in place.
    #[inline(always)]
    fn whole_row(&self, row: &mut [f32]) {
        for value in row {
            *value = self.whole(*value);
        }
    }
}

/// Nodes and weights on (0, 1) of the rule of eight points on (-1, 1).
const GAUSS_LEGENDRE: [[f32; 2]; 4] = [
    [0.183_434_65, 0.362_683_8],
    [0.525_532_4, 0.313_706_65],
    [0.796_666_5, 0.222_381_03],
    [0.960_289_9, 0.101_228_54],
];

/// Ways along which a profile hardly changes, standard deviations.
const SHORT: f32 = 1e-2;

/// The part within the cut of a way past the centre.
#[inline(always)]
fn chord(cut: f32, across_squared: f32, [along, length]: [f32; 2]) -> Option<[f32; 2]> {
    let half = (cut * cut - across_squared).max(0.0).sqrt();
    let (from, to) = (
        (along - 0.5 * length).max(-half),
        (along + 0.5 * length).min(half),
    );
    (from <= to && half > 0.0).then_some([from, to])
}

/// A cut Gaussian: less its value at the cut so that it ends without a step, with its mass kept, or as it is. In depth
/// it is the normal distribution within the cut.
#[derive(Debug, Clone)]
pub struct GaussianProfile {
    cut: f32,
    cut_squared: f32,
    peak: f32,
    /// Edge subtracted from the profile, and the scale that then makes the centre 1.
    edge: f32,
    scale: f32,
    /// Integral of the cut part of `exp(-r^2 / 2)` over a line through the centre.
    line: f32,
    cumulative: Vec<f32>,
}

/// Ways, in standard deviations, that are integrated by three points of Gauss: differences of the distribution would be
/// as small as its table's errors.
const QUADRATURE: f32 = 0.5;
/// Distance of the outer two of these points from the middle, in lengths of the way: half the root of 3/5.
const OUTER_NODE: f32 = 0.387_298_33;

/// Cells of the distribution per standard deviation.
const RESOLUTION: f32 = 256.0;

impl GaussianProfile {
    /// The Gaussian cut at `cut` standard deviations, without a step.
    pub fn new(cut: f64) -> Self {
        let edge = libm::exp(-0.5 * cut * cut);
        // The integral of exp(-r^2 / 2) - edge over the disc.
        let integral = 2.0 * std::f64::consts::PI * ((1.0 - edge) - 0.5 * edge * cut * cut);
        Self::with_edge(cut, edge, (1.0 - edge) / integral)
    }

    /// The Gaussian as it is within `cut` standard deviations, and nothing beyond (zwicker2001 section 6).
    pub fn raw(cut: f64) -> Self {
        Self::with_edge(cut, 0.0, 1.0 / (2.0 * std::f64::consts::PI))
    }

    fn with_edge(cut: f64, edge: f64, peak: f64) -> Self {
        let cells = (2.0 * cut * f64::from(RESOLUTION)).ceil() as usize;
        let inside = normal::mass_within(cut);
        let node = |i: usize| {
            let t = i as f64 / f64::from(RESOLUTION) - cut;
            ((normal::cumulative(t.min(cut)) - normal::cumulative(-cut)) / inside) as f32
        };
        Self {
            cut: cut as f32,
            cut_squared: (cut * cut) as f32,
            peak: peak as f32,
            edge: edge as f32,
            scale: (1.0 / (1.0 - edge)) as f32,
            line: ((2.0 * std::f64::consts::PI).sqrt() * inside) as f32,
            cumulative: (0..=cells + 1).map(node).collect(),
        }
    }

    #[inline(always)]
    fn below(&self, t: f32) -> f32 {
        let position = (t.clamp(-self.cut, self.cut) + self.cut) * RESOLUTION;
        let cell = position as usize;
        match self.cumulative.get(cell..cell + 2) {
            Some(&[low, high]) => low + (position - cell as f32) * (high - low),
            _ => 1.0,
        }
    }
}

impl Profile for GaussianProfile {
    #[inline(always)]
    fn cut(&self) -> f32 {
        self.cut
    }

    #[inline(always)]
    fn peak(&self) -> f32 {
        self.peak
    }

    #[inline(always)]
    fn whole(&self, squared: f32) -> f32 {
        if squared >= self.cut_squared {
            return 0.0;
        }
        ((libm::expf(-0.5 * squared) - self.edge) * self.scale).max(0.0)
    }

    #[inline(always)]
    fn between(&self, squared: f32, near: f32, far: f32) -> f32 {
        self.whole(squared) * (self.below(far) - self.below(near))
    }

    #[inline(always)]
    fn share(&self, _squared: f32, near: f32, far: f32) -> f32 {
        self.below(far) - self.below(near)
    }

    /// Closed form (`splats::moving`), less the edge.
    #[inline(always)]
    fn mean_along(&self, across_squared: f32, along: f32, length: f32) -> f32 {
        let Some([from, to]) = chord(self.cut, across_squared, [along, length]) else {
            return 0.0;
        };
        if length < SHORT {
            return self.whole(across_squared + along * along);
        }
        let across = libm::expf(-0.5 * across_squared);
        let passed = if length < QUADRATURE {
            let (middle, step) = (0.5 * (from + to), OUTER_NODE * (to - from));
            let at = |x: f32| libm::expf(-0.5 * x * x);
            (to - from) / 18.0 * (8.0 * at(middle) + 5.0 * (at(middle - step) + at(middle + step)))
        } else {
            self.line * (self.below(to) - self.below(from))
        };
        ((across * passed - self.edge * (to - from)) * self.scale).max(0.0) / length
    }

    #[inline(always)]
    fn is_separable(&self) -> bool {
        true
    }

    /// By a polynomial for the fraction of the exponent to base 2, relative error 3e-6, in operations that exist
    /// for vectors.
    #[inline(always)]
    fn whole_row(&self, row: &mut [f32]) {
        /// Added, it leaves the nearest integer in the lowest bits.
        const ROUND: f32 = 12_582_912.0;
        const TO_EXPONENT: f32 = -0.5 * std::f32::consts::LOG2_E;
        for value in row {
            let x = (*value * TO_EXPONENT).max(-126.0);
            let shifted = x + ROUND;
            let r = x - (shifted - ROUND);
            let mut p = 9.582_853e-3;
            for coefficient in [5.590_642_5e-2, 2.402_41e-1, 6.931_242e-1, 1.0] {
                p = p * r + coefficient;
            }
            let power = f32::from_bits(p.to_bits().wrapping_add(shifted.to_bits() << 23));
            let inside = *value < self.cut_squared;
            *value = if inside {
                ((power - self.edge) * self.scale).max(0.0)
            } else {
                0.0
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_disc_holds_all_mass_and_ends_without_a_step() {
        for cut in [2.0, 3.125, 5.0] {
            let profile = GaussianProfile::new(cut);
            let steps = 20_000;
            let mass: f64 = (0..steps)
                .map(|i| {
                    let r = cut * (f64::from(i) + 0.5) / f64::from(steps);
                    2.0 * std::f64::consts::PI * r * f64::from(profile.whole((r * r) as f32)) * cut
                        / f64::from(steps)
                })
                .sum();
            assert!(
                (mass * f64::from(profile.peak()) - 1.0).abs() < 1e-5,
                "{cut}: {mass}"
            );
            assert!(profile.whole((cut * cut) as f32) < 1e-6);
            assert_eq!(profile.whole(1000.0), 0.0);
        }
    }

    /// zwicker2001 section 6 evaluates the Gaussian where `r^2 < c`, here 4, and nothing beyond. Integrated over the disc
    /// in polar coordinates it has the mass `1 - exp(-2)` and the width `sqrt(1 - 2 exp(-2) / (1 - exp(-2)))` of its own.
    #[test]
    fn the_raw_cut_is_as_high_and_as_wide_as_the_paper_s() {
        let profile = GaussianProfile::raw(2.0);
        let steps = 20_000;
        let (mut mass, mut second) = (0.0, 0.0);
        for i in 0..steps {
            let r = 2.5 * (f64::from(i) + 0.5) / f64::from(steps);
            let mut row = [(r * r) as f32];
            let ring = 2.0 * std::f64::consts::PI * r * 2.5 / f64::from(steps);
            let height = f64::from(profile.whole(row[0])) * f64::from(profile.peak());
            profile.whole_row(&mut row);
            let of_row = f64::from(row[0]) * f64::from(profile.peak());
            assert!((height - of_row).abs() < 1e-6, "{r}: {height} {of_row}");
            mass += height * ring;
            second += 0.5 * r * r * height * ring;
        }
        let lost = (-2.0_f64).exp();
        let width = (second / mass).sqrt();
        assert!((mass - (1.0 - lost)).abs() < 1e-4, "{mass}");
        assert!(
            (width - (1.0 - 2.0 * lost / (1.0 - lost)).sqrt()).abs() < 1e-4,
            "{width}"
        );
        assert!((width - 0.829).abs() < 5e-4, "{width}");
    }

    #[test]
    fn sections_add_up_and_follow_the_normal_distribution() {
        let profile = GaussianProfile::new(4.0);
        let bounds = [-9.0, -1.7, -0.4, 0.3, 2.2, 8.0f32];
        let sum: f32 = bounds.windows(2).map(|w| profile.between(0.5, w[0], w[1])).sum();
        assert!((sum - profile.whole(0.5)).abs() < 1e-6);
        let exact = (normal::cumulative(0.3) - normal::cumulative(-0.4)) / normal::mass_within(4.0);
        let found = f64::from(profile.between(0.0, -0.4, 0.3));
        assert!((found - exact).abs() < 2e-6, "{found} {exact}");
    }
}
