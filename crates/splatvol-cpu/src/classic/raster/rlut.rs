//! `rlut`: squared distances as sums from one-dimensional tables, one per sub-pixel position (huang2000 section
//! 3.3).
//!
//! `r^2 = (x - x_o)^2 + (y - y_o)^2`. A centre snapped to a grid of k x k cells needs k tables of squares, the same
//! for x and y. No pixel depends on its neighbour. The paper's tables hold squared distances for one extent, and
//! are rebuilt for each sheet in perspective. Ours hold squared pixels, which serve every extent, and each pixel
//! multiplies: `i = s_x a + s_y b`. This is also right for ellipses along the axes.

use splatvol_core::radial::Entry;
use splatvol_core::splats::Footprint;

use super::snap::SubpixelGrid;
use super::tables::{Block, Lookup};

/// Largest distance in the tables, pixels; farther squares are computed.
const EXTENT: i64 = 128;
const LENGTH: usize = 2 * EXTENT as usize + 1;

/// Tables of squared offsets.
#[derive(Debug)]
pub(super) struct RadiusTables {
    grid: SubpixelGrid,
    /// One table of squares per cell, from `-EXTENT` pixels to `EXTENT`.
    squares: Vec<f32>,
}

impl RadiusTables {
    /// Tables of so many cells per pixel.
    pub(super) fn new(count: usize) -> Self {
        let grid = SubpixelGrid { count };
        let square = |cell, pixels| grid.offset(cell, pixels) * grid.offset(cell, pixels);
        let squares = (0..count)
            .flat_map(|cell| (-EXTENT..=EXTENT).map(move |pixels| (cell, pixels)))
            .map(|(cell, pixels)| square(cell, pixels))
            .collect();
        Self { grid, squares }
    }

    /// Moves a footprint to the nearest cell's centre.
    #[inline]
    pub(super) fn snap(&self, footprint: Footprint) -> Footprint {
        let centre = footprint.centre.map(|position| self.grid.snap(position));
        let [dx, dy] = [0, 1].map(|axis| centre[axis] - footprint.centre[axis]);
        let [x0, y0, x1, y1] = footprint.bounds;
        Footprint {
            centre,
            bounds: [x0 + dx, y0 + dy, x1 + dx, y1 + dy],
            ..footprint
        }
    }

    /// Fills a block. The conic xx, 0, yy leads to entries.
    pub(super) fn fill<E: Entry>(
        &self,
        lookup: &Lookup<'_, E>,
        [xx, _, yy]: [f32; 3],
        centre: [f32; 2],
        block: &Block,
        weights: &mut [f32],
    ) {
        let [(px, cell_x), (py, cell_y)] = centre.map(|position| self.grid.pixel_and_cell(position));
        let [left, top] = [block.first[0] as i64 - px, block.first[1] as i64 - py];
        let columns = self.columns(cell_x, left, block.size[0]);
        for (y, row) in weights.chunks_exact_mut(block.size[0]).enumerate() {
            let base = self.square(cell_y, top + y as i64) * yy;
            match columns {
                Some(squares) => {
                    for (weight, square) in row.iter_mut().zip(squares) {
                        *weight = lookup.nearest(square * xx + base);
                    }
                }
                None => {
                    for (x, weight) in row.iter_mut().enumerate() {
                        *weight = lookup.nearest(self.square(cell_x, left + x as i64) * xx + base);
                    }
                }
            }
        }
    }

    /// Squares of a row of pixels, where the table has them all.
    #[inline(always)]
    fn columns(&self, cell: usize, left: i64, count: usize) -> Option<&[f32]> {
        let table = self.squares.get(cell * LENGTH..(cell + 1) * LENGTH)?;
        let start = usize::try_from(left + EXTENT).ok()?;
        table.get(start..start + count)
    }

    #[inline(always)]
    fn square(&self, cell: usize, pixels: i64) -> f32 {
        match self.columns(cell, pixels, 1) {
            Some(&[square]) => square,
            _ => self.grid.offset(cell, pixels).powi(2),
        }
    }

    /// Memory of the tables.
    #[cfg(test)]
    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.squares.as_slice())
    }
}
