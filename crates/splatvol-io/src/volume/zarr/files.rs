//! Stored bytes of single chunks: from a file each, or from shards, whose indices are kept.

use std::collections::VecDeque;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use splatvol_scene::{ChunkFault, SourceError};

use super::array::{Array, Shard};
use super::codec::Codec;
use super::folder::Folder;
use crate::IoError;
use crate::files::{self, File, read_at};
use crate::key_store::{ByteRange, too_many_bytes};

/// Bytes of a chunk's offset and length in the index of a shard.
pub(super) const INDEX_ENTRY: u64 = 16;
/// Shards whose indices are kept: their number (files that are open), and the bytes of all indices.
const KEPT_SHARDS: usize = 64;
const KEPT_BYTES: usize = 32 << 20;
/// Bytes that a stored chunk may have beyond twice those of its samples.
const OVERHEAD: u64 = 1 << 20;
/// An entry of an index for a chunk that is not there.
const ABSENT: (u64, u64) = (u64::MAX, u64::MAX);

/// Kind of a failure: that of [`SourceError`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Transient,
    Corrupt,
    Missing,
    Refused,
}

/// Place of a chunk's bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) key: String,
    pub(super) offset: u64,
}

impl Place {
    /// A failure here.
    pub(super) fn fault(&self, kind: Kind, codec: Option<Codec>, reason: impl Into<String>) -> Failure {
        Failure::Chunk {
            kind,
            place: self.clone(),
            codec,
            reason: reason.into(),
        }
    }

    fn of_system(&self, error: &io::Error) -> Failure {
        let kind = match error.kind() {
            io::ErrorKind::PermissionDenied => Kind::Refused,
            io::ErrorKind::UnexpectedEof | io::ErrorKind::InvalidData => Kind::Corrupt,
            _ => Kind::Transient,
        };
        self.fault(kind, None, error.to_string())
    }
}

/// Why a chunk cannot be read.
#[derive(Debug)]
pub(super) enum Failure {
    /// A link that leads out of the array's folder.
    Outside(Box<IoError>),
    Chunk {
        kind: Kind,
        place: Place,
        codec: Option<Codec>,
        reason: String,
    },
}

impl Failure {
    /// The same as an error of a chunk.
    pub(super) fn at(self, level: usize, chunk: [usize; 3]) -> SourceError {
        let fault = |place: Place, codec: Option<Codec>, reason| {
            Box::new(ChunkFault {
                level,
                chunk,
                key: place.key,
                codec: codec.map(|codec| codec.name().to_owned()),
                offset: place.offset,
                reason,
            })
        };
        match self {
            Self::Outside(error) => {
                let place = Place {
                    key: String::new(),
                    offset: 0,
                };
                SourceError::Refused(fault(place, None, error.to_string()))
            }
            Self::Chunk {
                kind,
                place,
                codec,
                reason,
            } => {
                let fault = fault(place, codec, reason);
                match kind {
                    Kind::Transient => SourceError::Transient(fault),
                    Kind::Corrupt => SourceError::Corrupt(fault),
                    Kind::Missing => SourceError::Missing(fault),
                    Kind::Refused => SourceError::Refused(fault),
                }
            }
        }
    }
}

/// The files of an array, or its objects in a store.
#[derive(Debug)]
pub(super) struct Files {
    folder: Folder,
    /// Most stored bytes of a chunk.
    most: u64,
    /// The folder without links; `None` where links may lead anywhere.
    real_folder: Option<PathBuf>,
    shards: Mutex<VecDeque<Known>>,
}

/// A shard by its key; without a file, all of it is fill.
type Known = (String, Option<Arc<OpenShard>>);

/// A chunk's shard, and its bytes there.
type Found = Option<(Arc<OpenShard>, u64)>;

/// The open file of a shard, or its key in a store.
#[derive(Debug)]
struct OpenShard {
    /// The file and its length; `None` in a store.
    file: Option<(File, u64)>,
    /// Offset and length of every chunk, 16 bytes each.
    index: Vec<u8>,
}

impl Files {
    pub(super) fn new(array: &Array, allow_outside: bool) -> Self {
        let real_folder = files::canonicalize(array.folder.path());
        let bytes = array.samples_of_chunk() as u64 * array.sample_type.size() as u64;
        Self {
            folder: array.folder.clone(),
            most: bytes.saturating_mul(2).saturating_add(OVERHEAD),
            real_folder: real_folder.ok().filter(|_| !allow_outside),
            shards: Mutex::default(),
        }
    }

