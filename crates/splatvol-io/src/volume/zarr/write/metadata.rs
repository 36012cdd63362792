//! Metadata of arrays and groups, Zarr 2 and 3, and OME's of the image.

use std::path::Path;

use glam::{DAffine3, DMat3};
use serde_json::{Map, Value, json};
use splatvol_scene::{ElementType, LengthUnit, LevelLayout};

use super::files;
use super::plan::{LevelPlan, Plan};
use super::{Compression, OmeVersion, PyramidOptions};
use crate::IoError;
use crate::volume::zarr::blosc::BLOCK;
use crate::volume::zarr::geometry::finest_from_level;
use crate::volume::zarr::ome::LABELS;
use crate::volume::zarr::own::Own;

/// An array of any number of axes, the slowest first.
pub(super) struct ArrayMetadata<'a> {
    pub(super) shape: &'a [usize],
    pub(super) chunk: &'a [usize],
    /// Chunks of a shard; without them, a file holds one chunk.
    pub(super) shard: Option<&'a [usize]>,
    pub(super) element: ElementType,
    pub(super) names: &'a [&'a str],
    pub(super) attributes: Value,
}

impl ArrayMetadata<'_> {
    /// Writes the metadata into the folder of the array.
    pub(super) fn write(&self, folder: &Path, options: &PyramidOptions) -> Result<(), IoError> {
        match options.version {
            OmeVersion::V05 => json_file(&folder.join("zarr.json"), &self.version_3(options.compression)),
            OmeVersion::V04 => {
                json_file(&folder.join(".zattrs"), &self.attributes)?;
                json_file(&folder.join(".zarray"), &self.version_2(options.compression))
            }
        }
    }

    fn version_3(&self, compression: Compression) -> Value {
        let size = self.element.size();
        let bytes = match size {
            1 => json!({ "name": "bytes" }),
            _ => json!({ "name": "bytes", "configuration": { "endian": "little" } }),
        };
        let sum = json!({ "name": "crc32c" });
        let mut codecs = vec![bytes];
        if let Some(name) = compression.blosc_name() {
            codecs.push(
                json!({ "name": "blosc", "configuration": { "typesize": size, "cname": name, "clevel": 5,
                "shuffle": "bitshuffle", "blocksize": BLOCK } }),
            );
        }
        codecs.push(sum.clone());
        let (grid, codecs) = match self.shard {
            None => (self.chunk.to_vec(), codecs),
            Some(shard) => {
                let index = json!([{ "name": "bytes", "configuration": { "endian": "little" } }, sum]);
                let sharding = json!({ "name": "sharding_indexed", "configuration": { "chunk_shape": self.chunk,
                    "codecs": codecs, "index_codecs": index, "index_location": "end" } });
                let grid = self.chunk.iter().zip(shard).map(|(edge, count)| edge * count);
                (grid.collect(), vec![sharding])
            }
        };
        json!({ "zarr_format": 3, "node_type": "array", "shape": self.shape, "data_type": self.data_type(),
            "chunk_grid": { "name": "regular", "configuration": { "chunk_shape": grid } },
            "chunk_key_encoding": { "name": "default", "configuration": { "separator": "/" } },
            "fill_value": self.fill(), "codecs": codecs, "dimension_names": self.names, "attributes": self.attributes })
    }

    fn version_2(&self, compression: Compression) -> Value {
        let compressor = compression.blosc_name().map(
            |name| json!({ "id": "blosc", "cname": name, "clevel": 5, "shuffle": 2, "blocksize": BLOCK }),
        );
        let kind = match self.element {
            ElementType::U8 | ElementType::U16 | ElementType::U32 => 'u',
            ElementType::I8 | ElementType::I16 | ElementType::I32 => 'i',
            ElementType::F32 | ElementType::F64 => 'f',
        };
        let order = if self.element.size() == 1 { '|' } else { '<' };
        let dtype = format!("{order}{kind}{}", self.element.size());
        json!({ "zarr_format": 2, "shape": self.shape, "chunks": self.chunk, "dtype": dtype, "compressor": compressor,
            "fill_value": self.fill(), "order": "C", "filters": null, "dimension_separator": "/" })
    }

    fn data_type(&self) -> &'static str {
        match self.element {
            ElementType::U8 => "uint8",
            ElementType::I8 => "int8",
            ElementType::U16 => "uint16",
            ElementType::I16 => "int16",
            ElementType::U32 => "uint32",
            ElementType::I32 => "int32",
            ElementType::F32 => "float32",
            ElementType::F64 => "float64",
        }
    }

    fn fill(&self) -> Value {
        if self.element.is_float() {
            json!(0.0)
        } else {
            json!(0)
        }
    }
}

