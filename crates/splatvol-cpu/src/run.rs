//! Execution resources of a frame.

use splatvol_core::engine::Task;

use crate::instructions::InstructionSet;
use crate::pool::Pool;
use crate::sheets::blocks::Block;

/// Thread pool, instruction set and tile size of a frame.
#[derive(Clone, Copy)]
pub(crate) struct Run<'a> {
    pub pool: &'a Pool,
    /// The loops over SIMD vectors, for this processor.
    pub instructions: InstructionSet,
    pub tile_edge: Option<usize>,
    pub task: Task<'a>,
    /// The tiles to draw, where a picture is drawn block by block.
    pub block: Option<Block>,
    pub pass: Pass,
}

/// Place of a pass among those that show a volume's levels behind each other, each on the canvases of those before.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pass {
    /// Whether nothing lies in front.
    pub is_first: bool,
    /// Whether nothing lies behind, so that pixels are final.
    pub is_last: bool,
}

impl Pass {
    /// The only pass of a picture.
    pub(crate) const WHOLE: Self = Self {
        is_first: true,
        is_last: true,
    };
}
