//! The GPU engine in browsers: the same pictures by WebGPU, within the same laws.
//!
//! `laws` renders scenes of all kinds by both engines, and says how far their pictures are apart. In a browser, where
//! `splatvol_gpu` reaches the device through WebGPU and nothing may wait, that is the proof that a page can draw what the
//! command draws; on a desktop the same scenes run through Vulkan, Metal or DirectX. `cargo xtask webgpu` builds the module,
//! and the tests of this crate open it in a headless Chromium.
//!
//! | module | holds |
//! |---|---|
//! | [`laws`] | the scenes, and how far the engines' pictures of them may be apart |
//! | `interface` | the same for JavaScript: `laws()`, a promise |
#![forbid(unsafe_code)]

#[cfg(target_family = "wasm")]
pub mod interface;
pub mod laws;
mod scenes;
