//! The stages of a tile, in the order in which data passes through them.

pub(crate) mod activate;
pub(crate) mod composite;
pub(crate) mod cover;
pub(crate) mod resolve;
pub(crate) mod shade;
pub(crate) mod sheet_buffer;
pub(crate) mod splat;
