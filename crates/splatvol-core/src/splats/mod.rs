//! Splats: kernels in space, and what a camera makes of them.
//!
//! Whatever is rendered - voxels, and whatever else comes in kernels - becomes a [`SplatCloud`], which knows no camera. A
//! [`Projection`] turns each splat of it into a [`Footprint`], and an engine that draws footprints knows nothing else
//! (design: one primitive for all).
//!
//! | module | holds |
//! |---|---|
//! | `cloud` | centres, payloads and covariances, in chunks of neighbours |
//! | `extract` | the cloud of a classified volume, and that of its data |
//! | `profile` | the radial profile of a footprint, whole and between depths |
//! | `radial` | that of any radial kernel |
//! | `footprint` | the footprint: from pixel to radius |
//! | `projection` | alignment, low-pass, scaling: from splat to footprint |

mod cloud;
mod extract;
mod footprint;
mod profile;
mod projection;
mod radial;

pub use cloud::{Chunk, KernelShape, SplatCloud};
pub use extract::{Extract, Interest, classified, data};
pub use footprint::{Footprint, Ray, Sample, Warp};
pub use profile::{GaussianProfile, Profile};
pub use projection::{Bounds, Projection, View};
pub use radial::RadialProfile;
