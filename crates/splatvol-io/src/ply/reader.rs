//! The rows of a PLY file.

use std::io::BufRead;
use std::path::Path;

use super::header::{Kind, Scalar};
use super::{Element, Encoding, Header};
use crate::IoError;
use crate::error::Context;
use crate::source::{Rest, Source};

/// Bytes of rows that are decoded at a time.
const CHUNK: usize = 1 << 16;
/// Longest word of a text; numbers have at most some twenty characters.
const LONGEST_WORD: usize = 400;

/// Columns of an element by name.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Table {
    columns: Vec<(String, Vec<f64>)>,
}

impl Table {
    /// The column of that name, one value per row.
    pub(crate) fn column(&self, name: &str) -> Option<&[f64]> {
        let (_, values) = self.columns.iter().find(|(column, _)| column == name)?;
        Some(values)
    }
}

/// A PLY file whose rows are read in the order of the file.
pub(crate) struct Reader<'a> {
    header: Header,
    source: Source<'a>,
    context: Context<'a>,
    /// Elements before this one have been read or skipped.
    next: usize,
    position: u64,
}

impl<'a> Reader<'a> {
    /// Opens a file and reads its header.
    pub(crate) fn open(path: &'a Path) -> Result<Self, IoError> {
        Self::new(Source::open(path)?, Context::new("PLY", path))
    }

    /// The header from a source that begins with it.
    pub(crate) fn new(mut source: Source<'a>, context: Context<'a>) -> Result<Self, IoError> {
        let header = Header::read(&mut source, &context)?;
        let position = header.length;
        Ok(Self {
            header,
            source,
            context,
            next: 0,
            position,
        })
    }

    /// Contents of the header.
    pub(crate) fn header(&self) -> &Header {
        &self.header
    }

    /// The wanted columns of an element; memory for all of them at once.
    pub(crate) fn table(&mut self, element: &str, columns: &[&str]) -> Result<Table, IoError> {
        let mut values = vec![Vec::new(); columns.len()];
        self.rows(element, columns, |_, row| {
            for (values, value) in values.iter_mut().zip(row) {
                values.push(*value);
            }
            Ok(())
        })?;
        let names = columns.iter().map(|name| (*name).to_owned());
        Ok(Table {
            columns: names.zip(values).collect(),
        })
    }

    /// Calls `each` with the index and the wanted columns of every row of an element. Elements that come before it in
    /// the file are skipped; one that has been read or skipped cannot be read again.
    pub(crate) fn rows(
        &mut self,
        element: &str,
        columns: &[&str],
        mut each: impl FnMut(u64, &[f64]) -> Result<(), IoError>,
    ) -> Result<(), IoError> {
        self.listed(element, columns, None, |index, row, _| each(index, row))
    }

    /// As [`Reader::rows`], with the numbers of the property `list` of every row, which is a list.
    pub(crate) fn rows_and_lists(
        &mut self,
        element: &str,
        (columns, list): (&[&str], &str),
        each: impl FnMut(u64, &[f64], &[f64]) -> Result<(), IoError>,
    ) -> Result<(), IoError> {
        self.listed(element, columns, Some(list), each)
    }

    fn listed(
        &mut self,
        element: &str,
        columns: &[&str],
        list: Option<&str>,
        mut each: impl FnMut(u64, &[f64], &[f64]) -> Result<(), IoError>,
    ) -> Result<(), IoError> {
        let ahead = self.header.elements.get(self.next..).unwrap_or_default();
        let index = ahead.iter().position(|e| e.name == element).ok_or_else(|| {
            self.context
                .field("element", "(absent)", None, format!("an element \"{element}\""))
        })? + self.next;
        while self.next < index {
            let passed = self.header.elements[self.next].clone();
            self.pass(&passed)?;
            self.next += 1;
        }
        let element = self.header.elements[index].clone();
        let wanted = columns
            .iter()
            .map(|name| {
                element.column(name).ok_or_else(|| {
                    let expected = format!("a scalar property \"{name}\" of element \"{}\"", element.name);
                    self.context.field("property", "(absent)", None, expected)
                })
            })
            .collect::<Result<Vec<_>, _>>()?;
        let list = list.and_then(|list| element.properties.iter().position(|p| p.name == list));
        self.check_count(&element)?;
        self.next += 1;
        match element.stride() {
            Some(stride) if self.header.encoding != Encoding::Ascii => {
                self.strided(&element, stride, &wanted, &mut |index, row| each(index, row, &[]))
            }
            _ => self.sequential(&element, (&wanted, list), &mut each),
        }
    }

