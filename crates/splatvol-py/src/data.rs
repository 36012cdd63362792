//! Data in memory: arrays of the program's, or what files hold.

use std::path::PathBuf;
use std::sync::Mutex;

use glam::{DAffine3, DMat3, DVec3};
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyDict};
use splatvol::gaussians::GaussianAttributes;
use splatvol::mesh::{Association, CellKind, Cells, MeshField, Topology};
use splatvol::points::PointAttributes;
use splatvol::{Gaussians, Grid, LengthUnit, Mesh, Points, Rescale, Volume, with_samples};
use splatvol_document::held::HeldContent;
use splatvol_document::keys::ItemKeys;
use splatvol_document::{Held, Listener, ReadRules, Reading};
use splatvol_io::{Description, WriteOptions, write_gaussians, write_volume};

use crate::array;
use crate::chunks::chunk_rules;
use crate::error::{Raise, refused};
use crate::work::{self, Stop};

/// Data of one item, whatever their kind.
#[pyclass(frozen)]
#[derive(Debug)]
pub(crate) struct Data {
    pub(crate) held: Held,
}

/// Collects warnings and choices.
#[derive(Debug, Default)]
pub(crate) struct Notes(Mutex<Vec<(bool, String)>>);

impl Notes {
    fn add(&self, warns: bool, message: &str) {
        if let Ok(mut notes) = self.0.lock() {
            notes.push((warns, message.to_owned()));
        }
    }

    /// Each with whether it is a warning.
    pub(crate) fn taken(self) -> Vec<(bool, String)> {
        self.0.into_inner().unwrap_or_default()
    }
}

impl Listener for Notes {
    fn warn(&self, message: &str) {
        self.add(true, message);
    }

    fn detail(&self, message: &str) {
        self.add(false, message);
    }
}

/// Rows of an affine map from the grid's or the local space to the world.
type AffineRows = [[f64; 4]; 3];

fn affine(rows: AffineRows) -> DAffine3 {
    let column = |n: usize| DVec3::from_array(rows.map(|row| row[n]));
    DAffine3 {
        matrix3: DMat3::from_cols(column(0), column(1), column(2)),
        translation: column(3),
    }
}

fn rows(map: DAffine3) -> AffineRows {
    let columns = [
        map.matrix3.x_axis,
        map.matrix3.y_axis,
        map.matrix3.z_axis,
        map.translation,
    ];
    std::array::from_fn(|row| columns.map(|column| column[row]))
}

fn unit(symbol: Option<&str>) -> PyResult<LengthUnit> {
    match symbol {
        None | Some("") => Ok(LengthUnit::Unknown),
        Some("m") => Ok(LengthUnit::Metre),
        Some("mm") => Ok(LengthUnit::Millimetre),
        Some("um" | "µm" | "μm") => Ok(LengthUnit::Micrometre),
        Some("nm") => Ok(LengthUnit::Nanometre),
        Some(other) => Err(refused(
            "unit",
            format!("unit: {other:?} is not allowed (m, mm, um or nm)"),
        )),
    }
}

/// What is known about data that are no file.
fn described(stored_type: &str) -> Description {
    Description {
        format: "array".to_owned(),
        stored_type: stored_type.to_owned(),
        orientation: "as the program that holds it says".to_owned(),
        ..Description::default()
    }
}

impl Data {
    fn new(data: splatvol_io::Data) -> Self {
        Self {
            held: Held::new(data, described("f32")),
        }
    }

    fn stored(&self) -> PyResult<&Volume> {
        match self.held.content() {
            HeldContent::Volume(volume) => Ok(volume),
            _ => Err(refused("data", "only volumes have samples on a grid")),
        }
    }
}

