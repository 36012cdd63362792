//! Checks of a LAS header against the bytes present.
//!
//! The decoder crate allocates the lengths claimed by variable length records, chunk tables and layers of chunks. Here
//! each of these lengths is checked against the length of the file first.

use super::laszip::Laszip;
use crate::IoError;
use crate::error::Context;

/// Sizes of the fixed parts of point formats 0 to 10.
const RECORD: [u16; 11] = [20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67];
/// Formats with colours.
const COLORED: [u8; 6] = [2, 3, 5, 7, 8, 10];
/// Most points that a byte of LAZ may stand for; a constant cloud takes about a thousandth of a byte per point.
const POINTS_PER_BYTE: u64 = 4096;

/// The parts of a header that determine sizes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Claims {
    pub(super) version: (u8, u8),
    pub(super) format: u8,
    pub(super) compressed: bool,
    pub(super) count: u64,
    /// Where compressed points end.
    pub(super) end: u64,
    record: u16,
    header: u16,
    offset: u32,
    vlrs: u32,
}

/// Numbers at fixed places.
pub(super) struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    pub(super) fn array<const N: usize>(&self, at: u64) -> Option<[u8; N]> {
        let at = usize::try_from(at).ok()?;
        self.0.get(at..at.checked_add(N)?)?.try_into().ok()
    }

    pub(super) fn u16(&self, at: u64) -> Option<u16> {
        self.array(at).map(u16::from_le_bytes)
    }

    pub(super) fn u32(&self, at: u64) -> Option<u32> {
        self.array(at).map(u32::from_le_bytes)
    }

    fn u64(&self, at: u64) -> Option<u64> {
        self.array(at).map(u64::from_le_bytes)
    }

    fn length(&self) -> u64 {
        self.0.len() as u64
    }
}

impl Claims {
    /// The claims of the header, if the file is long enough for them.
    pub(super) fn read(file: &[u8], context: &Context<'_>) -> Result<Self, IoError> {
        let bytes = Bytes(file);
        if !file.starts_with(b"LASF") {
            let start = String::from_utf8_lossy(&file[..file.len().min(4)]);
            return Err(context.field("file signature", start, 0, "LASF"));
        }
        let mut claims =
            Self::parse(&bytes).ok_or_else(|| context.truncated("header", 227, bytes.length()))?;
        claims.check_header(&bytes, context)?;
        claims.check_records(&bytes, context)?;
        if claims.compressed {
            claims.end = claims.check_chunks(&bytes, context)?;
        }
        Ok(claims)
    }

    fn parse(bytes: &Bytes<'_>) -> Option<Self> {
        let [major, minor] = bytes.array(24)?;
        let [format] = bytes.array(104)?;
        let legacy = u64::from(bytes.u32(107)?);
        bytes.array::<8>(219)?;
        let large = if (major, minor) >= (1, 4) {
            bytes.u64(247)?
        } else {
            0
        };
        Some(Self {
            version: (major, minor),
            format: format & 0x3f,
            compressed: format & 0xc0 != 0,
            // By the specification, the old field counts unless it is zero.
            count: if legacy == 0 { large } else { legacy },
            end: u64::MAX,
            record: bytes.u16(105)?,
            header: bytes.u16(94)?,
            offset: bytes.u32(96)?,
            vlrs: bytes.u32(100)?,
        })
    }

    /// Whether points have colours.
    pub(super) fn has_color(&self) -> bool {
        COLORED.contains(&self.format)
    }

    fn check_header(&self, bytes: &Bytes<'_>, context: &Context<'_>) -> Result<(), IoError> {
        let (major, minor) = self.version;
        if major != 1 || minor > 4 {
            return Err(context.field("version", format!("{major}.{minor}"), 24, "1.0 to 1.4"));
        }
        let least = match minor {
            0..=2 => 227,
            3 => 235,
            _ => 375,
        };
        if self.header < least {
            return Err(context.field("header size", self.header, 94, format!("at least {least}")));
        }
        let Some(&fixed) = RECORD.get(usize::from(self.format)) else {
            return Err(context.field("point data record format", self.format, 104, "0 to 10"));
        };
        if self.record < fixed {
            return Err(context.field(
                "point data record length",
                self.record,
                105,
                format!("at least {fixed}"),
            ));
        }
        let offset = u64::from(self.offset);
        if offset > bytes.length() {
            return Err(context.truncated("bytes before the points", offset, bytes.length()));
        }
        if self.count == 0 {
            return Err(context.field("number of point records", 0, 107, "at least 1"));
        }
        let left = bytes.length() - offset;
        let needed = self.count.saturating_mul(u64::from(self.record));
        if !self.compressed && needed > left {
            return Err(context.truncated("points", needed, left));
        }
        let at_most = left.saturating_mul(POINTS_PER_BYTE);
        if self.compressed && self.count > at_most {
            return Err(context.too_small("points", self.count, at_most));
        }
        Ok(())
    }

