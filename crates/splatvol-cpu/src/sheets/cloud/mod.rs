//! Clouds: kernels with covariances of their own, on the same planes as the voxels of grids.
//!
//! Let `u` be a splat's centre and `V` its covariance in camera space, p the width of the low-pass, and t the
//! distance of the planes. A plane at depth D receives from the splat (zwicker2001 eq. 22, before the projection to
//! a plane)
//!
//! `m g(D - u_z) exp(-d^T C^-1 d / 2) / (2 pi sqrt|C|)`, `d = x - u_xy - s (D - u_z)`,
//! `v = V_zz + (DEPTH_SIGMA t)^2`, `s = V_xy,z / v`, `C = V_xy,xy - s s^T v + p^2 I`,
//!
//! m is the kernel's integral and g a Gaussian of variance v, cut and normalised. A plane of constant depth only
//! scales, so footprints are exact in perspective, near the camera and far from the axis. Flat splats would slip
//! between two planes; the widening in depth lets planes sample them: sums over planes ripple by a thousandth to
//! either side.
//!
//! | stage | module | what happens |
//! |---|---|---|
//! | plan | `plan` | chunks of the cloud to tile lists, by the first plane that they reach |
//! | open | `open`, `enter` | a chunk's splats into camera space, and into the list of the plane that they reach first |
//! | splat | `enter`, `splat` | a splat into the four planes that it meets next; if it reaches farther, again four planes later |
//! | show | `emission` | planes of extinction and emission, composited |
//! | | `field` | or planes of a mesh's values and weights, post-classified |
//! | | `values` | or one value of each ray kept from those |
//!
//! `mode` is the part of the tile loop that all three share.

pub(crate) mod emission;
mod enter;
pub(crate) mod field;
pub(crate) mod layer;
pub(crate) mod mode;
pub(crate) mod open;
pub(crate) mod plan;
pub(crate) mod splat;
pub(super) mod values;
