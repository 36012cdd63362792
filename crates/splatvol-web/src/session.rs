//! An instance: one document with its data, and the renderer that keeps what it derives from them.

use std::path::Path;
use std::sync::{Mutex, PoisonError};

use serde::Serialize;
use serde_json::Value;
use splatvol::transfer_function::{ColorMap, OpacityCurve};
use splatvol::{
    Camera, Content, Control, EngineConfig, Frame, Image, ImageSize, RenderSettings, Renderer, Share,
    TransferFunction,
};
use splatvol_document::camera::Surroundings;
use splatvol_document::keys::CameraKeys;
use splatvol_document::resolve::laid_over;
use splatvol_document::{
    CameraMotion, CameraPose, Document, Edit, Held, Listener, Picture, ReadRules, Reading, Resolving, outline,
};
use splatvol_io::{Data, Description};

use crate::message::{Edited, ItemFacts, Opened, Rendered, Request};
use crate::{LookEdit, VolumeData, WebError, look};

/// Edge of the blocks in which shares are dealt out, and of the engine's tiles, pixels.
pub const BLOCK: usize = 64;
/// Bins of an item's histogram.
const BINS: usize = 128;

/// An answer: its header, JSON, and bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Answer {
    /// What it says: see [`crate::message`].
    pub header: String,
    /// Pixels, where there are any.
    pub bytes: Vec<u8>,
}

/// An instance of the engine.
#[derive(Debug)]
pub struct Session {
    renderer: Renderer,
    frame: Frame,
    open: Option<Open>,
}

/// The document and its data.
#[derive(Debug)]
struct Open {
    held: Vec<Option<Held>>,
    picture: Picture,
    /// Transfer functions as they were opened, and the spacing of their volumes, world.
    looks: Vec<(TransferFunction, f64)>,
}

/// Collects what is said while a document is resolved.
#[derive(Debug, Default)]
struct Notes(Mutex<Vec<String>>);

impl Notes {
    fn add(&self, message: &str) {
        let mut notes = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        notes.push(message.to_owned());
    }
}

impl Listener for Notes {
    fn warn(&self, message: &str) {
        self.add(message);
    }

    fn detail(&self, message: &str) {
        self.add(message);
    }
}

impl Session {
    /// An instance without a document.
    ///
    /// # Errors
    /// Threads that the system refuses.
    pub fn new() -> Result<Self, WebError> {
        let config = EngineConfig {
            tile_edge: Some(BLOCK),
            ..EngineConfig::default()
        };
        Ok(Self {
            renderer: Renderer::new(config)?,
            frame: Frame::empty(ImageSize::new(1, 1)?),
            open: None,
        })
    }

    /// Answers a message: its header, JSON, and its bytes. What cannot be answered changes nothing.
    pub fn answer(&mut self, header: &str, bytes: &[u8]) -> Answer {
        self.answered(header, bytes).unwrap_or_else(|error| Answer {
            header: serde_json::json!({ "error": error.to_string() }).to_string(),
            bytes: Vec::new(),
        })
    }

    fn answered(&mut self, header: &str, bytes: &[u8]) -> Result<Answer, WebError> {
        match serde_json::from_str(header)? {
            Request::Open { document, data } => said(&self.open(&document, &data, bytes)?),
            Request::Edit { edits } => {
                let edits = edits.into_iter();
                self.edit(edits.map(|edit| Edit::Set {
                    path: edit.path,
                    value: Some(edit.value),
                }))
            }
            Request::Look { item, look } => self.look(item, &look),
            Request::Camera { camera, size } => {
                let open = self.open.as_ref().ok_or(WebError::Closed)?;
                let size = ImageSize::new(size[0], size[1])?;
                said(&CameraPose::from(&open.camera(Some(camera), size)?))
            }
            Request::Render { size, camera, share } => self.render(size, camera, share),
        }
    }

    fn open(&mut self, document: &Value, data: &[VolumeData], bytes: &[u8]) -> Result<Opened, WebError> {
        let document = Document::from_json(&document.to_string(), Path::new("document"))?;
        if document.items.len() != data.len() {
            return Err(WebError::Data {
                item: data.len().min(document.items.len()),
                why: format!(
                    "{} items have data, and {} are shown",
                    data.len(),
                    document.items.len()
                ),
            });
        }
        let held = held(data, bytes)?;
        let notes = Notes::default();
        let picture = resolve(&document, &held, &notes)?;
        let open = Open {
            looks: looks(&picture)?,
            held,
            picture,
        };
        let opened = open.facts(notes.0.into_inner().unwrap_or_default())?;
        self.open = Some(open);
        Ok(opened)
    }

    /// Makes edits, all or none.
    fn edit(&mut self, edits: impl Iterator<Item = Edit>) -> Result<Answer, WebError> {
        let open = self.open.as_mut().ok_or(WebError::Closed)?;
        let mut document = open.picture.document.clone();
        for edit in edits {
            document.apply(edit)?;
        }
        open.picture = resolve(&document, &open.held, &Notes::default())?;
        said(&Edited {
            document: serde_json::to_value(&open.picture.document)?,
        })
    }

    fn look(&mut self, item: usize, look: &LookEdit) -> Result<Answer, WebError> {
        let open = self.open.as_ref().ok_or(WebError::Closed)?;
        let (base, spacing) = open.looks.get(item).ok_or(WebError::Item(item))?;
        let function = look.apply(base, *spacing)?;
        let path = format!("item[{item}].transfer-function");
        let edit = Edit::set(path, serde_json::to_value(function)?);
        self.edit(std::iter::once(edit))
    }

