//! A sheet of pixels in rows of aligned vectors.

/// Floats of a cache line.
pub(crate) const LINE: usize = 16;
/// Rows behind the last one: a whole row may be taken from any float of the last one, and a small footprint's rows from
/// any row.
const PADDING: usize = 9;

/// Floats from an address that is a multiple of a cache line.
#[derive(Debug, Default)]
pub(crate) struct Aligned {
    storage: Vec<f32>,
    offset: usize,
}

impl Aligned {
    /// All zero.
    pub(crate) fn zeros(length: usize) -> Self {
        let storage = vec![0.0; length + LINE];
        // Never reallocated: the offset holds as long as the memory.
        let offset = storage.as_ptr().align_offset(LINE * size_of::<f32>()).min(LINE);
        Self { storage, offset }
    }

    /// Makes room for so many floats; what they are is not said.
    pub(crate) fn reserve(&mut self, length: usize) {
        if self.storage.len() < length + LINE {
            *self = Self::zeros(length);
        }
    }

    #[inline(always)]
    pub(crate) fn as_slice(&self) -> &[f32] {
        &self.storage[self.offset.min(self.storage.len())..]
    }

    #[inline(always)]
    pub(crate) fn as_mut_slice(&mut self) -> &mut [f32] {
        let offset = self.offset.min(self.storage.len());
        &mut self.storage[offset..]
    }
}

/// Pixels of one or four interleaved channels.
///
/// Rows begin at cache lines and lie an odd number of them apart, so that the rows of a footprint share no cache set.
#[derive(Debug)]
pub struct Sheet<const CHANNELS: usize> {
    values: Aligned,
    size: [usize; 2],
    /// Floats from row to row.
    pitch: usize,
}

impl<const CHANNELS: usize> Sheet<CHANNELS> {
    /// A sheet of `width` x `height` pixels, all zero.
    pub fn new([width, height]: [usize; 2]) -> Self {
        const { assert!(CHANNELS == 1 || CHANNELS == 4, "one channel or four") };
        let lines = (width * CHANNELS).div_ceil(LINE) | 1;
        let pitch = lines * LINE;
        Self {
            values: Aligned::zeros(pitch * (height + PADDING)),
            size: [width, height],
            pitch,
        }
    }

    /// Pixels of a row, and rows.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// A pixel's channels; none outside the sheet.
    pub fn pixel(&self, x: usize, y: usize) -> Option<[f32; CHANNELS]> {
        if x >= self.size[0] || y >= self.size[1] {
            return None;
        }
        let first = y * self.pitch + x * CHANNELS;
        self.values.as_slice()[first..].first_chunk().copied()
    }

    /// Sets all pixels to zero.
    pub fn clear(&mut self) {
        self.values.as_mut_slice().fill(0.0);
    }

    /// Floats from row to row.
    #[inline(always)]
    pub(crate) fn pitch(&self) -> usize {
        self.pitch
    }

    #[inline(always)]
    pub(crate) fn values(&self) -> &[f32] {
        &self.values.as_slice()[..self.pitch * self.size[1]]
    }

    #[inline(always)]
    pub(crate) fn values_mut(&mut self) -> &mut [f32] {
        &mut self.values.as_mut_slice()[..self.pitch * self.size[1]]
    }

    /// With rows behind the last one that nobody sees.
    #[inline(always)]
    pub(crate) fn padded_mut(&mut self) -> &mut [f32] {
        &mut self.values.as_mut_slice()[..self.pitch * (self.size[1] + PADDING)]
    }
}