    /// Skips the remaining elements, and tells whether more bytes follow.
    pub(crate) fn finish(self) -> Result<Rest, IoError> {
        Ok(match self.excess()? {
            0 => Rest::Nothing,
            _ => Rest::Excess,
        })
    }

    /// Skips the remaining elements. Returns the number of bytes that follow (in text: from the first that is not white
    /// space).
    pub(crate) fn excess(mut self) -> Result<u64, IoError> {
        while let Some(element) = self.header.elements.get(self.next).cloned() {
            self.pass(&element)?;
            self.next += 1;
        }
        if self.header.encoding == Encoding::Ascii {
            self.skip_white()?;
        }
        Ok(self.source.at_most())
    }

    fn pass(&mut self, element: &Element) -> Result<(), IoError> {
        self.check_count(element)?;
        match element.stride() {
            Some(stride) if self.header.encoding != Encoding::Ascii => {
                self.position += element.count * stride as u64;
                self.source.skip(element.count * stride as u64, &self.context)
            }
            _ => self.sequential(element, (&[], None), &mut |_, _, _| Ok(())),
        }
    }

    fn check_count(&self, element: &Element) -> Result<(), IoError> {
        let declared = element.least_bytes(self.header.encoding);
        self.source
            .check_declared("rows of an element", declared, &self.context)
    }

    /// Rows of one length.
    fn strided(
        &mut self,
        element: &Element,
        stride: usize,
        wanted: &[usize],
        each: &mut impl FnMut(u64, &[f64]) -> Result<(), IoError>,
    ) -> Result<(), IoError> {
        if stride == 0 {
            return Ok(());
        }
        let columns = places(element, wanted);
        let big = self.header.encoding == Encoding::BigEndian;
        let per_chunk = (CHUNK / stride).max(1) as u64;
        let mut row = vec![0.0; wanted.len()];
        let mut index = 0;
        while index < element.count {
            let rows = per_chunk.min(element.count - index);
            let bytes = rows * stride as u64;
            let chunk = self.source.read_bytes("rows", bytes, &self.context)?;
            self.position += bytes;
            for bytes in chunk.chunks_exact(stride) {
                for (value, &(place, scalar)) in row.iter_mut().zip(&columns) {
                    *value = decode(scalar, &bytes[place..place + scalar.size()], big);
                }
                each(index, &row)?;
                index += 1;
            }
        }
        Ok(())
    }

    /// Rows of text, or with lists.
    fn sequential(
        &mut self,
        element: &Element,
        (wanted, wanted_list): (&[usize], Option<usize>),
        each: &mut impl FnMut(u64, &[f64], &[f64]) -> Result<(), IoError>,
    ) -> Result<(), IoError> {
        if element.properties.is_empty() {
            return Ok(());
        }
        let mut values = vec![0.0; element.properties.len()];
        let mut list = Vec::new();
        let mut row = vec![0.0; wanted.len()];
        for index in 0..element.count {
            for (column, (value, property)) in values.iter_mut().zip(&element.properties).enumerate() {
                match property.kind {
                    Kind::Scalar(scalar) => *value = self.number(scalar, &property.name)?,
                    Kind::List { count, item } if wanted_list == Some(column) => {
                        self.read_list((count, item), &property.name, &mut list)?;
                    }
                    Kind::List { count, item } => self.pass_list(count, item, &property.name)?,
                }
            }
            for (value, &column) in row.iter_mut().zip(wanted) {
                *value = values[column];
            }
            each(index, &row, &list)?;
        }
        Ok(())
    }

    fn list_length(&mut self, count: Scalar, name: &str) -> Result<u64, IoError> {
        let at = self.position;
        let length = self.number(count, name)?;
        if length < 0.0 || length.fract() != 0.0 {
            return Err(self.context.field(name, length, at, "a list's length"));
        }
        Ok(length as u64)
    }

    /// Replaces the contents of `list`. It grows only as numbers come.
    fn read_list(
        &mut self,
        (count, item): (Scalar, Scalar),
        name: &str,
        list: &mut Vec<f64>,
    ) -> Result<(), IoError> {
        list.clear();
        for _ in 0..self.list_length(count, name)? {
            list.push(self.number(item, name)?);
        }
        Ok(())
    }

