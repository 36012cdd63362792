//! Overviews of levels that are too large to be read whole: every n-th sample along each axis.

use super::{ChunkBuffer, ChunkSource, ChunkedVolume};
use crate::{Grid, SampleSource, Samples, SceneError, Volume, VoxelBox};

use glam::{DAffine3, DVec3};

/// Every n-th sample of a level, from about the middle of each n on.
struct Thinning {
    step: usize,
    dims: [usize; 3],
}

impl Thinning {
    /// The smallest step that leaves at most so many samples.
    fn new(own: [usize; 3], most: usize) -> Self {
        let dims = |step: usize| own.map(|n| n.div_ceil(step));
        let fits = |step: &usize| dims(*step).iter().product::<usize>() <= most.max(1);
        let step = (1..).find(fits).unwrap_or(1);
        Self {
            step,
            dims: dims(step),
        }
    }

    /// The kept sample of each n, of those that an axis of so many samples has.
    fn place(&self, index: usize, own: usize) -> usize {
        (index * self.step + self.step / 2).min(own - 1)
    }

    /// Which samples are kept along an axis within a range of the level's own.
    fn kept(&self, range: std::ops::Range<usize>, own: usize) -> impl Iterator<Item = (usize, usize)> {
        let first = (range.start / self.step).saturating_sub(1);
        (first..own.div_ceil(self.step))
            .map(move |index| (index, self.place(index, own)))
            .skip_while(move |(_, place)| *place < range.start)
            .take_while(move |(_, place)| *place < range.end)
    }

    /// The thinned grid, in the same box.
    fn grid(&self, own: &Grid) -> Result<Grid, SceneError> {
        let ratio = DVec3::from_array(std::array::from_fn(|a| {
            own.dims()[a] as f64 / self.dims[a] as f64
        }));
        let own_from_thin =
            DAffine3::from_translation(0.5 * (ratio - DVec3::ONE)) * DAffine3::from_scale(ratio);
        Grid::from_affine(self.dims, own.world_from_voxel() * own_from_thin)
    }
}

impl ChunkedVolume {
    /// At most so many samples of a level, evenly spread over it.
    pub(super) fn thinned(&self, level: usize, most: usize) -> Result<Volume, SceneError> {
        let (layout, grid) = (self.layout(level), self.grid(level));
        let own = grid.dims();
        let thinning = Thinning::new(own, most);
        let mut kept = layout.element.filled(thinning.dims.iter().product(), layout.fill);
        let mut memory = layout.element.filled(0, 0.0);
        let mut buffer = ChunkBuffer::default();
        for region in self.regions_of(level, &thinning) {
            self.source()
                .read_region(level, region, &mut memory, &mut buffer)
                .map_err(|error| error.of_scene(self.source().identity().name, region))?;
            thinning.keep(own, (&memory, region), &mut kept);
        }
        Volume::new(thinning.grid(grid)?, kept, layout.rescale, self.unit())
    }

    /// Regions that hold all kept samples: rows, where those cost no more than their samples, else chunks.
    fn regions_of(&self, level: usize, thinning: &Thinning) -> Vec<VoxelBox> {
        let layout = self.layout(level);
        let [nx, ny, nz] = layout.grid.dims();
        if !self.source().reads_regions() {
            let all = layout.chunks_of(VoxelBox::whole(&layout.grid));
            return all.map(|chunk| layout.region(chunk)).collect();
        }
        let rows = |z: usize| {
            let row = move |(_, y)| VoxelBox {
                first: [0, y, z],
                size: [nx, 1, 1],
            };
            thinning.kept(0..ny, ny).map(row)
        };
        thinning.kept(0..nz, nz).flat_map(|(_, z)| rows(z)).collect()
    }
}

impl Thinning {
    /// Copies what is kept of a region.
    fn keep(&self, own: [usize; 3], (samples, region): (&Samples, VoxelBox), into: &mut Samples) {
        macro_rules! pairs {
            ($($variant:ident)*) => {
                match (samples, into) {
                    $((Samples::$variant(from), Samples::$variant(into)) => self.copy(own, (from, region), into.to_mut()),)*
                    _ => {}
                }
            };
        }
        pairs!(U8 I8 U16 I16 U32 I32 F32 F64);
    }

    fn copy<T: Copy>(&self, own: [usize; 3], (from, region): (&[T], VoxelBox), into: &mut [T]) {
        let along = |axis: usize| {
            self.kept(
                region.first[axis]..region.first[axis] + region.size[axis],
                own[axis],
            )
        };
        for (to_z, z) in along(2) {
            for (to_y, y) in along(1) {
                let row = region.row(from, [y, z]);
                let start = (to_z * self.dims[1] + to_y) * self.dims[0];
                for (to_x, x) in along(0) {
                    into[start + to_x] = row[x - region.first[0]];
                }
            }
        }
    }
}
