//! Pictures: PNG for showing, EXR for computing with, both with metadata.
//!
//! | format | holds |
//! |---|---|
//! | PNG, 8 or 16 bits | straight alpha, sRGB |
//! | EXR, 32-bit float | premultiplied alpha, linear light, and camera depth as channel `Z` |
//! | [`part`] | the pixels of a block, to be put together |

pub mod depth;
pub mod exr;
pub mod metadata;
pub mod part;
pub mod png;
mod srgb;

use std::path::Path;

use splatvol_scene::{Frame, Image};

use crate::IoError;
use crate::error::Context;
use crate::memory;
use crate::source::read_file;

/// Most pixels that a picture may have to be read: 4 GiB in memory.
const MOST_PIXELS: u64 = 1 << 28;

/// A picture that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadedImage {
    /// The picture; opaque where the file has no alpha.
    pub image: Image,
    /// Camera depth per pixel, row-major, where the file has it.
    pub depth: Option<Vec<f32>>,
    /// Keywords and texts, in the order of the file.
    pub metadata: Vec<(String, String)>,
}

/// File formats of pictures.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ImageFormat {
    /// PNG of 8 bits per channel.
    #[default]
    Png8,
    /// PNG of 16 bits per channel.
    Png16,
    /// OpenEXR of 32-bit floats.
    Exr,
}

impl ImageFormat {
    /// The format that a file name's extension stands for; `.png` is [`ImageFormat::Png8`].
    pub fn from_path(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "png" => Some(Self::Png8),
            "exr" => Some(Self::Exr),
            _ => None,
        }
    }
}

/// A picture as the bytes of a file. `depth` (one per pixel) goes into EXR only.
///
/// # Errors
/// [`IoError::Encode`]: metadata that the formats cannot hold, or a depth that does not fit the image.
pub fn encode_image(
    image: &Image,
    depth: Option<&[f32]>,
    format: ImageFormat,
    metadata: &[(String, String)],
) -> Result<Vec<u8>, IoError> {
    match format {
        ImageFormat::Png8 => png::encode(image, png::Depth::Eight, metadata),
        ImageFormat::Png16 => png::encode(image, png::Depth::Sixteen, metadata),
        ImageFormat::Exr => exr::encode(image, depth, metadata),
    }
}

/// Writes a picture to a file; see [`encode_image`].
///
/// # Errors
/// Same as [`encode_image`], and [`IoError::Write`].
pub fn write_image(
    path: impl AsRef<Path>,
    image: &Image,
    depth: Option<&[f32]>,
    format: ImageFormat,
    metadata: &[(String, String)],
) -> Result<(), IoError> {
    let path = path.as_ref();
    let bytes = encode_image(image, depth, format, metadata)?;
    std::fs::write(path, bytes).map_err(|source| IoError::Write {
        source,
        path: path.to_owned(),
    })
}

/// Writes a frame to a file whose extension chooses the format: `.png` (8 bits per channel), or `.exr` with the frame's
/// depth. `metadata` are keywords and texts that travel with the picture ([`metadata`]).
///
/// # Errors
/// [`IoError::Unsupported`] for other extensions; otherwise as [`write_image`].
pub fn write_frame(
    path: impl AsRef<Path>,
    frame: &Frame,
    metadata: &[(String, String)],
) -> Result<(), IoError> {
    let path = path.as_ref();
    let Some(format) = ImageFormat::from_path(path) else {
        let extension = path.extension().unwrap_or_default().display();
        return Err(Context::new("picture", path).unsupported(format!(
            "no writer for the extension \"{extension}\" (.png and .exr have one)"
        )));
    };
    write_image(path, &frame.image, Some(&frame.depth), format, metadata)
}

/// Reads a PNG or EXR; the first bytes decide which.
///
/// # Errors
/// See [`IoError`].
pub fn read_image(path: impl AsRef<Path>) -> Result<LoadedImage, IoError> {
    let path = path.as_ref();
    let bytes = read_file(path, &Context::new("picture", path))?;
    decode_image(&bytes, path)
}

/// The texts that a PNG or EXR carries, without its pixels.
///
/// # Errors
/// See [`IoError`].
pub fn read_image_metadata(path: impl AsRef<Path>) -> Result<Vec<(String, String)>, IoError> {
    let path = path.as_ref();
    let bytes = read_file(path, &Context::new("picture", path))?;
    match bytes[..] {
        [0x89, b'P', b'N', b'G', ..] => png::metadata(&bytes, path),
        _ => decode_image(&bytes, path).map(|image| image.metadata),
    }
}

/// A PNG or EXR from the bytes of a file; `path` is only named in errors.
///
/// # Errors
/// See [`IoError`].
pub fn decode_image(bytes: &[u8], path: &Path) -> Result<LoadedImage, IoError> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => png::decode(bytes, path),
        [0x76, 0x2f, 0x31, 0x01, ..] => exr::decode(bytes, path),
        _ => Err(Context::new("picture", path).unsupported("neither PNG nor OpenEXR")),
    }
}

/// Refuses sizes that the bytes present do not justify: no decoder of the format turns one byte into more than
/// `ratio`.
fn check_size(pixels: u64, bytes: &[u8], ratio: u64, context: &Context<'_>) -> Result<(), IoError> {
    let at_most = (bytes.len() as u64).saturating_mul(ratio);
    if pixels > at_most {
        return Err(context.too_small("pixels", pixels, at_most));
    }
    // A decoded picture, and half as much again while it is decoded.
    let size = size_of::<[f32; 4]>() as u64;
    let most = MOST_PIXELS.min(memory::granted() / 2 / size);
    if pixels > most {
        return Err(context.limit(pixels.saturating_mul(size), most * size));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use splatvol_scene::ImageSize;

    use super::*;

    #[test]
    fn the_extension_of_a_frame_chooses_the_format() {
        let folder = tempfile::tempdir().unwrap();
        let frame = Frame::empty(ImageSize::new(3, 2).unwrap());
        let texts = [("Title".to_owned(), "nothing".to_owned())];
        for (name, has_depth) in [("a.png", false), ("a.EXR", true)] {
            let path = folder.path().join(name);
            write_frame(&path, &frame, &texts).unwrap();
            let loaded = read_image(&path).unwrap();
            assert_eq!(loaded.image, frame.image, "{name}");
            assert_eq!(loaded.depth.is_some(), has_depth, "{name}");
            assert_eq!(
                metadata::find(&loaded.metadata, "Title"),
                Some("nothing"),
                "{name}"
            );
        }
        let error = write_frame(folder.path().join("a.jpg"), &frame, &[]).unwrap_err();
        let text = error.to_string();
        assert!(
            text.starts_with("picture: no writer for the extension \"jpg\""),
            "{text}"
        );
        assert!(text.ends_with("a.jpg"), "{text}");
    }
}
