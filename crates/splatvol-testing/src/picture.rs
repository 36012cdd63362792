//! Pictures as PNG files.
//!
//! Straight-alpha sRGB, as PNG prescribes. 16 bits keep a snapshot's premultiplied linear values to about 3e-5;
//! [`quantised`] returns the picture after the round trip. Values outside 0..1 (straight) are clipped.

use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter};
use std::path::Path;

use splatvol_scene::transfer_function::{linear_from_srgb, srgb_from_linear};
use splatvol_scene::{Image, ImageSize};

const MAX_16: f64 = 65_535.0;

/// Straight sRGB, 16 bits, of one premultiplied linear pixel.
fn encode(pixel: [f32; 4]) -> [u16; 4] {
    let [r, g, b, alpha] = pixel.map(f64::from);
    let level = |value: f64| (value.clamp(0.0, 1.0) * MAX_16).round() as u16;
    let color = [r, g, b].map(|c| {
        if alpha > 0.0 {
            level(srgb_from_linear(c / alpha))
        } else {
            0
        }
    });
    [color[0], color[1], color[2], level(alpha)]
}

fn decode(levels: [u16; 4]) -> [f32; 4] {
    let [r, g, b, alpha] = levels.map(|level| f64::from(level) / MAX_16);
    let [r, g, b] = [r, g, b].map(|c| linear_from_srgb(c) * alpha);
    [r, g, b, alpha].map(|c| c as f32)
}

/// The picture after a round trip through a file.
///
/// # Panics
/// Never: the size is that of a picture.
pub fn quantised(image: &Image) -> Image {
    let pixels = image.pixels.iter().map(|&pixel| decode(encode(pixel))).collect();
    Image::from_pixels(image.size(), pixels).expect("the same number of pixels")
}

/// Writes a 16-bit PNG, and the folders above it.
///
/// # Errors
/// Errors of the file system.
pub fn write(path: &Path, image: &Image) -> io::Result<()> {
    let levels = image.pixels.iter().flat_map(|&pixel| encode(pixel));
    let data: Vec<u8> = levels.flat_map(u16::to_be_bytes).collect();
    write_png(
        path,
        image.size(),
        (png::ColorType::Rgba, png::BitDepth::Sixteen),
        &data,
    )
}

/// Writes an opaque 8-bit sRGB PNG of values that are already encoded, and the folders above it.
///
/// # Errors
/// Errors of the file system, or data that do not fit the size.
pub(crate) fn write_rgb8(path: &Path, size: ImageSize, data: &[u8]) -> io::Result<()> {
    write_png(path, size, (png::ColorType::Rgb, png::BitDepth::Eight), data)
}

fn write_png(
    path: &Path,
    size: ImageSize,
    (color, depth): (png::ColorType, png::BitDepth),
    data: &[u8],
) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let mut encoder = png::Encoder::new(BufWriter::new(File::create(path)?), size.width(), size.height());
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(data)?;
    Ok(writer.finish()?)
}

/// Reads a PNG that [`write()`] wrote.
///
/// # Errors
/// Errors of the file system, or a PNG that is not 16-bit RGBA.
pub fn read(path: &Path) -> io::Result<Image> {
    let invalid = |what: String| io::Error::new(io::ErrorKind::InvalidData, what);
    let mut reader = png::Decoder::new(BufReader::new(File::open(path)?)).read_info()?;
    let (width, height) = reader.info().size();
    let size = ImageSize::new(width, height).map_err(|error| invalid(error.to_string()))?;
    let format = reader.output_color_type();
    if format != (png::ColorType::Rgba, png::BitDepth::Sixteen) {
        return Err(invalid(format!(
            "{}: {format:?} is not 16-bit RGBA",
            path.display()
        )));
    }
    let mut data = vec![0; 8 * size.pixel_count()];
    reader.next_frame(&mut data)?;
    let level = |bytes: &[u8], c: usize| u16::from_be_bytes([bytes[2 * c], bytes[2 * c + 1]]);
    let pixels = data
        .chunks_exact(8)
        .map(|bytes| decode(std::array::from_fn(|c| level(bytes, c))))
        .collect();
    Image::from_pixels(size, pixels).map_err(|error| invalid(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;

    #[test]
    fn pictures_survive_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/b.png");
        let mut random = Random::new(1);
        let mut pixel = || {
            let alpha = random.unit();
            [
                random.unit() * alpha,
                random.unit() * alpha,
                random.unit() * alpha,
                alpha,
            ]
            .map(|c| c as f32)
        };
        let size = ImageSize::new(17, 5).unwrap();
        let image = Image::from_pixels(size, (0..85).map(|_| pixel()).collect()).unwrap();
        write(&path, &image).unwrap();
        let back = read(&path).unwrap();
        assert_eq!(back, quantised(&image));
        let pairs = back.pixels.iter().flatten().zip(image.pixels.iter().flatten());
        assert!(pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) < 4e-5);
    }
}
