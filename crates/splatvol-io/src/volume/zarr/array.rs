//! Metadata of one array, Zarr 2 (`.zarray`) or 3 (`zarr.json`)
//! (<https://zarr-specs.readthedocs.io/en/latest/v2/v2.0.html>,
//! <https://zarr-specs.readthedocs.io/en/latest/v3/core/>).

use serde_json::Value;
use splatvol_scene::volume::widen;
use splatvol_scene::{ElementType, Grid, with_samples};

use super::codec::Codec;
use super::fill::FillValue;
use super::folder::Folder;
use super::own;
use crate::error::Context;
use crate::samples::{Endian, widen_samples};
use crate::{IoError, SampleType};

/// Axes that an array may have.
const MAX_AXES: usize = 8;

/// An array: its samples, and how its chunks lie in files.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Array {
    pub(super) folder: Folder,
    pub(super) version: u32,
    pub(super) shape: Vec<usize>,
    /// Shape of the chunks; with shards, of those inside.
    pub(super) chunks: Vec<usize>,
    pub(super) sample_type: SampleType,
    /// True for floats of 16 bits, which are `u16` until they are converted.
    pub(super) half: bool,
    pub(super) endian: Endian,
    /// Axes of a chunk from the slowest to the fastest.
    pub(super) order: Vec<usize>,
    pub(super) codecs: Vec<Codec>,
    pub(super) shard: Option<Shard>,
    /// Bytes of a sample that no chunk holds, in the order of the file.
    pub(super) fill: Vec<u8>,
    /// True where its writer said that no chunk is left out.
    pub(super) complete: bool,
    /// Before the numbers of a chunk's file: "c" or nothing; and between them.
    prefix: &'static str,
    separator: char,
}

/// Files that hold several chunks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Shard {
    pub(super) shape: Vec<usize>,
    /// True where the index ends in a checksum.
    pub(super) checksum: bool,
    pub(super) index_first: bool,
}

impl Shard {
    /// Chunks along each axis of a shard.
    pub(super) fn chunks_along(&self, chunks: &[usize]) -> Vec<usize> {
        let sizes = self.shape.iter().zip(chunks);
        sizes.map(|(outer, inner)| outer / inner).collect()
    }
}

impl Array {
    /// The array in a folder, `None` if there is none.
    pub(super) fn open(folder: &Folder) -> Result<Option<Self>, IoError> {
        let old = folder.path().join(".zarray");
        if let Some(value) = folder.json(".zarray")? {
            let context = &Context::new("Zarr 2 array", &old);
            return Fields {
                value: &value,
                context,
            }
            .version_2(folder)
            .map(Some);
        }
        let new = folder.path().join("zarr.json");
        match folder.json("zarr.json")? {
            Some(value) if value.get("node_type").and_then(Value::as_str) == Some("array") => {
                let context = &Context::new("Zarr 3 array", &new);
                Fields {
                    value: &value,
                    context,
                }
                .version_3(folder)
                .map(Some)
            }
            _ => Ok(None),
        }
    }

    pub(super) fn samples_of_chunk(&self) -> usize {
        self.chunks.iter().product()
    }

    /// The key of a chunk, or of a shard: its file below the folder.
    pub(super) fn key(&self, numbers: &[usize]) -> String {
        let mut parts: Vec<String> = Vec::new();
        if !self.prefix.is_empty() {
            parts.push(self.prefix.to_owned());
        }
        parts.extend(numbers.iter().map(usize::to_string));
        if parts.is_empty() {
            parts.push("0".to_owned());
        }
        parts.join(&self.separator.to_string())
    }

    /// The type of its samples in memory.
    pub(super) fn element(&self) -> ElementType {
        match self.half {
            true => ElementType::F32,
            false => self.sample_type.element(),
        }
    }

    /// The value of a sample that no chunk holds.
    pub(super) fn fill_value(&self) -> f64 {
        let mut samples = self.element().filled(1, 0.0);
        widen_samples(&self.fill, self.sample_type, self.endian, &mut samples);
        with_samples!(&samples, data => widen(data[0]))
    }

    pub(super) fn stored_type(&self) -> String {
        let order = match self.endian {
            _ if self.sample_type.size() == 1 => "",
            Endian::Little => ", little-endian",
            Endian::Big => ", big-endian",
        };
        let name = if self.half { "f16" } else { self.sample_type.name() };
        let codecs: Vec<&str> = self.codecs.iter().map(|codec| codec.name()).collect();
        let codecs = if codecs.is_empty() {
            "raw".to_owned()
        } else {
            codecs.join(", ")
        };
        let sharded = if self.shard.is_some() { ", sharded" } else { "" };
        format!("{name}{order}, {codecs}{sharded}")
    }
}

