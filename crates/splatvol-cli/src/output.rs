//! Writing results: never over an existing file without a request, never half a file.

use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;
use splatvol::Frame;
use splatvol_document::resolve::laid_over;
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
        check_replaceable(path)?;
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

/// Refuses results that would go to the same place: the later one would replace the earlier one.
pub(crate) fn check_distinct(results: &[(&str, &Target)]) -> Result<(), Failure> {
    for (i, (name, target)) in results.iter().enumerate() {
        for (other, earlier) in &results[..i] {
            match (earlier, target) {
                (Target::Stdout, Target::Stdout) => {
                    return Err(Failure::usage(format!(
                        "{other} and {name} cannot both go to stdout"
                    )));
                }
                (Target::File(a), Target::File(b)) if place_of(a) == place_of(b) => {
                    let file = b.display();
                    return Err(Failure::usage(format!(
                        "{other} and {name} cannot go to the same file, {file}"
                    )));
                }
                _ => (),
            }
        }
    }
    Ok(())
}

/// The file that a path names, links followed as far as they lead somewhere.
fn place_of(path: &Path) -> PathBuf {
    if let Ok(place) = path.canonicalize() {
        return place;
    }
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    match (folder.canonicalize(), path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.to_owned(),
    }
}

/// Refuses paths at which something other than a regular file lies: a rename would replace a device or a pipe.
fn check_replaceable(path: &Path) -> Result<(), Failure> {
    let kind = match fs::symlink_metadata(path) {
        Err(_) => return Ok(()),
        Ok(found) if found.is_symlink() => match fs::metadata(path) {
            Ok(target) => target.file_type(),
            Err(_) => {
                let message = format!("output {} is a link that leads nowhere", path.display());
                return Err(anyhow::anyhow!(message)).during(Step::Output);
            }
        },
        Ok(found) => found.file_type(),
    };
    let what = match kind {
        kind if kind.is_file() => return Ok(()),
        kind if kind.is_dir() => "a folder",
        _ => "neither a regular file nor a new one",
    };
    let refused = Err(anyhow::anyhow!("output {} is {what}", path.display())).during(Step::Output);
    refused.map_err(|failure| failure.hint("- writes to stdout, which can be sent anywhere"))
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
        (_, Some(background)) => encode_image(&laid_over(&frame.image, background), None, format, metadata),
    }
    .during(Step::Output)
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

/// A file beside its place, with the same extension, until it is complete; if dropped before, it is removed.
pub(crate) struct Scratch {
    scratch: PathBuf,
    place: PathBuf,
}

impl Scratch {
    /// For a file at `path`; nothing is created yet.
    pub(crate) fn beside(path: &Path) -> Self {
        // Beside the file that a link leads to, which may be on another disk.
        let place = place_of(path);
        let name = place.file_name().unwrap_or_default().to_string_lossy();
        Self {
            scratch: place.with_file_name(format!(".{}.{name}", std::process::id())),
            place,
        }
    }

    /// Where to write.
    pub(crate) fn path(&self) -> &Path {
        &self.scratch
    }

    /// Moves the file to its place.
    pub(crate) fn keep(self, overwrite: bool) -> Result<(), Failure> {
        let failed = || format!("cannot write {}", self.place.display());
        if overwrite {
            // It may have become something else during the work.
            check_replaceable(&self.place)?;
        } else {
            // Claims the name, so that a file that appeared meanwhile survives.
            let mut claim = OpenOptions::new();
            let claimed = claim.write(true).create_new(true).open(&self.place);
            claimed.map(drop).with_context(failed).during(Step::Output)?;
        }
        let moved = fs::rename(&self.scratch, &self.place);
        if moved.is_err() && !overwrite {
            // The claim is empty: nobody wants it.
            let _ = fs::remove_file(&self.place);
        }
        moved.with_context(failed).during(Step::Output)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // It may have been moved, or may never have been created.
        let _ = fs::remove_file(&self.scratch);
    }
}
