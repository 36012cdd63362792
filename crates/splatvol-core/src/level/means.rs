//! Classified voxels of a level: means of the classes of the finest voxels that they cover.
//!
//! `c_j = sum_i w_ij c(f_i)`, c extinction and emission, `w_ij` the share of voxel j that voxel i of the finest level fills. So a
//! ray's optical depth stays what it was, whatever the transfer function: classes of means would lose what is thinner
//! than a voxel. Missing samples are empty. Classes are kept in 16 bits, relative to the largest of their brick.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;
use splatvol_scene::volume::widen;
use splatvol_scene::{Block, SceneError, VoxelBox, with_samples};

use super::Level;
use crate::brick::BRICK;
use crate::classification::ClassificationTable;
use crate::field::{FieldStore, SourceLevel};
use crate::mip::Cover;
use crate::visibility::BRICK_VOXELS;

/// Extinction and emission of a brick's voxels, x fastest.
pub type Classes = [[f32; 4]; BRICK_VOXELS];

/// Mean classes of a level's visible bricks.
#[derive(Debug, Default)]
pub struct ClassifiedMeans {
    bricks: Vec<StoredClasses>,
}

/// A brick's classes in steps of 1/65535 of its largest.
#[derive(Debug)]
struct StoredClasses {
    step: [f32; 4],
    voxels: [[u16; 4]; BRICK_VOXELS],
}

impl StoredClasses {
    /// `None` without extinction.
    fn new(classes: &Classes) -> Option<Self> {
        let largest = classes.iter().fold([0.0f32; 4], |largest, class| {
            std::array::from_fn(|c| largest[c].max(class[c]))
        });
        let step = largest.map(|largest| largest / f32::from(u16::MAX));
        let steps = |value: f32, step: f32| {
            if step > 0.0 {
                (value / step).round() as u16
            } else {
                0
            }
        };
        (largest[0] > 0.0).then(|| Self {
            step,
            voxels: classes.map(|class| std::array::from_fn(|c| steps(class[c], step[c]))),
        })
    }
}

impl ClassifiedMeans {
    /// Means on the grid of `field` of the finest level's classes; the bricks with extinction, ascending.
    ///
    /// # Errors
    /// `stop`, set meanwhile, and samples that cannot be read.
    pub(super) fn new(
        finest: &Level,
        field: &FieldStore,
        stop: &AtomicBool,
    ) -> Result<(Vec<u32>, Self), SceneError> {
        let means = Means::new(finest, field);
        let found: Vec<(u32, StoredClasses)> = (0..means.count)
            .into_par_iter()
            .map(|brick| {
                if stop.load(Ordering::Relaxed) {
                    return Err(SceneError::Stopped);
                }
                let classes = means.brick(field.brick_first(brick))?;
                let stored = classes.and_then(|classes| StoredClasses::new(&classes));
                Ok(stored.map(|stored| (brick, stored)))
            })
            .filter_map(Result::transpose)
            .collect::<Result<_, _>>()?;
        let (visible, bricks) = found.into_iter().unzip();
        Ok((visible, Self { bricks }))
    }

    /// Classes of the n-th visible brick.
    pub fn decode(&self, n: usize, out: &mut Classes) {
        let StoredClasses { step, voxels } = &self.bricks[n];
        for (out, voxel) in out.iter_mut().zip(voxels) {
            *out = std::array::from_fn(|c| f32::from(voxel[c]) * step[c]);
        }
    }

    /// Memory held, bytes.
    pub(super) fn bytes(&self) -> usize {
        self.bricks.capacity() * size_of::<StoredClasses>()
    }
}

/// What all bricks' means are made from.
struct Means<'a> {
    source: &'a SourceLevel,
    table: &'a ClassificationTable,
    hull: [f32; 2],
    /// Normalised value of a stored one: factor and offset.
    normalised: [f64; 2],
    /// Whether the finest level's bricks are visible, and their number along x, y, z.
    visible: Vec<bool>,
    bricks: [usize; 3],
    /// First voxel of the finest lattice, and of the level's.
    margins: [[usize; 3]; 2],
    /// The finest samples that the level's voxels cover, along x, y, z.
    cover: [Vec<Cover>; 3],
    /// Bricks of the level.
    count: u32,
}

