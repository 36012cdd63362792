//! Execution resources of a frame.

use fearless_simd::Level;
use splatvol_core::engine::Task;

use crate::pool::Pool;

/// Thread pool, instruction set and tile size of a frame.
#[derive(Clone, Copy)]
pub(crate) struct Run<'a> {
    pub pool: &'a Pool,
    pub level: Level,
    pub tile_edge: Option<usize>,
    pub task: Task<'a>,
}
