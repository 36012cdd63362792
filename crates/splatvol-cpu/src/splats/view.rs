//! View: the low-pass of sixteen footprints at a time; the view itself is shared with other engines
//! ([`splatvol_core::cloud_view`]).

use fearless_simd::{f32x16, prelude::*};

pub(crate) use splatvol_core::cloud_view::{CloudView, LEAST_VARIANCE, LowPass, REFERENCE_TILE, rows};

/// Variance to add to covariances xx, xy, yy of this determinant.
#[inline(always)]
pub(super) fn added<S: Simd>(
    simd: S,
    low_pass: LowPass,
    [xx, xy, yy, determinant]: [f32x16<S>; 4],
) -> f32x16<S> {
    let variance = match low_pass {
        LowPass::Added(variance) => return f32x16::splat(simd, variance),
        LowPass::Lacking(variance) => f32x16::splat(simd, variance),
    };
    // The smaller eigenvalue as determinant over the larger one, without cancellation.
    let half = (xx - yy) * 0.5;
    let larger = (xx + yy) * 0.5 + (half * half + xy * xy).sqrt();
    let smaller = determinant / larger.max(f32x16::splat(simd, f32::MIN_POSITIVE));
    (variance - smaller).max(f32x16::splat(simd, LEAST_VARIANCE))
}
