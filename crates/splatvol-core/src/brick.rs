//! Bricks of 8^3 voxels, in which all engines handle volumes; and which bricks of a volume can be seen as a cloud,
//! by the ranges of their 4^3 blocks. Sheets cull by cells instead ([`crate::visibility`]).
//!
//! A block can hold visible points only if extinction is non-zero somewhere in the range of the reconstruction
//! there: the range of the samples within the kernel's reach, widened by [`OVERSHOOT`] where the kernel
//! interpolates. Voxels matter only within reach of such a block. Elsewhere the reconstruction lacks contributions,
//! but it stays within an invisible range, so culling does not change the picture.

use rayon::prelude::*;

use crate::classification::ClassificationTable;

/// Voxels along a brick's edge.
pub const BRICK: usize = 8;
/// Voxels along a block's edge.
pub const BLOCK: usize = 4;

/// Overshoot of an interpolating reconstruction beyond the range of the samples around, relative to that range's
/// width. Measured on random noise, the worst case: 0.38 (prefiltered Gaussian, sigma 0.7); data of any smoothness
/// stays below 0.15.
pub const OVERSHOOT: f32 = 0.5;

/// Smallest and largest value; empty where minimum exceeds maximum.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Range {
    min: f32,
    max: f32,
}

impl Range {
    const EMPTY: Self = Self {
        min: f32::INFINITY,
        max: f32::NEG_INFINITY,
    };

    /// NaN, a missing sample, loses every comparison.
    fn with(self, value: f32) -> Self {
        Self {
            min: value.min(self.min),
            max: value.max(self.max),
        }
    }

    fn join(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    fn is_empty(self) -> bool {
        self.min > self.max
    }
}

/// A brick with voxels that can change a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ActiveBrick {
    /// Index in the grid.
    pub brick: u32,
    /// Bit `x + 2 y + 4 z` for each of its 2 x 2 x 2 blocks that matter.
    pub blocks: u8,
}

/// The bricks of a volume with the sample range of each block.
#[derive(Debug, Clone)]
pub struct BrickGrid {
    /// Voxels along x, y, z.
    pub voxels: [usize; 3],
    /// Bricks along x, y, z.
    dims: [usize; 3],
    /// Blocks along x, y, z: two per brick, the last ones possibly empty.
    blocks: [usize; 3],
    ranges: Vec<Range>,
    overshoot: f32,
}

impl BrickGrid {
    /// Divides normalised samples (x fastest, NaN where missing) into bricks. `interpolating`: whether the
    /// reconstruction from them may overshoot.
    pub fn new(samples: &[f32], voxels: [usize; 3], interpolating: bool) -> Self {
        let dims = voxels.map(|n| n.div_ceil(BRICK));
        let blocks = dims.map(|n| n * (BRICK / BLOCK));
        let range_of = |block: usize| {
            let at = [
                block % blocks[0],
                block / blocks[0] % blocks[1],
                block / (blocks[0] * blocks[1]),
            ];
            let [xs, ys, zs]: [_; 3] =
                std::array::from_fn(|a| (at[a] * BLOCK).min(voxels[a])..((at[a] + 1) * BLOCK).min(voxels[a]));
            let mut range = Range::EMPTY;
            for z in zs {
                for y in ys.clone() {
                    let row = (z * voxels[1] + y) * voxels[0];
                    range = samples[row + xs.start..row + xs.end]
                        .iter()
                        .fold(range, |r, &v| r.with(v));
                }
            }
            range
        };
        let count: usize = blocks.iter().product();
        let ranges = (0..count)
            .into_par_iter()
            .with_min_len(1 << 10)
            .map(range_of)
            .collect();
        Self {
            voxels,
            dims,
            blocks,
            ranges,
            overshoot: if interpolating { OVERSHOOT } else { 0.0 },
        }
    }

    /// Number of bricks.
    pub fn len(&self) -> usize {
        self.dims.iter().product()
    }

