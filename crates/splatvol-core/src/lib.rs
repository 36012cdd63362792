//! Stages shared by the engines: from samples, kernel, transfer function and camera to footprints in tile lists.
//!
//! | stage | module | from | to |
//! |---|---|---|---|
//! | prefilter | [`coefficients`] | samples | kernel coefficients |
//! | classify | [`classification`] | transfer function | tables of extinction and emission integrals |
//! | cull | [`brick`] | coefficients, tables | bricks that can be seen |
//! | project | [`footprint`], [`sheets`] | grid, kernel, camera | the one footprint type, sliced by sheets |
//! | bin | [`bin`] | bricks, sheets | tile lists, front to back |
//! | plan | [`plan`] | grid, kernel, camera, bricks | a frame's plan: plain data that engines render tiles from |
//! | extract | [`irregular`] | meshes | kernels with covariances, masses and gradients |
//! | all of them | [`splats`] | kernels anywhere | footprints of any method |
//!
//! [`kernel`], [`radial`], [`normal`] and [`exponential`] hold the mathematics. An engine takes footprints and
//! sheets from this crate and does not know their origin; [`engine`] is the interface of an engine to its callers.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod bin;
pub mod brick;
pub mod classification;
pub mod coefficients;
mod eigen;
pub mod engine;
pub mod exponential;
pub mod field;
pub mod footprint;
pub mod irregular;
pub mod kernel;
pub mod mip;
pub mod normal;
pub mod plan;
pub mod points;
mod prefilter;
pub mod radial;
pub mod sheets;
pub mod splats;
pub mod visibility;