impl<'a> Means<'a> {
    fn new(finest: &'a Level, field: &FieldStore) -> Self {
        let source = finest.field.source();
        let [low, high] = source.value_range();
        let scale = if high > low { 1.0 / (high - low) } else { 1.0 };
        let rescale = source.rescale();
        let bricks_of = |field: &FieldStore| field.dims().map(|n| n.div_ceil(BRICK));
        let bricks = bricks_of(&finest.field);
        let mut visible = vec![false; bricks.iter().product()];
        for &brick in &finest.visible {
            visible[brick as usize] = true;
        }
        let dims = [source.grid().dims(), field.source().grid().dims()];
        Self {
            source,
            table: &finest.classification,
            hull: finest.hull,
            normalised: [rescale.slope * scale, (rescale.intercept - low) * scale],
            visible,
            bricks,
            margins: [finest.field.margin(), field.margin()],
            cover: std::array::from_fn(|a| Cover::all(dims[0][a], dims[1][a])),
            count: bricks_of(field).iter().product::<usize>() as u32,
        }
    }

    /// Mean classes of a brick's voxels; `None` where nothing is visible.
    fn brick(&self, first: [u32; 3]) -> Result<Option<Box<Classes>>, SceneError> {
        // The level's voxels of the brick.
        let voxels: [[usize; 2]; 3] = std::array::from_fn(|a| {
            let (from, margin) = (first[a] as usize, self.margins[1][a]);
            let count = self.cover[a].len();
            [from, from + BRICK].map(|point| point.clamp(margin, margin + count) - margin)
        });
        if voxels.iter().any(|[from, to]| from == to) {
            return Ok(None);
        }
        let covered: [[usize; 2]; 3] = std::array::from_fn(|a| {
            let [from, to] = voxels[a];
            [self.cover[a][from].range()[0], self.cover[a][to - 1].range()[1]]
        });
        if !self.any_visible(covered) {
            return Ok(None);
        }
        let region = VoxelBox {
            first: covered.map(|[from, _]| from),
            size: covered.map(|[from, to]| to - from),
        };
        let mut memory = None;
        let block = self.source.read(region, &mut memory)?;
        let mut classes = Box::new([[0.0; 4]; BRICK_VOXELS]);
        for (place, class) in classes.iter_mut().enumerate() {
            let at = [place % BRICK, place / BRICK % BRICK, place / (BRICK * BRICK)];
            let voxel: [Option<usize>; 3] = std::array::from_fn(|a| {
                let voxel = (first[a] as usize + at[a]).checked_sub(self.margins[1][a]);
                voxel.filter(|&voxel| voxel < self.cover[a].len())
            });
            if let [Some(x), Some(y), Some(z)] = voxel {
                *class = self.mean(&block, [&self.cover[0][x], &self.cover[1][y], &self.cover[2][z]]);
            }
        }
        Ok(Some(classes))
    }

    /// Whether one of the finest bricks that hold these voxels is visible.
    fn any_visible(&self, covered: [[usize; 2]; 3]) -> bool {
        let [xs, ys, zs]: [[usize; 2]; 3] = std::array::from_fn(|a| {
            let [from, to] = covered[a].map(|voxel| voxel + self.margins[0][a]);
            [from / BRICK, (to - 1) / BRICK + 1]
        });
        let [nx, ny, _] = self.bricks;
        (zs[0]..zs[1]).any(|z| {
            (ys[0]..ys[1]).any(|y| {
                let row = (z * ny + y) * nx;
                self.visible[row + xs[0]..row + xs[1]].contains(&true)
            })
        })
    }

