//! The renderer as programs use it. One program: each further one would link every dependency again.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod agreement;
mod allocations;
mod analytic;
mod chunks;
mod common;
mod control;
mod counting;
mod determinism;
mod examples;
mod fast;
mod laws;
mod methods;
mod operators;
mod other_engines;
mod pictures;
mod rotation;
mod scenes;
mod settings;
mod shared_samples;
mod shared_threads;
