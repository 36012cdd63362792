//! 3-D Gaussians as trained: covariances from scales and rotations, colours from harmonics, opacities unchanged.
//!
//! ```text
//! A = J M R S,  V - h I = A A^T                                2 x 3
//! det (V - h I) = |a_0 x a_1|^2                                (Cauchy-Binet)
//! ```
//!
//! Splats that were trained "antialiased" have `o sqrt(max(det (A A^T) / det V, 2.5e-5))` (Yu et al. 2024,
//! "Mip-Splatting", eq. 11, with the published renderer's bound).

use std::ops::Range;

use fearless_simd::{f32x16, prelude::*};
use splatvol_core::cloud_view::LEAST_RATIO;
use splatvol_scene::gaussians::harmonics_count;
use splatvol_scene::{Gaussians, harmonics};

use super::project::{LANES, Seen, Source, columns, dot, store};
use super::view::CloudView;

impl Source for Gaussians {
    fn means(&self) -> &[[f32; 3]] {
        &self.attributes().means
    }

    #[inline(always)]
    fn shape<S: Simd>(&self, simd: S, rows: &[[f32x16<S>; 3]; 2], range: Range<usize>) -> [f32x16<S>; 4] {
        let attributes = self.attributes();
        let rotation = columns(simd, &attributes.rotations[range.clone()], [0.0, 0.0, 0.0, 1.0]);
        let scales = columns(simd, &attributes.scales[range], [0.0; 3]);
        let [a, b] = screen_axes(simd, rows, rotation, scales);
        let mut cross = a;
        for (k, (i, j)) in [(1, 2), (2, 0), (0, 1)].into_iter().enumerate() {
            cross[k] = a[i] * b[j] - a[j] * b[i];
        }
        [dot(a, a), dot(a, b), dot(b, b), dot(cross, cross)]
    }

    #[inline(always)]
    fn peak<S: Simd>(&self, simd: S, at: &Seen<S>, range: Range<usize>) -> f32x16<S> {
        let [opacity] = columns(simd, rows_of_one(&self.attributes().opacities[range]), [0.0]);
        if self.antialiased() {
            opacity * (at.sharp / at.det).max(f32x16::splat(simd, LEAST_RATIO)).sqrt()
        } else {
            opacity
        }
    }

    #[inline(always)]
    fn colors<S: Simd>(
        &self,
        _: S,
        view: &CloudView,
        offset: &[f32x16<S>; 3],
        (range, mut visible): (Range<usize>, u32),
    ) -> [[f32; 3]; LANES] {
        let mut offsets = [[0.0; LANES]; 3];
        store(offset, &mut offsets);
        let mut colors = [[0.0; 3]; LANES];
        while visible != 0 {
            let lane = visible.trailing_zeros() as usize;
            visible &= visible - 1;
            // The one harmonic of degree 0 is constant.
            let direction = if self.degree() > 0 {
                direction(view, [offsets[0][lane], offsets[1][lane], offsets[2][lane]])
            } else {
                [0.0; 3]
            };
            colors[lane] = color(self, range.start + lane, direction);
        }
        colors
    }
}

#[inline(always)]
fn direction(view: &CloudView, [x, y, z]: [f32; 3]) -> [f32; 3] {
    if let Some(direction) = view.direction {
        return direction;
    }
    let inverse = 1.0 / (x * x + y * y + z * z).sqrt().max(f32::MIN_POSITIVE);
    [x * inverse, y * inverse, z * inverse]
}

#[inline(always)]
fn color(gaussians: &Gaussians, index: usize, direction: [f32; 3]) -> [f32; 3] {
    let count = harmonics_count(gaussians.degree());
    let own = &gaussians.attributes().harmonics[index * count..(index + 1) * count];
    harmonics::color(gaussians.degree(), own, direction)
}

/// Rows of the 2 x 3 matrix A.
#[inline(always)]
fn screen_axes<S: Simd>(
    simd: S,
    rows: &[[f32x16<S>; 3]; 2],
    rotation: [f32x16<S>; 4],
    scales: [f32x16<S>; 3],
) -> [[f32x16<S>; 3]; 2] {
    let one = f32x16::splat(simd, 1.0);
    let [x, y, z, w] = rotation;
    let [x2, y2, z2] = [x + x, y + y, z + z];
    let [xx, yy, zz] = [x * x2, y * y2, z * z2];
    let [xy, xz, yz] = [x * y2, x * z2, y * z2];
    let [wx, wy, wz] = [w * x2, w * y2, w * z2];
    let axes = [
        [one - (yy + zz), xy + wz, xz - wy],
        [xy - wz, one - (xx + zz), yz + wx],
        [xz + wy, yz - wx, one - (xx + yy)],
    ];
    let mut screen = *rows;
    for row in 0..2 {
        for k in 0..3 {
            screen[row][k] = dot(rows[row], axes[k]) * scales[k];
        }
    }
    screen
}

/// Numbers as rows of one.
#[inline(always)]
fn rows_of_one(values: &[f32]) -> &[[f32; 1]] {
    values.as_chunks::<1>().0
}
