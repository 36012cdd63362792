//! DICOM's data elements: tag, value representation, length, value (PS3.5, sections 7 and A; PS3.10, section 7).
//!
//! A data set is a view of the first bytes of its file, and says where the pixels are: nothing is copied, and a declared length
//! is checked against the bytes present before anything else happens. That is why no crate does this: those found
//! allocate what a header declares, up to 4 GB.

use std::collections::BTreeMap;
use std::ops::Range;

use super::contents::Contents;
use crate::IoError;
use crate::error::Context;
use crate::samples::Endian;

/// `group << 16 | element`.
pub(super) type Tag = u32;

/// The pixels.
pub(super) const PIXEL_DATA: Tag = 0x7fe0_0010;
const ITEM: Tag = 0xfffe_e000;
const ITEM_END: Tag = 0xfffe_e00d;
const SEQUENCE_END: Tag = 0xfffe_e0dd;
/// A length that is not stated.
const UNDEFINED: u32 = u32::MAX;
/// Deepest nesting of sequences; real files have about 6 levels.
const DEPTH: usize = 32;

/// Sequences of interest, which implicit value representations do not mark as such.
const SEQUENCES: [Tag; 9] = [
    0x0020_9111,
    0x0020_9113,
    0x0020_9116,
    0x0028_3000,
    0x0028_9110,
    0x0028_9145,
    0x5200_9229,
    0x5200_9230,
    0x0018_9114,
];

/// Elements by tag; of several with one tag, the first.
#[derive(Debug, Default)]
pub(super) struct Dataset<'a> {
    elements: BTreeMap<Tag, Element<'a>>,
}

#[derive(Debug)]
pub(super) struct Element<'a> {
    pub(super) tag: Tag,
    pub(super) value: Value<'a>,
}

#[derive(Debug)]
pub(super) enum Value<'a> {
    Bytes(&'a [u8]),
    Items(Vec<Dataset<'a>>),
    /// Byte range of the pixels in the file.
    Pixels(Range<usize>),
    /// Byte ranges of the encapsulated pixels in the file; the first fragment is the table of offsets.
    Fragments(Vec<Range<usize>>),
}

impl<'a> Dataset<'a> {
    fn push(&mut self, element: Element<'a>) {
        self.elements.entry(element.tag).or_insert(element);
    }

    pub(super) fn get(&self, tag: Tag) -> Option<&Element<'a>> {
        self.elements.get(&tag)
    }

    pub(super) fn bytes(&self, tag: Tag) -> Option<&'a [u8]> {
        match self.get(tag)?.value {
            Value::Bytes(bytes) => Some(bytes),
            _ => None,
        }
    }

    pub(super) fn items(&self, tag: Tag) -> &[Dataset<'a>] {
        match self.get(tag).map(|element| &element.value) {
            Some(Value::Items(items)) => items,
            _ => &[],
        }
    }
}

/// Coding of the elements.
#[derive(Debug, Clone, Copy)]
pub(super) struct Coding {
    pub(super) explicit: bool,
    pub(super) endian: Endian,
}

/// A position in a file.
pub(super) struct Reader<'a, 'c> {
    contents: &'a Contents,
    at: usize,
    /// First bytes of the file that would have to be in memory for what was read last.
    wanted: usize,
    coding: Coding,
    context: &'c Context<'c>,
}

/// Tag, value representation (blank where implicit) and length.
struct Head {
    tag: Tag,
    representation: [u8; 2],
    length: u32,
}

impl<'a, 'c> Reader<'a, 'c> {
    pub(super) fn new(contents: &'a Contents, at: usize, coding: Coding, context: &'c Context<'c>) -> Self {
        Self {
            contents,
            at,
            wanted: 0,
            coding,
            context,
        }
    }

    pub(super) fn position(&self) -> usize {
        self.at
    }

