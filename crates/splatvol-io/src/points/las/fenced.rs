//! A file in memory whose end can be moved while it is read.

use std::io::{Cursor, Read, Result, Seek, SeekFrom};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Bytes of which those before the end are read. The end is moved by [`Fence`].
pub(super) struct Fenced {
    bytes: Cursor<Vec<u8>>,
    end: Arc<AtomicU64>,
}

/// The end of a file that somebody else reads.
pub(super) struct Fence(Arc<AtomicU64>);

impl Fenced {
    /// All bytes, and their end.
    pub(super) fn new(bytes: Vec<u8>) -> (Self, Fence) {
        let end = Arc::new(AtomicU64::new(u64::MAX));
        let fenced = Self {
            bytes: Cursor::new(bytes),
            end: Arc::clone(&end),
        };
        (fenced, Fence(end))
    }
}

impl Fence {
    /// From now on the file ends here.
    pub(super) fn set(&self, end: u64) {
        self.0.store(end, Ordering::Relaxed);
    }
}

impl Read for Fenced {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let left = self
            .end
            .load(Ordering::Relaxed)
            .saturating_sub(self.bytes.position());
        let length = usize::try_from(left).map_or(buffer.len(), |left| left.min(buffer.len()));
        self.bytes.read(&mut buffer[..length])
    }
}

impl Seek for Fenced {
    fn seek(&mut self, to: SeekFrom) -> Result<u64> {
        self.bytes.seek(to)
    }
}
