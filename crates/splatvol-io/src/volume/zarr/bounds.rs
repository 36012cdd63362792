//! Index of smallest and largest samples: an array `splatvol/bounds/LEVEL` beside the levels, of shape
//! (2, blocks along z, y, x). It holds the smallest and the largest sample of every block and of the samples around it,
//! one in each direction; NaN where samples are missing.

use glam::DVec3;
use splatvol_scene::volume::widen;
use splatvol_scene::{
    ChunkBuffer, ChunkContent, Grid, LevelLayout, MinMaxIndex, Rescale, VoxelBox, with_samples,
};

use super::array::Array;
use super::folder::Folder;
use super::level::{ArrayLevel, Part};
use super::own;
use crate::volume::ReadOptions;

/// Reads the index of a level, `None` if there is none that fits. An index that cannot be read is as good as none.
pub(super) fn read(
    folder: &Folder,
    level: usize,
    of: &ArrayLevel,
    options: &ReadOptions,
) -> Option<MinMaxIndex> {
    let folder = folder.join(own::BOUNDS).join(&level.to_string());
    let array = Array::open(&folder).ok()??;
    let attributes = match array.version {
        2 => folder.json(".zattrs").ok()?,
        _ => folder
            .json("zarr.json")
            .ok()?
            .and_then(|value| value.get("attributes").cloned()),
    };
    let [z, y, x] = own::block_of_bounds(attributes.as_ref())?;
    let (dims, block) = (of.layout.grid.dims(), [x, y, z]);
    let counts: [usize; 3] = std::array::from_fn(|axis| dims[axis].div_ceil(block[axis]));
    if array.shape != [2, counts[2], counts[1], counts[0]] {
        return None;
    }
    let layout = LevelLayout {
        grid: Grid::centred(counts, DVec3::ONE).ok()?,
        chunk: [1; 3],
        element: array.element(),
        rescale: Rescale::default(),
        fill: 0.0,
    };
    let [smallest, largest] = [0, 1].map(|end| {
        let part = Part {
            place: vec![end, 0, 0, 0],
            spatial: vec![1, 2, 3],
        };
        ArrayLevel::new(array.clone(), part, layout.clone(), options.allow_outside)
    });
    let mut index = MinMaxIndex::new(dims, block, 1);
    let layout = &smallest.layout;
    // Stores that answer late are asked for all at once.
    for end in [&smallest, &largest] {
        end.will_need(layout.chunks_of(VoxelBox::whole(&layout.grid)));
    }
    for piece in layout.chunks_of(VoxelBox::whole(&layout.grid)) {
        let region = layout.region(piece);
        let [nx, ny, _] = region.size;
        let (low, high) = (values(&smallest, piece)?, values(&largest, piece)?);
        for (at, ends) in low.into_iter().zip(high).enumerate() {
            let within = [at % nx, at / nx % ny, at / (nx * ny)];
            let block = std::array::from_fn(|axis| region.first[axis] + within[axis]);
            index.join(block, ends.into());
        }
    }
    Some(index)
}

/// The values of a piece of the index, x fastest.
fn values(of: &ArrayLevel, piece: [usize; 3]) -> Option<Vec<f64>> {
    let mut buffer = ChunkBuffer::default();
    let content = of.read(piece, &mut buffer).ok()?;
    let samples = || with_samples!(&buffer.samples, data => data.iter().map(|&value| widen(value)).collect());
    (content == ChunkContent::Samples).then(samples)
}
