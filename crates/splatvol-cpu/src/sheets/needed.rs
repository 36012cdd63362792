//! Needed blocks: those of a square of blocks in which a group's footprints weigh anything.
//!
//! A footprint is an ellipse, its blocks are a square: of voxels four times as long as wide more than half of them may
//! hold nothing. Let `d` be a point's offset from the footprint's centre and `q(d) = xx x^2 + xy x y + yy y^2` its
//! exponent, negative, to base 2. A block is left out where `q` is below that of the kernel's cut by [`BELOW_CUT`],
//! at each of its points and wherever the centre lies. Of round footprints only corners could be left out, and loops over small
//! ones have no branches: both are added whole.
//!
//! Of all voxels of a slab the same blocks are needed, whatever the tile, so that pixels depend on neither. Where the
//! centre lies: the square is put around that at the middle of a voxel's sheets, to a block; those on the group's sheets
//! have moved from there along the kernel's slope, and with the perspective, the farther from the principal point.

use std::f32::consts::LOG2_E;

use splatvol_core::plan::{BELOW_CUT, MAX_BLOCKS, TRIMMED};

use super::ring::LANES;
use super::sheet::GroupShape;

/// Rounding of places, raster points.
const ROUNDING: f32 = 0.01;

/// Blocks of a square that are needed: for each row the columns, as bits.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Needed([u32; MAX_BLOCKS]);

/// What footprints on all of a group's sheets share.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Footprints {
    /// Depth at which the square lies around the centre, and raster points per world length there.
    pub anchor: f32,
    pub scale: f32,
    /// Drift of the centre per depth.
    pub slope: [f32; 2],
    /// Largest distance of a centre from the principal point, raster points.
    pub farthest: [f32; 2],
    /// Standard deviations at which footprints are cut.
    pub cut: f32,
    /// Blocks along the square's edge.
    pub size: usize,
}

/// A sheet's ellipse about its own centre.
struct Ellipse {
    xx: f32,
    xy: f32,
    yy: f32,
    /// Exponent on its edge.
    edge: f32,
}

impl Ellipse {
    /// Half of its width and of its height.
    fn half_extent(&self) -> [f32; 2] {
        let Self { xx, xy, yy, edge } = *self;
        let half = |own: f32, other: f32| (edge / (own - xy * xy / (4.0 * other))).sqrt();
        [half(xx, yy), half(yy, xx)]
    }

    /// Its least and largest x between two y; `None` where it does not lie there.
    fn within(&self, [y0, y1]: [f32; 2], [half_x, half_y]: [f32; 2]) -> Option<[f32; 2]> {
        let Self { xx, xy, yy, edge } = *self;
        let (y0, y1) = (y0.max(-half_y), y1.min(half_y));
        if y0 > y1 {
            return None;
        }
        // Where it is widest, if that is between them; else at the nearer end.
        let widest = -xy * half_x / (2.0 * yy);
        let side = |y: f32, sign: f32| {
            let y = y.clamp(y0, y1);
            let root = ((xy * y).powi(2) - 4.0 * xx * (yy * y * y - edge))
                .max(0.0)
                .sqrt();
            (xy * y + sign * root) / (-2.0 * xx)
        };
        Some([side(-widest, -1.0), side(widest, 1.0)])
    }
}

impl Needed {
    /// All blocks.
    pub(crate) fn all(size: usize) -> Self {
        let mut rows = [0; MAX_BLOCKS];
        rows[..size].fill(columns(0, size));
        Self(rows)
    }

    /// The blocks that any of a group's sheets needs.
    pub(crate) fn new(shape: &GroupShape, footprints: &Footprints) -> Self {
        let size = footprints.size;
        if size < TRIMMED {
            return Self::all(size);
        }
        let mut needed = Self::default();
        for lane in (0..LANES).filter(|&lane| shape.peak.0[lane] != 0.0) {
            let ellipse = Ellipse {
                xx: shape.xx.0[lane],
                xy: shape.xy.0[lane],
                yy: shape.yy.0[lane],
                edge: -0.5 * LOG2_E * footprints.cut * footprints.cut - BELOW_CUT,
            };
            let half = ellipse.half_extent();
            if !half.iter().all(|half| half.is_finite()) {
                return Self::all(size);
            }
            let [x, y] = footprints.centres(shape.depth.0[lane], shape.scale.0[lane]);
            for row in 0..size {
                // Offsets of the row's points.
                let strip = [(2 * row) as f32 - y[1], (2 * row + 1) as f32 - y[0]];
                if let Some([left, right]) = ellipse.within(strip, half) {
                    let first = ((left + x[0] - 1.0) * 0.5).ceil().clamp(0.0, size as f32);
                    let end = ((right + x[1]) * 0.5 + 1.0).floor().clamp(0.0, size as f32);
                    needed.0[row] |= columns(first as usize, end as usize);
                }
            }
        }
        needed
    }

    /// Whether a block is left out of footprints of this size. Tests have no cost for small ones, and little for others:
    /// those of all voxels of a slab have the same results.
    #[inline(always)]
    pub(crate) fn lacks<const ELLIPSES: bool>(&self, size: usize, [row, column]: [usize; 2]) -> bool {
        ELLIPSES && size >= TRIMMED && !self.has(row, column)
    }

