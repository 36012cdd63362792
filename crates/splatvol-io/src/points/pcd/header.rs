//! The header of a PCD file: lines of a keyword and its values, up to `DATA`.

use crate::IoError;
use crate::error::Context;

/// Longest header that is read, bytes.
const LONGEST: usize = 1 << 16;

/// Storage of the points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Data {
    Ascii,
    Binary,
    Compressed,
}

impl Data {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Ascii => "ascii",
            Self::Binary => "binary",
            Self::Compressed => "binary_compressed",
        }
    }
}

/// A field of every point.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Field {
    pub(super) name: String,
    /// `I`, `U` or `F`.
    pub(super) kind: char,
    /// Bytes of a number.
    pub(super) size: usize,
    /// Numbers of the field; the first counts.
    pub(super) count: usize,
    /// Byte in a point.
    pub(super) place: usize,
    /// Number in a line of text.
    pub(super) column: usize,
}

impl Field {
    /// The number that the bytes begin with.
    pub(super) fn decode(&self, bytes: &[u8]) -> Option<f64> {
        let mut eight = [0; 8];
        eight[..self.size].copy_from_slice(bytes.get(..self.size)?);
        let [a, b, c, d, ..] = eight;
        Some(match (self.kind, self.size) {
            ('F', 4) => f64::from(f32::from_le_bytes([a, b, c, d])),
            ('F', _) => f64::from_le_bytes(eight),
            ('I', 1) => f64::from(a as i8),
            ('I', 2) => f64::from(i16::from_le_bytes([a, b])),
            ('I', 4) => f64::from(i32::from_le_bytes([a, b, c, d])),
            ('I', _) => i64::from_le_bytes(eight) as f64,
            _ => u64::from_le_bytes(eight) as f64,
        })
    }

    /// The number that a word stands for.
    pub(super) fn parse(&self, word: &str) -> Option<f64> {
        word.parse().ok()
    }
}

/// Contents of the header.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Header {
    pub(super) version: String,
    pub(super) fields: Vec<Field>,
    /// Bytes of a point.
    pub(super) stride: usize,
    /// Numbers of a point.
    pub(super) width: usize,
    pub(super) points: u64,
    pub(super) viewpoint: Option<[f64; 3]>,
    pub(super) data: Data,
    /// Bytes of the header; the points begin here.
    pub(super) length: usize,
}

/// True if a file begins as PCD does: comments, then a version or fields.
pub(in crate::points) fn is_header(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    text.lines()
        .find(|line| !line.starts_with('#') && !line.trim().is_empty())
        .is_some_and(|line| line.starts_with("VERSION") || line.starts_with("FIELDS"))
}

#[derive(Default)]
struct Lines<'a> {
    version: &'a str,
    names: Vec<&'a str>,
    sizes: Vec<&'a str>,
    kinds: Vec<&'a str>,
    counts: Vec<&'a str>,
    numbers: [Option<u64>; 3],
    viewpoint: Vec<&'a str>,
}

impl Header {
    pub(super) fn parse(bytes: &[u8], context: &Context<'_>) -> Result<Self, IoError> {
        let mut lines = Lines::default();
        let mut position = 0;
        let data = loop {
            let rest = &bytes[position..];
            let end = rest
                .iter()
                .position(|&byte| byte == b'\n')
                .filter(|end| position + end < LONGEST);
            let Some(end) = end else {
                return Err(context.field(
                    "header",
                    "no DATA line",
                    position as u64,
                    "a header that ends with DATA",
                ));
            };
            let offset = position as u64;
            position += end + 1;
            let Ok(line) = str::from_utf8(&rest[..end]) else {
                return Err(context.field("header", "not text", offset, "a keyword and its values"));
            };
            let mut words = line.split_whitespace();
            let keyword = words.next().unwrap_or("#");
            let values: Vec<&str> = words.collect();
            if let Some(data) = lines.take(keyword, values, offset, context)? {
                break data;
            }
        };
        let fields = lines.fields(context)?;
        let [width, height, points] = lines.numbers;
        let product = width
            .zip(height)
            .map(|(width, height)| width.saturating_mul(height));
        let points = match (points, product) {
            (Some(points), Some(product)) if points != product => {
                let expected = format!("{product}, WIDTH times HEIGHT");
                return Err(context.field("POINTS", points, None, expected));
            }
            (points, product) => points
                .or(product)
                .ok_or_else(|| context.field("POINTS", "(absent)", None, "POINTS, or WIDTH and HEIGHT"))?,
        };
        Ok(Self {
            version: lines.version.to_owned(),
            stride: fields.iter().map(|field| field.size * field.count).sum(),
            width: fields.iter().map(|field| field.count).sum(),
            fields,
            points,
            viewpoint: lines.viewpoint(context)?,
            data,
            length: position,
        })
    }

