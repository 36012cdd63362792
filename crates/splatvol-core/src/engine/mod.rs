//! Engine interface: renders a scene with a camera and settings to a frame.
//!
//! An engine renders pictures of one sample per pixel. The renderer combines them for motion blur, adaptively
//! sampled edges, progressive passes and parts of a picture. The engine itself knows none of these: a [`Task`]
//! holds the wanted tiles and the cancellation flag.
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
    /// The scene.
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
