//! Sub-pixel grid of cells, to whose centres splats are snapped (huang2000 sections 3.2 and 3.3).

/// k cells per pixel and axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct SubpixelGrid {
    pub count: usize,
}

impl SubpixelGrid {
    /// The centre of the cell that a position lies in.
    #[inline(always)]
    pub(super) fn snap(&self, position: f32) -> f32 {
        let count = self.count as f32;
        ((position * count).floor() + 0.5) / count
    }

    /// The pixel of a snapped position, and the cell within it.
    #[inline(always)]
    pub(super) fn pixel_and_cell(&self, position: f32) -> (i64, usize) {
        let pixel = position.floor();
        let cell = ((position - pixel) * self.count as f32) as usize;
        (pixel as i64, cell.min(self.count - 1))
    }

    /// From a cell's centre to the centre of a pixel that lies so many pixels from the cell's.
    #[inline(always)]
    pub(super) fn offset(&self, cell: usize, pixels: i64) -> f32 {
        pixels as f32 + 0.5 - (cell as f32 + 0.5) / self.count as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_move_by_half_a_cell_at_most_and_offsets_are_theirs() {
        for count in [1, 2, 7, 100] {
            let grid = SubpixelGrid { count };
            for i in -500..500 {
                let position = i as f32 * 0.037;
                let snapped = grid.snap(position);
                assert!((snapped - position).abs() <= 0.5 / count as f32 + 1e-5);
                let (pixel, cell) = grid.pixel_and_cell(snapped);
                let found = grid.offset(cell, 12 - pixel);
                assert!((found - (12.5 - snapped)).abs() < 1e-4, "{count} {position}");
            }
        }
    }
}
