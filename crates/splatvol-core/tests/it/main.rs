//! Tests of what other crates use. One program: each further one would link every dependency again.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod alignment;
mod footprint_tables;
mod motion;
mod reconstruction;
