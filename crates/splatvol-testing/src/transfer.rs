//! Transfer functions whose extinction is known exactly, for closed forms.

use splatvol_scene::{ColorPoint, OpacityPoint, TransferFunction};

/// Points of a curved opacity: its linear pieces leave the wanted extinction by less than 1e-7 of it.
const PIECES: usize = 1000;

/// Extinction that rises linearly from 0 at `range[0]` to `extinction` (per world length) at `range[1]`, in one
/// sRGB colour.
///
/// # Panics
/// If the extinction is negative or not finite, the range is not finite, or the colour is outside 0..1.
pub fn linear_extinction(range: [f64; 2], extinction: f64, rgb: [f64; 3]) -> TransferFunction {
    let points = (0..=PIECES).map(|i| {
        let t = i as f64 / PIECES as f64;
        let value = range[0] + t * (range[1] - range[0]);
        OpacityPoint::new(value, -(-t * extinction).exp_m1())
    });
    let color = vec![ColorPoint::new(range[0], rgb)];
    TransferFunction::new(color, points.collect(), Some(1.0)).expect("documented domain")
}

/// A transfer function with one extinction (per world length) and one sRGB colour for every value.
///
/// # Panics
/// If the extinction is negative or not finite, or the colour is outside 0..1.
pub fn constant_extinction(extinction: f64, rgb: [f64; 3]) -> TransferFunction {
    let opacity = vec![OpacityPoint::new(0.0, -(-extinction).exp_m1())];
    TransferFunction::new(vec![ColorPoint::new(0.0, rgb)], opacity, Some(1.0)).expect("documented domain")
}

/// Extinction (per world length) for values from `range[0]` up to, not including, `range[1]`; nothing elsewhere.
///
/// # Panics
/// If the extinction is negative or not finite, the range is not finite or empty, or the colour is outside 0..1.
pub fn band_extinction(range: [f64; 2], extinction: f64, rgb: [f64; 3]) -> TransferFunction {
    let opacity = -(-extinction).exp_m1();
    let points = [
        (range[0], 0.0),
        (range[0], opacity),
        (range[1], opacity),
        (range[1], 0.0),
    ];
    let points = points.map(|(value, opacity)| OpacityPoint::new(value, opacity));
    TransferFunction::new(vec![ColorPoint::new(range[0], rgb)], points.to_vec(), Some(1.0))
        .expect("documented domain")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extinctions_are_those_asked_for() {
        let linear = linear_extinction([2.0, 4.0], 1.5, [1.0; 3]);
        for value in [2.0, 2.123_4, 3.0, 3.777, 4.0] {
            let expected = 1.5 * (value - 2.0) / 2.0;
            assert!((linear.extinction(value, 1.0) - expected).abs() < 1e-6);
        }
        let band = band_extinction([0.2, 0.3], 0.7, [1.0; 3]);
        let values = [0.199, 0.2, 0.299, 0.3].map(|value| band.extinction(value, 1.0));
        assert!(values[0] == 0.0 && values[3] == 0.0);
        assert!((values[1] - 0.7).abs() < 1e-12 && (values[2] - 0.7).abs() < 1e-12);
        assert!((constant_extinction(0.3, [1.0; 3]).extinction(9.0, 1.0) - 0.3).abs() < 1e-12);
    }
}
