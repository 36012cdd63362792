//! Flags about writing levels of detail.

use clap::{Args, ValueEnum};
use splatvol_io::{Compression, OmeVersion, PyramidOptions};

use super::help::OUTPUT;
use super::values;

/// Compression of chunks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum CompressionArg {
    /// Blosc: LZ4 of shuffled bits
    Lz4,
    /// Blosc: zlib of shuffled bits; smaller, much slower
    Zlib,
    /// None
    None,
}

/// Version of OME-Zarr.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum OmeVersionArg {
    /// Zarr 3, shards, checksums
    #[value(name = "0.5")]
    V05,
    /// Zarr 2, a file per chunk, no checksums
    #[value(name = "0.4")]
    V04,
}

/// How OME-Zarr is written.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct PyramidArgs {
    /// Most memory for the conversion to OME-Zarr: bytes, or 500M, 8G [default: half of the machine's]
    #[arg(long, value_name = "SIZE", value_parser = values::bytes, help_heading = OUTPUT)]
    pub(crate) memory: Option<u64>,
    /// Edge of OME-Zarr's chunks, samples, from 8 to 512 [default: 64]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(8..=512), help_heading = OUTPUT)]
    pub(crate) chunk: Option<u16>,
    /// Number of OME-Zarr's levels, the finest included [default: until the coarsest is one chunk]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=32), help_heading = OUTPUT)]
    pub(crate) levels: Option<u8>,
    /// Values are labels: the samples of OME-Zarr's levels are those that most of their box have; =false: means [default: decided
    /// by the data]
    ///
    /// The image says so (image-label), and is drawn as a label map from its levels, whatever its size. Labels are the values of
    /// images that say so already, and of what info calls a label volume; volumes that are read in chunks are judged by a few slabs.
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", help_heading = OUTPUT)]
    pub(crate) labels: Option<bool>,
    /// Compression of OME-Zarr [default: lz4]
    #[arg(long, value_name = "NAME", help_heading = OUTPUT)]
    pub(crate) compression: Option<CompressionArg>,
    /// Version of OME-Zarr [default: 0.5]
    #[arg(long, value_name = "VERSION", help_heading = OUTPUT)]
    pub(crate) ome_version: Option<OmeVersionArg>,
}

impl PyramidArgs {
    /// Options for the writer.
    pub(crate) fn options(&self, overwrite: bool) -> PyramidOptions {
        let default = PyramidOptions::default();
        PyramidOptions {
            version: match self.ome_version {
                Some(OmeVersionArg::V04) => OmeVersion::V04,
                Some(OmeVersionArg::V05) | None => OmeVersion::V05,
            },
            compression: match self.compression {
                Some(CompressionArg::None) => Compression::None,
                Some(CompressionArg::Zlib) => Compression::Zlib,
                Some(CompressionArg::Lz4) | None => Compression::Lz4,
            },
            chunk: self.chunk.map_or(default.chunk, usize::from),
            levels: self.levels.map(usize::from),
            labels: self.labels == Some(true),
            memory: self.memory.unwrap_or(default.memory),
            overwrite,
            ..default
        }
    }

    /// A flag that was given, by name.
    pub(crate) fn given(&self) -> Option<&'static str> {
        let flags = [
            (self.memory.is_some(), "--memory"),
            (self.chunk.is_some(), "--chunk"),
            (self.levels.is_some(), "--levels"),
            (self.labels.is_some(), "--labels"),
            (self.compression.is_some(), "--compression"),
            (self.ome_version.is_some(), "--ome-version"),
        ];
        flags.iter().find(|(given, _)| *given).map(|(_, name)| *name)
    }
}
