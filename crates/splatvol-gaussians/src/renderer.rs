//! The renderer: an engine with threads of its own.

use fearless_simd::Level;
use splatvol_scene::{Camera, Frame, Gaussians};

use crate::engine::{Engine, Placed};
use crate::settings::GaussianSettings;

/// Settings of a renderer's lifetime. They do not change pictures.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct RendererConfig {
    /// Worker threads; `None` takes one per logical processor.
    pub threads: Option<usize>,
    /// Instructions to use; `None` takes the best that the processor has.
    pub simd: Option<SimdLevel>,
}

/// Vector instructions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SimdLevel {
    /// What every processor of the architecture has: SSE2 on x86-64, NEON on 64-bit ARM.
    Baseline,
    /// AVX2 with FMA.
    Avx2,
    /// AVX-512.
    Avx512,
}

impl SimdLevel {
    /// All levels.
    pub const ALL: [Self; 3] = [Self::Baseline, Self::Avx2, Self::Avx512];

    /// Whether this processor has it.
    pub fn is_available(self) -> bool {
        self.level().is_some()
    }

    fn level(self) -> Option<Level> {
        match self {
            Self::Baseline => Some(Level::baseline()),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Self::Avx2 => Level::new().as_avx2().map(Level::Avx2),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Self::Avx512 => Level::new().as_avx512().map(Level::Avx512),
            #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
            Self::Avx2 | Self::Avx512 => None,
        }
    }
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
        let (threads, view) = ((&self.pool, self.level), (camera, settings));
        self.engine.render_into(threads, &clouds, view, frame);
    }
}
