//! One file of many frames: written beside its place, and moved there when it is whole.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use anyhow::Context;
use splatvol::{Frame, Image};
use splatvol_document::Picture;
use splatvol_io::image::png::Depth;
use splatvol_io::{AnimationSettings, ApngWriter, GifWriter};

use super::destination::Container;
use super::video::Film;
use crate::failure::{During, Failure, Step};
use crate::output::{Scratch, over};

/// A file that grows frame by frame.
pub(crate) struct Movie {
    /// Dropped first: a file that is open may not be removable.
    writer: Writer,
    scratch: Scratch,
    background: Option<[f64; 4]>,
}

enum Writer {
    Gif(GifWriter<BufWriter<File>>),
    Apng(ApngWriter<BufWriter<File>>),
    Film(Film),
}

impl Movie {
    /// Begins the file for frames like those of `picture`, with texts where the format has them.
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
        let scratch = Scratch::beside(path);
        let file = || {
            File::create(scratch.path())
                .map(BufWriter::new)
                .with_context(|| format!("cannot write {}", path.display()))
                .during(Step::Output)
        };
        let writer = match container {
            Container::Gif => Writer::Gif(GifWriter::new(file()?, settings).during(Step::Output)?),
            Container::Apng => {
                Writer::Apng(ApngWriter::new(file()?, settings, metadata).during(Step::Output)?)
            }
            Container::Video(_) if settings.alpha => {
                return Err(Failure::usage("films have no transparency")
                    .hint("give an opaque --background, or write .apng or frames"));
            }
            Container::Video(codec) => Writer::Film(Film::start(scratch.path(), codec, settings.size, fps)?),
        };
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
                laid = over(&frame.image, background);
                &laid
            }
        };
        match &mut self.writer {
            Writer::Gif(gif) => gif.write(image).during(Step::Output),
            Writer::Apng(apng) => apng.write(image).during(Step::Output),
            Writer::Film(film) => film.write(image),
        }
    }

    /// Ends the file and puts it in its place.
    pub(crate) fn finish(self, overwrite: bool) -> Result<(), Failure> {
        match self.writer {
            Writer::Gif(gif) => gif.finish().during(Step::Output)?,
            Writer::Apng(apng) => apng.finish().during(Step::Output)?,
            Writer::Film(film) => film.finish()?,
        }
        self.scratch.keep(overwrite)
    }
}
