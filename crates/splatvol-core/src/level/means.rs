//! Classified voxels of a level: means of the classes of the finest voxels that they cover.
//!
//! `c_j = sum_i w_ij c(f_i)`, c extinction and emission, `w_ij` the share of voxel j that voxel i of the finest level fills. So a
//! ray's optical depth stays what it was, whatever the transfer function: classes of means would lose what is thinner
//! than a voxel. Missing samples are empty. Classes are kept in 16 bits, relative to the largest of their brick. Labels have
//! surfaces beside them (`labels`), on which light falls.

mod labels;

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;
use splatvol_scene::volume::widen;
use splatvol_scene::{Block, SceneError, VoxelBox, with_samples};

use super::Level;
use crate::brick::BRICK;
use crate::classification::ClassificationTable;
use crate::field::{FieldStore, SourceLevel};
use crate::resample::Taps;
use crate::visibility::BRICK_VOXELS;
pub use labels::Surfaces;
use labels::{BrickSurfaces, StoredSurfaces};

/// Extinction and emission of a brick's voxels, x fastest.
pub type Classes = [[f32; 4]; BRICK_VOXELS];

/// Mean classes of a level's visible bricks.
#[derive(Debug, Default)]
pub struct ClassifiedMeans {
    bricks: Vec<StoredClasses>,
    /// Of labels, those in the same bricks.
    surfaces: Option<StoredSurfaces>,
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
    /// Means on the grid of `field` of the finest level's classes; the bricks with extinction, ascending. Of labels with
    /// their surfaces.
    ///
    /// # Errors
    /// `stop`, set meanwhile, and samples that cannot be read.
    pub(super) fn new(
        finest: &Level,
        field: &FieldStore,
        (labels, stop): (bool, &AtomicBool),
    ) -> Result<(Vec<u32>, Self), SceneError> {
        let means = Means::new(finest, field);
        let found: Vec<(u32, (StoredClasses, Option<BrickSurfaces>))> = (0..means.count)
            .into_par_iter()
            .map(|brick| {
                if stop.load(Ordering::Relaxed) {
                    return Err(SceneError::Stopped);
                }
                let first = field.brick_first(brick);
                let classes = means.brick(first)?;
                let Some(stored) = classes.and_then(|classes| StoredClasses::new(&classes)) else {
                    return Ok(None);
                };
                let surfaces = labels.then(|| means.surfaces(first)).transpose()?;
                Ok(Some((brick, (stored, surfaces))))
            })
            .filter_map(Result::transpose)
            .collect::<Result<_, _>>()?;
        let (visible, made): (_, Vec<_>) = found.into_iter().unzip();
        let (bricks, surfaces): (_, Vec<_>) = made.into_iter().unzip();
        let surfaces = labels.then(|| StoredSurfaces::new(surfaces.into_iter().flatten(), &means));
        Ok((visible, Self { bricks, surfaces }))
    }

    /// Whether these are classes of labels, on whose surfaces light falls.
    pub fn are_of_labels(&self) -> bool {
        self.surfaces.is_some()
    }

