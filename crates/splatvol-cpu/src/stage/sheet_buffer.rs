//! A tile's sheet: five channels per pixel, in f32.
//!
//! Rows hold the channels one after the other, so that a footprint touches few cache lines and each channel is
//! contiguous. Rows begin at cache lines and vectors are aligned to their size, so that a splat reads what the one
//! before it wrote in the same pieces (store forwarding fails otherwise). A channel's pitch is the widest tile plus one
//! vector, 80 pixels: an odd number of cache lines, which avoids 4 KiB aliasing, and a constant, which leaves one
//! bounds check per row.

/// Channels of a sheet.
pub(crate) const CHANNELS: usize = 5;
/// Widest SIMD vector, in f32.
pub(crate) const MAX_LANES: usize = 16;
/// Largest edge of a tile, pixels.
pub(crate) const MAX_EDGE: usize = 64;
/// Pixels per channel and row; the last vector of a row may write behind the tile.
pub(crate) const PITCH: usize = MAX_EDGE + MAX_LANES;

/// The channels of a row of pixels.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Row(pub [[f32; PITCH]; CHANNELS]);

/// One sheet of a tile.
#[derive(Debug)]
pub(crate) struct SheetBuffer {
    /// Top to bottom.
    pub rows: Vec<Row>,
    /// Pixels touched since the last clear: x0, y0, x1, y1 relative to the tile, ends excluded.
    pub touched: Touched,
}

/// A rectangle that only grows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Touched {
    pub x0: usize,
    pub y0: usize,
    pub x1: usize,
    pub y1: usize,
}

impl Default for Touched {
    fn default() -> Self {
        Self {
            x0: usize::MAX,
            y0: usize::MAX,
            x1: 0,
            y1: 0,
        }
    }
}

impl Touched {
    /// True where nothing was touched.
    pub(crate) fn is_empty(&self) -> bool {
        self.x0 >= self.x1
    }

    /// Smallest rectangle around both.
    pub(crate) fn join(self, other: Self) -> Self {
        Self {
            x0: self.x0.min(other.x0),
            y0: self.y0.min(other.y0),
            x1: self.x1.max(other.x1),
            y1: self.y1.max(other.y1),
        }
    }
}

impl SheetBuffer {
    /// Zeroed sheet for tiles of `edge` pixels.
    pub(crate) fn new(edge: usize) -> Self {
        Self {
            rows: vec![Row([[0.0; PITCH]; CHANNELS]); edge],
            touched: Touched::default(),
        }
    }

    /// The channels of a pixel.
    #[inline(always)]
    pub(crate) fn pixel(&self, x: usize, y: usize) -> [f32; CHANNELS] {
        let row = &self.rows[y].0;
        std::array::from_fn(|channel| row[channel][x])
    }

    /// Zeroes what was touched.
    pub(crate) fn clear(&mut self) {
        let touched = std::mem::take(&mut self.touched);
        if !touched.is_empty() {
            // The last vector may have written a vector's length further.
            let columns = touched.x0 / MAX_LANES * MAX_LANES..(touched.x1 + MAX_LANES).min(PITCH);
            for row in &mut self.rows[touched.y0..touched.y1] {
                for channel in &mut row.0 {
                    channel[columns.clone()].fill(0.0);
                }
            }
        }
    }
}
