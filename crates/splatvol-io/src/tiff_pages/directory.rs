//! Directories of TIFF and `BigTIFF` (TIFF 6.0, section 2): the tags of each page.
//!
//! Every length is checked against the file before memory is taken for it.

use std::collections::HashSet;
use std::path::Path;

use crate::IoError;
use crate::error::Context;
use crate::files::{File, read_at};
use crate::samples::Endian;
use crate::source::Source;

/// Numbers of tags.
pub(crate) mod tag {
    pub(crate) const IMAGE_WIDTH: u16 = 256;
    pub(crate) const IMAGE_LENGTH: u16 = 257;
    pub(crate) const BITS_PER_SAMPLE: u16 = 258;
    pub(crate) const COMPRESSION: u16 = 259;
    pub(crate) const PHOTOMETRIC_INTERPRETATION: u16 = 262;
    pub(crate) const FILL_ORDER: u16 = 266;
    pub(crate) const IMAGE_DESCRIPTION: u16 = 270;
    pub(crate) const STRIP_OFFSETS: u16 = 273;
    pub(crate) const SAMPLES_PER_PIXEL: u16 = 277;
    pub(crate) const ROWS_PER_STRIP: u16 = 278;
    pub(crate) const STRIP_BYTE_COUNTS: u16 = 279;
    pub(crate) const X_RESOLUTION: u16 = 282;
    pub(crate) const Y_RESOLUTION: u16 = 283;
    pub(crate) const PLANAR_CONFIGURATION: u16 = 284;
    pub(crate) const PREDICTOR: u16 = 317;
    pub(crate) const TILE_WIDTH: u16 = 322;
    pub(crate) const TILE_LENGTH: u16 = 323;
    pub(crate) const TILE_OFFSETS: u16 = 324;
    pub(crate) const TILE_BYTE_COUNTS: u16 = 325;
    pub(crate) const SAMPLE_FORMAT: u16 = 339;
    pub(crate) const JPEG_TABLES: u16 = 347;
    /// `GeoTIFF` (OGC 19-008r4).
    pub(crate) const MODEL_PIXEL_SCALE: u16 = 33_550;
    pub(crate) const MODEL_TIEPOINT: u16 = 33_922;
    pub(crate) const MODEL_TRANSFORMATION: u16 = 34_264;
    pub(crate) const GEO_KEY_DIRECTORY: u16 = 34_735;
    /// GDAL's value of missing samples.
    pub(crate) const GDAL_NODATA: u16 = 42_113;
}

/// A tag of the current directory.
#[derive(Debug, Clone, Copy)]
struct Entry {
    tag: u16,
    kind: u16,
    count: u64,
    /// The value, or its place in the file.
    value: [u8; 8],
}

/// The directories of a file.
pub(super) struct Directories {
    file: File,
    pub(super) length: u64,
    pub(super) endian: Endian,
    big: bool,
    /// Places of the directories that are known.
    places: Vec<u64>,
    visited: HashSet<u64>,
    /// Place of the directory behind them, 0 for none.
    next: u64,
    current: usize,
    entries: Vec<Entry>,
}

impl Directories {
    /// Opens a regular file at its first directory.
    pub(super) fn open(path: &Path, context: &Context<'_>) -> Result<Self, IoError> {
        // Refuses anything but a regular file.
        let length = Source::open(path)?.at_most();
        let file = File::open(path).map_err(|error| context.read(error))?;
        let mut directories = Self {
            file,
            length,
            endian: Endian::Little,
            big: false,
            places: Vec::new(),
            visited: HashSet::new(),
            next: 0,
            current: 0,
            entries: Vec::new(),
        };
        let head = directories.bytes(0, length.min(16), context)?;
        directories.endian = match head.get(..2) {
            Some(b"II") => Endian::Little,
            Some(b"MM") => Endian::Big,
            _ => return Err(context.field("byte order", head.escape_ascii(), 0, "II or MM")),
        };
        let version = directories.number(head.get(2..4).unwrap_or_default());
        let place = match version {
            42 => head.get(4..8),
            43 => head.get(8..16),
            _ => return Err(context.field("version", version, 2, "42, or 43 of BigTIFF")),
        };
        directories.big = version == 43;
        let place = place.ok_or_else(|| context.truncated("header", 8, length))?;
        directories.next = directories.number(place);
        match directories.advance(context)? {
            true => Ok(directories),
            false => Err(context.truncated("pages", 1, 0)),
        }
    }

