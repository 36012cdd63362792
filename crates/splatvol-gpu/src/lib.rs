//! GPU engine: the planes of `splatvol-cpu`, in gather form, clouds of other kernels on the same planes (`clouds`), and 3-D
//! Gaussians as published (`gaussians`), on any device of wgpu.
//!
//! A plane's value at a pixel is the definition itself (docs/numerics.md, "The field"):
//!
//! `v = sum_k c_k h(x - k) / sum_k h(x - k)`,
//!
//! h a product of Gaussians cut at `radius` along the voxel axes: 4 or 6 voxels along each of them. The CPU splats the
//! same kernels, cut across the ray instead, and less half of their edge in depth: planes differ by up to half a hundredth of the range
//! at full-contrast edges with the presets' kernel of radius 2. Intervals between planes are classified, lit and
//! composited from the CPU's tables by its rules. Kernels of voxels that are classified first are whole Gaussians on the CPU, so they are
//! wider by what the cut takes from them ([`splatvol_core::kernel::GaussianKernel::sigma_before_cut`]).
//!
//! | pass | module | shader | from | to |
//! |---|---|---|---|---|
//! | assemble | `atlas` | `assemble` | needed voxels' coefficients, of each of the `layers` | pages with a slot each, in a texture |
//! | page | `pager` | - | pages of a volume larger than the budget | some of them at a time |
//! | clear | `march` | `clear` | - | an empty picture |
//! | cull | `march` | `cull` | octants of pages, camera | planes of each tile that may hold something |
//! | march | `march`, `mode` | `field`, `march`, those of the mode | all of these, tables | colour, transmittance, depth |
//! | classify | `voxels` | `classify` | samples, table, light | classes of voxels, where these are splatted |
//! | mixture | `gather` | `gather`, `mixture` | intervals of several layers | the same |
//! | settle | `march`, `direct` | `settle` | what rays kept | the same |
//! | resolve | `march`, [`splatvol_core::level::blend`] | - | these | a frame, two levels in one |
//!
//! `sort` sorts and adds up on the device, `pass` runs a compiled entry point, `device` opens an adapter, `pipelines`
//! compiles shaders, `layout` and `effects` have data as shaders read them, `check` says what is refused. No `unsafe`, no feature beyond those of every WebGPU device.
#![forbid(unsafe_code)]

mod atlas;
mod check;
mod clouds;
mod device;
mod direct;
mod effects;
mod engine;
mod error;
mod footprints;
mod gather;
mod gaussians;
mod layers;
mod layout;
mod march;
mod mode;
mod operators;
mod pager;
mod pass;
mod pipelines;
mod shown;
mod sort;
#[cfg(test)]
mod tests;
mod timer;
mod voxels;

pub use check::check;
pub use device::GpuConfig;
pub use engine::GpuEngine;
pub use error::GpuError;
