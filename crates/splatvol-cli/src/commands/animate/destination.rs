//! Where an animation goes: one file, or a file per frame.

use std::path::{Path, PathBuf};

use splatvol_io::ImageFormat;
use splatvol_io::animation::{Container, check_ffmpeg};

use crate::args::AnimateArgs;
use crate::failure::{During, Failure, Step};
use crate::output::Target;

/// Kind of output.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Destination {
    /// A picture per frame.
    Frames(FrameNames),
    /// One file of all frames.
    Movie(PathBuf, Container),
}

/// `before####after`, with the frame's number for `####`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct FrameNames {
    folder: PathBuf,
    before: String,
    digits: usize,
    after: String,
    pub(crate) format: ImageFormat,
}

impl FrameNames {
    /// The file of a frame, from 0.
    pub(crate) fn path(&self, frame: u32) -> PathBuf {
        let (before, after) = (&self.before, &self.after);
        self.folder
            .join(format!("{before}{frame:0width$}{after}", width = self.digits))
    }

    /// Refuses before the work what cannot be written after it: names with too few digits, or files that
    /// exist.
    pub(crate) fn check(&self, frames: u32, overwrite: bool) -> Result<(), Failure> {
        let needed = (frames - 1).checked_ilog10().unwrap_or(0) as usize + 1;
        if needed > self.digits {
            return Err(Failure::usage(format!(
                "{frames} frames need {needed} # in the output's name, not {}",
                self.digits
            )));
        }
        (0..frames).try_for_each(|frame| Target::File(self.path(frame)).check(overwrite))
    }
}

impl Destination {
    /// The destination that the output's name asks for. Existing files and missing programs are found now.
    pub(crate) fn new(args: &AnimateArgs) -> Result<Self, Failure> {
        let path = args.render.output.as_deref().unwrap_or(Path::new(""));
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if name.contains('#') {
            return frames(path, &name).map(Self::Frames);
        }
        let Some(container) = Container::from_path(path) else {
            return Err(no_container(path, &name));
        };
        if args.resume {
            return Err(Failure::usage(format!("--resume cannot continue {name}"))
                .hint("frames can be continued: name-####.png"));
        }
        if args.render.picture.bits == Some(16) && container != Container::Apng {
            return Err(Failure::usage(format!("--bits 16 has no meaning for {name}")));
        }
        Target::File(path.to_owned()).check(args.render.write.overwrite)?;
        if let Container::Film(_) = container {
            check_ffmpeg().during(Step::Output).map_err(|failure| {
                failure.hint("install ffmpeg, or write .gif, .apng, or frames (name-####.png), which need no other program")
            })?;
        }
        Ok(Self::Movie(path.to_owned(), container))
    }
}

impl Destination {
    /// Every file of so many frames.
    pub(crate) fn targets(&self, frames: u32) -> impl Iterator<Item = Target> {
        let files = match self {
            Self::Frames(_) => frames,
            Self::Movie(..) => 1,
        };
        (0..files).map(move |frame| match self {
            Self::Frames(names) => Target::File(names.path(frame)),
            Self::Movie(path, _) => Target::File(path.clone()),
        })
    }
}

/// A name that is no animation's.
fn no_container(path: &Path, name: &str) -> Failure {
    match ImageFormat::from_path(path) {
        Some(_) => {
            let extension = path.extension().unwrap_or_default().display();
            Failure::usage(format!("{name} names one picture, not an animation")).hint(format!(
                "name frames like spin-####.{extension}, or one file like spin.apng"
            ))
        }
        None => Failure::usage(format!("{}: no animation has this extension", path.display()))
            .hint("use .gif, .apng, .mp4, .webm, .mov, .mkv, or frames: name-####.png"),
    }
}

fn frames(path: &Path, name: &str) -> Result<FrameNames, Failure> {
    let refused = |why: &str| {
        Failure::usage(format!("{}: {why}", path.display()))
            .hint("name frames like spin-####.png or spin-####.exr")
    };
    let format = ImageFormat::from_path(path).ok_or_else(|| refused("frames are .png or .exr"))?;
    let start = name.find('#').unwrap_or(0);
    let digits = name[start..].bytes().take_while(|&byte| byte == b'#').count();
    let after = &name[start + digits..];
    if after.contains('#') {
        return Err(refused("all # of a name must be together"));
    }
    Ok(FrameNames {
        folder: path.parent().map(Path::to_owned).unwrap_or_default(),
        before: name[..start].to_owned(),
        digits,
        after: after.to_owned(),
        format,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_digits_of_the_frame() {
        let names = |text: &str| {
            let path = Path::new(text);
            let name = path.file_name().unwrap().to_string_lossy();
            frames(path, &name).map_err(|failure| format!("{failure:?}"))
        };
        let found = names("a#b/spin-###x.png").unwrap();
        assert_eq!(found.path(7), Path::new("a#b").join("spin-007x.png"));
        assert!(found.check(1001, false).is_err());
        assert!(names("a-#-#.png").is_err());
        assert!(names("a-#.tiff").is_err());
        assert_eq!(names("#.exr").unwrap().path(3), Path::new("3.exr"));
    }
}
