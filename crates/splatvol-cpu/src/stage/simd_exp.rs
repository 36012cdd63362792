//! `exp` of vectors, for exponents from -87 to 0.
//!
//! `exp(x) = 2^n exp(r)`, n the nearest integer to `x log2(e)`, `|r| <= ln(2) / 2`, a polynomial for `exp(r)` (Cephes'
//! expf, relative error 2e-7). Smaller exponents are clamped: denormal results would slow everything behind.

use fearless_simd::prelude::*;

const LN2_HIGH: f32 = 0.693_359_4;
const LN2_LOW: f32 = -2.121_944_4e-4;

/// `exp(max(x, -87))` per lane.
#[inline(always)]
pub(crate) fn exp<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    let splat = |value: f32| S::f32s::simd_from(simd, value);
    let x = x.max(splat(-87.0));
    let n = (x * std::f32::consts::LOG2_E).round_ties_even();
    let r = n.mul_add(splat(-LN2_LOW), n.mul_add(splat(-LN2_HIGH), x));
    let mut p = splat(1.987_569_1e-4);
    for coefficient in [1.398_199_9e-3, 8.333_452e-3, 4.166_579_6e-2, 1.666_666_5e-1, 0.5] {
        p = p.mul_add(r, splat(coefficient));
    }
    let series = p.mul_add(r * r, r + 1.0);
    let power: S::u32s = (n + 127.0).to_int::<S::u32s>();
    series * (power << 23).bitcast::<S::f32s>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    #[inline(always)]
    fn worst_relative_error<S: Simd>(simd: S) -> f64 {
        let mut worst = 0.0f64;
        for i in 0..40_000 {
            let x = -(i as f32) * 87.0 / 40_000.0;
            let found = exp(simd, S::f32s::simd_from(simd, x));
            let expected = f64::from(x).exp();
            worst = worst.max((f64::from(found[0]) / expected - 1.0).abs());
        }
        worst
    }

    #[test]
    fn agrees_with_the_library_at_this_machines_best_level() {
        let level = Level::new();
        let worst = dispatch!(level, simd => worst_relative_error(simd));
        assert!(worst < 4e-7, "{worst}");
    }

    #[inline(always)]
    fn floor_of<S: Simd>(simd: S) -> f32 {
        exp(simd, S::f32s::simd_from(simd, -1e30))[0]
    }

    #[test]
    fn far_tails_are_tiny_normal_numbers() {
        let level = Level::new();
        let tail = dispatch!(level, simd => floor_of(simd));
        assert!(tail.is_normal() && tail < 1e-37, "{tail}");
    }
}
