//! A tile's sheet: five channels per pixel, in f32.
//!
//! Rows hold the channels one after the other (`[row][channel][pixel]`), so that a footprint touches few cache lines
//! and each channel is contiguous. Rows begin at cache lines and vectors are aligned to their size, so that a splat
//! reads what the one before it wrote in the same pieces (store forwarding fails otherwise: measured, 2.3 times
//! slower). An odd number of cache lines per pitch avoids 4 KiB aliasing.

/// Channels of a sheet.
pub(crate) const CHANNELS: usize = 5;
/// Widest SIMD vector, in f32.
pub(crate) const MAX_LANES: usize = 16;

/// One sheet of a tile.
#[derive(Debug)]
pub(crate) struct SheetBuffer {
    /// `[row][channel][pixel]`, from `start` on.
    pub data: Vec<f32>,
    /// First element that begins a cache line.
    start: usize,
    /// Pixels per channel and row, padding included.
    pub pitch: usize,
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
        let pitch = edge.next_multiple_of(MAX_LANES) + MAX_LANES;
        let data = vec![0.0f32; edge * CHANNELS * pitch + MAX_LANES];
        let start = data
            .as_ptr()
            .align_offset(size_of::<[f32; MAX_LANES]>())
            .min(MAX_LANES);
        Self {
            data,
            start,
            pitch,
            touched: Touched::default(),
        }
    }

    /// Index of a row's first channel.
    #[inline(always)]
    pub(crate) fn row(&self, y: usize) -> usize {
        self.start + y * CHANNELS * self.pitch
    }

    /// The channels of a pixel.
    #[inline(always)]
    pub(crate) fn pixel(&self, x: usize, y: usize) -> [f32; CHANNELS] {
        let start = self.row(y) + x;
        std::array::from_fn(|channel| self.data[start + channel * self.pitch])
    }

    /// Zeroes what was touched.
    pub(crate) fn clear(&mut self) {
        let touched = std::mem::take(&mut self.touched);
        for y in touched.y0..touched.y1 {
            let row = self.row(y);
            self.data[row..row + CHANNELS * self.pitch].fill(0.0);
        }
    }
}
