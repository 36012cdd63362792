//! Splats: kernels in space with covariances of their own, and their footprints in a camera's view.
//!
//! A [`SplatCloud`] holds voxels, samples of meshes, points and Gaussians alike, and is independent of the camera. The
//! papers' methods turn each of its splats into a [`Footprint`] by a [`Projection`], and need nothing else; sheets and
//! whole splats project clouds themselves.
//!
//! | module | holds |
//! |---|---|
//! | `cloud` | centres, payloads and covariances, in chunks of neighbours |
//! | `extract` | the cloud of a classified volume, and that of its values |
//! | `gather` | one cloud of voxels, samples of meshes, surfels and Gaussians |
//! | `profile` | the radial profile of a footprint, whole and between depths |
//! | `radial` | that of any radial kernel |
//! | `footprint` | the footprint: from pixel to radius |
//! | `ray` | footprints of kernels that are whitened, for rays that diverge |
//! | `moving`, `sweep` | motion blur of footprints |
//! | `projection` | alignment, low-pass, scaling: from splat to footprint |

mod cloud;
mod extract;
mod footprint;
mod gather;
mod moving;
mod profile;
mod projection;
mod radial;
mod ray;
mod sweep;

pub use cloud::{Chunk, KernelShape, SplatCloud};
pub use extract::{Extract, Interest, classified, unclassified};
pub use footprint::{Footprint, Sample, Warp};
pub use gather::{Gather, Gathered, Splat, gaussian_payload};
pub use moving::{Moving, Passage, Path, whitening};
pub use profile::{GaussianProfile, Profile};
pub use projection::{AlignmentErrors, Bounds, CameraView, Projection};
pub use radial::RadialProfile;
pub use ray::{Ray, Trapezoid};
