//! The CPU engine: which engine renders a scene, and the engines.
//!
//! | module | what it renders |
//! |---|---|
//! | `check`, `route` | nothing: they say whether a scene can be rendered, and by which of these |
//! | `sheets` | grids, meshes, and scenes of several things in layers: the default |
//! | `splats` | everything but one volume splat by splat: 3-D Gaussians as published, points, meshes |
//! | `classic` | one volume by the papers' methods, which are asked for by name |
//! | `coverage`, `shutter`, `progressive` | several of these pictures, made into one |
//!
//! Every pixel receives its contributions in one order (sheets by depth, then bricks and voxels by index) whatever
//! the number of threads and the tile it lies in, so frames are the same to the bit.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod check;
mod classic;
mod clock;
mod clouds;
mod config;
mod control;
mod coverage;
mod items;
#[doc(hidden)]
pub mod kernels;
mod meshes;
mod part;
mod phong;
mod pool;
mod prepare;
mod progressive;
mod renderer;
mod route;
mod run;
mod sheets;
mod shutter;
mod simd;
mod splat_light;
mod splats;
mod statistics;

pub use check::check;
#[cfg(any(test, all(target_family = "wasm", target_os = "unknown")))]
pub use clock::set_clock;
pub(crate) use config::level_name;
pub use config::{EngineConfig, EngineError, SimdLevel};
pub use control::{Control, OnProgress, OnTile};
pub use pool::Pool;
pub use progressive::Pass;
pub use renderer::Renderer;
pub use statistics::{MemoryUse, RenderStatistics, StageSeconds};