#[pymethods]
impl Data {
    /// Reads a file, or generates a sample, by the keys of an item as JSON; warnings and choices come with it. `rules` are `strict`,
    /// `allow_outside` and `max_memory`. With `lazy`, volumes that can be are read in chunks when they are drawn, within `memory`.
    #[staticmethod]
    #[pyo3(signature = (item, rules = (false, false, None), stop = None, progress = None, lazy = false, memory = None))]
    fn read(
        py: Python<'_>,
        item: &str,
        rules: (bool, bool, Option<u64>),
        stop: Option<&Stop>,
        progress: Option<Py<PyAny>>,
        lazy: bool,
        memory: Option<u64>,
    ) -> PyResult<(Self, Vec<(bool, String)>)> {
        let keys: ItemKeys = serde_json::from_str(item).map_err(Raise::raised)?;
        let (strict, allow_outside, max_bytes) = rules;
        let rules = ReadRules {
            strict,
            allow_outside,
            max_bytes,
            chunks: lazy.then(|| chunk_rules(memory)),
        };
        work::run(py, (stop, progress.as_ref()), |_| {
            let notes = Notes::default();
            let reading = Reading {
                rules,
                folder: None,
                listener: &notes,
            };
            let held = Held::read(&keys, reading).map_err(Raise::raised)?;
            Ok((Self { held }, notes.taken()))
        })
    }

    /// A volume of an OME-Zarr image, or a Zarr array, of whose keys `get` returns bytes when they are needed: `get(key, start, length)`,
    /// see the module `lazy`. `item` has the keys of an item as JSON, `memory` is the budget of its pictures.
    #[staticmethod]
    #[pyo3(signature = (name, get, item, memory = None, stop = None))]
    fn of_keys(
        py: Python<'_>,
        name: String,
        get: Py<PyAny>,
        item: &str,
        memory: Option<u64>,
        stop: Option<&Stop>,
    ) -> PyResult<Self> {
        Self::of_getter(py, (name, get), item, memory, stop)
    }

    /// A volume of the samples of an array in C order, x last, whose memory is shared. `affine` maps x, y, z of a sample's index to
    /// the world; `oriented` says that the world's z is up.
    #[staticmethod]
    #[pyo3(signature = (array, dtype, dims, affine, oriented, rescale, unit = None))]
    #[expect(clippy::too_many_arguments, reason = "Python's keywords")]
    fn volume(
        py: Python<'_>,
        array: &Bound<'_, PyAny>,
        dtype: &str,
        dims: [usize; 3],
        affine: AffineRows,
        oriented: bool,
        rescale: (f64, f64),
        unit: Option<&str>,
    ) -> PyResult<Self> {
        let grid = Grid::from_affine(dims, self::affine(affine)).map_err(Raise::raised)?;
        let samples = array::samples(array, dtype)?;
        let unit = self::unit(unit)?;
        let (slope, intercept) = rescale;
        let stored_type = samples.type_name();
        let volume = work::run(py, (None, None), |_| {
            Volume::new(grid, samples, Rescale { slope, intercept }, unit).map_err(Raise::raised)
        })?;
        let description = Description {
            oriented,
            ..described(stored_type)
        };
        Ok(Self {
            held: Held::new(splatvol_io::Data::Volume(volume), description),
        })
    }

    /// Points of surfaces: rows of float64 x y z, uint8 red green blue opacity, float32 normals, float32 radii. Triangles,
    /// rows of three uint32 indices, make the points corners of a surface.
    #[staticmethod]
    #[pyo3(signature = (positions, colors = None, normals = None, radii = None, triangles = None))]
    fn points(
        positions: &Bound<'_, PyAny>,
        colors: Option<&Bound<'_, PyAny>>,
        normals: Option<&Bound<'_, PyAny>>,
        radii: Option<&Bound<'_, PyAny>>,
        triangles: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let attributes = PointAttributes {
            colors: colors.map_or_else(|| Ok(Vec::new()), array::rows::<u8, 4>)?,
            normals: normals.map_or_else(|| Ok(Vec::new()), array::rows::<f32, 3>)?,
            radii: radii.map_or_else(|| Ok(Vec::new()), array::numbers::<f32>)?,
        };
        let (positions, world_from_local) = splatvol_io::around_local_origin(&array::rows(positions)?);
        let points = Points::new(positions, attributes, world_from_local);
        let mut points = points.map_err(Raise::raised)?;
        if let Some(triangles) = triangles {
            let corners = array::rows::<u32, 3>(triangles)?;
            points = splatvol_io::surfels_of_triangles(&points, corners).map_err(Raise::raised)?;
        }
        Ok(Self::new(splatvol_io::Data::Points(points)))
    }

