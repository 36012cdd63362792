//! Stored sample types and their decoding.
//!
//! Bytes are read straight into the typed vector that the volume keeps, and are swapped in place, so that a volume
//! is in memory only once. 64-bit integers, which [`Samples`] does not have, become `f64`; values beyond 2^53 lose
//! digits there and are reported.

mod text;

use bytemuck::Pod;
use splatvol_scene::{ElementType, Samples};

use crate::IoError;
use crate::error::Context;
use crate::source::{Source, grow};

pub(crate) use text::{HexDigits, TextNumbers, decode_text, remaining_text};

/// Integers up to this magnitude are exact in `f64`.
const EXACT: i64 = 1 << 53;

/// Byte order of multi-byte samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Endian {
    /// Least significant byte first.
    Little,
    /// Most significant byte first.
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
        pub enum SampleType {
            $(
                #[doc = concat!("`", $name, "`.")]
                $variant,
            )*
        }

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

/// Element type that the macro can read and byte-swap.
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

    /// Type of such samples in memory.
    pub(crate) fn element(self) -> ElementType {
        match self {
            Self::U8 => ElementType::U8,
            Self::I8 => ElementType::I8,
            Self::U16 => ElementType::U16,
            Self::I16 => ElementType::I16,
            Self::U32 => ElementType::U32,
            Self::I32 => ElementType::I32,
            Self::F32 => ElementType::F32,
            Self::U64 | Self::I64 | Self::F64 => ElementType::F64,
        }
    }

    /// Bytes of `count` samples.
    pub(crate) fn byte_count(self, count: usize) -> u64 {
        (count as u64).saturating_mul(self.size() as u64)
    }
}

/// Samples while they are read; several sources may follow each other (slice files, compressed blocks).
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
    /// number outside the type's range is an error. Returns the number of bytes used.
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
        with_buffer!(&mut self.buffer, data => text::parse_numbers(data, numbers, skip..end, context))
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
        Buffer::U8(data) => Samples::U8(data.into()),
        Buffer::I8(data) => Samples::I8(data.into()),
        Buffer::U16(data) => Samples::U16(data.into()),
        Buffer::I16(data) => Samples::I16(data.into()),
        Buffer::U32(data) => Samples::U32(data.into()),
        Buffer::I32(data) => Samples::I32(data.into()),
        Buffer::F32(data) => Samples::F32(data.into()),
        Buffer::F64(data) => Samples::F64(data.into()),
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

pub(crate) fn rounded(inexact: usize) -> Option<String> {
    (inexact > 0).then(|| format!("{inexact} 64-bit integers are beyond 2^53 and were rounded to f64"))
}

/// The bytes of samples, in native order.
pub(crate) fn sample_bytes_mut(samples: &mut Samples) -> &mut [u8] {
    macro_rules! bytes {
        ($($variant:ident)*) => {
            match samples { $(Samples::$variant(data) => bytemuck::cast_slice_mut(data.to_mut()),)* }
        };
    }
    bytes!(U8 I8 U16 I16 U32 I32 F32 F64)
}

/// Turns round the bytes of every sample of `size`.
pub(crate) fn swap_bytes_of(bytes: &mut [u8], size: usize) {
    fn swap<const N: usize>(bytes: &mut [u8]) {
        bytes.chunks_exact_mut(N).for_each(<[u8]>::reverse);
    }
    match size {
        2 => swap::<2>(bytes),
        4 => swap::<4>(bytes),
        8 => swap::<8>(bytes),
        _ => (),
    }
}

/// Stored bytes as samples in memory, as many as these are: half floats (stored as `u16`, into `f32`) and 64-bit
/// integers (into `f64`) are converted, all others copied. Returns the number of integers that lost digits.
pub(crate) fn widen_samples(
    bytes: &[u8],
    sample_type: SampleType,
    endian: Endian,
    into: &mut Samples,
) -> usize {
    fn words<const N: usize>(bytes: &[u8], endian: Endian) -> impl Iterator<Item = [u8; N]> {
        bytes
            .as_chunks()
            .0
            .iter()
            .map(move |word: &[u8; N]| match endian {
                Endian::Little => *word,
                Endian::Big => swap_bytes(*word),
            })
    }
    let mut inexact = 0;
    match (sample_type, &mut *into) {
        (SampleType::U16, Samples::F32(into)) => {
            let halves = words(bytes, endian).map(|word| half::f16::from_le_bytes(word).to_f32());
            into.to_mut()
                .iter_mut()
                .zip(halves)
                .for_each(|(to, half)| *to = half);
        }
        (SampleType::U64, Samples::F64(into)) => {
            for (to, value) in into
                .to_mut()
                .iter_mut()
                .zip(words(bytes, endian).map(u64::from_le_bytes))
            {
                *to = value as f64;
                inexact += usize::from(value > EXACT as u64);
            }
        }
        (SampleType::I64, Samples::F64(into)) => {
            for (to, value) in into
                .to_mut()
                .iter_mut()
                .zip(words(bytes, endian).map(i64::from_le_bytes))
            {
                *to = value as f64;
                inexact += usize::from(value.unsigned_abs() > EXACT as u64);
            }
        }
        (sample_type, into) => {
            let into = sample_bytes_mut(into);
            into.copy_from_slice(bytes);
            if endian != Endian::NATIVE {
                swap_bytes_of(into, sample_type.size());
            }
        }
    }
    inexact
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn context() -> Context<'static> {
        Context::new("test", Path::new("a"))
    }

    fn decode(bytes: Vec<u8>, sample_type: SampleType, endian: Endian) -> (Samples, Option<String>) {
        let mut buffer = SampleBuffer::new(sample_type, endian);
        let count = bytes.len() / sample_type.size();
        buffer
            .read(&mut Source::from_bytes(&bytes), count, &context())
            .unwrap();
        buffer.finish()
    }

    #[test]
    fn both_byte_orders_decode() {
        let bytes = vec![0x01, 0x02, 0xff, 0xfe];
        let (little, _) = decode(bytes.clone(), SampleType::I16, Endian::Little);
        let (big, _) = decode(bytes, SampleType::I16, Endian::Big);
        assert_eq!(little, Samples::I16(vec![0x0201, -257].into()));
        assert_eq!(big, Samples::I16(vec![0x0102, -2].into()));
        let (floats, _) = decode(1.5f64.to_be_bytes().to_vec(), SampleType::F64, Endian::Big);
        assert_eq!(floats, Samples::F64(vec![1.5].into()));
    }

    #[test]
    fn sources_that_end_early_are_refused() {
        let mut buffer = SampleBuffer::new(SampleType::I16, Endian::Little);
        assert!(
            buffer
                .read(&mut Source::from_bytes(&[1, 2, 3]), 2, &context())
                .is_err()
        );
        assert!(
            buffer
                .read(&mut Source::from_bytes(&[1, 2, 3]), usize::MAX, &context())
                .is_err()
        );
    }

    #[test]
    fn long_integers_are_reported_only_where_they_lose_digits() {
        let decode = |value: i64| decode(value.to_le_bytes().to_vec(), SampleType::I64, Endian::Little);
        assert_eq!(
            decode(-(1 << 53)),
            (Samples::F64(vec![-9007199254740992.0].into()), None)
        );
        assert!(decode(i64::MIN).1.unwrap().starts_with("1 64-bit integers"));
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
