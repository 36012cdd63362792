//! Line integrals of optical depth and emission: X-rays, each pixel shown as one homogeneous slab.

use fearless_simd::{f32x16, mask32x16, prelude::*};

use super::Blend;
use super::light::CutGaussian;
use crate::simd::math::exp2;
use crate::splats::composite::{Block, LANES};
use crate::splats::project::ProjectedSplat;
use crate::splats::resolve::Resolved;

/// In any order. Peaks are optical depths through the middle; the state of a pixel is its optical depth so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Integral {
    profile: CutGaussian,
}

impl Integral {
    pub(crate) fn new(profile: CutGaussian) -> Self {
        Self { profile }
    }
}

impl Blend for Integral {
    const EMPTY: Block = Block {
        state: [0.0; LANES],
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

    #[inline(always)]
    fn add<S: Simd>(self, simd: S, splat: &ProjectedSplat, exponent: f32x16<S>, block: &mut Block) -> bool {
        if let Some(depths) = self.profile.depths(simd, splat, exponent) {
            block.state = (f32x16::simd_from(simd, block.state) + depths).to_array();
            for (sum, value) in block.sums.iter_mut().zip(splat.values()) {
                *sum = (f32x16::simd_from(simd, *sum) + depths * value).to_array();
            }
        }
        true
    }

    #[inline(always)]
    fn resolve<S: Simd>(self, simd: S, block: &Block) -> Resolved {
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let total = f32x16::simd_from(simd, block.state);
        let touched = total.simd_gt(zero);
        let inverse = one / touched.select(total, one);
        let alpha = one - exp2(simd, total * -std::f32::consts::LOG2_E);
        let mut color = [[0.0; LANES]; 4];
        for (channel, sum) in color.iter_mut().zip(&block.sums) {
            *channel = (f32x16::simd_from(simd, *sum) * inverse * alpha).to_array();
        }
        color[3] = alpha.to_array();
        let depth = f32x16::simd_from(simd, block.sums[3]) * inverse;
        Resolved {
            color,
            depth: touched
                .select(depth, f32x16::splat(simd, f32::INFINITY))
                .to_array(),
            optical_depth: total.to_array(),
        }
    }
}
