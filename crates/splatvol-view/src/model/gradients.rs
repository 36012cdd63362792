//! How often values and gradient magnitudes come together: what a transfer function of both is drawn over
//! (Kindlmann and Durkin 1998). Boundaries between materials are arcs in it.
//!
//! Gradients are central differences of the samples, world; the samples are those of a lattice that is coarse enough to be counted at once.

use splatvol::Volume;
use splatvol::glam::{DAffine3, DMat3, DVec3};

use super::shown_volume::value;

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
    /// Counts the samples of a volume that lies somewhere in the world.
    ///
    /// # Panics
    /// Volumes that are not in memory.
    pub fn of(volume: &Volume, world_from_voxel: &DAffine3) -> Self {
        let values = volume.value_range();
        let pairs = pairs(volume, world_from_voxel);
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
fn pairs(volume: &Volume, world_from_voxel: &DAffine3) -> Vec<[f64; 2]> {
    let dims = volume.grid().dims();
    let count: usize = dims.iter().product();
    let stride = (1..).find(|stride| count / (stride * stride * stride) <= MOST_SAMPLES);
    let stride = stride.unwrap_or(1);
    let world_from_gradient: DMat3 = world_from_voxel.matrix3.inverse().transpose();
    let lattice = |axis: usize| (0..dims[axis]).skip(stride / 2).step_by(stride);
    let mut pairs = Vec::new();
    for z in lattice(2) {
        for y in lattice(1) {
            for x in lattice(0) {
                let voxel = [x, y, z];
                let value = value(volume, voxel);
                let magnitude = (world_from_gradient * difference(volume, voxel)).length();
                if value.is_finite() && magnitude.is_finite() {
                    pairs.push([value, magnitude]);
                }
            }
        }
    }
    pairs
}

/// Differences per voxel along each axis; at a border of the grid, to the one neighbour that there is.
fn difference(volume: &Volume, voxel: [usize; 3]) -> DVec3 {
    let dims = volume.grid().dims();
    let along = |axis: usize| {
        let (mut before, mut after) = (voxel, voxel);
        before[axis] = voxel[axis].saturating_sub(1);
        after[axis] = (voxel[axis] + 1).min(dims[axis] - 1);
        match after[axis] - before[axis] {
            0 => 0.0,
            way => (value(volume, after) - value(volume, before)) / way as f64,
        }
    };
    DVec3::new(along(0), along(1), along(2))
}

#[cfg(test)]
mod tests {
    use splatvol::volume::Samples;
    use splatvol::{Grid, LengthUnit, Rescale};

    use super::*;

    #[test]
    fn gradients_are_in_data_units_per_world_length() {
        // 3 per voxel along x and 4 along y, of which the voxels are 0.5 and 2 long.
        let dims = [10, 8, 6];
        let grid = Grid::centred(dims, [0.5, 2.0, 1.0]).unwrap();
        let world_from_voxel = grid.world_from_voxel();
        let samples = (0..480).map(|index| (3 * (index % 10) + 4 * (index / 10 % 8)) as f32);
        let samples = Samples::F32(samples.collect::<Vec<_>>().into());
        let volume = Volume::new(grid, samples, Rescale::default(), LengthUnit::Unknown).unwrap();
        let expected = f64::hypot(3.0 / 0.5, 4.0 / 2.0);
        for [_, magnitude] in pairs(&volume, &world_from_voxel) {
            assert!((magnitude - expected).abs() < 1e-9, "{magnitude}");
        }
        let gradients = Gradients::of(&volume, &world_from_voxel);
        assert_eq!(gradients.values, [0.0, 55.0]);
        assert!((gradients.steepest - ROOM * expected).abs() < 1e-9);
        assert_eq!(gradients.counts.iter().sum::<u32>(), 480);
        // All of them in one row.
        let row = (SIZE[1] as f64 / ROOM) as usize;
        assert_eq!(
            gradients.counts[row * SIZE[0]..(row + 1) * SIZE[0]]
                .iter()
                .sum::<u32>(),
            480
        );
    }
}
