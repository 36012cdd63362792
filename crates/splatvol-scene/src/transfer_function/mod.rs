//! Transfer functions: piecewise colour and opacity of data values.
//!
//! Opacity is never a bare number: it is the opacity of homogeneous material of thickness `unit_distance`, so that
//! `extinction = -ln(1 - opacity) / unit_distance`. Between points both curves follow VTK's `midpoint` and
//! `sharpness` (0.5 and 0: linear); outside the first and last point they are constant. Colours are sRGB, as
//! colour maps are, and interpolated as such.

mod automatic;
mod colormap;
mod colormap_tables;
mod labels;
mod named_opacity;
mod presets;

use serde::{Deserialize, Serialize};

use crate::SceneError;
pub use automatic::{AutomaticChoice, ValueKind};
pub use colormap::ColorMap;
pub use labels::Label;
pub use named_opacity::OpacityCurve;

/// A point of the colour curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ColorPoint {
    /// Data value.
    pub value: f64,
    /// sRGB, 0..1.
    pub rgb: [f64; 3],
    /// Position, between this point and the next, where the curve is half way, 0..1.
    #[serde(default = "default_midpoint")]
    pub midpoint: f64,
    /// 0: linear, 1: a step at the midpoint.
    #[serde(default)]
    pub sharpness: f64,
}

/// A point of the opacity curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OpacityPoint {
    /// Data value.
    pub value: f64,
    /// Opacity per unit distance, 0..1.
    pub opacity: f64,
    /// Position, between this point and the next, where the curve is half way, 0..1.
    #[serde(default = "default_midpoint")]
    pub midpoint: f64,
    /// 0: linear, 1: a step at the midpoint.
    #[serde(default)]
    pub sharpness: f64,
}

fn default_midpoint() -> f64 {
    0.5
}

impl ColorPoint {
    /// Point with linear interpolation to the next.
    pub fn new(value: f64, rgb: [f64; 3]) -> Self {
        Self {
            value,
            rgb,
            midpoint: 0.5,
            sharpness: 0.0,
        }
    }
}

impl OpacityPoint {
    /// Point with linear interpolation to the next.
    pub fn new(value: f64, opacity: f64) -> Self {
        Self {
            value,
            opacity,
            midpoint: 0.5,
            sharpness: 0.0,
        }
    }
}

/// A validated transfer function.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct TransferFunction {
    colors: Vec<ColorPoint>,
    opacities: Vec<OpacityPoint>,
    /// World length to which opacities refer; `None` is the volume's mean voxel spacing.
    pub unit_distance: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    colors: Vec<ColorPoint>,
    opacities: Vec<OpacityPoint>,
    unit_distance: Option<f64>,
}

impl TryFrom<Unchecked> for TransferFunction {
    type Error = SceneError;

    fn try_from(raw: Unchecked) -> Result<Self, SceneError> {
        Self::new(raw.colors, raw.opacities, raw.unit_distance)
    }
}

impl TransferFunction {
    /// Largest opacity that is kept: 1 would be infinite extinction.
    pub const MAX_OPACITY: f64 = 0.999_999;

