//! Animated PNG (W3C, Portable Network Graphics, 3rd edition, section 4.9): a PNG whose later frames follow in
//! chunks of their own, so that programs without animations show the first.

use std::io::Write;

use splatvol_scene::Image;

use super::{AnimationSettings, refused};
use crate::IoError;
use crate::image::{metadata, png};

const FORMAT: &str = "animated PNG";

/// Writes an animated PNG.
pub struct ApngWriter<W: Write> {
    settings: AnimationSettings,
    writer: ::png::Writer<W>,
    written: u32,
}

impl<W: Write> ApngWriter<W> {
    /// Begins a file; `metadata` as for pictures.
    ///
    /// # Errors
    /// [`IoError::Encode`]: no frames, less than 0.01 or more than 1000 frames per second, metadata that PNG cannot
    /// hold, or what the sink says.
    pub fn new(sink: W, settings: AnimationSettings, metadata: &[(String, String)]) -> Result<Self, IoError> {
        settings.check(FORMAT, [0.01, 1000.0])?;
        metadata::check(FORMAT, metadata)?;
        let begin = || {
            let mut encoder = png::encoder(sink, settings.size, settings.depth, !settings.alpha);
            encoder.set_animated(settings.frames, 0)?;
            let [numerator, denominator] = delay(settings.fps);
            encoder.set_frame_delay(numerator, denominator)?;
            let mut writer = encoder.write_header()?;
            png::write_texts(&mut writer, metadata)?;
            Ok(writer)
        };
        let writer = begin().map_err(|error: ::png::EncodingError| refused(FORMAT, error))?;
        Ok(Self {
            settings,
            writer,
            written: 0,
        })
    }

    /// Adds a frame. Alpha is left out unless the settings have it.
    ///
    /// # Errors
    /// [`IoError::Encode`]: a frame of another size, more frames than announced, or an error of the sink.
    pub fn write(&mut self, image: &Image) -> Result<(), IoError> {
        self.settings.check_frame(FORMAT, image, self.written)?;
        let data = png::data(
            &png::codes(image, self.settings.depth),
            self.settings.depth,
            !self.settings.alpha,
        );
        self.writer
            .write_image_data(&data)
            .map_err(|error| refused(FORMAT, error))?;
        self.written += 1;
        Ok(())
    }

    /// Ends the file.
    ///
    /// # Errors
    /// [`IoError::Encode`]: fewer frames than announced, or an error of the sink.
    pub fn finish(self) -> Result<(), IoError> {
        if self.written != self.settings.frames {
            let what = format!("{} frames of {}", self.written, self.settings.frames);
            return Err(refused(FORMAT, what));
        }
        self.writer.finish().map_err(|error| refused(FORMAT, error))
    }
}

/// Seconds per frame as a fraction of 16-bit numbers.
fn delay(fps: f64) -> [u16; 2] {
    let fraction = |numerator: u16| (numerator, (fps * f64::from(numerator)).round());
    // 29.97 is 100/2997; whole numbers need no scale.
    let fits = |&(_, denominator): &(u16, f64)| denominator >= 1.0 && denominator <= f64::from(u16::MAX);
    let scales = if fps.fract() == 0.0 {
        &[1][..]
    } else {
        &[1000, 100, 10, 1]
    };
    let found = scales.iter().map(|&scale| fraction(scale)).find(fits);
    let (numerator, denominator) = found.unwrap_or((1, 1.0));
    [numerator, denominator as u16]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_are_fractions_of_sixteen_bits() {
        for (fps, expected) in [
            (30.0, [1, 30]),
            (29.97, [1000, 29_970]),
            (0.5, [1000, 500]),
            (0.01, [1000, 10]),
            (120.5, [100, 12_050]),
            (1000.0, [1, 1000]),
        ] {
            assert_eq!(delay(fps), expected, "{fps}");
        }
    }
}
