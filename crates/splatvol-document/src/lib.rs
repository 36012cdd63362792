//! Decisions that the description of a picture leaves open: the camera, and which way is up.
//!
//! The command, a notebook, a viewer and the machines of a cluster all decide by this crate, so they make the same picture
//! of the same data.
//!
//! | module | decides |
//! |---|---|
//! | [`camera`] | the camera: asked for, framed automatically, or moved from an earlier one |
//! | [`mod@outline`] | what an automatic camera shows of an item |
//! | `mesh_outline` | the cells of a mesh that can be seen |
//! | [`visible`] | which voxels can be seen, but for specks |
//! | [`standing`] | which way is up where no file says so |
//! | `framing`, `turning` | where a camera has to be for an outline to fill the picture, still or on a turntable |
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod camera;
mod framing;
mod mesh_outline;
pub mod outline;
pub mod standing;
mod turning;
pub mod visible;

pub use camera::{CameraKeys, CameraPose, Fit, Lens, Surroundings, orbited};
pub use outline::outline;
