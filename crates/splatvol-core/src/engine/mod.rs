//! What an engine is to everything outside it: a scene, a camera and settings become a frame.
//!
//! A renderer asks an engine for pictures of one sample per pixel; it makes of them what a shutter sees, edges that are sampled
//! several times, progressive passes and parts. An engine sees none of that: a [`Task`] tells it which tiles are wanted,
//! and when to give up.
//!
//! | module | holds |
//! |---|---|
//! | `control` | what a caller may ask of a picture while it is made; the engine's side of it |
//! | `edges` | the pixels of a picture that are sampled several times |
//! | `statistics` | what a picture took: the report of an engine |

mod control;
mod edges;
mod statistics;

use std::fmt::Debug;

use splatvol_scene::{Camera, Frame, RenderSettings, Scene, SceneError};

pub use control::{Control, OnProgress, OnTile, Progress, Task};
pub use edges::Edges;
pub use statistics::{MemoryUse, RenderStatistics, StageSeconds};

/// A picture to be made.
#[derive(Debug, Clone, Copy)]
pub struct Shot<'a> {
    /// What it shows.
    pub scene: &'a Scene,
    /// From where.
    pub camera: &'a Camera,
    /// How.
    pub settings: &'a RenderSettings,
}

/// Makes pictures of scenes, one sample per pixel, and keeps between them what it derives from their items.
pub trait Engine: Debug + Send {
    /// Whether the engine can make a picture, before it begins.
    ///
    /// # Errors
    /// Why not: the field, its value and what would be accepted; or what was asked for, and what cannot be combined with it.
    fn check(&self, shot: Shot<'_>) -> Result<(), SceneError>;

    /// Makes a picture that passes [`Engine::check`]. `frame` is of the settings' size; of tiles that the task does not want it
    /// holds anything afterwards.
    ///
    /// # Errors
    /// [`SceneError::Stopped`], which leaves nonsense in the frame; places that cannot be inverted.
    fn render(
        &mut self,
        shot: Shot<'_>,
        frame: &mut Frame,
        task: Task<'_>,
    ) -> Result<RenderStatistics, SceneError>;

    /// Bytes held between pictures, by what they are for.
    fn memory(&self) -> MemoryUse;
}
