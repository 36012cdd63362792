//! Project: splats, sixteen at a time, to ellipses on the screen.
//!
//! ```text
//! V = J M Sigma M^T J^T + h I                                  Sigma: `Source::shape`; h: `CloudView::low_pass`
//! det V = det (V - h I) + h tr (V - h I) + h^2
//! J = s [[1, 0, -x/z], [0, 1, -y/z]],  s = f / z               x/z, y/z cut at 1.3 times the picture's
//! d^T V^-1 d <= r^2                                            `Blend::end`; where alpha >= 1/255, r^2 = 2 ln(255 o)
//! ```

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use fearless_simd::{f32x16, mask32x16, prelude::*};

use super::blend::Blend;
use super::view::{CloudView, REFERENCE_TILE, added};
use super::wanted::WantedTiles;

/// Splats per SIMD step.
pub(crate) const LANES: usize = 16;

/// An ellipse on the screen.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ProjectedSplat {
    /// Pixels.
    pub centre: [f32; 2],
    /// `log2(exp(-1/2 d^T V^-1 d)) = conic . (dx^2, dx dy, dy^2)`.
    pub conic: [f32; 3],
    /// Peak as stored by `Blend::kept`.
    pub peak: f32,
    /// Half width and height of the ellipse where it ends, pixels.
    pub reach: [f32; 2],
    /// Colour in the space of blending: display or linear light.
    pub color: [f32; 3],
    /// Camera depth.
    pub depth: f32,
    /// Reference tiles it may touch.
    pub rect: Rect,
}

impl ProjectedSplat {
    /// Blended values: colour and depth.
    #[inline(always)]
    pub(crate) fn values(&self) -> [f32; 4] {
        let [red, green, blue] = self.color;
        [red, green, blue, self.depth]
    }
}

/// First and past-the-last column, first and past-the-last row of the published renderer's tiles.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Rect {
    pub columns: [u16; 2],
    pub rows: [u16; 2],
}

/// Target of a chunk's splats: slices with room for all, the index of the first, and the tiles for which they are.
#[derive(Debug)]
pub(crate) struct Target<'a> {
    pub first: usize,
    pub wanted: &'a WantedTiles,
    pub splats: &'a mut [ProjectedSplat],
    pub rects: &'a mut [Rect],
    /// Depth in the upper half, index in the lower.
    pub keys: &'a [AtomicU64],
}

/// A source of splats: centres in its own space, and their shapes, peaks and colours in a view.
pub(crate) trait Source: Sync {
    /// Centres.
    fn means(&self) -> &[[f32; 3]];

    /// Covariances on the screen, xx, xy, yy, pixels squared, and their determinant. `rows`: of `J M`, the linear map
    /// from the source's space to pixels.
    fn shape<S: Simd>(&self, simd: S, rows: &[[f32x16<S>; 3]; 2], range: Range<usize>) -> [f32x16<S>; 4];

    /// Opacities or optical depths in the middle, as the blend defines them.
    fn peak<S: Simd>(&self, simd: S, at: &Seen<S>, range: Range<usize>) -> f32x16<S>;

    /// Colours of a range, for the lanes whose bits are set.
    fn colors<S: Simd>(
        &self,
        simd: S,
        view: &CloudView,
        offset: &[f32x16<S>; 3],
        range_and_lanes: (Range<usize>, u32),
    ) -> [[f32; 3]; LANES];
}

/// Projected shapes of splats, from which their peaks are computed.
pub(crate) struct Seen<S: Simd> {
    /// Determinant of the covariance, without the low-pass and with it, pixels to the fourth.
    pub sharp: f32x16<S>,
    pub det: f32x16<S>,
    /// Pixels per world length.
    pub scale: f32x16<S>,
    /// Slopes of the rays, cut like the covariances'.
    pub tangent: [f32x16<S>; 2],
}

/// State of the lanes before visible splats are picked.
struct Lanes<S: Simd> {
    visible: mask32x16<S>,
    offset: [f32x16<S>; 3],
    values: [f32x16<S>; VALUES],
    rect: [f32x16<S>; 4],
}

/// Centre, conic, peak, reach, depth.
const VALUES: usize = 9;

/// Projects a range of a source; returns the number of splats that are visible on wanted tiles.
#[inline(always)]
pub(crate) fn project<S: Simd>(
    simd: S,
    blend: impl Blend,
    (view, source): (&CloudView, &impl Source),
    range: Range<usize>,
    target: &mut Target<'_>,
) -> usize {
    let mut count = 0;
    let mut first = range.start;
    while first < range.end {
        let own = first..range.end.min(first + LANES);
        let lanes = project_lanes(simd, blend, (view, source), own.clone());
        let visible = lanes.visible.to_bitmask() as u32 & ((1 << own.len()) - 1);
        if visible != 0 {
            let rects = lanes.rects();
            let wanted = target.wanted.reached(&rects, visible);
            if wanted != 0 {
                let colors = source.colors(simd, view, &lanes.offset, (own.clone(), wanted));
                count += lanes.store(wanted, (&colors, &rects), (target, count));
            }
        }
        first = own.end;
    }
    count
}

impl<S: Simd> Lanes<S> {
    /// Reference tiles of all lanes.
    #[inline(always)]
    fn rects(&self) -> [Rect; LANES] {
        let mut ends = [[0.0; LANES]; 4];
        store(&self.rect, &mut ends);
        std::array::from_fn(|lane| Rect {
            columns: [ends[0][lane] as u16, ends[1][lane] as u16],
            rows: [ends[2][lane] as u16, ends[3][lane] as u16],
        })
    }

