//! Films by the `ffmpeg` found on PATH, which takes raw pictures from a pipe.

use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::JoinHandle;

use anyhow::{Context, anyhow};
use splatvol::{Image, ImageSize};
use splatvol_io::image::png::srgb8;

use crate::failure::{During, Failure, Step};

/// Codec of the pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Codec {
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

/// sRGB to BT.709 video of halved chroma, whose sides must be even; and that it says so.
const FILTER: &str = "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv:\
                      flags=bicubic+accurate_rnd+full_chroma_int,format=yuv420p,\
                      setparams=range=tv:colorspace=bt709:color_primaries=bt709:color_trc=iec61966-2-1";

/// Refuses before the work what would fail after it.
pub(crate) fn check_ffmpeg() -> Result<(), Failure> {
    let status = Command::new("ffmpeg")
        .arg("-version")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    let runs = status
        .map_err(anyhow::Error::from)
        .and_then(|status| match status.success() {
            true => Ok(()),
            false => Err(anyhow!("it ends with {status}")),
        });
    runs.context("films are made by ffmpeg, which does not run from PATH")
        .during(Step::Output)
        .map_err(|failure| {
            failure.hint("install ffmpeg, or write .gif, .apng, or frames (name-####.png), which need no other program")
        })
}

/// A running ffmpeg. It is stopped when dropped before the end.
pub(crate) struct Film {
    child: Child,
    messages: Option<JoinHandle<String>>,
}

impl Film {
    /// Starts a film of `size` at `path`.
    pub(crate) fn start(path: &Path, codec: Codec, size: ImageSize, fps: f64) -> Result<Self, Failure> {
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
            // A name that begins with a dash is no flag behind a folder.
            .arg(if path.is_relative() {
                Path::new(".").join(path)
            } else {
                path.to_owned()
            })
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .context("cannot start ffmpeg")
            .during(Step::Output)?;
        // Read as it comes: a full pipe would stop ffmpeg.
        let messages = child.stderr.take().map(|mut stderr| {
            std::thread::spawn(move || {
                let mut bytes = Vec::new();
                // What cannot be read cannot be told.
                let _ = stderr.read_to_end(&mut bytes);
                String::from_utf8_lossy(&bytes).trim().to_owned()
            })
        });
        Ok(Self { child, messages })
    }

    /// Adds a picture, whose alpha is left out.
    pub(crate) fn write(&mut self, image: &Image) -> Result<(), Failure> {
        let bytes: Vec<u8> = srgb8(image).iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
        let written = match &mut self.child.stdin {
            Some(pipe) => pipe.write_all(&bytes),
            None => Ok(()),
        };
        match written {
            Ok(()) => Ok(()),
            // It ended; it says why.
            Err(error) => self
                .end()
                .and(Err(error).context("cannot write to ffmpeg").during(Step::Output)),
        }
    }

    /// Waits until the film is whole.
    pub(crate) fn finish(mut self) -> Result<(), Failure> {
        self.end()
    }

    fn end(&mut self) -> Result<(), Failure> {
        drop(self.child.stdin.take());
        let status = self
            .child
            .wait()
            .context("cannot wait for ffmpeg")
            .during(Step::Output)?;
        let messages = self
            .messages
            .take()
            .and_then(|thread| thread.join().ok())
            .unwrap_or_default();
        if status.success() {
            return Ok(());
        }
        Err(anyhow!("ffmpeg failed ({status}): {messages}")).during(Step::Output)
    }
}

impl Drop for Film {
    fn drop(&mut self) {
        // It may have ended long ago.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
