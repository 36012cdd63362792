//! Volumes in memory as chunks, and chunks as volumes for engines.

use std::sync::{Arc, OnceLock};

use glam::DAffine3;

use super::region::copy_box;
use super::{Budget, CachedSource, ChunkBuffer, ChunkContent, ChunkSource, LevelLayout, MinMaxIndex};
use super::{OverBudget, Reservation, SourceError, SourceIdentity};
use crate::volume::Statistics;
use crate::{Block, Grid, LengthUnit, Rescale, SampleSource, Samples, SceneError, Volume, VoxelBox};

/// Edge of the chunks of a volume in memory, samples.
const EDGE: usize = 64;

/// A volume in memory, of one level. Regions of it are copies.
#[derive(Debug)]
struct InMemory {
    volume: Arc<Volume>,
    levels: [LevelLayout; 1],
}

impl From<Arc<Volume>> for Box<dyn ChunkSource> {
    fn from(volume: Arc<Volume>) -> Self {
        let layout = LevelLayout {
            grid: volume.grid().clone(),
            chunk: [EDGE; 3],
            element: volume.samples().element_type(),
            rescale: volume.rescale(),
            fill: 0.0,
        };
        Box::new(InMemory {
            volume,
            levels: [layout],
        })
    }
}

impl ChunkSource for InMemory {
    fn levels(&self) -> &[LevelLayout] {
        &self.levels
    }

    fn read(
        &self,
        level: usize,
        chunk: [usize; 3],
        into: &mut ChunkBuffer,
    ) -> Result<ChunkContent, SourceError> {
        let region = self.levels[level].region(chunk);
        let mut samples = std::mem::replace(&mut into.samples, Samples::U8(Vec::new().into()));
        self.read_region(level, region, &mut samples, into)?;
        into.samples = samples;
        Ok(ChunkContent::Samples)
    }

    fn read_region(
        &self,
        level: usize,
        region: VoxelBox,
        into: &mut Samples,
        _: &mut ChunkBuffer,
    ) -> Result<(), SourceError> {
        let layout = &self.levels[level];
        into.refill(layout.element, region.len(), layout.fill);
        copy_box(self.volume.samples(), VoxelBox::whole(&layout.grid), into, region);
        Ok(())
    }

    fn reads_regions(&self) -> bool {
        true
    }

    fn identity(&self) -> SourceIdentity {
        let [x, y, z] = self.levels[0].grid.dims();
        SourceIdentity {
            name: "memory".to_owned(),
            state: format!("{x}x{y}x{z} {}", self.levels[0].element.name()),
        }
    }
}

/// Samples that stand for all in histograms, about so many.
const SPREAD: usize = 1 << 16;

/// Samples from one that stands for its level to the next, given the number of all.
pub fn spread_step(samples: usize) -> usize {
    (samples / SPREAD).max(1) | 1
}

/// Of a level of which nothing is known.
const UNKNOWN: Statistics = Statistics {
    min: 0.0,
    max: 0.0,
    mean: 0.0,
    non_finite: 0,
};

/// What must be known of a level before it can be drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Survey {
    /// Range, mean and missing samples, in real values. Where nobody read through the level, the mean is that of
    /// another.
    pub statistics: Statistics,
    /// Every n-th stored sample, n by [`spread_step`].
    pub spread: Vec<f64>,
    /// Smallest and largest samples of blocks, where they were found by reading through the level.
    pub index: Option<Arc<MinMaxIndex>>,
}

/// A source of chunks as engines read samples: region by region, through a cache, within a budget of bytes. Clones, and
/// the same volume at other places, share cache and budget.
#[derive(Debug, Clone)]
pub struct ChunkedVolume {
    shared: Arc<Shared>,
    grids: Vec<Grid>,
}

#[derive(Debug)]
struct Shared {
    source: CachedSource,
    budget: Arc<Budget>,
    unit: LengthUnit,
    surveys: Vec<OnceLock<Survey>>,
    /// Statistics of a coarse level, for those that were not surveyed, and the memory of its samples.
    overview: OnceLock<(Statistics, Reservation)>,
}

