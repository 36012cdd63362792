//! The header of a .npy array: a Python dictionary literal such as
//! `{'descr': '<i2', 'fortran_order': False, 'shape': (256, 128, 128), }` (numpy's `lib.format`).

use crate::error::Context;
use crate::source::Source;
use crate::{Endian, IoError, SampleType};

const MAGIC: &[u8] = b"\x93NUMPY";
/// The library itself refuses to read headers above 10 000 bytes.
const MAX_HEADER: u64 = 1 << 16;
/// Deepest nesting of lists and tuples.
const MAX_DEPTH: usize = 8;

/// Type of the elements of an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ElementType {
    Number(SampleType),
    /// IEEE 754 binary16.
    Half,
}

impl ElementType {
    /// The type as stored in the file.
    pub(super) fn stored(self) -> SampleType {
        match self {
            Self::Number(sample_type) => sample_type,
            Self::Half => SampleType::U16,
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Number(sample_type) => sample_type.name(),
            Self::Half => "f16",
        }
    }
}

/// Contents of the header.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Header {
    pub(super) element: ElementType,
    pub(super) endian: Endian,
    pub(super) fortran_order: bool,
    pub(super) shape: Vec<u64>,
    /// Version of the format.
    pub(super) version: [u8; 2],
}

impl Header {
    /// Reads magic, version, length and dictionary; the samples follow in `source`.
    pub(super) fn read(source: &mut Source<'_>, context: &Context<'_>) -> Result<Self, IoError> {
        let start = source.read_bytes("magic and version", 8, context)?;
        let (magic, version) = start.split_at(6);
        if magic != MAGIC {
            return Err(context.field("magic", magic.escape_ascii(), 0, "\\x93NUMPY"));
        }
        let version = [version[0], version[1]];
        let width = match version[0] {
            1 => 2,
            2 | 3 => 4,
            _ => {
                let found = format!("{}.{}", version[0], version[1]);
                return Err(context.field("version", found, 6, "1.0, 2.0 or 3.0"));
            }
        };
        let length = source.read_bytes("header length", width, context)?;
        let length = length
            .iter()
            .rev()
            .fold(0, |length, &byte| length << 8 | u64::from(byte));
        if length > MAX_HEADER {
            return Err(context.field("header length", length, 8, format!("at most {MAX_HEADER}")));
        }
        let text = source.read_bytes("header", length, context)?;
        let text = String::from_utf8_lossy(&text);
        let offset = 8 + width;
        let literal = Literal::parse(&text)
            .ok_or_else(|| context.field("header", &text, offset, "a Python dictionary of plain values"))?;
        Self::from_literal(&literal, version, offset, context)
    }

    fn from_literal(
        literal: &Literal,
        version: [u8; 2],
        offset: u64,
        context: &Context<'_>,
    ) -> Result<Self, IoError> {
        let entry = |key: &str| literal.entry(key).unwrap_or(&Literal::None);
        let fail =
            |key: &str, expected| Err(context.field(key, format!("{:?}", entry(key)), offset, expected));
        let (element, endian) = match entry("descr") {
            Literal::Text(descr) => element_type(descr, offset, context)?,
            Literal::List(_) => return Err(context.unsupported("an array of records; save one field of it")),
            _ => return fail("descr", "a type such as '<f4'"),
        };
        let Literal::Bool(fortran_order) = *entry("fortran_order") else {
            return fail("fortran_order", "True or False");
        };
        let shape = match entry("shape") {
            Literal::List(sizes) => sizes.iter().map(Literal::integer).collect::<Option<Vec<u64>>>(),
            _ => None,
        };
        let Some(shape) = shape else {
            return fail("shape", "a tuple of sizes");
        };
        Ok(Self {
            element,
            endian,
            fortran_order,
            shape,
            version,
        })
    }

    /// The shape as Python writes it.
    pub(super) fn shape_text(&self) -> String {
        let sizes: Vec<String> = self.shape.iter().map(u64::to_string).collect();
        match sizes.as_slice() {
            [one] => format!("({one},)"),
            _ => format!("({})", sizes.join(", ")),
        }
    }
}

fn element_type(descr: &str, offset: u64, context: &Context<'_>) -> Result<(ElementType, Endian), IoError> {
    let (endian, code) = match descr.split_at_checked(1) {
        Some(("<", code)) => (Endian::Little, code),
        Some((">", code)) => (Endian::Big, code),
        Some(("|" | "=", code)) => (Endian::NATIVE, code),
        _ => (Endian::NATIVE, descr),
    };
    use SampleType as T;
    // The digit counts bytes: `u8` is a 64-bit integer.
    let element = ElementType::Number(match code {
        "f2" => return Ok((ElementType::Half, endian)),
        "b1" | "?" | "u1" => T::U8,
        "i1" => T::I8,
        "u2" => T::U16,
        "i2" => T::I16,
        "u4" => T::U32,
        "i4" => T::I32,
        "u8" => T::U64,
        "i8" => T::I64,
        "f4" => T::F32,
        "f8" => T::F64,
        "O" | "O8" | "O4" => {
            return Err(context.unsupported("an array of Python objects, which only Python can unpickle"));
        }
        _ => {
            let expected = "a boolean, integer or real type of up to 8 bytes";
            return Err(context.field("descr", descr, offset, expected));
        }
    });
    Ok((element, endian))
}

/// The values that a header may hold.
#[derive(Debug, Clone, PartialEq)]
enum Literal {
    Text(String),
    Bool(bool),
    Integer(u64),
    /// A list or a tuple.
    List(Vec<Literal>),
    Dictionary(Vec<(Literal, Literal)>),
    None,
}

