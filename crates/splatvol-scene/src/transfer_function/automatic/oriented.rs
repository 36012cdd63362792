//! A volume's samples addressed along the world's axes, so that a sparse choice of samples does not depend on the order
//! in which a file stores them.

use glam::DVec3;

use crate::volume::widen;
use crate::{Grid, Volume};

/// The voxel axis along each world axis, and its sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Orientation {
    /// Voxel axis nearest to world x, y, z.
    pub(super) axes: [usize; 3],
    /// Whether it runs against the world axis.
    flipped: [bool; 3],
}

impl Orientation {
    /// The assignment of voxel axes to world axes with the largest sum of direction cosines.
    pub(super) fn of(grid: &Grid) -> Self {
        const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        let direction = grid.direction();
        let cosine = |world: usize, axis: usize| direction.col(axis)[world];
        let fit = |order: &[usize; 3]| -> f64 { (0..3).map(|world| cosine(world, order[world]).abs()).sum() };
        // The identity wins ties up to rounding.
        let axes = ORDERS[1..].iter().fold(ORDERS[0], |best, order| {
            if fit(order) > fit(&best) + 1e-6 {
                *order
            } else {
                best
            }
        });
        Self {
            axes,
            flipped: std::array::from_fn(|world| cosine(world, axes[world]) < 0.0),
        }
    }

    /// Values per voxel axis as values per world axis.
    pub(super) fn reorder(&self, per_axis: DVec3) -> [f64; 3] {
        self.axes.map(|axis| per_axis[axis])
    }
}

/// Samples (x fastest) by their place along the world's axes.
pub(super) struct OrientedSamples<'a, T> {
    data: &'a [T],
    volume: &'a Volume,
    /// Samples along world x, y, z.
    pub(super) dims: [usize; 3],
    strides: [usize; 3],
    flipped: [bool; 3],
}

impl<'a, T: Copy + Into<f64>> OrientedSamples<'a, T> {
    /// The samples `data` of `volume`.
    pub(super) fn new(data: &'a [T], volume: &'a Volume, orientation: Orientation) -> Self {
        let dims = volume.grid().dims();
        let strides = [1, dims[0], dims[0] * dims[1]];
        Self {
            data,
            volume,
            dims: orientation.axes.map(|axis| dims[axis]),
            strides: orientation.axes.map(|axis| strides[axis]),
            flipped: orientation.flipped,
        }
    }

    /// Real value at a place; NaN or infinite where missing.
    pub(super) fn value(&self, place: [usize; 3]) -> f64 {
        let index: usize = (0..3)
            .map(|axis| {
                let step = if self.flipped[axis] {
                    self.dims[axis] - 1 - place[axis]
                } else {
                    place[axis]
                };
                step * self.strides[axis]
            })
            .sum();
        self.volume.rescale().apply(widen(self.data[index]))
    }
}
