//! The engine for browsers, as it was built.

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

/// The engine, a WebAssembly module in gzip.
///
/// # Errors
/// Programs without it.
pub fn engine() -> Result<&'static [u8], Absent> {
    // A constant would be copied to every place where it is used.
    static ENGINE: Result<&[u8], Absent> = include!(concat!(env!("OUT_DIR"), "/engine.rs"));
    ENGINE
}
