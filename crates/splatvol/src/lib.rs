//! Volume rendering by splatting.
#![forbid(unsafe_code)]

mod check;
mod part;
mod progressive;
mod renderer;
mod shutter;

pub use check::check;
pub use progressive::Pass;
pub use renderer::Renderer;
pub use splatvol_core::bin::TileRect;
pub use splatvol_core::engine::{
    Control, Engine, MemoryUse, OnProgress, OnTile, RenderStatistics, Shot, StageSeconds, Task,
};
pub use splatvol_core::radial;
#[cfg(all(target_family = "wasm", target_os = "unknown"))]
pub use splatvol_cpu::set_clock;
pub use splatvol_cpu::{CpuEngine, EngineConfig, EngineError, Pool, SimdLevel};
pub use splatvol_scene::*;