    /// 3-D Gaussians: rows of float64 means, of float32 standard deviations, quaternions x y z w, opacities, and spherical harmonics, of each
    /// Gaussian `(degree + 1)^2` rows of red, green, blue.
    #[staticmethod]
    fn gaussians(
        means: &Bound<'_, PyAny>,
        scales: &Bound<'_, PyAny>,
        rotations: &Bound<'_, PyAny>,
        opacities: &Bound<'_, PyAny>,
        harmonics: (u32, Bound<'_, PyAny>),
    ) -> PyResult<Self> {
        let (degree, coefficients) = harmonics;
        let (local, world_from_local) = splatvol_io::around_local_origin(&array::rows(means)?);
        let attributes = GaussianAttributes {
            means: local,
            scales: array::rows(scales)?,
            rotations: array::rows(rotations)?,
            opacities: array::numbers(opacities)?,
            harmonics: array::rows(&coefficients)?,
        };
        let gaussians = Gaussians::new(attributes, degree, world_from_local);
        Ok(Self::new(splatvol_io::Data::Gaussians(
            gaussians.map_err(Raise::raised)?,
        )))
    }

    /// A mesh: rows of float64 x y z; cells by VTK's types (uint8), offsets (one more than cells) and points (uint32); float32
    /// values of points, or of cells.
    #[staticmethod]
    fn mesh(
        positions: &Bound<'_, PyAny>,
        cells: (Bound<'_, PyAny>, Bound<'_, PyAny>, Bound<'_, PyAny>),
        values: &Bound<'_, PyAny>,
        name: String,
        of_cells: bool,
    ) -> PyResult<Self> {
        let (types, offsets, connectivity) = cells;
        let cells = listed(
            &array::numbers(&types)?,
            &array::numbers(&offsets)?,
            &array::numbers(&connectivity)?,
        )?;
        let association = match of_cells {
            true => Association::Cell,
            false => Association::Point,
        };
        let field = MeshField {
            name,
            association,
            values: array::numbers(values)?,
        };
        let topology = Topology::Unstructured(cells);
        let (positions, world_from_local) = splatvol_io::around_local_origin(&array::rows(positions)?);
        let mesh = Mesh::new(positions, topology, Vec::new(), field, world_from_local);
        Ok(Self::new(splatvol_io::Data::Mesh(mesh.map_err(Raise::raised)?)))
    }

    /// Kind of the data: volume, points, terrain, depth-images, gaussians or mesh.
    #[getter]
    fn kind(&self) -> &'static str {
        self.held.kind().name()
    }

    /// Whether chunks are read when a picture needs them: not all samples are in memory.
    #[getter]
    fn in_chunks(&self) -> bool {
        matches!(self.held.content(), HeldContent::Volume(volume) if volume.chunks().is_some())
    }

    /// What is known about the data, as a dictionary.
    fn describe<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        let description = self.held.description();
        all.set_item("kind", self.kind())?;
        all.set_item("format", &description.format)?;
        all.set_item("stored_type", &description.stored_type)?;
        all.set_item("orientation", &description.orientation)?;
        all.set_item("is_oriented", description.oriented)?;
        all.set_item("files", &description.files)?;
        all.set_item("channels", &description.channels)?;
        all.set_item("times", description.times)?;
        all.set_item("levels", &description.levels)?;
        all.set_item("series", &description.series)?;
        all.set_item("warnings", &description.warnings)?;
        match self.held.content() {
            HeldContent::Volume(volume) => {
                let Rescale { slope, intercept } = volume.rescale();
                let statistics = volume.statistics();
                all.set_item("dims", volume.grid().dims())?;
                all.set_item("dtype", volume.samples().type_name())?;
                all.set_item("affine", rows(volume.grid().world_from_voxel()))?;
                all.set_item("spacing", volume.grid().spacing().to_array())?;
                all.set_item("rescale", (slope, intercept))?;
                all.set_item("unit", volume.unit().symbol())?;
                all.set_item("range", volume.value_range())?;
                all.set_item("mean", statistics.mean)?;
                all.set_item("missing", statistics.non_finite)?;
                all.set_item(
                    "nbytes",
                    volume.samples().len() * volume.samples().bytes_per_sample(),
                )?;
            }
            HeldContent::Mesh(mesh) => {
                all.set_item("count", mesh.cell_count())?;
                all.set_item("points", mesh.positions().len())?;
                all.set_item("array", &mesh.field().name)?;
                all.set_item("range", mesh.value_range())?;
            }
            HeldContent::Points(points) => {
                all.set_item("count", points.positions().len())?;
                all.set_item("has_colors", !points.attributes().colors.is_empty())?;
                all.set_item("has_normals", !points.attributes().normals.is_empty())?;
                all.set_item("has_radii", !points.attributes().radii.is_empty())?;
            }
            HeldContent::Gaussians(gaussians) => {
                all.set_item("count", gaussians.attributes().means.len())?;
                all.set_item("degree", gaussians.degree())?;
            }
        }
        Ok(all)
    }

