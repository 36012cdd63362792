//! The description of a picture as one [`Document`], and the decisions that it leaves open.
//!
//! A document describes a picture by a few keys of a user, or by all keys: for the command's flags, a scene file, the
//! text in a PNG, a notebook or a viewer alike. [`Document::resolve`] reads the data and decides the rest: which way is
//! up, how values look, where the camera stands, which method suits. All programs decide by this crate, so all make the
//! same picture of the same data.
//!
//! ```
//! use splatvol_document::{Document, ReadRules, Reading, Resolving, Silent};
//!
//! let text = "[[item]]\nfile = \"sample:head:16\"\n[camera]\nview = \"front\"\n";
//! let asked = Document::from_toml(text, "scene.toml".as_ref())?;
//! let reading = Reading { rules: ReadRules::default(), folder: None, listener: &Silent };
//! let resolving = Resolving { reading, held: &[], moves: Default::default(), keeps_alpha: false, in_windows: false };
//! let picture = asked.resolve(resolving)?;
//! assert!(picture.document.camera.position.is_some() && picture.scene.items.len() == 1);
//! # Ok::<(), splatvol_document::DocumentError>(())
//! ```
//!
//! | module | holds |
//! |---|---|
//! | `document`, [`keys`], [`spelling`] | the document, its tables, and how names are written |
//! | [`mod@format`], `version1` | TOML, JSON and PNG text; what earlier versions wrote |
//! | [`edit`] | edits, undo and redo |
//! | `schema` | the JSON schema |
//! | [`resolve`] | from a document to a picture that can be rendered |
//! | [`items`], [`input`], [`held`], [`meaning`] | reading an item, or taking it from memory; which keys it can have |
//! | `chunked` | items that are read in chunks when they are drawn |
//! | [`look`], [`settings`], `effects`, [`motion`] | transfer function, method, operators and clips, motion blur |
//! | [`upright`], [`standing`] | which way is up: as given, or as the data suggest |
//! | [`camera`], `framing`, `turning` | the camera: as requested, or so that an outline fills the picture, still or turning |
//! | [`mod@outline`], `mesh_outline`, [`visible`] | what an automatic camera shows of an item: voxels and cells that can be seen |
//! | [`animation`] | which cameras see which frame |
//! | `files` | the door to files, which is shut in browsers |
//! | [`listener`], `error` | listeners to choices and warnings; errors |
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod animation;
pub mod camera;
mod chunked;
mod document;
pub mod edit;
mod effects;
mod error;
mod files;
pub mod format;
mod framing;
pub mod held;
pub mod input;
pub mod items;
pub mod keys;
pub mod listener;
pub mod look;
pub mod meaning;
mod mesh_outline;
pub mod motion;
pub mod outline;
pub mod resolve;
mod schema;
pub mod settings;
pub mod spelling;
pub mod standing;
mod turning;
pub mod upright;
mod version1;
pub mod visible;

pub use animation::Plan;
pub use camera::{CameraPose, Surroundings, orbited};
pub use document::{Document, VERSION};
pub use edit::{Edit, History};
pub use error::DocumentError;
pub use format::Record;
pub use held::{Held, HeldContent};
pub use input::{ChunkRules, ReadRules, Reading};
pub use listener::{Listener, Silent};
pub use motion::CameraMotion;
pub use outline::outline;
pub use resolve::{Picture, Resolving};
pub use schema::schema;
