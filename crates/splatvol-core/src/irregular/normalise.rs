//! Masses for which a constant field stays constant.
//!
//! One sweep divides each mass by the sum of all kernels at its centre: Jacobi's iteration for the sums to be 1, hastened
//! by steps of several lengths (Richardson's, with Chebyshev's steps; Varga, Matrix Iterative Analysis, chapter 5).

use glam::{DMat3, DVec3};

use super::Sample;

/// Squared distance in standard deviations beyond which a kernel is nothing: it has 0.1 % of its mass there.
pub(super) const REACH_SQUARED: f64 = 16.0;
/// Deviation of the sums that is left alone.
const TOLERANCE: f64 = 5e-4;

/// A kernel ready to be evaluated.
#[derive(Debug, Clone, Copy)]
pub(super) struct Evaluated {
    pub(super) position: DVec3,
    inverse: DMat3,
    /// Peak of the density for mass 1; 0 for samples without a kernel.
    peak: f64,
}

impl Evaluated {
    pub(super) fn new(sample: &Sample) -> Self {
        let determinant = sample.covariance.determinant();
        let legal = sample.valid && determinant > 0.0 && determinant.is_normal();
        let peak = match legal {
            true => ((2.0 * std::f64::consts::PI).powi(3) * determinant)
                .sqrt()
                .recip(),
            false => 0.0,
        };
        Self {
            position: sample.position,
            inverse: if legal {
                sample.covariance.inverse()
            } else {
                DMat3::ZERO
            },
            peak,
        }
    }

    /// Squared distance of an offset from the centre, in standard deviations.
    #[inline(always)]
    pub(super) fn distance_squared(&self, offset: DVec3) -> f64 {
        offset.dot(self.inverse * offset)
    }

    /// The density of mass 1 at an offset from the centre.
    #[inline(always)]
    pub(super) fn density(&self, offset: DVec3) -> f64 {
        let distance_squared = self.distance_squared(offset);
        if distance_squared > REACH_SQUARED {
            return 0.0;
        }
        self.peak * libm::exp(-0.5 * distance_squared)
    }

    pub(super) fn is_legal(&self) -> bool {
        self.peak > 0.0
    }
}

/// Divides masses by powers of what `sums` finds for them until the sums are 1, once per step at most.
///
/// Near the solution a step multiplies each mode of the error by `1 - step * eigenvalue`; the eigenvalues are those of the
/// matrix of the kernels at the centres, 1 for what is smooth and near 0 for what no kernel resolves.
pub(super) fn sweep(samples: &mut [Sample], steps: &[f64], sums: impl Fn(&[Sample]) -> Vec<Correction>) {
    for &step in steps {
        let found = sums(samples);
        let mut largest = 0.0f64;
        for (sample, correction) in samples.iter_mut().zip(&found) {
            let (sum, step) = match *correction {
                Correction::Full(sum) if sum > 0.0 => (sum.clamp(0.5, 2.0), step),
                Correction::Excess(sum) => (sum.max(1.0), step.min(1.0)),
                Correction::Full(_) => (1.0, 1.0),
            };
            sample.mass *= libm::pow(sum, -step);
            largest = largest.max((sum - 1.0).abs());
        }
        if largest < TOLERANCE {
            return;
        }
    }
}

/// The sum of all kernels at a sample.
#[derive(Debug, Clone, Copy)]
pub(super) enum Correction {
    /// It should be 1.
    Full(f64),
    /// It should not be above 1: beside a border.
    Excess(f64),
}

impl Correction {
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
