//! Flags about reading a volume.

use std::path::PathBuf;

use clap::Args;
use splatvol_document::ReadRules;
use splatvol_io::{Endian, SampleType};

use super::help::{HEADERLESS, INPUT};
use super::values::{self, Dims, Triple};

/// How to read a volume.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct InputArgs {
    /// Number of samples along x, y and z
    #[arg(long, value_name = "XxYxZ", value_parser = values::dims, help_heading = HEADERLESS, requires = "sample_type")]
    pub(crate) dims: Option<Dims>,
    /// Type of a sample: u8, i8, u16, i16, u32, i32, u64, i64, f32 or f64
    #[arg(long = "type", value_name = "TYPE", value_parser = values::sample_type, help_heading = HEADERLESS,
          requires = "dims", id = "sample_type")]
    pub(crate) sample_type: Option<SampleType>,
    /// Distance of samples along x, y and z, in world lengths [default: 1,1,1]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::triple, help_heading = HEADERLESS, requires = "dims")]
    pub(crate) spacing: Option<Triple>,
    /// Byte order: little or big [default: little]
    #[arg(long, value_name = "ORDER", value_parser = values::endian, help_heading = HEADERLESS, requires = "dims")]
    pub(crate) endian: Option<Endian>,
    /// Number of bytes before the first sample [default: 0]
    #[arg(long, value_name = "BYTES", help_heading = HEADERLESS, requires = "dims")]
    pub(crate) offset: Option<u64>,
    /// Name of the array, where a file holds several
    #[arg(long, value_name = "NAME", help_heading = INPUT)]
    pub(crate) array: Option<String>,
    /// Component to read of samples that are vectors, from 0
    #[arg(long, value_name = "N", help_heading = INPUT)]
    pub(crate) component: Option<usize>,
    /// Time point of a series, from 0
    #[arg(long, value_name = "N", help_heading = INPUT)]
    pub(crate) time: Option<usize>,
    /// Channel of a multi-channel image, from 0
    #[arg(long, value_name = "N", help_heading = INPUT)]
    pub(crate) channel: Option<usize>,
    /// Level of detail of a multi-scale image; 0 is the finest
    #[arg(long, value_name = "N", help_heading = INPUT)]
    pub(crate) level: Option<usize>,
    /// Series to read of a folder of several: its number, UID or description
    #[arg(long, value_name = "SERIES", help_heading = INPUT)]
    pub(crate) series: Option<String>,
    /// Solution that belongs to a PLOT3D grid, where no file beside it has a matching name
    #[arg(long, value_name = "FILE", help_heading = INPUT)]
    pub(crate) solution: Option<PathBuf>,
    /// Refuse files that break the rules of their format in any way
    #[arg(long, help_heading = INPUT)]
    pub(crate) strict: bool,
    /// Follow links that lead out of the folder of the input, and read files elsewhere that an earlier picture names
    #[arg(long, help_heading = INPUT)]
    pub(crate) allow_outside: bool,
    /// Most memory for the samples of an input: bytes, or 500M, 8G [default: half of the machine's]
    #[arg(long, value_name = "BYTES", value_parser = values::bytes, help_heading = INPUT)]
    pub(crate) max_memory: Option<u64>,
}

impl InputArgs {
    /// What is refused when files are read.
    pub(crate) fn rules(&self) -> ReadRules {
        ReadRules {
            strict: self.strict,
            allow_outside: self.allow_outside,
            max_bytes: self.max_memory,
            chunks: None,
        }
    }
}