    fn render(
        &mut self,
        size: Option<[u32; 2]>,
        camera: Option<CameraKeys>,
        share: Option<[usize; 2]>,
    ) -> Result<Answer, WebError> {
        let open = self.open.as_ref().ok_or(WebError::Closed)?;
        let picture = &open.picture;
        let size = match size {
            Some([width, height]) => ImageSize::new(width, height)?,
            None => picture.settings.size,
        };
        let [index, count] = share.unwrap_or([0, 1]);
        let share = Share::new(index, count, BLOCK)?;
        let camera = open.camera(camera, size)?;
        let settings = RenderSettings {
            size,
            ..picture.settings
        };
        let control = Control {
            share: Some(share),
            ..Control::default()
        };
        self.renderer
            .render_with(&picture.scene, &camera, &settings, &mut self.frame, &control)?;
        let mut bytes = Vec::new();
        let mut tiles = Vec::new();
        for block in share.blocks(size) {
            let width = size.width() as usize;
            let rows = (block.y0..block.y1).map(|y| y * width + block.x0..y * width + block.x1);
            let pixels = rows
                .flat_map(|row| self.frame.image.pixels[row].iter().copied())
                .collect();
            let [columns, rows] = [block.x1 - block.x0, block.y1 - block.y0].map(|side| side as u32);
            let tile = Image::from_pixels(ImageSize::new(columns, rows)?, pixels)?;
            let tile = match picture.background() {
                Some(color) => laid_over(&tile, color),
                None => tile,
            };
            bytes.extend_from_slice(splatvol_io::image::png::srgb8(&tile).as_flattened());
            tiles.push([block.x0, block.y0, block.x1, block.y1]);
        }
        let answer = said(&Rendered {
            size: size.into(),
            camera: CameraPose::from(&camera),
            tiles,
        })?;
        Ok(Answer { bytes, ..answer })
    }
}

impl Open {
    /// The document's camera with other keys over it, for a picture of a size.
    fn camera(&self, keys: Option<CameraKeys>, size: ImageSize) -> Result<Camera, WebError> {
        let Some(keys) = keys else {
            return Ok(self.picture.camera);
        };
        let keys = keys.over(&self.picture.document.camera);
        let items = &self.picture.scene.items;
        let fit = keys.fit.unwrap_or_default();
        let outlines = || items.iter().flat_map(|item| outline(item, fit)).collect();
        Ok(keys.resolve(&Surroundings::of_outline(outlines, size.aspect()))?)
    }

    fn facts(&self, notes: Vec<String>) -> Result<Opened, WebError> {
        let shown = self.picture.document.items.iter().zip(&self.picture.scene.items);
        let items = shown.zip(&self.looks).filter_map(|((keys, item), (look, _))| {
            let Content::Volume { volume, .. } = &item.content else {
                return None;
            };
            Some(ItemFacts {
                name: keys.file.clone(),
                dims: volume.grid().dims(),
                unit: volume.unit().symbol(),
                values: volume.value_range(),
                histogram: volume.histogram(BINS),
                range: look::range(look),
                transfer_function: look.clone(),
            })
        });
        Ok(Opened {
            version: env!("CARGO_PKG_VERSION"),
            document: serde_json::to_value(&self.picture.document)?,
            items: items.collect(),
            bounds: self.picture.scene.bounds()?,
            color_maps: ColorMap::names().collect(),
            opacity_curves: OpacityCurve::names().collect(),
            notes,
        })
    }
}

/// A header without bytes.
fn said(header: &impl Serialize) -> Result<Answer, WebError> {
    Ok(Answer {
        header: serde_json::to_string(header)?,
        bytes: Vec::new(),
    })
}

/// The volumes of packed samples, one after the other.
fn held(data: &[VolumeData], bytes: &[u8]) -> Result<Vec<Option<Held>>, WebError> {
    let mut rest = bytes;
    let mut all = Vec::new();
    for (item, data) in data.iter().enumerate() {
        let fault = |why: String| WebError::Data { item, why };
        let count = data.byte_count().filter(|&count| count <= rest.len());
        let count = count.ok_or_else(|| fault(format!("{} bytes are too few for it", rest.len())))?;
        let (own, others) = rest.split_at(count);
        rest = others;
        let volume = data.unpack(own).map_err(|error| fault(error.to_string()))?;
        let description = Description {
            format: "memory".to_owned(),
            stored_type: data.sample_type.clone(),
            orientation: "as the page says".to_owned(),
            oriented: true,
            ..Description::default()
        };
        all.push(Some(Held::new(Data::Volume(volume), description)));
    }
    match rest.len() {
        0 => Ok(all),
        extra => Err(WebError::Data {
            item: data.len(),
            why: format!("{extra} bytes belong to nothing"),
        }),
    }
}

fn resolve(document: &Document, held: &[Option<Held>], notes: &Notes) -> Result<Picture, WebError> {
    let picture = document.resolve(Resolving {
        reading: Reading {
            rules: ReadRules::default(),
            folder: None,
            listener: notes,
        },
        held,
        moves: CameraMotion::default(),
        keeps_alpha: false,
    })?;
    splatvol::check(&picture.scene, &picture.camera, &picture.settings)?;
    Ok(picture)
}

/// The transfer functions of a scene of volumes, and their spacings. All items have to be visible: those that are not have
/// no look.
fn looks(picture: &Picture) -> Result<Vec<(TransferFunction, f64)>, WebError> {
    let items = &picture.scene.items;
    if items.len() != picture.document.items.len() {
        return Err(WebError::Item(items.len()));
    }
    let looks = items.iter().enumerate().map(|(index, item)| match &item.content {
        Content::Volume {
            volume,
            transfer_function,
            ..
        } => Ok((transfer_function.clone(), volume.grid().mean_spacing())),
        _ => Err(WebError::Item(index)),
    });
    looks.collect()
}
