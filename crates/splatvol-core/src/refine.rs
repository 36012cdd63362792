//! Long voxels: volumes whose samples lie much farther apart along some axes than along others, as slices of CT and MR do.
//!
//! The kernel of such a voxel covers many pixels and many sheets. So samples are first interpolated along these axes, to
//!
//! ```text
//! n = ceil(r / 1.4),  r = spacing / smallest spacing, where r is at least 2.5
//! ```
//!
//! samples per voxel, at `(i + 1/2) / n - 1/2` for i = 0, 1, 2..., so that the box stays. What follows draws a volume of
//! nearly cubic voxels. The interpolation is the six-point cubic convolution of Keys 1981 ("Cubic convolution interpolation
//! for digital image processing", section VI): once continuously differentiable, of fourth order. The samples are
//! continued by their mirror image at the box's faces, and no new one leaves their range.
//!
//! Only where values are interpolated anyway: voxels that are classified first, smoothing kernels and volumes with
//! missing samples keep their long kernels.

use std::sync::Arc;

use splatvol_scene::volume::Statistics;
use splatvol_scene::{
    Block, Grid, MinMaxIndex, RenderSettings, Rescale, SampleSource, Samples, SceneError, SheetSettings,
    Survey, Volume, VoxelBox,
};

use crate::field::{SourceLevel, spread};
use crate::level::Wanted;
use crate::resample::{Resampling, Taps, world_from_new};

/// Ratio of spacings from which on voxels are long.
const LONG: f64 = 2.5;
/// Ratio of spacings that is left at most.
const LEFT: f64 = 1.4;
/// Share of a ratio that may come from rounding: turned volumes are refined as others are.
const ROUNDING: f64 = 1e-6;
/// Most new samples per old one.
const MOST_PER_SAMPLE: usize = 16;
/// Most new samples.
const MOST: usize = 1 << 28;

/// Whether pictures with these settings show interpolated values, so that long voxels are refined.
pub(crate) fn applies(settings: &RenderSettings<SheetSettings>) -> bool {
    settings.method.prefilter && Wanted::of(settings) != Wanted::Classified
}

/// The grid of the finest samples that are drawn of a volume.
pub fn finest_grid(volume: &Volume, settings: &RenderSettings<SheetSettings>) -> Grid {
    let own = volume.finest_grid();
    let refined = match applies(settings) && volume.statistics().non_finite == 0 {
        true => Finer::of(own, 0.0),
        false => None,
    };
    refined.map_or_else(|| own.clone(), |finer| finer.grid)
}

/// A source's own level whose voxels are long. A spacing counts as at least that of the level's octave, so that a level that is
/// coarser along some axes alone is not refined back.
#[derive(Debug)]
pub(crate) struct LongLevel<'a> {
    source: &'a SourceLevel,
    finer: Finer,
}

impl<'a> LongLevel<'a> {
    /// A level, of those of a source; `None` where its voxels are not long.
    pub(crate) fn of(levels: &'a [SourceLevel], number: usize) -> Option<Self> {
        let source = &levels[number];
        let octave = smallest_spacing(levels[0].grid()) * libm::exp2(number as f64);
        let least = if number == 0 { 0.0 } else { octave };
        Some(Self {
            source,
            finer: Finer::of(source.grid(), least)?,
        })
    }

    /// The level with more samples, itself where samples are missing. It must have been surveyed.
    ///
    /// # Errors
    /// Samples that cannot be read.
    pub(crate) fn refined(&self) -> Result<SourceLevel, SceneError> {
        match self.source.statistics().non_finite {
            0 => refined(self.source, &self.finer),
            _ => Ok(self.source.clone()),
        }
    }
}

fn refined(source: &SourceLevel, finer: &Finer) -> Result<SourceLevel, SceneError> {
    let statistics = source.statistics();
    let taps = finer.taps(source.grid().dims());
    let resampling = Resampling::new(source, finer.grid.clone(), taps)?;
    let mut survey = Survey {
        statistics,
        spread: spread(source)?,
        index: None,
    };
    let (old, new) = (source.rescale(), resampling.rescale());
    for stored in &mut survey.spread {
        *stored = (old.apply(*stored) - new.intercept) / new.slope;
    }
    let made: Arc<dyn SampleSource> = match source.chunks() {
        None => Arc::new(Refined {
            volume: resampling.volume()?,
            survey,
        }),
        Some(chunks) => {
            let (_, level) = source.of();
            let index = chunks.index(level);
            let index = index.map(|own| finer.index(&own, &resampling));
            let chunk = finer.chunk(chunks.layout(level).chunk);
            let made = resampling.in_chunks((level, "refinement"), (chunk, index), chunks)?;
            made.set_survey(0, survey);
            made
        }
    };
    Ok(SourceLevel::new(made, 0))
}

