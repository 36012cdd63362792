//! Data of any kind: choice of the reader for a file or folder, and its result.
//!
//! The first bytes decide, in this order, so that the most specific format wins:
//!
//! | sign | kind |
//! |---|---|
//! | a layout is given | raw: terrain where it is one slice thick, else a volume |
//! | a folder | Gaussians (SOG), or a volume: OME-Zarr, DICOM, slices |
//! | `.toml`, `.json` with `frame` | frames of depth cameras |
//! | recognised by [`is_gaussians`] | Gaussians |
//! | polygonal data of VTK | points: surfels |
//! | recognised by [`is_mesh`] | a mesh |
//! | USGS DEM; a georeferenced TIFF; a table of very many columns | terrain |
//! | recognised by [`read_volume`], by its first bytes or its extension | a volume |
//! | anything else that is text, PLY, LAS or PCD | points |
//!
//! Only the starts of files are read to decide.

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use glam::DVec3;
use splatvol_scene::{Gaussians, Mesh, Points, Volume};

use crate::points::{self, height_field};
use crate::{
    DepthImageOptions, Description, GaussiansDescription, HeightFieldOptions, IoError, Loaded,
    LoadedGaussians, LoadedMesh, LoadedPoints, ReadOptions, is_gaussians, is_mesh, is_plot3d_pair,
    read_depth_images, read_gaussians, read_height_field, read_mesh, read_points, read_volume, volume,
};
use crate::{files, remote};

/// Data of any kind that can be read.
#[derive(Debug, Clone)]
pub enum Data {
    /// Samples on a regular grid.
    Volume(Volume),
    /// Samples of surfaces.
    Points(Points),
    /// 3-D Gaussians.
    Gaussians(Gaussians),
    /// Samples on an irregular grid.
    Mesh(Mesh),
}

/// The reader for a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DataKind {
    /// [`read_volume`].
    Volume,
    /// [`read_points`].
    Points,
    /// [`read_height_field`]: points of a surface over a map.
    Terrain,
    /// [`read_depth_images`]: points of what cameras saw.
    DepthImages,
    /// [`read_gaussians`].
    Gaussians,
    /// [`read_mesh`].
    Mesh,
}

impl DataKind {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Volume,
        Self::Points,
        Self::Terrain,
        Self::DepthImages,
        Self::Gaussians,
        Self::Mesh,
    ];

    /// Its name: `volume`, `depth-images`...
    pub fn name(self) -> &'static str {
        match self {
            Self::Volume => "volume",
            Self::Points => "points",
            Self::Terrain => "terrain",
            Self::DepthImages => "depth-images",
            Self::Gaussians => "gaussians",
            Self::Mesh => "mesh",
        }
    }
}

impl Display for DataKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for DataKind {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|kind| kind.name() == text)
            .ok_or_else(|| format!("expected one of {}", Self::ALL.map(Self::name).join(", ")))
    }
}

/// Options for reading data of any kind.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DataOptions {
    /// Kind of the file; if absent, detected from its contents.
    pub kind: Option<DataKind>,
    /// Options for the reader; each reader uses those that apply to it.
    pub read: ReadOptions,
    /// Picture that is laid over terrain.
    pub drape: Option<PathBuf>,
    /// Posts to the east and to the north that heights of terrain are interpolated to.
    pub posts: Option<[usize; 2]>,
}

/// Data and where they came from.
#[derive(Debug, Clone)]
pub struct LoadedData {
    /// The data.
    pub data: Data,
    /// The reader that was used.
    pub kind: DataKind,
    /// Description of the file, including warnings.
    pub description: Description,
    /// Rendering modes that the Gaussians were trained for: `antialiased`, `mip`, `flat`, `linear`.
    pub tags: Vec<String>,
    /// Arrays of the file, any of which can be named as [`ReadOptions::array`].
    pub arrays: Vec<String>,
    /// Position of the scanner of points, world, if the file gives it.
    pub viewpoint: Option<DVec3>,
}

