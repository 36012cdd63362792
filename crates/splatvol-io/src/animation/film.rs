//! Films by the `ffmpeg` found on PATH, which takes raw pictures from a pipe.

use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::JoinHandle;

use splatvol_scene::Image;

use super::AnimationSettings;
use crate::IoError;
use crate::image::png::srgb8;

/// Format, as errors have it.
const FORMAT: &str = "film";

/// Codec of the pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Codec {
    /// In .mp4, .mov and .mkv.
    H264,
    /// In .webm.
    Vp9,
}

impl Codec {
    fn flags(self) -> &'static [&'static str] {
        match self {
            Self::H264 => &["-c:v", "libx264", "-crf", "18", "-movflags", "+faststart"],
            Self::Vp9 => &["-c:v", "libvpx-vp9", "-crf", "24", "-b:v", "0", "-row-mt", "1"],
        }
    }
}

/// From sRGB to BT.709 video with halved chroma, whose sides must be even; the file is tagged as such.
const FILTER: &str = "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv:\
                      flags=bicubic+accurate_rnd+full_chroma_int,format=yuv420p,\
                      setparams=range=tv:colorspace=bt709:color_primaries=bt709:color_trc=iec61966-2-1";

/// Refuses before the work what would fail after it.
///
/// # Errors
/// [`IoError::Encode`]: `ffmpeg` does not run from PATH.
pub fn check_ffmpeg() -> Result<(), IoError> {
    let status = Command::new("ffmpeg")
        .arg("-version")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    let why = match status {
        Ok(status) if status.success() => return Ok(()),
        Ok(status) => format!("it ends with {status}"),
        Err(error) => error.to_string(),
    };
    Err(failed(format!(
        "ffmpeg, which makes films, does not run from PATH ({why})"
    )))
}

fn failed(what: String) -> IoError {
    IoError::Encode { format: FORMAT, what }
}

/// A film in the making: a running ffmpeg, which is stopped when this is dropped before the end.
#[derive(Debug)]
pub struct FilmWriter {
    child: Child,
    messages: Option<JoinHandle<String>>,
}

impl FilmWriter {
    /// Starts a film at `path`.
    ///
    /// # Errors
    /// [`IoError::Encode`]: frames with alpha, which films have not; an ffmpeg that does not start.
    pub fn new(path: &Path, codec: Codec, settings: AnimationSettings) -> Result<Self, IoError> {
        let AnimationSettings { size, fps, alpha, .. } = settings;
        if alpha {
            return Err(failed("films have no transparency".to_owned()));
        }
        let mut child = Command::new("ffmpeg")
            .args([
                "-loglevel",
                "error",
                "-nostdin",
                "-y",
                "-f",
                "rawvideo",
                "-pixel_format",
                "rgb24",
            ])
            .args(["-video_size", &format!("{}x{}", size.width(), size.height())])
            .args([
                "-framerate",
                &fps.to_string(),
                "-i",
                "pipe:0",
                "-an",
                "-vf",
                FILTER,
            ])
            .args(codec.flags())
            // With a folder in front, a name that begins with a dash is not a flag.
            .arg(if path.is_relative() {
                Path::new(".").join(path)
            } else {
                path.to_owned()
            })
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|error| failed(format!("cannot start ffmpeg: {error}")))?;
        // Read as it comes: a full pipe would stop ffmpeg.
        let messages = child.stderr.take().map(|mut stderr| {
            std::thread::spawn(move || {
                let mut bytes = Vec::new();
                // Messages that cannot be read cannot be reported.
                let _ = stderr.read_to_end(&mut bytes);
                String::from_utf8_lossy(&bytes).trim().to_owned()
            })
        });
        Ok(Self { child, messages })
    }

    /// Adds a picture, whose alpha is left out.
    ///
    /// # Errors
    /// [`IoError::Encode`] with ffmpeg's messages.
    pub fn write(&mut self, image: &Image) -> Result<(), IoError> {
        let bytes: Vec<u8> = srgb8(image).iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
        let written = match &mut self.child.stdin {
            Some(pipe) => pipe.write_all(&bytes),
            None => Ok(()),
        };
        match written {
            Ok(()) => Ok(()),
            // ffmpeg has ended; its messages say why.
            Err(error) => self
                .end()
                .and(Err(failed(format!("cannot write to ffmpeg: {error}")))),
        }
    }

    /// Waits until the film is complete.
    ///
    /// # Errors
    /// [`IoError::Encode`] with ffmpeg's messages.
    pub fn finish(mut self) -> Result<(), IoError> {
        self.end()
    }

    fn end(&mut self) -> Result<(), IoError> {
        drop(self.child.stdin.take());
        let status = self
            .child
            .wait()
            .map_err(|error| failed(format!("cannot wait for ffmpeg: {error}")))?;
        let messages = self
            .messages
            .take()
            .and_then(|thread| thread.join().ok())
            .unwrap_or_default();
        if status.success() {
            return Ok(());
        }
        Err(failed(format!("ffmpeg failed ({status}): {messages}")))
    }
}

impl Drop for FilmWriter {
    fn drop(&mut self) {
        // It may have ended long ago.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