    fn pass_list(&mut self, count: Scalar, item: Scalar, name: &str) -> Result<(), IoError> {
        let length = self.list_length(count, name)?;
        if self.header.encoding == Encoding::Ascii {
            for _ in 0..length {
                self.number(item, name)?;
            }
            return Ok(());
        }
        self.position += length * item.size() as u64;
        self.source.skip(length * item.size() as u64, &self.context)
    }

    fn number(&mut self, scalar: Scalar, name: &str) -> Result<f64, IoError> {
        if self.header.encoding == Encoding::Ascii {
            return self.word(scalar, name);
        }
        let mut bytes = [0; 8];
        let bytes = &mut bytes[..scalar.size()];
        let read = self.source.fill(bytes, &self.context)?;
        if read < bytes.len() {
            return Err(self.context.truncated("rows", bytes.len() as u64, read as u64));
        }
        self.position += read as u64;
        Ok(decode(scalar, bytes, self.header.encoding == Encoding::BigEndian))
    }

    /// The next number of a text. Line breaks do not matter: the header gives the number of values per row.
    fn word(&mut self, scalar: Scalar, name: &str) -> Result<f64, IoError> {
        self.skip_white()?;
        let offset = self.position;
        let mut word = [0; LONGEST_WORD];
        let mut length = 0;
        loop {
            let buffer = self.source.peek(&self.context)?;
            let part = buffer.iter().position(u8::is_ascii_whitespace);
            let taken = part.unwrap_or(buffer.len()).min(LONGEST_WORD - length);
            word[length..length + taken].copy_from_slice(&buffer[..taken]);
            let done = part == Some(taken) || buffer.is_empty() || length + taken == LONGEST_WORD;
            self.source.consume(taken);
            self.position += taken as u64;
            length += taken;
            if done {
                break;
            }
        }
        let text = String::from_utf8_lossy(&word[..length]);
        let number = text.parse().ok().filter(|&number| fits(scalar, number));
        number.ok_or_else(|| {
            let expected = format!("a number of type {scalar:?}");
            self.context.field(name, text, offset, expected)
        })
    }

    fn skip_white(&mut self) -> Result<(), IoError> {
        loop {
            let buffer = self.source.peek(&self.context)?;
            let white = buffer.iter().take_while(|b| b.is_ascii_whitespace()).count();
            let all = white == buffer.len();
            self.source.consume(white);
            self.position += white as u64;
            if !all || white == 0 {
                return Ok(());
            }
        }
    }
}

/// Whether a type can hold a number: a colour of 300 in a byte would be another one.
fn fits(scalar: Scalar, number: f64) -> bool {
    let whole = |low: f64, high: f64| number.fract() == 0.0 && (low..=high).contains(&number);
    match scalar {
        Scalar::I8 => whole(i8::MIN.into(), i8::MAX.into()),
        Scalar::U8 => whole(0.0, u8::MAX.into()),
        Scalar::I16 => whole(i16::MIN.into(), i16::MAX.into()),
        Scalar::U16 => whole(0.0, u16::MAX.into()),
        Scalar::I32 => whole(i32::MIN.into(), i32::MAX.into()),
        Scalar::U32 => whole(0.0, u32::MAX.into()),
        Scalar::F32 | Scalar::F64 => true,
    }
}

/// Byte offsets in a row and types of the wanted columns; none of the properties are lists.
fn places(element: &Element, wanted: &[usize]) -> Vec<(usize, Scalar)> {
    let mut place = 0;
    let mut all = Vec::with_capacity(element.properties.len());
    for property in &element.properties {
        let (Kind::Scalar(scalar) | Kind::List { count: scalar, .. }) = property.kind;
        all.push((place, scalar));
        place += scalar.size();
    }
    wanted.iter().map(|&column| all[column]).collect()
}

/// The number that `bytes`, as many as the type has, stand for.
#[inline]
fn decode(scalar: Scalar, bytes: &[u8], big: bool) -> f64 {
    let mut little = [0; 8];
    for (to, from) in little.iter_mut().zip(bytes) {
        *to = *from;
    }
    if big {
        little[..bytes.len()].reverse();
    }
    let [a, b, c, d, ..] = little;
    match scalar {
        Scalar::I8 => f64::from(a as i8),
        Scalar::U8 => f64::from(a),
        Scalar::I16 => f64::from(i16::from_le_bytes([a, b])),
        Scalar::U16 => f64::from(u16::from_le_bytes([a, b])),
        Scalar::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
        Scalar::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
        Scalar::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
        Scalar::F64 => f64::from_le_bytes(little),
    }
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