impl ChunkedVolume {
    /// A source, whose samples and all that is derived from them shall take no more than a budget. `holes`: chunks
    /// that are lost are holes, not errors.
    ///
    /// # Errors
    /// A budget of which nothing is left.
    pub fn new(
        source: Arc<dyn ChunkSource>,
        unit: LengthUnit,
        (budget, holes): (Arc<Budget>, bool),
    ) -> Result<Self, OverBudget> {
        let grids: Vec<Grid> = source.levels().iter().map(|level| level.grid.clone()).collect();
        let source = CachedSource::new(source, budget.reserve(0)?);
        Ok(Self {
            shared: Arc::new(Shared {
                surveys: grids.iter().map(|_| OnceLock::new()).collect(),
                source: if holes { source.with_holes() } else { source },
                budget,
                unit,
                overview: OnceLock::new(),
            }),
            grids,
        })
    }

    /// A volume whose overview, from which looks and cameras are chosen, is a coarse level, or of one that has more samples
    /// than `most` every n-th along each axis. They are read now, and count.
    ///
    /// # Errors
    /// Samples that cannot be read, or that are larger than the budget.
    pub fn over(self, level: usize, most: usize) -> Result<Volume, SceneError> {
        let overview = match self.grids[level].sample_count() <= most {
            true => self.in_memory(level)?,
            false => self.thinned(level, most)?,
        };
        let bytes = overview.bytes() as u64;
        let budget = &self.shared.budget;
        let region = VoxelBox::whole(&self.grids[level]);
        let reserved = budget.try_reserve(bytes).ok_or_else(|| {
            let reason = format!(
                "of {} bytes of memory, {bytes} are needed for an overview",
                budget.limit()
            );
            self.failed(level, region, reason)
        })?;
        let _ = self.shared.overview.set((overview.statistics(), reserved));
        // What is read from now on is read for pictures.
        self.shared.source.take_counts();
        Ok(overview.over_chunks(self))
    }

    /// The same at another place: its maps from voxel to world become `world_from_old * world_from_voxel`.
    ///
    /// # Errors
    /// Same as [`Grid::from_affine`].
    pub fn transformed(&self, world_from_old: DAffine3) -> Result<Self, SceneError> {
        let moved = |grid: &Grid| Grid::from_affine(grid.dims(), world_from_old * grid.world_from_voxel());
        Ok(Self {
            shared: Arc::clone(&self.shared),
            grids: self.grids.iter().map(moved).collect::<Result<_, _>>()?,
        })
    }

    /// Unit of world lengths.
    pub fn unit(&self) -> LengthUnit {
        self.shared.unit
    }

    /// The chunks, and those in memory.
    pub fn source(&self) -> &CachedSource {
        &self.shared.source
    }

    /// Bytes that samples and all that is derived from them may take.
    pub fn budget(&self) -> &Arc<Budget> {
        &self.shared.budget
    }

    /// Division of a level into chunks; its grid is the stored one, not that of [`SampleSource::grid`].
    pub fn layout(&self, level: usize) -> &LevelLayout {
        &self.shared.source.levels()[level]
    }

    /// What is known of a level.
    pub fn survey(&self, level: usize) -> Option<&Survey> {
        self.shared.surveys[level].get()
    }

    /// Says what is known of a level; what was said first holds.
    pub fn set_survey(&self, level: usize, survey: Survey) {
        let _ = self.shared.surveys[level].set(survey);
    }

    /// Smallest and largest stored values of the blocks of a level: those that the source knows, or those that were
    /// found when the level was surveyed.
    pub fn index(&self, level: usize) -> Option<Arc<MinMaxIndex>> {
        let surveyed = || self.survey(level)?.index.clone();
        self.shared.source.index(level).or_else(surveyed)
    }

