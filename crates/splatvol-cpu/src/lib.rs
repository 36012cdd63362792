//! The CPU engine: tiles, sheets, SIMD splatting, shading and compositing.
//!
//! A frame is planned once (`plan`): tables, sheets, bricks in tile lists. Then every 64 x 64-pixel tile runs on its
//! own, with scratch memory of its thread, front to back, sheet by sheet (`tile`):
//!
//! | stage | module | what happens to a sheet |
//! |---|---|---|
//! | activate | `stage::activate` | bricks that reach the sheet become open voxels in camera space |
//! | splat | `stage::splat` | slices of open voxels are added to the sheet buffer (SIMD) |
//! | shade | `stage::shade` | post-classification: value, coverage, gradient of a pixel to extinction and lit colour |
//! | composite | `stage::composite` | the sheet goes behind what the pixel has; finished blocks are noted |
//! | resolve | `stage::resolve` | pixels to the frame |
//!
//! Every pixel receives its contributions in one order (sheets by depth, then bricks and voxels by index) whatever
//! the number of threads and the tile it lies in, so frames are the same to the bit.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod check;
mod clock;
mod clouds;
mod config;
mod control;
mod coverage;
mod footprints;
#[doc(hidden)]
pub mod kernels;
mod part;
mod phong;
mod plan;
mod pool;
mod progressive;
mod renderer;
mod route;
mod sheets;
mod shutter;
mod simd;
mod splat_light;
mod splats;
mod stage;
mod statistics;
mod tile;

pub use check::check;
#[cfg(any(test, all(target_family = "wasm", target_os = "unknown")))]
pub use clock::set_clock;
pub(crate) use config::level_name;
pub use config::{EngineConfig, EngineError, SimdLevel};
pub use control::{Control, OnProgress, OnTile};
pub use pool::Pool;
pub use progressive::Pass;
pub use renderer::Renderer;
pub use statistics::{RenderStatistics, StageSeconds};
