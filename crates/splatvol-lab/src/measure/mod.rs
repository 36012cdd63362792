//! Measures that several experiments use.

mod clock;
mod picture;
mod spectrum;
mod statistics;

pub(crate) use clock::{Rounds, Timed, median_seconds};
pub(crate) use picture::{luminance, psnr};
pub(crate) use spectrum::Spectrum;
pub(crate) use statistics::{mean, median};