/// The array of a level.
pub(super) fn level_array<'a>(
    [shape, chunk, shard]: &'a [[usize; 3]; 3],
    element: ElementType,
    options: &PyramidOptions,
) -> ArrayMetadata<'a> {
    ArrayMetadata {
        shape,
        chunk,
        shard: (options.version == OmeVersion::V05).then_some(shard),
        element,
        names: &["z", "y", "x"],
        attributes: crate::volume::zarr::own::complete(),
    }
}

/// Shape, chunk and chunks of a shard, the slowest axis first.
pub(super) fn slowest_first(level: &LevelPlan) -> [[usize; 3]; 3] {
    [level.dims, level.chunk, level.shard].map(|[x, y, z]| [z, y, x])
}

/// A group with these attributes.
pub(super) fn write_group(
    folder: &Path,
    attributes: Map<String, Value>,
    version: OmeVersion,
) -> Result<(), IoError> {
    match version {
        OmeVersion::V05 => {
            let group = json!({ "zarr_format": 3, "node_type": "group", "attributes": attributes });
            json_file(&folder.join("zarr.json"), &group)
        }
        OmeVersion::V04 => {
            if !attributes.is_empty() {
                json_file(&folder.join(".zattrs"), &attributes.into())?;
            }
            json_file(&folder.join(".zgroup"), &json!({ "zarr_format": 2 }))
        }
    }
}

fn json_file(path: &Path, value: &Value) -> Result<(), IoError> {
    files::write(path, format!("{value:#}\n").as_bytes())
}

/// Attributes of the image.
pub(super) fn image(
    finest: &LevelLayout,
    (unit, oriented): (LengthUnit, bool),
    plan: &Plan,
    options: &PyramidOptions,
) -> Map<String, Value> {
    let version = options.version;
    let axis = |name: &str| {
        let mut axis = json!({ "name": name, "type": "space" });
        if let Some(unit) = unit_name(unit) {
            axis["unit"] = json!(unit);
        }
        axis
    };
    let map = finest.grid.world_from_voxel();
    let spacing = finest.grid.spacing();
    let datasets: Vec<Value> = plan
        .levels
        .iter()
        .enumerate()
        .map(|(number, level)| {
            let own = DAffine3::from_mat3_translation(DMat3::from_diagonal(spacing), map.translation);
            let own = own * finest_from_level(plan.levels[0].dims, level.dims);
            let [x, y, z] = [own.matrix3.x_axis.x, own.matrix3.y_axis.y, own.matrix3.z_axis.z];
            let at = own.translation;
            json!({ "path": number.to_string(), "coordinateTransformations": [
            { "type": "scale", "scale": [z, y, x] },
            { "type": "translation", "translation": [at.z, at.y, at.x] }
        ] })
        })
        .collect();
    let kind = if options.labels { "mode" } else { "mean" };
    let mut scales = json!({ "axes": [axis("z"), axis("y"), axis("x")], "datasets": datasets, "type": kind });
    let mut attributes = Map::new();
    match version {
        OmeVersion::V05 => {
            let mut image = json!({ "version": "0.5", "multiscales": [scales] });
            if options.labels {
                image[LABELS] = json!({ "version": "0.5" });
            }
            attributes.insert("ome".to_owned(), image);
        }
        OmeVersion::V04 => {
            scales["version"] = json!("0.4");
            attributes.insert("multiscales".to_owned(), json!([scales]));
            if options.labels {
                attributes.insert(LABELS.to_owned(), json!({ "version": "0.4" }));
            }
        }
    }
    let own = Own {
        rescale: finest.rescale,
        world_from_voxel: (!is_plain(map)).then_some(map),
        oriented,
    };
    own.add_to(&mut attributes);
    attributes
}

/// True for a scale and a translation.
pub(super) fn is_plain(map: DAffine3) -> bool {
    let scale = map.matrix3.transpose();
    let diagonal = [scale.x_axis.x, scale.y_axis.y, scale.z_axis.z];
    diagonal.iter().all(|&step| step > 0.0) && map.matrix3 == DMat3::from_diagonal(diagonal.into())
}

fn unit_name(unit: LengthUnit) -> Option<&'static str> {
    match unit {
        LengthUnit::Unknown => None,
        LengthUnit::Metre => Some("meter"),
        LengthUnit::Millimetre => Some("millimeter"),
        LengthUnit::Micrometre => Some("micrometer"),
        LengthUnit::Nanometre => Some("nanometer"),
    }
}
