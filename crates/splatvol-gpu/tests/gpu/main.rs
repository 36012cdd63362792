//! The GPU engine against the CPU engine, and requests that it refuses.
#![allow(clippy::unwrap_used, reason = "tests")]

mod chunks;
mod clouds;
mod common;
mod effects;
mod gaussians;
mod pictures;
