//! Stored sample types and their decoding.
//!
//! Bytes are read straight into the typed vector that the volume keeps, and are swapped in place, so that a volume
//! is in memory only once. 64-bit integers, which [`Samples`] does not have, become `f64`; values beyond 2^53 lose
//! digits there and are reported.

mod text;

use bytemuck::Pod;
use splatvol_scene::Samples;

use crate::IoError;
use crate::error::Context;
use crate::source::{Source, grow};

pub(crate) use text::{TextNumbers, decode_hex, decode_text, remaining_text};

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

fn rounded(inexact: usize) -> Option<String> {
    (inexact > 0).then(|| format!("{inexact} 64-bit integers are beyond 2^53 and were rounded to f64"))
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
