//! An instance: one document with its data, as [`splatvol_web::Session`], and the GPU engine. It answers the same messages, later:
//! in browsers nothing may wait.

use splatvol::{Control, Engine, Frame, ImageSize, Task};
use splatvol_gpu::{GpuConfig, GpuEngine};
use splatvol_web::{Answer, Heard, OpenDocument, Tiles, WebError};

/// An instance of the GPU engine.
#[derive(Debug)]
pub struct Session {
    engine: GpuEngine,
    frame: Frame,
    opened: OpenDocument,
}

impl Session {
    /// An instance without a document, on the device that the browser prefers.
    ///
    /// # Errors
    /// No WebGPU, or a device that lacks what the engine needs.
    pub async fn open() -> Result<Self, Box<dyn std::error::Error>> {
        Ok(Self {
            engine: GpuEngine::open(&GpuConfig::default()).await?,
            frame: Frame::empty(ImageSize::new(1, 1)?),
            opened: OpenDocument::default(),
        })
    }

    /// Answers a message: its header, JSON, and its bytes. What cannot be answered, or drawn by this engine, changes nothing.
    pub async fn answer(&mut self, header: &str, bytes: &[u8]) -> Answer {
        match self.answered(header, bytes).await {
            Ok(answer) => answer,
            Err(error) => Answer::refusal(&error),
        }
    }

    async fn answered(&mut self, header: &str, bytes: &[u8]) -> Result<Answer, WebError> {
        match self.opened.hear(header, bytes)? {
            Heard::Answer(answer) => Ok(answer),
            Heard::Tiles(tiles) => self.draw(&tiles).await,
        }
    }

    async fn draw(&mut self, tiles: &Tiles) -> Result<Answer, WebError> {
        let shot = tiles.shot();
        self.engine.check(shot)?;
        if self.frame.image.size() != shot.settings.size {
            self.frame = Frame::empty(shot.settings.size);
        }
        let task = Task::new(&Control::default(), &|_| {});
        self.engine.render_async(shot, &mut self.frame, task).await?;
        tiles.answer(&self.frame)
    }
}
