//! The engines and the readers for browsers, as they were built.

/// Why there is no engine for browsers in this program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Absent {
    /// It was not built before this program.
    #[error("this program was built without the engine for browsers")]
    NotBuilt,
    /// It was built of other sources than this program: its pictures might differ.
    #[error("the engine for browsers was built of other sources than this program")]
    OutOfDate,
}

impl Absent {
    /// What to do about it.
    pub const REMEDY: &str =
        "rustup target add wasm32-unknown-unknown; cargo xtask web; then build this program again";
}

/// The GPU engine, a WebAssembly module, and its bindings, JavaScript; both in gzip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WebGpu {
    /// The module.
    pub module: &'static [u8],
    /// What it calls of the browser.
    pub bindings: &'static [u8],
}

/// The GPU engine, where `cargo xtask-webgpu` has built it of the sources of this program. Pages do without it.
pub fn webgpu() -> Option<WebGpu> {
    static WEBGPU: Option<WebGpu> = include!(concat!(env!("OUT_DIR"), "/webgpu.rs"));
    WEBGPU
}

// A constant would be copied to every place where it is used.
static MODULES: Result<[&[u8]; 2], Absent> = include!(concat!(env!("OUT_DIR"), "/engine.rs"));

/// The engine, a WebAssembly module in gzip.
///
/// # Errors
/// Programs without it.
pub fn engine() -> Result<&'static [u8], Absent> {
    MODULES.map(|[engine, _]| engine)
}

/// The readers of files, a WebAssembly module in gzip.
///
/// # Errors
/// Programs without them: those without the engine.
pub fn readers() -> Result<&'static [u8], Absent> {
    MODULES.map(|[_, readers]| readers)
}
