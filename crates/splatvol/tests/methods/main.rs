//! The papers' methods: footprints of any alignment and filter, composited in every way.

#[path = "../common/mod.rs"]
mod common;
#[path = "../fast/support.rs"]
#[allow(dead_code, reason = "used in part")]
mod support;

mod agreement;
mod fastsplats;
mod motion;
