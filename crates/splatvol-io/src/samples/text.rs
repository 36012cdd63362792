//! Samples written as decimal numbers or hexadecimal digits.

use std::io::{self, BufRead, Read};
use std::str::FromStr;

use splatvol_scene::Samples;

use super::{Endian, SampleBuffer, SampleType};
use crate::IoError;
use crate::error::Context;
use crate::source::Source;

/// Decodes `count` numbers separated by white space or commas. A number outside the type's range is an error.
///
/// `start` is the position of `text` in the file. The last value is the number of bytes used.
pub(crate) fn decode_text(
    text: &[u8],
    sample_type: SampleType,
    count: usize,
    start: u64,
    context: &Context<'_>,
) -> Result<(Samples, Option<String>, usize), IoError> {
    let mut buffer = SampleBuffer::new(sample_type, Endian::NATIVE);
    let used = buffer.read_text(&TextNumbers { text, start }, 0, count, context)?;
    let (samples, warning) = buffer.finish();
    Ok((samples, warning, used))
}

/// Numbers as text, and the position of that text in the file.
pub(crate) struct TextNumbers<'a> {
    pub(crate) text: &'a [u8],
    pub(crate) start: u64,
}

impl<'a> TextNumbers<'a> {
    /// The next number at or after `position`, and its position; `None` at the end.
    fn next(&self, position: usize) -> Option<(&'a [u8], usize)> {
        let separator = |byte: &u8| byte.is_ascii_whitespace() || *byte == b',' || *byte == 0;
        let begin = position
            + self.text[position..]
                .iter()
                .take_while(|byte| separator(byte))
                .count();
        let length = self.text[begin..]
            .iter()
            .take_while(|byte| !separator(byte))
            .count();
        (length > 0).then(|| (&self.text[begin..begin + length], begin))
    }

    /// How many there are.
    #[cfg(not(target_family = "wasm"))]
    pub(crate) fn count(&self) -> usize {
        let mut position = 0;
        std::iter::from_fn(|| {
            let (token, begin) = self.next(position)?;
            position = begin + token.len();
            Some(())
        })
        .count()
    }

    /// True where nothing but separators follows `position`.
    pub(crate) fn ends_at(&self, position: usize) -> bool {
        self.next(position).is_none()
    }
}

/// A number in a text file.
pub(super) trait TextNumber: FromStr {
    /// Whether numbers may have digits after a decimal point.
    const IS_REAL: bool = false;

    /// False for values that only overflow can have produced.
    fn fits(&self, _token: &str) -> bool {
        true
    }
}

/// Whether a comma after a number may be a decimal one: `1,5` is one number in half of Europe.
fn is_decimal_comma(text: &[u8], end: usize) -> bool {
    text.get(end) == Some(&b',') && text.get(end + 1).is_some_and(u8::is_ascii_digit)
}

macro_rules! text_number {
    (integers $($integer:ty)*; floats $($float:ty)*) => {
        $(impl TextNumber for $integer {})*
        $(impl TextNumber for $float {
            const IS_REAL: bool = true;

            fn fits(&self, token: &str) -> bool {
                !self.is_infinite() || token.to_ascii_lowercase().contains("inf")
            }
        })*
    };
}
text_number!(integers u8 i8 u16 i16 u32 i32 u64 i64; floats f32 f64);

pub(super) fn parse_numbers<T: TextNumber>(
    data: &mut Vec<T>,
    numbers: &TextNumbers<'_>,
    range: std::ops::Range<usize>,
    context: &Context<'_>,
) -> Result<usize, IoError> {
    let count = range.len();
    data.try_reserve_exact(count)
        .map_err(|_| context.limit((count as u64).saturating_mul(size_of::<T>() as u64), 0))?;
    let mut position = 0;
    for index in 0..range.end {
        let Some((token, begin)) = numbers.next(position) else {
            let (found, offset) = (format!("{index} numbers"), numbers.start + position as u64);
            return Err(context.field("samples", found, offset, format!("{} numbers", range.end)));
        };
        position = begin + token.len();
        if T::IS_REAL && is_decimal_comma(numbers.text, position) {
            let digits = numbers.text[position + 1..]
                .iter()
                .take_while(|byte| byte.is_ascii_digit());
            let shown = String::from_utf8_lossy(&numbers.text[begin..=position + digits.count()]);
            let expected = "a decimal point, or a blank after a comma that separates numbers";
            let offset = numbers.start + begin as u64;
            return Err(context.field(format!("sample {index}"), shown, offset, expected));
        }
        if index < range.start {
            continue;
        }
        let token = String::from_utf8_lossy(token);
        match token.parse::<T>() {
            Ok(number) if number.fits(&token) => data.push(number),
            _ => {
                let expected = format!("a number of type {}", std::any::type_name::<T>());
                let offset = numbers.start + begin as u64;
                return Err(context.field(format!("sample {index}"), token, offset, expected));
            }
        }
    }
    Ok(position)
}

