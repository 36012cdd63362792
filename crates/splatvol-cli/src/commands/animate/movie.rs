//! One file of many frames: written beside its place, and moved there when it is complete.

use std::path::Path;

use anyhow::Context;
use splatvol::{Frame, Image};
use splatvol_document::Picture;
use splatvol_document::resolve::laid_over;
use splatvol_io::AnimationSettings;
use splatvol_io::animation::{Container, MovieWriter};
use splatvol_io::image::png::Depth;

use crate::failure::{During, Failure, Step};
use crate::output::Scratch;

/// A file that grows frame by frame.
pub(crate) struct Movie {
    /// Dropped first: an open file may not be removable.
    writer: MovieWriter,
    scratch: Scratch,
    background: Option<[f64; 4]>,
}

impl Movie {
    /// Begins the file for frames like those of `picture`, with texts if the format has them.
    pub(crate) fn start(
        path: &Path,
        container: Container,
        (picture, metadata): (&Picture, &[(String, String)]),
        (frames, fps): (u32, f64),
    ) -> Result<Self, Failure> {
        let settings = AnimationSettings {
            size: picture.settings.size,
            frames,
            fps,
            alpha: picture.background().is_none_or(|[.., alpha]| alpha < 1.0),
            depth: if picture.bits() == 16 {
                Depth::Sixteen
            } else {
                Depth::Eight
            },
        };
        if let (Container::Film(_), true) = (container, settings.alpha) {
            return Err(Failure::usage("films have no transparency")
                .hint("give an opaque --background, or write .apng or frames"));
        }
        let scratch = Scratch::beside(path);
        let writer = MovieWriter::create(scratch.path(), container, settings, metadata)
            .with_context(|| format!("cannot write {}", path.display()))
            .during(Step::Output)?;
        Ok(Self {
            writer,
            scratch,
            background: picture.background(),
        })
    }

    /// Adds a frame.
    pub(crate) fn write(&mut self, frame: &Frame) -> Result<(), Failure> {
        let laid: Image;
        let image = match self.background {
            None => &frame.image,
            Some(background) => {
                laid = laid_over(&frame.image, background);
                &laid
            }
        };
        self.writer.write(image).during(Step::Output)
    }

    /// Ends the file and puts it in its place.
    pub(crate) fn finish(self, overwrite: bool) -> Result<(), Failure> {
        self.writer.finish().during(Step::Output)?;
        self.scratch.keep(overwrite)
    }
}
