//! Opacity curves under `PyVista`'s names.
//!
//! As `pyvista.opacity_transfer_function`, over t = 0..1 of a value range:
//!
//! | name | opacity per unit distance |
//! |---|---|
//! | `linear` | t |
//! | `geom` | `(1e-6 / 255)^(1 - t)` |
//! | `sigmoid_a` | `1 / (1 + exp(a - 2 a t))`; a is 1..10, 15 or 20, and 10 where it is left out |
//! | `foreground` | 0 below the first 1/255 of the range, 1 above |
//!
//! `_r` reverses a curve (also those `PyVista` leaves out). `PyVista` keeps 8 bits and rounds down: opacities below
//! 1/255 vanish; they vanish here too, but nothing else is quantised. The largest opacity is 1 per unit distance,
//! which renderers take as [`crate::TransferFunction::MAX_OPACITY`].

use crate::{OpacityPoint, SceneError};

/// Pieces into which curved functions are cut; the error of linear interpolation is below 0.004 for `sigmoid_20`.
const PIECES: usize = 128;

/// A named opacity curve over 0..1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpacityCurve {
    shape: Shape,
    reversed: bool,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Shape {
    Linear,
    Geometric,
    Sigmoid { steepness: u8 },
    Foreground,
}

impl OpacityCurve {
    /// Curve of a `PyVista` name.
    ///
    /// # Errors
    /// A name that is not in [`OpacityCurve::names`], with or without `_r`.
    pub fn from_name(name: &str) -> Result<Self, SceneError> {
        let (base, reversed) = match name.strip_suffix("_r") {
            Some(base) => (base, true),
            None => (name, false),
        };
        let shape = match base {
            "linear" => Some(Shape::Linear),
            "geom" => Some(Shape::Geometric),
            "sigmoid" => Some(Shape::Sigmoid { steepness: 10 }),
            "foreground" => Some(Shape::Foreground),
            _ => base
                .strip_prefix("sigmoid_")
                .and_then(|digits| digits.parse().ok())
                .filter(|a| matches!(a, 1..=10 | 15 | 20))
                .map(|steepness| Shape::Sigmoid { steepness }),
        };
        shape.map(|shape| Self { shape, reversed }).ok_or_else(|| {
            SceneError::invalid(
                "opacity curve",
                name,
                "linear, geom, sigmoid, sigmoid_1 to _10, _15, _20 or foreground, with _r to reverse",
            )
        })
    }

    /// All names, each of which may be followed by `_r`.
    pub fn names() -> impl Iterator<Item = String> {
        let sigmoids = (1..=10).chain([15, 20]).map(|a| format!("sigmoid_{a}"));
        ["linear", "geom", "foreground", "sigmoid"]
            .into_iter()
            .map(String::from)
            .chain(sigmoids)
    }

    /// Opacity at `t` in 0..1.
    pub fn opacity(&self, t: f64) -> f64 {
        let t = t.clamp(0.0, 1.0);
        let t = if self.reversed { 1.0 - t } else { t };
        let opacity = match self.shape {
            Shape::Linear => return t,
            Shape::Geometric => libm::pow(1e-6f64 / 255.0, 1.0 - t),
            Shape::Sigmoid { steepness } => 1.0 / (1.0 + libm::exp(f64::from(steepness) * (1.0 - 2.0 * t))),
            Shape::Foreground => return f64::from(u8::from(t >= 1.0 / 255.0)),
        };
        if opacity < 1.0 / 255.0 { 0.0 } else { opacity }
    }

