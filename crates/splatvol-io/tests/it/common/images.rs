//! OME-Zarr images as splatvol writes them, and their chunks.

use std::path::{Path, PathBuf};

use splatvol_io::{OmeVersion, PyramidOptions, ReadOptions, open_volume, write_pyramid};
use splatvol_scene::{ChunkBuffer, ChunkContent, ChunkSource, Samples, SourceError};

/// An image with levels, in shards or in files.
pub fn image(folder: &Path, version: OmeVersion) -> PathBuf {
    let raw = folder.join("a.npy");
    let [nx, ny, nz] = [50, 40, 30];
    let text = format!("{{'descr': '<u2', 'fortran_order': False, 'shape': ({nz}, {ny}, {nx}), }}");
    let mut bytes = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    bytes.extend(format!("{text:<117}\n").into_bytes());
    bytes.extend((0..nx * ny * nz).flat_map(|i: u32| ((i * 7 % 4001) as u16).to_le_bytes()));
    std::fs::write(&raw, bytes).unwrap();
    let opened = open_volume(&raw, &ReadOptions::default()).unwrap().unwrap();
    let path = folder.join("a.ome.zarr");
    let options = PyramidOptions {
        version,
        chunk: 16,
        overwrite: true,
        ..PyramidOptions::default()
    };
    write_pyramid(&opened, &path, &options, &|_| {}).unwrap();
    path
}

/// Every chunk of every level, or the first error.
pub fn chunks(source: &dyn ChunkSource) -> Result<Vec<Samples>, SourceError> {
    let mut all = Vec::new();
    let mut buffer = ChunkBuffer::default();
    for (level, layout) in source.levels().iter().enumerate() {
        let [nx, ny, nz] = layout.counts();
        for at in 0..nx * ny * nz {
            let chunk = [at % nx, at / nx % ny, at / (nx * ny)];
            match source.read(level, chunk, &mut buffer)? {
                ChunkContent::Samples => all.push(buffer.samples.clone()),
                ChunkContent::Constant(value) => all.push(layout.element.filled(1, value)),
            }
        }
    }
    Ok(all)
}
