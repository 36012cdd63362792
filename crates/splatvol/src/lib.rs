//! Volume rendering by splatting.
#![forbid(unsafe_code)]

pub use splatvol_cpu::{EngineConfig, EngineError, RenderStatistics, Renderer, SimdLevel, StageSeconds};
pub use splatvol_scene::*;
