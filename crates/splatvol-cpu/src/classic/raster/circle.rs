//! `square-1d`: circles by two additions per pixel, looked up in a table with even steps of the squared distance.
//!
//! `r^2(x + 1, y) = r^2(x, y) + 2 (x - x_o) + 1`, whose last two terms grow by 2 per pixel (huang2000 eq. 2). As in
//! the scan conversion of circles, the sums are in fixed point, in units of table entries with 32 bits of fraction,
//! so that they do not drift.

use splatvol_core::radial::Entry;

use super::tables::{Block, Lookup};

const FRACTION: u32 = 32;
const ONE: f64 = (1_u64 << FRACTION) as f64;

/// Fills a block. `scale`: entries per squared pixel.
pub(super) fn fill<E: Entry>(
    lookup: &Lookup<'_, E>,
    scale: f32,
    centre: [f32; 2],
    block: &Block,
    weights: &mut [f32],
) {
    let scale = f64::from(scale);
    let [left, top] = block.offset(centre).map(f64::from);
    let fixed = |value: f64| (value * ONE) as i64;
    let first_step = fixed(scale * (2.0 * left + 1.0));
    let step_of_step = fixed(2.0 * scale);
    for (y, row) in weights.chunks_exact_mut(block.size[0]).enumerate() {
        let dy = top + y as f64;
        let mut squared = fixed(scale * (left * left + dy * dy) + 0.5);
        let mut step = first_step;
        for weight in row {
            *weight = lookup.entry((squared >> FRACTION) as usize);
            squared = squared.wrapping_add(step);
            step = step.wrapping_add(step_of_step);
        }
    }
}
