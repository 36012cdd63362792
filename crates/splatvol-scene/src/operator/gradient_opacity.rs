//! Gradient opacity: extinction scaled by a curve over the gradient's magnitude (Levoy 1988; VTK's
//! `SetGradientOpacity`).
//!
//! The factor multiplies the extinction, as it does VTK's opacity of short steps. Straight lines between points,
//! constant beyond the first and last; a magnitude given twice is a step.

use serde::{Deserialize, Serialize};

use super::{Appearance, PixelOperator, SheetSample, WgslOperator, wgsl};
use crate::SceneError;

/// A point of the curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GradientOpacityPoint {
    /// Magnitude of the gradient, data units per world length.
    pub gradient: f64,
    /// Factor of the extinction, 0 to 1.
    pub factor: f64,
}

/// Extinction scaled by the gradient's magnitude.
#[derive(Debug, Clone, PartialEq)]
pub struct GradientOpacity {
    /// Magnitude and factor.
    points: Vec<[f32; 2]>,
}

impl GradientOpacity {
    /// Curve through points, which are sorted.
    ///
    /// # Errors
    /// No points, magnitudes that are negative or not finite, or factors outside 0 to 1.
    pub fn new(points: &[GradientOpacityPoint]) -> Result<Self, SceneError> {
        if points.is_empty() {
            return Err(SceneError::invalid(
                "gradient opacity",
                points,
                "at least one point",
            ));
        }
        for point in points {
            if !(point.gradient.is_finite() && point.gradient >= 0.0 && (0.0..=1.0).contains(&point.factor)) {
                return Err(SceneError::invalid(
                    "gradient opacity",
                    point,
                    "a gradient of 0 or more and a factor from 0 to 1",
                ));
            }
        }
        let mut sorted = points.to_vec();
        sorted.sort_by(|a, b| a.gradient.total_cmp(&b.gradient));
        let points = sorted
            .iter()
            .map(|p| [p.gradient as f32, p.factor as f32])
            .collect();
        Ok(Self { points })
    }

    /// Factor for a magnitude.
    pub fn factor(&self, magnitude: f32) -> f32 {
        let next = self
            .points
            .partition_point(|[gradient, _]| *gradient <= magnitude);
        let after = self.points[next.min(self.points.len() - 1)];
        let before = self.points[next.saturating_sub(1)];
        let width = after[0] - before[0];
        if width > 0.0 {
            before[1] + (after[1] - before[1]) * ((magnitude - before[0]) / width)
        } else {
            before[1]
        }
    }
}

impl PixelOperator for GradientOpacity {
    fn apply(&self, sample: &SheetSample, appearance: &mut Appearance) {
        appearance.extinction *= self.factor(sample.gradient.length());
    }

    fn pieces(&self) -> usize {
        4
    }

    fn wgsl(&self) -> Option<WgslOperator> {
        let points = self
            .points
            .iter()
            .map(|&[gradient, factor]| [gradient, factor, 0.0, 0.0]);
        Some(WgslOperator {
            name: "gradient_opacity",
            texts: vec![wgsl::GRADIENT_OPACITY],
            operands: std::iter::once([self.points.len() as f32, 0.0, 0.0, 0.0])
                .chain(points)
                .collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(points: &[[f64; 2]]) -> Result<GradientOpacity, SceneError> {
        let points: Vec<_> = points
            .iter()
            .map(|&[gradient, factor]| GradientOpacityPoint { gradient, factor })
            .collect();
        GradientOpacity::new(&points)
    }

    #[test]
    fn factors_run_straight_between_points_and_stay_beyond() {
        let ramp = curve(&[[30.0, 1.0], [10.0, 0.2], [30.0, 0.5]]).unwrap();
        for (magnitude, factor) in [(0.0, 0.2), (10.0, 0.2), (20.0, 0.6), (30.0, 0.5), (99.0, 0.5)] {
            assert!((ramp.factor(magnitude) - factor).abs() < 1e-6, "{magnitude}");
        }
        assert_eq!(curve(&[[3.0, 0.7]]).unwrap().factor(1.0), 0.7);
        assert!(ramp.factor(f32::NAN).is_finite());
        for bad in [&[][..], &[[-1.0, 0.0]], &[[1.0, 1.5]], &[[f64::NAN, 0.5]]] {
            assert!(curve(bad).is_err(), "{bad:?}");
        }
    }
}
