//! Packed bricks: needed bricks as they are kept, for devices that decode themselves.

use super::{FieldStore, PACKED};
use crate::brick::BRICK;
use crate::visibility::VisibleLevels;

impl FieldStore {
    /// Needed voxels of a needed brick: a bit each, x fastest, by planes. Of volumes in chunks all, since nothing is known of
    /// them before the brick is solved; which ones they are depends on [`Self::levels`].
    pub fn needed_in(&self, index: usize) -> [u64; BRICK] {
        if self.lazy.is_some() {
            return [u64::MAX; BRICK];
        }
        let [chunk, i] = self.needed[index].map(|n| n as usize);
        self.chunks[chunk].needed[i].mask
    }

    /// A needed brick as it is kept, for devices that decode themselves: the bits of offset (less the background) and scale, 1
    /// where samples are missing and 0, an unused word; a bit per needed voxel, 64 for each plane, in words of 32; values of
    /// 16 bits in pairs, the first in the lower bits, each `offset + scale * value`, or `u16::MAX` where the sample is
    /// missing. Of volumes in chunks the brick is solved first; one without needed voxels is all zeros.
    pub fn pack(&self, index: usize, out: &mut [u32; PACKED]) {
        if self.lazy.is_some() {
            return self.solve_brick(index, |solved| match solved {
                Some((stored, mask)) => stored.pack(mask, self.background, out),
                None => out.fill(0),
            });
        }
        let [chunk, i] = self.needed[index].map(|n| n as usize);
        let chunk = &self.chunks[chunk];
        let brick = &chunk.needed[i];
        chunk.stored(brick.place).pack(&brick.mask, self.background, out);
    }

    /// Visible levels for which the voxels are needed, if they were set.
    pub fn levels(&self) -> Option<&VisibleLevels> {
        self.levels.as_ref()
    }
}
