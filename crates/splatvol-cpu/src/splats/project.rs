//! Project: Gaussians to splats, sixteen at a time.
//!
//! ```text
//! A = J M R S                                  2 x 3;  V = A A^T + h I
//! det V = |a_0 x a_1|^2 + h (|a_0|^2 + |a_1|^2) + h^2          (Cauchy-Binet)
//! J = s [[1, 0, -x/z], [0, 1, -y/z]],  s = f / z               x/z, y/z cut at 1.3 times the picture's
//! alpha >= 1/255  <=>  d^T V^-1 d <= r^2 = 2 ln(255 o)
//! ```
//!
//! Splats that were trained "antialiased" have `o sqrt(max(det (A A^T) / det V, 2.5e-5))` (Yu et al. 2024, "Mip-Splatting",
//! eq. 11, with the published renderer's bound).

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use fearless_simd::{f32x16, mask32x16, prelude::*};
use splatvol_scene::Gaussians;
use splatvol_scene::gaussians::harmonics_count;
use splatvol_scene::harmonics;

use super::view::{REFERENCE_TILE, View};
use crate::simd::math::log2;

/// Gaussians per SIMD step.
const LANES: usize = 16;
/// `log2(255)`: splats count where the logarithm of their opacity is above its negative.
pub(crate) const LOG2_255: f32 = 7.994_353_3;
/// Bound of the determinants' ratio.
const LEAST_RATIO: f32 = 2.5e-5;

/// A Gaussian on the screen.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Splat {
    /// Pixels.
    pub centre: [f32; 2],
    /// `log2(exp(-1/2 d^T V^-1 d)) = conic . (dx^2, dx dy, dy^2)`.
    pub conic: [f32; 3],
    pub log2_opacity: f32,
    /// Half width and height of the ellipse where the opacity is 1/255, pixels.
    pub reach: [f32; 2],
    /// Display colour.
    pub color: [f32; 3],
    /// Camera depth.
    pub depth: f32,
    /// Reference tiles it may touch.
    pub rect: Rect,
}

/// First and past-the-last column, first and past-the-last row of the published renderer's tiles.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Rect {
    pub columns: [u16; 2],
    pub rows: [u16; 2],
}

/// Where a chunk of Gaussians puts its splats: slices with room for all, and the index of the first.
#[derive(Debug)]
pub(crate) struct Target<'a> {
    pub first: usize,
    pub splats: &'a mut [Splat],
    pub rects: &'a mut [Rect],
    /// Depth in the upper half, index in the lower.
    pub keys: &'a [AtomicU64],
}

/// What the lanes hold before splats are picked.
struct Lanes<S: Simd> {
    visible: mask32x16<S>,
    offset: [f32x16<S>; 3],
    values: [f32x16<S>; VALUES],
    rect: [f32x16<S>; 4],
}

/// Centre, conic, opacity, reach, depth.
const VALUES: usize = 9;

/// Projects the Gaussians of a range; returns how many can be seen.
#[inline(always)]
pub(crate) fn project<S: Simd>(
    simd: S,
    view: &View,
    gaussians: &Gaussians,
    range: Range<usize>,
    target: &mut Target<'_>,
) -> usize {
    let mut count = 0;
    let mut first = range.start;
    while first < range.end {
        let step = (range.end - first).min(LANES);
        let lanes = project_lanes(simd, view, gaussians, first..first + step);
        let mut visible = lanes.visible.to_bitmask() & ((1 << step) - 1);
        if visible != 0 {
            let (mut offset, mut values, mut rect) =
                ([[0.0; LANES]; 3], [[0.0; LANES]; VALUES], [[0.0; LANES]; 4]);
            store(&lanes.offset, &mut offset);
            store(&lanes.values, &mut values);
            store(&lanes.rect, &mut rect);
            while visible != 0 {
                let lane = visible.trailing_zeros() as usize;
                visible &= visible - 1;
                // The one harmonic of degree 0 is constant.
                let direction = if gaussians.degree() > 0 {
                    direction(view, [offset[0][lane], offset[1][lane], offset[2][lane]])
                } else {
                    [0.0; 3]
                };
                let rect = Rect {
                    columns: [rect[0][lane] as u16, rect[1][lane] as u16],
                    rows: [rect[2][lane] as u16, rect[3][lane] as u16],
                };
                let splat = Splat {
                    centre: [values[0][lane], values[1][lane]],
                    conic: [values[2][lane], values[3][lane], values[4][lane]],
                    log2_opacity: values[5][lane],
                    reach: [values[6][lane], values[7][lane]],
                    color: color(gaussians, first + lane, direction),
                    depth: values[8][lane],
                    rect,
                };
                target.splats[count] = splat;
                target.rects[count] = rect;
                let key = u64::from(splat.depth.to_bits()) << 32 | (target.first + count) as u64;
                target.keys[count].store(key, Ordering::Relaxed);
                count += 1;
            }
        }
        first += step;
    }
    count
}

