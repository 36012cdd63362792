//! The CPU engine with the loops of the best instruction set of this processor.

use splatvol_core::engine::{Engine, MemoryUse, RenderStatistics, Shot, Task};
use splatvol_cpu::{EngineConfig, EngineError, InstructionSet, Pool, SimdLevel};
use splatvol_scene::{Frame, SceneError};

use compiled::{avx2, avx512, baseline};

/// Renders scenes on the CPU.
#[derive(Debug)]
pub struct CpuEngine(splatvol_cpu::CpuEngine);

impl CpuEngine {
    /// Starts the engine with its own threads.
    ///
    /// # Errors
    /// The system refuses the threads, the tile edge is outside its domain, or the processor lacks the instructions.
    pub fn new(config: EngineConfig) -> Result<Self, EngineError> {
        let instructions = instruction_set(config.simd)?;
        splatvol_cpu::CpuEngine::new(config, instructions).map(Self)
    }

    /// Starts the engine on a caller-provided thread pool, which engines may share.
    ///
    /// # Errors
    /// The configured number of threads differs from the pool's, the tile edge is outside its domain, or the processor
    /// lacks the instructions.
    pub fn with_pool(pool: impl Into<Pool>, config: EngineConfig) -> Result<Self, EngineError> {
        let instructions = instruction_set(config.simd)?;
        splatvol_cpu::CpuEngine::with_pool(pool, config, instructions).map(Self)
    }
}

impl Engine for CpuEngine {
    fn check(&self, shot: Shot<'_>) -> Result<(), SceneError> {
        self.0.check(shot)
    }

    fn render(
        &mut self,
        shot: Shot<'_>,
        frame: &mut Frame,
        task: Task<'_>,
    ) -> Result<RenderStatistics, SceneError> {
        self.0.render(shot, frame, task)
    }

    fn memory(&self) -> MemoryUse {
        self.0.memory()
    }
}

/// The instruction set to use: the best one, if none is given.
fn instruction_set(simd: Option<SimdLevel>) -> Result<InstructionSet, EngineError> {
    match simd {
        None => Ok(avx512().or_else(avx2).unwrap_or_else(baseline)),
        Some(SimdLevel::Baseline) => Ok(baseline()),
        Some(simd @ SimdLevel::Avx2) => avx2().ok_or(EngineError::Simd { simd }),
        Some(simd @ SimdLevel::Avx512) => avx512().ok_or(EngineError::Simd { simd }),
    }
}

/// x86: three instruction sets. Every processor of x86-64 has the first.
#[cfg(target_feature = "sse2")]
mod compiled {
    pub(super) use splatvol_cpu_avx2::instruction_set as avx2;
    pub(super) use splatvol_cpu_avx512::instruction_set as avx512;
    pub(super) use splatvol_cpu_sse2::instruction_set as baseline;
}

/// Other architectures: one.
#[cfg(not(target_feature = "sse2"))]
mod compiled {
    use splatvol_cpu::InstructionSet;

    pub(super) use splatvol_cpu_baseline::instruction_set as baseline;

    pub(super) fn avx2() -> Option<InstructionSet> {
        None
    }

    pub(super) fn avx512() -> Option<InstructionSet> {
        None
    }
}
