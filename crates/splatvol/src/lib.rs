//! Volume rendering by splatting.
#![forbid(unsafe_code)]

pub use splatvol_core::radial;
pub use splatvol_cpu::{
    EngineConfig, EngineError, Pass, RenderStatistics, Renderer, SimdLevel, StageSeconds, check,
};
pub use splatvol_scene::*;
