//! Writing results: never over an existing file unasked, never half a file.

use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;
use splatvol::transfer_function::linear_from_srgb;
use splatvol::{Frame, Image};
use splatvol_io::{ImageFormat, encode_image};

use crate::failure::{During, Failure, Step};

/// Where a result goes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Target {
    /// Standard output.
    Stdout,
    /// A file.
    File(PathBuf),
}

impl Target {
    /// `-` is standard output.
    pub(crate) fn new(path: &Path) -> Self {
        if path == Path::new("-") {
            Self::Stdout
        } else {
            Self::File(path.to_owned())
        }
    }

    /// Refuses early what [`Target::write`] would refuse after all the work.
    pub(crate) fn check(&self, overwrite: bool) -> Result<(), Failure> {
        let Self::File(path) = self else {
            return Ok(());
        };
        if path.is_dir() {
            return Err(anyhow::anyhow!("output {} is a folder", path.display())).during(Step::Output);
        }
        if path.exists() && !overwrite {
            return Err(exists(path));
        }
        match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
                Err(anyhow::anyhow!("folder {} does not exist", folder.display())).during(Step::Output)
            }
            _ => Ok(()),
        }
    }

    /// Writes all bytes, or leaves what was there.
    pub(crate) fn write(&self, bytes: &[u8], overwrite: bool) -> Result<(), Failure> {
        match self {
            Self::Stdout => {
                let mut stdout = std::io::stdout().lock();
                stdout
                    .write_all(bytes)
                    .and_then(|()| stdout.flush())
                    .context("cannot write to stdout")
                    .during(Step::Output)
            }
            Self::File(path) => replace(path, overwrite, |scratch| {
                let mut file = File::create(scratch)?;
                file.write_all(bytes)?;
                Ok(file.sync_all()?)
            }),
        }
    }
}

/// The picture format of a file's extension.
pub(crate) fn picture_format(path: &Path) -> Result<ImageFormat, Failure> {
    ImageFormat::from_path(path).ok_or_else(|| {
        Failure::usage(format!(
            "{}: no picture format has this extension",
            path.display()
        ))
        .hint("use .png or .exr")
    })
}

/// A frame as a picture file: EXR keeps alpha and depth; a PNG is laid over the background (sRGB, straight alpha).
pub(crate) fn encode_frame(
    frame: &Frame,
    format: ImageFormat,
    background: Option<[f64; 4]>,
    metadata: &[(String, String)],
) -> Result<Vec<u8>, Failure> {
    match (format, background) {
        (ImageFormat::Exr, _) => encode_image(&frame.image, Some(&frame.depth), format, metadata),
        (_, None) => encode_image(&frame.image, None, format, metadata),
        (_, Some(background)) => encode_image(&over(&frame.image, background), None, format, metadata),
    }
    .during(Step::Output)
}

/// A picture over a background (sRGB, straight alpha).
pub(crate) fn over(image: &Image, [r, g, b, a]: [f64; 4]) -> Image {
    let [r, g, b] = [r, g, b].map(|c| linear_from_srgb(c) as f32);
    image.over([r, g, b, a as f32])
}

fn exists(path: &Path) -> Failure {
    Err::<(), _>(anyhow::anyhow!("{} already exists", path.display()))
        .during(Step::Output)
        .expect_err("is an error")
        .hint("-w overwrites it, -o names another file")
}

/// Lets `write` fill a scratch file beside `path`, with the same extension, and moves it there when it is complete.
pub(crate) fn replace(
    path: &Path,
    overwrite: bool,
    write: impl FnOnce(&Path) -> anyhow::Result<()>,
) -> Result<(), Failure> {
    let scratch = Scratch::beside(path);
    write(scratch.path())
        .with_context(|| format!("cannot write {}", path.display()))
        .during(Step::Output)?;
    scratch.keep(overwrite)
}

/// A file beside its place, with the same extension, until it is whole; dropped before, it goes away.
pub(crate) struct Scratch {
    scratch: PathBuf,
    place: PathBuf,
}

impl Scratch {
    /// For a file at `path`; nothing is created yet.
    pub(crate) fn beside(path: &Path) -> Self {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        Self {
            scratch: path.with_file_name(format!(".{}.{name}", std::process::id())),
            place: path.to_owned(),
        }
    }

    /// Where to write.
    pub(crate) fn path(&self) -> &Path {
        &self.scratch
    }

    /// Moves the file to its place.
    pub(crate) fn keep(self, overwrite: bool) -> Result<(), Failure> {
        let claimed = if overwrite {
            Ok(())
        } else {
            // Claims the name, so that a file that appeared meanwhile survives.
            let mut claim = OpenOptions::new();
            claim.write(true).create_new(true).open(&self.place).map(drop)
        };
        claimed
            .and_then(|()| fs::rename(&self.scratch, &self.place))
            .with_context(|| format!("cannot write {}", self.place.display()))
            .during(Step::Output)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // It may have been moved, or may never have come to be.
        let _ = fs::remove_file(&self.scratch);
    }
}