    /// The samples of a volume as they are stored, x fastest, copied.
    fn sample_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyByteArray>> {
        let volume = self.stored()?;
        let bytes = with_samples!(volume.samples(), samples => {
            let size = size_of_val(samples);
            PyByteArray::new_with(py, size, |bytes| {
                let width = size.checked_div(samples.len()).unwrap_or(1).max(1);
                for (to, sample) in bytes.chunks_exact_mut(width).zip(samples) {
                    to.copy_from_slice(&sample.to_ne_bytes());
                }
                Ok(())
            })?
        });
        Ok(bytes)
    }

    /// Writes a volume, `.nrrd` or `.npy`, or Gaussians, `.ply`, `.splat` and so on, as they are stored.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        work::run(py, (None, None), |_| match self.held.content() {
            HeldContent::Volume(volume) => {
                write_volume(&path, volume, &WriteOptions::default()).map_err(Raise::raised)
            }
            HeldContent::Gaussians(gaussians) => write_gaussians(&path, gaussians).map_err(Raise::raised),
            _ => Err(refused(
                "data",
                "volumes and Gaussians are written; points and meshes are only read",
            )),
        })
    }

    /// Counts of a volume's values in equal bins over their range.
    fn histogram(&self, py: Python<'_>, bins: usize) -> PyResult<Vec<u64>> {
        let volume = self.stored()?;
        work::run(py, (None, None), |_| Ok(volume.histogram(bins)))
    }

    fn __repr__(&self) -> String {
        format!("<{} of {}>", self.kind(), self.held.description().format)
    }
}

/// Cells as VTK lists them.
fn listed(types: &[u8], offsets: &[u32], connectivity: &[u32]) -> PyResult<Cells> {
    if offsets.len() != types.len() + 1 {
        return Err(refused("cells", "offsets must be one more than types"));
    }
    let mut cells = Cells::default();
    for (index, (&code, ends)) in types.iter().zip(offsets.windows(2)).enumerate() {
        let kind = CellKind::from_vtk(code).ok_or_else(|| {
            refused(
                "cells",
                format!("cell {index} is of VTK's type {code}, which is not solid"),
            )
        })?;
        let points = connectivity.get(ends[0] as usize..ends[1] as usize);
        let points =
            points.ok_or_else(|| refused("cells", format!("cell {index} lies outside the connectivity")))?;
        cells.push(kind, points).map_err(Raise::raised)?;
    }
    Ok(cells)
}
