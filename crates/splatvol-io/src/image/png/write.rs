//! Writing PNG, whole or some rows at a time: the bytes do not depend on how many.

use std::fs::File;
use std::io::{BufReader, BufWriter, Write};
use std::path::Path;

use png::text_metadata::{ITXtChunk, TEXtChunk};
use png::{BitDepth, ColorType, SrgbRenderingIntent, StreamWriter};
use splatvol_scene::{Image, ImageSize};

use super::{Depth, codes};
use crate::IoError;
use crate::image::metadata;

/// Texts longer than this are compressed.
const LONG_TEXT: usize = 1024;
/// Bytes of a chunk of compressed pixels.
const CHUNK: usize = 1 << 16;

/// A picture as the bytes of a PNG file.
///
/// # Errors
/// [`IoError::Encode`] for metadata that PNG cannot hold.
pub fn encode(image: &Image, depth: Depth, metadata: &[(String, String)]) -> Result<Vec<u8>, IoError> {
    metadata::check("PNG", metadata)?;
    let codes = codes(image, depth);
    let is_opaque = are_opaque(&codes, depth);
    let mut bytes = Vec::new();
    let mut writer = begin(&mut bytes, image.size(), (depth, is_opaque), metadata)?;
    let mut rows = writer.stream_writer_with_size(CHUNK).map_err(failed)?;
    rows.write_all(&data(&codes, depth, is_opaque)).map_err(failed)?;
    rows.finish().map_err(failed)?;
    drop(writer);
    Ok(bytes)
}

fn failed(error: impl std::fmt::Display) -> IoError {
    IoError::Encode {
        format: "PNG",
        what: error.to_string(),
    }
}

fn are_opaque(codes: &[[u16; 4]], depth: Depth) -> bool {
    codes.iter().all(|code| f64::from(code[3]) == depth.largest())
}

/// A file up to its pixels.
fn begin<W: Write>(
    sink: W,
    size: ImageSize,
    (depth, is_opaque): (Depth, bool),
    metadata: &[(String, String)],
) -> Result<png::Writer<W>, IoError> {
    let mut writer = encoder(sink, size, depth, is_opaque)
        .write_header()
        .map_err(failed)?;
    write_texts(&mut writer, metadata).map_err(failed)?;
    Ok(writer)
}

/// As [`begin`], for pixels that come row by row.
fn begin_file(
    file: File,
    size: ImageSize,
    codes: (Depth, bool),
    metadata: &[(String, String)],
) -> Result<StreamWriter<'static, BufWriter<File>>, IoError> {
    begin(BufWriter::new(file), size, codes, metadata)?
        .into_stream_writer_with_size(CHUNK)
        .map_err(failed)
}

/// A PNG file that is written some rows at a time, from the top: it has the bytes of [`encode`] of the whole picture.
pub struct PngRows {
    writer: StreamWriter<'static, BufWriter<File>>,
    size: ImageSize,
    depth: Depth,
    metadata: Vec<(String, String)>,
    /// Whether it is written without alpha.
    is_rgb: bool,
    /// Whether all pixels so far are opaque.
    is_opaque: bool,
}

impl std::fmt::Debug for PngRows {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter
            .debug_struct("PngRows")
            .field("size", &self.size)
            .field("depth", &self.depth)
            .finish_non_exhaustive()
    }
}

impl PngRows {
    /// Begins a file. `is_opaque`: whether all pixels are known to be.
    ///
    /// # Errors
    /// [`IoError::Write`], and [`IoError::Encode`] for metadata that PNG cannot hold.
    pub fn new(
        path: &Path,
        size: ImageSize,
        (depth, is_opaque): (Depth, bool),
        metadata: &[(String, String)],
    ) -> Result<Self, IoError> {
        metadata::check("PNG", metadata)?;
        let file = File::create(path).map_err(|source| IoError::Write {
            source,
            path: path.to_owned(),
        })?;
        Ok(Self {
            writer: begin_file(file, size, (depth, is_opaque), metadata)?,
            size,
            depth,
            metadata: metadata.to_vec(),
            is_rgb: is_opaque,
            is_opaque: true,
        })
    }

    /// Writes the next rows, as wide as the picture.
    ///
    /// # Errors
    /// A file that cannot be written, rows of another width, pixels that are not opaque as was said.
    pub fn write(&mut self, rows: &Image) -> Result<(), IoError> {
        if rows.size().width() != self.size.width() {
            let (found, expected) = (rows.size().width(), self.size.width());
            return Err(failed(format!(
                "rows of {found} pixels in a picture of {expected}"
            )));
        }
        let codes = codes(rows, self.depth);
        self.is_opaque &= are_opaque(&codes, self.depth);
        if self.is_rgb && !self.is_opaque {
            return Err(failed("a picture without alpha has pixels that are not opaque"));
        }
        self.writer
            .write_all(&data(&codes, self.depth, self.is_rgb))
            .map_err(failed)
    }