    /// The curve over a value range.
    pub fn points(&self, range: [f64; 2]) -> Vec<OpacityPoint> {
        let point = |t: f64, opacity| OpacityPoint::new(range[0] + t * (range[1] - range[0]), opacity);
        let step = |at: f64| {
            let (below, above) = if self.reversed { (1.0, 0.0) } else { (0.0, 1.0) };
            vec![
                point(0.0, below),
                point(at, below),
                point(at, above),
                point(1.0, above),
            ]
        };
        match self.shape {
            Shape::Foreground if self.reversed => step(254.0 / 255.0),
            Shape::Foreground => step(1.0 / 255.0),
            Shape::Linear => [0.0, 1.0].map(|t| point(t, self.opacity(t))).to_vec(),
            Shape::Geometric | Shape::Sigmoid { .. } => (0..=PIECES)
                .map(|i| i as f64 / PIECES as f64)
                .map(|t| point(t, self.opacity(t)))
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ColorPoint, TransferFunction};

    fn opacity(name: &str, t: f64) -> f64 {
        OpacityCurve::from_name(name).unwrap().opacity(t)
    }

    /// Entries of `pyvista.opacity_transfer_function(name, 256)`, `PyVista` 0.49, which rounds down.
    const PYVISTA: &[(&str, usize, u8)] = &[
        ("linear", 0, 0),
        ("linear", 1, 1),
        ("linear", 70, 70),
        ("linear", 128, 128),
        ("linear", 150, 150),
        ("linear", 240, 240),
        ("linear", 255, 255),
        ("geom", 0, 0),
        ("geom", 1, 0),
        ("geom", 70, 0),
        ("geom", 128, 0),
        ("geom", 150, 0),
        ("geom", 240, 81),
        ("geom", 255, 255),
        ("geom_r", 0, 255),
        ("geom_r", 1, 236),
        ("geom_r", 70, 1),
        ("geom_r", 128, 0),
        ("geom_r", 150, 0),
        ("geom_r", 240, 0),
        ("geom_r", 255, 0),
        ("sigmoid", 0, 0),
        ("sigmoid", 1, 0),
        ("sigmoid", 70, 2),
        ("sigmoid", 128, 129),
        ("sigmoid", 150, 217),
        ("sigmoid", 240, 254),
        ("sigmoid", 255, 254),
        ("sigmoid_3", 0, 12),
        ("sigmoid_3", 1, 12),
        ("sigmoid_3", 70, 52),
        ("sigmoid_3", 128, 128),
        ("sigmoid_3", 150, 160),
        ("sigmoid_3", 240, 238),
        ("sigmoid_3", 255, 242),
        ("sigmoid_20", 0, 0),
        ("sigmoid_20", 1, 0),
        ("sigmoid_20", 70, 0),
        ("sigmoid_20", 128, 132),
        ("sigmoid_20", 150, 247),
        ("sigmoid_20", 240, 254),
        ("sigmoid_20", 255, 254),
        ("foreground", 0, 0),
        ("foreground", 1, 255),
        ("foreground", 70, 255),
        ("foreground", 128, 255),
        ("foreground", 150, 255),
        ("foreground", 240, 255),
        ("foreground", 255, 255),
        ("linear_r", 0, 255),
        ("linear_r", 1, 254),
        ("linear_r", 70, 185),
        ("linear_r", 128, 127),
        ("linear_r", 150, 105),
        ("linear_r", 240, 15),
        ("linear_r", 255, 0),
        ("sigmoid_r", 0, 254),
        ("sigmoid_r", 1, 254),
        ("sigmoid_r", 70, 252),
        ("sigmoid_r", 128, 125),
        ("sigmoid_r", 150, 37),
        ("sigmoid_r", 240, 0),
        ("sigmoid_r", 255, 0),
    ];

    #[test]
    fn curves_are_pyvistas() {
        for &(name, entry, want) in PYVISTA {
            let got = opacity(name, entry as f64 / 255.0) * 255.0;
            let want = f64::from(want);
            assert!(
                (want - 1e-9..want + 1.0).contains(&got),
                "{name} {entry}: {got} {want}"
            );
        }
    }

    #[test]
    fn points_follow_the_curve() {
        for name in OpacityCurve::names().flat_map(|name| [format!("{name}_r"), name]) {
            let curve = OpacityCurve::from_name(&name).unwrap();
            let tf = TransferFunction::new(
                vec![ColorPoint::new(0.0, [0.0; 3])],
                curve.points([-2.0, 6.0]),
                None,
            )
            .unwrap();
            for i in 0..=1000 {
                // Half-way numbers, off the steps.
                let t = (f64::from(i) + 0.5) / 1001.0;
                let (got, want) = (tf.opacity(-2.0 + 8.0 * t), curve.opacity(t));
                assert!((got - want).abs() < 0.01, "{name} {t}: {got} {want}");
            }
        }
    }

    #[test]
    fn unknown_names_are_refused() {
        for name in ["sigmoid_11", "sigmoid_", "Linear", "", "_r"] {
            let error = OpacityCurve::from_name(name).unwrap_err().to_string();
            assert!(error.starts_with(&format!("opacity curve: {name:?}")), "{error}");
        }
    }
}
