//! The papers' methods: footprints of any alignment and filter, composited in every way.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

#[path = "../common/mod.rs"]
mod common;
#[path = "../fast/support.rs"]
#[allow(dead_code, reason = "used in part")]
mod support;

mod agreement;
mod antialiasing;
mod fastsplats;
mod motion;