/// The smallest distance of samples along an axis with several.
fn smallest_spacing(grid: &Grid) -> f64 {
    let spacing = grid.spacing().to_array();
    let axes = (0..3).filter(|&axis| grid.dims()[axis] > 1);
    axes.map(|axis| spacing[axis]).fold(f64::INFINITY, f64::min)
}

/// A grid with more samples along long axes, in the same box.
#[derive(Debug)]
struct Finer {
    /// New samples per old one, along x, y, z.
    factors: [usize; 3],
    grid: Grid,
}

impl Finer {
    /// `None` where no axis is long, compared with the smallest spacing, or a larger one.
    fn of(own: &Grid, least: f64) -> Option<Self> {
        let (dims, spacing) = (own.dims(), own.spacing().to_array());
        let least = smallest_spacing(own).max(least);
        let mut factors: [usize; 3] = std::array::from_fn(|axis| {
            let ratio = spacing[axis] / least;
            match dims[axis] > 1 && ratio >= LONG - ROUNDING {
                true => (ratio / LEFT - ROUNDING).ceil().min(MOST_PER_SAMPLE as f64) as usize,
                false => 1,
            }
        });
        let fits = |factors: &[usize; 3]| {
            let new: [usize; 3] = std::array::from_fn(|axis| dims[axis].saturating_mul(factors[axis]));
            let count = new.iter().fold(1usize, |count, &n| count.saturating_mul(n));
            let most = MOST.min(own.sample_count().saturating_mul(MOST_PER_SAMPLE));
            count <= most && new.iter().all(|&n| n <= Grid::MAX_DIM)
        };
        while factors != [1; 3] && !fits(&factors) {
            let largest = (0..3).max_by_key(|&axis| factors[axis])?;
            factors[largest] -= 1;
        }
        let new = std::array::from_fn(|axis| dims[axis] * factors[axis]);
        let grid = Grid::from_affine(new, world_from_new(own, new)).ok()?;
        (factors != [1; 3]).then_some(Self { factors, grid })
    }

    /// Old samples of the new ones along each axis.
    fn taps(&self, own: [usize; 3]) -> [Vec<Taps>; 3] {
        std::array::from_fn(|axis| {
            let factor = self.factors[axis];
            let all = 0..own[axis] * factor;
            all.map(|i| interpolation(i, (factor, own[axis]))).collect()
        })
    }

    /// Samples of a chunk, made of old chunks of so many: as many as these have, up to 64 along each axis.
    fn chunk(&self, own: [usize; 3]) -> [usize; 3] {
        std::array::from_fn(|axis| {
            let factor = self.factors[axis];
            factor * (own[axis].min(CHUNK_EDGE) / factor).max(1)
        })
    }

    /// Smallest and largest new samples of blocks, or less and more, from those of the old ones.
    fn index(&self, own: &MinMaxIndex, resampling: &Resampling) -> MinMaxIndex {
        let dims = self.grid.dims();
        let mut index = MinMaxIndex::new(dims, INDEX_BLOCK, 0);
        let counts: [usize; 3] = std::array::from_fn(|axis| dims[axis].div_ceil(INDEX_BLOCK[axis]));
        for number in 0..counts.iter().product::<usize>() {
            let block = [
                number % counts[0],
                number / counts[0] % counts[1],
                number / (counts[0] * counts[1]),
            ];
            let first: [usize; 3] = std::array::from_fn(|axis| block[axis] * INDEX_BLOCK[axis]);
            let region = VoxelBox {
                first,
                size: std::array::from_fn(|axis| INDEX_BLOCK[axis].min(dims[axis] - first[axis])),
            };
            let ends = own.within(resampling.old_samples(region));
            let ends = ends.map_or([f64::NAN; 2], |ends| resampling.ends(ends, OVERSHOOT));
            index.join(block, ends);
        }
        index
    }
}

/// Largest edge of a chunk of new samples.
const CHUNK_EDGE: usize = 64;
/// New samples of a block of the index.
const INDEX_BLOCK: [usize; 3] = [16; 3];
/// How far, relative to the range of the old samples, new ones may lie outside: the sum of the negative weights, which is
/// .1875 along an axis, and .445 along two.
const OVERSHOOT: f64 = 0.45;

