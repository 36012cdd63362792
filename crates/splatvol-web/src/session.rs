//! An instance: one document with its data, and the renderer that keeps what it derives from them.

use std::path::Path;

use serde_json::Value;
use splatvol::{EngineConfig, Frame, ImageSize, Renderer};
use splatvol_document::{Document, Held};

use crate::message::{Opened, Request};
use crate::shown::{Shown, said};
use crate::{ItemData, WebError, held};

/// Edge of the blocks in which shares are dealt out, and of the engine's tiles, pixels.
pub const BLOCK: usize = 64;
/// Edge of the blocks of X-rays, pixels: the engine's tiles have this size there, whatever is asked for. Each share would draw
/// all tiles if a tile had blocks of every share.
pub(crate) const RAY_BLOCK: usize = 128;

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
    shown: Option<Shown>,
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
            shown: None,
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
            Request::Render { size, camera, share } => {
                let tiles = self
                    .shown
                    .as_ref()
                    .ok_or(WebError::Closed)?
                    .tiles(size, camera, share)?;
                tiles.draw((&mut self.renderer, &mut self.frame), None)
            }
            change => self.shown.as_mut().ok_or(WebError::Closed)?.answer(change),
        }
    }

    fn open(&mut self, document: &Value, data: &[ItemData], bytes: &[u8]) -> Result<Opened, WebError> {
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
        let shown = Shown::new(&document, unpacked(data, bytes)?)?;
        let opened = shown.facts()?;
        self.shown = Some(shown);
        Ok(opened)
    }
}

/// The data of packed numbers, one after the other.
fn unpacked(data: &[ItemData], bytes: &[u8]) -> Result<Vec<Option<Held>>, WebError> {
    let mut rest = bytes;
    let mut all = Vec::new();
    for (item, data) in data.iter().enumerate() {
        let fault = |why: String| WebError::Data { item, why };
        let own = data.unpack(&mut rest).map_err(|error| fault(error.to_string()))?;
        all.push(Some(held(own.into())));
    }
    match rest.len() {
        0 => Ok(all),
        extra => Err(WebError::Data {
            item: data.len(),
            why: format!("{extra} bytes belong to nothing"),
        }),
    }
}
