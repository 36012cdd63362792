//! The attributes (`POINT_DATA`, `CELL_DATA`) of a legacy VTK file: a list of arrays and where their data start.
//!
//! Binary data carry no length of their own, so an array can only be found by walking over those before it.

use crate::IoError;
use crate::samples::SampleType;
use crate::volume::vtk_array::{ArrayHead, Association, TupleCounts};

use super::cursor::Cursor;

/// Coding of the numbers of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Coding {
    Ascii,
    Binary,
}

/// Type of bytes that text has as parts of 255. No word of a file is like it.
const SHARES: &str = "unsigned_char, written from 0 to 1";

/// Type of an array's elements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ElementType {
    Number(SampleType),
    /// Eight to the byte in binary files, the first in the highest bit; digits 0 and 1 in text.
    Bit,
    /// Bytes that text has as parts of 255, from 0 to 1.
    Share,
    /// Strings and variants.
    Other,
}

impl ElementType {
    pub(crate) fn from_name(name: &str) -> Self {
        use SampleType as T;
        Self::Number(match name.to_ascii_lowercase().as_str() {
            "bit" => return Self::Bit,
            SHARES => return Self::Share,
            "char" | "signed_char" => T::I8,
            "unsigned_char" => T::U8,
            "short" => T::I16,
            "unsigned_short" => T::U16,
            // VTK writes its ids as 32-bit integers in this format, whatever they are in memory.
            "int" | "vtkidtype" => T::I32,
            "unsigned_int" => T::U32,
            // As on 64-bit Unix.
            "long" | "vtktypeint64" | "long_long" | "__int64" => T::I64,
            "unsigned_long" | "vtktypeuint64" | "unsigned_long_long" | "unsigned___int64" => T::U64,
            "float" => T::F32,
            "double" => T::F64,
            _ => return Self::Other,
        })
    }

    pub(crate) fn sample_type(self) -> Option<SampleType> {
        match self {
            Self::Number(sample_type) => Some(sample_type),
            Self::Bit | Self::Share => Some(SampleType::U8),
            Self::Other => None,
        }
    }
}

/// An array and where its data start.
pub(crate) struct Array {
    pub(crate) element: ElementType,
    pub(crate) start: usize,
}

/// The arrays found. `heads` and `arrays` go together.
#[derive(Default)]
pub(crate) struct Attributes {
    pub(crate) heads: Vec<ArrayHead>,
    pub(crate) arrays: Vec<Array>,
}

/// The declaration line of an attribute.
struct Declaration {
    name: String,
    type_name: String,
    components: u64,
    tuples: u64,
}

/// Walks over the attributes of one file.
pub(crate) struct Scan<'a, 'b> {
    pub(crate) cursor: Cursor<'a>,
    pub(crate) coding: Coding,
    /// Number of points and cells.
    pub(crate) counts: TupleCounts,
    /// Name of the array that is wanted, maybe with a component (`name:1`); none: the point data's first scalars.
    pub(crate) wanted: Option<&'b str>,
    /// Stop at the wanted array: the rest need not be legible.
    pub(crate) stops_early: bool,
    /// Attributes found so far.
    pub(crate) found: Attributes,
}

impl Scan<'_, '_> {
    /// Fills `found`, up to the wanted array or the end.
    ///
    /// # Errors
    /// An attribute that cannot be read; those before it are in `found` all the same.
    pub(crate) fn run(&mut self) -> Result<(), IoError> {
        let mut section = None;
        while let Some(keyword) = self.cursor.word() {
            let keyword = keyword.to_ascii_uppercase();
            match (keyword.as_str(), section) {
                ("POINT_DATA", _) => section = Some(self.section(Association::Point)?),
                ("CELL_DATA", _) => section = Some(self.section(Association::Cell)?),
                ("METADATA", _) => self.cursor.skip_metadata()?,
                (_, Some((association, tuples))) => {
                    self.attribute(&keyword, association, tuples)?;
                    if self.has_wanted() {
                        return Ok(());
                    }
                }
                _ => return Err(self.cursor.error("keyword", &keyword, "POINT_DATA or CELL_DATA")),
            }
        }
        Ok(())
    }

    fn has_wanted(&self) -> bool {
        self.stops_early
            && self.found.heads.last().is_some_and(|head| {
                head.association == Association::Point
                    && match self.wanted {
                        Some(name) if head.components > 1 => name
                            .strip_prefix(head.name.as_str())
                            .is_some_and(|rest| rest.is_empty() || rest.starts_with(':')),
                        Some(name) => head.name == name,
                        None => head.active,
                    }
            })
    }

    fn section(&mut self, association: Association) -> Result<(Association, u64), IoError> {
        let start = self.cursor;
        let count: u64 = self.cursor.number(association.name())?;
        let expected = self.counts.of(association);
        if expected != Some(count) {
            let expected = format!("{} for this geometry", expected.unwrap_or_default());
            return Err(start.error(association.name(), &count.to_string(), expected));
        }
        Ok((association, count))
    }