    /// Variable length records, before and after the points.
    fn check_records(&self, bytes: &Bytes<'_>, context: &Context<'_>) -> Result<(), IoError> {
        let mut at = u64::from(self.header);
        for index in 0..self.vlrs {
            let length = bytes.u16(at + 20).map(u64::from);
            at = length.map_or(u64::MAX, |length| at + 54 + length);
            if at > u64::from(self.offset) {
                let expected = "records that end before the points";
                return Err(context.field(
                    format!("variable length record {index}"),
                    self.vlrs,
                    100,
                    expected,
                ));
            }
        }
        if self.version < (1, 4) {
            return Ok(());
        }
        let (Some(mut at), Some(count)) = (bytes.u64(235), bytes.u32(243)) else {
            return Err(context.truncated("header", 375, bytes.length()));
        };
        for index in 0..count {
            let length = at.checked_add(20).and_then(|place| bytes.u64(place));
            let end = length.and_then(|length| at.checked_add(60)?.checked_add(length));
            match end {
                Some(end) if end <= bytes.length() => at = end,
                _ => {
                    let field = format!("extended variable length record {index}");
                    return Err(context.field(field, count, 243, "records that end with the file"));
                }
            }
        }
        Ok(())
    }

    /// The record of the compression, which stands among those that were checked.
    fn laszip(&self, bytes: &Bytes<'_>) -> Option<Laszip> {
        let mut at = u64::from(self.header);
        (0..self.vlrs).find_map(|_| {
            let header = at;
            at += 54 + u64::from(bytes.u16(at + 20)?);
            Laszip::read(bytes, header, header + 54)
        })
    }

    /// The table of chunks, and the sizes of layers inside chunks. Returns where the points end.
    fn check_chunks(&self, bytes: &Bytes<'_>, context: &Context<'_>) -> Result<u64, IoError> {
        let laszip = self.laszip(bytes);
        let laszip = laszip.ok_or_else(|| {
            let expected = "the record of LAZ, which is missing or cut off";
            context.field("variable length record 22204", "", None, expected)
        })?;
        laszip.check(self.record, context)?;
        let start = u64::from(self.offset);
        let wrong = |value: u64, expected: &str| Err(context.field("chunk table", value, start, expected));
        let Some(table) = bytes.u64(start) else {
            return Err(context.truncated("points", start + 8, bytes.length()));
        };
        // All ones: the writer could not go back, and the place is in the last eight bytes.
        let table = if table == u64::MAX {
            bytes.u64(bytes.length().saturating_sub(8)).unwrap_or(0)
        } else {
            table
        };
        if table < start + 8 || table > bytes.length() - 8 {
            return wrong(table, "a place behind the points and within the file");
        }
        let chunks = u64::from(bytes.u32(table + 4).unwrap_or(u32::MAX));
        // Every chunk begins with a whole point.
        if chunks.saturating_mul(u64::from(self.record)) > table - start {
            return wrong(chunks, "a number of chunks that the file can hold");
        }
        if laszip.chunks(self.count).is_some_and(|needed| needed > chunks) {
            return wrong(chunks, "enough chunks for all points");
        }
        let mut at = start + 8;
        for _ in 0..if laszip.layered() { chunks } else { 0 } {
            let end = laszip.end_of_layers(bytes, at, self.record);
            let Some(end) = end.filter(|end| *end <= table) else {
                return wrong(at, "layers that end before the chunk table");
            };
            at = end;
        }
        Ok(table)
    }
}
