//! Readers and writers as other crates use them. One program: each further one would link every dependency again.

#![allow(clippy::unwrap_used, reason = "panics are how tests fail")]

mod animation;
mod common;
mod dicom;
mod exr;
mod flat;
mod gaussians;
mod hostile;
mod legacy_vtk;
mod mesh;
mod mesh_hostile;
mod metaimage;
mod mutations;
mod nifti;
mod npy;
mod nrrd;
mod png;
mod points;
mod points_hostile;
mod pyramid;
mod raw;
#[cfg(feature = "remote")]
mod remote;
mod shared_stacks;
mod stores;
mod terrain;
mod tiff;
mod transfer_function_files;
mod vti;
mod zarr;
