//! Stages shared by the engines: from samples, kernels, transfer function and camera to splats in tile lists.
//!
//! | stage | module | from | to |
//! |---|---|---|---|
//! | classify | [`classification`] | transfer function | tables of extinction and emission, and their integrals |
//!
//! Grids on sheets, of which only the needed voxels are solved:
//!
//! | stage | module | from | to |
//! |---|---|---|---|
//! | refine | [`refine`] | samples of long voxels | samples of nearly cubic ones |
//! | halve | [`mip`] | samples | samples of half the resolution |
//! | select | [`visibility`] | tables | ranges of values that can be seen |
//! | solve | [`field`] | samples, region by region | needed voxels and their coefficients |
//! | plan | [`plan`], with [`footprint`] and [`sheets`] | grid, kernel, camera, bricks | a frame's plan: plain data that engines render tiles from |
//! | bin | [`bin`] | projected bricks, or chunks of a cloud | tile lists, front to back |
//! | level | [`level`], kept by [`prepared`] | volume, transfer function, camera | the resolution that suits the picture |
//! | budget | [`chunk_memory`] | a volume in chunks, a picture | the bytes that its parts may take |
//! | shade | [`shade_table`], [`border`] | tables; the volume's faces | what intervals between planes are shaded with |
//!
//! Clouds of kernels with covariances of their own:
//!
//! | stage | module | from | to |
//! |---|---|---|---|
//! | normalise | [`coefficients`] | samples of a volume | values from 0 to 1 |
//! | cull | [`brick`] | these, tables | bricks that can be seen |
//! | complete | [`points`] | bare points | radii and normals |
//! | surround | [`irregular`] | meshes | kernels with covariances, masses and gradients |
//! | extract | [`scene_cloud`], [`mesh_cloud`] | items of a scene, a mesh | their cloud, kept between frames |
//! | slice | [`cloud_planes`] | a cloud, camera | planes, and how kernels are sampled on them |
//! | gather, project | [`splats`] | kernels anywhere | a cloud of splats, and their footprints by any of the papers' methods |
//!
//! [`kernel`], [`radial`], [`normal`] and [`exponential`] hold the mathematics. [`engine`] is the interface of an
//! engine to its callers.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod bin;
pub mod border;
pub mod brick;
pub mod chunk_memory;
pub mod classification;
pub mod clock;
pub mod cloud_planes;
pub mod cloud_view;
pub mod coefficients;
mod eigen;
pub mod engine;
pub mod exponential;
pub mod field;
pub mod footprint;
pub mod irregular;
pub mod kernel;
pub mod level;
pub mod mesh_cloud;
pub mod mip;
pub mod normal;
pub mod plan;
pub mod points;
mod prefilter;
pub mod prepared;
pub mod radial;
pub mod refine;
mod resample;
pub mod scene_cloud;
pub mod shade_table;
pub mod sheets;
pub mod splats;
pub mod visibility;
