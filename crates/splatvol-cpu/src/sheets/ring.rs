//! The ring of open sheets of a tile: four sheets interleaved in every pixel.
//!
//! A voxel is splatted once into all the sheets that it reaches. A block holds 2 x 2 pixels by four sheets in one
//! 512-bit vector. So the rows and columns of a footprint at any position fill whole aligned vectors. The store
//! traffic, which bounds splatting, is a quarter of that of a sheet-by-sheet layout. Where a kernel reaches more
//! than four sheets, the ring has several groups of four.

/// Sheets that a block interleaves.
pub(crate) const LANES: usize = 4;
/// Pixels along a block's edge.
pub(crate) const BLOCK_EDGE: usize = 2;

/// 2 x 2 pixels of four sheets: `[y][x][sheet]`.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Block(pub [f32; LANES * BLOCK_EDGE * BLOCK_EDGE]);

impl Block {
    pub(crate) const ZERO: Self = Self([0.0; 16]);
}

/// Written blocks x0..x1, y0..y1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Area {
    pub x0: usize,
    pub y0: usize,
    pub x1: usize,
    pub y1: usize,
}

impl Area {
    pub(crate) const EMPTY: Self = Self {
        x0: usize::MAX,
        y0: usize::MAX,
        x1: 0,
        y1: 0,
    };

    pub(crate) fn is_empty(&self) -> bool {
        self.x0 >= self.x1
    }

    pub(crate) fn join(self, other: Self) -> Self {
        Self {
            x0: self.x0.min(other.x0),
            y0: self.y0.min(other.y0),
            x1: self.x1.max(other.x1),
            y1: self.y1.max(other.y1),
        }
    }
}

/// Blocks from one row to the next: the widest tile with footprints on both sides; odd, so that rows do not share
/// cache sets.
pub(crate) const PITCH: usize = 101;

/// A row of blocks.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row(pub [Block; PITCH]);

/// The open sheets of a tile.
#[derive(Debug, Default)]
pub(crate) struct SheetRing {
    /// Group by group, top to bottom.
    pub rows: Vec<Row>,
    /// Rows of a group.
    pub height: usize,
    /// Area written to each sheet since it was last taken.
    pub touched: Vec<Area>,
    /// Index of the sheet up to which sums over sheets are complete, where there are such sums.
    pub last_sheet: f32,
}

impl SheetRing {
    /// Resets to `height` rows of pixels and `groups` of four sheets, all zero.
    pub(crate) fn reset(&mut self, height: usize, groups: usize) {
        let height = height.div_ceil(BLOCK_EDGE);
        let same = self.rows.len() == height * groups && self.height == height;
        if same && self.touched.iter().all(Area::is_empty) {
            return;
        }
        self.height = height;
        self.rows.clear();
        self.rows.resize(height * groups, Row([Block::ZERO; PITCH]));
        self.touched.clear();
        self.touched.resize(groups * LANES, Area::EMPTY);
    }

    /// Rows of every `stride`-th group from `first` on.
    pub(crate) fn groups<const N: usize>(&mut self, first: usize, stride: usize) -> [&mut [Row]; N] {
        let mut groups = self
            .rows
            .chunks_exact_mut(self.height.max(1))
            .skip(first)
            .step_by(stride.max(1));
        std::array::from_fn(|_| groups.next().unwrap_or_default())
    }

    /// Rows of a group.
    pub(crate) fn group(&mut self, group: usize) -> &mut [Row] {
        &mut self.rows[group * self.height..][..self.height]
    }
}
