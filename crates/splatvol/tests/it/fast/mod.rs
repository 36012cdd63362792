//! The engine that splats into all sheets at once ([`RenderSettings::fast`](splatvol::RenderSettings::fast)): the same
//! bytes whatever runs it, close to the reference and to closed forms, smooth across levels of detail.
//!
//! Tolerances lie a little above the measured values; `--nocapture` prints the figures.

mod agreement;
mod by_depth;
mod close_ups;
mod detail;
mod determinism;
mod fly;
mod holes;
mod laws;
mod modes;
mod slices;
mod standing;
mod state;
pub(crate) mod support;
