//! Division of the work: levels, their chunks and shards, and tasks, each of which writes whole files.
//!
//! A task of level k is a box of 16 x 2 x 2 chunks. It reads that box and one sample around it, finds the ends of its
//! blocks and makes 8 x 1 x 1 chunks of level k + 1; level 0 is copied on the way. So every file has one writer, each
//! level is read once, and memory depends on the edge of the chunks alone.

use splatvol_scene::{ElementType, VoxelBox};

/// Chunks of a task along x, y, z.
const TASK: [usize; 3] = [16, 2, 2];

/// Smallest edge of a block of the index of smallest and largest samples.
const BLOCK: usize = 16;
/// Blocks that an index has at most, unless a block is a chunk: readers read it whole.
const MOST_BLOCKS: usize = 1 << 21;

/// A level of detail.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct LevelPlan {
    pub(super) dims: [usize; 3],
    pub(super) chunk: [usize; 3],
    /// Chunks of a shard.
    pub(super) shard: [usize; 3],
}

impl LevelPlan {
    fn new(dims: [usize; 3], edge: usize, of_shard: [usize; 3]) -> Self {
        let chunk = dims.map(|dim| dim.min(edge));
        Self {
            dims,
            chunk,
            shard: std::array::from_fn(|axis| of_shard[axis].min(dims[axis].div_ceil(chunk[axis]))),
        }
    }

    /// Samples along x, y, z of the blocks of the level's index: cubes of 16, 32... along the axes where these divide a
    /// chunk, or where there is one chunk alone.
    pub(super) fn block(&self) -> [usize; 3] {
        let edges = std::iter::successors(Some(BLOCK), |edge| edge.checked_mul(2));
        let block = |edge: usize| {
            std::array::from_fn(|axis| {
                let (chunk, dim) = (self.chunk[axis], self.dims[axis]);
                let divides = chunk.is_multiple_of(edge) || (chunk >= dim && edge <= dim.max(BLOCK));
                if divides { edge } else { chunk }
            })
        };
        let longest = self.chunk.into_iter().fold(BLOCK, usize::max);
        let mut blocks = edges.take_while(|edge| *edge <= longest).map(block);
        let few = |block: &[usize; 3]| self.counts_of(*block).into_iter().product::<usize>() <= MOST_BLOCKS;
        blocks.find(few).unwrap_or(self.chunk)
    }

    fn counts_of(&self, block: [usize; 3]) -> [usize; 3] {
        std::array::from_fn(|axis| self.dims[axis].div_ceil(block[axis]))
    }

    /// Blocks of the index along x, y, z.
    pub(super) fn block_counts(&self) -> [usize; 3] {
        self.counts_of(self.block())
    }

    /// The blocks of the index within a box that begins and ends with chunks, x fastest.
    pub(super) fn blocks_in(&self, region: VoxelBox) -> impl Iterator<Item = [usize; 3]> + use<> {
        boxes_in(self.block(), region)
    }

    pub(super) fn samples(&self) -> u64 {
        self.dims.iter().map(|&dim| dim as u64).product()
    }

    /// The samples of a chunk and, where it sticks out, places without samples.
    pub(super) fn whole_chunk(&self, chunk: [usize; 3]) -> VoxelBox {
        VoxelBox {
            first: std::array::from_fn(|axis| chunk[axis] * self.chunk[axis]),
            size: self.chunk,
        }
    }
}

/// All levels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Plan {
    pub(super) levels: Vec<LevelPlan>,
    edge: usize,
}

impl Plan {
    /// `levels`: as many as are asked for; if none are, until the coarsest is one chunk.
    pub(super) fn new(dims: [usize; 3], edge: usize, levels: Option<usize>) -> Self {
        let halves = std::iter::successors(Some(dims), |dims| Some(dims.map(|dim| dim.div_ceil(2))));
        let enough = |dims: &[usize; 3]| dims.iter().all(|&dim| dim <= edge);
        let count = levels.unwrap_or_else(|| halves.clone().take_while(|dims| !enough(dims)).count() + 1);
        let plan =
            |(level, dims)| LevelPlan::new(dims, edge, if level == 0 { TASK } else { [TASK[0] / 2, 1, 1] });
        Self {
            levels: halves.take(count).enumerate().map(plan).collect(),
            edge,
        }
    }

    /// Edges of the box of a task, samples.
    fn task_size(&self) -> [usize; 3] {
        TASK.map(|chunks| chunks * self.edge)
    }

    /// Tasks of a level along x, y, z.
    fn task_counts(&self, level: usize) -> [usize; 3] {
        let (dims, size) = (self.levels[level].dims, self.task_size());
        std::array::from_fn(|axis| dims[axis].div_ceil(size[axis]))
    }

    /// Number of tasks of a level.
    pub(super) fn tasks(&self, level: usize) -> usize {
        self.task_counts(level).iter().product()
    }

