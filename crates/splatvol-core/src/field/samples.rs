//! Samples of a field's bricks, for classification of voxels. Only the ranges, which the field has anyway, are
//! kept; the visible bricks of a transfer function are found anew from these in a millisecond.

use crate::brick::BRICK;
use crate::visibility::{LEVELS, VisibleLevels};

use super::FieldStore;
use super::lattice::{Block, Lattice, StoredSample};

/// Samples along the edge of a brick with one around it.
const AROUND: usize = BRICK + 2;
/// Row length in memory: one sample before the brick, its eight, one behind, and padding to a vector.
const ROW: usize = 16;

/// Normalised samples of a brick and of one voxel around it.
#[derive(Debug, Clone)]
pub struct Neighbourhood {
    /// By z, y and x, from one voxel before the brick on. Beyond the volume the nearest sample; NaN where one is
    /// missing.
    pub values: [[[f32; ROW]; AROUND]; AROUND],
    /// Whether samples of the volume are missing.
    pub any_missing: bool,
    /// First of the brick's voxels that exist, and one past the last, along x, y, z.
    pub inside: [[usize; 2]; 3],
    /// One over the voxels between the neighbours of each voxel, along x, y, z: a half, or one at the volume's faces.
    pub per_difference: [[f32; BRICK]; 3],
}

impl Default for Neighbourhood {
    fn default() -> Self {
        Self {
            values: [[[0.0; ROW]; AROUND]; AROUND],
            any_missing: false,
            inside: [[0; 2]; 3],
            per_difference: [[0.5; BRICK]; 3],
        }
    }
}

impl FieldStore {
    /// Replaces `bricks` by those with a sample that may be visible, ascending.
    pub fn visible_bricks(&self, levels: &VisibleLevels, bricks: &mut Vec<u32>) {
        let shows = |[low, high]: [i16; 2]| {
            low <= high && levels.any_of([(low - 1).max(0), (high + 1).min(LEVELS as i16 - 1)])
        };
        bricks.clear();
        if self.lazy.is_some() {
            return self.candidate_bricks(levels, bricks);
        }
        bricks.extend(
            (0u32..)
                .zip(self.ranges.all())
                .filter(|(_, range)| shows(**range))
                .map(|(i, _)| i),
        );
    }

    /// First lattice point of one of these bricks.
    #[inline]
    pub fn brick_first(&self, brick: u32) -> [u32; 3] {
        let [nx, ny, _] = self.bricks.map(|n| n as u32);
        [brick % nx, brick / nx % ny, brick / (nx * ny)].map(|b| b * BRICK as u32)
    }

    /// Reads the samples of one of these bricks.
    pub fn read(&self, brick: u32, out: &mut Neighbourhood) {
        let first = self.brick_first(brick).map(|c| c as usize);
        let mut reader = self.reader();
        let region = self.lattice.region(first, first.map(|at| at + AROUND));
        let read = with_block!(reader, region, data => {
            vectorized!(self.lattice.simd, self.lattice.neighbourhood(data, first, out));
        });
        if read.is_none() {
            *out = Neighbourhood::default();
        }
    }
}

