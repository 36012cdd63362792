//! The form of a page.

use super::compression;
use super::directory::{Directories, tag};
use crate::IoError;
use crate::error::Context;
use crate::samples::{Endian, SampleType};

/// Meanings of samples (`PhotometricInterpretation`).
const WHITE_IS_ZERO: u64 = 0;
const BLACK_IS_ZERO: u64 = 1;
const PALETTE: u64 = 3;

/// The form of a page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PageHead {
    /// Columns and rows.
    pub(crate) size: [usize; 2],
    pub(crate) components: usize,
    /// The type that samples are read as.
    pub(crate) sample_type: SampleType,
    /// Bits that a stored sample takes: 1, 2, 4, or those of its type, or 16 of a half float.
    pub(super) bits: u64,
    half: bool,
    /// True where samples are places in a palette.
    pub(crate) palette: bool,
    pub(crate) white_is_zero: bool,
    /// `PhotometricInterpretation`.
    pub(super) photometric: u64,
    /// True where each component has strips or tiles of its own.
    pub(super) planar: bool,
    /// True where the lowest bit of a byte comes first.
    pub(super) low_bits_first: bool,
    pub(super) predictor: u64,
    pub(super) compression: u64,
    pub(crate) endian: Endian,
}

impl PageHead {
    /// The form of the current page.
    pub(super) fn read(directory: &Directories, context: &Context<'_>) -> Result<Self, IoError> {
        let number = |tag, default| -> Result<u64, IoError> {
            Ok(directory
                .unsigned(tag, context)?
                .first()
                .copied()
                .unwrap_or(default))
        };
        let side = |tag, name: &str| -> Result<usize, IoError> {
            let found = number(tag, 0)?;
            let side = u32::try_from(found).ok().filter(|&side| side > 0);
            let side = side.ok_or_else(|| context.field(name.to_owned(), found, None, "1 to 2^32 - 1"))?;
            Ok(side as usize)
        };
        let size = [
            side(tag::IMAGE_WIDTH, "ImageWidth")?,
            side(tag::IMAGE_LENGTH, "ImageLength")?,
        ];
        let bits = number(tag::BITS_PER_SAMPLE, 1)?;
        let format = number(tag::SAMPLE_FORMAT, 1)?;
        let photometric = number(tag::PHOTOMETRIC_INTERPRETATION, BLACK_IS_ZERO)?;
        let components = number(tag::SAMPLES_PER_PIXEL, 1)?;
        let components = usize::from(
            u16::try_from(components)
                .ok()
                .filter(|&count| count > 0)
                .ok_or_else(|| context.field("SamplesPerPixel", components, None, "1 to 65535"))?,
        );
        let sample_type = sample_type(format, bits)
            .ok_or_else(|| context.unsupported(format!("samples of {bits} bits in format {format}")))?;
        Ok(Self {
            size,
            components,
            sample_type,
            bits,
            half: (format, bits) == (3, 16),
            palette: photometric == PALETTE,
            white_is_zero: photometric == WHITE_IS_ZERO,
            photometric,
            planar: number(tag::PLANAR_CONFIGURATION, 1)? == 2 && components > 1,
            low_bits_first: number(tag::FILL_ORDER, 1)? == 2,
            predictor: number(tag::PREDICTOR, 1)?,
            compression: number(tag::COMPRESSION, 1)?,
            endian: directory.endian,
        })
    }

    /// Samples of all components.
    pub(crate) fn samples(&self) -> usize {
        let [columns, rows] = self.size;
        columns.saturating_mul(rows).saturating_mul(self.components)
    }

    /// Bytes of the samples as they are stored, without the padding of rows of bits.
    pub(crate) fn stored_bytes(&self) -> u64 {
        (self.samples() as u64).saturating_mul(self.bits) / 8
    }

    /// True for samples that take the bytes of their type.
    pub(super) fn is_plain(&self) -> bool {
        self.bits == 8 * self.sample_type.size() as u64
    }

    pub(super) fn is_half(&self) -> bool {
        self.half
    }

    /// The type, byte order and compression, to show.
    pub(crate) fn stored_type(&self) -> String {
        let order = match self.endian {
            _ if self.bits <= 8 => "",
            Endian::Little => ", little-endian",
            Endian::Big => ", big-endian",
        };
        let name = match self.bits {
            _ if self.half => "f16".to_owned(),
            bits @ 1..=7 => format!("{bits} bits"),
            _ => self.sample_type.name().to_owned(),
        };
        let coding = compression::name(self.compression);
        let palette = if self.palette { ", places in a palette" } else { "" };
        format!("{name}{order}, {coding}{palette}")
    }
}

/// The type for a `SampleFormat` and a number of bits.
fn sample_type(format: u64, bits: u64) -> Option<SampleType> {
    Some(match (format, bits) {
        (1 | 4, 1 | 2 | 4 | 8) => SampleType::U8,
        (1 | 4, 16) => SampleType::U16,
        (1 | 4, 32) => SampleType::U32,
        (1 | 4, 64) => SampleType::U64,
        (2, 8) => SampleType::I8,
        (2, 16) => SampleType::I16,
        (2, 32) => SampleType::I32,
        (2, 64) => SampleType::I64,
        (3, 16 | 32) => SampleType::F32,
        (3, 64) => SampleType::F64,
        _ => return None,
    })
}
