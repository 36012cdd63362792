//! Slab: data shared by its voxels where they are integrated along rays (see `integral`).

use fearless_simd::{f32x16, prelude::*};
use splatvol_core::plan::SplatConstants;

use super::records::Records;

/// Depth of a slab's footprints, to which its voxels are moved.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slab {
    /// Least depth of their visible part.
    pub begin: f32,
    /// Depth of the plane whose scale the footprints have.
    pub depth: f64,
    /// Footprints of nearer voxels would be larger by the ratio of depths; in a slab they have one size, but masses
    /// of their own.
    pub is_wider_when_near: bool,
}

impl Slab {
    /// Largest mass of a footprint relative to that of the slab's depth.
    pub(crate) fn most(&self) -> f32 {
        if self.is_wider_when_near {
            (self.depth as f32 / self.begin).powi(2)
        } else {
            1.0
        }
    }

    /// Moves voxels to the slab's depth along their own rays. Their mass relative to the largest is expressed by
    /// the profile in depth: their offset is zero at the largest mass.
    #[inline(always)]
    pub(crate) fn gather<S: Simd>(&self, simd: S, constants: &SplatConstants, records: &mut Records) {
        let depth = f32x16::splat(simd, self.depth as f32);
        let zero = f32x16::splat(simd, 0.0);
        let most = libm::log2f(self.most());
        for n in (0..records.len).step_by(16) {
            let range = n..n + 16;
            let mut shown = depth;
            if self.is_wider_when_near {
                let own = f32x16::from_slice(simd, &records.z[n..n + 16]);
                let ratio = depth / own;
                for axis in [&mut records.x, &mut records.y] {
                    (f32x16::from_slice(simd, &axis[range.clone()]) * ratio)
                        .store_slice(&mut axis[range.clone()]);
                }
                // The logarithm of the ratio squared, by the series of the inverse hyperbolic tangent.
                let t = (depth - own) / (depth + own);
                let exponent = (t * t * (1.0 / 3.0) + 1.0) * t * (4.0 * std::f32::consts::LOG2_E) - most;
                shown = depth - (exponent.min(zero) / constants.depth_exponent).sqrt();
            }
            shown.store_slice(&mut records.z[range]);
        }
    }
}