    /// Whether a block is one of them.
    #[inline(always)]
    pub(crate) fn has(&self, row: usize, column: usize) -> bool {
        self.0[row] >> column & 1 != 0
    }

    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.0.iter().map(|row| row.count_ones() as usize).sum()
    }
}

/// Bits of the columns from the first to before the end.
fn columns(first: usize, end: usize) -> u32 {
    ((1 << end) - 1) & !((1 << first.min(end)) - 1)
}

impl Footprints {
    /// Least and largest coordinates of the centre on a sheet from the square's first point, x and y.
    fn centres(&self, depth: f32, scale: f32) -> [[f32; 2]; 2] {
        [0, 1].map(|axis| {
            let drift = (depth - self.anchor) * self.slope[axis] * scale;
            let apart = (scale / self.scale - 1.0).abs() * self.farthest[axis] + ROUNDING;
            let square = self.size as f32;
            [square - 1.5 + drift - apart, square + 0.5 + drift + apart]
        })
    }
}

#[cfg(test)]
mod tests {
    use splatvol_testing::Random;

    use super::super::sheet::Lanes16;
    use super::*;

    const DEPTHS: [f32; LANES] = [-2.0, -1.0, 0.0, 1.0];

    /// A group of ellipses of these exponents on four sheets, whose scales differ by a share per sheet.
    fn group(exponent: [f32; 3], perspective: f32) -> GroupShape {
        let of = |value: &dyn Fn(usize) -> f32| Lanes16(std::array::from_fn(|lane| value(lane % LANES)));
        GroupShape {
            depth: of(&|lane| DEPTHS[lane]),
            scale: of(&|lane| 2.0 - perspective * DEPTHS[lane]),
            xx: of(&|_| -exponent[0]),
            xy: of(&|_| -exponent[1]),
            yy: of(&|_| -exponent[2]),
            peak: of(&|_| 1.0),
        }
    }

    /// An ellipse of two standard deviations, the first along a direction, radians.
    fn ellipse([long, short]: [f32; 2], angle: f32) -> [f32; 3] {
        let (sin, cos) = angle.sin_cos();
        let [a, b] = [long, short].map(|sigma| 0.5 * LOG2_E / (sigma * sigma));
        [
            a * cos * cos + b * sin * sin,
            2.0 * (a - b) * sin * cos,
            a * sin * sin + b * cos * cos,
        ]
    }

    #[test]
    fn whatever_has_a_weight_is_needed() {
        let mut random = Random::new(17);
        for _ in 0..300 {
            let mut float = |low: f64, high: f64| random.range(low, high) as f32;
            let exponent = ellipse([float(0.6, 5.0), float(0.6, 5.0)], float(0.0, 3.2));
            let perspective = float(0.0, 0.01);
            let shape = group(exponent, perspective);
            let size = 12;
            let footprints = Footprints {
                anchor: 0.0,
                scale: 2.0,
                slope: [float(-1.0, 1.0), float(-1.0, 1.0)],
                farthest: [300.0, 200.0],
                cut: 3.3,
                size,
            };
            let needed = Needed::new(&shape, &footprints);
            let edge = -0.5 * LOG2_E * 3.3 * 3.3 - BELOW_CUT;
            for _ in 0..40 {
                // On the middle sheet: from the principal point, and from the square's first point.
                let from_principal = [float(-300.0, 300.0), float(-200.0, 200.0)];
                let square = [(); 2].map(|()| size as f32 + float(-1.5, 0.5));
                for (lane, depth) in DEPTHS.into_iter().enumerate() {
                    let scale = shape.scale.0[lane];
                    let centre = [0, 1].map(|axis| {
                        let world = from_principal[axis] / 2.0 + depth * footprints.slope[axis];
                        square[axis] + world * scale - from_principal[axis]
                    });
                    for (row, column) in (0..2 * size).flat_map(|j| (0..2 * size).map(move |i| (j, i))) {
                        let (x, y) = (column as f32 - centre[0], row as f32 - centre[1]);
                        let q = -exponent[0] * x * x - exponent[1] * x * y - exponent[2] * y * y;
                        let is_needed = needed.has(row / 2, column / 2);
                        assert!(q < edge || is_needed, "{exponent:?} {q} at {x}, {y}");
                    }
                }
            }
        }
    }

    #[test]
    fn long_footprints_leave_blocks_out() {
        let count = |sigmas: [f32; 2], angle: f32, size: usize| {
            let exponent = ellipse(sigmas, angle);
            let footprints = Footprints {
                anchor: 0.0,
                scale: 2.0,
                slope: [0.0; 2],
                farthest: [300.0; 2],
                cut: 3.3,
                size,
            };
            Needed::new(&group(exponent, 0.0), &footprints).count()
        };
        assert_eq!(count([1.3, 0.7], 0.0, 5), 25);
        assert!(count([4.9, 0.7], 0.0, 16) <= 80);
        assert!(count([4.9, 0.7], 0.7, 16) <= 128);
    }
}