    /// A task of a level, in the order in which they share most.
    pub(super) fn task(&self, level: usize, index: usize) -> Task {
        let [nx, ny, _] = self.task_counts(level);
        let at = [index % nx, index / nx % ny, index / (nx * ny)];
        let (dims, size) = (self.levels[level].dims, self.task_size());
        let first: [usize; 3] = std::array::from_fn(|axis| at[axis] * size[axis]);
        let end: [usize; 3] = std::array::from_fn(|axis| dims[axis].min(first[axis] + size[axis]));
        let before = first.map(|first| first.saturating_sub(1));
        let own = VoxelBox {
            first,
            size: std::array::from_fn(|axis| end[axis] - first[axis]),
        };
        let next = self.levels.get(level + 1).map(|next| {
            let first: [usize; 3] = std::array::from_fn(|axis| at[axis] * size[axis] / 2);
            let end: [usize; 3] =
                std::array::from_fn(|axis| next.dims[axis].min(first[axis] + size[axis] / 2));
            VoxelBox {
                first,
                size: std::array::from_fn(|axis| end[axis] - first[axis]),
            }
        });
        Task {
            read: VoxelBox {
                first: before,
                size: std::array::from_fn(|axis| dims[axis].min(end[axis] + 1) - before[axis]),
            },
            own,
            next,
        }
    }

    /// Bytes that one thread takes for its tasks, with chunks of the source of `source_chunk` bytes.
    pub(super) fn bytes_of_thread(&self, element: ElementType, source_chunk: u64) -> u64 {
        let finest = &self.levels[0];
        let box_of = |extra: usize, divisor: usize| -> u64 {
            let edges = (0..3)
                .map(|axis| (self.task_size()[axis] / divisor + extra).min(finest.dims[axis] + extra) as u64);
            edges.product::<u64>() * element.size() as u64
        };
        let chunk: u64 =
            finest.chunk.iter().map(|&edge| edge as u64).product::<u64>() * element.size() as u64;
        // A task, its means, a chunk before and after compression, one of the source in all its forms, buffers of files.
        box_of(2, 1) + box_of(0, 2) + 5 * chunk / 2 + 3 * source_chunk + (2 << 20)
    }
}

/// A part of the work on a level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Task {
    /// The samples that it is about.
    pub(super) own: VoxelBox,
    /// The same and those around them.
    pub(super) read: VoxelBox,
    /// The samples of the next level that it makes.
    pub(super) next: Option<VoxelBox>,
}

/// The chunks of a level within a box that begins and ends with chunks, x fastest.
pub(super) fn chunks_in(level: &LevelPlan, region: VoxelBox) -> impl Iterator<Item = [usize; 3]> + use<> {
    boxes_in(level.chunk, region)
}

/// The boxes of so many samples within a region that begins and ends with boxes, x fastest.
fn boxes_in(size: [usize; 3], region: VoxelBox) -> impl Iterator<Item = [usize; 3]> + use<> {
    let first: [usize; 3] = std::array::from_fn(|axis| region.first[axis] / size[axis]);
    let count: [usize; 3] = std::array::from_fn(|axis| region.size[axis].div_ceil(size[axis]));
    (0..count.iter().product()).map(move |index| {
        let at = [
            index % count[0],
            index / count[0] % count[1],
            index / (count[0] * count[1]),
        ];
        std::array::from_fn(|axis| first[axis] + at[axis])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tasks_cover_every_level_once_and_make_the_next() {
        for (dims, edge) in [
            ([70, 33, 9], 8),
            ([1, 40, 17], 4),
            ([5, 5, 5], 64),
            ([129, 2, 1], 3),
        ] {
            let plan = Plan::new(dims, edge, None);
            assert!(plan.levels.last().unwrap().dims.iter().all(|&dim| dim <= edge));
            for (level, of) in plan.levels.iter().enumerate() {
                let tasks: Vec<Task> = (0..plan.tasks(level)).map(|i| plan.task(level, i)).collect();
                let samples: u64 = tasks.iter().map(|task| task.own.len() as u64).sum();
                assert_eq!(samples, of.samples());
                let mut chunks: Vec<_> = tasks.iter().flat_map(|task| chunks_in(of, task.own)).collect();
                chunks.sort_unstable();
                chunks.dedup();
                let counts = (0..3).map(|axis| of.dims[axis].div_ceil(of.chunk[axis]));
                assert_eq!(chunks.len(), counts.product::<usize>());
                let blocks = tasks.iter().flat_map(|task| of.blocks_in(task.own));
                let found: std::collections::BTreeSet<_> = blocks.collect();
                assert_eq!(found.len(), of.block_counts().iter().product::<usize>());
                if let Some(next) = plan.levels.get(level + 1) {
                    let made: u64 = tasks.iter().map(|task| task.next.unwrap().len() as u64).sum();
                    assert_eq!(made, next.samples(), "{dims:?} {level}");
                }
            }
        }
    }

    #[test]
    fn blocks_of_huge_levels_are_larger_and_divide_chunks() {
        let block = |dims, edge| LevelPlan::new(dims, edge, [1; 3]).block();
        assert_eq!(block([2048; 3], 64), [16; 3]);
        assert_eq!(block([2049, 2048, 2048], 64), [32; 3]);
        assert_eq!(block([10_240, 7680, 1356], 64), [64; 3]);
        assert_eq!(block([100_000; 3], 64), [64; 3]);
        assert_eq!(block([100, 400, 9], 40), [40, 40, 16]);
        assert_eq!(block([30, 40, 50], 64), [16; 3]);
    }
}