    /// Transfer function from its points; they are sorted by value (stable, so that a value given twice is a step).
    ///
    /// # Errors
    /// No points, values that are not finite, colours, opacities, midpoints or sharpnesses outside 0..1, or a unit
    /// distance that is not positive.
    pub fn new(
        mut colors: Vec<ColorPoint>,
        mut opacities: Vec<OpacityPoint>,
        unit_distance: Option<f64>,
    ) -> Result<Self, SceneError> {
        let unit = |value: f64| (0.0..=1.0).contains(&value);
        if colors.is_empty() || opacities.is_empty() {
            return Err(SceneError::invalid(
                "transfer function points",
                [colors.len(), opacities.len()],
                "at least one colour and one opacity point",
            ));
        }
        for point in &colors {
            if !point.value.is_finite() || !point.rgb.iter().all(|&c| unit(c)) {
                return Err(SceneError::invalid(
                    "color point",
                    point,
                    "a finite value and rgb in 0..1",
                ));
            }
            if !unit(point.midpoint) || !unit(point.sharpness) {
                return Err(SceneError::invalid(
                    "color point",
                    point,
                    "midpoint and sharpness in 0..1",
                ));
            }
        }
        for point in &opacities {
            if !point.value.is_finite() || !unit(point.opacity) {
                return Err(SceneError::invalid(
                    "opacity point",
                    point,
                    "a finite value and opacity in 0..1",
                ));
            }
            if !unit(point.midpoint) || !unit(point.sharpness) {
                return Err(SceneError::invalid(
                    "opacity point",
                    point,
                    "midpoint and sharpness in 0..1",
                ));
            }
        }
        if let Some(distance) = unit_distance.filter(|d| !(*d > 0.0 && d.is_finite())) {
            return Err(SceneError::invalid(
                "unit distance",
                distance,
                "positive and finite",
            ));
        }
        colors.sort_by(|a, b| a.value.total_cmp(&b.value));
        opacities.sort_by(|a, b| a.value.total_cmp(&b.value));
        Ok(Self {
            colors,
            opacities,
            unit_distance,
        })
    }

    /// Colour points by ascending value.
    pub fn colors(&self) -> &[ColorPoint] {
        &self.colors
    }

    /// Opacity points by ascending value.
    pub fn opacities(&self) -> &[OpacityPoint] {
        &self.opacities
    }

    /// sRGB colour of a value.
    pub fn color(&self, value: f64) -> [f64; 3] {
        let points = &self.colors;
        match bracket(points.len(), |i| points[i].value, value) {
            Bracket::Point(i) => points[i].rgb,
            Bracket::Between(i, t) => {
                let t = ease(t, points[i].midpoint, points[i].sharpness);
                std::array::from_fn(|c| points[i].rgb[c] + t * (points[i + 1].rgb[c] - points[i].rgb[c]))
            }
        }
    }

    /// Colour of a value in linear light.
    pub fn linear_color(&self, value: f64) -> [f64; 3] {
        self.color(value).map(linear_from_srgb)
    }

    /// Opacity of a value, per unit distance.
    pub fn opacity(&self, value: f64) -> f64 {
        let points = &self.opacities;
        match bracket(points.len(), |i| points[i].value, value) {
            Bracket::Point(i) => points[i].opacity,
            Bracket::Between(i, t) => {
                let t = ease(t, points[i].midpoint, points[i].sharpness);
                points[i].opacity + t * (points[i + 1].opacity - points[i].opacity)
            }
        }
    }

    /// Extinction of a value per world length: `-ln(1 - opacity) / unit_distance`.
    pub fn extinction(&self, value: f64, unit_distance: f64) -> f64 {
        -libm::log1p(-self.opacity(value).min(Self::MAX_OPACITY)) / unit_distance
    }
}

enum Bracket {
    Point(usize),
    Between(usize, f64),
}

