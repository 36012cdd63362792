//! An instance: one document with its data, and the renderer that keeps what it derives from them.

use splatvol::{EngineConfig, Frame, ImageSize, Renderer};

use crate::WebError;
use crate::message::Request;
use crate::shown::{Shown, Tiles, said};

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

impl Answer {
    /// Says why there is none.
    pub fn refusal(error: &impl ToString) -> Self {
        Self {
            header: serde_json::json!({ "error": error.to_string() }).to_string(),
            bytes: Vec::new(),
        }
    }
}

/// What a message asks for.
#[derive(Debug)]
pub enum Heard {
    /// Nothing more: this is the answer.
    Answer(Answer),
    /// Tiles, which an engine has to draw.
    Tiles(Box<Tiles>),
}

/// The document that messages open and change, without an engine.
#[derive(Debug, Default)]
pub struct OpenDocument {
    shown: Option<Shown>,
}

impl OpenDocument {
    /// Hears a message: its header, JSON, and its bytes. What cannot be answered changes nothing.
    ///
    /// # Errors
    /// Messages that are not understood, or ask for what there is not.
    pub fn hear(&mut self, header: &str, bytes: &[u8]) -> Result<Heard, WebError> {
        let answer = match serde_json::from_str(header)? {
            Request::Open {
                document,
                data,
                described,
            } => {
                let shown = Shown::open(&document, (&data, described), bytes)?;
                let opened = said(&shown.facts()?)?;
                self.shown = Some(shown);
                opened
            }
            Request::Render { size, camera, share } => {
                let shown = self.shown.as_ref().ok_or(WebError::Closed)?;
                return Ok(Heard::Tiles(Box::new(shown.tiles(size, camera, share)?)));
            }
            change => self.shown.as_mut().ok_or(WebError::Closed)?.answer(change)?,
        };
        Ok(Heard::Answer(answer))
    }
}

/// An instance of the engine.
#[derive(Debug)]
pub struct Session {
    renderer: Renderer,
    frame: Frame,
    opened: OpenDocument,
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
            opened: OpenDocument::default(),
        })
    }

    /// Answers a message: its header, JSON, and its bytes. What cannot be answered changes nothing.
    pub fn answer(&mut self, header: &str, bytes: &[u8]) -> Answer {
        self.answered(header, bytes)
            .unwrap_or_else(|error| Answer::refusal(&error))
    }

    fn answered(&mut self, header: &str, bytes: &[u8]) -> Result<Answer, WebError> {
        match self.opened.hear(header, bytes)? {
            Heard::Answer(answer) => Ok(answer),
            Heard::Tiles(tiles) => tiles.draw((&mut self.renderer, &mut self.frame), None),
        }
    }
}
