//! Stores of keyed bytes: servers, object stores, mappings of other programs. Zarr is read from them as from folders.

use std::fmt::Debug;
use std::io;

/// Bytes of an object that are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ByteRange {
    /// All of them.
    All,
    /// So many, from a position on; fewer where the object ends.
    From {
        /// The first.
        start: u64,
        /// Their number.
        length: u64,
    },
    /// So many at the end; fewer where the object has no more.
    Last(u64),
}

impl ByteRange {
    /// First byte and number of bytes within an object of a length.
    pub fn within(self, all: u64) -> (u64, u64) {
        match self {
            Self::All => (0, all),
            Self::From { start, length } => {
                let start = start.min(all);
                (start, length.min(all - start))
            }
            Self::Last(length) => {
                let length = length.min(all);
                (all - length, length)
            }
        }
    }
}

/// A store of objects by key. Any thread may read at any time; a call blocks until the bytes are there.
pub trait KeyStore: Debug + Send + Sync {
    /// Its address, without secrets.
    fn name(&self) -> String;

    /// Bytes of an object, `None` where there is none. `key` is relative to the store, such as `0/c/0/0/0`.
    ///
    /// # Errors
    /// Objects that cannot be read, or of whose bytes more than `most` were asked for.
    fn read(&self, key: &str, bytes: ByteRange, most: u64) -> io::Result<Option<Vec<u8>>>;

    /// A hint that these bytes are read next, so that a store may fetch them at once: keys, ranges, and how many at most.
    fn will_read(&self, _requests: &[(String, ByteRange, u64)]) {}
}

/// The error of bytes that are more than the reader has use for.
pub fn too_many_bytes(found: u64, most: u64) -> io::Error {
    let what = format!("an object of {found} bytes, where at most {most} are expected");
    io::Error::new(io::ErrorKind::InvalidData, what)
}
