//! Blend: effect of a splat on the pixels of a block, and their final result.
//!
//! | | effect of a splat on a pixel at d from its centre | a pixel ends |
//! |---|---|---|
//! | [`Published`] | `alpha = min(0.99, o exp(-d^T V^-1 d / 2))`, nothing below 1/255; `C += T alpha c`, `T *= 1 - alpha`, c in display colours | before T falls below 1e-4 |
//! | [`Light`] | `tau = tau_0 (exp(-d^T V^-1 d / 2) - e) / (1 - e)`, e what is left at the cut; `C += T (1 - exp(-tau)) c`, `T *= exp(-tau)` | where T has fallen to the termination |
//! | [`Integral`] | the same tau; `D += tau`, `C += tau c`, shown as one slab | never |
//!
//! Kerbl et al. 2023, eq. 3; Westover 1989 and zwicker2001 eq. 4, without the linear approximation of its exponential.

mod integral;
mod light;
mod published;

use fearless_simd::{f32x16, mask32x16, prelude::*};

use super::composite::Block;
use super::project::ProjectedSplat;
use super::resolve::Resolved;

pub(crate) use integral::Integral;
pub(crate) use light::{CutGaussian, Light};
pub(crate) use published::Published;

/// Blending of splats into pixels.
pub(crate) trait Blend: Copy + Send + Sync {
    /// An empty block.
    const EMPTY: Block;

    /// Whether a splat of this peak is visible at all; its source defines the peak.
    fn is_seen<S: Simd>(self, simd: S, peak: f32x16<S>) -> mask32x16<S>;

    /// The value stored for a splat in place of its peak.
    fn kept<S: Simd>(self, simd: S, peak: f32x16<S>) -> f32x16<S>;

    /// End of a splat, given the stored peak: `log2(e) d^T V^-1 d / 2`.
    fn end<S: Simd>(self, simd: S, kept: f32x16<S>) -> f32x16<S>;

    /// Half the edge of the square around a splat beyond which it is not drawn, pixels; covariance: xx, xy, yy.
    #[inline(always)]
    fn square<S: Simd>(self, simd: S, _covariance: [f32x16<S>; 3]) -> f32x16<S> {
        f32x16::splat(simd, f32::MAX)
    }

    /// Offset added to a splat's exponents, `-log2(e) d^T V^-1 d / 2`, before they are passed to [`Blend::add`].
    #[inline(always)]
    fn offset(self, _: &ProjectedSplat) -> f32 {
        0.0
    }

    /// Composites a splat behind the pixels of a block; returns whether any pixel is still open.
    fn add<S: Simd>(self, simd: S, splat: &ProjectedSplat, exponent: f32x16<S>, block: &mut Block) -> bool;

    /// Final result of the pixels of a block.
    fn resolve<S: Simd>(self, simd: S, block: &Block) -> Resolved;

    /// The pixel of an empty tile.
    fn empty(self) -> [f32; 4] {
        [0.0; 4]
    }
}
