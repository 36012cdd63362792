//! A document with its data, shown: it answers everything but the tiles of pictures, and says how these are drawn.

use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};

use serde::Serialize;
use serde_json::Value;
use splatvol::transfer_function::{ColorMap, OpacityCurve};
use splatvol::{
    Camera, Compositing, Content, Control, Frame, Image, ImageSize, RenderSettings, Renderer, Scene,
    SceneError, Share, Shot, TransferFunction,
};
use splatvol_document::camera::Surroundings;
use splatvol_document::keys::CameraKeys;
use splatvol_document::resolve::laid_over;
use splatvol_document::{
    CameraMotion, CameraPose, Document, Edit, Held, HeldContent, Listener, Picture, ReadRules, Reading,
    Resolving, outline,
};

use crate::data::held_as;
use crate::message::{Described, Edited, ItemFacts, Opened, Rendered, Request, ValueFacts};
use crate::session::{Answer, BLOCK, RAY_BLOCK};
use crate::{ItemData, LookEdit, WebError, held, look, size_of};

/// Bins of an item's histogram.
const BINS: usize = 128;

/// A document with its data in memory. Clones share the data, and change on their own.
#[derive(Debug, Clone)]
pub struct Shown {
    held: Vec<Option<Held>>,
    picture: Picture,
    /// Transfer functions as they were opened, where items have one, and the lengths to which opacities refer if these do not say,
    /// world.
    looks: Vec<Option<(TransferFunction, f64)>>,
    /// What was chosen, and warnings.
    notes: Vec<String>,
}

/// Tiles to be drawn.
#[derive(Debug, Clone)]
pub struct Tiles {
    scene: Scene,
    camera: Camera,
    settings: RenderSettings,
    background: Option<[f64; 4]>,
    share: Share,
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

impl Shown {
    /// Opens a document, JSON, with the packed data of its items, one after the other, and what their files say about them.
    ///
    /// # Errors
    /// As [`Shown::new`]; data that are not those of the items.
    pub fn open(
        document: &Value,
        (data, described): (&[ItemData], Option<Vec<Described>>),
        bytes: &[u8],
    ) -> Result<Self, WebError> {
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
        let contents = unpacked(data, bytes)?.into_iter();
        let held: Vec<Held> = match described {
            None => contents.map(held).collect(),
            Some(described) if described.len() == data.len() => contents
                .zip(described)
                .map(|(content, described)| held_as(content, described))
                .collect(),
            Some(described) => {
                return Err(WebError::Data {
                    item: described.len().min(data.len()),
                    why: format!(
                        "{} items have data, and {} are described",
                        data.len(),
                        described.len()
                    ),
                });
            }
        };
        Self::new(&document, held.into_iter().map(Some).collect())
    }

    /// Shows a document whose items' data are in memory.
    ///
    /// # Errors
    /// A document that cannot become a picture, or that hides items.
    pub fn new(document: &Document, held: Vec<Option<Held>>) -> Result<Self, WebError> {
        let notes = Notes::default();
        let picture = resolve(document, &held, &notes)?;
        Ok(Self {
            looks: looks(&picture)?,
            held,
            picture,
            notes: notes.0.into_inner().unwrap_or_default(),
        })
    }

    /// Answers a change, or a question about a camera. What cannot be answered changes nothing.
    ///
    /// # Errors
    /// Keys and values that are refused; requests that open documents or render.
    pub fn answer(&mut self, request: Request) -> Result<Answer, WebError> {
        match request {
            Request::Edit { edits } => {
                let edits = edits.into_iter();
                self.edit(edits.map(|edit| Edit::Set {
                    path: edit.path,
                    value: Some(edit.value),
                }))
            }
            Request::Look { item, look } => self.look(item, &look),
            Request::Camera { camera, size } => {
                let size = ImageSize::new(size[0], size[1])?;
                said(&CameraPose::from(&self.camera(Some(camera), size)?))
            }
            Request::Open { .. } | Request::Render { .. } => Err(WebError::NoChange),
        }
    }

