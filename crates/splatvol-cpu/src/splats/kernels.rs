//! Kernels of all other items - points, samples of meshes, voxels, Gaussians in linear light - as whole splats.
//!
//! A kernel holds a covariance, and either a mass m, extinction integrated over space, or the optical depth t of a
//! ray through its middle (Gaussians, the same from every side). The optical depth in the middle of its splat is
//! that of a ray through it (zwicker2001 eq. 22); widening by the low-pass reduces it.
//!
//! ```text
//! V - h I = P Sigma P^T,  det (V - h I) = w^T adj(Sigma) w,  w = p_0 x p_1       P = J M, of rows p
//! tau = m s^2 l / (2 pi sqrt(det V)),  l = sqrt(1 + (x/z)^2 + (y/z)^2)           or t sqrt(det (V - h I) / det V)
//! ```
//!
//! Among published Gaussians a splat's opacity falls off as theirs does, from `1 - exp(-tau)`. Its colour, lit in
//! linear light, is encoded as display colour, in which these are composited. Otherwise its optical depth falls off
//! as a Gaussian. So overlapping discs of points are a surface about as opaque as in sheets, and splats smaller
//! than a pixel fade.

use std::ops::Range;

use fearless_simd::{f32x16, prelude::*};
use splatvol_core::splats::SplatCloud;
use splatvol_scene::{Camera, Lighting};

use super::blend::CutGaussian;
use super::project::{LANES, Seen, Source, columns, dot};
use super::view::{CloudView, rows};
use crate::phong::Phong;
use crate::simd::math::{exp2_quick, srgb_from_linear};

/// Optical depths beyond this are no more opaque.
const THICKEST: f32 = 60.0;

/// A cloud of kernels in its light.
#[derive(Debug)]
pub(crate) struct LitKernels<'a> {
    cloud: &'a SplatCloud,
    light: Option<Light>,
    /// The cut of its optical depths; `None` among published Gaussians, which have opacities.
    profile: Option<CutGaussian>,
}

#[derive(Debug)]
struct Light {
    phong: Phong,
    /// Rows.
    camera_from_gradient: [[f32; 3]; 3],
}

impl<'a> LitKernels<'a> {
    /// From kernels with covariances of their own.
    pub(crate) fn new(
        cloud: &'a SplatCloud,
        lighting: Option<&Lighting>,
        camera: &Camera,
        profile: Option<CutGaussian>,
    ) -> Self {
        let light = lighting.map(|lighting| Light {
            phong: Phong::new(lighting, cloud.spacing),
            camera_from_gradient: rows(cloud.gradient_from_local(camera.camera_from_world().matrix3)),
        });
        Self {
            cloud,
            light,
            profile,
        }
    }

    /// Optical depths through the middle.
    #[inline(always)]
    fn depth<S: Simd>(&self, simd: S, at: &Seen<S>, range: Range<usize>) -> f32x16<S> {
        let [carried, ..] = columns(simd, &self.cloud.payloads[range.clone()], [0.0; 4]);
        let [x, y] = at.tangent;
        let path = (x * x + y * y + 1.0).sqrt();
        let det = at.det.max(f32x16::splat(simd, f32::MIN_POSITIVE));
        let height = self.profile.map_or(1.0, |profile| profile.0.peak_of_mass);
        let per_area = at.scale * at.scale / det.sqrt() * (height * 0.5 * std::f32::consts::FRAC_1_PI);
        let of_masses = carried * path * per_area;
        let peaks_from = self.cloud.peaks_from;
        if range.end <= peaks_from {
            return of_masses;
        }
        let of_peaks = carried * (at.sharp / det).sqrt();
        let mut is_peak = [0.0; LANES];
        for (lane, is_peak) in is_peak.iter_mut().enumerate() {
            *is_peak = f32::from(u8::from(range.start + lane >= peaks_from));
        }
        let is_peak = f32x16::simd_from(simd, is_peak).simd_gt(f32x16::splat(simd, 0.0));
        is_peak.select(of_peaks, of_masses)
    }
}

impl Source for LitKernels<'_> {
    fn means(&self) -> &[[f32; 3]] {
        &self.cloud.positions
    }

    #[inline(always)]
    fn shape<S: Simd>(&self, simd: S, rows: &[[f32x16<S>; 3]; 2], range: Range<usize>) -> [f32x16<S>; 4] {
        let [xx, xy, xz, yy, yz, zz] = columns(simd, &self.cloud.covariances[range], [0.0; 6]);
        let covariance = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        let [across, down] = rows;
        let (mut on_across, mut on_down, mut normal) = (*across, *across, *across);
        for (k, (i, j)) in [(1, 2), (2, 0), (0, 1)].into_iter().enumerate() {
            on_across[k] = dot(covariance[k], *across);
            on_down[k] = dot(covariance[k], *down);
            normal[k] = across[i] * down[j] - across[j] * down[i];
        }
        let adjugate = [
            [yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy],
            [xz * yz - xy * zz, xx * zz - xz * xz, xy * xz - xx * yz],
            [xy * yz - xz * yy, xy * xz - xx * yz, xx * yy - xy * xy],
        ];
        let mut on_normal = normal;
        for k in 0..3 {
            on_normal[k] = dot(adjugate[k], normal);
        }
        let sharp = dot(normal, on_normal).max(f32x16::splat(simd, 0.0));
        [
            dot(*across, on_across),
            dot(*across, on_down),
            dot(*down, on_down),
            sharp,
        ]
    }

    #[inline(always)]
    fn peak<S: Simd>(&self, simd: S, at: &Seen<S>, range: Range<usize>) -> f32x16<S> {
        let depth = self.depth(simd, at, range);
        if self.profile.is_some() {
            return depth;
        }
        let depth = depth.min(f32x16::splat(simd, THICKEST));
        1.0 - exp2_quick(simd, depth * -std::f32::consts::LOG2_E)
    }

    #[inline(always)]
    fn colors<S: Simd>(
        &self,
        simd: S,
        _: &CloudView,
        _: &[f32x16<S>; 3],
        (range, _): (Range<usize>, u32),
    ) -> [[f32; 3]; LANES] {
        let zero = f32x16::splat(simd, 0.0);
        let [mass, emission @ ..] = columns(simd, &self.cloud.payloads[range.clone()], [1.0, 0.0, 0.0, 0.0]);
        let (mut diffuse, mut specular) = (f32x16::splat(simd, 1.0), zero);
        if let Some(light) = &self.light {
            let gradient = columns(simd, &self.cloud.gradients[range], [0.0; 3]);
            let mut turned = gradient;
            for (turned, [x, y, z]) in turned.iter_mut().zip(light.camera_from_gradient) {
                *turned = gradient[0] * x + gradient[1] * y + gradient[2] * z;
            }
            (diffuse, specular) = light.phong.lanes(simd, turned);
        }
        let mut colors = [[0.0; 3]; LANES];
        for channel in 0..3 {
            let linear = emission[channel] / mass * diffuse + specular;
            let shown = match self.profile {
                Some(_) => linear.max(zero),
                None => srgb_from_linear(simd, linear.max(zero)),
            };
            let shown = shown.to_array();
            for lane in 0..LANES {
                colors[lane][channel] = shown[lane];
            }
        }
        colors
    }
}