/// The bytes that hexadecimal digits stand for, with white space anywhere.
pub(crate) struct HexDigits<R> {
    text: R,
    /// Digits and white space before.
    position: u64,
    high: Option<u32>,
}

impl<R: BufRead> HexDigits<R> {
    /// `start`: position of the text in its file.
    pub(crate) fn new(text: R, start: u64) -> Self {
        Self {
            text,
            position: start,
            high: None,
        }
    }
}

impl<R: BufRead> Read for HexDigits<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let mut written = 0;
        while written < bytes.len() {
            let text = self.text.fill_buf()?;
            let Some(&digit) = text.first() else {
                break;
            };
            if !digit.is_ascii_whitespace() {
                let Some(nibble) = char::from(digit).to_digit(16) else {
                    let shown = char::from(digit);
                    let reason = format!("`{shown}` at byte {} is no hexadecimal digit", self.position);
                    return Err(io::Error::new(io::ErrorKind::InvalidData, reason));
                };
                match self.high.take() {
                    None => self.high = Some(nibble),
                    Some(high) => {
                        bytes[written] = (high << 4 | nibble) as u8;
                        written += 1;
                    }
                }
            }
            self.text.consume(1);
            self.position += 1;
        }
        Ok(written)
    }
}

/// Reads whatever text follows, for text encodings.
pub(crate) fn remaining_text(source: &mut Source<'_>, context: &Context<'_>) -> Result<Vec<u8>, IoError> {
    let mut text = Vec::new();
    source
        .read_to_end(&mut text)
        .map_err(|error| context.read(error))?;
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn context() -> Context<'static> {
        Context::new("test", Path::new("a"))
    }

    fn text(text: &str, sample_type: SampleType, count: usize) -> Result<Samples, IoError> {
        decode_text(text.as_bytes(), sample_type, count, 100, &context()).map(|(samples, ..)| samples)
    }

    #[test]
    fn overflow_in_text_is_an_error_not_a_clamped_value() {
        assert_eq!(
            text(" 1,2\n-3 ", SampleType::I8, 3).unwrap(),
            Samples::I8(vec![1, 2, -3].into())
        );
        let error = text("1 99999 3", SampleType::I16, 3).unwrap_err().to_string();
        assert_eq!(
            error,
            "test, field \"sample 1\" = \"99999\" (byte 102): expected a number of type i16, in a"
        );
        assert!(text("1e39", SampleType::F32, 1).is_err());
        assert_eq!(
            text("inf", SampleType::F32, 1).unwrap(),
            Samples::F32(vec![f32::INFINITY].into())
        );
        assert!(text("1 2", SampleType::U8, 3).is_err());
        assert!(text("1 2", SampleType::U8, usize::MAX).is_err());
    }

    #[test]
    fn decimal_commas_are_refused_and_separators_taken() {
        let reals = |text_: &str| text(text_, SampleType::F32, 2);
        assert_eq!(reals("1.5, 2").unwrap(), Samples::F32(vec![1.5, 2.0].into()));
        assert_eq!(reals("1.5 ,2").unwrap(), Samples::F32(vec![1.5, 2.0].into()));
        let error = reals("1,5 2,25").unwrap_err().to_string();
        assert!(
            error.contains("\"1,5\"") && error.contains("decimal point"),
            "{error}"
        );
        assert!(text("1,2", SampleType::I16, 2).is_ok());
    }

    #[test]
    fn hexadecimal_digits_make_bytes() {
        let read = |text: &[u8]| {
            let mut bytes = Vec::new();
            HexDigits::new(text, 7).read_to_end(&mut bytes).map(|_| bytes)
        };
        assert_eq!(read(b"0a F\nf").unwrap(), [0x0a, 0xff]);
        assert_eq!(read(b"0a f").unwrap(), [0x0a]);
        let error = read(b"0g").unwrap_err().to_string();
        assert!(error.contains("`g` at byte 8"), "{error}");
    }
}
