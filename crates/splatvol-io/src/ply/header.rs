//! The header of a PLY file: text lines from `ply` to `end_header`.

use std::io::BufRead;

use crate::IoError;
use crate::error::{Context, excerpt};
use crate::source::Source;

/// Longest header that is read, bytes.
const LONGEST: usize = 1 << 20;

/// Encoding of the rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

impl Encoding {
    /// The name in the header.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Ascii => "ascii",
            Self::LittleEndian => "binary_little_endian",
            Self::BigEndian => "binary_big_endian",
        }
    }
}

/// Type of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// The name of Turk's paper.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::I8 => "char",
            Self::U8 => "uchar",
            Self::I16 => "short",
            Self::U16 => "ushort",
            Self::I32 => "int",
            Self::U32 => "uint",
            Self::F32 => "float",
            Self::F64 => "double",
        }
    }

    /// Bytes in binary files.
    pub(crate) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// Type of a property.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Scalar(Scalar),
    List { count: Scalar, item: Scalar },
}

/// A column of an element.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Property {
    pub(crate) name: String,
    pub(crate) kind: Kind,
}

/// A table of rows: `vertex`, `face`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Element {
    pub(crate) name: String,
    pub(crate) count: u64,
    pub(crate) properties: Vec<Property>,
}

impl Element {
    /// Index of the scalar property of that name.
    pub(crate) fn column(&self, name: &str) -> Option<usize> {
        self.properties
            .iter()
            .position(|p| p.name == name && matches!(p.kind, Kind::Scalar(_)))
    }

    /// True where the element has a scalar property of that name.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.column(name).is_some()
    }

    /// The first of these names that a property has which is a list.
    pub(crate) fn list<'a>(&self, names: &[&'a str]) -> Option<&'a str> {
        let is_list = |name: &&&str| {
            let mut properties = self.properties.iter();
            properties.any(|p| p.name == **name && matches!(p.kind, Kind::List { .. }))
        };
        names.iter().find(is_list).copied()
    }

    /// Type of the scalar property of that name.
    pub(crate) fn scalar(&self, name: &str) -> Option<Scalar> {
        match self.properties.get(self.column(name)?)?.kind {
            Kind::Scalar(scalar) => Some(scalar),
            Kind::List { .. } => None,
        }
    }

    /// Bytes of a row, of binary files without lists.
    pub(crate) fn stride(&self) -> Option<usize> {
        let size = |property: &Property| match property.kind {
            Kind::Scalar(scalar) => Some(scalar.size()),
            Kind::List { .. } => None,
        };
        self.properties.iter().map(size).sum()
    }

    /// The least number of bytes that the rows can take.
    pub(crate) fn least_bytes(&self, encoding: Encoding) -> u64 {
        let least = |property: &Property| match (encoding, property.kind) {
            (Encoding::Ascii, _) => 2,
            (_, Kind::Scalar(scalar) | Kind::List { count: scalar, .. }) => scalar.size() as u64,
        };
        let bytes = self
            .count
            .saturating_mul(self.properties.iter().map(least).sum::<u64>());
        // The last line of a text needs no end.
        bytes.saturating_sub(u64::from(encoding == Encoding::Ascii && bytes > 0))
    }
}

/// Contents of the header.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Header {
    pub(crate) encoding: Encoding,
    /// Elements in the order of their rows in the file.
    pub(crate) elements: Vec<Element>,
    /// Texts of `comment` and `obj_info` lines.
    pub(crate) comments: Vec<String>,
    /// Bytes of the header; the rows begin here.
    pub(crate) length: u64,
}

