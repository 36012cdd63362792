//! One file of many frames, in the format that its name asks for.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use splatvol_scene::Image;

use super::film::{Codec, FilmWriter};
use super::{AnimationSettings, ApngWriter, GifWriter};
use crate::IoError;

/// Formats of one file with many frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Container {
    /// `.gif`.
    Gif,
    /// `.apng`.
    Apng,
    /// `.mp4`, `.mov`, `.mkv` and `.webm`, made by ffmpeg.
    Film(Codec),
}

impl Container {
    /// The format of a file's extension.
    pub fn from_path(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_ascii_lowercase();
        match extension.to_str()? {
            "gif" => Some(Self::Gif),
            "apng" => Some(Self::Apng),
            "mp4" | "mov" | "mkv" => Some(Self::Film(Codec::H264)),
            "webm" => Some(Self::Film(Codec::Vp9)),
            _ => None,
        }
    }
}

/// A file that grows frame by frame.
pub struct MovieWriter(Writer);

enum Writer {
    Gif(GifWriter<BufWriter<File>>),
    Apng(ApngWriter<BufWriter<File>>),
    Film(FilmWriter),
}

impl MovieWriter {
    /// Begins the file, with texts if the format has them.
    ///
    /// # Errors
    /// [`IoError::Write`] for a file that cannot be written, [`IoError::Encode`] for settings that the format does not have.
    pub fn create(
        path: &Path,
        container: Container,
        settings: AnimationSettings,
        metadata: &[(String, String)],
    ) -> Result<Self, IoError> {
        let file = || {
            File::create(path)
                .map(BufWriter::new)
                .map_err(|source| IoError::Write {
                    source,
                    path: path.to_owned(),
                })
        };
        Ok(Self(match container {
            Container::Gif => Writer::Gif(GifWriter::new(file()?, settings)?),
            Container::Apng => Writer::Apng(ApngWriter::new(file()?, settings, metadata)?),
            Container::Film(codec) => Writer::Film(FilmWriter::new(path, codec, settings)?),
        }))
    }

    /// Adds a frame, laid over its background.
    ///
    /// # Errors
    /// Those of the format's writer.
    pub fn write(&mut self, image: &Image) -> Result<(), IoError> {
        match &mut self.0 {
            Writer::Gif(gif) => gif.write(image),
            Writer::Apng(apng) => apng.write(image),
            Writer::Film(film) => film.write(image),
        }
    }

    /// Ends the file.
    ///
    /// # Errors
    /// Those of the format's writer; fewer frames than promised.
    pub fn finish(self) -> Result<(), IoError> {
        match self.0 {
            Writer::Gif(gif) => gif.finish(),
            Writer::Apng(apng) => apng.finish(),
            Writer::Film(film) => film.finish(),
        }
    }
}