/// The old samples of a new one along an axis.
fn interpolation(i: usize, (factor, own): (usize, usize)) -> Taps {
    if factor == 1 {
        return Taps::new(i, vec![1.0]);
    }
    let at = (i as f64 + 0.5) / factor as f64 - 0.5;
    let below = at.floor() as i64;
    let near: Vec<(usize, f64)> = (below - 2..=below + 3)
        .map(|sample| (mirrored(sample, own), keys(at - sample as f64)))
        .collect();
    let first = near.iter().map(|(sample, _)| *sample).min().unwrap_or(0);
    let end = near.iter().map(|(sample, _)| sample + 1).max().unwrap_or(0);
    let mut weights = vec![0.0; end - first];
    for (sample, weight) in near {
        weights[sample - first] += weight;
    }
    Taps::new(first, weights.into_iter().map(|weight| weight as f32).collect())
}

/// The sample that stands for one beyond a face: the box's mirror image.
fn mirrored(sample: i64, count: usize) -> usize {
    let period = 2 * count as i64;
    let at = sample.rem_euclid(period);
    at.min(period - 1 - at) as usize
}

/// The six-point cubic convolution kernel.
fn keys(offset: f64) -> f64 {
    let s = offset.abs();
    match s {
        _ if s < 1.0 => (4.0 / 3.0 * s - 7.0 / 3.0) * s * s + 1.0,
        _ if s < 2.0 => ((-7.0 / 12.0 * s + 3.0) * s - 59.0 / 12.0) * s + 2.5,
        _ if s < 3.0 => ((s / 12.0 - 2.0 / 3.0) * s + 1.75) * s - 1.5,
        _ => 0.0,
    }
}

/// A refined level in memory, with the range and the spread samples of the one that it was made of, as one in chunks has them.
#[derive(Debug)]
struct Refined {
    volume: Volume,
    survey: Survey,
}

impl SampleSource for Refined {
    fn grid(&self, _: usize) -> &Grid {
        self.volume.grid()
    }

    fn rescale(&self, _: usize) -> Rescale {
        self.volume.rescale()
    }

    fn statistics(&self, _: usize) -> Statistics {
        self.survey.statistics
    }

