//! Depth maps: camera depth per pixel, along the view direction, world length; infinite where there is nothing.
//!
//! | format | holds |
//! |---|---|
//! | EXR | one float channel `Z`, as it is |
//! | `.npy` | `float32`, rows by columns, as it is |
//! | PNG | 16 bits of grey: 0 where there is nothing, 1 to 65535 from the nearest to the farthest depth, whose world lengths are the text [`DEPTH_RANGE`] |

use std::io::Cursor;
use std::path::Path;

use exr::prelude::{AnyChannel, AnyChannels, Encoding, FlatSamples, Layer, WritableImage};
use png::text_metadata::TEXtChunk;
use png::{BitDepth, ColorType};
use splatvol_scene::ImageSize;

use super::{exr::attributes, metadata};
use crate::IoError;

/// Keyword for the depths of the codes 1 and 65535 in a PNG: two numbers.
pub const DEPTH_RANGE: &str = "splatvol.depth-range";

/// File formats of depth maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DepthFormat {
    /// OpenEXR with the channel `Z`.
    Exr,
    /// PNG of 16 bits.
    Png,
    /// A `NumPy` array.
    Npy,
}

impl DepthFormat {
    /// The format that a file name's extension stands for.
    pub fn from_path(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "exr" => Some(Self::Exr),
            "png" => Some(Self::Png),
            "npy" => Some(Self::Npy),
            _ => None,
        }
    }
}

/// A depth map as the bytes of a file. `metadata` goes into EXR and PNG only.
///
/// # Errors
/// [`IoError::Encode`]: metadata that the formats cannot hold, or depths that do not fit the size.
pub fn encode_depth(
    depth: &[f32],
    size: ImageSize,
    format: DepthFormat,
    metadata: &[(String, String)],
) -> Result<Vec<u8>, IoError> {
    let name = match format {
        DepthFormat::Exr => "EXR",
        DepthFormat::Png => "PNG",
        DepthFormat::Npy => "NPY",
    };
    let refuse = |what: String| IoError::Encode { format: name, what };
    metadata::check(name, metadata)?;
    if depth.len() != size.pixel_count() {
        let (found, expected) = (depth.len(), size.pixel_count());
        return Err(refuse(format!("{found} depths for {expected} pixels")));
    }
    match format {
        DepthFormat::Exr => as_exr(depth, size, metadata).map_err(refuse),
        DepthFormat::Png => as_png(depth, size, metadata).map_err(|error| refuse(error.to_string())),
        DepthFormat::Npy => Ok(as_npy(depth, size)),
    }
}

fn as_exr(depth: &[f32], size: ImageSize, metadata: &[(String, String)]) -> Result<Vec<u8>, String> {
    let channel = AnyChannel::new("Z", FlatSamples::F32(depth.to_vec()));
    let layer = Layer::new(
        (size.width() as usize, size.height() as usize),
        attributes(metadata).map_err(|error| error.to_string())?,
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort([channel].into_iter().collect()),
    );
    let mut bytes = Cursor::new(Vec::new());
    exr::prelude::Image::from_layer(layer)
        .write()
        .to_buffered(&mut bytes)
        .map_err(|error| error.to_string())?;
    Ok(bytes.into_inner())
}

/// Nearest and farthest finite depth; 0 and 1 if there is none.
fn range(depth: &[f32]) -> [f32; 2] {
    let finite = depth.iter().copied().filter(|d| d.is_finite());
    let ends = finite.fold([f32::INFINITY, f32::NEG_INFINITY], |[near, far], d| {
        [near.min(d), far.max(d)]
    });
    if ends[0] <= ends[1] { ends } else { [0.0, 1.0] }
}

fn as_png(
    depth: &[f32],
    size: ImageSize,
    metadata: &[(String, String)],
) -> Result<Vec<u8>, png::EncodingError> {
    let [near, far] = range(depth).map(f64::from);
    let width = if far > near { far - near } else { 1.0 };
    let code = |d: f32| {
        if d.is_finite() {
            (1.0 + 65_534.0 * (f64::from(d) - near) / width).round() as u16
        } else {
            0
        }
    };
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size.width(), size.height());
    encoder.set_color(ColorType::Grayscale);
    encoder.set_depth(BitDepth::Sixteen);
    let mut writer = encoder.write_header()?;
    let range = (DEPTH_RANGE.to_owned(), format!("{near} {far}"));
    for (keyword, text) in metadata.iter().chain([&range]) {
        writer.write_text_chunk(&TEXtChunk::new(keyword, text))?;
    }
    let data: Vec<u8> = depth.iter().flat_map(|&d| code(d).to_be_bytes()).collect();
    writer.write_image_data(&data)?;
    writer.finish()?;
    Ok(bytes)
}

fn as_npy(depth: &[f32], size: ImageSize) -> Vec<u8> {
    let dictionary = format!(
        "{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, {}), }}",
        size.height(),
        size.width()
    );
    // Version 1.0: magic, version, a 16-bit length, and blanks up to a multiple of 64 bytes, the last a line end.
    let length = (10 + dictionary.len() + 1).next_multiple_of(64) - 10;
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((length as u16).to_le_bytes());
    bytes.extend(format!("{dictionary:<width$}\n", width = length - 1).into_bytes());
    bytes.extend(depth.iter().flat_map(|d| d.to_le_bytes()));
    bytes
}

#[cfg(test)]
mod tests {
    use exr::prelude::{ReadChannels, ReadLayers};

    use super::*;

    const DEPTH: [f32; 6] = [10.0, 12.5, f32::INFINITY, 30.0, 20.0, 10.0];

    fn size() -> ImageSize {
        ImageSize::new(3, 2).unwrap()
    }

    #[test]
    fn png_codes_run_from_near_to_far_and_zero_is_nothing() {
        let bytes = encode_depth(&DEPTH, size(), DepthFormat::Png, &[]).unwrap();
        let mut reader = png::Decoder::new(Cursor::new(&bytes)).read_info().unwrap();
        let mut data = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut data).unwrap();
        let text = &reader.info().uncompressed_latin1_text[0];
        assert_eq!(
            (text.keyword.as_str(), text.text.as_str()),
            (DEPTH_RANGE, "10 30")
        );
        for (pair, depth) in data.chunks_exact(2).zip(DEPTH) {
            let code = f64::from(u16::from_be_bytes([pair[0], pair[1]]));
            let back = if code > 0.0 {
                10.0 + 20.0 * (code - 1.0) / 65_534.0
            } else {
                f64::INFINITY
            };
            assert!(
                back == f64::from(depth) || (back - f64::from(depth)).abs() < 2e-4,
                "{code}"
            );
        }
    }

    #[test]
    fn arrays_and_exr_hold_the_floats() {
        let npy = encode_depth(&DEPTH, size(), DepthFormat::Npy, &[]).unwrap();
        assert_eq!(npy.len() % 64, 24);
        assert!(String::from_utf8_lossy(&npy).contains("'shape': (2, 3)"));
        let floats: Vec<f32> = npy[npy.len() - 24..]
            .chunks_exact(4)
            .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            .collect();
        assert_eq!(floats, DEPTH);
        let bytes = encode_depth(&DEPTH, size(), DepthFormat::Exr, &[]).unwrap();
        let image = exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(bytes))
            .unwrap();
        let channel = &image.layer_data.channel_data.list[0];
        assert!(channel.name.eq("Z"));
        assert_eq!(channel.sample_data.values_as_f32().collect::<Vec<_>>(), DEPTH);
        assert!(encode_depth(&DEPTH[1..], size(), DepthFormat::Exr, &[]).is_err());
    }
}
