//! A document with its data, resolved: the picture as it will be, and how it is rendered.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use splatvol::{Control, RenderStatistics, SceneError, TileRect};
use splatvol_document::format::{is_scene, path_outside, read_scene};
use splatvol_document::keys::ItemKeys;
use splatvol_document::{CameraMotion, Document, Edit, Held, ReadRules, Reading, Record, Resolving};

use crate::chunks;
use crate::data::{Data, Notes};
use crate::engines;
use crate::error::Raise;
use crate::frame::Frame;
use crate::work::{self, Stop, Watch};

/// A picture that can be rendered.
#[pyclass(frozen)]
#[derive(Debug)]
pub(crate) struct Picture {
    pub(crate) picture: splatvol_document::Picture,
    notes: Vec<(bool, String)>,
}

#[pymethods]
impl Picture {
    /// Resolves a document, JSON. `held` has the data of each item, or `None` for those that are to be read; `memory` is the
    /// budget for volumes that are read in chunks, bytes.
    #[new]
    #[pyo3(signature = (document, held, strict = false, folder = None, keeps_alpha = false, memory = None, stop = None, progress = None))]
    #[expect(clippy::too_many_arguments, reason = "Python's keywords")]
    fn new(
        py: Python<'_>,
        document: &str,
        held: Vec<Option<Bound<'_, Data>>>,
        strict: bool,
        folder: Option<PathBuf>,
        keeps_alpha: bool,
        memory: Option<u64>,
        stop: Option<&Stop>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let document = Document::from_json(document, "document".as_ref()).map_err(Raise::raised)?;
        let held: Vec<Option<Held>> = held
            .into_iter()
            .map(|data| data.map(|data| data.get().held.clone()))
            .collect();
        work::run(py, (stop, progress.as_ref()), |_| {
            let notes = Notes::default();
            let picture = document.resolve(Resolving {
                reading: Reading {
                    rules: ReadRules {
                        strict,
                        chunks: Some(chunks::chunk_rules(memory)),
                        ..ReadRules::default()
                    },
                    folder: folder.as_deref(),
                    listener: &notes,
                },
                held: &held,
                moves: CameraMotion::default(),
                keeps_alpha,
                in_windows: true,
            });
            let picture = picture.map_err(Raise::raised)?;
            Ok(Self {
                picture: chunks::whole_where_needed(picture)?,
                notes: notes.taken(),
            })
        })
    }

    /// The document with nothing left open, JSON.
    fn document(&self) -> PyResult<String> {
        self.picture.document.to_json(false).map_err(Raise::raised)
    }

    /// Warnings and choices, each with whether it is a warning.
    #[getter]
    fn notes(&self) -> Vec<(bool, String)> {
        self.notes.clone()
    }

    /// Bounds of the scene, world: least and greatest x, y, z.
    fn bounds(&self) -> PyResult<([f64; 3], [f64; 3])> {
        let bounds = self.picture.scene.bounds().map_err(Raise::raised)?;
        Ok((bounds.min.to_array(), bounds.max.to_array()))
    }

    /// Renders it.
    #[pyo3(signature = (stop = None, progress = None))]
    fn render(&self, py: Python<'_>, stop: Option<&Stop>, progress: Option<Py<PyAny>>) -> PyResult<Frame> {
        let picture = &self.picture;
        picture.check_size().map_err(Raise::raised)?;
        let _turn = engines::Turn::wait_for(py, &picture.scene)?;
        let (frame, statistics) =
            work::run(py, (stop, progress.as_ref()), |watch| draw(picture, None, watch))?;
        let [.., alpha] = picture.scene.background;
        let is_blended = alpha > 0.0 && picture.scene.is_published(&picture.settings);
        Ok(Frame::new(frame, picture.background()).of_render(is_blended, statistics))
    }
}

/// The pixels of a picture, or of a block of it.
pub(crate) fn draw(
    picture: &splatvol_document::Picture,
    window: Option<TileRect>,
    watch: &Watch,
) -> PyResult<(splatvol::Frame, RenderStatistics)> {
    let splatvol_document::Picture {
        scene,
        camera,
        settings,
        sub_frames,
        ..
    } = picture;
    let rendered = engines::render(scene, |renderer| {
        // The renderer gives it its size.
        let mut frame = splatvol::Frame::empty(splatvol::ImageSize::new(1, 1)?);
        watch.controls(|control| {
            let control = &Control { window, ..*control };
            match &sub_frames[..] {
                [] => renderer.render_with(scene, camera, settings, &mut frame, control),
                cameras => renderer.expose(scene, cameras, settings, &mut frame, control),
            }
        })?;
        Ok::<_, SceneError>((frame, renderer.statistics().clone()))
    });
    rendered?.map_err(Raise::raised)
}