    /// Goes to the directory behind the last known one; false where there is none.
    fn advance(&mut self, context: &Context<'_>) -> Result<bool, IoError> {
        if self.next == 0 {
            return Ok(false);
        }
        if !self.visited.insert(self.next) {
            return Err(context.field("next page", self.next, None, "a page that was not there before"));
        }
        self.places.push(self.next);
        self.current = self.places.len() - 1;
        self.read(context)?;
        Ok(true)
    }

    /// Number of directories. The last is the current one then.
    pub(super) fn count(&mut self, context: &Context<'_>) -> Result<usize, IoError> {
        while self.advance(context)? {}
        Ok(self.places.len())
    }

    /// Makes a directory the current one.
    pub(super) fn seek(&mut self, page: usize, context: &Context<'_>) -> Result<(), IoError> {
        while page >= self.places.len() {
            if !self.advance(context)? {
                return Err(context.truncated("pages", page as u64 + 1, self.places.len() as u64));
            }
        }
        if self.current == page {
            return Ok(());
        }
        self.current = page;
        let next = self.next;
        self.read(context)?;
        self.next = next;
        Ok(())
    }

    /// Reads the entries of the current directory, and the place of the next.
    fn read(&mut self, context: &Context<'_>) -> Result<(), IoError> {
        let place = self.places[self.current];
        let (counted, size, link) = if self.big { (8, 20, 8) } else { (2, 12, 4) };
        let count = self.number(&self.bytes(place, counted, context)?);
        let at = place + counted;
        let bytes = self.bytes(at, count.saturating_mul(size).saturating_add(link), context)?;
        let (entries, link) = bytes.split_at(bytes.len() - link as usize);
        let entry = |bytes: &[u8]| {
            let (count, value) = bytes[4..].split_at((size as usize - 4) / 2);
            let mut whole = [0; 8];
            whole[..value.len()].copy_from_slice(value);
            Entry {
                tag: self.number(&bytes[..2]) as u16,
                kind: self.number(&bytes[2..4]) as u16,
                count: self.number(count),
                value: whole,
            }
        };
        let (entries, next) = (
            entries.chunks_exact(size as usize).map(entry).collect(),
            self.number(link),
        );
        (self.entries, self.next) = (entries, next);
        Ok(())
    }

    /// Bytes of the file.
    pub(super) fn bytes(&self, offset: u64, count: u64, context: &Context<'_>) -> Result<Vec<u8>, IoError> {
        let left = self.length.saturating_sub(offset);
        if count > left {
            return Err(context.truncated("bytes", count, left));
        }
        let size = usize::try_from(count).map_err(|_| context.limit(count, usize::MAX as u64))?;
        let mut bytes = vec![0; size];
        read_at(&self.file, &mut bytes, offset).map_err(|error| context.read(error))?;
        Ok(bytes)
    }

    /// An unsigned integer of the length of the bytes.
    fn number(&self, bytes: &[u8]) -> u64 {
        let add = |number: u64, byte: &u8| number << 8 | u64::from(*byte);
        match self.endian {
            Endian::Big => bytes.iter().fold(0, add),
            Endian::Little => bytes.iter().rev().fold(0, add),
        }
    }

    /// True where the current directory has a tag.
    pub(super) fn has(&self, tag: u16) -> bool {
        self.entries.iter().any(|entry| entry.tag == tag)
    }

