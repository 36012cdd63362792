//! Several things in one picture: surfels, Gaussians and volumes, gathered into one cloud.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

#[path = "../common/mod.rs"]
#[allow(dead_code, reason = "used in part")]
mod common;

mod gaussians;
mod meshes;
mod mixed;
mod support;
mod surfels;