/// A document over another, both JSON.
#[pyfunction]
pub(crate) fn document_over(above: &str, below: &str) -> PyResult<String> {
    let read = |text| Document::from_json(text, "document".as_ref()).map_err(Raise::raised);
    read(above)?
        .over(&read(below)?)
        .to_json(false)
        .map_err(Raise::raised)
}

/// Why a key, in a table or in the document itself, cannot have a value, JSON; `None` where it can.
#[pyfunction]
pub(crate) fn refusal(table: &str, key: &str, value: &str) -> PyResult<Option<String>> {
    let value: serde_json::Value = serde_json::from_str(value).map_err(Raise::raised)?;
    let mut document = Document::of_items([ItemKeys::default()]);
    let path = match table {
        "" => key.to_owned(),
        "item" => format!("item[0].{key}"),
        table => format!("{table}.{key}"),
    };
    let Err(error) = document.apply(Edit::set(&path, value)) else {
        return Ok(None);
    };
    let message = error.to_string();
    let start = format!("{path} : ");
    Ok(Some(message.strip_prefix(&start).unwrap_or(&message).to_owned()))
}

/// A document, JSON, as TOML for people, or as JSON in lines.
#[pyfunction]
pub(crate) fn document_text(document: &str, form: &str) -> PyResult<String> {
    let document = Document::from_json(document, "document".as_ref()).map_err(Raise::raised)?;
    let text = match form {
        "toml" => document.to_toml(),
        _ => document.to_json(true),
    };
    text.map_err(Raise::raised)
}

/// The document of a scene's file, JSON; `None` where the file is no scene.
#[pyfunction]
pub(crate) fn read_document(path: PathBuf) -> PyResult<Option<String>> {
    if !is_scene(&path) {
        return Ok(None);
    }
    let document = read_scene(&path).map_err(Raise::raised)?;
    document.to_json(false).map(Some).map_err(Raise::raised)
}

/// The document that a picture's file carries, JSON, and the command that made it.
#[pyfunction]
pub(crate) fn read_record(path: PathBuf) -> PyResult<(String, String)> {
    let record = Record::of_picture(&path).map_err(Raise::raised)?;
    let document = record.document.to_json(false).map_err(Raise::raised)?;
    Ok((document, record.command))
}

/// The document of a picture that is to be made again, JSON, and a file that it names elsewhere than in its folder and the current
/// one. Files beside the picture are found as by the command's `--like`, and as there not if `has_data`: if other data take the
/// place of the items' files.
#[pyfunction]
pub(crate) fn read_like(path: PathBuf, has_data: bool) -> PyResult<(String, Option<String>)> {
    let recorded = Record::of_picture(&path).map_err(Raise::raised)?.document;
    let (document, outside) = match path.parent().filter(|_| !has_data) {
        Some(folder) => {
            let outside = path_outside(recorded.paths(), Some(&path)).map(str::to_owned);
            (recorded.located(folder), outside)
        }
        None => {
            let look = without_data(recorded.clone());
            let outside = path_outside(look.paths(), None).map(str::to_owned);
            (recorded, outside)
        }
    };
    Ok((document.to_json(false).map_err(Raise::raised)?, outside))
}

/// The document without the files of its items' data.
fn without_data(mut document: Document) -> Document {
    for item in &mut document.items {
        // Samples have no file.
        "sample:".clone_into(&mut item.file);
        (item.drape, item.solution) = (None, None);
    }
    document
}

/// The transfer function of a file, as the document has it, JSON, for data in a range; and warnings.
#[pyfunction]
pub(crate) fn read_transfer_function(path: PathBuf, range: [f64; 2]) -> PyResult<(String, Vec<String>)> {
    let (function, warnings) = splatvol_io::read_transfer_function(path, range).map_err(Raise::raised)?;
    Ok((serde_json::to_string(&function).map_err(Raise::raised)?, warnings))
}

/// Writes a transfer function, JSON, in the format of the file's extension.
#[pyfunction]
pub(crate) fn write_transfer_function(path: PathBuf, function: &str) -> PyResult<()> {
    let function: splatvol::TransferFunction = serde_json::from_str(function).map_err(Raise::raised)?;
    splatvol_io::write_transfer_function(path, &function).map_err(Raise::raised)
}

/// Statistics as a dictionary.
pub(crate) fn statistics<'py>(
    py: Python<'py>,
    statistics: &RenderStatistics,
) -> PyResult<Bound<'py, PyDict>> {
    let text = serde_json::to_string(statistics).map_err(Raise::raised)?;
    let read = py.import("json")?.call_method1("loads", (text,))?;
    read.cast_into::<PyDict>().map_err(Into::into)
}
