//! Transcendental functions of vectors; powers of two are `splatvol_core::exponential`'s.

use fearless_simd::{f32x16, i32x16, prelude::*, u32x16};
use splatvol_core::exponential;

pub(crate) use splatvol_core::exponential::{exp2_of, exp2_quick};

/// Least exponent, to base 2, of a transmittance or a weight: far below anything that is seen, and no denormal after a
/// few products.
pub(crate) const LEAST_EXPONENT: f32 = -100.0;
/// Least exponent, to base 2, of a normal number.
pub(crate) const LEAST_NORMAL: f32 = -126.0;

/// `2^max(x, -126)` per lane for x up to 126; relative error 2e-7.
#[inline(always)]
pub(crate) fn exp2<S: Simd>(simd: S, x: f32x16<S>) -> f32x16<S> {
    exponential::exp2(simd, x.max(f32x16::splat(simd, LEAST_NORMAL)))
}

/// `log2` per lane of positive normal numbers; absolute error 3e-6.
#[inline(always)]
pub(crate) fn log2<S: Simd>(simd: S, x: f32x16<S>) -> f32x16<S> {
    // The exponent such that the mantissa lies within sqrt(1/2) .. sqrt(2).
    const SQRT_HALF: u32 = 0x3f35_04f3;
    let bits = x.bitcast::<u32x16<S>>();
    let shifted = bits - SQRT_HALF;
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
    let power = exp2_quick(simd, log2(simd, (encoded + 0.055) * (1.0 / 1.055)) * 2.4);
    encoded
        .simd_le(f32x16::splat(simd, 0.040_45))
        .select(encoded * (1.0 / 12.92), power)
}

/// Linear light to sRGB (IEC 61966-2-1) per lane, from 0 to 1e6; relative error 1e-5.
#[inline(always)]
pub(crate) fn srgb_from_linear<S: Simd>(simd: S, linear: f32x16<S>) -> f32x16<S> {
    let logarithm = log2(simd, linear.max(f32x16::splat(simd, f32::MIN_POSITIVE)));
    let power = exp2_quick(simd, logarithm * (1.0 / 2.4)) * 1.055 - 0.055;
    linear
        .simd_le(f32x16::splat(simd, 0.003_130_8))
        .select(linear * 12.92, power)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};
    use splatvol_scene::transfer_function;

    #[inline(always)]
    fn of_colors<S: Simd>(simd: S, x: f32) -> [f32; 4] {
        let v = f32x16::splat(simd, x);
        [
            exp2_quick(simd, v - 8.0)[3],
            log2(simd, v + 1e-3)[5],
            linear_from_srgb(simd, v)[7],
            srgb_from_linear(simd, v)[9],
        ]
    }

    #[test]
    fn powers_and_display_colors_agree_with_the_library() {
        let near = |found: f32, expected: f64, share: f64| {
            (f64::from(found) - expected).abs() <= share * expected.abs() + 4e-6
        };
        for i in 0..20_000 {
            let x = i as f32 * 4e-4;
            let [power, logarithm, linear, encoded] = dispatch!(Level::new(), simd => of_colors(simd, x));
            let exact = f64::from(x);
            assert!(near(power, f64::from(x - 8.0).exp2(), 4e-6), "{x}");
            assert!(near(logarithm, f64::from(x + 1e-3).log2(), 0.0), "{x}");
            assert!(
                near(linear, transfer_function::linear_from_srgb(exact), 2e-5),
                "{x} {linear}"
            );
            assert!(
                near(encoded, transfer_function::srgb_from_linear(exact), 2e-5),
                "{x} {encoded}"
            );
        }
    }
}
