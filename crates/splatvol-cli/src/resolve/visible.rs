//! Which part of a grid can be seen: what an automatic camera shows.

use glam::DVec3;
use rayon::prelude::*;
use splatvol::volume::widen;
use splatvol::{TransferFunction, Volume, with_samples};

/// Opacity per unit distance from which a voxel counts as seen.
const SEEN: f64 = 0.004;
/// Entries of the table that says which values are seen.
const ENTRIES: usize = 4096;
/// Directions within a slice in which its extreme voxels are kept. They bound the slice's outline from outside within
/// `1 - cos(pi / 32)`, half a per cent of its radius.
const DIRECTIONS: usize = 32;

/// World positions that bound the voxels with some opacity as a convex hull would: the extremes of every slice. The
/// grid's corners where nothing is seen.
pub(crate) fn visible_outline(volume: &Volume, transfer_function: &TransferFunction) -> Vec<DVec3> {
    let seen = SeenValues::new(volume, transfer_function);
    let rescale = volume.rescale();
    let [nx, ny, _] = volume.grid().dims();
    let directions = std::array::from_fn(|i| {
        let (sin, cos) = (i as f64 * std::f64::consts::TAU / DIRECTIONS as f64).sin_cos();
        [cos, sin]
    });
    let outlines: Vec<SliceOutline<'_>> = with_samples!(volume.samples(), data => {
        data.par_chunks(nx * ny)
            .enumerate()
            .map(|(z, slice)| {
                let mut outline = SliceOutline::new(z, &directions);
                for (y, row) in slice.chunks_exact(nx).enumerate() {
                    let is_seen = |sample: &_| seen.contains(rescale.apply(widen(*sample)));
                    let Some(first) = row.iter().position(is_seen) else {
                        continue;
                    };
                    let last = row.iter().rposition(is_seen).unwrap_or(first);
                    outline.add(first as f64, y as f64);
                    outline.add(last as f64, y as f64);
                }
                outline
            })
            .collect()
    });
    let world_from_voxel = volume.grid().world_from_voxel();
    let voxels = outlines.iter().flat_map(SliceOutline::voxels);
    let world: Vec<_> = voxels
        .map(|voxel| world_from_voxel.transform_point3(voxel))
        .collect();
    if world.is_empty() {
        return volume.grid().corners().to_vec();
    }
    world
}

/// A table of the values that are seen.
struct SeenValues {
    seen: Vec<bool>,
    low: f64,
    scale: f64,
}

impl SeenValues {
    fn new(volume: &Volume, transfer_function: &TransferFunction) -> Self {
        let [low, high] = volume.value_range();
        let step = (high - low) / (ENTRIES as f64 - 1.0);
        Self {
            seen: (0..ENTRIES)
                .map(|i| transfer_function.opacity(low + step * i as f64) >= SEEN)
                .collect(),
            low,
            scale: if step > 0.0 { 1.0 / step } else { 0.0 },
        }
    }

    #[inline]
    fn contains(&self, value: f64) -> bool {
        // Missing samples (NaN) become entry 0 by the cast, hence the check.
        value.is_finite() && self.seen[(((value - self.low) * self.scale + 0.5) as usize).min(ENTRIES - 1)]
    }
}

/// The seen voxels of a slice that lie furthest in each direction.
struct SliceOutline<'a> {
    z: usize,
    directions: &'a [[f64; 2]; DIRECTIONS],
    extremes: [Option<(f64, [f64; 2])>; DIRECTIONS],
}

impl<'a> SliceOutline<'a> {
    fn new(z: usize, directions: &'a [[f64; 2]; DIRECTIONS]) -> Self {
        Self {
            z,
            directions,
            extremes: [None; DIRECTIONS],
        }
    }

    fn add(&mut self, x: f64, y: f64) {
        for (extreme, [cos, sin]) in self.extremes.iter_mut().zip(self.directions) {
            let reach = cos * x + sin * y;
            if extreme.is_none_or(|(most, _)| reach > most) {
                *extreme = Some((reach, [x, y]));
            }
        }
    }

    /// Corners of the kept voxels' cells.
    fn voxels(&self) -> impl Iterator<Item = DVec3> {
        let z = self.z as f64;
        self.extremes.iter().flatten().flat_map(move |&(_, [x, y])| {
            (0..8).map(move |corner| {
                let side = |bit: u8| f64::from(corner >> bit & 1) - 0.5;
                DVec3::new(x + side(0), y + side(1), z + side(2))
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use splatvol::{ColorPoint, Grid, LengthUnit, OpacityPoint, Rescale, Samples};

    fn from(value: f64) -> TransferFunction {
        TransferFunction::new(
            vec![ColorPoint::new(0.0, [1.0; 3])],
            vec![OpacityPoint::new(value, 0.0), OpacityPoint::new(value + 0.5, 1.0)],
            None,
        )
        .expect("the points are in order")
    }

    #[test]
    fn the_outline_spans_the_opaque_cells() {
        let mut data = vec![f32::NAN; 5 * 4 * 3];
        data[0] = 0.0;
        data[(2 * 4 + 1) * 5 + 3] = 9.0;
        data[(4 + 2) * 5 + 1] = 10.0;
        let grid = Grid::centred([5, 4, 3], DVec3::new(1.0, 2.0, 1.0)).unwrap();
        let volume = Volume::new(grid, Samples::F32(data), Rescale::default(), LengthUnit::Unknown).unwrap();
        let outline = visible_outline(&volume, &from(5.0));
        let low = outline.iter().copied().reduce(DVec3::min).unwrap();
        let high = outline.iter().copied().reduce(DVec3::max).unwrap();
        assert_eq!(low, DVec3::new(-1.5, -2.0, -0.5));
        assert_eq!(high, DVec3::new(1.5, 2.0, 1.5));
        assert_eq!(visible_outline(&volume, &from(11.0)), volume.grid().corners());
    }
}
