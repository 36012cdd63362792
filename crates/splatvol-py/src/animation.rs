//! Animations: the documents of their frames, and files of many frames.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use pyo3::prelude::*;
use splatvol_document::{CameraMotion, Document, Plan, ReadRules, Reading, Record, Resolving, Silent};
use splatvol_io::AnimationSettings;
use splatvol_io::animation::{Container, MovieWriter, check_ffmpeg};
use splatvol_io::image::png::Depth;

use crate::data::Data;
use crate::error::{Raise, refused};
use crate::frame::Frame;
use crate::{chunks, work};

/// The frames of an animation, each a document.
#[pyclass(frozen)]
#[derive(Debug)]
pub(crate) struct Animation {
    document: Document,
    plan: Plan,
    rate: f64,
}

#[pymethods]
impl Animation {
    /// The frames of a document, JSON, that has a table `animation`.
    #[new]
    fn new(py: Python<'_>, document: &str, held: Vec<Option<Bound<'_, Data>>>) -> PyResult<Self> {
        let mut asked = Document::from_json(document, "document".as_ref()).map_err(Raise::raised)?;
        // Frames have the motion of the path's camera, not of an earlier picture's.
        asked.motion.camera = None;
        asked.motion.sub_frames = None;
        let held: Vec<_> = held
            .into_iter()
            .map(|data| data.map(|data| data.get().held.clone()))
            .collect();
        work::run(py, (None, None), |_| {
            let reading = Reading {
                rules: ReadRules {
                    chunks: Some(chunks::chunk_rules(None)),
                    ..ReadRules::default()
                },
                folder: None,
                listener: &Silent,
            };
            let animation = asked.animation.loaded(reading).map_err(Raise::raised)?;
            let moves = CameraMotion {
                turns: animation.turns(),
                shutter: animation.has_shutter(),
            };
            let picture = asked.resolve(Resolving {
                reading,
                held: &held,
                moves,
                keeps_alpha: false,
                in_windows: false,
            });
            let picture = picture.map_err(Raise::raised)?;
            let start = (&picture.camera, picture.settings.motion_blur);
            let plan = Plan::new(&animation, &asked.motion, start).map_err(Raise::raised)?;
            Ok(Self {
                document: picture.document,
                plan,
                rate: animation.rate(),
            })
        })
    }

    /// Number of frames.
    #[getter]
    fn frames(&self) -> u32 {
        self.plan.frames()
    }

    /// Frames per second.
    #[getter]
    fn rate(&self) -> f64 {
        self.rate
    }

    /// The document of a frame, JSON, with nothing left open.
    fn document(&self, frame: u32) -> PyResult<String> {
        let document = self.plan.document(&self.document, frame).map_err(Raise::raised)?;
        document.to_json(false).map_err(Raise::raised)
    }
}

/// A file that grows frame by frame.
#[pyclass(frozen)]
pub(crate) struct Movie(Mutex<Option<MovieWriter>>);

#[pymethods]
impl Movie {
    /// Begins a file at `path`, in the format of `name`. The file carries the document of its first frame, where it can.
    #[new]
    fn new(
        path: PathBuf,
        name: PathBuf,
        first: &Frame,
        timing: (u32, f64),
        record: (String, String),
    ) -> PyResult<Self> {
        let (text, command) = record;
        let container = Container::from_path(&name).ok_or_else(|| {
            let known = "(.gif, .apng, .mp4, .webm, .mov, .mkv, or frames: name-####.png)";
            refused(
                "path",
                format!("{}: no animation has this extension {known}", name.display()),
            )
        })?;
        if let Container::Film(_) = container {
            check_ffmpeg().map_err(Raise::raised)?;
        }
        let (frames, fps) = timing;
        let document = Document::from_json(&text, "document".as_ref()).map_err(Raise::raised)?;
        let depth = match document.bits {
            Some(16) => Depth::Sixteen,
            _ => Depth::Eight,
        };
        let settings = AnimationSettings {
            size: first.image_size(),
            frames,
            fps,
            alpha: first.has_alpha(),
            depth,
        };
        let metadata = Record { document, command }
            .shortened(Path::new(""))
            .metadata()
            .map_err(Raise::raised)?;
        let writer = MovieWriter::create(&path, container, settings, &metadata).map_err(Raise::raised)?;
        Ok(Self(Mutex::new(Some(writer))))
    }

    /// Adds a frame, over its background.
    fn write(&self, py: Python<'_>, frame: &Frame) -> PyResult<()> {
        py.detach(|| {
            let mut writer = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            match writer.as_mut() {
                Some(writer) => writer.write(&frame.shown()).map_err(Raise::raised),
                None => Err(refused("path", "the file is finished")),
            }
        })
    }

    /// Ends the file.
    fn finish(&self, py: Python<'_>) -> PyResult<()> {
        py.detach(|| {
            let writer = self.0.lock().unwrap_or_else(PoisonError::into_inner).take();
            writer.map_or(Ok(()), |writer| writer.finish().map_err(Raise::raised))
        })
    }
}