    /// Makes edits, all or none.
    fn edit(&mut self, edits: impl Iterator<Item = Edit>) -> Result<Answer, WebError> {
        let mut document = self.picture.document.clone();
        for edit in edits {
            document.apply(edit)?;
        }
        self.picture = resolve(&document, &self.held, &Notes::default())?;
        said(&Edited {
            document: serde_json::to_value(&self.picture.document)?,
        })
    }

    fn look(&mut self, item: usize, edit: &LookEdit) -> Result<Answer, WebError> {
        let look = self.looks.get(item).and_then(Option::as_ref);
        let (base, spacing) = look.ok_or(WebError::Item(item))?;
        let function = edit.apply(base, *spacing)?;
        let path = format!("item[{item}].transfer-function");
        let edit = Edit::set(path, serde_json::to_value(function)?);
        self.edit(std::iter::once(edit))
    }

    /// The tiles of a share of a picture: `[0, 1]` of `share` is all of it.
    ///
    /// # Errors
    /// Sizes, cameras and shares that do not exist.
    pub fn tiles(
        &self,
        size: Option<[u32; 2]>,
        camera: Option<CameraKeys>,
        share: Option<[usize; 2]>,
    ) -> Result<Tiles, WebError> {
        let picture = &self.picture;
        let size = match size {
            Some([width, height]) => ImageSize::new(width, height)?,
            None => picture.settings.size,
        };
        let [index, count] = share.unwrap_or([0, 1]);
        let block = match picture.settings.method.compositing() {
            Compositing::Xray => RAY_BLOCK,
            _ => BLOCK,
        };
        Ok(Tiles {
            scene: picture.scene.clone(),
            camera: self.camera(camera, size)?,
            settings: RenderSettings {
                size,
                ..picture.settings
            },
            background: picture.background(),
            share: Share::new(index, count, block)?,
        })
    }

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

    /// What was opened: its items, bounds, and what they may be shown by.
    ///
    /// # Errors
    /// A scene without bounds.
    pub fn facts(&self) -> Result<Opened, WebError> {
        let shown = self.picture.document.items.iter().zip(&self.picture.scene.items);
        let items = shown.zip(&self.looks).map(|((keys, item), look)| ItemFacts {
            name: keys.file.clone(),
            size: size_of(&HeldContent::from(&item.content)),
            unit: match &item.content {
                Content::Volume { volume, .. } => volume.unit().symbol(),
                _ => "",
            },
            opacity: match &item.content {
                Content::Points { look, .. } => Some(look.opacity),
                _ => None,
            },
            values: look.as_ref().and_then(|(look, _)| values_of(&item.content, look)),
        });
        Ok(Opened {
            version: env!("CARGO_PKG_VERSION"),
            document: serde_json::to_value(&self.picture.document)?,
            items: items.collect(),
            bounds: self.picture.scene.bounds()?,
            color_maps: ColorMap::names().collect(),
            opacity_curves: OpacityCurve::names().collect(),
            notes: self.notes.clone(),
        })
    }
}

impl Tiles {
    /// Pixels that are drawn.
    pub fn pixel_count(&self) -> usize {
        self.share
            .blocks(self.settings.size)
            .map(|block| (block.x1 - block.x0) * (block.y1 - block.y0))
            .sum()
    }

    /// Their scene, camera and settings.
    pub fn shot(&self) -> Shot<'_> {
        Shot {
            scene: &self.scene,
            camera: &self.camera,
            settings: &self.settings,
        }
    }

    /// Draws them.
    ///
    /// # Errors
    /// Scenes and settings that the engine refuses; a stopped picture.
    pub fn draw(
        &self,
        (renderer, frame): (&mut Renderer, &mut Frame),
        stop: Option<&AtomicBool>,
    ) -> Result<Answer, WebError> {
        let control = Control {
            share: Some(self.share),
            stop,
            ..Control::default()
        };
        renderer.render_with(&self.scene, &self.camera, &self.settings, frame, &control)?;
        self.answer(frame)
    }

