//! Blending as in the published renderer of Gaussians: opacities, composited in display colours.

use fearless_simd::{f32x16, mask32x16, prelude::*};
use splatvol_core::cloud_view::{
    LEAST_ALPHA, LEAST_SPREAD, LEAST_TRANSMITTANCE, LOG2_255, MOST_ALPHA, UNSEEN_ALPHA,
};
use splatvol_scene::transfer_function::srgb_from_linear;

use super::Blend;
use crate::simd::math::{exp2_quick, linear_from_srgb, log2};
use crate::splats::composite::{Block, LANES};
use crate::splats::project::ProjectedSplat;
use crate::splats::resolve::Resolved;
use crate::splats::settings::sane;

/// Blending as in the published renderer. Peaks are opacities; a splat keeps their logarithm to base 2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Published {
    /// Display colour behind everything, straight.
    color: [f32; 3],
    alpha: f32,
    /// The background in linear light, premultiplied.
    empty: [f32; 4],
}

impl Published {
    /// Blending over a background, in linear light with straight alpha.
    pub(crate) fn new(background: [f32; 4]) -> Self {
        let [r, g, b, alpha] = background.map(|value| sane(f64::from(value)));
        let alpha = alpha.min(1.0) as f32;
        let [red, green, blue] = [r, g, b].map(|channel| channel as f32 * alpha);
        Self {
            color: [r, g, b].map(|channel| srgb_from_linear(channel) as f32),
            alpha,
            empty: [red, green, blue, alpha],
        }
    }
}

impl Blend for Published {
    const EMPTY: Block = Block {
        state: [1.0; LANES],
        sums: [[0.0; LANES]; 4],
    };

    #[inline(always)]
    fn is_seen<S: Simd>(self, simd: S, peak: f32x16<S>) -> mask32x16<S> {
        peak.simd_ge(f32x16::splat(simd, LEAST_ALPHA))
    }

    #[inline(always)]
    fn kept<S: Simd>(self, simd: S, peak: f32x16<S>) -> f32x16<S> {
        log2(simd, peak.max(f32x16::splat(simd, UNSEEN_ALPHA)))
    }

    #[inline(always)]
    fn end<S: Simd>(self, _: S, kept: f32x16<S>) -> f32x16<S> {
        kept + LOG2_255
    }

    /// Three standard deviations, rounded up.
    #[inline(always)]
    fn square<S: Simd>(self, simd: S, [xx, xy, yy]: [f32x16<S>; 3]) -> f32x16<S> {
        let half = (xx - yy) * 0.5;
        let spread = (half * half + xy * xy)
            .max(f32x16::splat(simd, LEAST_SPREAD))
            .sqrt();
        (((xx + yy) * 0.5 + spread).sqrt() * 3.0).ceil()
    }

    #[inline(always)]
    fn offset(self, splat: &ProjectedSplat) -> f32 {
        splat.peak
    }

    /// A pixel that has ended keeps its transmittance with the sign turned.
    #[inline(always)]
    fn add<S: Simd>(self, simd: S, splat: &ProjectedSplat, exponent: f32x16<S>, block: &mut Block) -> bool {
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let most = f32x16::splat(simd, MOST_ALPHA);
        let least = f32x16::splat(simd, LEAST_TRANSMITTANCE);
        let threshold = f32x16::splat(simd, -LOG2_255);
        let counts = exponent.simd_ge(threshold);
        if !counts.any_true() {
            return true;
        }
        let alpha = exp2_quick(simd, exponent.max(threshold)).min(most);
        let alpha = counts.select(alpha, zero);
        let through = f32x16::simd_from(simd, block.state);
        let next = through * (one - alpha);
        let goes_on = next.simd_ge(least);
        let share = goes_on.select(through * alpha, zero);
        let ended = -through.abs();
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
        let covered = one - through;
        let behind = through * self.alpha;
        let alpha = covered + behind;
        let seen = alpha.simd_gt(zero);
        let inverse = one / seen.select(alpha, one);
        let mut color = [[0.0; LANES]; 4];
        let (sums, unders) = (block.sums.iter(), self.color);
        for (channel, (sum, under)) in color.iter_mut().zip(sums.zip(unders)) {
            let sum = f32x16::simd_from(simd, *sum) + behind * under;
            let linear = linear_from_srgb(simd, sum * inverse) * alpha;
            *channel = seen.select(linear, zero).to_array();
        }
        color[3] = alpha.to_array();
        let touched = covered.simd_gt(zero);
        let depth = f32x16::simd_from(simd, block.sums[3]) / touched.select(covered, one);
        let depth = touched.select(depth, f32x16::splat(simd, f32::INFINITY));
        let optical_depth = log2(simd, through) * -std::f32::consts::LN_2;
        Resolved {
            color,
            depth: depth.to_array(),
            optical_depth: touched.select(optical_depth, zero).to_array(),
        }
    }

    fn empty(self) -> [f32; 4] {
        self.empty
    }
}
