//! The renderer: an engine with threads of its own.

use fearless_simd::Level;
use splatvol_scene::{Camera, Frame, Gaussians};

use crate::engine::{Engine, Placed};
use crate::settings::GaussianSettings;
use crate::simd::SimdLevel;

/// Settings of a renderer's lifetime. They do not change pictures.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct RendererConfig {
    /// Worker threads; `None` takes one per logical processor.
    pub threads: Option<usize>,
    /// Instructions to use; `None` takes the best that the processor has.
    pub simd: Option<SimdLevel>,
}

/// Why a renderer cannot start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RendererError {
    /// The operating system refused the threads.
    #[error("cannot start {threads:?} worker threads: {reason}")]
    Threads {
        /// Threads asked for.
        threads: Option<usize>,
        /// What the system said.
        reason: String,
    },
    /// Instructions that the processor lacks.
    #[error("this processor has no {simd:?} instructions")]
    Simd {
        /// What was asked for.
        simd: SimdLevel,
    },
}

/// Renders clouds of Gaussians; keeps its threads and its memory between frames.
#[derive(Debug)]
pub struct Renderer {
    pool: rayon::ThreadPool,
    level: Level,
    engine: Engine,
}

impl Renderer {
    /// A renderer with threads of its own.
    ///
    /// # Errors
    /// Threads that the system refuses, or instructions that the processor lacks.
    pub fn new(config: RendererConfig) -> Result<Self, RendererError> {
        let level = match config.simd {
            None => Level::new(),
            Some(simd) => simd.level().ok_or(RendererError::Simd { simd })?,
        };
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(config.threads.unwrap_or(0))
            .thread_name(|index| format!("splatvol-gaussians-{index}"))
            .build()
            .map_err(|error| RendererError::Threads {
                threads: config.threads,
                reason: error.to_string(),
            })?;
        Ok(Self {
            pool,
            level,
            engine: Engine::default(),
        })
    }

    /// Bytes that are kept for the next frame.
    pub fn memory(&self) -> usize {
        self.engine.memory()
    }

    /// A picture of all clouds together.
    pub fn render(&mut self, clouds: &[&Gaussians], camera: &Camera, settings: &GaussianSettings) -> Frame {
        let mut frame = Frame::empty(settings.size);
        self.render_into(clouds, camera, settings, &mut frame);
        frame
    }

    /// The same into a frame whose memory is used again if it has the size.
    ///
    /// Draws the first 2^32 - 1 Gaussians if there should be more.
    pub fn render_into(
        &mut self,
        clouds: &[&Gaussians],
        camera: &Camera,
        settings: &GaussianSettings,
        frame: &mut Frame,
    ) {
        let clouds: Vec<Placed<'_>> = clouds.iter().map(|&cloud| cloud.into()).collect();
        let Self { pool, level, engine } = self;
        pool.install(|| engine.render_into(*level, &clouds, (camera, settings), frame));
    }
}