    /// Stores the wanted lanes behind the first `count` splats of the target; returns their number.
    #[inline(always)]
    fn store(
        &self,
        mut wanted: u32,
        (colors, rects): (&[[f32; 3]; LANES], &[Rect; LANES]),
        (target, mut count): (&mut Target<'_>, usize),
    ) -> usize {
        let before = count;
        let mut values = [[0.0; LANES]; VALUES];
        store(&self.values, &mut values);
        while wanted != 0 {
            let lane = wanted.trailing_zeros() as usize;
            wanted &= wanted - 1;
            let rect = rects[lane];
            let splat = ProjectedSplat {
                centre: [values[0][lane], values[1][lane]],
                conic: [values[2][lane], values[3][lane], values[4][lane]],
                peak: values[5][lane],
                reach: [values[6][lane], values[7][lane]],
                color: colors[lane],
                depth: values[8][lane],
                rect,
            };
            target.splats[count] = splat;
            target.rects[count] = rect;
            let key = u64::from(splat.depth.to_bits()) << 32 | (target.first + count) as u64;
            target.keys[count].store(key, Ordering::Relaxed);
            count += 1;
        }
        count - before
    }
}

/// Closures over vectors are not inlined, so everything here is loops.
#[inline(always)]
pub(crate) fn store<S: Simd, const N: usize>(vectors: &[f32x16<S>; N], arrays: &mut [[f32; LANES]; N]) {
    for k in 0..N {
        arrays[k] = vectors[k].to_array();
    }
}

/// Component `k` of up to sixteen rows, one per lane; the rest is `fill`.
#[inline(always)]
pub(crate) fn columns<S: Simd, const N: usize>(simd: S, rows: &[[f32; N]], fill: [f32; N]) -> [f32x16<S>; N] {
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
pub(crate) fn dot<S: Simd>(a: [f32x16<S>; 3], b: [f32x16<S>; 3]) -> f32x16<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn project_lanes<S: Simd>(
    simd: S,
    blend: impl Blend,
    (view, source): (&CloudView, &impl Source),
    range: Range<usize>,
) -> Lanes<S> {
    let zero = f32x16::splat(simd, 0.0);
    let one = f32x16::splat(simd, 1.0);
    let mut offset = columns(simd, &source.means()[range.clone()], [0.0; 3]);
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
    let (mut centre, mut tangent, mut rows) = ([zero; 2], [zero; 2], [[zero; 3]; 2]);
    for axis in 0..2 {
        let place = dot(to_camera[axis], offset);
        centre[axis] = place * scale + view.centre[axis];
        let limit = f32x16::splat(simd, view.tangent_limit[axis]);
        tangent[axis] = (place * inverse).max(-limit).min(limit);
        for k in 0..3 {
            rows[axis][k] = (to_camera[axis][k] - tangent[axis] * to_camera[2][k]) * scale;
        }
    }
    let [xx, xy, yy, sharp] = source.shape(simd, &rows, range.clone());
    let added = added(simd, view.low_pass, [xx, xy, yy, sharp]);
    let det = sharp + (xx + yy) * added + added * added;
    let (xx, yy) = (xx + added, yy + added);
    let seen = Seen {
        sharp,
        det,
        scale,
        tangent,
    };
    let peak = source.peak(simd, &seen, range);
    // Positive and finite; NaN is neither.
    visible &= det.simd_gt(zero) & det.simd_lt(f32x16::splat(simd, f32::MAX));
    visible &= blend.is_seen(simd, peak);
    if !visible.any_true() {
        return Lanes {
            visible,
            offset,
            values: [zero; VALUES],
            rect: [zero; 4],
        };
    }
    let peak = blend.kept(simd, peak);
    let radius2 = (blend.end(simd, peak) * (2.0 * std::f32::consts::LN_2)).max(zero);
    let reach = [(radius2 * xx).sqrt(), (radius2 * yy).sqrt()];
    let rect = rect(simd, view, centre, reach, blend.square(simd, [xx, xy, yy]));
    visible &= rect[0].simd_lt(rect[1]) & rect[2].simd_lt(rect[3]);

    let inverse = f32x16::splat(simd, -0.5 * std::f32::consts::LOG2_E) / det;
    let conic = [yy * inverse, xy * inverse * -2.0, xx * inverse];
    Lanes {
        visible,
        offset,
        values: [
            centre[0], centre[1], conic[0], conic[1], conic[2], peak, reach[0], reach[1], depth,
        ],
        rect,
    }
}

/// Reference tiles that both the square around a splat (`Blend::square`) and the ellipse meet.
#[inline(always)]
fn rect<S: Simd>(
    simd: S,
    view: &CloudView,
    centre: [f32x16<S>; 2],
    reach: [f32x16<S>; 2],
    half_square: f32x16<S>,
) -> [f32x16<S>; 4] {
    const EDGE: f32 = REFERENCE_TILE as f32;
    // Pixels by which the ellipse may be larger than computed.
    const ROUNDING: f32 = 0.01;
    let zero = f32x16::splat(simd, 0.0);
    let mut rect = [zero; 4];
    for axis in 0..2 {
        // The published renderer numbers pixels by their centres.
        let place = centre[axis] - 0.5;
        let low = (place - half_square.min(reach[axis] + ROUNDING)) * (1.0 / EDGE);
        let square = (place + half_square + (EDGE - 1.0)) * (1.0 / EDGE);
        let own = (place + reach[axis] + (EDGE + ROUNDING)) * (1.0 / EDGE);
        let past = f32x16::splat(simd, view.reference_tiles[axis] as f32);
        rect[2 * axis] = low.floor().max(zero).min(past);
        rect[2 * axis + 1] = square.min(own).floor().max(zero).min(past);
    }
    rect
}
