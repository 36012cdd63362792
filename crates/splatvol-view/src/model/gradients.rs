//! How often values and gradient magnitudes come together: what a transfer function of both is drawn over
//! (Kindlmann and Durkin 1998). Boundaries between materials are arcs in it.
//!
//! Gradients are central differences of the samples, world; the samples are those of a lattice that is coarse enough to be counted at once.

use splatvol::glam::{DMat3, DVec3};

use super::shown_volume::ShownVolume;

/// Columns of values, and rows of gradient magnitudes.
pub const SIZE: [usize; 2] = [160, 100];
/// Most samples that are counted.
const MOST_SAMPLES: usize = 250_000;
/// Share of the samples whose gradients are steeper than the last row, and room above them.
const STEEPER: f64 = 1e-3;
const ROOM: f64 = 1.15;

/// A histogram of values and gradient magnitudes.
#[derive(Debug, Clone, PartialEq)]
pub struct Gradients {
    /// Smallest and largest value.
    pub values: [f64; 2],
    /// Gradient magnitude at the upper end of the last row, data units per world length.
    pub steepest: f64,
    /// Counts, row by row of [`SIZE`], the flattest first.
    pub counts: Vec<u32>,
}

impl Gradients {
    /// Counts the samples of a volume.
    pub fn of(shown: ShownVolume<'_>) -> Self {
        let values = shown.volume.value_range();
        let pairs = pairs(shown);
        let mut magnitudes: Vec<f64> = pairs.iter().map(|[_, magnitude]| *magnitude).collect();
        let last = magnitudes.len().saturating_sub(1);
        let place = last - (STEEPER * last as f64) as usize;
        let steep = match magnitudes.is_empty() {
            true => 0.0,
            false => *magnitudes.select_nth_unstable_by(place, f64::total_cmp).1,
        };
        // A field without gradients has an axis, too.
        let steepest = if steep > 0.0 { ROOM * steep } else { 1.0 };
        let [low, high] = values;
        let mut counts = vec![0; SIZE[0] * SIZE[1]];
        let cell = |share: f64, count: usize| ((share * count as f64) as usize).min(count - 1);
        for [value, magnitude] in pairs {
            let column = cell((value - low) / (high - low).max(f64::MIN_POSITIVE), SIZE[0]);
            let row = cell(magnitude / steepest, SIZE[1]);
            if magnitude <= steepest {
                counts[row * SIZE[0] + column] += 1;
            }
        }
        Self {
            values,
            steepest,
            counts,
        }
    }
}

/// Values and gradient magnitudes of a lattice of samples, without those that are missing or have such neighbours.
fn pairs(shown: ShownVolume<'_>) -> Vec<[f64; 2]> {
    let dims = shown.volume.grid().dims();
    let count: usize = dims.iter().product();
    let stride = (1..).find(|stride| count / (stride * stride * stride) <= MOST_SAMPLES);
    let stride = stride.unwrap_or(1);
    let world_from_gradient: DMat3 = shown.world_from_voxel().matrix3.inverse().transpose();
    let lattice = |axis: usize| (0..dims[axis]).skip(stride / 2).step_by(stride);
    let mut pairs = Vec::new();
    for z in lattice(2) {
        for y in lattice(1) {
            for x in lattice(0) {
                let voxel = [x, y, z];
                let value = shown.value(voxel);
                let magnitude = (world_from_gradient * difference(shown, voxel, dims)).length();
                if value.is_finite() && magnitude.is_finite() {
                    pairs.push([value, magnitude]);
                }
            }
        }
    }
    pairs
}

/// Differences per voxel along each axis; at a border of the grid, to the one neighbour that there is.
fn difference(shown: ShownVolume<'_>, voxel: [usize; 3], dims: [usize; 3]) -> DVec3 {
    let along = |axis: usize| {
        let (mut before, mut after) = (voxel, voxel);
        before[axis] = voxel[axis].saturating_sub(1);
        after[axis] = (voxel[axis] + 1).min(dims[axis] - 1);
        match after[axis] - before[axis] {
            0 => 0.0,
            way => (shown.value(after) - shown.value(before)) / way as f64,
        }
    };
    DVec3::new(along(0), along(1), along(2))
}
