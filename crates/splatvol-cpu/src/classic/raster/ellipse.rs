//! `ellipse-1d`: ellipses by two additions per pixel, looked up in a table with even steps of the squared distance.
//!
//! `r^2 = a dx^2 + b dy^2 + c dx dy` and `r^2(x + 1, y) = r^2(x, y) + 2 a dx + a + c dy`, whose last terms grow by
//! `2 a` per pixel (huang2000 eq. 3 and 4). Sums are in floating point as in the paper, but in 64 bits: with 32
//! bits the drift along a row would show at tile edges. Each row starts afresh.

use splatvol_core::radial::Entry;

use super::tables::{Block, Lookup};

/// Fills a block. The conic xx, xy, yy leads to entries.
pub(super) fn fill<E: Entry>(
    lookup: &Lookup<'_, E>,
    [xx, xy, yy]: [f32; 3],
    centre: [f32; 2],
    block: &Block,
    weights: &mut [f32],
) {
    let [a, b, c] = [xx, yy, 2.0 * xy].map(f64::from);
    let [left, top] = block.offset(centre).map(f64::from);
    for (y, row) in weights.chunks_exact_mut(block.size[0]).enumerate() {
        let dy = top + y as f64;
        let mut squared = (a * left + c * dy) * left + b * dy * dy;
        let mut step = 2.0 * a * left + a + c * dy;
        for weight in row {
            *weight = lookup.nearest(squared as f32);
            squared += step;
            step += 2.0 * a;
        }
    }
}
