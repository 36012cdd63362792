//! Normalisation of masses, so that a constant field stays constant.
//!
//! One sweep divides each mass by the sum of all kernels at its centre. This is Jacobi's iteration for sums of 1,
//! accelerated by steps of varying lengths (Richardson's, with Chebyshev's steps; Varga, Matrix Iterative Analysis,
//! chapter 5).

use rayon::prelude::*;

/// Squared distance, in standard deviations, at which a kernel is cut: 0.1 % of its mass lies beyond.
pub(super) const REACH_SQUARED: f64 = 16.0;
/// Tolerated deviation of the sums.
const TOLERANCE: f64 = 5e-4;

/// Divides the masses of some samples, the places, by powers of the sums from `sums` until these are 1, at most
/// once per step.
///
/// Near the solution a step multiplies each mode of the error by `1 - step * eigenvalue`. The eigenvalues are those
/// of the matrix of the kernels at the centres: 1 for smooth modes, and near 0 for modes that no kernel resolves.
pub(super) fn sweep(
    masses: &mut [f64],
    places: &[u32],
    steps: &[f64],
    sums: impl Fn(&[f64]) -> Vec<Correction>,
) {
    for &step in steps {
        let found = sums(masses);
        let divisors: Vec<(f64, f64)> = found.par_iter().map(|found| found.divisor(step)).collect();
        for (&place, (divisor, _)) in places.iter().zip(&divisors) {
            masses[place as usize] /= divisor;
        }
        if divisors.iter().all(|(_, deviation)| *deviation < TOLERANCE) {
            return;
        }
    }
}

/// The sum of all kernels at a sample.
#[derive(Debug, Clone, Copy)]
pub(super) enum Correction {
    /// It should be 1.
    Full(f64),
    /// It should not exceed 1: beside a border.
    Excess(f64),
}

impl Correction {
    /// An empty sum, for a sample beside a border or inside.
    pub(super) fn beside(border: bool) -> Self {
        match border {
            true => Self::Excess(0.0),
            false => Self::Full(0.0),
        }
    }

    /// Divisor of a mass in a step, and the deviation of the sum from its target.
    fn divisor(self, step: f64) -> (f64, f64) {
        let (sum, step) = match self {
            Self::Full(sum) if sum > 0.0 => (sum.clamp(0.5, 2.0), step),
            Self::Excess(sum) => (sum.max(1.0), step.min(1.0)),
            Self::Full(_) => (1.0, 1.0),
        };
        (libm::pow(sum, step), (sum - 1.0).abs())
    }

    /// Whether the sum is right enough.
    pub(super) fn is_right(self) -> bool {
        match self {
            Self::Full(sum) => (sum - 1.0).abs() < TOLERANCE,
            Self::Excess(sum) => sum - 1.0 < TOLERANCE,
        }
    }

    /// With more added to the sum.
    pub(super) fn plus(self, more: f64) -> Self {
        match self {
            Self::Full(sum) => Self::Full(sum + more),
            Self::Excess(sum) => Self::Excess(sum + more),
        }
    }
}
