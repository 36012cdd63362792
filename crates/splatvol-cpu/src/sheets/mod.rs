//! Sheets: kernels are summed on planes, and the planes composited.
//!
//! | stage | module | what happens |
//! |---|---|---|
//! | level | `levels`, [`splatvol_core::level`] | the volume, or the halves of it that suit the picture's scale, with the data that a transfer function needs |
//! | plan | `frame`, [`splatvol_core::plan`] | kernel and camera to sheets, sheets to runs of one raster each, bricks to tiles |
//! | activate | `activate`, `mask` | voxels that enter a sheet, by depth, less what finished pixels hide |
//! | splat | `records`, `splat`, `footprint`, `needed`, `direct`, `sheet`, `ring` | each voxel once into the four sheets (or eight, twelve...) that it meets |
//! | | `cloud` | or kernels of their own shapes: points, Gaussians, samples of meshes |
//! | take | `plane`, `upsample` | a finished sheet out of the ring, to pixels |
//! | | `eye` | the planes at the eye, which have no scale, where it is within the volume |
//! | | `holes` | the same for missing samples, whose weight the sums lack |
//! | shade | `shaded`, `shade`, `shade_batch` | two planes: classified, lit, composited |
//! | | `operated`, `cut`, `crossing` | with operators, clips or isosurfaces: the same pixel by pixel |
//! | | `analytic`, `gradients`, `hermite`, `fine_table`, `lattice_weights` | or analytic gradients splatted too, and cubics with exact slopes lit piece by piece |
//! | | `intensity`, `exact_intensity`, `slopes`, `cubic`, `extremum` | or the largest, smallest or mean value between them kept |
//! | | `classified`, `compose` | or classified voxels composited |
//! | | `classified`, `integral`, `slab` | or classified voxels integrated |
//! | resolve | `resolve` | tiles to the frame |
//!
//! `engine` keeps state from frame to frame, `tiles` the pixels from pass to pass. A `picture` is what tiles show, of any mode. `layer` runs the layers of a `tile` through these
//! stages (several in a `scene`, as `layers`), and `canvas` composites their material. A `mode` holds what differs
//! between post-classification and the others.
#![allow(
    clippy::needless_range_loop,
    reason = "iterators over several arrays need closures, which do not inline into code for vectors"
)]

pub(crate) mod activate;
pub(crate) mod analytic;
pub(crate) mod blocks;
pub(crate) mod canvas;
pub(crate) mod classified;
pub(crate) mod cloud;
pub(crate) mod compose;
pub(crate) mod crossing;
pub(crate) mod cubic;
pub(crate) mod cut;
pub(crate) mod direct;
pub(crate) mod engine;
pub(crate) mod exact_intensity;
pub(crate) mod extremum;
pub(crate) mod eye;
pub(crate) mod fine_table;
pub(crate) mod footprint;
pub(crate) mod frame;
pub(crate) mod gradients;
pub(crate) mod hermite;
pub(crate) mod holes;
pub(crate) mod integral;
pub(crate) mod intensity;
pub(crate) mod lattice_weights;
pub(crate) mod layer;
pub(crate) mod layers;
pub(crate) mod levels;
pub(crate) mod mask;
pub(crate) mod mode;
pub(crate) mod needed;
pub(crate) mod operated;
pub(crate) mod picture;
pub(crate) mod pixel;
pub(crate) mod place;
pub(crate) mod plane;
pub(crate) mod records;
pub(crate) mod resolve;
pub(crate) mod ring;
pub(crate) mod scene;
pub(crate) mod shade;
pub(crate) mod shade_batch;
pub(crate) mod shaded;
pub(crate) mod sheet;
pub(crate) mod slab;
pub(crate) mod slopes;
pub(crate) mod splat;
pub(crate) mod tile;
pub(crate) mod tiles;
pub(crate) mod upsample;
