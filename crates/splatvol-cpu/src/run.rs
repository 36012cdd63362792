//! Execution resources of a frame.

use fearless_simd::Level;
use splatvol_core::engine::Task;

use crate::pool::Pool;
use crate::sheets::blocks::Block;

/// Thread pool, instruction set and tile size of a frame.
#[derive(Clone, Copy)]
pub(crate) struct Run<'a> {
    pub pool: &'a Pool,
    pub level: Level,
    pub tile_edge: Option<usize>,
    pub task: Task<'a>,
    /// The tiles to draw, where a picture is drawn block by block.
    pub block: Option<Block>,
}