    /// Surfaces of labels in the n-th visible brick: their mean gradient, differences per voxel of the level, and their share
    /// of its extinction. `false` without labels.
    pub fn decode_surfaces(&self, n: usize, out: &mut Surfaces) -> bool {
        let Some(surfaces) = &self.surfaces else {
            return false;
        };
        surfaces.decode(n, out);
        true
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
        let surfaces = self.surfaces.as_ref().map_or(0, StoredSurfaces::bytes);
        self.bricks.capacity() * size_of::<StoredClasses>() + surfaces
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
    cover: [Vec<Taps>; 3],
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
            cover: std::array::from_fn(|a| Taps::of_means(dims[0][a], dims[1][a])),
            count: bricks_of(field).iter().product::<usize>() as u32,
        }
    }

    /// Mean classes of a brick's voxels; `None` where nothing is visible.
    fn brick(&self, first: [u32; 3]) -> Result<Option<Box<Classes>>, SceneError> {
        let Some(covered) = self.covered(first).filter(|&covered| self.any_visible(covered)) else {
            return Ok(None);
        };
        let region = VoxelBox {
            first: covered.map(|[from, _]| from),
            size: covered.map(|[from, to]| to - from),
        };
        let mut memory = None;
        let block = self.source.read(region, &mut memory)?;
        let mut classes = Box::new([[0.0; 4]; BRICK_VOXELS]);
        for (place, class) in classes.iter_mut().enumerate() {
            if let Some(covers) = self.covers(first, place) {
                *class = self.mean(&block, covers);
            }
        }
        Ok(Some(classes))
    }

    /// First and past-the-last of the finest samples that a brick's voxels cover, along x, y, z.
    fn covered(&self, first: [u32; 3]) -> Option<[[usize; 2]; 3]> {
        // The level's voxels of the brick.
        let voxels: [[usize; 2]; 3] = std::array::from_fn(|a| {
            let (from, margin) = (first[a] as usize, self.margins[1][a]);
            let count = self.cover[a].len();
            [from, from + BRICK].map(|point| point.clamp(margin, margin + count) - margin)
        });
        let is_empty = voxels.iter().any(|[from, to]| from == to);
        (!is_empty).then(|| {
            std::array::from_fn(|a| {
                let [from, to] = voxels[a];
                [self.cover[a][from].range()[0], self.cover[a][to - 1].range()[1]]
            })
        })
    }

    /// What a voxel of a brick covers; nothing beyond the volume.
    fn covers(&self, first: [u32; 3], place: usize) -> Option<[&Taps; 3]> {
        let at = [place % BRICK, place / BRICK % BRICK, place / (BRICK * BRICK)];
        let cover = |a: usize| {
            let voxel = (first[a] as usize + at[a]).checked_sub(self.margins[1][a])?;
            self.cover[a].get(voxel)
        };
        Some([cover(0)?, cover(1)?, cover(2)?])
    }

    /// Class of a stored sample, unless it is invisible or missing.
    fn class(&self, sample: f64) -> Option<[f32; 4]> {
        let [factor, offset] = self.normalised;
        let [low, high] = self.hull;
        let value = (sample * factor + offset) as f32;
        // False where the sample is missing.
        (value >= low && value <= high).then(|| self.table.at(value))
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
    fn mean(&self, block: &Block<'_>, [xs, ys, zs]: [&Taps; 3]) -> [f32; 4] {
        let [from, to] = xs.range();
        let mut sum = [0.0f32; 4];
        for (z, of_z) in zs.iter() {
            for (y, of_y) in ys.iter() {
                with_samples!(block.samples, data => {
                    let row = &block.of.row(data, [y, z])[from - block.of.first[0]..to - block.of.first[0]];
                    for (&sample, (_, of_x)) in row.iter().zip(xs.iter()) {
                        if let Some(class) = self.class(widen(sample)) {
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
        Classification, ColorPoint, Grid, Label, LengthUnit, OpacityPoint, RenderSettings, Rescale, Samples,
        SheetSettings, Shows, TransferFunction, Volume,
    };
    use splatvol_testing::random::Random;

    use super::super::{Pyramid, VolumeLook, Wanted};
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
    fn surfaces_of_labels_are_those_of_the_finest_samples() {
        // Two labels that face each other along x, and nothing beyond; y and z run to the volume's faces.
        let label = |i: usize| [4u8, 4, 4, 4, 4, 4, 9, 9, 9, 9, 9, 0, 0, 0, 0, 0][i % 16];
        let samples = Samples::U8((0..16 * 16 * 16).map(label).collect::<Vec<_>>().into());
        let grid = Grid::centred([16; 3], DVec3::ONE).unwrap();
        let volume = Volume::new(grid, samples, Rescale::default(), LengthUnit::Unknown).unwrap();
        let settings = RenderSettings::default().with(SheetSettings {
            shows: Shows::Material(Classification::Pre),
            ..SheetSettings::default()
        });
        let mut pyramid = Pyramid::new(Arc::new(volume), &settings);
        let names = [(0.0, 0.0), (4.0, 0.5), (9.0, 0.8)];
        let names = names.map(|(value, opacity)| Label {
            value,
            rgb: [1.0; 3],
            opacity,
        });
        let transfer_function = TransferFunction::of_labels(&names, Some(1.0)).unwrap();
        let look = VolumeLook {
            transfer_function: &transfer_function,
            unit_distance: 1.0,
            labels: true,
        };
        let stop = AtomicBool::new(false);
        // Gradient along x per voxel, and share of surface, of the voxels along x. At a face both neighbours count by their
        // own label: the last 4 sees a 9 behind, the first 9 a 4 before it.
        let expected: [&[[f32; 2]]; 2] = [
            &[
                [0.0; 2],
                [0.0; 2],
                [-1.0, 0.5],
                [1.0, 0.5],
                [0.0; 2],
                [-1.0, 1.0],
                [0.0; 2],
                [0.0; 2],
            ],
            // Of the second voxel two samples are a 4 and two a 9: a surface each, whose gradients oppose each other by their
            // extinctions.
            &[[0.0; 2], [0.795_9, 0.5], [-2.0, 1.0 / 3.0], [0.0; 2]],
        ];
        for (level, expected) in (1..).zip(expected) {
            let level = pyramid.classify(level, look, Wanted::Classified, &stop).unwrap();
            let means = level.means.as_ref().unwrap();
            assert!(means.are_of_labels());
            let margin = level.field.margin();
            let dims = level.field.dims().map(|n| n.div_ceil(BRICK));
            let mut surfaces = [[0.0; 4]; BRICK_VOXELS];
            for (x, [gradient, share]) in expected.iter().enumerate() {
                let point = [x + margin[0], margin[1] + 1, margin[2] + 1];
                let [bx, by, bz] = point.map(|at| at / BRICK);
                let brick = (bz * dims[1] + by) * dims[0] + bx;
                let found = match level.visible.binary_search(&(brick as u32)) {
                    Ok(n) => {
                        assert!(means.decode_surfaces(n, &mut surfaces));
                        let [x, y, z] = point.map(|at| at % BRICK);
                        surfaces[(z * BRICK + y) * BRICK + x]
                    }
                    Err(_) => [0.0; 4],
                };
                let wanted = [*gradient, 0.0, 0.0, *share];
                for c in 0..4 {
                    assert!((found[c] - wanted[c]).abs() < 2e-3, "{x}: {found:?} {wanted:?}");
                }
            }
        }
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
                    .classify(
                        level,
                        VolumeLook {
                            transfer_function: &look,
                            unit_distance: 1.0,
                            labels: false,
                        },
                        Wanted::Classified,
                        &stop,
                    )
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
