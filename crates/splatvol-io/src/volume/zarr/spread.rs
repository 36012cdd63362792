//! Samples that stand for a level in histograms: an array `splatvol/spread/LEVEL` beside the levels. Row by row it holds
//! every n-th sample of the level ([`splatvol_scene::chunks::spread_step`]), and zeros behind the last.

use glam::DVec3;
use splatvol_scene::chunks::spread_step;
use splatvol_scene::volume::widen;
use splatvol_scene::{ChunkBuffer, ChunkContent, Grid, LevelLayout, Rescale, VoxelBox, with_samples};

use super::array::Array;
use super::folder::Folder;
use super::level::{ArrayLevel, Part};
use super::own;
use crate::volume::ReadOptions;

/// Samples of a row.
pub(super) const ROW: usize = 256;

/// Number of samples that stand for a level of these dimensions.
pub(super) fn count(dims: [usize; 3]) -> usize {
    let samples = dims.iter().product();
    usize::div_ceil(samples, spread_step(samples))
}

/// Those within a box: their numbers among them, and their places.
pub(super) fn within(dims: [usize; 3], region: VoxelBox) -> impl Iterator<Item = (usize, [usize; 3])> {
    let [nx, ny, nz] = dims;
    let step = spread_step(nx * ny * nz);
    let [x, y, z] = region.first;
    let rows = (0..region.size[1] * region.size[2])
        .map(move |row| [y + row % region.size[1], z + row / region.size[1]]);
    rows.flat_map(move |[y, z]| {
        let first = (z * ny + y) * nx + x;
        let numbers = first.div_ceil(step)..(first + region.size[0]).div_ceil(step);
        numbers.map(move |number| (number, [x + number * step - first, y, z]))
    })
}

/// Reads those of a level; `None` if they are not there, or not those of this level.
pub(super) fn read(
    folder: &Folder,
    level: usize,
    of: &ArrayLevel,
    options: &ReadOptions,
) -> Option<Vec<f64>> {
    let folder = folder.join(own::SPREAD).join(&level.to_string());
    let array = Array::open(&folder).ok()??;
    let count = count(of.layout.grid.dims());
    let rows = count.div_ceil(ROW);
    if array.shape != [rows, ROW] || array.chunks != [rows, ROW] || array.element() != of.layout.element {
        return None;
    }
    let layout = LevelLayout {
        grid: Grid::centred([ROW, rows, 1], DVec3::ONE).ok()?,
        chunk: [1; 3],
        element: array.element(),
        rescale: Rescale::default(),
        fill: 0.0,
    };
    let part = Part {
        place: vec![0, 0],
        spatial: vec![0, 1],
    };
    let samples = ArrayLevel::new(array, part, layout, options.allow_outside);
    let mut buffer = ChunkBuffer::default();
    if samples.read([0; 3], &mut buffer).ok()? != ChunkContent::Samples {
        return None;
    }
    let mut values: Vec<f64> =
        with_samples!(&buffer.samples, data => data.iter().map(|&value| widen(value)).collect());
    values.truncate(count);
    values.iter().all(|value| value.is_finite()).then_some(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_hold_all_places_once() {
        for dims in [[70, 50, 40], [300, 7, 90], [5, 4, 3]] {
            let mut found = vec![None; count(dims)];
            for z in (0..dims[2]).step_by(16) {
                for x in (0..dims[0]).step_by(33) {
                    let region = VoxelBox {
                        first: [x, 0, z],
                        size: [33.min(dims[0] - x), dims[1], 16.min(dims[2] - z)],
                    };
                    for (number, place) in within(dims, region) {
                        assert_eq!(found[number].replace(place), None);
                    }
                }
            }
            let step = spread_step(dims.iter().product());
            for (number, place) in found.into_iter().enumerate() {
                let [x, y, z] = place.unwrap();
                assert_eq!((z * dims[1] + y) * dims[0] + x, number * step);
            }
        }
    }
}