    /// Bytes of all points.
    pub(super) fn byte_count(&self, context: &Context<'_>) -> Result<usize, IoError> {
        let bytes = self.points.saturating_mul(self.stride as u64);
        usize::try_from(bytes).map_err(|_| context.limit(bytes, usize::MAX as u64))
    }
}

impl<'a> Lines<'a> {
    /// Consumes a line; returns the value of `DATA`.
    fn take(
        &mut self,
        keyword: &str,
        values: Vec<&'a str>,
        offset: u64,
        context: &Context<'_>,
    ) -> Result<Option<Data>, IoError> {
        let wrong =
            |values: &[&str], expected: &str| context.field(keyword, values.join(" "), offset, expected);
        match keyword {
            "VERSION" => self.version = values.first().copied().unwrap_or_default(),
            "FIELDS" | "COLUMNS" => self.names = values,
            "SIZE" => self.sizes = values,
            "TYPE" => self.kinds = values,
            "COUNT" => self.counts = values,
            "VIEWPOINT" => self.viewpoint = values,
            "WIDTH" | "HEIGHT" | "POINTS" => {
                let slot = ["WIDTH", "HEIGHT", "POINTS"]
                    .iter()
                    .position(|name| *name == keyword);
                let number = match values.as_slice() {
                    [number] => number.parse().ok(),
                    _ => None,
                };
                let number = number.ok_or_else(|| wrong(&values, "a whole number"))?;
                self.numbers[slot.unwrap_or(0)] = Some(number);
            }
            "DATA" => {
                return match values.as_slice() {
                    ["ascii"] => Ok(Some(Data::Ascii)),
                    ["binary"] => Ok(Some(Data::Binary)),
                    ["binary_compressed"] => Ok(Some(Data::Compressed)),
                    _ => Err(wrong(&values, "ascii, binary or binary_compressed")),
                };
            }
            _ if keyword.starts_with('#') => {}
            _ => return Err(wrong(&values, "a keyword of PCD 0.5 to 0.7")),
        }
        Ok(None)
    }

    fn fields(&self, context: &Context<'_>) -> Result<Vec<Field>, IoError> {
        let count = self.names.len();
        let ones = vec!["1"; count];
        let counts = if self.counts.is_empty() {
            &ones
        } else {
            &self.counts
        };
        for (keyword, values) in [("SIZE", &self.sizes), ("TYPE", &self.kinds), ("COUNT", counts)] {
            if values.len() != count || count == 0 {
                let expected = format!("one value for each of the {count} FIELDS");
                return Err(context.field(keyword, values.join(" "), None, expected));
            }
        }
        let (mut place, mut column) = (0, 0);
        let mut fields = Vec::with_capacity(count);
        for (index, name) in self.names.iter().enumerate() {
            let (size, kind, count) = (self.sizes[index], self.kinds[index], counts[index]);
            let wrong = |keyword: &str, value: &str, expected| context.field(keyword, value, None, expected);
            let kind = match kind {
                "I" | "U" | "F" => kind.chars().next().unwrap_or('F'),
                _ => return Err(wrong("TYPE", kind, "I, U or F")),
            };
            let size = match size {
                "1" | "2" if kind != 'F' => usize::from(size == "2") + 1,
                "4" => 4,
                "8" => 8,
                _ => return Err(wrong("SIZE", size, "1, 2, 4 or 8 bytes, of floats 4 or 8")),
            };
            let count: u16 = count
                .parse()
                .ok()
                .filter(|&count| count > 0)
                .ok_or_else(|| wrong("COUNT", count, "1 to 65535"))?;
            let count = usize::from(count);
            fields.push(Field {
                name: (*name).to_owned(),
                kind,
                size,
                count,
                place,
                column,
            });
            place += size * count;
            column += count;
        }
        Ok(fields)
    }

    /// The place of a viewpoint other than the default.
    fn viewpoint(&self, context: &Context<'_>) -> Result<Option<[f64; 3]>, IoError> {
        if self.viewpoint.is_empty() {
            return Ok(None);
        }
        let numbers: Option<Vec<f64>> = self
            .viewpoint
            .iter()
            .map(|word| word.parse().ok().filter(|n: &f64| n.is_finite()))
            .collect();
        match numbers.as_deref() {
            Some([x, y, z, w, a, b, c]) => {
                let default = [*x, *y, *z, *w, *a, *b, *c] == [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
                Ok((!default).then_some([*x, *y, *z]))
            }
            _ => Err(context.field("VIEWPOINT", self.viewpoint.join(" "), None, "seven numbers")),
        }
    }
}