    /// The file meta information: elements of group 2, always explicit and little-endian.
    pub(super) fn meta(&mut self) -> Result<Dataset<'a>, IoError> {
        let mut dataset = Dataset::default();
        while self.at + 2 <= self.contents.length() && self.view(self.at..self.at + 2)? == [2, 0] {
            dataset.push(self.element(0)?);
        }
        Ok(dataset)
    }

    /// The first bytes of the file that an error was about.
    pub(super) fn wanted(&self) -> usize {
        self.wanted
    }

    /// All elements up to and including the pixels; padding or a signature may follow.
    pub(super) fn image(&mut self) -> Result<Dataset<'a>, IoError> {
        let mut dataset = Dataset::default();
        while self.at < self.contents.length() {
            let element = self.element(0)?;
            let last = element.tag == PIXEL_DATA;
            dataset.push(element);
            if last {
                break;
            }
        }
        Ok(dataset)
    }

    fn element(&mut self, depth: usize) -> Result<Element<'a>, IoError> {
        let head = self.head()?;
        self.value(&head, depth)
    }

    fn value(&mut self, head: &Head, depth: usize) -> Result<Element<'a>, IoError> {
        let sequence = &head.representation == b"SQ" || SEQUENCES.contains(&head.tag);
        let value = if head.length == UNDEFINED && head.tag == PIXEL_DATA {
            Value::Fragments(self.fragments()?)
        } else if head.length == UNDEFINED {
            // PS3.5, 6.2.2: an unknown sequence is coded implicitly.
            let outer = self.coding;
            if &head.representation == b"UN" {
                self.coding = Coding {
                    explicit: false,
                    endian: Endian::Little,
                };
            }
            let items = self.items(None, depth + 1);
            self.coding = outer;
            Value::Items(items?)
        } else if sequence {
            let end = self.end(head.length)?;
            Value::Items(self.items(Some(end), depth + 1)?)
        } else if head.tag == PIXEL_DATA && depth == 0 {
            let start = self.at;
            self.at = self.end(head.length)?;
            Value::Pixels(start..self.at)
        } else {
            Value::Bytes(self.take(head.length)?)
        };
        Ok(Element { tag: head.tag, value })
    }

    fn items(&mut self, end: Option<usize>, depth: usize) -> Result<Vec<Dataset<'a>>, IoError> {
        if depth > DEPTH {
            return Err(self.bad("sequences", format!("{depth} in each other"), "fewer"));
        }
        let mut items = Vec::new();
        while end.is_none_or(|end| self.at < end) {
            let tag = self.tag()?;
            let length = self.number()?;
            match (tag, length) {
                (ITEM, UNDEFINED) => items.push(self.dataset(None, depth)?),
                (ITEM, length) => {
                    let end = self.end(length)?;
                    items.push(self.dataset(Some(end), depth)?);
                }
                (SEQUENCE_END, _) => break,
                (tag, _) => return Err(self.bad("item tag", name(tag), "an item or the sequence's end")),
            }
        }
        Ok(items)
    }

    fn dataset(&mut self, end: Option<usize>, depth: usize) -> Result<Dataset<'a>, IoError> {
        let mut dataset = Dataset::default();
        while end.is_none_or(|end| self.at < end) {
            let head = self.head()?;
            if head.tag == ITEM_END {
                break;
            }
            dataset.push(self.value(&head, depth)?);
        }
        Ok(dataset)
    }

    fn fragments(&mut self) -> Result<Vec<Range<usize>>, IoError> {
        let endian = self.coding.endian;
        let mut fragments = Vec::new();
        loop {
            let start = self.end(8)?;
            let head = self.contents.read(self.at..start, self.context)?;
            let half = |bytes| unsigned(bytes, endian);
            let (tag, length) = (half(&head[..2]) << 16 | half(&head[2..4]), half(&head[4..]));
            self.at = start;
            match tag {
                ITEM => {
                    self.at = self.end(length)?;
                    fragments.push(start..self.at);
                }
                SEQUENCE_END => return Ok(fragments),
                _ => return Err(self.bad("item tag", name(tag), "a fragment or the end of the pixels")),
            }
        }
    }

    fn head(&mut self) -> Result<Head, IoError> {
        let tag = self.tag()?;
        if !self.coding.explicit || tag >> 16 == 0xfffe {
            return Ok(Head {
                tag,
                representation: *b"  ",
                length: self.number()?,
            });
        }
        let representation = [self.byte()?, self.byte()?];
        if !representation.iter().all(u8::is_ascii_uppercase) {
            let shown = String::from_utf8_lossy(&representation).into_owned();
            return Err(self.bad("value representation", shown, "two capital letters"));
        }
        const LONG: [&[u8; 2]; 13] = [
            b"OB", b"OD", b"OF", b"OL", b"OV", b"OW", b"SQ", b"SV", b"UC", b"UN", b"UR", b"UT", b"UV",
        ];
        let length = match LONG.contains(&&representation) {
            true => {
                self.take(2)?;
                self.number()?
            }
            false => u32::from(self.short()?),
        };
        Ok(Head {
            tag,
            representation,
            length,
        })
    }

    fn tag(&mut self) -> Result<Tag, IoError> {
        Ok(u32::from(self.short()?) << 16 | u32::from(self.short()?))
    }

    fn byte(&mut self) -> Result<u8, IoError> {
        Ok(self.take(1)?[0])
    }

    fn short(&mut self) -> Result<u16, IoError> {
        let bytes = self.take(2)?;
        Ok(unsigned(bytes, self.coding.endian) as u16)
    }

    fn number(&mut self) -> Result<u32, IoError> {
        let bytes = self.take(4)?;
        Ok(unsigned(bytes, self.coding.endian))
    }

    fn end(&self, length: u32) -> Result<usize, IoError> {
        let found = self.contents.length() - self.at;
        match length as usize <= found {
            true => Ok(self.at + length as usize),
            false => Err(self
                .context
                .truncated("data elements", u64::from(length), found as u64)),
        }
    }

    fn take(&mut self, length: u32) -> Result<&'a [u8], IoError> {
        let end = self.end(length)?;
        let bytes = self.view(self.at..end)?;
        self.at = end;
        Ok(bytes)
    }

    /// Bytes of the file that are in memory.
    fn view(&mut self, range: Range<usize>) -> Result<&'a [u8], IoError> {
        self.wanted = range.end;
        let start = self.contents.start();
        start.get(range.clone()).ok_or_else(|| {
            self.context
                .truncated("data elements", range.end as u64, start.len() as u64)
        })
    }

    fn bad(&self, field: &str, value: String, expected: &str) -> IoError {
        self.context.field(field, value, self.at as u64, expected)
    }
}

/// The number in up to four bytes.
pub(super) fn unsigned(bytes: &[u8], endian: Endian) -> u32 {
    let fold = |number: u32, &byte: &u8| number << 8 | u32::from(byte);
    match endian {
        Endian::Little => bytes.iter().rev().fold(0, fold),
        Endian::Big => bytes.iter().fold(0, fold),
    }
}

/// `(0028,0010)`.
pub(super) fn name(tag: Tag) -> String {
    format!("({:04X},{:04X})", tag >> 16, tag & 0xffff)
}

/// Text without the padding of its end. Only ASCII matters here; other characters are shown as they come.
pub(super) fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes)
        .trim_matches(['\0', ' '])
        .to_owned()
}
