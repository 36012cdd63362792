//! Several things in one picture: surfels, Gaussians and volumes, gathered into one cloud.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

#[path = "../common/mod.rs"]
mod common;

mod gaussians;
mod meshes;
mod mixed;
mod support;
mod surfels;
