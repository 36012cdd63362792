//! CPU engine: the selection of a render loop for a scene, and the three render loops.
//!
//! | module | what it renders |
//! |---|---|
//! | `sheets` | grids, meshes, and scenes of several things in layers: the default |
//! | `splats` | everything but one volume splat by splat: 3-D Gaussians as published, points, meshes |
//! | `classic` | one volume by the papers' methods, used only on request |
//!
//! | module | what it does for these |
//! |---|---|
//! | `engine` | [`CpuEngine`], which hands a scene to one of them |
//! | `check`, `route` | say whether a scene can be rendered, and by which |
//! | `items`, `meshes`, `clouds` | turn items into clouds, and keep these between frames |
//! | `phong`, `splat_light`, `simd` | light, and functions of vectors |
//! | `instructions` | [`Work`], which other crates compile, each for one instruction set |
//! | `config`, `run`, `pool`, `prepare`, `room` | options, threads, cancellation and memory |
//!
//! Every pixel receives its contributions in a fixed order (sheets by depth, then layers, bricks and voxels by index;
//! whole splats by depth, then by index), independent of the number of threads and of its tile. So frames are the same
//! to the bit.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod check;
mod classic;
mod clouds;
mod config;
mod engine;
mod instructions;
mod integrals;
mod items;
mod meshes;
#[doc(hidden)]
pub mod microbench;
mod phong;
mod pool;
mod prepare;
mod room;
mod route;
mod run;
mod sheets;
mod simd;
mod splat_light;
mod splats;

pub use check::check;
pub use config::{EngineConfig, EngineError, SimdLevel};
pub use engine::CpuEngine;
pub use instructions::{InstructionSet, Work};
pub use pool::{Pool, most_threads};
