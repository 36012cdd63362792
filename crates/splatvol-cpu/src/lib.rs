//! The CPU engine: tiles, sheets, SIMD splatting, shading and compositing.
#![forbid(unsafe_code)]

mod renderer;
mod statistics;

pub use renderer::{EngineConfig, EngineError, Renderer};
pub use statistics::{RenderStatistics, StageSeconds};