impl Literal {
    fn parse(text: &str) -> Option<Self> {
        let mut parser = Parser { rest: text, depth: 0 };
        let value = parser.value()?;
        parser.rest.trim().is_empty().then_some(value)
    }

    fn entry(&self, key: &str) -> Option<&Self> {
        let Self::Dictionary(entries) = self else {
            return None;
        };
        entries
            .iter()
            .find_map(|(name, value)| matches!(name, Self::Text(name) if name == key).then_some(value))
    }

    fn integer(&self) -> Option<u64> {
        match self {
            Self::Integer(value) => Some(*value),
            _ => None,
        }
    }
}

struct Parser<'a> {
    rest: &'a str,
    depth: usize,
}

impl Parser<'_> {
    fn value(&mut self) -> Option<Literal> {
        self.rest = self.rest.trim_start();
        let first = self.rest.chars().next()?;
        match first {
            '\'' | '"' => {
                let (text, rest) = self.rest[1..].split_once(first)?;
                self.rest = rest;
                (!text.contains('\\')).then(|| Literal::Text(text.to_owned()))
            }
            '(' => self.sequence(')', Self::value).map(Literal::List),
            '[' => self.sequence(']', Self::value).map(Literal::List),
            '{' => self.sequence('}', Self::pair).map(Literal::Dictionary),
            _ => self.word(),
        }
    }

    fn word(&mut self) -> Option<Literal> {
        let end = self
            .rest
            .find(|c: char| !c.is_ascii_alphanumeric())
            .unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        match word {
            "True" => Some(Literal::Bool(true)),
            "False" => Some(Literal::Bool(false)),
            "None" => Some(Literal::None),
            // Python 2 wrote long integers as `256L`.
            _ => word.trim_end_matches('L').parse().ok().map(Literal::Integer),
        }
    }

    fn pair(&mut self) -> Option<(Literal, Literal)> {
        let key = self.value()?;
        self.skip(':').then_some(())?;
        Some((key, self.value()?))
    }

    /// Items separated by commas, up to `close`; a comma may follow the last.
    fn sequence<T>(&mut self, close: char, item: fn(&mut Self) -> Option<T>) -> Option<Vec<T>> {
        self.rest = &self.rest[1..];
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return None;
        }
        let mut items = Vec::new();
        while !self.skip(close) {
            items.push(item(self)?);
            if !self.skip(',') {
                self.skip(close).then_some(())?;
                break;
            }
        }
        self.depth -= 1;
        Some(items)
    }

    fn skip(&mut self, token: char) -> bool {
        self.rest = self.rest.trim_start();
        let found = self.rest.strip_prefix(token);
        self.rest = found.unwrap_or(self.rest);
        found.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn header(text: &str) -> Result<Header, IoError> {
        let context = Context::new("NPY", Path::new("a.npy"));
        let length = (text.len() as u16).to_le_bytes();
        let bytes = [b"\x93NUMPY\x01\x00", &length[..], text.as_bytes()].concat();
        Header::read(&mut Source::from_bytes(&bytes), &context)
    }

    #[test]
    fn python_2_and_3_headers_are_read() {
        let read = header("{'descr': '>i2', 'fortran_order': False, 'shape': (3L, 4L, 5L), }   \n").unwrap();
        assert_eq!(read.shape, [3, 4, 5]);
        assert_eq!(
            (read.element, read.endian),
            (ElementType::Number(SampleType::I16), Endian::Big)
        );
        let read = header("{\"shape\":(7,),\"fortran_order\":True,\"descr\":\"|b1\"}").unwrap();
        assert_eq!((read.shape_text().as_str(), read.fortran_order), ("(7,)", true));
        assert_eq!(read.element, ElementType::Number(SampleType::U8));
    }

    #[test]
    fn what_is_no_plain_array_is_refused_with_its_reason() {
        let cases = [
            (
                "{'descr': '|O', 'fortran_order': False, 'shape': (1,)}",
                "Python objects",
            ),
            (
                "{'descr': [('a', '<f4')], 'fortran_order': False, 'shape': (1,)}",
                "records",
            ),
            ("{'descr': '<c8', 'fortran_order': False, 'shape': (1,)}", "descr"),
            ("{'descr': '<U8', 'fortran_order': False, 'shape': (1,)}", "descr"),
            (
                "{'descr': '<f16', 'fortran_order': False, 'shape': (1,)}",
                "descr",
            ),
            ("{'descr': '<f3', 'fortran_order': False, 'shape': (1,)}", "descr"),
            (
                "{'descr': '<f4', 'fortran_order': 0, 'shape': (1,)}",
                "fortran_order",
            ),
            (
                "{'descr': '<f4', 'fortran_order': False, 'shape': (-1,)}",
                "header",
            ),
            ("{'descr': '<f4', 'fortran_order': False, 'shape': 5}", "shape"),
            (
                "{'descr': '<f4', 'fortran_order': False, 'shape': (99999999999999999999,)}",
                "header",
            ),
            ("{'descr': '<f4', 'fortran_order': False}", "shape"),
            (
                "{'descr': '<f4', 'fortran_order': False, 'shape': (1,)} x",
                "header",
            ),
            ("((((((((((((1))))))))))))", "header"),
            ("{'é': 'x\\''}", "header"),
            ("", "header"),
        ];
        for (text, expected) in cases {
            let error = header(text).unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
