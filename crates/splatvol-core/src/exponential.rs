//! Powers of two, per lane.
//!
//! `2^x = 2^n 2^r`, n the nearest integer, `|r| <= 1/2`, with a polynomial for `2^r`. Adding `1.5 * 2^23` puts n in
//! the lowest bits of a float, which are then shifted into the exponent. No operation is fused, so the bits are the
//! same at every SIMD level.

use fearless_simd::{f32x16, prelude::*, u32x16};

/// Adding and subtracting it rounds.
const ROUND: f32 = 12_582_912.0;
/// Coefficients of a polynomial for `2^r`, highest power first; exactly 1 at 0. Relative error 2e-7.
const PRECISE: [f32; 6] = [
    1.327_647_2e-3,
    9.675_541e-3,
    5.550_713e-2,
    2.402_212e-1,
    6.931_472e-1,
    1.0,
];
/// Coefficients of a shorter polynomial; relative error 3e-6.
const QUICK: [f32; 5] = [9.582_853e-3, 5.590_642_5e-2, 2.402_41e-1, 6.931_242e-1, 1.0];

#[inline(always)]
fn power<S: Simd>(simd: S, x: f32x16<S>, coefficients: &[f32]) -> f32x16<S> {
    let shifted = x + ROUND;
    let r = x - (shifted - ROUND);
    let mut p = f32x16::splat(simd, coefficients[0]);
    for &coefficient in &coefficients[1..] {
        p = p * r + coefficient;
    }
    (p.bitcast::<u32x16<S>>() + (shifted.bitcast::<u32x16<S>>() << 23)).bitcast::<f32x16<S>>()
}

/// `2^x` per lane for x from -126 to 126, not clamped; relative error 2e-7.
#[inline(always)]
pub fn exp2<S: Simd>(simd: S, x: f32x16<S>) -> f32x16<S> {
    power(simd, x, &PRECISE)
}

/// `2^x` per lane for x from -126 to 126, not clamped; relative error 3e-6.
#[inline(always)]
pub fn exp2_quick<S: Simd>(simd: S, x: f32x16<S>) -> f32x16<S> {
    power(simd, x, &QUICK)
}

/// `2^x` of one number, cut at -126 and 126; the bits of [`exp2`].
pub fn exp2_of(x: f32) -> f32 {
    let x = x.clamp(-126.0, 126.0);
    let n = x.round_ties_even();
    let r = x - n;
    let p = PRECISE[1..].iter().fold(PRECISE[0], |p, c| p * r + c);
    p * f32::from_bits(((n + 127.0) as u32) << 23)
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};

    use super::*;

    #[inline(always)]
    fn both<S: Simd>(simd: S, x: f32) -> [f32; 2] {
        let x = f32x16::splat(simd, x);
        [exp2(simd, x)[3], exp2_quick(simd, x)[5]]
    }

    #[test]
    fn powers_agree_with_the_library() {
        for i in 0..=50_400 {
            let x = (i as f32 - 25_200.0) / 200.0;
            let expected = f64::from(x).exp2();
            let [precise, quick] = dispatch!(Level::new(), simd => both(simd, x));
            assert!(
                (f64::from(precise) / expected - 1.0).abs() < 4e-7,
                "{x}: {precise}"
            );
            assert!((f64::from(quick) / expected - 1.0).abs() < 4e-6, "{x}: {quick}");
            assert_eq!(precise.to_bits(), exp2_of(x).to_bits(), "{x}");
        }
    }
}
