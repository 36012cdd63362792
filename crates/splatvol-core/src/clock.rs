//! Clock for the timing of stages. Pictures do not depend on it.

#[cfg(any(test, all(target_family = "wasm", target_os = "unknown")))]
mod host;

#[cfg(all(target_family = "wasm", target_os = "unknown"))]
pub use host::Instant;
#[cfg(any(test, all(target_family = "wasm", target_os = "unknown")))]
pub use host::set_clock;
#[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
pub use std::time::Instant;
