//! Tests of what other crates use. One program: each further one would link every dependency again.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod field;
mod pictures;
