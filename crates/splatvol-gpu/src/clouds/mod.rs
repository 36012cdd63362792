//! Clouds: points, meshes, volumetric Gaussians and all else with covariances of its own, on the planes of volumes.
//!
//! Sums on a plane are those of `splatvol_cpu::sheets::cloud` (docs/numerics.md, "Clouds of kernels"), in single precision.
//! Footprints end at the same box; the CPU ends them with whole blocks of two pixels.
//!
//! | pass | module | shader | from | to |
//! |---|---|---|---|---|
//! | - | `store` | - | items of a scene | clouds, kept on the host and on the device |
//! | open | `open` | `clouds/open` | kernels, page by page | splats in camera space |
//! | list | `open` | `clouds/pairs`, `sort` | splats | lists of tiles of 16 x 16 pixels and groups of eight planes |
//! | make planes | `layer` | `clouds/planes` | lists | a ring of planes: each group once per band of the picture |
//! | march | `layer` | `clouds/emission`, or `clouds/field` with the shaders of volumes | planes | gathered intervals |
//! | march, settle | `layer` | `clouds/rays` with `cubic` | planes | values of rays, then pixels |
//! | project | `integral` | `clouds/project` | kernels, page by page | whole footprints of optical depth, for X-rays |
//! | integrate, settle | `integral` | `clouds/integrate`, `integrals` | lists of footprints | integrals of rays, then pixels |
//!
//! Splats of a list are in their cloud's order, so sums do not depend on how a device runs workgroups.

mod integral;
mod layer;
mod open;
mod passes;
mod store;

pub(crate) use integral::{Integral, IntegralPasses};
#[cfg(test)]
pub(crate) use integral::{ProfileData, TilesData};
pub(crate) use layer::{CloudLayer, ring_bytes};
#[cfg(test)]
pub(crate) use open::{CloudData, PartData, SPLAT_BYTES};
pub(crate) use open::{Look, Opened, ValueLook};
pub(crate) use passes::{CloudMarch, CloudPasses};
#[cfg(test)]
pub(crate) use store::KernelData;
pub(crate) use store::{CloudStore, OfMesh};