    /// All samples of a level in memory.
    ///
    /// # Errors
    /// Samples that cannot be read, or that are larger than the budget.
    pub fn in_memory(&self, level: usize) -> Result<Volume, SceneError> {
        let (layout, grid) = (self.layout(level), &self.grids[level]);
        let wanted = grid.sample_count() as u64 * layout.element.size() as u64;
        let region = VoxelBox::whole(grid);
        if wanted > self.shared.budget.limit() {
            let limit = self.shared.budget.limit();
            let reason = format!("in memory it takes {wanted} bytes, and {limit} are allowed");
            return Err(self.failed(level, region, reason));
        }
        let mut samples = layout.element.filled(0, 0.0);
        let source = &self.shared.source;
        source
            .read_region(level, region, &mut samples, &mut ChunkBuffer::default())
            .map_err(|error| self.failed(level, region, error.to_string()))?;
        Volume::new(grid.clone(), samples, layout.rescale, self.shared.unit)
    }

    fn failed(&self, level: usize, region: VoxelBox, reason: String) -> SceneError {
        SceneError::Source {
            name: self.shared.source.identity().name,
            level,
            first: region.first,
            reason,
        }
    }
}

impl SampleSource for ChunkedVolume {
    fn levels(&self) -> usize {
        self.grids.len()
    }

    fn grid(&self, level: usize) -> &Grid {
        &self.grids[level]
    }

    fn rescale(&self, level: usize) -> Rescale {
        self.layout(level).rescale
    }

    fn statistics(&self, level: usize) -> Statistics {
        let overview = || self.shared.overview.get().map(|(statistics, _)| *statistics);
        let own = self.survey(level).map(|survey| survey.statistics);
        own.or_else(overview).unwrap_or(UNKNOWN)
    }

