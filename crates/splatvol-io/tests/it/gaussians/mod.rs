//! Readers and writers of 3-D Gaussians.

mod formats;
mod harmonics;
mod malformed;
mod shared;