/// Closures over vectors are not inlined, so everything here is loops.
#[inline(always)]
fn store<S: Simd, const N: usize>(vectors: &[f32x16<S>; N], arrays: &mut [[f32; LANES]; N]) {
    for k in 0..N {
        arrays[k] = vectors[k].to_array();
    }
}

#[inline(always)]
fn direction(view: &View, [x, y, z]: [f32; 3]) -> [f32; 3] {
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

/// Component `k` of up to sixteen rows, one per lane; the rest is `fill`.
#[inline(always)]
fn columns<S: Simd, const N: usize>(simd: S, rows: &[[f32; N]], fill: [f32; N]) -> [f32x16<S>; N] {
    let mut lanes = [[0.0; LANES]; N];
    if let Ok(rows) = <&[[f32; N]; LANES]>::try_from(rows) {
        for (lane, row) in rows.iter().enumerate() {
            for k in 0..N {
                lanes[k][lane] = row[k];
            }
        }
    } else {
        for (lane, row) in rows
            .iter()
            .chain(std::iter::repeat(&fill))
            .take(LANES)
            .enumerate()
        {
            for k in 0..N {
                lanes[k][lane] = row[k];
            }
        }
    }
    let mut vectors = [f32x16::splat(simd, 0.0); N];
    for k in 0..N {
        vectors[k] = f32x16::simd_from(simd, lanes[k]);
    }
    vectors
}

#[inline(always)]
fn dot<S: Simd>(a: [f32x16<S>; 3], b: [f32x16<S>; 3]) -> f32x16<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Rows of the 2 x 3 matrix A.
#[inline(always)]
fn screen_axes<S: Simd>(
    simd: S,
    rows: [[f32x16<S>; 3]; 2],
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
    let mut screen = rows;
    for row in 0..2 {
        for k in 0..3 {
            screen[row][k] = dot(rows[row], axes[k]) * scales[k];
        }
    }
    screen
}

#[inline(always)]
fn project_lanes<S: Simd>(simd: S, view: &View, gaussians: &Gaussians, range: Range<usize>) -> Lanes<S> {
    let zero = f32x16::splat(simd, 0.0);
    let one = f32x16::splat(simd, 1.0);
    let attributes = gaussians.attributes();
    let mut offset = columns(simd, &attributes.means[range.clone()], [0.0; 3]);
    let mut to_camera = [[zero; 3]; 3];
    for k in 0..3 {
        offset[k] = offset[k] - view.eye[0][k] - view.eye[1][k];
        for (vector, value) in to_camera[k].iter_mut().zip(view.camera_from_local[k]) {
            *vector = f32x16::splat(simd, value);
        }
    }
    let depth = dot(to_camera[2], offset);
    let mut visible = depth.simd_gt(f32x16::splat(simd, view.near));
    let inverse = if view.perspective {
        one / depth.max(f32x16::splat(simd, f32::MIN_POSITIVE))
    } else {
        one
    };
    let scale = inverse * view.scale;
    let (mut centre, mut rows) = ([zero; 2], [[zero; 3]; 2]);
    for axis in 0..2 {
        let place = dot(to_camera[axis], offset);
        centre[axis] = place * scale + view.centre[axis];
        let limit = f32x16::splat(simd, view.tangent_limit[axis]);
        let tangent = (place * inverse).max(-limit).min(limit);
        for k in 0..3 {
            rows[axis][k] = (to_camera[axis][k] - tangent * to_camera[2][k]) * scale;
        }
    }
    let rotation = columns(simd, &attributes.rotations[range.clone()], [0.0, 0.0, 0.0, 1.0]);
    let scales = columns(simd, &attributes.scales[range.clone()], [0.0; 3]);
    let [a, b] = screen_axes(simd, rows, rotation, scales);

    let (xx, xy, yy) = (dot(a, a), dot(a, b), dot(b, b));
    let mut cross = a;
    for (k, (i, j)) in [(1, 2), (2, 0), (0, 1)].into_iter().enumerate() {
        cross[k] = a[i] * b[j] - a[j] * b[i];
    }
    let sharp = dot(cross, cross);
    let det = sharp + (xx + yy) * view.low_pass + view.low_pass * view.low_pass;
    let (xx, yy) = (xx + view.low_pass, yy + view.low_pass);
    let [opacity] = columns(simd, opacities(&attributes.opacities[range]), [0.0]);
    let opacity = if view.antialiased {
        opacity * (sharp / det).max(f32x16::splat(simd, LEAST_RATIO)).sqrt()
    } else {
        opacity
    };
    // Positive and finite; NaN is neither.
    visible &= det.simd_gt(zero) & det.simd_lt(f32x16::splat(simd, f32::MAX));
    visible &= opacity.simd_ge(f32x16::splat(simd, 1.0 / 255.0));
    if !visible.any_true() {
        return Lanes {
            visible,
            offset,
            values: [zero; VALUES],
            rect: [zero; 4],
        };
    }
    let log2_opacity = log2(simd, opacity.max(f32x16::splat(simd, 1.0 / 256.0)));
    let radius2 = ((log2_opacity + LOG2_255) * (2.0 * std::f32::consts::LN_2)).max(zero);
    let reach = [(radius2 * xx).sqrt(), (radius2 * yy).sqrt()];
    let half = (xx - yy) * 0.5;
    let spread = (half * half + xy * xy).max(f32x16::splat(simd, 0.1)).sqrt();
    let three_sigma = (((xx + yy) * 0.5 + spread).sqrt() * 3.0).ceil();
    let rect = rect(simd, view, centre, reach, three_sigma);
    visible &= rect[0].simd_lt(rect[1]) & rect[2].simd_lt(rect[3]);

    let inverse = f32x16::splat(simd, -0.5 * std::f32::consts::LOG2_E) / det;
    let conic = [yy * inverse, xy * inverse * -2.0, xx * inverse];
    Lanes {
        visible,
        offset,
        values: [
            centre[0],
            centre[1],
            conic[0],
            conic[1],
            conic[2],
            log2_opacity,
            reach[0],
            reach[1],
            depth,
        ],
        rect,
    }
}

/// Numbers as rows of one.
#[inline(always)]
fn opacities(values: &[f32]) -> &[[f32; 1]] {
    values.as_chunks::<1>().0
}

/// Reference tiles that both the published renderer's square of three standard deviations and the ellipse meet.
#[inline(always)]
fn rect<S: Simd>(
    simd: S,
    view: &View,
    centre: [f32x16<S>; 2],
    reach: [f32x16<S>; 2],
    three_sigma: f32x16<S>,
) -> [f32x16<S>; 4] {
    const EDGE: f32 = REFERENCE_TILE as f32;
    let zero = f32x16::splat(simd, 0.0);
    let mut rect = [zero; 4];
    for axis in 0..2 {
        // Pixels are numbered by their centres there.
        let place = centre[axis] - 0.5;
        let low = (place - three_sigma.min(reach[axis] + 0.01)) * (1.0 / EDGE);
        let square = (place + three_sigma + (EDGE - 1.0)) * (1.0 / EDGE);
        let own = (place + reach[axis] + (EDGE + 0.01)) * (1.0 / EDGE);
        let past = f32x16::splat(simd, view.reference_tiles[axis] as f32);
        rect[2 * axis] = low.floor().max(zero).min(past);
        rect[2 * axis + 1] = square.min(own).floor().max(zero).min(past);
    }
    rect
}
