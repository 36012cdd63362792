//! Animations, written frame by frame as they come: no frame is kept.
//!
//! | format | colours | alpha | time of a frame |
//! |---|---|---|---|
//! | GIF | 256 per frame | on or off | whole 1/100 s, rounded so that errors do not add up |
//! | animated PNG | 8 or 16 bits per channel | yes | exact for whole frames per second |
//! | film, by `ffmpeg` | 8 bits, halved chroma | no | exact |
//!
//! The first two repeat for ever.

mod apng;
mod film;
mod gif;
mod movie;

use splatvol_scene::{Image, ImageSize};

use crate::IoError;
use crate::image::png::Depth;

pub use apng::ApngWriter;
pub use film::{Codec, FilmWriter, check_ffmpeg};
pub use gif::GifWriter;
pub use movie::{Container, MovieWriter};

/// Settings common to all frames of an animation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AnimationSettings {
    /// Size of every frame.
    pub size: ImageSize,
    /// Number of frames.
    pub frames: u32,
    /// Frames per second.
    pub fps: f64,
    /// Whether frames have transparent pixels.
    pub alpha: bool,
    /// Bits per channel; a GIF has 8.
    pub depth: Depth,
}

impl AnimationSettings {
    fn check(&self, format: &'static str, fps: [f64; 2]) -> Result<(), IoError> {
        let [slowest, fastest] = fps;
        if self.frames == 0 {
            return Err(refused(format, "an animation has at least 1 frame"));
        }
        if !(slowest..=fastest).contains(&self.fps) {
            let what = format!(
                "{} frames per second are not allowed ({slowest} to {fastest})",
                self.fps
            );
            return Err(refused(format, what));
        }
        Ok(())
    }

    fn check_frame(&self, format: &'static str, image: &Image, written: u32) -> Result<(), IoError> {
        if image.size() != self.size {
            let size = |size: ImageSize| format!("{}x{}", size.width(), size.height());
            let what = format!("a frame of {}, not {}", size(image.size()), size(self.size));
            return Err(refused(format, what));
        }
        if written >= self.frames {
            return Err(refused(format, format!("more than {} frames", self.frames)));
        }
        Ok(())
    }
}

fn refused(format: &'static str, what: impl ToString) -> IoError {
    IoError::Encode {
        format,
        what: what.to_string(),
    }
}