    fn read<'a>(
        &'a self,
        level: usize,
        region: VoxelBox,
        memory: &'a mut Option<Samples>,
    ) -> Result<Block<'a>, SceneError> {
        let samples = memory.get_or_insert_with(|| self.layout(level).element.filled(0, 0.0));
        let source = &self.shared.source;
        source
            .read_region(level, region, samples, &mut ChunkBuffer::default())
            .map_err(|error| error.of_scene(source.identity().name, region))?;
        Ok(Block { samples, of: region })
    }

    fn survey(&self, level: usize) -> Option<&Survey> {
        Self::survey(self, level)
    }

    fn bytes(&self) -> usize {
        self.shared.source.kept_bytes() as usize
    }

    fn chunks(&self) -> Option<&ChunkedVolume> {
        Some(self)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{ChunkCounts, ChunkFault};
    use super::*;
    use glam::DVec3;

    fn volume(dims: [usize; 3]) -> Arc<Volume> {
        let data: Vec<u16> = (0..dims.iter().product::<usize>())
            .map(|i| (i * 7919 % 65_521) as u16)
            .collect();
        let grid = Grid::centred(dims, DVec3::ONE).unwrap();
        Arc::new(
            Volume::new(
                grid,
                Samples::U16(data.into()),
                Rescale::default(),
                LengthUnit::Unknown,
            )
            .unwrap(),
        )
    }

    /// Chunks of 4 x 3 x 5; every third one is constant.
    #[derive(Debug)]
    struct Pieces {
        levels: Vec<LevelLayout>,
        whole: Box<dyn ChunkSource>,
        fails: bool,
    }

    impl Pieces {
        fn new(volume: Arc<Volume>, fails: bool) -> Self {
            let whole: Box<dyn ChunkSource> = volume.into();
            let mut layout = whole.levels()[0].clone();
            layout.chunk = [4, 3, 5];
            Self {
                levels: vec![layout],
                whole,
                fails,
            }
        }
    }

    impl ChunkSource for Pieces {
        fn levels(&self) -> &[LevelLayout] {
            &self.levels
        }

        fn read(
            &self,
            level: usize,
            chunk: [usize; 3],
            into: &mut ChunkBuffer,
        ) -> Result<ChunkContent, SourceError> {
            if self.fails {
                return Err(SourceError::Missing(Box::new(ChunkFault {
                    level,
                    chunk,
                    key: "a/b".to_owned(),
                    codec: Some("none".to_owned()),
                    offset: 9,
                    reason: "gone".to_owned(),
                })));
            }
            if chunk.iter().sum::<usize>() % 3 == 2 {
                return Ok(ChunkContent::Constant(12.0));
            }
            let mut samples = std::mem::replace(&mut into.samples, Samples::U8(Vec::new().into()));
            self.whole
                .read_region(0, self.levels[0].region(chunk), &mut samples, into)?;
            into.samples = samples;
            Ok(ChunkContent::Samples)
        }

        fn identity(&self) -> SourceIdentity {
            self.whole.identity()
        }
    }

    #[test]
    fn regions_hold_the_samples_of_their_chunks() {
        let dims = [11, 7, 9];
        let volume = volume(dims);
        let Samples::U16(all) = volume.samples() else {
            panic!()
        };
        let pieces: Arc<dyn ChunkSource> = Arc::new(Pieces::new(Arc::clone(&volume), false));
        let cached = CachedSource::new(Arc::clone(&pieces), Budget::new(2000).reserve(2000).unwrap());
        let unit = LengthUnit::Unknown;
        let chunked = ChunkedVolume::new(Arc::clone(&pieces), unit, (Budget::new(2000), false)).unwrap();
        chunked.source().resize(1000).unwrap();
        for (first, size) in [
            ([0; 3], dims),
            ([3, 2, 4], [5, 3, 2]),
            ([10, 6, 8], [1; 3]),
            ([1; 3], [7, 6, 8]),
        ] {
            let region = VoxelBox { first, size };
            let expected: Vec<u16> = (0..region.len())
                .map(|i| {
                    let at = [i % size[0], i / size[0] % size[1], i / (size[0] * size[1])];
                    let [x, y, z]: [usize; 3] = std::array::from_fn(|a| first[a] + at[a]);
                    match (x / 4 + y / 3 + z / 5) % 3 {
                        2 => 12,
                        _ => all[x + dims[0] * (y + dims[1] * z)],
                    }
                })
                .collect();
            let expected = Samples::U16(expected.into());
            let mut memory = None;
            assert_eq!(chunked.read(0, region, &mut memory).unwrap().samples, &expected);
            for source in [&*pieces, &cached] {
                let (mut found, mut buffer) = (Samples::U8(Vec::new().into()), ChunkBuffer::default());
                source.read_region(0, region, &mut found, &mut buffer).unwrap();
                assert_eq!(found, expected, "{region:?}");
            }
        }
    }

    #[test]
    fn failures_name_their_place() {
        let volume = volume([5, 5, 5]);
        let source: Arc<dyn ChunkSource> = Arc::new(Pieces::new(Arc::clone(&volume), true));
        let unit = LengthUnit::Unknown;
        let of = |holes| ChunkedVolume::new(Arc::clone(&source), unit, (Budget::new(2000), holes)).unwrap();
        let chunked = of(false);
        let region = VoxelBox {
            first: [4, 0, 0],
            size: [1; 3],
        };
        let error = chunked.read(0, region, &mut None).unwrap_err().to_string();
        let expected = "memory: level 0, samples from [4, 0, 0]: level 0, chunk 1,0,0, key a/b from byte 9, codec none: gone";
        assert_eq!(error, expected);
        assert!(chunked.in_memory(0).is_err());
        // Holes are counted, and have the value that was set last.
        let chunked = of(true);
        chunked.source().set_hole(7.0);
        let mut memory = None;
        assert_eq!(
            chunked.read(0, region, &mut memory).unwrap().samples,
            &Samples::U16(vec![7].into())
        );
        let counts = chunked.source().take_counts();
        assert_eq!(
            (counts.holes, counts.reads, counts.chunks, counts.most),
            (1, 1, 1, 1)
        );
        assert_eq!(chunked.source().take_counts(), ChunkCounts::default());
        let small = ChunkedVolume::new(source, unit, (Budget::new(100), true)).unwrap();
        assert!(small.in_memory(0).unwrap_err().to_string().contains("250 bytes"));
    }
}