/// The reader for the file or folder at `path`.
///
/// # Errors
/// [`IoError::Open`] where it cannot be read, [`IoError::Unsupported`] where nothing reads it.
pub fn data_kind(path: impl AsRef<Path>, options: &DataOptions) -> Result<DataKind, IoError> {
    let path = path.as_ref();
    if let Some(kind) = options.kind {
        return Ok(kind);
    }
    if let Some(raw) = &options.read.raw {
        let is_flat = raw.dims[2] == 1;
        return Ok(if is_flat {
            DataKind::Terrain
        } else {
            DataKind::Volume
        });
    }
    if remote::address(path).is_some() {
        return Ok(DataKind::Volume);
    }
    if !files::exists(path) {
        volume::known(path)?;
    }
    if is_gaussians(path) {
        return Ok(DataKind::Gaussians);
    }
    if files::is_dir(path) {
        return volume::known(path).map(|()| DataKind::Volume);
    }
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    if extension == "toml" || extension == "json" {
        return Ok(DataKind::DepthImages);
    }
    if points::is_poly_data(path)? {
        return Ok(DataKind::Points);
    }
    // A solution beside a file says what a file of text is that could be a table, too.
    let is_grid = |solution: &PathBuf| is_plot3d_pair(path, solution);
    if is_mesh(path)? || options.read.solution.as_ref().is_some_and(is_grid) {
        return Ok(DataKind::Mesh);
    }
    let volume = volume::known(path);
    // The numbers of a text volume may stand at the columns where a DEM has its own.
    if height_field::is_terrain(path, volume.is_ok())? {
        return Ok(DataKind::Terrain);
    }
    match volume {
        Err(IoError::Unsupported { .. }) if points::is_known(path)? => Ok(DataKind::Points),
        known => known.map(|()| DataKind::Volume),
    }
}

/// Reads a file or folder of any supported format with the reader given by [`data_kind`].
///
/// # Errors
/// See [`IoError`]; with [`ReadOptions::strict`] also where a warning would be given.
pub fn read_data(path: impl AsRef<Path>, options: &DataOptions) -> Result<LoadedData, IoError> {
    let path = path.as_ref();
    let kind = data_kind(path, options)?;
    let read = &options.read;
    Ok(match kind {
        DataKind::Volume => read_volume(path, read)?.into(),
        DataKind::Gaussians => read_gaussians(path, read)?.into(),
        DataKind::Mesh => read_mesh(path, read)?.into(),
        DataKind::Points => LoadedData::of_points(read_points(path, read)?, kind),
        DataKind::Terrain => {
            let terrain = HeightFieldOptions {
                raw: read.raw.clone(),
                spacing: read.raw.as_ref().map(|raw| raw.spacing.truncate().to_array()),
                color_image: options.drape.clone(),
                posts: options.posts,
                strict: read.strict,
                max_bytes: read.max_bytes,
                ..HeightFieldOptions::default()
            };
            LoadedData::of_points(read_height_field(path, &terrain)?, kind)
        }
        DataKind::DepthImages => {
            let frames = DepthImageOptions {
                strict: read.strict,
                allow_outside: read.allow_outside,
                max_bytes: read.max_bytes,
                ..DepthImageOptions::default()
            };
            LoadedData::of_points(read_depth_images(path, &frames)?, kind)
        }
    })
}

impl LoadedData {
    fn of_points(loaded: LoadedPoints, kind: DataKind) -> Self {
        Self {
            data: Data::Points(loaded.points),
            kind,
            description: loaded.description,
            tags: Vec::new(),
            arrays: Vec::new(),
            viewpoint: loaded.viewpoint,
        }
    }
}

impl From<Loaded> for LoadedData {
    fn from(loaded: Loaded) -> Self {
        Self {
            data: Data::Volume(loaded.volume),
            kind: DataKind::Volume,
            description: loaded.description,
            tags: Vec::new(),
            arrays: Vec::new(),
            viewpoint: None,
        }
    }
}

