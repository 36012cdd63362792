//! PNG (W3C, Portable Network Graphics, 3rd edition): straight alpha, sRGB.
//!
//! Writing: `code = round(max * srgb(linear / alpha))`, alpha itself linear; values beyond 0..1 are clamped, NaN is 0;
//! a picture without transparency is written as RGB. The chunk `sRGB` is written. Reading: every colour type and bit
//! depth; `gAMA` is followed if there is no `sRGB`, embedded ICC profiles are not. A picture read and written again at
//! its own depth has the same codes.

mod write;

use std::io::Cursor;
use std::path::Path;

use png::{BitDepth, ColorType, DecodingError, Transformations};
use splatvol_scene::transfer_function::linear_from_srgb;
use splatvol_scene::{Image, ImageSize};

use super::srgb::{self, SrgbCodes};
use super::{LoadedImage, check_size};
use crate::IoError;
use crate::error::Context;

pub use self::write::{PngRows, encode};
pub(crate) use self::write::{data, encoder, write_texts};

/// Bits per channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Depth {
    /// 256 codes.
    Eight,
    /// 65536 codes.
    Sixteen,
}

impl Depth {
    pub(super) fn largest(self) -> f64 {
        match self {
            Self::Eight => 255.0,
            Self::Sixteen => 65_535.0,
        }
    }

    fn srgb_codes(self) -> &'static SrgbCodes {
        match self {
            Self::Eight => &srgb::EIGHT,
            Self::Sixteen => &srgb::SIXTEEN,
        }
    }
}

/// Deflate turns one byte into at most 1032, each of which may hold 8 grey pixels.
const PIXELS_PER_BYTE: u64 = 8 * 1032;

/// Codes of a picture: sRGB, straight alpha, row-major.
pub(crate) fn codes(image: &Image, depth: Depth) -> Vec<[u16; 4]> {
    let srgb = depth.srgb_codes();
    image
        .pixels
        .iter()
        .map(|&pixel| code(pixel, depth, srgb))
        .collect()
}

/// A picture as 8-bit RGBA: sRGB, straight alpha, row-major; the codes of an 8-bit PNG.
pub fn srgb8(image: &Image) -> Vec<[u8; 4]> {
    let srgb = Depth::Eight.srgb_codes();
    let mut codes = vec![[0; 4]; image.pixels.len()];
    for (own, &pixel) in codes.iter_mut().zip(&image.pixels) {
        for (byte, code) in own.iter_mut().zip(code(pixel, Depth::Eight, srgb)) {
            *byte = code as u8;
        }
    }
    codes
}

/// Straight sRGB codes of a linear premultiplied pixel.
#[inline(always)]
fn code(pixel: [f32; 4], depth: Depth, srgb: &SrgbCodes) -> [u16; 4] {
    let alpha = f64::from(pixel[3]);
    // A conversion from float saturates, and NaN becomes 0.
    let alpha_code = (alpha.clamp(0.0, 1.0) * depth.largest() + 0.5) as u16;
    if alpha_code == 0 {
        return [0; 4];
    }
    let mut codes = [0, 0, 0, alpha_code];
    for (code, channel) in codes.iter_mut().zip(pixel).take(3) {
        let premultiplied = f64::from(channel);
        *code = srgb.code(match alpha == 1.0 {
            true => premultiplied,
            false => premultiplied / alpha,
        });
    }
    codes
}

