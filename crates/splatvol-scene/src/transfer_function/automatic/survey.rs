//! Survey of a volume for the automatic choice: a sparse, jittered sampling of values and gradients.
//!
//! The grid is cut into at most [`CELLS_PER_AXIS`]^3 cells; each gives one sample at a hashed place inside it (a plain
//! stride would alias with lattices and repeated slices), with the gradient magnitude from forward differences. So at
//! most 4 * 64^3 = 1 M voxels are touched, and 6 * 64^2 more on the faces of the grid, always the same ones, however
//! the file orders its axes.

use super::oriented::{Orientation, OrientedSamples};
use crate::{Volume, with_samples};

const CELLS_PER_AXIS: usize = 64;

/// Samples of a volume; missing (not finite) samples are left out.
pub(super) struct Survey {
    /// Cells along world x, y, z (the nearest voxel axes).
    pub(super) cells: [usize; 3],
    /// Lengths of a cell along the same axes, mean voxel spacings.
    pub(super) cell_size: [f64; 3],
    /// Value per cell, x fastest; NaN where missing.
    pub(super) values: Vec<f64>,
    /// Gradient magnitude per cell, value per voxel; NaN where missing.
    pub(super) gradients: Vec<f64>,
    /// Share of the neighbours (+x, +y, +z) of equal value, 0..1, per cell.
    pub(super) equal_neighbours: Vec<f32>,
    /// All finite values, ascending.
    pub(super) sorted: Vec<f64>,
    /// Finite values on the six faces of the grid, ascending.
    pub(super) border: Vec<f64>,
}

impl Survey {
    /// Samples `volume` sparsely.
    pub(super) fn new(volume: &Volume) -> Self {
        let grid = volume.grid();
        let orientation = Orientation::of(grid);
        let mut survey = with_samples!(volume.samples(), data => {
            take_samples(&OrientedSamples::new(data, volume, orientation))
        });
        let relative = orientation.reorder(grid.spacing() / grid.mean_spacing());
        survey.cell_size = std::array::from_fn(|axis| survey.cell_size[axis] * relative[axis]);
        survey.sorted = ascending(survey.values.iter().copied());
        survey
    }

    /// Value below which the given share of the samples lies.
    pub(super) fn quantile(&self, share: f64) -> f64 {
        quantile(&self.sorted, share)
    }

    /// Share of the samples above `value`.
    pub(super) fn share_above(&self, value: f64) -> f64 {
        let below = self.sorted.partition_point(|&v| v <= value);
        (self.sorted.len() - below) as f64 / self.sorted.len().max(1) as f64
    }

    /// Negates all values, so that dark becomes bright.
    pub(super) fn negate(&mut self) {
        for list in [&mut self.sorted, &mut self.border] {
            list.reverse();
            list.iter_mut().for_each(|v| *v = -*v);
        }
        self.values.iter_mut().for_each(|v| *v = -*v);
    }

    /// Replaces all values by their magnitudes.
    pub(super) fn make_absolute(&mut self) {
        for list in [&mut self.sorted, &mut self.border] {
            list.iter_mut().for_each(|v| *v = v.abs());
            list.sort_unstable_by(f64::total_cmp);
        }
        self.values.iter_mut().for_each(|v| *v = v.abs());
    }

    /// Mean of the samples in `range`, `None` where there is none.
    pub(super) fn mean(&self, range: [f64; 2]) -> Option<f64> {
        let start = self.sorted.partition_point(|&v| v < range[0]);
        let end = self.sorted.partition_point(|&v| v < range[1]);
        let part = self.sorted.get(start..end).filter(|part| !part.is_empty())?;
        Some(part.iter().sum::<f64>() / part.len() as f64)
    }

    /// Values along each line of cells parallel to an axis.
    pub(super) fn rays(&self, axis: usize) -> impl Iterator<Item = impl Iterator<Item = f64> + Clone> {
        let strides = [1, self.cells[0], self.cells[0] * self.cells[1]];
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        (0..self.cells[a] * self.cells[b]).map(move |ray| {
            let start = ray % self.cells[a] * strides[a] + ray / self.cells[a] * strides[b];
            (0..self.cells[axis]).map(move |i| self.values[start + i * strides[axis]])
        })
    }

