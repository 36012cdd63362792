//! Powers and logarithms of vectors: the same operations, hence the same bits, at every SIMD level. Nothing is fused.

use fearless_simd::{f32x16, i32x16, prelude::*, u32x16};

/// `2^x` per lane for x from -126 to 126; relative error 3e-6, and 1 for 0.
///
/// Adding 1.5 * 2^23 leaves the nearest integer in the lowest bits, from where it is shifted into the exponent.
#[inline(always)]
pub(crate) fn exp2<S: Simd>(simd: S, x: f32x16<S>) -> f32x16<S> {
    const ROUND: f32 = 12_582_912.0;
    let shifted = x + ROUND;
    let r = x - (shifted - ROUND);
    let mut p = f32x16::splat(simd, 9.582_853e-3);
    for coefficient in [5.590_642_5e-2, 2.402_41e-1, 6.931_242e-1, 1.0] {
        p = p * r + coefficient;
    }
    (p.bitcast::<u32x16<S>>() + (shifted.bitcast::<u32x16<S>>() << 23)).bitcast::<f32x16<S>>()
}

/// `log2` per lane of positive normal numbers; absolute error 3e-6.
#[inline(always)]
pub(crate) fn log2<S: Simd>(simd: S, x: f32x16<S>) -> f32x16<S> {
    // The exponent such that the mantissa lies within sqrt(1/2) .. sqrt(2).
    const SQRT_HALF: u32 = 0x3f35_04f3;
    let shifted = x.bitcast::<u32x16<S>>() - SQRT_HALF;
    let exponent = (shifted.bitcast::<i32x16<S>>() >> 23).to_float::<f32x16<S>>();
    let mantissa = ((shifted & 0x007f_ffff) + SQRT_HALF).bitcast::<f32x16<S>>();
    let f = mantissa - 1.0;
    let mut p = f32x16::splat(simd, -2.065_916_4e-1);
    for coefficient in [
        3.221_547_6e-1,
        -3.674_9e-1,
        4.793_480_2e-1,
        -7.211_318_6e-1,
        1.442_713_5,
    ] {
        p = p * f + coefficient;
    }
    p * f + exponent
}

/// sRGB (IEC 61966-2-1) to linear light per lane, from 0 to 1e6; relative error 1e-5.
#[inline(always)]
pub(crate) fn linear_from_srgb<S: Simd>(simd: S, encoded: f32x16<S>) -> f32x16<S> {
    let power = exp2(simd, log2(simd, (encoded + 0.055) * (1.0 / 1.055)) * 2.4);
    encoded
        .simd_le(f32x16::splat(simd, 0.040_45))
        .select(encoded * (1.0 / 12.92), power)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};
    use splatvol_scene::transfer_function;

    #[inline(always)]
    fn found<S: Simd>(simd: S, x: f32) -> [f32; 3] {
        let v = f32x16::splat(simd, x);
        [
            exp2(simd, v - 8.0)[3],
            log2(simd, v + 1e-3)[5],
            linear_from_srgb(simd, v)[7],
        ]
    }

    #[test]
    fn functions_agree_with_the_library() {
        for i in 0..20_000 {
            let x = i as f32 * 4e-4;
            let [power, logarithm, linear] = dispatch!(Level::new(), simd => found(simd, x));
            let exact = f64::from(x);
            assert!(
                (f64::from(power) / (f64::from(x - 8.0)).exp2() - 1.0).abs() < 4e-6,
                "{x}"
            );
            assert!(
                (f64::from(logarithm) - f64::from(x + 1e-3).log2()).abs() < 4e-6,
                "{x}"
            );
            let expected = transfer_function::linear_from_srgb(exact);
            assert!(
                (f64::from(linear) - expected).abs() <= 2e-5 * expected,
                "{x} {linear} {expected}"
            );
        }
    }
}
