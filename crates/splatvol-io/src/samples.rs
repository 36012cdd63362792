//! Stored sample types and their decoding.
//!
//! Bytes are read straight into the typed vector that the volume keeps and swapped in place, so that a volume is in
//! memory once. 64-bit integers, which [`Samples`] does not have, become `f64`; values beyond 2^53 lose digits there
//! and are reported.

use std::io::Read;
use std::str::FromStr;

use bytemuck::Pod;
use splatvol_scene::Samples;

use crate::IoError;
use crate::error::Context;
use crate::source::{Source, grow};

/// Integers up to this magnitude are exact in `f64`.
const EXACT: i64 = 1 << 53;

/// Byte order of multi-byte samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "the variants say it")]
pub enum Endian {
    Little,
    Big,
}

impl Endian {
    /// The order of this machine.
    pub const NATIVE: Self = if cfg!(target_endian = "big") {
        Self::Big
    } else {
        Self::Little
    };
}

/// Makes [`SampleType`], the buffer of each type, and what depends on the type alone.
macro_rules! sample_types {
    ($($variant:ident $type:ty, $name:literal;)*) => {
        /// Type of a sample in a file.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[expect(missing_docs, reason = "the variants are their element types")]
        pub enum SampleType { $($variant,)* }

        impl SampleType {
            /// Every type.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)*];

            /// Bytes per sample.
            pub fn size(self) -> usize {
                match self { $(Self::$variant => size_of::<$type>(),)* }
            }

            /// `u8`, `i16`, `f32`...
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            fn buffer(self) -> Buffer {
                match self { $(Self::$variant => Buffer::$variant(Vec::new()),)* }
            }
        }

        /// One typed vector.
        enum Buffer { $($variant(Vec<$type>),)* }

        /// Runs `$body` with `$data` bound to the vector inside a [`Buffer`].
        macro_rules! with_buffer {
            ($buffer:expr, $data:ident => $body:expr) => {
                match $buffer { $(Buffer::$variant($data) => $body,)* }
            };
        }

        $(impl Sample for $type {
            fn swapped(self) -> Self {
                Self::from_ne_bytes(swap_bytes(self.to_ne_bytes()))
            }
        })*
    };
}

/// What the macro needs of an element.
trait Sample: Pod + Default {
    fn swapped(self) -> Self;
}

fn swap_bytes<const N: usize>(mut bytes: [u8; N]) -> [u8; N] {
    bytes.reverse();
    bytes
}

sample_types! {
    U8 u8, "u8";
    I8 i8, "i8";
    U16 u16, "u16";
    I16 i16, "i16";
    U32 u32, "u32";
    I32 i32, "i32";
    U64 u64, "u64";
    I64 i64, "i64";
    F32 f32, "f32";
    F64 f64, "f64";
}