    /// Mean length, in mean voxel spacings, that a ray spends among the values in `range`, over the rays that meet any
    /// of them; `None` if there are no such values. By Cauchy's theorem (mean chord = volume over mean projected area)
    /// this is the harmonic mean over the three axes.
    pub(super) fn mean_path(&self, range: [f64; 2]) -> Option<f64> {
        let inside = |v: f64| (range[0]..range[1]).contains(&v);
        let total = self.values.iter().filter(|&&v| inside(v)).count();
        let inverse_path = |axis: usize| {
            let met = self.rays(axis).filter(|ray| ray.clone().any(inside)).count();
            met as f64 / (total as f64 * self.cell_size[axis])
        };
        (total > 0).then(|| 3.0 / (inverse_path(0) + inverse_path(1) + inverse_path(2)))
    }

    /// Share of the axis-aligned rays through values in `range` that also meet larger values: the share of denser
    /// material that would be hidden if `range` were opaque.
    pub(super) fn share_before_denser(&self, range: [f64; 2]) -> f64 {
        let (mut met, mut denser) = (0usize, 0usize);
        for ray in (0..3).flat_map(|axis| self.rays(axis)) {
            if ray.clone().any(|v| (range[0]..range[1]).contains(&v)) {
                met += 1;
                denser += usize::from(ray.clone().any(|v| v >= range[1]));
            }
        }
        denser as f64 / met.max(1) as f64
    }
}

/// Value below which `share` of an ascending list lies; NaN of an empty one.
pub(super) fn quantile(sorted: &[f64], share: f64) -> f64 {
    let last = sorted.len().saturating_sub(1);
    sorted
        .get((share * last as f64).round() as usize)
        .copied()
        .unwrap_or(f64::NAN)
}

fn ascending(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sorted: Vec<f64> = values.filter(|v| v.is_finite()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted
}

fn take_samples<T: Copy + Into<f64>>(samples: &OrientedSamples<'_, T>) -> Survey {
    let dims = samples.dims;
    let cells = dims.map(|n| n.min(CELLS_PER_AXIS));
    let count = cells.iter().product();
    let mut survey = Survey {
        cells,
        cell_size: std::array::from_fn(|axis| dims[axis] as f64 / cells[axis] as f64),
        values: Vec::with_capacity(count),
        gradients: Vec::with_capacity(count),
        equal_neighbours: Vec::with_capacity(count),
        sorted: Vec::new(),
        border: Vec::new(),
    };
    let value_at = |place: [usize; 3]| samples.value(place);
    for cell in 0..count {
        let voxel = jittered_voxel(cell, cells, dims);
        let value = value_at(voxel);
        let (mut square, mut equal, mut neighbours) = (0.0, 0, 0);
        for axis in 0..3 {
            if voxel[axis] + 1 < dims[axis] {
                let mut neighbour = voxel;
                neighbour[axis] += 1;
                let difference = value_at(neighbour) - value;
                square += difference * difference;
                equal += u8::from(difference == 0.0);
                neighbours += 1;
            }
        }
        let value = if value.is_finite() { value } else { f64::NAN };
        let gradient: f64 = square.sqrt();
        survey.values.push(value);
        survey
            .gradients
            .push(if gradient.is_finite() { gradient } else { f64::NAN });
        survey
            .equal_neighbours
            .push(f32::from(equal) / f32::from(neighbours.max(1u8)));
    }
    survey.border = ascending(border_voxels(dims).map(value_at));
    survey
}

/// The sample's voxel in a cell.
fn jittered_voxel(cell: usize, cells: [usize; 3], dims: [usize; 3]) -> [usize; 3] {
    let index = [
        cell % cells[0],
        cell / cells[0] % cells[1],
        cell / cells[0] / cells[1],
    ];
    let mut hash = mix(cell as u64);
    std::array::from_fn(|axis| {
        let (start, end) = (
            index[axis] * dims[axis] / cells[axis],
            (index[axis] + 1) * dims[axis] / cells[axis],
        );
        hash = mix(hash);
        start + (hash % (end - start).max(1) as u64) as usize
    })
}

/// The finaliser of splitmix64.
fn mix(seed: u64) -> u64 {
    let z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

/// Voxels on the six faces, on a stride that leaves at most 64^2 per face.
fn border_voxels(dims: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..3).flat_map(move |axis| {
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        let steps = [a, b].map(|axis| dims[axis].div_ceil(CELLS_PER_AXIS));
        [0, dims[axis] - 1].into_iter().flat_map(move |face| {
            (0..dims[a]).step_by(steps[0]).flat_map(move |i| {
                (0..dims[b]).step_by(steps[1]).map(move |j| {
                    let mut voxel = [0; 3];
                    (voxel[axis], voxel[a], voxel[b]) = (face, i, j);
                    voxel
                })
            })
        })
    })
}