    fn attribute(&mut self, keyword: &str, association: Association, tuples: u64) -> Result<(), IoError> {
        let start = self.cursor;
        let line = self.cursor.line(keyword)?;
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let word = |index: usize| words.get(index).copied().unwrap_or_default();
        let number = |index: usize| {
            word(index)
                .parse::<u64>()
                .map_err(|_| start.error(keyword, &line, "a number of components or values"))
        };
        let colors = match self.coding {
            Coding::Ascii => SHARES,
            Coding::Binary => "unsigned_char",
        };
        let (type_name, components) = match keyword {
            "SCALARS" => {
                let components = if words.len() > 2 { number(2)? } else { 1 };
                self.skip_lookup_table_name()?;
                (word(1), components)
            }
            "VECTORS" | "NORMALS" => (word(1), 3),
            "TENSORS" => (word(1), 9),
            "TENSORS6" => (word(1), 6),
            "GLOBAL_IDS" | "PEDIGREE_IDS" | "EDGE_FLAGS" => (word(1), 1),
            "TEXTURE_COORDINATES" => (word(2), number(1)?),
            "COLOR_SCALARS" => (colors, number(1)?),
            "LOOKUP_TABLE" => {
                let element = ElementType::from_name(colors);
                return skip(
                    &mut self.cursor,
                    self.coding,
                    element,
                    number(1)?.saturating_mul(4),
                );
            }
            "FIELD" => return self.field(number(1)?, association),
            _ => return Err(start.error("keyword", keyword, "an attribute of a data set")),
        };
        let declaration = Declaration {
            name: decode_name(word(0)),
            type_name: type_name.to_owned(),
            components,
            tuples,
        };
        self.add(declaration, association, keyword)
    }

    /// `LOOKUP_TABLE name` between scalars and their data.
    fn skip_lookup_table_name(&mut self) -> Result<(), IoError> {
        const KEYWORD: &[u8] = b"LOOKUP_TABLE";
        let mut ahead = self.cursor;
        ahead.skip_blanks();
        let found = ahead.rest().get(..KEYWORD.len());
        if found.is_some_and(|found| found.eq_ignore_ascii_case(KEYWORD)) {
            ahead.line("LOOKUP_TABLE")?;
            self.cursor = ahead;
        }
        Ok(())
    }

    fn field(&mut self, count: u64, association: Association) -> Result<(), IoError> {
        for _ in 0..count {
            let start = self.cursor;
            let declaration = field_array(&mut self.cursor)?;
            let expected = self.counts.of(association).unwrap_or_default();
            if declaration.tuples != expected {
                let found = declaration.tuples.to_string();
                return Err(start.error(&declaration.name, &found, format!("{expected} tuples")));
            }
            self.add(declaration, association, "FIELD")?;
            if self.has_wanted() {
                return Ok(());
            }
        }
        Ok(())
    }

    fn add(&mut self, array: Declaration, association: Association, keyword: &str) -> Result<(), IoError> {
        if array.type_name.is_empty() {
            return Err(self.cursor.error("attribute", &array.name, "a name and a type"));
        }
        let element = ElementType::from_name(&array.type_name);
        let components = usize::try_from(array.components)
            .ok()
            .filter(|n| (1..=1 << 16).contains(n));
        let (Some(components), Some(count)) = (components, array.components.checked_mul(array.tuples)) else {
            let found = array.components.to_string();
            return Err(self
                .cursor
                .error("components", &found, format!("1 to 65536 for `{}`", array.name)));
        };
        let first = |head: &ArrayHead| head.association == association && head.active;
        self.found.heads.push(ArrayHead {
            association,
            name: array.name,
            components,
            type_name: array.type_name,
            sample_type: element.sample_type(),
            active: keyword == "SCALARS" && !self.found.heads.iter().any(first),
            is_id: keyword.ends_with("_IDS"),
        });
        self.found.arrays.push(Array {
            element,
            start: self.cursor.position(),
        });
        if self.has_wanted() {
            return Ok(());
        }
        skip(&mut self.cursor, self.coding, element, count)
    }
}

/// Skips the arrays of a field that belongs to the data set as a whole.
pub(crate) fn skip_field(cursor: &mut Cursor<'_>, coding: Coding, count: u64) -> Result<(), IoError> {
    for _ in 0..count {
        let array = field_array(cursor)?;
        let element = ElementType::from_name(&array.type_name);
        skip(
            cursor,
            coding,
            element,
            array.components.saturating_mul(array.tuples),
        )?;
    }
    Ok(())
}

/// The line of an array in a field, after the metadata of the array before it.
fn field_array(cursor: &mut Cursor<'_>) -> Result<Declaration, IoError> {
    let mut name = cursor.word().unwrap_or_default();
    if name.eq_ignore_ascii_case("METADATA") {
        cursor.skip_metadata()?;
        name = cursor.word().unwrap_or_default();
    }
    let [components, tuples] = cursor.numbers("FIELD")?;
    Ok(Declaration {
        name: decode_name(&name),
        type_name: cursor.line("FIELD")?,
        components,
        tuples,
    })
}

fn skip(cursor: &mut Cursor<'_>, coding: Coding, element: ElementType, count: u64) -> Result<(), IoError> {
    match (coding, element) {
        (_, ElementType::Other) => Err(cursor
            .context()
            .unsupported("an array of strings before the chosen one")),
        (Coding::Ascii, _) => cursor.skip_words(count),
        (Coding::Binary, ElementType::Bit) => cursor.skip_bytes(count.div_ceil(8)),
        (Coding::Binary, ElementType::Share) => cursor.skip_bytes(count),
        (Coding::Binary, ElementType::Number(sample_type)) => {
            cursor.skip_bytes(count.saturating_mul(sample_type.size() as u64))
        }
    }
}

/// Names are written with `%20` for a space and the like since version 2.0.
fn decode_name(name: &str) -> String {
    let bytes = name.as_bytes();
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut position = 0;
    while position < bytes.len() {
        let hex = name
            .get(position + 1..position + 3)
            .filter(|_| bytes[position] == b'%')
            .and_then(|hex| u8::from_str_radix(hex, 16).ok());
        decoded.push(hex.unwrap_or(bytes[position]));
        position += if hex.is_some() { 3 } else { 1 };
    }
    String::from_utf8_lossy(&decoded).into_owned()
}