struct Fields<'a> {
    value: &'a Value,
    context: &'a Context<'a>,
}

impl Fields<'_> {
    fn bad(&self, field: &str, value: Option<&Value>, expected: &str) -> IoError {
        let shown = value.map(Value::to_string).unwrap_or_default();
        self.context.field(field, shown, None, expected)
    }

    /// Sizes of axes; as many as `axes`, if that is known.
    fn sizes(&self, field: &str, value: Option<&Value>, axes: Option<usize>) -> Result<Vec<usize>, IoError> {
        let sizes: Option<Vec<usize>> = value.and_then(Value::as_array).and_then(|sizes| {
            let size = |size: &Value| usize::try_from(size.as_u64()?).ok();
            sizes.iter().map(size).collect()
        });
        let legal = |sizes: &Vec<usize>| {
            (1..=MAX_AXES).contains(&sizes.len())
                && axes.is_none_or(|axes| axes == sizes.len())
                && sizes.iter().all(|&size| (1..=1 << 32).contains(&(size as u64)))
        };
        let expected = format!(
            "{} positive sizes",
            axes.map_or("1 to 8".to_owned(), |axes| axes.to_string())
        );
        sizes
            .filter(legal)
            .ok_or_else(|| self.bad(field, value, &expected))
    }

    /// Sizes of a chunk, whose product is kept small.
    fn chunk(&self, field: &str, value: Option<&Value>, axes: usize) -> Result<Vec<usize>, IoError> {
        let sizes = self.sizes(field, value, Some(axes))?;
        let product = sizes
            .iter()
            .try_fold(1usize, |product, &size| product.checked_mul(size));
        let most = (Grid::MAX_DIM as u64 + 1).pow(2);
        match product.is_some_and(|product| product as u64 <= most) {
            true => Ok(sizes),
            false => Err(self.bad(field, value, "chunks of at most 2^32 samples")),
        }
    }

    fn version_2(&self, folder: &Folder) -> Result<Array, IoError> {
        let shape = self.sizes("shape", self.value.get("shape"), None)?;
        let chunks = self.chunk("chunks", self.value.get("chunks"), shape.len())?;
        let dtype = self.value.get("dtype");
        let text = dtype.and_then(Value::as_str).unwrap_or_default();
        let (sample_type, half) = match text.trim_start_matches(['<', '>', '|']) {
            "f2" => (Some(SampleType::U16), true),
            "b1" => (Some(SampleType::U8), false),
            "f4" => (Some(SampleType::F32), false),
            "f8" => (Some(SampleType::F64), false),
            // Numbers are bytes here, not bits.
            "u1" => (Some(SampleType::U8), false),
            "i1" => (Some(SampleType::I8), false),
            "u2" => (Some(SampleType::U16), false),
            "i2" => (Some(SampleType::I16), false),
            "u4" => (Some(SampleType::U32), false),
            "i4" => (Some(SampleType::I32), false),
            "u8" => (Some(SampleType::U64), false),
            "i8" => (Some(SampleType::I64), false),
            _ => (None, false),
        };
        let sample_type = sample_type.ok_or_else(|| self.bad("dtype", dtype, "a real number type"))?;
        let endian = if text.starts_with('>') {
            Endian::Big
        } else {
            Endian::Little
        };
        let filters = self.value.get("filters").and_then(Value::as_array);
        if filters.is_some_and(|filters| !filters.is_empty()) {
            return Err(self.bad("filters", self.value.get("filters"), "no filters"));
        }
        let compressor = self.value.get("compressor").filter(|value| !value.is_null());
        let codecs = match compressor {
            None => Vec::new(),
            Some(value) => {
                let expected = "blosc, gzip, zlib, zstd or lz4";
                vec![
                    Codec::from_compressor(value)
                        .ok_or_else(|| self.bad("compressor", compressor, expected))?,
                ]
            }
        };
        let axes = 0..shape.len();
        let order = match self.value.get("order").and_then(Value::as_str) {
            Some("F") => axes.rev().collect(),
            _ => axes.collect(),
        };
        let slashes = self.value.get("dimension_separator").and_then(Value::as_str) == Some("/");
        Ok(Array {
            folder: folder.clone(),
            version: 2,
            shape,
            chunks,
            sample_type,
            half,
            endian,
            order,
            codecs,
            shard: None,
            fill: FillValue::new(self.value, self.context).bytes(sample_type, half, endian)?,
            complete: own::is_complete(folder.json(".zattrs")?.as_ref()),
            prefix: "",
            separator: if slashes { '/' } else { '.' },
        })
    }

    fn version_3(&self, folder: &Folder) -> Result<Array, IoError> {
        let shape = self.sizes("shape", self.value.get("shape"), None)?;
        let grid = self.value.pointer("/chunk_grid/configuration/chunk_shape");
        let outer = self.chunk("chunk_shape", grid, shape.len())?;
        let dtype = self.value.get("data_type");
        let (sample_type, half) = match dtype.and_then(Value::as_str).unwrap_or_default() {
            "float16" => (Some(SampleType::U16), true),
            "bool" => (Some(SampleType::U8), false),
            "float32" => (Some(SampleType::F32), false),
            "float64" => (Some(SampleType::F64), false),
            name => (SampleType::from_name(name), false),
        };
        let sample_type = sample_type.ok_or_else(|| self.bad("data_type", dtype, "a real number type"))?;
        let axes = shape.len();
        let plain = self
            .value
            .pointer("/chunk_key_encoding/name")
            .and_then(Value::as_str)
            == Some("v2");
        let separator = self
            .value
            .pointer("/chunk_key_encoding/configuration/separator")
            .and_then(Value::as_str)
            .unwrap_or(if plain { "." } else { "/" });
        let mut array = Array {
            folder: folder.clone(),
            version: 3,
            shape,
            chunks: outer.clone(),
            sample_type,
            half,
            endian: Endian::Little,
            order: (0..axes).collect(),
            codecs: Vec::new(),
            shard: None,
            fill: Vec::new(),
            complete: own::is_complete(self.value.get("attributes")),
            prefix: if plain { "" } else { "c" },
            separator: if separator == "." { '.' } else { '/' },
        };
        self.codecs(self.value.get("codecs"), &mut array)?;
        if let Some(shard) = &array.shard
            && shard
                .shape
                .iter()
                .zip(&array.chunks)
                .any(|(outer, inner)| outer % inner != 0)
        {
            return Err(self.bad("chunk_shape", grid, "a multiple of the chunks inside"));
        }
        array.fill = FillValue::new(self.value, self.context).bytes(sample_type, half, array.endian)?;
        Ok(array)
    }

    /// Interprets the list of codecs of version 3.
    fn codecs(&self, list: Option<&Value>, array: &mut Array) -> Result<(), IoError> {
        let codecs = list.and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
        for codec in codecs {
            // A codec without settings may be its name alone.
            let name = codec.get("name").unwrap_or(codec).as_str().unwrap_or_default();
            let setting = |key: &str| codec.get("configuration")?.get(key);
            match name {
                "bytes" => {
                    let big = setting("endian").and_then(Value::as_str) == Some("big");
                    array.endian = if big { Endian::Big } else { Endian::Little };
                }
                "transpose" => {
                    let axes = setting("order")
                        .and_then(Value::as_array)
                        .map_or(&[][..], Vec::as_slice);
                    let axes: Vec<usize> = axes
                        .iter()
                        .filter_map(|axis| Some(axis.as_u64()? as usize))
                        .collect();
                    let mut sorted = axes.clone();
                    sorted.sort_unstable();
                    if sorted != (0..array.shape.len()).collect::<Vec<_>>() {
                        return Err(self.bad("transpose", Some(codec), "an order of all axes"));
                    }
                    // Transpositions follow each other.
                    array.order = axes.iter().map(|&axis| array.order[axis]).collect();
                }
                "sharding_indexed" if array.shard.is_none() && array.order.is_sorted() => {
                    let inner = self.chunk("chunk_shape", setting("chunk_shape"), array.shape.len())?;
                    let index = setting("index_codecs").map(Value::to_string).unwrap_or_default();
                    array.shard = Some(Shard {
                        shape: std::mem::replace(&mut array.chunks, inner),
                        checksum: index.contains("crc32c"),
                        index_first: setting("index_location").and_then(Value::as_str) == Some("start"),
                    });
                    self.codecs(setting("codecs"), array)?;
                }
                name => {
                    let expected = "bytes, transpose, sharding_indexed, blosc, gzip, zstd or crc32c";
                    let codec =
                        Codec::from_name(name).ok_or_else(|| self.bad("codecs", Some(codec), expected))?;
                    array.codecs.push(codec);
                }
            }
        }
        Ok(())
    }
}
