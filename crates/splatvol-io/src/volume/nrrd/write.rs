//! Writing NRRD0004, attached, little-endian, gzip or raw.
//!
//! World space is written as `right-anterior-superior`. NRRD has no slope and intercept: rescaled samples are written
//! as real values, `f32` for stored types of up to 16 bits and `f64` for others.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;
use glam::DVec3;
use splatvol_scene::{Rescale, Samples, Volume};

use crate::IoError;
use crate::samples::for_each_little_endian_chunk;
use crate::volume::WriteOptions;

/// Writes `volume` to a `.nrrd` file.
///
/// # Errors
/// [`IoError::Write`].
pub fn write(path: &Path, volume: &Volume, options: &WriteOptions) -> Result<(), IoError> {
    let failed = |source| IoError::Write {
        source,
        path: path.to_owned(),
    };
    write_to(path, volume, options).map_err(failed)
}

fn write_to(path: &Path, volume: &Volume, options: &WriteOptions) -> std::io::Result<()> {
    let real = (volume.rescale() != Rescale::default()).then(|| real_values(volume));
    let samples = real.as_ref().unwrap_or(volume.samples());
    let mut file = BufWriter::new(File::create(path)?);
    file.write_all(header(volume, samples, options).as_bytes())?;
    if options.compress {
        let mut encoder = GzEncoder::new(file, Compression::default());
        for_each_little_endian_chunk(samples, |bytes| encoder.write_all(bytes))?;
        file = encoder.finish()?;
    } else {
        for_each_little_endian_chunk(samples, |bytes| file.write_all(bytes))?;
    }
    file.flush()
}

fn header(volume: &Volume, samples: &Samples, options: &WriteOptions) -> String {
    let grid = volume.grid();
    let [nx, ny, nz] = grid.dims();
    let map = grid.world_from_voxel();
    let vector = |v: DVec3| format!("({},{},{})", v.x, v.y, v.z);
    let sample_type = match samples {
        Samples::U8(_) => "uint8",
        Samples::I8(_) => "int8",
        Samples::U16(_) => "uint16",
        Samples::I16(_) => "int16",
        Samples::U32(_) => "uint32",
        Samples::I32(_) => "int32",
        Samples::F32(_) => "float",
        Samples::F64(_) => "double",
    };
    let unit = match volume.unit().symbol() {
        "" => String::new(),
        symbol => format!("space units: \"{symbol}\" \"{symbol}\" \"{symbol}\"\n"),
    };
    format!(
        "NRRD0004\n# Complete NRRD file format specification at:\n# http://teem.sourceforge.net/nrrd/format.html\n\
         type: {sample_type}\ndimension: 3\nspace: right-anterior-superior\nsizes: {nx} {ny} {nz}\n\
         space directions: {} {} {}\nkinds: domain domain domain\nendian: little\nencoding: {}\n\
         {unit}space origin: {}\n\n",
        vector(map.matrix3.x_axis),
        vector(map.matrix3.y_axis),
        vector(map.matrix3.z_axis),
        if options.compress { "gzip" } else { "raw" },
        vector(map.translation),
    )
}

/// Real values of rescaled samples, for formats without a rescale.
pub(in crate::volume) fn real_values(volume: &Volume) -> Samples {
    let samples = volume.samples();
    let values = (0..samples.len()).map(|index| volume.value(index));
    if samples.bytes_per_sample() <= 2 {
        Samples::F32(values.map(|value| value as f32).collect())
    } else {
        Samples::F64(values.collect())
    }
}
