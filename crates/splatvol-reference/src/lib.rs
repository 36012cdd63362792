//! The slow, obvious f64 ray integrator that every engine is tested against.
//!
//! It evaluates the field of `docs/numerics.md` point by point, straight from the samples, and integrates it along
//! the ray through each pixel's centre. It shares no code with the engines: no footprints, no sheets, no tables, no
//! tiles, only the scene's types.
//!
//! | module | equation |
//! |---|---|
//! | [`reconstruction`] | `S`, `W`, `v = S / W`, coefficients of the interpolating prefilter |
//! | [`long_voxels`] | values between samples that lie far apart |
//! | `kernel` | the cut Gaussian `h`, and h convolved with the EWA low-pass |
//! | `lattice` | `sum_k p_k h(x - k)` over the samples |
//! | `medium` | extinction and emission at a camera-space point, pre- and post-classified |
//! | `shading` | Phong with surfaceness, voxel gradients |
//! | `features` | where a transfer function bends, so that no thin feature is stepped over |
//! | `integral` | adaptive emission-absorption integral |
//! | `ray_value` | the largest, smallest or mean value along a ray |
//! | [`mod@render`] | rays, clipping, frames |
//! | [`ellipsoids`] | the same integral of a cloud of Gaussian kernels |
//!
//! `SheetSettings::thickness` and `termination` have no meaning here: this is the limit of thin sheets that
//! are never terminated.
#![forbid(unsafe_code)]

pub mod ellipsoids;
mod error;
mod features;
mod integral;
mod kernel;
mod lattice;
pub mod long_voxels;
mod medium;
mod ray_value;
pub mod reconstruction;
pub mod render;
mod shading;
mod solve;

pub use error::ReferenceError;
pub use reconstruction::{Reconstruction, Sums};
pub use render::{PixelResult, Reference, ReferenceSettings, render, render_pixels};
