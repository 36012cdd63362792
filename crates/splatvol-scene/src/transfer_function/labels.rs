//! Transfer functions of label volumes, whose values are names of kinds: a colour and an opacity each.

use super::TransferFunction;
use crate::{ColorPoint, OpacityPoint, SceneError};

/// The look of a label.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Label {
    /// Its value.
    pub value: f64,
    /// sRGB, 0..1.
    pub rgb: [f64; 3],
    /// Opacity per unit distance, 0..1.
    pub opacity: f64,
}

impl TransferFunction {
    /// A band of its own colour and opacity for every label, which reaches halfway to its neighbours. `labels`: by ascending values.
    ///
    /// # Errors
    /// See [`TransferFunction::new`].
    pub fn of_labels(labels: &[Label], unit_distance: Option<f64>) -> Result<Self, SceneError> {
        let (colors, opacities) = bands(labels);
        Self::new(colors, opacities, unit_distance)
    }
}

/// Points at both ends of each label's band.
pub(super) fn bands(labels: &[Label]) -> (Vec<ColorPoint>, Vec<OpacityPoint>) {
    let (mut colors, mut opacities) = (Vec::new(), Vec::new());
    for (index, &Label { value, rgb, opacity }) in labels.iter().enumerate() {
        let halfway = |other: Option<&Label>| other.map_or(value, |other| 0.5 * (other.value + value));
        let low = halfway(index.checked_sub(1).map(|before| &labels[before]));
        let high = halfway(labels.get(index + 1));
        for end in [low, high] {
            colors.push(ColorPoint::new(end, rgb));
            opacities.push(OpacityPoint::new(end, opacity));
        }
    }
    (colors, opacities)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_label_has_its_own_look_and_no_other() {
        let label = |value: f64, red: f64, opacity: f64| Label {
            value,
            rgb: [red, 0.0, 0.0],
            opacity,
        };
        let labels = [
            label(0.0, 0.0, 0.0),
            label(1.0, 0.2, 0.9),
            label(2.0, 0.4, 0.0),
            label(7.0, 0.6, 0.5),
        ];
        let function = TransferFunction::of_labels(&labels, Some(1.0)).unwrap();
        for Label { value, rgb, opacity } in labels {
            assert_eq!((function.color(value), function.opacity(value)), (rgb, opacity));
        }
        assert_eq!(function.opacity(4.4), 0.0);
        assert_eq!(function.opacity(4.6), 0.5);
        assert!(TransferFunction::of_labels(&[], None).is_err());
    }
}
