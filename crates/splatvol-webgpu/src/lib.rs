//! The GPU engine in browsers: the same pictures by WebGPU, within the same laws.
//!
//! A page draws by it what moves, where the browser has a device ([`Session`]). `laws` renders scenes of all kinds by both
//! engines, and says how far their pictures are apart. In a browser, where `splatvol_gpu` reaches the device through WebGPU and
//! nothing may wait, that is the proof that a page can draw what the command draws; on a desktop the same scenes run through
//! Vulkan, Metal or DirectX. `cargo xtask-webgpu` builds one module for pages, and one with the laws, which the tests of this
//! crate open in a headless Chromium.
//!
//! | module | holds |
//! |---|---|
//! | `session` | an instance: a document with its data, and the GPU engine; it answers the messages of `splatvol_web` |
//! | [`laws`] | the scenes, and how far the engines' pictures of them may be apart (feature `laws`) |
//! | `interface` | both for JavaScript: an instance, and `laws()`, a promise |
#![forbid(unsafe_code)]

#[cfg(target_family = "wasm")]
pub mod interface;
#[cfg(feature = "laws")]
pub mod laws;
#[cfg(feature = "laws")]
mod scenes;
mod session;

pub use session::Session;
