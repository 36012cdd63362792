//! The engines and the readers for browsers, as they were built.

/// There is no engine for browsers in this program: none was built before it, and no committed one was there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("this program was built without the engine for browsers")]
pub struct Absent;

impl Absent {
    /// What to do about it.
    pub const REMEDY: &str = "scripts/wasm; cargo xtask web; then build this program again";
}

/// The GPU engine, a WebAssembly module, and its bindings, JavaScript; both in gzip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WebGpu {
    /// The module.
    pub module: &'static [u8],
    /// What it calls of the browser.
    pub bindings: &'static [u8],
}

/// The GPU engine, where this program has one of its own sources, or one as old as the [engine](engine()). Pages do without it.
pub fn webgpu() -> Option<WebGpu> {
    static WEBGPU: Option<WebGpu> = include!(concat!(env!("OUT_DIR"), "/webgpu.rs"));
    WEBGPU
}

/// WebAssembly modules in gzip.
#[derive(Debug, Clone, Copy)]
struct Modules {
    engine: &'static [u8],
    readers: &'static [u8],
    /// Whether they were built of the sources of this program.
    is_current: bool,
}

// A constant would be copied to every place where it is used.
static MODULES: Result<Modules, Absent> = include!(concat!(env!("OUT_DIR"), "/engine.rs"));

/// The engine, a WebAssembly module in gzip.
///
/// # Errors
/// Programs without it.
pub fn engine() -> Result<&'static [u8], Absent> {
    MODULES.map(|modules| modules.engine)
}

/// The readers of files, a WebAssembly module in gzip.
///
/// # Errors
/// Programs without them: those without the engine.
pub fn readers() -> Result<&'static [u8], Absent> {
    MODULES.map(|modules| modules.readers)
}

/// A sentence for users whose program has an engine of other sources, and how to get its own.
pub fn outdated() -> Option<&'static str> {
    let is_outdated = MODULES.is_ok_and(|modules| !modules.is_current);
    is_outdated.then_some(
        "the engine for browsers is older than this program: pictures of pages may differ from its own \
         (scripts/wasm; cargo xtask web; then build this program again)",
    )
}
