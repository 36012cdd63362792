//! Engine configuration, and errors at start.

use fearless_simd::Level;

/// Settings of an engine's lifetime.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct EngineConfig {
    /// Worker threads; `None` takes one per logical processor.
    pub threads: Option<usize>,
    /// Edge of a tile in pixels, a multiple of 16 from 16 to 128; `None` takes the fastest. Does not change the
    /// picture.
    pub tile_edge: Option<usize>,
    /// Instructions to use; `None` takes the best available. Does not change the picture.
    pub simd: Option<SimdLevel>,
    /// Memory budget, bytes, for volumes of earlier scenes, prepared and with their samples, the last used first:
    /// switching between a few volumes finds them ready. `None` for 1 GiB.
    pub spare_bytes: Option<usize>,
}

/// Vector instructions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SimdLevel {
    /// Instructions of every processor of the architecture: SSE2 on x86-64, NEON on 64-bit ARM.
    Baseline,
    /// AVX2 with FMA.
    Avx2,
    /// AVX-512.
    Avx512,
}

impl SimdLevel {
    /// All levels.
    pub const ALL: [Self; 3] = [Self::Baseline, Self::Avx2, Self::Avx512];

    /// Whether this processor supports it.
    pub fn is_available(self) -> bool {
        self.level().is_some()
    }

    /// The level, if this processor supports it.
    pub fn level(self) -> Option<Level> {
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

/// Why an engine cannot start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EngineError {
    /// The operating system refused the threads.
    #[error("cannot start {threads:?} worker threads: {reason}")]
    Threads {
        /// Threads asked for.
        threads: Option<usize>,
        /// Message of the operating system.
        reason: String,
    },
    /// More threads than any picture gains from.
    #[error("threads: {threads} is not allowed (at most {most} on this machine)")]
    TooManyThreads {
        /// Threads asked for.
        threads: usize,
        /// Threads that are allowed.
        most: usize,
    },
    /// A thread count that differs from the pool's.
    #[error("threads: {threads} is not allowed (the pool that was given has {there})")]
    Pool {
        /// Threads asked for.
        threads: usize,
        /// Threads of the pool.
        there: usize,
    },
    /// Instructions that the processor lacks.
    #[error("this processor has no {simd:?} instructions")]
    Simd {
        /// Instructions asked for.
        simd: SimdLevel,
    },
    /// No GPU, or none that opens.
    #[error("{reason}")]
    Gpu {
        /// What is missing, or the driver's message.
        reason: String,
    },
    /// A tile edge outside its domain.
    #[error("tile edge: {edge} is not allowed (a multiple of 16 from 16 to 128)")]
    TileEdge {
        /// The offending value, pixels.
        edge: usize,
    },
}