    /// Mean class of the samples that one voxel covers.
    fn mean(&self, block: &Block<'_>, [xs, ys, zs]: [&Cover; 3]) -> [f32; 4] {
        let [factor, offset] = self.normalised;
        let [low, high] = self.hull;
        let [from, to] = xs.range();
        let mut sum = [0.0f32; 4];
        for (z, of_z) in zs.taps() {
            for (y, of_y) in ys.taps() {
                with_samples!(block.samples, data => {
                    let row = &block.of.row(data, [y, z])[from - block.of.first[0]..to - block.of.first[0]];
                    for (&sample, (_, of_x)) in row.iter().zip(xs.taps()) {
                        let value = (widen(sample) * factor + offset) as f32;
                        // False where the sample is missing.
                        if value >= low && value <= high {
                            let class = self.table.at(value);
                            let weight = of_x * of_y * of_z;
                            sum = std::array::from_fn(|c| sum[c] + weight * class[c]);
                        }
                    }
                });
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DVec3;
    use splatvol_scene::{
        Classification, ColorPoint, Grid, LengthUnit, OpacityPoint, RenderSettings, Rescale, Samples,
        SheetSettings, Shows, TransferFunction, Volume,
    };
    use splatvol_testing::random::Random;

    use super::super::{Pyramid, Wanted};
    use super::*;

    /// A look that sees one narrow range of values, in colour.
    fn look() -> TransferFunction {
        let opacity = [(90.0, 0.0), (100.0, 0.5), (110.0, 0.0)];
        let opacity = opacity.map(|(value, opacity)| OpacityPoint::new(value, opacity));
        let colors = vec![
            ColorPoint::new(90.0, [1.0, 0.2, 0.0]),
            ColorPoint::new(110.0, [0.1, 0.3, 1.0]),
        ];
        TransferFunction::new(colors, opacity.to_vec(), Some(1.0)).unwrap()
    }

    #[test]
    fn every_level_holds_all_of_the_classes() {
        for dims in [[40, 24, 33], [17, 9, 1]] {
            let mut random = Random::new(4);
            let count: usize = dims.iter().product();
            let mut data: Vec<f32> = (0..count).map(|_| random.unit() as f32 * 255.0).collect();
            data[count / 2] = f32::NAN;
            let grid = Grid::centred(dims, DVec3::ONE).unwrap();
            let samples = Samples::F32(data.into());
            let volume = Volume::new(grid, samples, Rescale::default(), LengthUnit::Unknown).unwrap();
            let volume = Arc::new(volume);
            let settings = RenderSettings::default().with(SheetSettings {
                shows: Shows::Material(Classification::Pre),
                ..SheetSettings::default()
            });
            let mut pyramid = Pyramid::new(volume.clone(), &settings);
            let look = look();
            let stop = AtomicBool::new(false);
            let table = ClassificationTable::new(&look, volume.value_range(), 1.0);
            let [low, high] = volume.value_range();
            let expected = (0..count)
                .filter(|&i| volume.value(i).is_finite())
                .map(|i| {
                    table
                        .at(((volume.value(i) - low) / (high - low)) as f32)
                        .map(f64::from)
                })
                .fold([0.0f64; 4], |sum, class| {
                    std::array::from_fn(|c| sum[c] + class[c])
                });
            for level in 1..4 {
                let level = pyramid
                    .classify(level, (&look, 1.0), Wanted::Classified, &stop)
                    .unwrap();
                let covered = count as f64 / level.field.source().grid().sample_count() as f64;
                let means = level.means.as_ref().unwrap();
                let mut classes = [[0.0; 4]; BRICK_VOXELS];
                let mut sum = [0.0f64; 4];
                for n in 0..level.visible.len() {
                    means.decode(n, &mut classes);
                    for class in &classes {
                        sum = std::array::from_fn(|c| sum[c] + covered * f64::from(class[c]));
                    }
                }
                for c in 0..4 {
                    assert!(
                        (sum[c] / expected[c] - 1.0).abs() < 1e-4,
                        "{dims:?} {c}: {sum:?} {expected:?}"
                    );
                }
            }
        }
    }
}