/// A picture from the bytes of a PNG file; `path` is only named in errors.
///
/// # Errors
/// [`IoError::Format`] for an invalid PNG, [`IoError::Truncated`] and [`IoError::Limit`] for sizes that the bytes do
/// not justify.
pub fn decode(bytes: &[u8], path: &Path) -> Result<LoadedImage, IoError> {
    let context = Context::new("PNG", path);
    let malformed = |error: DecodingError| malformed(&error, &context);
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(Transformations::EXPAND);
    let header = decoder.read_header_info().map_err(malformed)?;
    let (width, height) = header.size();
    let size = ImageSize::new(width, height).map_err(|error| context.scene(error))?;
    check_size(size.pixel_count() as u64, bytes, PIXELS_PER_BYTE, &context)?;

    let mut reader = decoder.read_info().map_err(malformed)?;
    let (color_type, bit_depth) = reader.output_color_type();
    let length = reader
        .output_buffer_size()
        .ok_or_else(|| context.limit(u64::MAX, usize::MAX as u64))?;
    let mut data = vec![0; length];
    reader.next_frame(&mut data).map_err(malformed)?;
    // Text after the pixels counts too.
    reader.finish().map_err(malformed)?;
    let info = reader.info();

    let transfer = Transfer::of(info);
    let pixels = match bit_depth {
        BitDepth::Sixteen => {
            let codes = data
                .chunks_exact(2)
                .map(|pair| u16::from_be_bytes([pair[0], pair[1]]));
            let table: Vec<f64> = (0..=u16::MAX)
                .map(|code| transfer.linear(f64::from(code) / 65_535.0))
                .collect();
            unpack(&codes.collect::<Vec<_>>(), color_type, &table)
        }
        _ => {
            let table: Vec<f64> = (0..=u8::MAX)
                .map(|code| transfer.linear(f64::from(code) / 255.0))
                .collect();
            unpack(
                &data.iter().map(|&code| u16::from(code)).collect::<Vec<_>>(),
                color_type,
                &table,
            )
        }
    };
    Ok(LoadedImage {
        image: Image::from_pixels(size, pixels).map_err(|error| context.scene(error))?,
        depth: None,
        metadata: texts(info).map_err(malformed)?,
    })
}

/// The texts of a PNG, before and after its pixels, which are not decoded.
pub(super) fn metadata(bytes: &[u8], path: &Path) -> Result<Vec<(String, String)>, IoError> {
    let context = Context::new("PNG", path);
    let malformed = |error: DecodingError| malformed(&error, &context);
    let mut reader = png::Decoder::new(Cursor::new(bytes))
        .read_info()
        .map_err(malformed)?;
    reader.finish().map_err(malformed)?;
    texts(reader.info()).map_err(malformed)
}

/// Converts a decoder's error to this crate's error.
fn malformed(error: &DecodingError, context: &Context<'_>) -> IoError {
    context.field("contents", error, None, "a valid PNG")
}

/// Transfer curve from codes to linear light.
enum Transfer {
    Srgb,
    Gamma(f64),
}

impl Transfer {
    fn of(info: &png::Info<'_>) -> Self {
        match info.gama_chunk {
            Some(gamma) if info.srgb.is_none() && gamma.into_value() > 0.0 => {
                Self::Gamma(f64::from(gamma.into_value()))
            }
            _ => Self::Srgb,
        }
    }

    fn linear(&self, encoded: f64) -> f64 {
        match self {
            Self::Srgb => linear_from_srgb(encoded),
            Self::Gamma(gamma) => encoded.powf(1.0 / gamma),
        }
    }
}

/// Linear premultiplied pixels of codes, which `table` makes linear.
fn unpack(codes: &[u16], color_type: ColorType, table: &[f64]) -> Vec<[f32; 4]> {
    let largest = table.len() as f64 - 1.0;
    let pixel = |gray: [u16; 3], alpha: Option<u16>| {
        let alpha = alpha.map_or(1.0, |code| f64::from(code) / largest);
        let [r, g, b] = gray.map(|code| (table[usize::from(code)] * alpha) as f32);
        [r, g, b, alpha as f32]
    };
    match color_type {
        ColorType::Grayscale => codes.iter().map(|&v| pixel([v; 3], None)).collect(),
        ColorType::GrayscaleAlpha => codes
            .chunks_exact(2)
            .map(|c| pixel([c[0]; 3], Some(c[1])))
            .collect(),
        ColorType::Rgba => codes
            .chunks_exact(4)
            .map(|c| pixel([c[0], c[1], c[2]], Some(c[3])))
            .collect(),
        // Palettes are expanded.
        ColorType::Rgb | ColorType::Indexed => codes
            .chunks_exact(3)
            .map(|c| pixel([c[0], c[1], c[2]], None))
            .collect(),
    }
}

fn texts(info: &png::Info<'_>) -> Result<Vec<(String, String)>, DecodingError> {
    let mut metadata = Vec::new();
    for chunk in &info.uncompressed_latin1_text {
        metadata.push((chunk.keyword.clone(), chunk.text.clone()));
    }
    for chunk in &info.compressed_latin1_text {
        metadata.push((chunk.keyword.clone(), chunk.get_text()?));
    }
    for chunk in &info.utf8_text {
        metadata.push((chunk.keyword.clone(), chunk.get_text()?));
    }
    Ok(metadata)
}