    /// Reads the stored bytes of a chunk; `None` as the second where there are none.
    pub(super) fn read(
        &self,
        array: &Array,
        numbers: &[usize],
        into: &mut Vec<u8>,
    ) -> Result<(Place, bool), Failure> {
        let Some(shard) = &array.shard else {
            return self.file(array.key(numbers), into);
        };
        let (place, found) = self.locate(array, shard, numbers)?;
        let Some((open, length)) = found else {
            return Ok((place, false));
        };
        let offset = place.offset;
        let Some((file, all)) = &open.file else {
            let range = ByteRange::From {
                start: offset,
                length,
            };
            return match self.fetch(&place, range)? {
                Some(bytes) if bytes.len() as u64 == length => {
                    *into = bytes;
                    Ok((place, true))
                }
                Some(bytes) => {
                    let reason = format!("{} bytes of the {length} that the shard lists", bytes.len());
                    Err(place.fault(Kind::Corrupt, None, reason))
                }
                None => Err(place.fault(Kind::Missing, None, "the shard is gone; it was there")),
            };
        };
        if offset.checked_add(length).is_none_or(|end| end > *all) {
            let reason = format!("{length} bytes outside the shard of {all}");
            return Err(place.fault(Kind::Corrupt, None, reason));
        }
        into.clear();
        into.resize(length as usize, 0);
        read_at(file, into, offset).map_err(|error| place.of_system(&error))?;
        Ok((place, true))
    }

    /// Where a chunk lies in its shard, and its bytes there; `None` if it is not there.
    fn locate(&self, array: &Array, shard: &Shard, numbers: &[usize]) -> Result<(Place, Found), Failure> {
        let inner = shard.chunks_along(&array.chunks);
        let outer: Vec<usize> = numbers
            .iter()
            .zip(&inner)
            .map(|(number, inner)| number / inner)
            .collect();
        let within = |place, (number, inner): (&usize, &usize)| place * inner + number % inner;
        let within = numbers.iter().zip(&inner).fold(0, within);
        let mut place = Place {
            key: array.key(&outer),
            offset: 0,
        };
        let Some(open) = self.shard(shard, &inner, &place)? else {
            return Ok((place, None));
        };
        let (offset, length) = open.entry(within);
        if (offset, length) == ABSENT {
            return Ok((place, None));
        }
        place.offset = offset;
        Ok((place, Some((open, length))))
    }

    /// Tells a store which chunks are read next. Errors are those of the reads.
    pub(super) fn will_read(&self, array: &Array, numbers: impl Iterator<Item = Vec<usize>>) {
        let Some((store, _)) = self.folder.stored("") else {
            return;
        };
        let request = |numbers: Vec<usize>| {
            let (key, range) = match &array.shard {
                None => (array.key(&numbers), ByteRange::All),
                Some(shard) => {
                    let (place, found) = self.locate(array, shard, &numbers).ok()?;
                    let (start, length) = (place.offset, found?.1);
                    (place.key, ByteRange::From { start, length })
                }
            };
            let (_, key) = self.folder.stored(&key)?;
            Some((key, range, self.most))
        };
        let requests: Vec<_> = numbers.filter_map(request).collect();
        store.will_read(&requests);
    }

    /// Bytes of an object in a store; `None` if there is none.
    fn fetch(&self, place: &Place, range: ByteRange) -> Result<Option<Vec<u8>>, Failure> {
        let Some((store, key)) = self.folder.stored(&place.key) else {
            return Ok(None);
        };
        let most = match range {
            ByteRange::Last(length) => length,
            ByteRange::From { length, .. } if length > self.most => {
                return Err(place.of_system(&too_many_bytes(length, self.most)));
            }
            _ => self.most,
        };
        store
            .read(&key, range, most)
            .map_err(|error| place.of_system(&error))
    }

    /// All bytes of a file.
    fn file(&self, key: String, into: &mut Vec<u8>) -> Result<(Place, bool), Failure> {
        let place = Place { key, offset: 0 };
        if self.folder.stored("").is_some() {
            return Ok(match self.fetch(&place, ByteRange::All)? {
                Some(bytes) => {
                    *into = bytes;
                    (place, true)
                }
                None => (place, false),
            });
        }
        let Some((file, length)) = self.open(&place)? else {
            return Ok((place, false));
        };
        into.clear();
        into.resize(length as usize, 0);
        read_at(&file, into, 0).map_err(|error| place.of_system(&error))?;
        Ok((place, true))
    }

    /// A regular file and its length, `None` if there is none.
    fn open(&self, place: &Place) -> Result<Option<(File, u64)>, Failure> {
        let path = self.folder.path().join(&place.key);
        let metadata = match files::metadata(&path) {
            Err(error) if is_absent(&error) => return Ok(None),
            found => found.map_err(|error| place.of_system(&error))?,
        };
        // Opening a pipe may block for ever.
        if !metadata.is_file() {
            return Err(place.fault(Kind::Refused, None, "not a regular file"));
        }
        self.check_inside(&path)?;
        let file = File::open(&path).map_err(|error| place.of_system(&error))?;
        Ok(Some((file, metadata.len())))
    }

