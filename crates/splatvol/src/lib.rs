//! Volume rendering by splatting.
#![forbid(unsafe_code)]

pub use splatvol_cpu::{EngineConfig, EngineError, RenderStatistics, Renderer, StageSeconds};
pub use splatvol_scene::*;
