//! Readers and writers: volumes, points, Gaussians, meshes, transfer functions and images.
//!
//! | module | formats |
//! |---|---|
//! | [`data`] | all of the following: chooses the reader for a file |
//! | [`item`] | the same, with a look that suits it |
//! | [`gaussians`] | `.ply` of 3-D Gaussians, compressed `.ply`, `.splat`, `.ksplat`, `.spz`, `.sog`, glTF |
//! | [`points`] | PLY, LAS, LAZ, COPC, PCD, tables of text; terrain; frames of depth cameras |
//! | [`volume`] | NRRD, MetaImage, NIfTI-1/2, VTK XML image data, legacy VTK, `.npy`/`.npz`, DICOM, TIFF, OME-Zarr, MGH/MGZ, SLC, folders of slices, headerless raw |
//! | [`mesh`] | legacy VTK grids, .vtr, .vts, .vtu, PLOT3D |
//! | [`transfer_function`] | 3D Slicer, ParaView, Inviwo, ImageJ |
//! | [`image`] | PNG, OpenEXR; depth also as `.npy` |
//! | [`animation`] | GIF, animated PNG (written only) |
//! | [`camera_keys`] | key frames of a camera path, TOML or JSON |
//!
//! Readers meet files through [`files`]: those of the system or, in a browser, those that a page was given.
//!
//! Guarantees of every reader: no panic and no endless loop on any bytes; no allocation that the bytes present do not
//! justify; every error names file, field, value and offset; nothing is repaired silently (warnings are listed, and
//! [`ReadOptions::strict`] turns them into errors); no path outside the input's folder is followed (except absolute
//! paths in a scene file, which its user wrote).
#![forbid(unsafe_code)]

pub mod animation;
pub mod camera_keys;
pub mod data;
mod error;
pub mod files;
pub mod gaussians;
pub mod image;
pub mod item;
mod jpeg;
mod json;
mod key_store;
pub mod memory;
pub mod mesh;
mod ply;
pub mod points;
pub mod remote;
mod samples;
mod source;
mod state;
mod tiff_pages;
pub mod transfer_function;
pub mod volume;
mod xml;

pub use animation::{AnimationSettings, ApngWriter, GifWriter};
pub use camera_keys::{StoredCameraKey, read_camera_keys};
pub use data::{Data, DataKind, DataOptions, LoadedData, data_kind, read_data};
pub use error::{FormatError, IoError};
pub use gaussians::{GaussiansDescription, LoadedGaussians, is_gaussians, read_gaussians, write_gaussians};
pub use image::depth::{DepthFormat, encode_depth};
pub use image::part::{Assembly, Part, PartHeader, PartKey, PartOrigin, PictureBlock};
pub use image::png::{Depth as PngDepth, PngRows};
pub use image::{
    ImageFormat, LoadedImage, decode_image, encode_image, read_image, read_image_metadata, write_frame,
    write_image,
};
pub use item::read_item;
pub use key_store::{ByteRange, KeyStore, too_many_bytes};
pub use mesh::plot3d::is_plot3d_pair;
pub use mesh::{LoadedMesh, is_mesh, read_mesh};
pub use points::around_local_origin;
pub use points::depth_image::{DepthImageOptions, read_depth_images};
pub use points::height_field::{HeightFieldOptions, RowOrder, read_height_field};
pub use points::triangles::surfels_of_triangles;
pub use points::{LoadedPoints, read_points};
pub use samples::{Endian, SampleType};
pub use source::read_text;
pub use state::state_of_files;
pub use transfer_function::{
    read_gradient_opacity, read_transfer_function, read_transfer_function_2d, write_transfer_function,
};
pub use volume::zarr::{Compression, OmeVersion, Pyramid, PyramidOptions, write_pyramid};
pub use volume::{
    Description, Loaded, Opened, RawLayout, ReadOptions, WriteOptions, axis_codes, open_volume,
    open_volume_in, read_volume, write_volume,
};