    fn check_inside(&self, path: &Path) -> Result<(), Failure> {
        let Some(folder) = &self.real_folder else {
            return Ok(());
        };
        match files::canonicalize(path) {
            Ok(target) if !target.starts_with(folder) => Err(Failure::Outside(Box::new(IoError::Outside {
                link: path.to_owned(),
                target,
                path: self.folder.path().to_owned(),
            }))),
            _ => Ok(()),
        }
    }

    /// An open shard: one of those that were read last, or from its file.
    fn shard(
        &self,
        shard: &Shard,
        inner: &[usize],
        place: &Place,
    ) -> Result<Option<Arc<OpenShard>>, Failure> {
        let lock = || self.shards.lock().unwrap_or_else(PoisonError::into_inner);
        {
            let mut shards = lock();
            if let Some(at) = shards.iter().position(|(key, _)| *key == place.key)
                && let Some(known) = shards.remove(at)
            {
                shards.push_back(known.clone());
                return Ok(known.1);
            }
        }
        let open = match self.folder.stored("") {
            Some(_) => self.stored_shard(shard, inner, place)?,
            None => match self.open(place)? {
                Some((file, length)) => Some(OpenShard::of_file((file, length), shard, inner, place)?),
                None => None,
            },
        }
        .map(Arc::new);
        let mut shards = lock();
        shards.push_back((place.key.clone(), open.clone()));
        let bytes = |known: &Known| known.1.as_ref().map_or(0, |open| open.index.len());
        while shards.len() > KEPT_SHARDS
            || (shards.len() > 1 && shards.iter().map(bytes).sum::<usize>() > KEPT_BYTES)
        {
            shards.pop_front();
        }
        Ok(open)
    }
}

impl Files {
    /// A shard in a store: its index alone is read.
    fn stored_shard(
        &self,
        shard: &Shard,
        inner: &[usize],
        place: &Place,
    ) -> Result<Option<OpenShard>, Failure> {
        let length = OpenShard::index_length(shard, inner);
        if length > KEPT_BYTES as u64 {
            let reason = format!("an index of {length} bytes");
            return Err(place.fault(Kind::Refused, None, reason));
        }
        let range = match shard.index_first {
            true => ByteRange::From { start: 0, length },
            false => ByteRange::Last(length),
        };
        let Some(index) = self.fetch(place, range)? else {
            return Ok(None);
        };
        if index.len() as u64 != length {
            let reason = format!("the index needs {length} bytes, the shard has {}", index.len());
            return Err(place.fault(Kind::Corrupt, None, reason));
        }
        OpenShard::new(None, index, shard, place).map(Some)
    }
}

fn is_absent(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::NotFound | io::ErrorKind::NotADirectory
    )
}

impl OpenShard {
    /// Bytes of the index.
    fn index_length(shard: &Shard, inner: &[usize]) -> u64 {
        let entries = inner
            .iter()
            .fold(INDEX_ENTRY, |bytes, &size| bytes.saturating_mul(size as u64));
        entries.saturating_add(if shard.checksum { 4 } else { 0 })
    }

    /// Reads the index from a file of a length.
    fn of_file(
        (file, length): (File, u64),
        shard: &Shard,
        inner: &[usize],
        place: &Place,
    ) -> Result<Self, Failure> {
        let bytes = Self::index_length(shard, inner);
        if bytes > length {
            let reason = format!("the index needs {bytes} bytes, the shard has {length}");
            return Err(place.fault(Kind::Corrupt, None, reason));
        }
        let place = Place {
            offset: if shard.index_first { 0 } else { length - bytes },
            ..place.clone()
        };
        let mut index = vec![0; bytes as usize];
        read_at(&file, &mut index, place.offset).map_err(|error| place.of_system(&error))?;
        Self::new(Some((file, length)), index, shard, &place)
    }

    /// With an index, which is checked.
    fn new(file: Option<(File, u64)>, index: Vec<u8>, shard: &Shard, place: &Place) -> Result<Self, Failure> {
        if shard.checksum
            && let Some((entries, sum)) = index.split_last_chunk::<4>()
            && crc32c::crc32c(entries) != u32::from_le_bytes(*sum)
        {
            let reason = "a wrong checksum of the shard's index";
            return Err(place.fault(Kind::Corrupt, Some(Codec::Crc32c), reason));
        }
        Ok(Self { file, index })
    }

    /// Offset and length of a chunk.
    fn entry(&self, place: usize) -> (u64, u64) {
        let number = |at: usize| {
            let bytes = self.index.get(at..at + 8).and_then(|bytes| bytes.try_into().ok());
            bytes.map_or(u64::MAX, u64::from_le_bytes)
        };
        let at = place * INDEX_ENTRY as usize;
        (number(at), number(at + 8))
    }
}