/// Finds the pair of points around `value`; of points with one value the last counts from there on.
fn bracket(count: usize, value_of: impl Fn(usize) -> f64, value: f64) -> Bracket {
    let (mut low, mut high) = (0, count);
    while low < high {
        let middle = (low + high) / 2;
        if value_of(middle) <= value {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    match low {
        0 => Bracket::Point(0),
        n if n == count => Bracket::Point(count - 1),
        n => Bracket::Between(n - 1, (value - value_of(n - 1)) / (value_of(n) - value_of(n - 1))),
    }
}

/// VTK's midpoint and sharpness (vtkPiecewiseFunction): t in 0..1 to t in 0..1.
fn ease(t: f64, midpoint: f64, sharpness: f64) -> f64 {
    let midpoint = midpoint.clamp(1e-5, 1.0 - 1e-5);
    let t = if t < midpoint {
        0.5 * t / midpoint
    } else {
        0.5 + 0.5 * (t - midpoint) / (1.0 - midpoint)
    };
    if sharpness > 0.99 {
        return if t < 0.5 { 0.0 } else { 1.0 };
    }
    if sharpness < 0.01 {
        return t;
    }
    // A Hermite curve whose ends flatten with the sharpness.
    let exponent = 1.0 + 10.0 * sharpness;
    let t = if t < 0.5 {
        0.5 * libm::pow(2.0 * t, exponent)
    } else {
        1.0 - 0.5 * libm::pow(2.0 * (1.0 - t), exponent)
    };
    let (t2, t3) = (t * t, t * t * t);
    let slope = 1.0 - sharpness;
    (3.0 * t2 - 2.0 * t3) + slope * (t3 - 2.0 * t2 + t) + slope * (t3 - t2)
}

/// sRGB (IEC 61966-2-1) to linear light.
pub fn linear_from_srgb(encoded: f64) -> f64 {
    if encoded <= 0.040_45 {
        encoded / 12.92
    } else {
        libm::pow((encoded + 0.055) / 1.055, 2.4)
    }
}

/// Linear light to sRGB (IEC 61966-2-1).
pub fn srgb_from_linear(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        linear * 12.92
    } else {
        1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> TransferFunction {
        TransferFunction::new(
            vec![
                ColorPoint::new(10.0, [1.0, 0.0, 0.5]),
                ColorPoint::new(0.0, [0.0, 1.0, 0.5]),
            ],
            vec![
                OpacityPoint::new(0.0, 0.0),
                OpacityPoint::new(5.0, 0.2),
                OpacityPoint::new(5.0, 0.8),
                OpacityPoint::new(10.0, 1.0),
            ],
            None,
        )
        .unwrap()
    }

    #[test]
    fn curves_are_linear_clamped_and_may_step() {
        let tf = ramp();
        assert_eq!(tf.color(2.5), [0.25, 0.75, 0.5]);
        assert_eq!(
            [
                tf.opacity(-3.0),
                tf.opacity(2.5),
                tf.opacity(5.0),
                tf.opacity(99.0)
            ],
            [0.0, 0.1, 0.8, 1.0]
        );
        assert!((tf.opacity(4.999_999) - 0.2).abs() < 1e-6);
    }

    #[test]
    fn extinction_gives_the_opacity_back_over_the_unit_distance() {
        let tf = ramp();
        for distance in [0.1, 1.0, 7.0] {
            let through = (-tf.extinction(2.5, distance) * distance).exp();
            assert!((1.0 - through - 0.1).abs() < 1e-12);
        }
        assert!(tf.extinction(10.0, 1.0).is_finite());
    }

    #[test]
    fn srgb_round_trips() {
        for i in 0..=100 {
            let x = f64::from(i) / 100.0;
            assert!((srgb_from_linear(linear_from_srgb(x)) - x).abs() < 1e-9);
        }
    }

    #[test]
    fn sharpness_makes_a_step_and_midpoint_moves_it() {
        let mut points = vec![OpacityPoint::new(0.0, 0.0), OpacityPoint::new(1.0, 1.0)];
        points[0].sharpness = 1.0;
        points[0].midpoint = 0.25;
        let tf = TransferFunction::new(vec![ColorPoint::new(0.0, [0.0; 3])], points, None).unwrap();
        assert_eq!([tf.opacity(0.24), tf.opacity(0.26)], [0.0, 1.0]);
    }

    #[test]
    fn bad_points_are_refused() {
        let color = || vec![ColorPoint::new(0.0, [0.0; 3])];
        assert!(TransferFunction::new(color(), vec![], None).is_err());
        assert!(TransferFunction::new(color(), vec![OpacityPoint::new(f64::NAN, 0.1)], None).is_err());
        assert!(TransferFunction::new(color(), vec![OpacityPoint::new(0.0, 1.1)], None).is_err());
        assert!(TransferFunction::new(color(), vec![OpacityPoint::new(0.0, 1.0)], Some(0.0)).is_err());
    }
}
