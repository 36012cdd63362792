//! Optical depths in linear light: each splat is a slab of transmittance `exp(-tau)`.

use fearless_simd::{f32x16, mask32x16, prelude::*};

use splatvol_core::cloud_view::CutProfile;

use super::Blend;
use crate::simd::math::{exp2, exp2_quick, log2};
use crate::splats::composite::{Block, LANES};
use crate::splats::project::ProjectedSplat;
use crate::splats::resolve::Resolved;

/// Larger optical depths through the middle count as this one.
const DEEPEST: f32 = 1e9;

/// The profile of whole footprints of optical depth, sixteen pixels at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CutGaussian(pub CutProfile);

impl CutGaussian {
    /// Cut at so many standard deviations.
    pub(crate) fn new(cut: f64) -> Self {
        Self(CutProfile::new(cut))
    }

    #[inline(always)]
    pub(super) fn is_seen<S: Simd>(simd: S, peak: f32x16<S>) -> mask32x16<S> {
        peak.simd_gt(f32x16::splat(simd, 0.0))
    }

    #[inline(always)]
    pub(super) fn kept<S: Simd>(self, simd: S, peak: f32x16<S>) -> f32x16<S> {
        peak.min(f32x16::splat(simd, DEEPEST)) * (1.0 / (1.0 - self.0.edge))
    }

    #[inline(always)]
    pub(super) fn end<S: Simd>(self, simd: S) -> f32x16<S> {
        f32x16::splat(simd, self.0.end)
    }

    /// Optical depths where a splat has these exponents; `None` where it has none at all.
    #[inline(always)]
    pub(super) fn depths<S: Simd>(
        self,
        simd: S,
        splat: &ProjectedSplat,
        exponent: f32x16<S>,
    ) -> Option<f32x16<S>> {
        let (end, zero) = (f32x16::splat(simd, -self.0.end), f32x16::splat(simd, 0.0));
        let counts = exponent.simd_gt(end);
        if !counts.any_true() {
            return None;
        }
        let above = (exp2_quick(simd, exponent.max(end).min(zero)) - self.0.edge).max(zero);
        Some(counts.select(above * splat.peak, zero))
    }
}

/// Front to back. Peaks are optical depths through the middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Light {
    profile: CutGaussian,
    termination: f32,
}

impl Light {
    /// Pixels end where their transmittance falls to `termination`.
    pub(crate) fn new(profile: CutGaussian, termination: f32) -> Self {
        Self { profile, termination }
    }
}

impl Blend for Light {
    const EMPTY: Block = Block {
        state: [1.0; LANES],
        sums: [[0.0; LANES]; 4],
    };

    #[inline(always)]
    fn is_seen<S: Simd>(self, simd: S, peak: f32x16<S>) -> mask32x16<S> {
        CutGaussian::is_seen(simd, peak)
    }

    #[inline(always)]
    fn kept<S: Simd>(self, simd: S, peak: f32x16<S>) -> f32x16<S> {
        self.profile.kept(simd, peak)
    }

    #[inline(always)]
    fn end<S: Simd>(self, simd: S, _: f32x16<S>) -> f32x16<S> {
        self.profile.end(simd)
    }

    /// A pixel that has ended keeps its transmittance with the sign turned.
    #[inline(always)]
    fn add<S: Simd>(self, simd: S, splat: &ProjectedSplat, exponent: f32x16<S>, block: &mut Block) -> bool {
        let Some(depths) = self.profile.depths(simd, splat, exponent) else {
            return true;
        };
        let zero = f32x16::splat(simd, 0.0);
        let through = f32x16::simd_from(simd, block.state);
        let open = through.simd_gt(zero);
        let next = through * exp2(simd, depths * -std::f32::consts::LOG2_E);
        let share = open.select(through - next, zero);
        let goes_on = open & next.simd_gt(f32x16::splat(simd, self.termination));
        let ended = open.select(-next, through);
        block.state = goes_on.select(next, ended).to_array();
        for (sum, value) in block.sums.iter_mut().zip(splat.values()) {
            *sum = (f32x16::simd_from(simd, *sum) + share * value).to_array();
        }
        goes_on.any_true()
    }

    #[inline(always)]
    fn resolve<S: Simd>(self, simd: S, block: &Block) -> Resolved {
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let through = f32x16::simd_from(simd, block.state).abs();
        let alpha = one - through;
        let touched = alpha.simd_gt(zero);
        let depth = f32x16::simd_from(simd, block.sums[3]) / touched.select(alpha, one);
        let least = f32x16::splat(simd, f32::MIN_POSITIVE);
        let optical_depth = log2(simd, through.max(least)) * -std::f32::consts::LN_2;
        let [red, green, blue, _] = block.sums;
        Resolved {
            color: [red, green, blue, alpha.to_array()],
            depth: touched
                .select(depth, f32x16::splat(simd, f32::INFINITY))
                .to_array(),
            optical_depth: touched.select(optical_depth, zero).to_array(),
        }
    }
}
