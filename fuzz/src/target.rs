//! What is done with an input: read, summarised, and sometimes rendered.

use std::path::Path;

use splatvol::{
    Camera, EngineConfig, ImageSize, Item, PointLook, Projection, RenderSettings, Renderer, Scene, View,
};
use splatvol_document::{Document, Record};
use splatvol_io::{Data, DataKind, DataOptions, RawLayout, ReadOptions, SampleType};

use crate::input::Input;

/// One format, or a group of formats that one reader reads.
pub(crate) struct Target {
    pub(crate) name: &'static str,
    pub(crate) reader: Reader,
    /// Inputs of the run in the tests: about what takes five seconds.
    pub(crate) quick: u32,
    pub(crate) seeds: fn() -> Vec<Input>,
    /// Words of the format.
    pub(crate) dictionary: &'static [&'static str],
}

/// A reader of the library.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Reader {
    /// Data of a kind, or of the kind that the file seems to be.
    Data(Option<DataKind>),
    /// Bytes without a header.
    Raw,
    TransferFunction,
    TransferFunction2d,
    CameraPath,
    Scene,
    Picture,
}

/// What came of an input: text that is the same for inputs that took the same way through the reader.
pub(crate) struct Answer {
    pub(crate) accepted: bool,
    pub(crate) text: String,
    /// What can be rendered.
    pub(crate) item: Option<Item>,
}

impl Answer {
    fn of<T>(result: Result<T, impl std::fmt::Display>, path: &Path, say: impl FnOnce(T) -> String) -> Self {
        let accepted = result.is_ok();
        let text = match result {
            Ok(value) => essence(&format!("accepted: {}", say(value)), path),
            Err(error) => essence(&error.to_string(), path),
        };
        Self {
            accepted,
            text: without_digits(&text),
            item: None,
        }
    }
}

impl Reader {
    /// Reads a file or folder.
    pub(crate) fn read(self, path: &Path) -> Answer {
        match self {
            Self::Data(kind) => read_data(path, kind, None),
            Self::Raw => read_data(path, None, Some(raw_layout(path))),
            Self::TransferFunction => {
                let gradient = splatvol_io::read_gradient_opacity(path).map_err(drop);
                let gradient = gradient.map(|points| points.is_some());
                let result = splatvol_io::read_transfer_function(path, [-100.0, 300.0]);
                Answer::of(result, path, |(function, warnings)| {
                    let (colors, opacities) = (function.colors().len(), function.opacities().len());
                    format!("{} {} {gradient:?} {warnings:?}", colors.min(4), opacities.min(4))
                })
            }
            Self::TransferFunction2d => {
                let result = splatvol_io::read_transfer_function_2d(path, 1.0);
                Answer::of(result, path, |_| String::new())
            }
            Self::CameraPath => Answer::of(splatvol_io::read_camera_keys(path), path, |keys| {
                format!(
                    "{:?}",
                    keys.last()
                        .map(|key| (key.time.is_some(), key.up.is_some(), key.projection.is_some()))
                )
            }),
            Self::Scene => Answer::of(splatvol_document::format::read_scene(path), path, |document| {
                of_document(&document)
            }),
            Self::Picture => {
                // The pixels, too: a picture may lie as a texture or on terrain.
                let pixels = splatvol_io::read_image(path).is_ok();
                let record = Record::of_picture(path);
                Answer::of(record, path, |record| {
                    format!("{pixels} {}", of_document(&record.document))
                })
            }
        }
    }
}

/// A scene that was read is written, and what was written is read.
fn of_document(document: &Document) -> String {
    let text = document.to_json(true).unwrap_or_default();
    let again = Document::from_json(&text, "again.json".as_ref());
    assert!(
        again.is_ok_and(|again| again == *document),
        "a document that does not come back:\n{text}"
    );
    let settings = document.settings.resolve(None, Default::default());
    let tables: Vec<&str> = text.lines().filter(|line| line.starts_with("  \"")).collect();
    format!(
        "{tables:?} {:?}",
        settings.map(drop).map_err(|error| error.to_string())
    )
}

/// The layout of a headerless file is the file's own first bytes: dimensions, type, byte order, offset.
fn raw_layout(path: &Path) -> RawLayout {
    let bytes = std::fs::read(path).unwrap_or_default();
    let byte = |at: usize| bytes.get(at).copied().unwrap_or(1);
    let types = [SampleType::U8, SampleType::I16, SampleType::F32, SampleType::F64];
    RawLayout {
        dims: [byte(0), byte(1), byte(2)].map(usize::from),
        sample_type: types[usize::from(byte(3)) % 4],
        spacing: glam::DVec3::new(1.0, 2.0, f64::from(byte(4))),
        endian: if byte(5) & 1 == 0 {
            splatvol_io::Endian::Little
        } else {
            splatvol_io::Endian::Big
        },
        offset: u64::from(byte(6)),
    }
}

fn read_data(path: &Path, kind: Option<DataKind>, raw: Option<RawLayout>) -> Answer {
    let options = DataOptions {
        kind,
        read: ReadOptions {
            raw,
            ..ReadOptions::default()
        },
        ..DataOptions::default()
    };
    let mut item = None;
    let result = splatvol_io::read_data(path, &options).map(|loaded| {
        let description = loaded.description;
        let text = format!(
            "{} {} {} {:?} {:?}",
            loaded.kind, description.format, description.stored_type, description.warnings, loaded.tags
        );
        item = of_data(loaded.data);
        text
    });
    let mut answer = Answer::of(result, path, |text| essence(&text, path));
    answer.item = item;
    answer
}

fn of_data(data: Data) -> Option<Item> {
    match data {
        Data::Volume(volume) => Some(Item::automatic(volume)),
        Data::Points(points) => Some(Item::points(points, PointLook::default())),
        Data::Gaussians(gaussians) => Some(Item::gaussians(gaussians)),
        Data::Mesh(mesh) => Item::automatic_mesh(mesh).ok(),
    }
}

/// Renders as small a picture as shows anything, as the command does by default.
pub(crate) fn render(item: Item) -> anyhow::Result<()> {
    let scene = Scene::from(item);
    let settings = RenderSettings::default().with_size(ImageSize::new(16, 16)?);
    let camera = Camera::framing(&scene.bounds()?, View::Iso, Projection::default(), 1.0)?;
    let config = EngineConfig {
        threads: Some(1),
        ..EngineConfig::default()
    };
    Renderer::new(config)?.render(&scene, &camera, &settings)?;
    Ok(())
}

/// An error without the file's path and the value that it found.
fn essence(text: &str, path: &Path) -> String {
    let text = text.replace(&path.display().to_string(), "");
    match (text.find("= \""), text.rfind("\": expected")) {
        (Some(start), Some(end)) if start < end => format!("{}{}", &text[..start], &text[end..]),
        _ => text,
    }
}

fn without_digits(text: &str) -> String {
    text.chars().filter(|c| !c.is_ascii_digit()).take(400).collect()
}
