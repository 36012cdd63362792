//! The papers' methods: footprints of any alignment and filter, composited in every way.

mod agreement;
mod antialiasing;
mod fastsplats;
mod motion;
