//! Errors of sources of chunks.

use std::fmt::{self, Display, Formatter};

use crate::{SceneError, VoxelBox};

/// Place and cause of a failure, for people.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChunkFault {
    /// Level of detail.
    pub level: usize,
    /// Number of the chunk along x, y, z.
    pub chunk: [usize; 3],
    /// Key of the stored object: a file's name within its folder, or an address.
    pub key: String,
    /// Codec that failed, if one did.
    pub codec: Option<String>,
    /// Byte in the stored object at which the chunk begins.
    pub offset: u64,
    /// Cause.
    pub reason: String,
}

impl Display for ChunkFault {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        let Self { level, key, .. } = self;
        let [x, y, z] = self.chunk;
        write!(formatter, "level {level}, chunk {x},{y},{z}, key {key}")?;
        if self.offset > 0 {
            write!(formatter, " from byte {}", self.offset)?;
        }
        if let Some(codec) = &self.codec {
            write!(formatter, ", codec {codec}")?;
        }
        write!(formatter, ": {}", self.reason)
    }
}

/// Why a chunk cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SourceError {
    /// It may come at another try.
    #[error("{0} (another try may succeed)")]
    Transient(Box<ChunkFault>),
    /// The stored bytes are not those that were written.
    #[error("{0}")]
    Corrupt(Box<ChunkFault>),
    /// The chunk should be there and is not.
    #[error("{0}")]
    Missing(Box<ChunkFault>),
    /// The chunk must not be read, or cannot be read in the memory that is allowed.
    #[error("{0}")]
    Refused(Box<ChunkFault>),
}

impl SourceError {
    /// Place and cause.
    pub fn fault(&self) -> &ChunkFault {
        match self {
            Self::Transient(fault) | Self::Corrupt(fault) | Self::Missing(fault) | Self::Refused(fault) => {
                fault
            }
        }
    }

    /// The same as an error of the scene's source called `name`, at a region of samples.
    pub fn of_scene(&self, name: impl Into<String>, region: VoxelBox) -> SceneError {
        SceneError::Source {
            name: name.into(),
            level: self.fault().level,
            first: region.first,
            reason: self.to_string(),
        }
    }
}
