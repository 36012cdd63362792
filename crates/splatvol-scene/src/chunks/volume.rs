//! Volumes in memory as chunks, and chunks as volumes for engines.

use std::sync::Arc;

use super::region::copy_box;
use super::{ChunkBuffer, ChunkContent, ChunkSource, LevelLayout, SourceError, SourceIdentity};
use crate::volume::Statistics;
use crate::{Block, Grid, Rescale, SampleSource, Samples, SceneError, Volume, VoxelBox};

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

/// Chunks as engines read samples: region by region.
#[derive(Debug)]
pub struct ChunkedVolume {
    source: Arc<dyn ChunkSource>,
    statistics: Vec<Statistics>,
}

impl ChunkedVolume {
    /// A source and the statistics of its levels, the finest first. Nobody reads through all of a large volume to
    /// find them: those of a coarse level may stand for all.
    ///
    /// # Errors
    /// Another number of statistics than of levels.
    pub fn new(source: Arc<dyn ChunkSource>, statistics: Vec<Statistics>) -> Result<Self, SceneError> {
        if statistics.len() != source.levels().len() {
            return Err(SceneError::invalid(
                "statistics",
                statistics.len(),
                "one of each level",
            ));
        }
        Ok(Self { source, statistics })
    }

    fn layout(&self, level: usize) -> &LevelLayout {
        &self.source.levels()[level]
    }
}

impl SampleSource for ChunkedVolume {
    fn levels(&self) -> usize {
        self.statistics.len()
    }

    fn grid(&self, level: usize) -> &Grid {
        &self.layout(level).grid
    }

    fn rescale(&self, level: usize) -> Rescale {
        self.layout(level).rescale
    }

    fn statistics(&self, level: usize) -> Statistics {
        self.statistics[level]
    }

    fn read<'a>(
        &'a self,
        level: usize,
        region: VoxelBox,
        memory: &'a mut Option<Samples>,
    ) -> Result<Block<'a>, SceneError> {
        let samples = memory.get_or_insert_with(|| self.layout(level).element.filled(0, 0.0));
        self.source
            .read_region(level, region, samples, &mut ChunkBuffer::default())
            .map_err(|error| error.of_scene(self.source.identity().name, region))?;
        Ok(Block { samples, of: region })
    }

    fn bytes(&self) -> usize {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Budget, CachedSource, ChunkFault};
    use super::*;
    use crate::LengthUnit;
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
        let chunked = ChunkedVolume::new(Arc::clone(&pieces), vec![volume.statistics()]).unwrap();
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
        assert!(ChunkedVolume::new(Arc::clone(&source), Vec::new()).is_err());
        let chunked = ChunkedVolume::new(source, vec![volume.statistics()]).unwrap();
        let region = VoxelBox {
            first: [4, 0, 0],
            size: [1; 3],
        };
        let error = chunked.read(0, region, &mut None).unwrap_err().to_string();
        let expected = "memory: level 0, samples from [4, 0, 0]: level 0, chunk 1,0,0, key a/b from byte 9, codec none: gone";
        assert_eq!(error, expected);
    }
}
