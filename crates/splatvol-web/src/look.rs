//! Changes of a transfer function: another range, more or less of it, other colours or another curve.
//!
//! They apply to the transfer function as it was opened, not to each other: what is taken back leaves no trace.

use serde::{Deserialize, Serialize};
use splatvol::transfer_function::{ColorMap, OpacityCurve};
use splatvol::{SceneError, TransferFunction};

/// Changes of a transfer function. What is absent stays as it is.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct LookEdit {
    /// Data values that the least and the largest value of its points become; those between move along.
    pub range: Option<[f64; 2]>,
    /// Factor on optical depths.
    pub strength: Option<f64>,
    /// Colour map over the range, instead of its own colours.
    pub cmap: Option<String>,
    /// Opacity curve over the range, instead of its own.
    pub opacity: Option<String>,
}

/// The least and the largest value of a transfer function's points.
pub(crate) fn range(function: &TransferFunction) -> [f64; 2] {
    let colors = function.colors().iter().map(|point| point.value);
    let values = colors.chain(function.opacities().iter().map(|point| point.value));
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
        [low.min(value), high.max(value)]
    })
}

impl LookEdit {
    /// The transfer function with these changes. `spacing`: the length to which opacities refer if it does not say, world.
    ///
    /// # Errors
    /// Names that there are not, ranges that are empty or not finite, strengths that are not positive.
    pub fn apply(&self, base: &TransferFunction, spacing: f64) -> Result<TransferFunction, SceneError> {
        let old = range(base);
        let new = self.range.unwrap_or(old);
        if !(new[0] <= new[1] && new.iter().all(|value| value.is_finite())) {
            return Err(SceneError::invalid("range", new, "two finite values in order"));
        }
        let moved = |value: f64| match self.range {
            Some(_) if old[1] > old[0] => new[0] + (value - old[0]) / (old[1] - old[0]) * (new[1] - new[0]),
            Some(_) => 0.5 * (new[0] + new[1]),
            None => value,
        };
        let mut colors = base.colors().to_vec();
        let mut opacities = base.opacities().to_vec();
        colors
            .iter_mut()
            .for_each(|point| point.value = moved(point.value));
        opacities
            .iter_mut()
            .for_each(|point| point.value = moved(point.value));
        if let Some(name) = &self.cmap {
            colors = ColorMap::from_name(name)?.points(new, ColorMap::DEFAULT_POINTS);
        }
        if let Some(name) = &self.opacity {
            opacities = OpacityCurve::from_name(name)?.points(new);
        }
        let unit_distance = match self.strength {
            None => base.unit_distance,
            Some(strength) if strength > 0.0 && strength.is_finite() => {
                Some(base.unit_distance.unwrap_or(spacing) / strength)
            }
            Some(strength) => return Err(SceneError::invalid("strength", strength, "a positive factor")),
        };
        TransferFunction::new(colors, opacities, unit_distance)
    }
}

#[cfg(test)]
mod tests {
    use splatvol::{ColorPoint, OpacityPoint};

    use super::*;

    fn base() -> TransferFunction {
        let colors = vec![
            ColorPoint::new(10.0, [1.0, 0.0, 0.0]),
            ColorPoint::new(30.0, [0.0; 3]),
        ];
        let opacities = vec![OpacityPoint::new(0.0, 0.0), OpacityPoint::new(40.0, 0.5)];
        TransferFunction::new(colors, opacities, None).unwrap()
    }

    #[test]
    fn nothing_asked_for_changes_nothing() {
        assert_eq!(LookEdit::default().apply(&base(), 2.0).unwrap(), base());
        assert_eq!(range(&base()), [0.0, 40.0]);
    }

    #[test]
    fn a_range_moves_points_and_strength_multiplies_optical_depth() {
        let edit = LookEdit {
            range: Some([100.0, 180.0]),
            strength: Some(4.0),
            ..LookEdit::default()
        };
        let edited = edit.apply(&base(), 2.0).unwrap();
        assert_eq!(range(&edited), [100.0, 180.0]);
        assert_eq!(edited.colors()[0].value, 120.0);
        assert_eq!(edited.unit_distance, Some(0.5));
        let ratio = edited.extinction(140.0, 0.5) / base().extinction(20.0, 2.0);
        assert!((ratio - 4.0).abs() < 1e-12, "{ratio}");
    }

    #[test]
    fn named_colours_and_curves_span_the_range() {
        let edit = LookEdit {
            range: Some([0.0, 1.0]),
            cmap: Some("gray".to_owned()),
            opacity: Some("linear_r".to_owned()),
            ..LookEdit::default()
        };
        let edited = edit.apply(&base(), 1.0).unwrap();
        assert!((edited.color(0.5)[0] - 0.5).abs() < 0.01 && edited.opacity(0.25) == 0.75);
    }

    #[test]
    fn what_has_no_meaning_is_refused() {
        let refused = |edit: LookEdit| edit.apply(&base(), 1.0).is_err();
        for range in [[2.0, 1.0], [f64::NAN, 1.0], [0.0, f64::INFINITY]] {
            assert!(refused(LookEdit {
                range: Some(range),
                ..LookEdit::default()
            }));
        }
        for strength in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(refused(LookEdit {
                strength: Some(strength),
                ..LookEdit::default()
            }));
        }
        assert!(refused(LookEdit {
            cmap: Some("mauve".to_owned()),
            ..LookEdit::default()
        }));
        assert!(refused(LookEdit {
            opacity: Some("steep".to_owned()),
            ..LookEdit::default()
        }));
    }
}
