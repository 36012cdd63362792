//! The renderer.

use splatvol_scene::{Camera, Frame, Image, RenderSettings, Scene, SceneError};

use crate::statistics::RenderStatistics;

/// Settings of an engine's lifetime.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct EngineConfig {
    /// Worker threads; `None` takes one per logical processor.
    pub threads: Option<usize>,
}

/// Why an engine cannot start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EngineError {
    /// The operating system refused the threads.
    #[error("cannot start {threads} worker threads: {reason}")]
    Threads {
        /// Threads asked for.
        threads: usize,
        /// What the system said.
        reason: String,
    },
}

/// Renders scenes; keeps what it derives from a volume between frames.
#[derive(Debug, Default)]
pub struct Renderer {
    statistics: RenderStatistics,
}

impl Renderer {
    /// Starts the engine.
    ///
    /// # Errors
    /// When the worker threads cannot be started.
    pub fn new(_config: EngineConfig) -> Result<Self, EngineError> {
        Ok(Self::default())
    }

    /// Renders one frame.
    ///
    /// # Errors
    /// Settings outside their domain.
    pub fn render(&mut self, scene: &Scene, camera: &Camera, settings: &RenderSettings) -> Result<Frame, SceneError> {
        self.render_with_progress(scene, camera, settings, &|_| {})
    }

    /// Renders one frame, reporting the finished share (0..1) from any thread.
    ///
    /// # Errors
    /// Settings outside their domain.
    pub fn render_with_progress(
        &mut self,
        _scene: &Scene,
        _camera: &Camera,
        settings: &RenderSettings,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Frame, SceneError> {
        settings.validate()?;
        progress(1.0);
        let count = settings.size.pixel_count();
        Ok(Frame {
            image: Image::filled(settings.size, [0.0; 4]),
            depth: vec![f32::INFINITY; count],
            optical_depth: vec![0.0; count],
        })
    }

    /// Times and counts of the last frame.
    pub fn statistics(&self) -> &RenderStatistics {
        &self.statistics
    }
}
