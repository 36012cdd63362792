//! Transfer functions from a few words: a map with a curve, an isosurface, a grey ramp.

use super::{ColorMap, OpacityCurve};
use crate::{ColorPoint, OpacityPoint, SceneError, TransferFunction};

impl TransferFunction {
    /// Colour map and opacity curve, both over `range`.
    ///
    /// # Errors
    /// A range or unit distance that is not allowed in [`TransferFunction::new`].
    pub fn from_map_and_opacity(
        range: [f64; 2],
        map: ColorMap,
        curve: OpacityCurve,
        unit_distance: Option<f64>,
    ) -> Result<Self, SceneError> {
        Self::new(
            map.points(range, ColorMap::DEFAULT_POINTS),
            curve.points(range),
            unit_distance,
        )
    }

    /// A transfer function that looks like the surface `v = value`, in one colour (sRGB): opacity rises from 0 to
    /// [`TransferFunction::MAX_OPACITY`] per voxel within `width` around the value and stays there above. About 1/50 of
    /// the value range is a good width; much less shows sheets, much more is foggy.
    ///
    /// # Errors
    /// A value that is not finite, a width that is not positive, or a colour outside 0..1.
    pub fn isosurface(value: f64, width: f64, rgb: [f64; 3]) -> Result<Self, SceneError> {
        if !(width > 0.0 && width.is_finite()) {
            return Err(SceneError::invalid(
                "isosurface width",
                width,
                "positive and finite",
            ));
        }
        let opacities = vec![
            OpacityPoint::new(value - 0.5 * width, 0.0),
            OpacityPoint::new(value + 0.5 * width, Self::MAX_OPACITY),
        ];
        Self::new(vec![ColorPoint::new(value, rgb)], opacities, None)
    }

    /// Black to white with opacity 0 to `opacity` over `range`, for MIP (`opacity` 1) and X-ray pictures (small).
    ///
    /// # Errors
    /// A range that is not finite or an opacity outside 0..1.
    pub fn gray_ramp(range: [f64; 2], opacity: f64) -> Result<Self, SceneError> {
        Self::new(
            vec![
                ColorPoint::new(range[0], [0.0; 3]),
                ColorPoint::new(range[1], [1.0; 3]),
            ],
            vec![
                OpacityPoint::new(range[0], 0.0),
                OpacityPoint::new(range[1], opacity),
            ],
            None,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_isosurface_is_opaque_above_its_value_only() {
        let tf = TransferFunction::isosurface(10.0, 2.0, [1.0, 0.5, 0.0]).unwrap();
        assert_eq!([tf.opacity(9.0), tf.opacity(8.0)], [0.0; 2]);
        assert!((tf.opacity(10.0) - 0.5).abs() < 1e-6);
        assert_eq!(tf.opacity(1e9), TransferFunction::MAX_OPACITY);
        for (value, width) in [(f64::NAN, 1.0), (0.0, 0.0), (0.0, f64::NAN)] {
            assert!(TransferFunction::isosurface(value, width, [0.0; 3]).is_err());
        }
    }

    #[test]
    fn map_and_curve_share_the_range() {
        let (map, curve) = (
            ColorMap::from_name("viridis").unwrap(),
            OpacityCurve::from_name("linear_r").unwrap(),
        );
        let tf = TransferFunction::from_map_and_opacity([100.0, 300.0], map, curve, Some(2.0)).unwrap();
        for t in [0.0, 0.25, 0.8, 1.0] {
            assert!((tf.opacity(100.0 + 200.0 * t) - (1.0 - t)).abs() < 1e-12);
            for (got, want) in tf.color(100.0 + 200.0 * t).into_iter().zip(map.rgb(t)) {
                assert!((got - want).abs() < 0.5 / 255.0);
            }
        }
        assert!(TransferFunction::from_map_and_opacity([0.0, f64::INFINITY], map, curve, None).is_err());
        assert_eq!(
            TransferFunction::gray_ramp([0.0, 4.0], 0.2).unwrap().opacity(2.0),
            0.1
        );
    }
}
