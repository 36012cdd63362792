//! Vector functions that several stages share.

pub(crate) mod math;