    /// True for a grid without bricks (none exists: volumes are not empty).
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// First voxel of a brick, and one past its last.
    pub fn voxel_box(&self, brick: usize) -> ([usize; 3], [usize; 3]) {
        let [bx, by, _] = self.dims;
        let first = [brick % bx, brick / bx % by, brick / (bx * by)].map(|b| b * BRICK);
        (
            first,
            std::array::from_fn(|a| (first[a] + BRICK).min(self.voxels[a])),
        )
    }

    /// Bricks whose voxels can change a pixel of a reconstruction, ascending. `reach`: a voxel's, in voxels per
    /// axis, including the low-pass and a sheet's spacing.
    pub fn active(&self, table: &ClassificationTable, reach: [f64; 3]) -> Vec<ActiveBrick> {
        let steps = reach.map(|r| (r / BLOCK as f64).ceil() as usize);
        let mut around = self.ranges.clone();
        self.dilate(&mut around, steps, Range::join);
        let visible = |range: &Range| {
            let slack = self.overshoot * (range.max - range.min);
            !range.is_empty() && table.is_visible(range.min - slack, range.max + slack)
        };
        let mut active: Vec<bool> = around.iter().map(visible).collect();
        self.dilate(&mut active, steps, |a, b| a | b);
        self.gather(|block| active[block] && !self.ranges[block].is_empty())
    }

    /// Bricks that hold a visible voxel of their own, ascending (pre-classification).
    pub fn visible(&self, table: &ClassificationTable) -> Vec<ActiveBrick> {
        self.gather(|block| {
            let range = self.ranges[block];
            !range.is_empty() && table.is_visible(range.min, range.max)
        })
    }

    fn gather(&self, wanted: impl Fn(usize) -> bool) -> Vec<ActiveBrick> {
        let [bx, by, _] = self.dims;
        let bricks = (0..self.len()).map(|brick| {
            let first = [brick % bx, brick / bx % by, brick / (bx * by)].map(|b| 2 * b);
            let bit = |i: usize| {
                let [x, y, z]: [usize; 3] = std::array::from_fn(|a| first[a] + (i >> a & 1));
                u8::from(wanted((z * self.blocks[1] + y) * self.blocks[0] + x)) << i
            };
            ActiveBrick {
                brick: brick as u32,
                blocks: (0..8).map(bit).sum(),
            }
        });
        bricks.filter(|brick| brick.blocks != 0).collect()
    }

    /// Joins every block with its neighbours up to `steps` along each axis.
    fn dilate<T: Copy>(&self, values: &mut [T], steps: [usize; 3], join: impl Fn(T, T) -> T) {
        let strides = [1, self.blocks[0], self.blocks[0] * self.blocks[1]];
        for axis in 0..3 {
            let before = values.to_vec();
            for (index, value) in values.iter_mut().enumerate() {
                let at = index / strides[axis] % self.blocks[axis];
                let low = at - steps[axis].min(at);
                let high = (at + steps[axis]).min(self.blocks[axis] - 1);
                let line = index - at * strides[axis];
                *value = (low..=high).fold(*value, |sum, other| {
                    join(sum, before[line + other * strides[axis]])
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use splatvol_scene::{ColorPoint, OpacityPoint, TransferFunction};

    #[test]
    fn only_what_reaches_the_visible_voxel_is_active() {
        let dims = [40, 40, 40];
        let mut samples = vec![0.0; 64_000];
        samples[(20 * 40 + 20) * 40 + 20] = 1.0;
        let opacity = vec![OpacityPoint::new(0.6, 0.0), OpacityPoint::new(0.9, 0.5)];
        let tf = TransferFunction::new(vec![ColorPoint::new(0.0, [1.0; 3])], opacity, None).unwrap();
        let table = ClassificationTable::new(&tf, [0.0, 1.0], 1.0);
        let grid = BrickGrid::new(&samples, dims, false);
        // Block 5 of 10 along each axis holds it. Its value acts one block around, and what is seen there one
        // further.
        let blocks: u32 = grid
            .active(&table, [3.0; 3])
            .iter()
            .map(|b| b.blocks.count_ones())
            .sum();
        assert_eq!(blocks, 5 * 5 * 5);
        assert_eq!(
            grid.visible(&table),
            [ActiveBrick {
                brick: 2 + 5 * (2 + 5 * 2),
                blocks: 128
            }]
        );
    }
}
