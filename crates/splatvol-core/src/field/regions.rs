//! Tests: fields of samples that come region by region.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;
use splatvol_scene::volume::{Statistics, widen};
use splatvol_scene::{
    Block, Grid, Kernel, LengthUnit, Rescale, SampleSource, Samples, SceneError, Volume, VoxelBox,
    with_samples,
};
use splatvol_testing::random::Random;

use super::{FieldStore, Neighbourhood, SourceLevel};
use crate::kernel::GaussianKernel;
use crate::mip;
use crate::visibility::{BRICK_VOXELS, VisibleLevels};

/// Source that copies only the requested region; fails after so many reads.
#[derive(Debug)]
struct Pieces {
    volume: Volume,
    left: AtomicUsize,
}

impl SampleSource for Pieces {
    fn grid(&self, _: usize) -> &Grid {
        self.volume.grid()
    }

    fn rescale(&self, _: usize) -> Rescale {
        self.volume.rescale()
    }

    fn statistics(&self, _: usize) -> Statistics {
        self.volume.statistics()
    }

    fn read<'a>(
        &'a self,
        level: usize,
        of: VoxelBox,
        memory: &'a mut Option<Samples>,
    ) -> Result<Block<'a>, SceneError> {
        let took = self
            .left
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1));
        if took.is_err() {
            return Err(SceneError::Source {
                name: "pieces".into(),
                level,
                first: of.first,
                reason: "used up".into(),
            });
        }
        let whole = VoxelBox::whole(self.volume.grid());
        let rows = (0..of.size[1] * of.size[2]).map(|row| [row % of.size[1], row / of.size[1]]);
        let copy = with_samples!(self.volume.samples(), data => Samples::F64(
            rows.flat_map(|[y, z]| {
                let row = whole.row(data, [of.first[1] + y, of.first[2] + z]);
                row[of.first[0]..][..of.size[0]].iter().map(|&sample| widen(sample))
            })
            .collect(),
        ));
        Ok(Block {
            samples: memory.insert(copy),
            of,
        })
    }

    fn bytes(&self) -> usize {
        0
    }
}

fn volume(dims: [usize; 3], missing: f64) -> Volume {
    let mut random = Random::new(11);
    let count = dims.iter().product();
    let sample = |_| match random.unit() < missing {
        true => f64::NAN,
        false => random.unit() * 7.0 - 2.0,
    };
    let samples: Vec<f64> = (0..count).map(sample).collect();
    let grid = Grid::centred(dims, DVec3::ONE).unwrap();
    Volume::new(
        grid,
        Samples::F64(samples.into()),
        Rescale::default(),
        LengthUnit::Unknown,
    )
    .unwrap()
}

fn pieces(volume: &Volume, reads: usize) -> SourceLevel {
    let pieces = Pieces {
        volume: volume.clone(),
        left: reads.into(),
    };
    SourceLevel::new(Arc::new(pieces), 0)
}

/// Visible levels: a third of all.
fn levels() -> VisibleLevels {
    use splatvol_scene::{ColorPoint, OpacityPoint, TransferFunction};

    let points = [(0.0, 0.0), (2.5, 0.0), (3.0, 1.0), (3.5, 0.0)];
    let opacities = points.map(|(value, opacity)| OpacityPoint::new(value, opacity));
    let colors = vec![ColorPoint::new(0.0, [1.0; 3])];
    let look = TransferFunction::new(colors, opacities.to_vec(), None).unwrap();
    VisibleLevels::new(&crate::classification::ClassificationTable::new(
        &look,
        [-2.0, 5.0],
        1.0,
    ))
}

#[test]
fn regions_make_the_same_field_as_all_samples_at_once() {
    for (dims, missing) in [([70, 37, 41], 0.0), ([19, 70, 9], 0.02), ([66, 1, 35], 0.0)] {
        for kernel in [
            Kernel::default(),
            splatvol_scene::RenderSettings::fast().method.kernel(),
        ] {
            let kernel = &GaussianKernel::new(kernel);
            let volume = volume(dims, missing);
            let whole = SourceLevel::from(Arc::new(volume.clone()));
            for interpolates in [true, false] {
                let mut fields =
                    [whole.clone(), pieces(&volume, usize::MAX)].map(|source| match interpolates {
                        true => FieldStore::new(source, kernel),
                        false => FieldStore::of_samples(source, kernel),
                    });
                for field in &mut fields {
                    field.update(&levels());
                }
                let [whole, pieces] = &fields;
                assert!(whole.len() > 4 && pieces.failure().is_none());
                assert_eq!(
                    (whole.len(), whole.background()),
                    (pieces.len(), pieces.background())
                );
                for brick in 0..whole.len() {
                    let mut values = [[0.0; BRICK_VOXELS]; 2];
                    fields[0].decode(brick, &mut values[0]);
                    fields[1].decode(brick, &mut values[1]);
                    assert_eq!(
                        values[0].map(f32::to_bits),
                        values[1].map(f32::to_bits),
                        "{dims:?} {brick}"
                    );
                }
                let mut bricks = [Vec::new(), Vec::new()];
                fields[0].visible_bricks(&levels(), &mut bricks[0]);
                fields[1].visible_bricks(&levels(), &mut bricks[1]);
                assert_eq!(bricks[0], bricks[1]);
                for &brick in &bricks[0] {
                    let mut around = [Neighbourhood::default(), Neighbourhood::default()];
                    fields[0].read(brick, &mut around[0]);
                    fields[1].read(brick, &mut around[1]);
                    let [a, b] =
                        around.map(|own| own.values.map(|slice| slice.map(|row| row.map(f32::to_bits))));
                    assert_eq!(a, b, "{dims:?} {brick}");
                }
            }
        }
    }
}

#[test]
fn regions_have_the_same_half_as_all_samples_at_once() {
    let volume = volume([37, 8, 21], 0.05);
    let whole = mip::half(&Arc::new(volume.clone()).into()).unwrap();
    let pieces = mip::half(&pieces(&volume, usize::MAX)).unwrap();
    let bits = |half: &Volume| {
        (0..half.samples().len())
            .map(|i| half.value(i).to_bits())
            .collect::<Vec<_>>()
    };
    assert_eq!(bits(&whole), bits(&pieces));
}

#[test]
fn what_cannot_be_read_is_told() {
    let volume = volume([40, 40, 40], 0.0);
    let kernel = &GaussianKernel::new(Kernel::default());
    for reads in [0, 3, 60] {
        let mut field = FieldStore::new(pieces(&volume, reads), kernel);
        field.update(&levels());
        let failure = field.failure().expect("a source that fails").to_string();
        assert!(
            failure.starts_with("pieces: level 0, samples from ["),
            "{failure}"
        );
    }
    let error = mip::half(&pieces(&volume, 2)).unwrap_err();
    assert!(matches!(error, SceneError::Source { .. }), "{error}");
}
