//! Analytic fields and the comparison kit of the tests.
//!
//! | module | holds |
//! |---|---|
//! | [`fields`] | scalar fields with closed-form values and gradients; sampling them into volumes |
//! | [`transfer`] | transfer functions of known extinction |
//! | [`random`] | the seeded generator behind every random test |
//! | [`compare`] | how far two pictures are apart, on all four channels |
//! | [`assertion`] | [`Tolerance`] and [`assert_images`]: the one way to demand that pictures agree |
//! | [`snapshot`] | [`assert_snapshot`]: pictures against 16-bit PNGs kept with the tests |
//! | [`method`] | settings of any method, varied from one base |
//! | [`picture`] | pictures as PNG files |
//! | [`pieces`] | volumes in memory as sources of chunks, with faults |
//! | [`chromium`] | a headless browser whose page says something, by WebGPU |
//! | [`process`] | [`alone!`]: tests that measure their process run in one of their own |
//! | [`server`] | a server of files, and what servers do wrong |
//!
//! A failing comparison leaves `expected | difference | actual` and its figures in `target/test-output`.
#![forbid(unsafe_code)]

pub mod assertion;
pub mod chromium;
pub mod compare;
pub mod fields;
pub mod method;
pub mod picture;
pub mod pieces;
pub mod process;
pub mod random;
pub mod server;
pub mod snapshot;
pub mod transfer;

pub use assertion::{Tolerance, assert_images};
pub use compare::Comparison;
pub use fields::{Field, sample};
pub use method::checked;
pub use pieces::{Fault, Pieces};
pub use random::Random;
pub use snapshot::assert_snapshot;
