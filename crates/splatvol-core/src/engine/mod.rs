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
//! | `share` | equal shares of a picture, for workers |
//! | `statistics` | what a picture took: the report of an engine |

mod control;
mod edges;
mod share;
mod statistics;

use std::fmt::Debug;

use splatvol_scene::{Camera, Frame, RenderSettings, Scene, SceneError};

pub use control::{Control, GoOn, OnProgress, OnTile, Partial, Progress, Task, WINDOW_STEP};
pub use edges::Edges;
pub use share::Share;
pub use statistics::{ChunkStatistics, MemoryUse, PassSeconds, RenderStatistics, StageSeconds};

/// A picture to render.
#[derive(Debug, Clone, Copy)]
pub struct Shot<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The camera.
    pub camera: &'a Camera,
    /// The settings.
    pub settings: &'a RenderSettings,
}

/// Renders scenes with one sample per pixel, and caches data derived from their items.
pub trait Engine: Debug + Send {
    /// Checks, before rendering, that the engine supports a picture.
    ///
    /// # Errors
    /// The offending field, its value and the accepted values; or the feature in use, and the one it cannot be
    /// combined with.
    fn check(&self, shot: Shot<'_>) -> Result<(), SceneError>;

    /// Renders a picture that passes [`Engine::check`]. `frame` is of the settings' size, or of that of
    /// the task's window; the contents of tiles that the task does not want are undefined afterwards.
    ///
    /// # Errors
    /// [`SceneError::Stopped`], after which the frame's contents are undefined; transformations that cannot be
    /// inverted.
    fn render(
        &mut self,
        shot: Shot<'_>,
        frame: &mut Frame,
        task: Task<'_>,
    ) -> Result<RenderStatistics, SceneError>;

    /// Bytes held between pictures, by purpose.
    fn memory(&self) -> MemoryUse;
}
