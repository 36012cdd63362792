//! From raw arguments to what is done: defaults, what an earlier picture remembers, and what the data say.
//!
//! An explicit flag beats the picture given with `--like`, which beats what is chosen from the data.

pub(crate) mod around;
pub(crate) mod camera;
pub(crate) mod effects;
mod fastsplats;
mod footprint;
pub(crate) mod input;
pub(crate) mod item_keys;
pub(crate) mod items;
pub(crate) mod kernel;
pub(crate) mod look;
pub(crate) mod method;
pub(crate) mod motion;
pub(crate) mod upright;
