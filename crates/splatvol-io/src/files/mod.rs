//! The files that readers read.
//!
//! Where there is a system, they are its own. A browser gives its modules none: there, they are those that a page was given
//! (`give`), under the same names and with the same functions, so that no reader knows of the difference.

#[cfg(any(test, all(target_family = "wasm", target_os = "unknown")))]
mod given;
#[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
mod system;

#[cfg(all(target_family = "wasm", target_os = "unknown"))]
pub(crate) use given::{
    DirEntry, File, canonicalize, exists, is_dir, is_file, is_symlink, metadata, read_at, read_dir,
};
#[cfg(any(test, all(target_family = "wasm", target_os = "unknown")))]
pub use given::{GivenBytes, GivenFile, give};
#[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
pub(crate) use system::{
    DirEntry, File, canonicalize, exists, is_dir, is_file, is_symlink, metadata, read_at, read_dir,
};
