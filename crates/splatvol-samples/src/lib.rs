//! Built-in sample volumes, generated on the spot: nothing to download, the same bytes on every run and for any
//! number of threads.
//!
//! | name | contents |
//! |---|---|
//! | `head` | a CT-like head phantom in Hounsfield units, RAS+, built from implicit shapes |
//! | `marschner-lobb` | the standard test of reconstruction filters |
//! | `checker-sheet` | one checkered slice (swan1997, figure 7) |
//! | `tunnel` | a checkered tube (mueller1998, figure 5) |
//! | `zebra` | a thin striped slab (zwicker2001, figure 8) |
//! | `shells` | nested noisy shells, the benchmark volume |
//! | `ball` | `1 - (r/R)^2`, exact in closed form |
//! | `slab` | a linear ramp along x, exact in closed form |
//! | `terrain` | a landscape in the colours of a satellite photograph (mueller1998, figure 6) |
//! | `microtubules` | many thin bent tubes |
//! | `nerve` | a branching cell in voxels of 1:1:5 |
//! | `tomato` | a fruit with chambers and seeds |
//!
//! ```
//! let volume = splatvol_samples::sample("marschner-lobb", None)?;
//! assert_eq!(volume.grid().dims(), [41, 41, 41]);
//! # Ok::<(), splatvol_samples::SampleError>(())
//! ```
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod error;
mod fill;
mod head;
mod noise;
mod registry;
mod rotation;
mod signals;
mod terrain;
mod textures;
mod tomato;
mod transfer;
mod tubes;

pub use error::SampleError;
pub use registry::{Sample, SampleSize, sample};
