//! Occlusion: finished pixels, and the splats hidden by them.

use splatvol_scene::Occlusion;

/// Opaque pixels of a tile.
#[derive(Debug, Default)]
pub(crate) struct Finished {
    kind: Occlusion,
    pixels: Vec<bool>,
    width: usize,
    height: usize,
    left: usize,
    /// Unfinished pixels per block.
    blocks: Vec<u32>,
    /// `sums[y][x]`: finished pixels above and left of x, y; one column and row more than pixels.
    sums: Vec<u32>,
    /// First row that changed since the sums were made.
    stale: usize,
}

const EDGE: usize = 8;

impl Finished {
    /// No pixel is finished.
    pub(crate) fn reset(&mut self, kind: Occlusion, width: usize, height: usize) {
        (self.kind, self.width, self.height) = (kind, width, height);
        self.left = width * height;
        self.pixels.clear();
        self.pixels.resize(width * height, false);
        self.blocks.clear();
        for y in (0..height).step_by(EDGE) {
            for x in (0..width).step_by(EDGE) {
                self.blocks
                    .push(((width - x).min(EDGE) * (height - y).min(EDGE)) as u32);
            }
        }
        self.sums.clear();
        if kind == Occlusion::Sat {
            self.sums.resize((width + 1) * (height + 1), 0);
        }
        self.stale = height;
    }

    /// Whether a pixel is finished.
    #[inline(always)]
    pub(crate) fn is(&self, x: usize, y: usize) -> bool {
        self.pixels[y * self.width + x]
    }

    /// Finishes a pixel.
    #[inline(always)]
    pub(crate) fn finish(&mut self, x: usize, y: usize) {
        let pixel = &mut self.pixels[y * self.width + x];
        if self.kind != Occlusion::None && !*pixel {
            *pixel = true;
            self.left -= 1;
            self.blocks[y / EDGE * self.width.div_ceil(EDGE) + x / EDGE] -= 1;
            self.stale = self.stale.min(y);
        }
    }

    /// Whether all pixels are finished.
    pub(crate) fn all(&self) -> bool {
        self.left == 0
    }

    /// Updates the summed-area table; does nothing where it is not used. Rows above the first changed one keep
    /// their sums.
    pub(crate) fn refresh(&mut self) {
        if self.kind != Occlusion::Sat || self.stale >= self.height {
            return;
        }
        let pitch = self.width + 1;
        for y in self.stale..self.height {
            let (above, below) = self.sums.split_at_mut((y + 1) * pitch);
            let above = &above[y * pitch..];
            let mut sum = 0;
            let row = &self.pixels[y * self.width..(y + 1) * self.width];
            for (x, &finished) in row.iter().enumerate() {
                sum += u32::from(finished);
                below[x + 1] = above[x + 1] + sum;
            }
        }
        self.stale = self.height;
    }

    /// Whether all pixels from x0, y0 to x1, y1 (excluded) are known to be finished.
    #[inline(always)]
    pub(crate) fn hide(&self, [x0, y0, x1, y1]: [usize; 4]) -> bool {
        match self.kind {
            Occlusion::None => false,
            Occlusion::Auto => self.blocks_hide([x0, y0, x1, y1]),
            Occlusion::Sat => {
                let sum = |x: usize, y: usize| self.sums[y * (self.width + 1) + x];
                let count = sum(x1, y1) + sum(x0, y0) - sum(x0, y1) - sum(x1, y0);
                count as usize == (x1 - x0) * (y1 - y0)
            }
        }
    }

    #[inline(always)]
    fn blocks_hide(&self, [x0, y0, x1, y1]: [usize; 4]) -> bool {
        let columns = self.width.div_ceil(EDGE);
        (y0 / EDGE..=(y1 - 1) / EDGE)
            .all(|row| (x0 / EDGE..=(x1 - 1) / EDGE).all(|column| self.blocks[row * columns + column] == 0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_summed_area_table_counts_finished_pixels_once_refreshed() {
        let mut finished = Finished::default();
        finished.reset(Occlusion::Sat, 13, 9);
        for y in 3..7 {
            for x in 2..11 {
                finished.finish(x, y);
            }
        }
        assert!(!finished.hide([2, 3, 11, 7]), "not refreshed yet");
        finished.refresh();
        assert!(finished.hide([2, 3, 11, 7]));
        assert!(finished.hide([4, 5, 5, 6]));
        assert!(!finished.hide([2, 3, 12, 7]));
        assert!(!finished.hide([2, 2, 11, 7]));
        finished.finish(11, 4);
        finished.refresh();
        assert!(finished.hide([2, 4, 12, 5]));
        assert!(!finished.all());
    }

    #[test]
    fn blocks_hide_what_lies_in_finished_ones_only() {
        let mut finished = Finished::default();
        finished.reset(Occlusion::Auto, 20, 9);
        for y in 0..8 {
            for x in 8..16 {
                finished.finish(x, y);
            }
        }
        assert!(finished.hide([9, 1, 12, 3]));
        assert!(!finished.hide([7, 1, 12, 3]));
        assert!(!finished.hide([9, 1, 12, 9]));
    }

    #[test]
    fn without_occlusion_no_pixel_is_ever_finished() {
        let mut finished = Finished::default();
        finished.reset(Occlusion::None, 1, 1);
        finished.finish(0, 0);
        assert!(!finished.is(0, 0) && !finished.all() && !finished.hide([0, 0, 1, 1]));
    }
}
