//! Codes of sRGB (IEC 61966-2-1) by thresholds.
//!
//! `code = round(largest * srgb(linear))` holds from `linear = srgb^-1((code - 1/2) / largest)` on, so a table of these
//! thresholds gives the code without a power per pixel. The square root of the light, which sRGB follows within a
//! factor of 1.5, tells where in the table to begin. Of 8 bits it has so many steps that hardly ever one remains, which no
//! processor could foresee.

use std::sync::LazyLock;

use splatvol_scene::transfer_function::linear_from_srgb;

/// Codes of 8 bits.
pub(super) static EIGHT: LazyLock<SrgbCodes> = LazyLock::new(|| SrgbCodes::new(u8::MAX.into(), 16));
/// Codes of 16 bits.
pub(super) static SIXTEEN: LazyLock<SrgbCodes> = LazyLock::new(|| SrgbCodes::new(u16::MAX, 1));

/// Conversion of linear light to the codes `0..=largest`.
pub(super) struct SrgbCodes {
    /// Least light of the codes from 1 on, then infinity.
    thresholds: Vec<f64>,
    /// Steps of the square root.
    steps: f64,
    /// Code of the least light of each step.
    starts: Vec<u16>,
}

impl SrgbCodes {
    /// `per_code`: steps of the square root for each code.
    fn new(largest: u16, per_code: u32) -> Self {
        let steps = u32::from(largest) * per_code;
        let threshold = |code: u16| linear_from_srgb((f64::from(code) - 0.5) / f64::from(largest));
        let mut thresholds: Vec<f64> = (1..=largest).map(threshold).collect();
        let start = |step: u32| {
            let root = f64::from(step) / f64::from(steps);
            thresholds.partition_point(|&least| least <= root * root) as u16
        };
        let starts = (0..=steps).map(start).collect();
        thresholds.push(f64::INFINITY);
        Self {
            thresholds,
            steps: f64::from(steps),
            starts,
        }
    }

    /// Code of a light value; values outside 0 to 1 are clamped, NaN becomes 0.
    #[inline(always)]
    pub(super) fn code(&self, linear: f64) -> u16 {
        // A conversion from float saturates, and NaN becomes 0.
        let linear = linear.clamp(0.0, 1.0);
        let step = (linear.sqrt() * self.steps) as usize;
        let mut code = self.starts[step];
        // A root may round up into a step whose least light is above this one.
        while code > 0 && linear < self.thresholds[usize::from(code) - 1] {
            code -= 1;
        }
        while linear >= self.thresholds[usize::from(code)] {
            code += 1;
        }
        code
    }
}

#[cfg(test)]
mod tests {
    use splatvol_scene::transfer_function::srgb_from_linear;

    use super::*;

    fn largest(codes: &SrgbCodes) -> u16 {
        (codes.thresholds.len() - 1) as u16
    }

    #[test]
    fn codes_are_those_of_the_formula() {
        for codes in [&*EIGHT, &*SIXTEEN] {
            let largest = f64::from(largest(codes));
            let dark = (0..20_000).map(|step| f64::from(step) * 1e-6);
            let any = (0..=200_000).map(|step| f64::from(step) / 200_000.0);
            for linear in dark.chain(any) {
                let exact = largest * srgb_from_linear(linear);
                // A tie may fall to either side.
                let away = (f64::from(codes.code(linear)) - exact).abs();
                assert!(away <= 0.5 + 1e-9, "{linear}: {exact}");
            }
        }
    }

    #[test]
    fn every_code_is_its_own_light_and_what_is_beyond_is_clamped() {
        for codes in [&*EIGHT, &*SIXTEEN] {
            for code in 0..=largest(codes) {
                let linear = linear_from_srgb(f64::from(code) / f64::from(largest(codes)));
                assert_eq!(codes.code(linear), code);
            }
            assert_eq!(codes.code(f64::NAN), 0);
            assert_eq!(codes.code(-1.0), 0);
            assert_eq!(codes.code(f64::INFINITY), largest(codes));
        }
    }
}
