//! Choice between the engine on the CPU and the one on a GPU.

use splatvol_cpu::{EngineConfig, EngineError};

use crate::{CpuEngine, Renderer};

/// Which engine makes the pictures.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum EngineChoice {
    /// The CPU's: every scene, the same bytes everywhere.
    #[default]
    Cpu,
    /// A GPU's; what it does not draw is refused by name.
    Gpu,
    /// A GPU's where there is a GPU that draws the scene, else the CPU's:
    /// [`RenderStatistics`](crate::RenderStatistics) say which, and why.
    Auto,
}

impl EngineChoice {
    /// Whether this program was built with the GPU's engine (feature `gpu`).
    pub const WITH_GPU: bool = cfg!(feature = "gpu");
}

impl Renderer {
    /// Starts the chosen engine.
    ///
    /// # Errors
    /// As [`Renderer::new`]; with [`EngineChoice::Gpu`] no adapter, or a program that was built without the feature `gpu`.
    pub fn start(choice: EngineChoice, config: EngineConfig) -> Result<Self, EngineError> {
        let cpu = || CpuEngine::new(config);
        match choice {
            EngineChoice::Cpu => cpu().map(Self::with_engine),
            EngineChoice::Gpu => gpu::open().map(Self::with_engine),
            EngineChoice::Auto => Ok(Self::with_engine(gpu::either(cpu()?))),
        }
    }
}

#[cfg(not(feature = "gpu"))]
mod gpu {
    use splatvol_core::engine::{Engine, MemoryUse, RenderStatistics, Shot, Task};
    use splatvol_cpu::EngineError;
    use splatvol_scene::{Frame, SceneError};

    use crate::CpuEngine;

    const NONE: &str = "this program was built without the feature `gpu`";

    pub(super) fn open() -> Result<CpuEngine, EngineError> {
        Err(EngineError::Gpu {
            reason: NONE.to_owned(),
        })
    }

    pub(super) fn either(cpu: CpuEngine) -> Explained {
        Explained(cpu)
    }

    /// The CPU's engine, which says why it is not a GPU's.
    #[derive(Debug)]
    pub(super) struct Explained(CpuEngine);

    impl Engine for Explained {
        fn check(&self, shot: Shot<'_>) -> Result<(), SceneError> {
            self.0.check(shot)
        }

        fn render(
            &mut self,
            shot: Shot<'_>,
            frame: &mut Frame,
            task: Task<'_>,
        ) -> Result<RenderStatistics, SceneError> {
            let statistics = self.0.render(shot, frame, task)?;
            Ok(RenderStatistics {
                why: NONE.to_owned(),
                ..statistics
            })
        }

        fn memory(&self) -> MemoryUse {
            self.0.memory()
        }
    }
}

#[cfg(feature = "gpu")]
mod gpu {
    use splatvol_core::engine::{Engine, MemoryUse, RenderStatistics, Shot, Task};
    use splatvol_cpu::EngineError;
    use splatvol_gpu::{GpuConfig, GpuEngine};
    use splatvol_scene::{Frame, SceneError};

    use crate::CpuEngine;

    pub(super) fn open() -> Result<GpuEngine, EngineError> {
        GpuEngine::new(&GpuConfig::default()).map_err(|error| EngineError::Gpu {
            reason: error.to_string(),
        })
    }

    /// Both engines, as far as there is a GPU. Devices that the CPU imitates are slower than the CPU's own engine.
    pub(super) fn either(cpu: CpuEngine) -> Either {
        let gpu = GpuEngine::new(&GpuConfig::default());
        let gpu = match gpu {
            Ok(gpu) if gpu.is_imitated() => Err(format!("{} is no GPU", gpu.adapter())),
            Ok(gpu) => Ok(gpu),
            Err(error) => Err(error.to_string()),
        };
        Either { cpu, gpu }
    }

    /// A GPU's engine, or why there is none, and the CPU's.
    #[derive(Debug)]
    pub(super) struct Either {
        cpu: CpuEngine,
        gpu: Result<GpuEngine, String>,
    }

    impl Engine for Either {
        fn check(&self, shot: Shot<'_>) -> Result<(), SceneError> {
            self.cpu.check(shot)
        }

        fn render(
            &mut self,
            shot: Shot<'_>,
            frame: &mut Frame,
            task: Task<'_>,
        ) -> Result<RenderStatistics, SceneError> {
            let why = match &mut self.gpu {
                Err(why) => why.clone(),
                Ok(gpu) => match gpu.check(shot).and_then(|()| gpu.render(shot, frame, task)) {
                    Ok(statistics) => return Ok(statistics),
                    Err(error @ SceneError::Stopped) => return Err(error),
                    Err(error) => error.to_string(),
                },
            };
            let statistics = self.cpu.render(shot, frame, task)?;
            Ok(RenderStatistics { why, ..statistics })
        }

        fn memory(&self) -> MemoryUse {
            let on_cpu = self.cpu.memory();
            match &self.gpu {
                Err(_) => on_cpu,
                Ok(gpu) => {
                    let on_gpu = gpu.memory();
                    MemoryUse {
                        volumes: on_cpu.volumes + on_gpu.volumes,
                        spare_volumes: on_cpu.spare_volumes + on_gpu.spare_volumes,
                        device: on_gpu.device,
                        ..on_cpu
                    }
                }
            }
        }
    }
}
