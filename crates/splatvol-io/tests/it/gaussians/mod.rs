//! Readers and writers of 3-D Gaussians.
#![allow(clippy::unwrap_used, reason = "panics are how tests fail")]

#[path = "../common/mod.rs"]
mod common;
mod files;
mod formats;
mod harmonics;
mod malformed;
mod shared;
