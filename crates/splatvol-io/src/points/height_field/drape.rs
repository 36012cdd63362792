//! A picture over posts: every post has the mean colour, in linear light, of the pixels around it.

use std::path::Path;

use splatvol_scene::transfer_function::{linear_from_srgb, srgb_from_linear};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use crate::IoError;
use crate::error::Context;
use crate::image::{decode_image, png::srgb8};
use crate::source::read_file;

/// Rows from the north, sRGB and opacity.
pub(in crate::points) struct Picture {
    pub(in crate::points) width: usize,
    pub(in crate::points) height: usize,
    pub(in crate::points) pixels: Vec<[u8; 4]>,
}

/// Colours of posts, row 0 the south. The picture's border is the border of the outermost posts' cells.
pub(super) fn colors(path: &Path, dims: [usize; 2]) -> Result<Vec<[u8; 4]>, IoError> {
    let picture = picture(path)?;
    let table: Vec<f64> = (0..=255u8)
        .map(|code| linear_from_srgb(f64::from(code) / 255.0))
        .collect();
    let [width, height] = dims;
    let mut colors = Vec::with_capacity(width * height);
    for row in 0..height {
        let rows = pixels_of(height - 1 - row, height, picture.height);
        for column in 0..width {
            let columns = pixels_of(column, width, picture.width);
            colors.push(mean(&picture, columns, rows.clone(), &table));
        }
    }
    Ok(colors)
}

/// Pixels, at least one, of a post.
fn pixels_of(post: usize, posts: usize, pixels: usize) -> std::ops::Range<usize> {
    let first = (post * pixels / posts).min(pixels - 1);
    first..((post + 1) * pixels / posts).clamp(first + 1, pixels)
}

fn mean(
    picture: &Picture,
    columns: std::ops::Range<usize>,
    rows: std::ops::Range<usize>,
    table: &[f64],
) -> [u8; 4] {
    let mut sum = [0.0; 4];
    for row in rows.clone() {
        for [r, g, b, a] in &picture.pixels[row * picture.width..][columns.clone()] {
            let alpha = f64::from(*a) / 255.0;
            for (sum, code) in sum.iter_mut().zip([r, g, b]) {
                *sum += alpha * table[usize::from(*code)];
            }
            sum[3] += alpha;
        }
    }
    let count = (rows.len() * columns.len()) as f64;
    let code = |c: f64| (255.0 * c).round() as u8;
    let color = |c: f64| {
        code(if sum[3] > 0.0 {
            srgb_from_linear((c / sum[3]).min(1.0))
        } else {
            0.0
        })
    };
    [color(sum[0]), color(sum[1]), color(sum[2]), code(sum[3] / count)]
}

/// A PNG, JPEG or EXR as codes.
pub(in crate::points) fn picture(path: &Path) -> Result<Picture, IoError> {
    let context = &Context::new("picture", path);
    let bytes = read_file(path, context)?;
    if bytes.starts_with(&[0xff, 0xd8]) {
        return jpeg(&bytes, path);
    }
    let image = decode_image(&bytes, path)?.image;
    Ok(Picture {
        width: image.size().width() as usize,
        height: image.size().height() as usize,
        pixels: srgb8(&image),
    })
}

fn jpeg(bytes: &[u8], path: &Path) -> Result<Picture, IoError> {
    let context = &Context::new("JPEG", path);
    let malformed = |error: zune_jpeg::errors::DecodeErrors| {
        context.field("contents", format!("{error:?}"), None, "a valid JPEG")
    };
    let options = DecoderOptions::default()
        .jpeg_set_out_colorspace(ColorSpace::RGB)
        .set_strict_mode(false);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(malformed)?;
    let (width, height) = decoder
        .info()
        .map_or((0, 0), |info| (usize::from(info.width), usize::from(info.height)));
    // A block of 64 pixels takes at least a few bits.
    let (pixels, at_most) = ((width * height) as u64, (bytes.len() as u64).saturating_mul(1024));
    if pixels == 0 || pixels > at_most {
        return Err(context.too_small("pixels", pixels, at_most));
    }
    let codes = decoder.decode().map_err(malformed)?;
    if codes.len() != 3 * width * height {
        return Err(context.unsupported(format!("{} codes for {width} x {height} pixels", codes.len())));
    }
    Ok(Picture {
        width,
        height,
        pixels: codes.chunks_exact(3).map(|c| [c[0], c[1], c[2], 255]).collect(),
    })
}
