//! Packed bricks: needed bricks as they are kept, for devices that decode themselves.

use super::{FieldStore, PACKED};
use crate::brick::BRICK;

impl FieldStore {
    /// Needed voxels of a needed brick: a bit each, x fastest, by planes. Volumes in chunks have none.
    pub fn needed_in(&self, index: usize) -> [u64; BRICK] {
        let [chunk, i] = self.needed[index].map(|n| n as usize);
        self.chunks[chunk].needed[i].mask
    }

    /// A needed brick as it is kept, for devices that decode themselves: the bits of offset (less the background) and scale, 1
    /// where samples are missing and 0, an unused word; a bit per needed voxel, 64 for each plane, in words of 32; values of
    /// 16 bits in pairs, the first in the lower bits, each `offset + scale * value`, or `u16::MAX` where the sample is
    /// missing. Volumes in chunks have none.
    pub fn pack(&self, index: usize, out: &mut [u32; PACKED]) {
        let [chunk, i] = self.needed[index].map(|n| n as usize);
        let chunk = &self.chunks[chunk];
        let brick = &chunk.needed[i];
        chunk.stored(brick.place).pack(&brick.mask, self.background, out);
    }
}
