//! Opacity by gradient as a curve that is edited like any other: gradient magnitudes are its values, factors its opacities
//! (Levoy 1988: flat regions fade, boundaries stay).

use splatvol::{ColorPoint, GradientOpacityPoint, OpacityPoint, SceneError, TransferFunction};

use super::Values;
use super::gradients::{Gradients, SIZE};

/// Where a curve that is begun rises, shares of the steepest gradient.
const RISE: [f64; 2] = [0.02, 0.2];

/// The curve of points.
///
/// # Errors
/// No points, or numbers that are not finite.
pub fn curve(points: &[GradientOpacityPoint]) -> Result<TransferFunction, SceneError> {
    let opacities = points
        .iter()
        .map(|point| OpacityPoint::new(point.gradient, point.factor));
    let white = ColorPoint::new(0.0, [1.0; 3]);
    TransferFunction::new(vec![white], opacities.collect(), None)
}

/// The points of a curve; gradients are magnitudes.
pub fn points(curve: &TransferFunction) -> Vec<GradientOpacityPoint> {
    let points = curve.opacities().iter();
    points
        .map(|point| GradientOpacityPoint {
            gradient: point.value.max(0.0),
            factor: point.opacity,
        })
        .collect()
}

/// A curve that leaves out what is flat, of data whose steepest gradient is given.
pub fn begun(steepest: f64) -> Vec<GradientOpacityPoint> {
    let [from, to] = RISE;
    [(from, 0.0), (to, 1.0)]
        .map(|(share, factor)| GradientOpacityPoint {
            gradient: share * steepest,
            factor,
        })
        .to_vec()
}

/// How often gradient magnitudes are met, whatever the values.
pub fn magnitudes(gradients: &Gradients) -> Values {
    let rows = gradients.counts.chunks_exact(SIZE[0]);
    Values {
        is_grid: false,
        range: [0.0, gradients.steepest],
        histogram: rows
            .map(|row| row.iter().map(|&count| u64::from(count)).sum())
            .collect(),
        spacing: 1.0,
        unit: "",
    }
}

#[cfg(test)]
mod tests {
    use splatvol::GradientOpacity;

    use super::*;
    use crate::model::curve as edits;

    #[test]
    fn a_curve_is_edited_and_read_back() {
        let begun = begun(50.0);
        assert!(GradientOpacity::new(&begun).is_ok());
        let shown = curve(&begun).unwrap();
        assert_eq!(points(&shown), begun);
        let (more, index) = edits::add_point(&shown, [30.0, 0.5]).unwrap();
        assert_eq!((index, points(&more)[2].gradient), (2, 30.0));
        // No gradient is negative.
        let left = edits::move_point(&more, 0, [-9.0, 0.2]).unwrap();
        assert_eq!((points(&left)[0].gradient, points(&left)[0].factor), (0.0, 0.2));
        assert!(GradientOpacity::new(&points(&left)).is_ok());
        assert!(curve(&[]).is_err());
    }

    #[test]
    fn magnitudes_are_counted_over_all_values() {
        let mut counts = vec![0; SIZE[0] * SIZE[1]];
        counts[..3].fill(7);
        *counts.last_mut().unwrap() = 5;
        let values = magnitudes(&Gradients {
            values: [3.0, 9.0],
            steepest: 20.0,
            counts,
        });
        assert_eq!((values.range, values.histogram.len()), ([0.0, 20.0], SIZE[1]));
        assert_eq!(
            (
                values.histogram[0],
                values.histogram[1],
                values.histogram[SIZE[1] - 1]
            ),
            (21, 0, 5)
        );
    }
}
