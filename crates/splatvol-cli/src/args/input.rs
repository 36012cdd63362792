//! Flags about reading a volume.

use clap::Args;
use splatvol_io::{Endian, SampleType};

use super::values::{self, Dims, Triple};

const RAW: &str = "Raw input (files without a header)";
pub(super) const READING: &str = "Reading";

/// How to read a volume.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct InputArgs {
    /// Samples along x, y, z of a headerless file
    #[arg(long, value_name = "XxYxZ", value_parser = values::dims, help_heading = RAW, requires = "sample_type")]
    pub(crate) dims: Option<Dims>,
    /// Sample type of a headerless file: u8 i8 u16 i16 u32 i32 f32 f64...
    #[arg(long = "type", value_name = "TYPE", value_parser = values::sample_type, help_heading = RAW,
          requires = "dims", id = "sample_type")]
    pub(crate) sample_type: Option<SampleType>,
    /// World length per voxel of a headerless file [default: 1,1,1]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::triple, help_heading = RAW, requires = "dims")]
    pub(crate) spacing: Option<Triple>,
    /// Byte order of a headerless file: little or big [default: little]
    #[arg(long, value_parser = values::endian, help_heading = RAW, requires = "dims")]
    pub(crate) endian: Option<Endian>,
    /// Bytes before the first sample of a headerless file [default: 0]
    #[arg(long, value_name = "BYTES", help_heading = RAW, requires = "dims")]
    pub(crate) offset: Option<u64>,
    /// Name of the array, in files that hold several
    #[arg(long, value_name = "NAME", help_heading = READING)]
    pub(crate) array: Option<String>,
    /// Component of vector-valued samples, from 0
    #[arg(long, value_name = "N", help_heading = READING)]
    pub(crate) component: Option<usize>,
    /// Time point of a series, from 0
    #[arg(long, value_name = "N", help_heading = READING)]
    pub(crate) time: Option<usize>,
    /// Channel of a multi-channel image, from 0
    #[arg(long, value_name = "N", help_heading = READING)]
    pub(crate) channel: Option<usize>,
    /// Level of detail of a multi-scale image; 0 is the finest
    #[arg(long, value_name = "N", help_heading = READING)]
    pub(crate) level: Option<usize>,
    /// Series of a folder that holds several: its number, UID or description
    #[arg(long, value_name = "SERIES", help_heading = READING)]
    pub(crate) series: Option<String>,
    /// Refuse files that are odd in any way
    #[arg(long, help_heading = READING)]
    pub(crate) strict: bool,
}