    /// Completes the file at `path`, where it was begun; `scratch` is a place for another, of which nothing stays.
    ///
    /// # Errors
    /// A file that cannot be written, rows that are missing.
    pub fn finish(self, path: &Path, scratch: &Path) -> Result<(), IoError> {
        self.writer.finish().map_err(failed)?;
        if self.is_rgb || !self.is_opaque {
            return Ok(());
        }
        // As for whole pictures, one without transparent pixels has no alpha.
        let decoder = png::Decoder::new(BufReader::new(File::open(path).map_err(failed)?));
        let mut reader = decoder.read_info().map_err(failed)?;
        let file = File::create(scratch).map_err(failed)?;
        let mut writer = begin_file(file, self.size, (self.depth, true), &self.metadata)?;
        let bytes = match self.depth {
            Depth::Eight => 1,
            Depth::Sixteen => 2,
        };
        while let Some(row) = reader.next_row().map_err(failed)? {
            for pixel in row.data().chunks_exact(4 * bytes) {
                writer.write_all(&pixel[..3 * bytes]).map_err(failed)?;
            }
        }
        writer.finish().map_err(failed)?;
        std::fs::rename(scratch, path).map_err(failed)
    }
}

/// An encoder of RGB (opaque) or RGBA in sRGB.
pub(crate) fn encoder<W: Write>(
    sink: W,
    size: ImageSize,
    depth: Depth,
    opaque: bool,
) -> png::Encoder<'static, W> {
    let mut encoder = png::Encoder::new(sink, size.width(), size.height());
    encoder.set_color(if opaque { ColorType::Rgb } else { ColorType::Rgba });
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    encoder.set_depth(match depth {
        Depth::Eight => BitDepth::Eight,
        Depth::Sixteen => BitDepth::Sixteen,
    });
    encoder
}

/// Text chunks, compressed where they are long.
pub(crate) fn write_texts<W: Write>(
    writer: &mut png::Writer<W>,
    metadata: &[(String, String)],
) -> Result<(), png::EncodingError> {
    for (keyword, text) in metadata {
        if text.is_ascii() && text.len() <= LONG_TEXT {
            writer.write_text_chunk(&TEXtChunk::new(keyword, text))?;
        } else {
            let mut chunk = ITXtChunk::new(keyword, text);
            chunk.compressed = text.len() > LONG_TEXT;
            writer.write_text_chunk(&chunk)?;
        }
    }
    Ok(())
}

/// Codes as PNG orders their bytes; without alpha where opaque.
pub(crate) fn data(codes: &[[u16; 4]], depth: Depth, opaque: bool) -> Vec<u8> {
    let channels = if opaque { 3 } else { 4 };
    let kept = codes.iter().flat_map(|code| &code[..channels]);
    match depth {
        Depth::Eight => kept.map(|&code| code as u8).collect(),
        Depth::Sixteen => kept.flat_map(|code| code.to_be_bytes()).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_make_the_bytes_of_the_whole_picture() {
        let size = ImageSize::new(40, 37).unwrap();
        let texts = [("Title".to_owned(), "rows".to_owned())];
        for (alpha, depth, said) in [
            (1.0, Depth::Eight, true),
            (1.0, Depth::Eight, false),
            (1.0, Depth::Sixteen, false),
            (0.5, Depth::Sixteen, false),
        ] {
            let pixels = (0..40 * 37)
                .map(|i| [0.3 * alpha, (i % 40) as f32 / 50.0, 0.1, alpha])
                .collect();
            let image = Image::from_pixels(size, pixels).unwrap();
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("a.png");
            let mut rows = PngRows::new(&path, size, (depth, said), &texts).unwrap();
            for band in image.pixels.chunks(40 * 10) {
                let size = ImageSize::new(40, (band.len() / 40) as u32).unwrap();
                rows.write(&Image::from_pixels(size, band.to_vec()).unwrap())
                    .unwrap();
            }
            rows.finish(&path, &folder.path().join("b.png")).unwrap();
            assert!(std::fs::read(&path).unwrap() == encode(&image, depth, &texts).unwrap());
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        }
    }

    #[test]
    fn pictures_that_are_not_as_was_said_are_errors() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let size = ImageSize::new(4, 4).unwrap();
        let image = |width, height, alpha| {
            Image::filled(ImageSize::new(width, height).unwrap(), [0.0, 0.0, 0.0, alpha])
        };
        let begin = |said| PngRows::new(&path, size, (Depth::Eight, said), &[]).unwrap();
        let error = begin(false).write(&image(5, 1, 1.0)).unwrap_err().to_string();
        assert!(error.contains("rows of 5 pixels"), "{error}");
        let error = begin(true).write(&image(4, 1, 0.5)).unwrap_err().to_string();
        assert!(error.contains("not opaque"), "{error}");
        let mut short = begin(true);
        short.write(&image(4, 3, 1.0)).unwrap();
        assert!(short.finish(&path, &folder.path().join("b")).is_err());
    }
}