impl From<LoadedMesh> for LoadedData {
    fn from(loaded: LoadedMesh) -> Self {
        Self {
            data: Data::Mesh(loaded.mesh),
            kind: DataKind::Mesh,
            description: loaded.description,
            tags: Vec::new(),
            arrays: loaded.arrays,
            viewpoint: None,
        }
    }
}

impl From<LoadedGaussians> for LoadedData {
    fn from(loaded: LoadedGaussians) -> Self {
        let GaussiansDescription {
            format,
            stored_type,
            orientation,
            tags,
            files,
            warnings,
            ..
        } = loaded.description;
        Self {
            data: Data::Gaussians(loaded.gaussians),
            kind: DataKind::Gaussians,
            description: Description {
                format,
                stored_type,
                orientation,
                files,
                warnings,
                ..Description::default()
            },
            tags,
            arrays: Vec::new(),
            viewpoint: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kind_of(name: &str, contents: &[u8]) -> Result<DataKind, IoError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, contents).unwrap();
        data_kind(&path, &DataOptions::default())
    }

    #[test]
    fn contents_say_what_a_file_is() {
        let header =
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
        let trained: String = [
            "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
        ]
        .into_iter()
        .chain(["rot_0", "rot_1", "rot_2", "rot_3"])
        .map(|name| format!("property float {name}\n"))
        .collect();
        let heights = [["1.5"; 32].join(","), ["2"; 32].join(",")].join("\n");
        for (name, contents, kind) in [
            ("a.ply", format!("{header}end_header\n0 0 0\n"), DataKind::Points),
            (
                "b.ply",
                format!("{header}{trained}end_header\n"),
                DataKind::Gaussians,
            ),
            ("c.txt", "0 0 0\n1 1 1\n".to_owned(), DataKind::Points),
            ("d.csv", heights, DataKind::Terrain),
            ("e", "NRRD0004\n".to_owned(), DataKind::Volume),
            ("f.bin", "\u{1}\u{2}".to_owned(), DataKind::Volume),
            ("g.toml", "[[frame]]\n".to_owned(), DataKind::DepthImages),
            (
                "i.vtk",
                "# vtk DataFile Version 3.0\na\nASCII\nDATASET RECTILINEAR_GRID\n".to_owned(),
                DataKind::Mesh,
            ),
            ("h.splat", "0".repeat(32), DataKind::Gaussians),
        ] {
            assert_eq!(kind_of(name, contents.as_bytes()).unwrap(), kind, "{name}");
        }
        assert!(kind_of("j.dat", &[0, 1, 2, 255]).is_err());
    }

    #[test]
    fn what_is_asked_for_comes_first() {
        let layout = |depth| DataOptions {
            read: ReadOptions {
                raw: Some(crate::RawLayout {
                    dims: [2, 2, depth],
                    sample_type: crate::SampleType::U8,
                    spacing: DVec3::ONE,
                    endian: crate::Endian::Little,
                    offset: 0,
                }),
                ..ReadOptions::default()
            },
            ..DataOptions::default()
        };
        assert_eq!(data_kind("no.raw", &layout(2)).unwrap(), DataKind::Volume);
        assert_eq!(data_kind("no.raw", &layout(1)).unwrap(), DataKind::Terrain);
        let asked = DataOptions {
            kind: Some(DataKind::Points),
            ..DataOptions::default()
        };
        assert_eq!(data_kind("no.csv", &asked).unwrap(), DataKind::Points);
        let error = data_kind("no/such.nrrd", &DataOptions::default()).unwrap_err();
        assert!(matches!(error, IoError::Open { .. }), "{error}");
        assert_eq!("terrain".parse(), Ok(DataKind::Terrain));
        assert!("clouds".parse::<DataKind>().unwrap_err().contains("depth-images"));
    }
}
