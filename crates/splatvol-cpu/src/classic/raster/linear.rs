//! `linear-1d`: a square root per pixel, looked up in a table with even steps of the distance (huang2000 section
//! 3.1.1).

use splatvol_core::radial::Entry;

use super::tables::{Block, Lookup};

/// Fills a block. `conic`: to squared support radii.
pub(super) fn fill<E: Entry>(
    lookup: &Lookup<'_, E>,
    [xx, xy, yy]: [f32; 3],
    centre: [f32; 2],
    block: &Block,
    weights: &mut [f32],
) {
    let last = lookup.last() as f32;
    let [left, top] = block.offset(centre);
    for (y, row) in weights.chunks_exact_mut(block.size[0]).enumerate() {
        let dy = top + y as f32;
        let (cross, constant) = (2.0 * xy * dy, yy * dy * dy);
        for (x, weight) in row.iter_mut().enumerate() {
            let dx = left + x as f32;
            let squared = (xx * dx + cross) * dx + constant;
            *weight = lookup.nearest(squared.max(0.0).sqrt() * last);
        }
    }
}