    fn read<'a>(
        &'a self,
        level: usize,
        region: VoxelBox,
        memory: &'a mut Option<Samples>,
    ) -> Result<Block<'a>, SceneError> {
        SampleSource::read(&self.volume, level, region, memory)
    }

    fn survey(&self, _: usize) -> Option<&Survey> {
        Some(&self.survey)
    }

    fn bytes(&self) -> usize {
        SampleSource::bytes(&self.volume)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use splatvol_scene::LengthUnit;
    use splatvol_scene::volume::widen;
    use splatvol_testing::random::Random;

    use super::*;

    fn grid(dims: [usize; 3], spacing: [f64; 3]) -> Grid {
        let turned = glam::DMat3::from_rotation_y(0.3);
        Grid::new(
            dims,
            DVec3::new(3.0, -1.0, 2.0),
            DVec3::from_array(spacing),
            turned,
        )
        .unwrap()
    }

    fn source(grid: &Grid, samples: Samples) -> SourceLevel {
        let volume = Volume::new(grid.clone(), samples, Rescale::default(), LengthUnit::Unknown).unwrap();
        Arc::new(volume).into()
    }

    fn refined(level: &SourceLevel) -> SourceLevel {
        let levels = [level.clone()];
        LongLevel::of(&levels, 0).unwrap().refined().unwrap()
    }

    #[test]
    fn levels_that_are_coarser_along_some_axes_stay_as_coarse() {
        let levels = |spacings: &[[f64; 3]]| -> Vec<Option<[usize; 3]>> {
            let level = |spacing: &[f64; 3]| {
                let own = grid([8, 9, 10], *spacing);
                source(&own, Samples::F32(vec![1.0; 720].into()))
            };
            let all: Vec<SourceLevel> = spacings.iter().map(level).collect();
            let factors = |number| LongLevel::of(&all, number).map(|long| long.finer.factors);
            (0..all.len()).map(factors).collect()
        };
        // A stack of slices that is halved within them: the first levels are refined across, none within.
        let stack = [
            [0.2, 0.2, 1.0],
            [0.4, 0.4, 1.0],
            [0.8, 0.8, 1.0],
            [3.2, 3.2, 1.0],
            [6.4, 6.4, 1.0],
        ];
        let expected = [Some([1, 1, 4]), Some([1, 1, 2]), None, None, None];
        assert_eq!(levels(&stack), expected);
    }

    fn values(of: &SourceLevel) -> Vec<f64> {
        let mut memory = None;
        let block = of.read(VoxelBox::whole(of.grid()), &mut memory).unwrap();
        let rescale = of.rescale();
        splatvol_scene::with_samples!(block.samples, data => {
            data.iter().map(|&sample| rescale.apply(widen(sample))).collect()
        })
    }

    #[test]
    fn long_axes_alone_get_more_samples_in_the_same_box() {
        for (dims, spacing, factors) in [
            ([20, 30, 10], [0.5, 0.5, 5.0], Some([1, 1, 8])),
            ([20, 30, 10], [0.8, 0.8, 2.0], Some([1, 1, 2])),
            ([20, 30, 10], [1.0, 1.0, 2.4], None),
            ([20, 30, 10], [3.0, 1.0, 3.0], Some([3, 1, 3])),
            // Images, and slices without an end.
            ([20, 30, 1], [1.0, 1.0, 9.0], None),
            ([1, 30, 10], [0.1, 1.0, 1.0], None),
            ([20, 30, 10], [1.0, 1.0, 1e4], Some([1, 1, 16])),
            ([20, 30, 10], [1.0, 1e4, 1e4], Some([1, 4, 4])),
            ([2, 2, 5000], [1.0, 1.0, 1e4], Some([1, 1, 13])),
        ] {
            let own = grid(dims, spacing);
            let found = Finer::of(&own, 0.0);
            assert_eq!(found.as_ref().map(|finer| finer.factors), factors, "{spacing:?}");
            if let Some(finer) = found {
                for (a, b) in own.corners().iter().zip(finer.grid.corners()) {
                    assert!((*a - b).length() < 1e-8 * own.bounds().diagonal(), "{a} {b}");
                }
            }
        }
    }

    #[test]
    fn cubic_fields_are_interpolated_and_no_value_leaves_the_range() {
        let own = grid([3, 2, 24], [1.0, 1.0, 4.0]);
        let cubic = |z: f64| 2.0 + 0.3 * z + 0.05 * z * z - 0.001 * z * z * z;
        let data: Vec<f64> = (0..144).map(|i| cubic((i / 6) as f64)).collect();
        let level = source(&own, Samples::F64(data.into()));
        let finer = refined(&level);
        assert_eq!(finer.grid().dims(), [3, 2, 72]);
        for (i, value) in values(&finer).into_iter().enumerate() {
            let z = ((i / 6) as f64 + 0.5) / 3.0 - 0.5;
            if (3.0..20.0).contains(&z) {
                assert!((value - cubic(z)).abs() < 2e-5, "{z}: {value} {}", cubic(z));
            }
        }
        let mut random = Random::new(3);
        let data: Vec<u8> = (0..144)
            .map(|_| if random.unit() < 0.5 { 10 } else { 200 })
            .collect();
        let level = source(&own, Samples::U8(data.into()));
        let finer = refined(&level);
        let found = values(&finer);
        assert!(found.iter().all(|value| (10.0..=200.0).contains(value)));
        assert!(found.contains(&10.0) && found.contains(&200.0));
        assert_eq!(finer.value_range(), level.value_range());
    }

    #[test]
    fn missing_samples_keep_long_voxels() {
        let own = grid([3, 2, 24], [1.0, 1.0, 4.0]);
        let mut data = vec![1.0f32; 144];
        data[7] = f32::NAN;
        let level = source(&own, Samples::F32(data.into()));
        assert!(Arc::ptr_eq(refined(&level).of().0, level.of().0));
    }

    #[test]
    fn weights_sum_to_one_and_stay_within_what_the_index_allows() {
        for (factor, own) in [(2, 9), (8, 5), (3, 2), (16, 1000)] {
            for i in 0..factor * own {
                let taps = interpolation(i, (factor, own));
                let sum: f32 = taps.iter().map(|(_, weight)| weight).sum();
                let outside: f32 = taps.iter().map(|(_, weight)| (-weight).max(0.0)).sum();
                assert!((sum - 1.0).abs() < 1e-6, "{i}: {sum}");
                assert!(outside < 0.1876, "{i}: {outside}");
                assert!(taps.range()[1] <= own);
            }
        }
    }
}