    /// Type and bytes of a tag's value; no bytes where the tag is missing.
    fn value(&self, tag: u16, context: &Context<'_>) -> Result<(u16, Vec<u8>), IoError> {
        let Some(entry) = self.entries.iter().find(|entry| entry.tag == tag) else {
            return Ok((BYTE, Vec::new()));
        };
        let size = size_of_type(entry.kind)
            .ok_or_else(|| context.field(format!("type of tag {tag}"), entry.kind, None, "1 to 18"))?;
        let length = entry.count.saturating_mul(size);
        let inline = if self.big { 8 } else { 4 };
        let bytes = match length <= inline {
            true => entry.value[..length as usize].to_vec(),
            false => self.bytes(self.number(&entry.value[..inline as usize]), length, context)?,
        };
        Ok((entry.kind, bytes))
    }

    /// Text of a tag, without what follows a zero.
    pub(super) fn text(&self, tag: u16, context: &Context<'_>) -> Option<String> {
        let (_, bytes) = self.value(tag, context).ok()?;
        let text = bytes.split(|&byte| byte == 0).next()?;
        Some(String::from_utf8_lossy(text).into_owned()).filter(|text| !text.is_empty())
    }

    /// Plain bytes of a tag.
    pub(super) fn blob(&self, tag: u16, context: &Context<'_>) -> Result<Vec<u8>, IoError> {
        Ok(self.value(tag, context)?.1)
    }

    /// Unsigned integers of a tag.
    pub(super) fn unsigned(&self, tag: u16, context: &Context<'_>) -> Result<Vec<u64>, IoError> {
        let (kind, bytes) = self.value(tag, context)?;
        match (kind, size_of_type(kind)) {
            (BYTE | SHORT | LONG | IFD | LONG8 | IFD8, Some(size)) => {
                let numbers = bytes.chunks_exact(size as usize);
                Ok(numbers.map(|number| self.number(number)).collect())
            }
            _ => Err(context.field(format!("type of tag {tag}"), kind, None, "an unsigned integer")),
        }
    }

    /// Numbers of a tag, of any type but text.
    pub(super) fn floats(&self, tag: u16, context: &Context<'_>) -> Result<Vec<f64>, IoError> {
        let (kind, bytes) = self.value(tag, context)?;
        let signed = |bytes: &[u8]| {
            let unused = 64 - 8 * bytes.len() as u32;
            ((self.number(bytes) << unused) as i64 >> unused) as f64
        };
        let float = |bytes: &[u8]| match kind {
            FLOAT => f64::from(f32::from_bits(self.number(bytes) as u32)),
            DOUBLE => f64::from_bits(self.number(bytes)),
            RATIONAL => self.number(&bytes[..4]) as f64 / self.number(&bytes[4..]) as f64,
            SRATIONAL => signed(&bytes[..4]) / signed(&bytes[4..]),
            SBYTE | SSHORT | SLONG | SLONG8 => signed(bytes),
            _ => self.number(bytes) as f64,
        };
        let size = size_of_type(kind).unwrap_or(1) as usize;
        Ok(bytes.chunks_exact(size).map(float).collect())
    }
}

const BYTE: u16 = 1;
const SHORT: u16 = 3;
const LONG: u16 = 4;
const RATIONAL: u16 = 5;
const SBYTE: u16 = 6;
const SSHORT: u16 = 8;
const SLONG: u16 = 9;
const SRATIONAL: u16 = 10;
const FLOAT: u16 = 11;
const DOUBLE: u16 = 12;
const IFD: u16 = 13;
const LONG8: u16 = 16;
const SLONG8: u16 = 17;
const IFD8: u16 = 18;

/// Bytes of a type of values.
fn size_of_type(kind: u16) -> Option<u64> {
    // Texts are 2, bytes without a meaning 7.
    Some(match kind {
        BYTE | 2 | SBYTE | 7 => 1,
        SHORT | SSHORT => 2,
        LONG | SLONG | FLOAT | IFD => 4,
        RATIONAL | SRATIONAL | DOUBLE | LONG8 | SLONG8 | IFD8 => 8,
        _ => return None,
    })
}
