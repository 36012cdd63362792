//! Bricks of 8^3 voxels: the unit of culling.
//!
//! A reconstructed value is a convex combination of the coefficients within the kernel's reach. So a brick can hold
//! visible points only if extinction is not zero somewhere between the smallest and the largest coefficient of the
//! brick and its neighbours; and voxels matter only within reach of such a brick. What is culled this way cannot
//! change a pixel: near visible points every contribution is there, and elsewhere a partial sum is still a convex
//! combination of values that are invisible.

use rayon::prelude::*;

use crate::classification::ClassificationTable;
use crate::coefficients::Coefficients;

/// Voxels along a brick's edge.
pub const BRICK: usize = 8;

/// Smallest and largest value; empty where minimum exceeds maximum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Smallest value.
    pub min: f32,
    /// Largest value.
    pub max: f32,
}

impl Range {
    const EMPTY: Self = Self {
        min: f32::INFINITY,
        max: f32::NEG_INFINITY,
    };

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

/// The bricks of a volume with the coefficient range of each.
#[derive(Debug, Clone)]
pub struct BrickGrid {
    /// Voxels along x, y, z.
    pub voxels: [usize; 3],
    /// Bricks along x, y, z.
    pub dims: [usize; 3],
    ranges: Vec<Range>,
}

impl BrickGrid {
    /// Divides a volume into bricks.
    pub fn new(coefficients: &Coefficients) -> Self {
        let voxels = coefficients.dims;
        let dims = voxels.map(|n| n.div_ceil(BRICK));
        let mut grid = Self {
            voxels,
            dims,
            ranges: Vec::new(),
        };
        let range_of = |brick: usize| {
            let mut range = Range::EMPTY;
            let ([x0, y0, z0], [x1, y1, z1]) = grid.voxel_box(brick);
            for z in z0..z1 {
                for y in y0..y1 {
                    let row = (z * voxels[1] + y) * voxels[0];
                    for &c in &coefficients.values[row + x0..row + x1] {
                        // NaN, a missing sample, loses every comparison.
                        range = Range {
                            min: c.min(range.min),
                            max: c.max(range.max),
                        };
                    }
                }
            }
            range
        };
        let ranges = (0..dims.iter().product()).into_par_iter().map(range_of).collect();
        grid.ranges = ranges;
        grid
    }

    /// Number of bricks.
    pub fn len(&self) -> usize {
        self.ranges.len()
    }

    /// True for a grid without bricks (none exists: volumes are not empty).
    pub fn is_empty(&self) -> bool {
        self.ranges.is_empty()
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

    /// Bricks whose voxels can change a pixel, ascending. `reach` is how far a voxel acts, in voxels per axis.
    pub fn active(&self, table: &ClassificationTable, reach: [f64; 3]) -> Vec<u32> {
        let steps = reach.map(|r| (r / BRICK as f64).ceil() as usize);
        let mut around = self.ranges.clone();
        self.dilate(&mut around, steps, Range::join);
        let visible = |range: &Range| !range.is_empty() && table.is_visible(range.min, range.max);
        let mut active: Vec<bool> = around.iter().map(visible).collect();
        self.dilate(&mut active, steps, |a, b| a | b);
        let ids = 0..self.len() as u32;
        ids.filter(|&b| active[b as usize] && !self.ranges[b as usize].is_empty())
            .collect()
    }

    /// Bricks that hold a visible voxel of their own, ascending (pre-classification).
    pub fn visible(&self, table: &ClassificationTable) -> Vec<u32> {
        let visible = |b: &u32| {
            let range = self.ranges[*b as usize];
            !range.is_empty() && table.is_visible(range.min, range.max)
        };
        (0..self.len() as u32).filter(visible).collect()
    }

    /// Joins every brick with its neighbours up to `steps` along each axis.
    fn dilate<T: Copy>(&self, values: &mut [T], steps: [usize; 3], join: impl Fn(T, T) -> T) {
        let strides = [1, self.dims[0], self.dims[0] * self.dims[1]];
        for axis in 0..3 {
            let before = values.to_vec();
            for (index, value) in values.iter_mut().enumerate() {
                let at = index / strides[axis] % self.dims[axis];
                let low = at - steps[axis].min(at);
                let high = (at + steps[axis]).min(self.dims[axis] - 1);
                for other in low..=high {
                    *value = join(*value, before[index - at * strides[axis] + other * strides[axis]]);
                }
            }
        }
    }
}
