//! What engines render a frame with.

use fearless_simd::Level;
use splatvol_core::bin::TileRect;

use crate::control::Task;
use crate::coverage::Edges;
use crate::pool::Pool;

/// What a frame is rendered with.
#[derive(Clone, Copy)]
pub(crate) struct Run<'a> {
    pub pool: &'a Pool,
    pub level: Level,
    pub tile_edge: Option<usize>,
    pub task: Task<'a>,
    /// Tiles without any of these are left out.
    pub only: Option<&'a Edges>,
}

impl Run<'_> {
    /// Whether a tile's pixels are wanted.
    pub(crate) fn wants(&self, rect: &TileRect) -> bool {
        self.task.wants(rect) && self.only.is_none_or(|edges| edges.meets(rect))
    }
}