    /// The answer that has them, from a frame of the picture.
    ///
    /// # Errors
    /// A frame of another size.
    pub fn answer(&self, frame: &Frame) -> Result<Answer, WebError> {
        let size = self.settings.size;
        if frame.image.size() != size {
            let found = <[u32; 2]>::from(frame.image.size());
            return Err(SceneError::invalid("size of the frame", found, "that of the picture").into());
        }
        let mut bytes = Vec::new();
        let mut tiles = Vec::new();
        for block in self.share.blocks(size) {
            let width = size.width() as usize;
            let rows = (block.y0..block.y1).map(|y| y * width + block.x0..y * width + block.x1);
            let pixels = rows
                .flat_map(|row| frame.image.pixels[row].iter().copied())
                .collect();
            let [columns, rows] = [block.x1 - block.x0, block.y1 - block.y0].map(|side| side as u32);
            let tile = Image::from_pixels(ImageSize::new(columns, rows)?, pixels)?;
            let tile = match self.background {
                Some(color) => laid_over(&tile, color),
                None => tile,
            };
            bytes.extend_from_slice(splatvol_io::image::png::srgb8(&tile).as_flattened());
            tiles.push([block.x0, block.y0, block.x1, block.y1]);
        }
        let answer = said(&Rendered {
            size: size.into(),
            camera: CameraPose::from(&self.camera),
            tiles,
        })?;
        Ok(Answer { bytes, ..answer })
    }
}

/// The data of packed numbers, one after the other.
fn unpacked(data: &[ItemData], bytes: &[u8]) -> Result<Vec<HeldContent>, WebError> {
    let mut rest = bytes;
    let mut all = Vec::new();
    for (item, data) in data.iter().enumerate() {
        let fault = |why: String| WebError::Data { item, why };
        let own = data.unpack(&mut rest).map_err(|error| fault(error.to_string()))?;
        all.push(own.into());
    }
    match rest.len() {
        0 => Ok(all),
        extra => Err(WebError::Data {
            item: data.len(),
            why: format!("{extra} bytes belong to nothing"),
        }),
    }
}

/// A header without bytes.
pub(crate) fn said(header: &impl Serialize) -> Result<Answer, WebError> {
    Ok(Answer {
        header: serde_json::to_string(header)?,
        bytes: Vec::new(),
    })
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
        in_windows: false,
    })?;
    splatvol::check(&picture.scene, &picture.camera, &picture.settings)?;
    Ok(picture)
}

/// The transfer functions of a scene, where items have one, and the lengths to which opacities refer otherwise. All items have to
/// be visible: those that are not have no look.
fn looks(picture: &Picture) -> Result<Vec<Option<(TransferFunction, f64)>>, WebError> {
    let items = &picture.scene.items;
    if items.len() != picture.document.items.len() {
        return Err(WebError::Item(items.len()));
    }
    let looks = items.iter().map(|item| match &item.content {
        Content::Volume {
            volume,
            transfer_function,
            ..
        } => Some((transfer_function.clone(), volume.finest_grid().mean_spacing())),
        Content::Mesh {
            mesh,
            transfer_function,
            ..
        } => Some((transfer_function.clone(), mesh.mean_spacing())),
        Content::Points { .. } | Content::Gaussians(_) => None,
    });
    Ok(looks.collect())
}

/// The values of content, and the transfer function that they were opened with.
fn values_of(content: &Content, look: &TransferFunction) -> Option<ValueFacts> {
    let (extremes, histogram) = match content {
        Content::Volume { volume, .. } => (volume.value_range(), volume.histogram(BINS)),
        Content::Mesh { mesh, .. } => (mesh.value_range().map(f64::from), mesh.histogram(BINS)),
        Content::Points { .. } | Content::Gaussians(_) => return None,
    };
    Some(ValueFacts {
        extremes,
        histogram,
        range: look::range(look),
        transfer_function: look.clone(),
    })
}