impl Header {
    /// Reads a header and nothing that follows it.
    pub(crate) fn read(source: &mut Source<'_>, context: &Context<'_>) -> Result<Self, IoError> {
        let mut lines = Lines::new(source, context);
        let magic = lines.next()?;
        if magic.text.trim_end() != "ply" {
            return Err(context.field("first line", &magic.text, 0, "ply"));
        }
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        let mut comments = Vec::new();
        loop {
            let line = lines.next()?;
            let words: Vec<&str> = line.text.split_whitespace().collect();
            let wrong = |field: &str, expected: &str| context.field(field, &line.text, line.offset, expected);
            match words.as_slice() {
                [] => {}
                ["end_header"] => break,
                ["comment" | "obj_info", ..] => {
                    let text = line.text.split_once(char::is_whitespace).unwrap_or_default().1;
                    comments.push(text.trim().to_owned());
                }
                ["format", name, version] => {
                    encoding = Some(parse_encoding(name, version).ok_or_else(|| {
                        wrong(
                            "format",
                            "ascii, binary_little_endian or binary_big_endian, and 1.0",
                        )
                    })?);
                }
                ["element", name, count] => {
                    let count = count
                        .parse()
                        .map_err(|_| wrong("element", "a name and a count"))?;
                    elements.push(Element {
                        name: (*name).to_owned(),
                        count,
                        properties: Vec::new(),
                    });
                }
                ["property", words @ ..] => {
                    let property = parse_property(words).ok_or_else(|| {
                        wrong(
                            "property",
                            "TYPE NAME or list TYPE TYPE NAME, of the eight PLY types",
                        )
                    })?;
                    let element = elements
                        .last_mut()
                        .ok_or_else(|| wrong("property", "an element before it"))?;
                    element.properties.push(property);
                }
                _ => {
                    return Err(wrong(
                        "header line",
                        "format, element, property, comment, obj_info or end_header",
                    ));
                }
            }
        }
        let length = lines.position;
        let encoding = encoding.ok_or_else(|| context.field("format", "(absent)", None, "a format line"))?;
        Ok(Self {
            encoding,
            elements,
            comments,
            length,
        })
    }

    /// The element of that name.
    pub(crate) fn element(&self, name: &str) -> Option<&Element> {
        self.elements.iter().find(|element| element.name == name)
    }
}

fn parse_encoding(name: &str, version: &str) -> Option<Encoding> {
    [Encoding::Ascii, Encoding::LittleEndian, Encoding::BigEndian]
        .into_iter()
        .find(|encoding| encoding.name() == name && version == "1.0")
}

fn parse_property(words: &[&str]) -> Option<Property> {
    let (kind, name) = match words {
        ["list", count, item, name] => {
            let count = Scalar::from_name(count).filter(|c| !matches!(c, Scalar::F32 | Scalar::F64))?;
            let item = Scalar::from_name(item)?;
            (Kind::List { count, item }, name)
        }
        [scalar, name] => (Kind::Scalar(Scalar::from_name(scalar)?), name),
        _ => return None,
    };
    let name = (*name).to_owned();
    Some(Property { name, kind })
}

struct Line {
    text: String,
    offset: u64,
}

/// Lines that end as the first one does: LF, CR LF, or CR alone, behind which binary data may hold any byte.
struct Lines<'s, 'a, 'c> {
    source: &'s mut Source<'a>,
    context: &'c Context<'c>,
    position: u64,
    end: Option<&'static [u8]>,
}

impl<'s, 'a, 'c> Lines<'s, 'a, 'c> {
    fn new(source: &'s mut Source<'a>, context: &'c Context<'c>) -> Self {
        Self {
            source,
            context,
            position: 0,
            end: None,
        }
    }

    fn next(&mut self) -> Result<Line, IoError> {
        let offset = self.position;
        let mut bytes = Vec::new();
        while !self.ended(&bytes)? {
            let Some(&byte) = self.source.peek(self.context)?.first() else {
                let text = excerpt(&String::from_utf8_lossy(&bytes));
                let expected = "a header that ends with \"end_header\"";
                return Err(self.context.field("end of file", text, offset, expected));
            };
            self.take(byte, &mut bytes);
            if self.position > LONGEST as u64 {
                let expected = format!("end_header within {LONGEST} bytes");
                return Err(self
                    .context
                    .field("header", "no end_header", self.position, expected));
            }
        }
        let end = self.end.map_or(0, <[u8]>::len);
        bytes.truncate(bytes.len() - end);
        let text = String::from_utf8_lossy(&bytes).into_owned();
        Ok(Line { text, offset })
    }

    fn take(&mut self, byte: u8, bytes: &mut Vec<u8>) {
        self.source.consume(1);
        self.position += 1;
        bytes.push(byte);
    }

    fn ended(&mut self, bytes: &[u8]) -> Result<bool, IoError> {
        if let Some(end) = self.end {
            return Ok(bytes.ends_with(end));
        }
        self.end = match bytes {
            [.., b'\n'] => Some(b"\n"),
            [.., b'\r'] if self.source.peek(self.context)?.first() == Some(&b'\n') => Some(b"\r\n"),
            [.., b'\r'] => Some(b"\r"),
            _ => None,
        };
        Ok(self.end.is_some_and(|end| bytes.ends_with(end)))
    }
}
