//! Volume rendering by splatting.
#![forbid(unsafe_code)]

pub use splatvol_core::bin::TileRect;
pub use splatvol_core::radial;
#[cfg(all(target_family = "wasm", target_os = "unknown"))]
pub use splatvol_cpu::set_clock;
pub use splatvol_cpu::{
    Control, EngineConfig, EngineError, OnProgress, OnTile, Pass, Pool, RenderStatistics, Renderer,
    SimdLevel, StageSeconds, check,
};
pub use splatvol_scene::*;