impl Lattice {
    #[inline(always)]
    fn neighbourhood<T: StoredSample>(
        &self,
        data: &Block<'_, T>,
        first: [usize; 3],
        out: &mut Neighbourhood,
    ) {
        for (axis, &first) in first.iter().enumerate() {
            let (margin, count) = (self.margin[axis], self.own[axis]);
            let within = |point: usize| (first + point).clamp(margin, margin + count) - first;
            out.inside[axis] = [within(0), within(BRICK)];
            for (i, per) in out.per_difference[axis].iter_mut().enumerate() {
                let at_face = first + i == margin || first + i + 1 == margin + count;
                *per = if at_face { 1.0 } else { 0.5 };
            }
        }
        // Sample at a place of the neighbourhood.
        let nearest = |axis: usize, place: usize| {
            (first[axis] + place)
                .saturating_sub(self.margin[axis] + 1)
                .min(self.own[axis] - 1)
        };
        let start = first[0].wrapping_sub(self.margin[0] + 1);
        for (z, slice) in out.values.iter_mut().enumerate() {
            for (y, values) in slice.iter_mut().enumerate() {
                let row = data.row([nearest(1, y), nearest(2, z)]);
                if let Some(samples) = row.chunk::<AROUND>(start) {
                    for x in 0..AROUND {
                        values[x] = self.normalised(samples[x]);
                    }
                } else {
                    for (x, value) in values[..AROUND].iter_mut().enumerate() {
                        *value = self.normalised(row.at(nearest(0, x)));
                    }
                }
            }
        }
        out.any_missing = self.any_missing;
        if self.any_missing {
            for value in out.values.as_flattened_mut().as_flattened_mut() {
                *value = if value.is_finite() { *value } else { f32::NAN };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DVec3;
    use splatvol_scene::{ColorPoint, OpacityPoint, TransferFunction};
    use splatvol_scene::{Grid, Kernel, LengthUnit, Rescale, Samples, Volume};
    use splatvol_testing::random::Random;

    use super::*;
    use crate::classification::ClassificationTable;
    use crate::kernel::GaussianKernel;

    #[test]
    fn bricks_hold_the_samples_around_and_their_differences() {
        for dims in [[19, 9, 8], [7, 1, 23], [16, 16, 2]] {
            let mut random = Random::new(3);
            let count = dims.iter().product();
            let data: Vec<u16> = (0..count).map(|_| (random.unit() * 4000.0) as u16).collect();
            let grid = Grid::centred(dims, DVec3::ONE).unwrap();
            let volume = Arc::new(
                Volume::new(
                    grid,
                    Samples::U16(data.into()),
                    Rescale::default(),
                    LengthUnit::Unknown,
                )
                .unwrap(),
            );
            let [low, high] = volume.value_range();
            let value = |p: [usize; 3]| {
                ((volume.value((p[2] * dims[1] + p[1]) * dims[0] + p[0]) - low) / (high - low)) as f32
            };
            let store = FieldStore::new(Arc::clone(&volume), &GaussianKernel::new(Kernel::default()));
            let opacity = vec![OpacityPoint::new(0.0, 0.1)];
            let all = TransferFunction::new(vec![ColorPoint::new(0.0, [1.0; 3])], opacity, None).unwrap();
            let table = ClassificationTable::new(&all, [low, high], 1.0);
            let mut bricks = Vec::new();
            store.visible_bricks(&VisibleLevels::new(&table), &mut bricks);
            let (mut around, mut seen) = (Neighbourhood::default(), 0);
            for &brick in &bricks {
                store.read(brick, &mut around);
                let first = store.brick_first(brick);
                for i in 0..512usize {
                    let at = [i % 8, i / 8 % 8, i / 64];
                    if (0..3).any(|a| !(around.inside[a][0]..around.inside[a][1]).contains(&at[a])) {
                        continue;
                    }
                    seen += 1;
                    let p: [usize; 3] =
                        std::array::from_fn(|a| first[a] as usize + at[a] - store.margin()[a]);
                    let read = |d: [usize; 3]| around.values[at[2] + d[2]][at[1] + d[1]][at[0] + d[0]];
                    assert!((read([1; 3]) - value(p)).abs() < 1e-6);
                    for axis in 0..3 {
                        let (mut before, mut after, mut low, mut high) = ([1; 3], [1; 3], p, p);
                        (before[axis], after[axis]) = (0, 2);
                        low[axis] = p[axis].saturating_sub(1);
                        high[axis] = (p[axis] + 1).min(dims[axis] - 1);
                        let steps = (high[axis] - low[axis]).max(1) as f32;
                        let expected = (value(high) - value(low)) / steps;
                        let found = (read(after) - read(before)) * around.per_difference[axis][at[axis]];
                        assert!(
                            (found - expected).abs() < 1e-5,
                            "{dims:?} {p:?} {axis}: {found} {expected}"
                        );
                    }
                }
            }
            assert_eq!(seen, count, "{dims:?}");
        }
    }

    #[test]
    fn bricks_without_visible_samples_are_left_out() {
        let dims = [40; 3];
        let mut data = vec![0u8; 64_000];
        data[(20 * 40 + 20) * 40 + 20] = 255;
        let grid = Grid::centred(dims, DVec3::ONE).unwrap();
        let volume = Volume::new(
            grid,
            Samples::U8(data.into()),
            Rescale::default(),
            LengthUnit::Unknown,
        )
        .unwrap();
        let opacity = vec![OpacityPoint::new(150.0, 0.0), OpacityPoint::new(230.0, 0.5)];
        let look = TransferFunction::new(vec![ColorPoint::new(0.0, [1.0; 3])], opacity, None).unwrap();
        let table = ClassificationTable::new(&look, [0.0, 255.0], 1.0);
        let store = FieldStore::new(Arc::new(volume), &GaussianKernel::new(Kernel::default()));
        let mut bricks = vec![7];
        store.visible_bricks(&VisibleLevels::new(&table), &mut bricks);
        assert_eq!(bricks.len(), 1, "{bricks:?}");
        assert_eq!(store.brick_first(bricks[0]), [16; 3]);
    }
}
