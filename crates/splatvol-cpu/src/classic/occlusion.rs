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
    /// Pixels around which a box of the size `window` is finished.
    windows: Vec<bool>,
    window: [usize; 2],
    /// Largest size of a splat so far: the next window.
    largest: [usize; 2],
    /// First row that changed since the sums or windows were made.
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
        self.windows.clear();
        if kind == Occlusion::Box {
            self.windows.resize(width * height, false);
        }
        (self.window, self.largest) = ([0; 2], [0; 2]);
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

    /// Notes the size of a splat, pixels.
    #[inline(always)]
    pub(crate) fn note(&mut self, [width, height]: [usize; 2]) {
        self.largest = [self.largest[0].max(width), self.largest[1].max(height)];
    }

    /// Updates what is queried; does nothing where nothing changed.
    pub(crate) fn refresh(&mut self) {
        if self.stale >= self.height {
            return;
        }
        match self.kind {
            Occlusion::Sat => self.sum(),
            Occlusion::Box => self.convolve(),
            Occlusion::None | Occlusion::Auto => {}
        }
        self.stale = self.height;
    }

    /// Updates the summed-area table. Rows above the first changed one keep their sums.
    fn sum(&mut self) {
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
    }

    /// Convolves the finished pixels with a box as large as the largest splat so far, by rows and then by columns. A box that
    /// reaches beyond the picture counts what is within.
    fn convolve(&mut self) {
        let Self { width, height, .. } = *self;
        // Odd, so that a box has a centre.
        self.window = self.largest.map(|size| size | 1);
        let [across, down] = self.window.map(|size| size / 2);
        let around =
            |at: usize, half: usize, count: usize| at.saturating_sub(half)..(at + half + 1).min(count);
        let mut rows = vec![false; width * height];
        for y in 0..height {
            let pixels = &self.pixels[y * width..(y + 1) * width];
            for (x, row) in rows[y * width..(y + 1) * width].iter_mut().enumerate() {
                *row = pixels[around(x, across, width)].iter().all(|&finished| finished);
            }
        }
        for y in 0..height {
            for x in 0..width {
                let all = around(y, down, height).all(|row| rows[row * width + x]);
                self.windows[y * width + x] = all;
            }
        }
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
            Occlusion::Box => {
                let fits = x1 - x0 <= self.window[0] && y1 - y0 <= self.window[1];
                // The middle pixel: a window around it reaches as far as the area does on either side.
                let (x, y) = ((x0 + x1 - 1) / 2, (y0 + y1 - 1) / 2);
                let reaches = x1 - x <= self.window[0].div_ceil(2) && y1 - y <= self.window[1].div_ceil(2);
                fits && reaches && self.windows[y * self.width + x]
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

    /// A box as large as the largest splat hides what fits into it, and never what a single unfinished pixel is in.
    #[test]
    fn the_box_hides_only_what_is_finished() {
        let mut finished = Finished::default();
        finished.reset(Occlusion::Box, 19, 11);
        finished.note([4, 3]);
        for y in 2..9 {
            for x in 3..15 {
                finished.finish(x, y);
            }
        }
        assert!(!finished.hide([6, 4, 9, 6]), "not refreshed yet");
        finished.refresh();
        assert!(finished.hide([6, 4, 9, 6]));
        assert!(finished.hide([5, 3, 9, 6]));
        assert!(!finished.hide([5, 3, 11, 6]), "larger than the box");
        let inside = |[x0, y0, x1, y1]: [usize; 4]| x0 >= 3 && x1 <= 15 && y0 >= 2 && y1 <= 9;
        for (x0, y0) in (0..15).flat_map(|x0| (0..8).map(move |y0| (x0, y0))) {
            for (width, height) in (1..5).flat_map(|width| (1..4).map(move |height| (width, height))) {
                let area = [x0, y0, x0 + width, y0 + height];
                assert!(!finished.hide(area) || inside(area), "{area:?}");
            }
        }
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
