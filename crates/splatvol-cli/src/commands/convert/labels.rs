//! Whether the values of a volume are labels.

use splatvol::transfer_function::ValueKind;
use splatvol::{ChunkBuffer, ChunkSource, LengthUnit, TransferFunction, Volume, VoxelBox};
use splatvol_io::Opened;

/// Slabs that are looked at, evenly spread along z.
const SLABS: usize = 8;
/// Most samples of a slab along x, y, z.
const SLAB: [usize; 3] = [256, 256, 4];
/// Most samples of a volume that is looked at as a whole: one slab of everything costs no more than the slabs.
const WHOLE: usize = SLABS * SLAB[0] * SLAB[1] * SLAB[2];

/// Whether most slabs of the finest level that are not all of one value look like labels, as an automatic look takes them.
/// Slabs that cannot be read tell nothing: whoever reads all will say why.
pub(super) fn are_in(volume: &Opened) -> bool {
    let source = &*volume.source;
    let dims = source.levels()[0].grid.dims();
    let (mut labels, mut others) = (0, 0);
    for region in slabs(dims) {
        match read(source, region).map(|slab| TransferFunction::automatic(&slab, None).1.kind) {
            Some(ValueKind::Labels) => labels += 1,
            Some(ValueKind::Constant) | None => {}
            Some(_) => others += 1,
        }
    }
    labels > others
}

/// Slabs in the middle of x and y; all of a small volume.
fn slabs(dims: [usize; 3]) -> Vec<VoxelBox> {
    if dims.iter().product::<usize>() <= WHOLE {
        return vec![VoxelBox {
            first: [0; 3],
            size: dims,
        }];
    }
    let size: [usize; 3] = std::array::from_fn(|axis| dims[axis].min(SLAB[axis]));
    let at = |number: usize| {
        let [x, y] = [0, 1].map(|axis| (dims[axis] - size[axis]) / 2);
        let z = (dims[2] - size[2]) * (2 * number + 1) / (2 * SLABS);
        VoxelBox {
            first: [x, y, z],
            size,
        }
    };
    let mut all: Vec<VoxelBox> = (0..SLABS).map(at).collect();
    all.dedup();
    all
}

fn read(source: &dyn ChunkSource, region: VoxelBox) -> Option<Volume> {
    let layout = &source.levels()[0];
    let mut samples = layout.element.filled(0, 0.0);
    source
        .read_region(0, region, &mut samples, &mut ChunkBuffer::default())
        .ok()?;
    let grid = splatvol::Grid::centred(region.size, glam::DVec3::ONE).ok()?;
    Volume::new(grid, samples, layout.rescale, LengthUnit::Unknown).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slabs_lie_within_the_volume() {
        assert_eq!(slabs([10, 20, 30])[0].size, [10, 20, 30]);
        for dims in [[1000, 300, 2], [5000, 5000, 1], [100, 4000, 700]] {
            let slabs = slabs(dims);
            assert!(!slabs.is_empty() && slabs.len() <= SLABS);
            for VoxelBox { first, size } in slabs {
                assert!((0..3).all(|axis| size[axis] > 0 && first[axis] + size[axis] <= dims[axis]));
            }
        }
    }
}
