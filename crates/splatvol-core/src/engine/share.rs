//! Equal shares of a picture, for workers that have no memory in common.
//!
//! A picture is cut into square blocks, which are dealt out in turn along rows, each row starting further on: with two
//! shares a checkerboard. So each share has blocks everywhere, and all have about as much to do.

use splatvol_scene::{Frame, ImageSize, SceneError};

use crate::bin::TileRect;

/// One of several shares of a picture. All shares together are the whole picture, to the bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Share {
    index: usize,
    count: usize,
    /// Edge of a block, pixels.
    edge: usize,
    /// Pixels around each block that are wanted too.
    margin: usize,
}

impl Share {
    /// Share `index` of `count`, in blocks of `edge` x `edge` pixels. Tiles that are no larger than a block, and divide it,
    /// are rendered by one share only.
    ///
    /// # Errors
    /// An index that is not below the count, or blocks without pixels.
    pub fn new(index: usize, count: usize, edge: usize) -> Result<Self, SceneError> {
        if index >= count {
            return Err(SceneError::invalid(
                "share",
                [index, count],
                "its number, from 0, below the number of shares",
            ));
        }
        if edge == 0 {
            return Err(SceneError::invalid("block edge", edge, "at least one pixel"));
        }
        Ok(Self {
            index,
            count,
            edge,
            margin: 0,
        })
    }

    /// The blocks of a picture that belong to this share, row by row.
    pub fn blocks(self, size: ImageSize) -> impl Iterator<Item = TileRect> {
        let [width, height] = <[u32; 2]>::from(size).map(|side| side as usize);
        let (columns, rows) = (width.div_ceil(self.edge), height.div_ceil(self.edge));
        let places = (0..rows).flat_map(move |row| (0..columns).map(move |column| [column, row]));
        let own = places.filter(move |&place| self.owns(place));
        own.map(move |[column, row]| TileRect {
            x0: column * self.edge,
            y0: row * self.edge,
            x1: ((column + 1) * self.edge).min(width),
            y1: ((row + 1) * self.edge).min(height),
        })
    }

    fn owns(self, [column, row]: [usize; 2]) -> bool {
        // An odd step: neighbours above each other are of different shares, unless there is one only.
        (column + row * ((self.count / 2) | 1)) % self.count == self.index
    }

    /// Whether any pixel of a rectangle is wanted.
    pub fn meets(self, rect: &TileRect) -> bool {
        let blocks = |from: usize, to: usize| {
            from.saturating_sub(self.margin) / self.edge..(to + self.margin).div_ceil(self.edge)
        };
        let columns = blocks(rect.x0, rect.x1);
        blocks(rect.y0, rect.y1).any(|row| columns.clone().any(|column| self.owns([column, row])))
    }

    /// The share and the pixels next to it.
    #[must_use]
    pub fn with_neighbors(self) -> Self {
        Self {
            margin: self.margin + 1,
            ..self
        }
    }

    /// The same share of a picture `factor` times as large.
    #[must_use]
    pub fn enlarged(self, factor: usize) -> Self {
        Self {
            edge: self.edge * factor,
            margin: self.margin * factor,
            ..self
        }
    }

    /// Clears a frame, whose first pixel is that one of the picture, except for the share.
    pub fn keep(self, frame: &mut Frame, [x0, y0]: [usize; 2]) {
        let [width, height] = <[u32; 2]>::from(frame.image.size()).map(|side| side as usize);
        for y in 0..height {
            let mut x = 0;
            while x < width {
                let block = [x0 + x, y0 + y].map(|at| at / self.edge);
                let end = ((block[0] + 1) * self.edge - x0).min(width);
                if !self.owns(block) {
                    let pixels = y * width + x..y * width + end;
                    frame.image.pixels[pixels.clone()].fill([0.0; 4]);
                    frame.depth[pixels.clone()].fill(f32::INFINITY);
                    frame.optical_depth[pixels].fill(0.0);
                }
                x = end;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_own_each_block_once_and_meet_what_they_own() {
        let size = ImageSize::new(150, 70).unwrap();
        for count in 1..9 {
            let mut owners = vec![0; 150 * 70];
            for index in 0..count {
                let share = Share::new(index, count, 16).unwrap();
                for block in share.blocks(size) {
                    assert!(share.meets(&block) && block.x1 <= 150 && block.y1 <= 70);
                    for y in block.y0..block.y1 {
                        owners[y * 150 + block.x0..y * 150 + block.x1]
                            .iter_mut()
                            .for_each(|owners| *owners += 1);
                    }
                }
            }
            assert!(owners.iter().all(|&owners| owners == 1), "{count}");
        }
    }

    #[test]
    fn two_shares_are_a_checkerboard_with_a_margin_where_asked() {
        let share = Share::new(0, 2, 10).unwrap();
        let rect = |x0, y0, x1, y1| TileRect { x0, y0, x1, y1 };
        assert!(share.meets(&rect(0, 0, 1, 1)) && share.meets(&rect(10, 10, 20, 20)));
        assert!(!share.meets(&rect(10, 0, 20, 10)) && !share.meets(&rect(0, 10, 10, 20)));
        assert!(share.with_neighbors().meets(&rect(10, 0, 11, 1)));
        assert!(!share.with_neighbors().meets(&rect(12, 3, 18, 9)));
        assert!(share.with_neighbors().enlarged(3).meets(&rect(32, 0, 33, 1)));
    }

    #[test]
    fn shares_that_do_not_exist_are_refused() {
        assert!(
            Share::new(2, 2, 16).is_err() && Share::new(0, 0, 16).is_err() && Share::new(0, 1, 0).is_err()
        );
    }
}
