//! One HTML file that shows volumes, points, Gaussians and meshes: it turns, zooms, changes look and clip, in any browser, without a network.
//!
//! A page is the player (DOM, hand-written), the engine as WebAssembly, a document, and its data, which are made to fit a
//! size. The player asks instances of the engine, one per worker, for pictures ([`splatvol_web`]); where workers are
//! blocked, the page has one itself. Its content policy forbids every connection.
//!
//! | module | holds |
//! |---|---|
//! | `content` | what a page shows of a picture |
//! | `engine` | the engines, gzip: those of `cargo xtask web` and `cargo xtask-webgpu`, or the committed ones |
//! | `fit` | data in fewer bits or of a coarser level, until they fit |
//! | `template` | the page with slots: each is filled once, by text that is escaped, or by code and data that are checked |
//! | `page` | the page of a document |
//!
//! The player is in the folder `player`: `page.html` has the slots, `engine.js` runs in workers, `camera.js` moves the
//! camera, `frames.js` decides what is rendered when, `controls.js` makes the panel, `player.js` begins; `server.js` is
//! in pages from a server only, and `webgpu.js` draws what moves where the browser has a device.
#![forbid(unsafe_code)]

mod content;
mod engine;
mod error;
mod fit;
mod page;
mod template;

pub use content::PageContent;
pub use engine::{Absent, WebGpu, engine, outdated, readers, webgpu};
pub use error::PageError;
pub use fit::{Bits, Fitted, Piece, fit};
pub use page::{ENGINE_SCRIPT, Page};
