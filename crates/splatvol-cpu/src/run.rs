//! What engines render a frame with.

use fearless_simd::Level;
use splatvol_core::engine::Task;

use crate::pool::Pool;

/// What a frame is rendered with.
#[derive(Clone, Copy)]
pub(crate) struct Run<'a> {
    pub pool: &'a Pool,
    pub level: Level,
    pub tile_edge: Option<usize>,
    pub task: Task<'a>,
}
