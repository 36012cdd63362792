//! Readers and writers of 3-D Gaussians.
#![allow(clippy::unwrap_used, reason = "panics are how tests fail")]

mod harmonics;
mod shared;
