//! The part of a grid that can be seen, which an automatic camera shows.
//!
//! Two passes over the samples: the opacity in every slice along each axis says where the specks are (a holder, noise)
//! that would shrink the picture, and what remains is bounded by the extremes of its slices.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;
use splatvol_scene::volume::widen;
use splatvol_scene::{TransferFunction, Volume, with_samples};

/// Least opacity per unit distance at which a voxel counts as seen: this, or this share of the largest one...
const SEEN: [f64; 2] = [0.004, 0.01];
/// ...but no more than this share, where all of it is faint, as in X-rays.
const SEEN_OF_FAINT: f64 = 0.04;
/// A slice with less than this share of the fullest slice's opacity may be a speck's...
const SPECK: f64 = 0.005;
/// ...if leaving such slices out shortens the object by more than this share at one end.
const WORTHWHILE: f64 = 0.1;
/// Entries of the table that says which values are seen.
const ENTRIES: usize = 4096;
/// Directions within a slice in which its extreme voxels are kept. They bound the slice's outline from outside within
/// `1 - cos(pi / 32)`, half a per cent of its radius.
const DIRECTIONS: usize = 32;

/// World positions that bound the voxels with some opacity as a convex hull would: the extremes of every slice. If
/// nothing is seen, the grid's corners.
pub fn visible_outline(volume: &Volume, transfer_function: &TransferFunction) -> Vec<DVec3> {
    let seen = SeenValues::new(volume, transfer_function);
    let rows = 0..volume.grid().dims()[1];
    let [xs, ys, zs] = opacity_per_slice(volume, &seen, &rows).map(|weights| without_specks(&weights));
    let rescale = volume.rescale();
    let [nx, ny, _] = volume.grid().dims();
    let directions = std::array::from_fn(|i| {
        let (sin, cos) = libm::sincos(i as f64 * std::f64::consts::TAU / DIRECTIONS as f64);
        [cos, sin]
    });
    let outlines: Vec<SliceOutline<'_>> = with_samples!(volume.samples(), data => {
        data.par_chunks(nx * ny)
            .enumerate()
            .filter(|(z, _)| zs.contains(z))
            .map(|(z, slice)| {
                let mut outline = SliceOutline::new(z, &directions);
                for (y, row) in slice.chunks_exact(nx).enumerate().filter(|(y, _)| ys.contains(y)) {
                    let is_seen = |sample: &_| seen.weight(rescale.apply(widen(*sample))) > 0;
                    let row = &row[xs.clone()];
                    let Some(first) = row.iter().position(is_seen) else {
                        continue;
                    };
                    let last = row.iter().rposition(is_seen).unwrap_or(first);
                    outline.add((xs.start + first) as f64, y as f64);
                    outline.add((xs.start + last) as f64, y as f64);
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

/// Sums of the seen voxels' opacities, in whole steps, in the slices across x, y and z; of those voxels whose y is one
/// of `rows`.
pub(crate) fn opacity_per_slice(volume: &Volume, seen: &SeenValues, rows: &Range<usize>) -> [Vec<u64>; 3] {
    let rescale = volume.rescale();
    let dims = volume.grid().dims();
    let [nx, ny, _] = dims;
    let none = || dims.map(|n| vec![0u64; n]);
    let add = |mut sums: [Vec<u64>; 3], other: [Vec<u64>; 3]| {
        for (sum, more) in sums.iter_mut().flatten().zip(other.into_iter().flatten()) {
            *sum += more;
        }
        sums
    };
    with_samples!(volume.samples(), data => {
        data.par_chunks(nx * ny)
            .enumerate()
            .fold(none, |[mut xs, mut ys, mut zs], (z, slice)| {
                let counted = slice.chunks_exact(nx).zip(&mut ys);
                for (row, y) in counted.take(rows.end).skip(rows.start) {
                    let mut sum = 0;
                    for (sample, x) in row.iter().zip(&mut xs) {
                        let weight = u64::from(seen.weight(rescale.apply(widen(*sample))));
                        *x += weight;
                        sum += weight;
                    }
                    *y += sum;
                    zs[z] += sum;
                }
                [xs, ys, zs]
            })
            .reduce(none, add)
    })
}

/// The slices from the first to the last that is seen, without the specks at the ends.
pub(crate) fn without_specks(weights: &[u64]) -> Range<usize> {
    let span = |least: u64| {
        let first = weights.iter().position(|&w| w >= least)?;
        let last = weights.iter().rposition(|&w| w >= least)?;
        Some(first..last + 1)
    };
    let fullest = weights.iter().copied().max().unwrap_or(0);
    let least = ((SPECK * fullest as f64) as u64).max(1);
    let (Some(all), Some(main)) = (span(1), span(least)) else {
        return 0..0;
    };
    let worthwhile = (WORTHWHILE * main.len() as f64) as usize;
    let start = if main.start - all.start > worthwhile {
        main.start
    } else {
        all.start
    };
    let end = if all.end - main.end > worthwhile {
        main.end
    } else {
        all.end
    };
    start..end
}

/// A table of the opacity of values in steps of 1/65535, 0 if they are not seen.
pub(crate) struct SeenValues {
    weights: Vec<u16>,
    low: f64,
    scale: f64,
}

impl SeenValues {
    pub(crate) fn new(volume: &Volume, transfer_function: &TransferFunction) -> Self {
        let [low, high] = volume.value_range();
        let step = (high - low) / (ENTRIES as f64 - 1.0);
        let opacities: Vec<f64> = (0..ENTRIES)
            .map(|i| transfer_function.opacity(low + step * i as f64))
            .collect();
        let [least, share] = SEEN;
        let largest = opacities.iter().copied().fold(0.0, f64::max);
        let least = least.min(SEEN_OF_FAINT * largest).max(share * largest);
        Self {
            weights: opacities
                .iter()
                .map(|&opacity| {
                    if opacity > 0.0 && opacity >= least {
                        // The least counts, however faint.
                        ((opacity * f64::from(u16::MAX)) as u16).max(1)
                    } else {
                        0
                    }
                })
                .collect(),
            low,
            scale: if step > 0.0 { 1.0 / step } else { 0.0 },
        }
    }

    #[inline]
    fn weight(&self, value: f64) -> u16 {
        // Missing samples (NaN) become entry 0 by the cast, hence the check.
        if value.is_finite() {
            self.weights[(((value - self.low) * self.scale + 0.5) as usize).min(ENTRIES - 1)]
        } else {
            0
        }
    }
}

/// The seen voxels of a slice that lie farthest in each direction.
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
    use splatvol_scene::{ColorPoint, Grid, LengthUnit, OpacityPoint, Rescale, Samples};

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
        let volume = Volume::new(
            grid,
            Samples::F32(data.into()),
            Rescale::default(),
            LengthUnit::Unknown,
        )
        .unwrap();
        let outline = visible_outline(&volume, &from(5.0));
        let low = outline.iter().copied().reduce(DVec3::min).unwrap();
        let high = outline.iter().copied().reduce(DVec3::max).unwrap();
        assert_eq!(low, DVec3::new(-1.5, -2.0, -0.5));
        assert_eq!(high, DVec3::new(1.5, 2.0, 1.5));
        assert_eq!(visible_outline(&volume, &from(11.0)), volume.grid().corners());
    }

    #[test]
    fn faint_material_is_seen_to_its_end() {
        let data: Vec<f32> = (0..1000).map(|i| (i % 10) as f32).collect();
        let grid = Grid::centred([10; 3], DVec3::ONE).unwrap();
        let volume = Volume::new(
            grid,
            Samples::F32(data.into()),
            Rescale::default(),
            LengthUnit::Unknown,
        )
        .unwrap();
        for opacity in [1e-5, 1e-3, 0.02] {
            let ramp = vec![OpacityPoint::new(0.0, 0.0), OpacityPoint::new(9.0, opacity)];
            let look = TransferFunction::new(vec![ColorPoint::new(0.0, [1.0; 3])], ramp, None).unwrap();
            let outline = visible_outline(&volume, &look);
            let low = outline.iter().copied().reduce(DVec3::min).unwrap();
            // All values but 0, in the first slice.
            assert_eq!(low.x, -4.0, "{opacity}");
        }
    }

    #[test]
    fn specks_far_away_do_not_count_but_thin_ends_do() {
        let outline = |bright: &dyn Fn([usize; 3]) -> bool| {
            let voxels = (0..40 * 40 * 40).map(|i| [i % 40, i / 40 % 40, i / 1600]);
            let data = voxels.map(|voxel| u8::from(bright(voxel))).collect();
            let grid = Grid::new([40; 3], DVec3::ZERO, DVec3::ONE, glam::DMat3::IDENTITY).unwrap();
            let volume =
                Volume::new(grid, Samples::U8(data), Rescale::default(), LengthUnit::Unknown).unwrap();
            let outline = visible_outline(&volume, &from(0.4));
            let low = outline.iter().copied().reduce(DVec3::min).unwrap();
            let high = outline.iter().copied().reduce(DVec3::max).unwrap();
            (low.to_array(), high.to_array())
        };
        let block = |voxel: [usize; 3]| voxel.iter().all(|i| (10..30).contains(i));
        let expected = ([9.5; 3], [29.5; 3]);
        assert_eq!(outline(&block), expected);
        let specks = |voxel| block(voxel) || voxel == [38, 20, 20] || voxel == [20, 1, 0];
        assert_eq!(outline(&specks), expected);
        let tip = |voxel| block(voxel) || voxel == [30, 20, 20];
        assert_eq!(outline(&tip), ([9.5; 3], [30.5, 29.5, 29.5]));
        // A thing that is thin along its whole length is not a speck.
        let rod = |[x, y, z]: [usize; 3]| x == 5 && y == 7 && z > 3;
        assert_eq!(outline(&rod), ([4.5, 6.5, 3.5], [5.5, 7.5, 39.5]));
    }
}
