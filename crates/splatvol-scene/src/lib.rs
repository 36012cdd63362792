//! Description of a picture before it is rendered: validated inputs, plain settings, and the output images.
//!
//! | module | holds |
//! |---|---|
//! | [`grid`] | where samples lie: dimensions and `world_from_voxel` |
//! | [`volume`] | samples on a grid, in their own type, with value range and statistics |
//! | [`source`] | samples at levels of detail, read region by region |
//! | [`chunks`] | samples in chunks, for volumes larger than memory |
//! | [`storage`] | where these lie: in their own memory, or in shared memory |
//! | [`camera`] | `camera_from_world` and the projection to pixels |
//! | [`camera_path`] | cameras that move: turntables and key frames |
//! | [`transfer_function`] | piecewise colour and opacity per unit distance; named maps; automatic choice |
//! | [`lighting`] | the Phong model that engines and reference share |
//! | [`settings`] | render settings: compositing, classification, filter, kernel |
//! | [`motion`] | motion while the shutter is open |
//! | [`points`] | samples of surfaces: places, sizes, normals, colours |
//! | [`mesh`] | a scalar on irregular grids: structured blocks, unstructured cells |
//! | [`gaussians`] | 3-D Gaussians with opacity and spherical harmonics |
//! | [`harmonics`] | colours of Gaussians by direction |
//! | [`item`] | data of one kind with their appearance, placement, operators, clips and motion |
//! | [`scene`] | items that are rendered together |
//! | [`operator`] | changes of material before it is lit: textures, bumps, mirrors, gradient opacity |
//! | [`clip`] | convex bodies that cut away parts |
//! | [`image`] | linear premultiplied float images, frames with depth |
//! | [`exposure`] | the mean of frames |
//!
//! # Spaces and units
//!
//! *voxel*: continuous index, sample centres at integers, x fastest. *world*: the data's own physical unit,
//! right-handed, RAS+ where the file says so. *camera*: x right, y down, z forward, same unit as world.
//! *screen*: pixels, origin top-left, pixel centres at +0.5. *depth* is camera z. `a_from_b` names a matrix that
//! maps points of space b into space a.
//!
//! Constructors are fallible, and their results are valid by themselves; invalid combinations are refused before
//! rendering.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod camera;
pub mod camera_path;
pub mod chunks;
pub mod clip;
mod error;
pub mod exposure;
pub mod gaussians;
pub mod grid;
pub mod harmonics;
pub mod image;
pub mod item;
pub mod lighting;
pub mod mesh;
pub mod motion;
pub mod operator;
pub mod points;
pub mod rotation;
pub mod scene;
pub mod settings;
pub mod source;
pub mod storage;
pub mod transfer_function;
pub mod volume;

pub use camera::{Camera, Projection, ScreenFromCamera, View};
pub use camera_path::{CameraKey, CameraPath};
pub use chunks::{
    Budget, CachedSource, ChunkBuffer, ChunkContent, ChunkCounts, ChunkFault, ChunkSource, ChunkedVolume,
    ElementType, LevelLayout, MinMaxIndex, OverBudget, Recent, Reservation, SourceError, SourceIdentity,
    Survey,
};
pub use clip::{Clip, ClipPlane, Keep};
pub use error::SceneError;
pub use exposure::Exposure;
pub use gaussians::{GaussianAttributes, Gaussians};
pub use grid::{Bounds, Grid, LengthUnit};
pub use image::{Frame, Image, ImageSize};
pub use item::{Content, Isosurface, Item, PointLook};
pub use lighting::Lighting;
pub use mesh::{Association, CellKind, Cells, Mesh, MeshField, Topology};
pub use motion::Motion;
pub use operator::{
    Appearance, BumpMap, EnvironmentMap, GradientOpacity, GradientOpacityPoint, PixelOperator, Region,
    SheetSample, SolidTexture, Stuff, TransferFunction2d, WgslOperator,
};
pub use points::{PointAttributes, Points};
pub use scene::{Scene, SingleVolume};
pub use settings::{
    Absorption, Alignment, Classification, Compositing, Coverage, Extraction, Filter, FlatSettings,
    GaussianMode, Gradient, Kernel, KernelEdge, Method, MotionBlur, Occlusion, PixelFilter, Rasterizer,
    Reconstruction, RenderSettings, SheetContent, SheetKernel, SheetPrecision, SheetSettings, SheetValues,
    Shows, SplatCompositing, SplatSettings, Stretch, TableLayout, TablePrecision,
};
pub use source::{Block, SampleSource, VoxelBox};
pub use storage::Storage;
pub use transfer_function::{
    AutomaticChoice, ColorMap, ColorPoint, Label, OpacityCurve, OpacityPoint, TransferFunction, ValueKind,
};
pub use volume::{Rescale, Samples, Statistics, Volume};