impl SampleType {
    /// Reads a type by the names in use: `u8`, `uint8`, `uint8_t`, `unsigned char`, `float`, `f4`...
    pub fn from_name(name: &str) -> Option<Self> {
        let name = name
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ")
            .to_ascii_lowercase();
        Some(match name.as_str() {
            "u8" | "uint8" | "uint8_t" | "uchar" | "unsigned char" | "u1" => Self::U8,
            "i8" | "int8" | "int8_t" | "signed char" | "char" | "i1" => Self::I8,
            "u16" | "uint16" | "uint16_t" | "ushort" | "unsigned short" | "unsigned short int" | "u2" => {
                Self::U16
            }
            "i16" | "int16" | "int16_t" | "short" | "short int" | "signed short" | "signed short int"
            | "i2" => Self::I16,
            "u32" | "uint32" | "uint32_t" | "uint" | "unsigned int" | "u4" => Self::U32,
            "i32" | "int32" | "int32_t" | "int" | "signed int" | "i4" => Self::I32,
            "u64" | "uint64" | "uint64_t" | "ulonglong" | "unsigned long long" | "unsigned long long int" => {
                Self::U64
            }
            "i64"
            | "int64"
            | "int64_t"
            | "longlong"
            | "long long"
            | "long long int"
            | "signed long long"
            | "signed long long int" => Self::I64,
            "f32" | "float32" | "float" | "f4" => Self::F32,
            "f64" | "float64" | "double" | "f8" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of `count` samples.
    pub(crate) fn byte_count(self, count: usize) -> u64 {
        (count as u64).saturating_mul(self.size() as u64)
    }
}

/// Samples on their way into memory; several sources may follow each other (slice files, compressed blocks).
pub(crate) struct SampleBuffer {
    buffer: Buffer,
    endian: Endian,
}

impl SampleBuffer {
    pub(crate) fn new(sample_type: SampleType, endian: Endian) -> Self {
        Self {
            buffer: sample_type.buffer(),
            endian,
        }
    }

    /// Appends `count` samples from `source`; memory grows as they arrive.
    pub(crate) fn read(
        &mut self,
        source: &mut Source<'_>,
        count: usize,
        context: &Context<'_>,
    ) -> Result<(), IoError> {
        with_buffer!(&mut self.buffer, data => append(data, source, count, context))
    }

    /// Appends `count` numbers written as text, after skipping `skip` of them; the buffer must be of native order. A
    /// number outside the type's range is an error. Gives the number of bytes used.
    pub(crate) fn read_text(
        &mut self,
        numbers: &TextNumbers<'_>,
        skip: usize,
        count: usize,
        context: &Context<'_>,
    ) -> Result<usize, IoError> {
        let end = skip.saturating_add(count);
        // Every number takes a digit, and all but the last a separator.
        let most = numbers.text.len().div_ceil(2);
        if end > most {
            let found = format!("text of {} bytes", numbers.text.len());
            return Err(context.field("samples", found, numbers.start, format!("{end} numbers")));
        }
        with_buffer!(&mut self.buffer, data => parse_numbers(data, numbers, skip..end, context))
    }

    /// The samples in native order, and a warning where 64-bit integers lost digits.
    pub(crate) fn finish(self) -> (Samples, Option<String>) {
        let Self { mut buffer, endian } = self;
        if endian != Endian::NATIVE {
            with_buffer!(&mut buffer, data => data.iter_mut().for_each(|sample| *sample = sample.swapped()));
        }
        into_samples(buffer)
    }
}

fn append<T: Sample>(
    data: &mut Vec<T>,
    source: &mut Source<'_>,
    count: usize,
    context: &Context<'_>,
) -> Result<(), IoError> {
    let width = size_of::<T>();
    let declared = (count as u64).saturating_mul(width as u64);
    source.check_declared("samples", declared, context)?;
    let start = data.len();
    let end = start
        .checked_add(count)
        .ok_or_else(|| context.limit(declared, usize::MAX as u64))?;
    while data.len() < end {
        let known = data.len();
        grow(data, end, context)?;
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut data[known..]);
        let wanted = bytes.len();
        let read = source.fill(bytes, context)?;
        if read < wanted {
            let found = (known - start) * width + read;
            return Err(context.truncated("samples", declared, found as u64));
        }
    }
    Ok(())
}

fn into_samples(buffer: Buffer) -> (Samples, Option<String>) {
    let samples = match buffer {
        Buffer::U8(data) => Samples::U8(data),
        Buffer::I8(data) => Samples::I8(data),
        Buffer::U16(data) => Samples::U16(data),
        Buffer::I16(data) => Samples::I16(data),
        Buffer::U32(data) => Samples::U32(data),
        Buffer::I32(data) => Samples::I32(data),
        Buffer::F32(data) => Samples::F32(data),
        Buffer::F64(data) => Samples::F64(data),
        Buffer::U64(data) => {
            let inexact = data.iter().filter(|&&v| v > EXACT as u64).count();
            return (
                Samples::F64(data.into_iter().map(|v| v as f64).collect()),
                rounded(inexact),
            );
        }
        Buffer::I64(data) => {
            let inexact = data.iter().filter(|v| v.unsigned_abs() > EXACT as u64).count();
            return (
                Samples::F64(data.into_iter().map(|v| v as f64).collect()),
                rounded(inexact),
            );
        }
    };
    (samples, None)
}

fn rounded(inexact: usize) -> Option<String> {
    (inexact > 0).then(|| format!("{inexact} 64-bit integers are beyond 2^53 and were rounded to f64"))
}

/// Decodes samples that are already in memory (`bytes` must hold exactly the samples). Single bytes are not copied.
pub(crate) fn decode(
    bytes: Vec<u8>,
    sample_type: SampleType,
    endian: Endian,
    context: &Context<'_>,
) -> Result<(Samples, Option<String>), IoError> {
    if sample_type == SampleType::U8 {
        return Ok((Samples::U8(bytes), None));
    }
    let count = bytes.len() / sample_type.size();
    if count * sample_type.size() != bytes.len() {
        return Err(context.truncated("samples", sample_type.byte_count(count + 1), bytes.len() as u64));
    }
    let mut buffer = SampleBuffer::new(sample_type, endian);
    buffer.read(&mut Source::from_bytes(&bytes), count, context)?;
    Ok(buffer.finish())
}

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

    /// True where nothing but separators follows `position`.
    pub(crate) fn ends_at(&self, position: usize) -> bool {
        self.next(position).is_none()
    }
}

/// A number in a text file.
trait TextNumber: FromStr {
    /// False for what only overflow can have made.
    fn fits(&self, _token: &str) -> bool {
        true
    }
}

macro_rules! text_number {
    (integers $($integer:ty)*; floats $($float:ty)*) => {
        $(impl TextNumber for $integer {})*
        $(impl TextNumber for $float {
            fn fits(&self, token: &str) -> bool {
                !self.is_infinite() || token.to_ascii_lowercase().contains("inf")
            }
        })*
    };
}
text_number!(integers u8 i8 u16 i16 u32 i32 u64 i64; floats f32 f64);

fn parse_numbers<T: TextNumber>(
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

/// Turns pairs of hexadecimal digits (white space ignored) into bytes, `count` of them.
pub(crate) fn decode_hex(
    text: &[u8],
    count: u64,
    start: u64,
    context: &Context<'_>,
) -> Result<Vec<u8>, IoError> {
    if count > text.len() as u64 / 2 {
        return Err(context.truncated("hexadecimal digits", count.saturating_mul(2), text.len() as u64));
    }
    let mut bytes = Vec::with_capacity(count as usize);
    let mut high = None;
    for (position, &digit) in text.iter().enumerate() {
        if bytes.len() as u64 == count {
            break;
        }
        if digit.is_ascii_whitespace() {
            continue;
        }
        let Some(nibble) = char::from(digit).to_digit(16) else {
            let field = format!("sample byte {}", bytes.len());
            let expected = "hexadecimal digits";
            return Err(context.field(field, char::from(digit), start + position as u64, expected));
        };
        match high.take() {
            None => high = Some(nibble),
            Some(high) => bytes.push((high << 4 | nibble) as u8),
        }
    }
    if (bytes.len() as u64) < count {
        return Err(context.truncated("hexadecimal bytes", count, bytes.len() as u64));
    }
    Ok(bytes)
}

/// Every `components`-th sample, from `component` on: one component of interleaved vectors.
pub(crate) fn pick_component(samples: &Samples, components: usize, component: usize) -> Samples {
    macro_rules! pick {
        ($($variant:ident)*) => {
            match samples {
                $(Samples::$variant(data) => {
                    Samples::$variant(data.iter().skip(component).step_by(components).copied().collect())
                })*
            }
        };
    }
    pick!(U8 I8 U16 I16 U32 I32 F32 F64)
}

/// The bytes of samples in little-endian order, handed to `write` in pieces.
pub(crate) fn for_each_little_endian_chunk<E>(
    samples: &Samples,
    mut write: impl FnMut(&[u8]) -> Result<(), E>,
) -> Result<(), E> {
    fn chunks<T: Sample, E>(data: &[T], write: &mut impl FnMut(&[u8]) -> Result<(), E>) -> Result<(), E> {
        for chunk in data.chunks(1 << 14) {
            if Endian::NATIVE == Endian::Little {
                write(bytemuck::cast_slice(chunk))?;
            } else {
                let swapped: Vec<T> = chunk.iter().map(|sample| sample.swapped()).collect();
                write(bytemuck::cast_slice(&swapped))?;
            }
        }
        Ok(())
    }
    splatvol_scene::with_samples!(samples, data => chunks(data, &mut write))
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
    fn both_byte_orders_decode() {
        let bytes = vec![0x01, 0x02, 0xff, 0xfe];
        let (little, _) = decode(bytes.clone(), SampleType::I16, Endian::Little, &context()).unwrap();
        let (big, _) = decode(bytes.clone(), SampleType::I16, Endian::Big, &context()).unwrap();
        assert_eq!(little, Samples::I16(vec![0x0201, -257]));
        assert_eq!(big, Samples::I16(vec![0x0102, -2]));
        assert!(decode(bytes[..3].to_vec(), SampleType::I16, Endian::Big, &context()).is_err());
        let (floats, _) = decode(
            1.5f64.to_be_bytes().to_vec(),
            SampleType::F64,
            Endian::Big,
            &context(),
        )
        .unwrap();
        assert_eq!(floats, Samples::F64(vec![1.5]));
    }

    #[test]
    fn long_integers_are_reported_only_where_they_lose_digits() {
        let decode = |value: i64| {
            decode(
                value.to_le_bytes().to_vec(),
                SampleType::I64,
                Endian::Little,
                &context(),
            )
        };
        assert_eq!(
            decode(-(1 << 53)).unwrap(),
            (Samples::F64(vec![-9007199254740992.0]), None)
        );
        assert!(
            decode(i64::MIN)
                .unwrap()
                .1
                .unwrap()
                .starts_with("1 64-bit integers")
        );
    }

    #[test]
    fn overflow_in_text_is_an_error_not_a_clamped_value() {
        assert_eq!(
            text(" 1,2\n-3 ", SampleType::I8, 3).unwrap(),
            Samples::I8(vec![1, 2, -3])
        );
        let error = text("1 99999 3", SampleType::I16, 3).unwrap_err().to_string();
        assert_eq!(
            error,
            "test, field \"sample 1\" = \"99999\" (byte 102): expected a number of type i16, in a"
        );
        assert!(text("1e39", SampleType::F32, 1).is_err());
        assert_eq!(
            text("inf", SampleType::F32, 1).unwrap(),
            Samples::F32(vec![f32::INFINITY])
        );
        assert!(text("1 2", SampleType::U8, 3).is_err());
        assert!(text("1 2", SampleType::U8, usize::MAX).is_err());
    }

    #[test]
    fn hexadecimal_digits_make_bytes() {
        assert_eq!(decode_hex(b"0a F\nf", 2, 0, &context()).unwrap(), [0x0a, 0xff]);
        assert!(decode_hex(b"0a f", 2, 0, &context()).is_err());
        assert!(decode_hex(b"0g", 1, 0, &context()).is_err());
    }

    #[test]
    fn type_names_have_many_spellings() {
        for name in ["unsigned char", "uint8_t", " UCHAR ", "u8", "unsigned  char"] {
            assert_eq!(SampleType::from_name(name), Some(SampleType::U8), "{name}");
        }
        for &sample_type in SampleType::ALL {
            assert_eq!(SampleType::from_name(sample_type.name()), Some(sample_type));
        }
        assert_eq!(SampleType::from_name("block"), None);
    }
}
