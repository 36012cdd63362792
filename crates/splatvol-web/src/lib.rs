//! The CPU engine for browsers: an instance that holds one document with its data, and answers messages.
//!
//! A message is a header, JSON, and bytes; so is its answer ([`Session::answer`]). There is no state that two instances
//! share, so each worker of a page has an instance of its own, and renders its share of the tiles: no threads, no memory
//! in common, and no page that a server must isolate. All shares together are the whole picture, to the byte, and that is
//! the picture of the command: it is the same code.
//!
//! ```
//! use splatvol_web::{ItemData, Session, VolumeData};
//!
//! let volume = splatvol::samples::sample("marschner-lobb", None)?;
//! let data = VolumeData::of(&volume, false);
//! let bytes = data.pack(&volume);
//! let header = serde_json::json!({
//!     "do": "open",
//!     "document": { "item": [{ "file": "marschner-lobb" }] },
//!     "data": [ItemData::Volume(data)],
//! });
//! let mut session = Session::new()?;
//! let opened = session.answer(&header.to_string(), &bytes);
//! assert!(opened.header.contains("viridis"));
//! let tiles = session.answer(r#"{ "do": "render", "size": [64, 48], "share": [0, 1] }"#, &[]);
//! assert_eq!(tiles.bytes.len(), 64 * 48 * 4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | module | holds |
//! |---|---|
//! | `session` | the instance; its document alone, for engines that are asked in another way |
//! | `shown` | a document with its data: changes, cameras, and the tiles of pictures |
//! | [`message`] | what may be asked, and what is answered |
//! | `data` | samples and clouds as bytes, packed so that they compress well |
//! | `files` | files that a page was given, read; a module of its own, as most pages open none |
//! | `look` | changes of a transfer function: range, strength, colour map, curve |
//! | `interface` | instance and readers as WebAssembly modules, without bindings: memory for a message, and its answer |
#![cfg_attr(not(target_family = "wasm"), forbid(unsafe_code))]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod data;
mod error;
mod files;
#[cfg(all(target_family = "wasm", feature = "module"))]
mod interface;
mod look;
pub mod message;
mod session;
mod shown;

pub use data::{
    CellsData, Column, GaussiansData, ItemData, MeshData, PointsData, Precision, VolumeData, held, size_of,
};
pub use error::WebError;
pub use files::{FileGiven, FilesGiven, FilesRead, ItemRead, read_files};
pub use look::LookEdit;
pub use session::{Answer, BLOCK, Heard, OpenDocument, Session};
pub use shown::{Shown, Tiles};
