//! Chunks of a box of samples, compressed, in a file each or together in a shard.

use std::path::PathBuf;

use splatvol_scene::{Samples, VoxelBox, chunks::copy_box};

use super::files::{self, NewFile};
use super::plan::{LevelPlan, chunks_in};
use super::{Compression, OmeVersion, PyramidOptions};
use crate::IoError;
use crate::samples::{Endian, sample_bytes_mut, swap_bytes_of};
use crate::volume::zarr::blosc;

/// Writer of the files of a level.
pub(super) struct LevelFiles<'a> {
    pub(super) folder: PathBuf,
    pub(super) level: &'a LevelPlan,
    pub(super) options: &'a PyramidOptions,
}

impl LevelFiles<'_> {
    /// Writes the chunks of `region`, samples of which are in `samples`, which are those of `of`. `chunk` is memory.
    pub(super) fn write(
        &self,
        region: VoxelBox,
        (samples, of): (&Samples, VoxelBox),
        chunk: &mut Samples,
    ) -> Result<(), IoError> {
        match self.options.version {
            OmeVersion::V05 => self.write_shard(region, (samples, of), chunk),
            OmeVersion::V04 => {
                for number in chunks_in(self.level, region) {
                    let coded = self.coded(number, (samples, of), chunk);
                    let [x, y, z] = number;
                    files::write(&self.folder.join(format!("{z}/{y}/{x}")), &coded)?;
                }
                Ok(())
            }
        }
    }

    /// A shard: its chunks, the fastest axis first, and behind them the index.
    fn write_shard(
        &self,
        region: VoxelBox,
        (samples, of): (&Samples, VoxelBox),
        chunk: &mut Samples,
    ) -> Result<(), IoError> {
        let LevelPlan {
            chunk: edges, shard, ..
        } = *self.level;
        let first: [usize; 3] = std::array::from_fn(|axis| region.first[axis] / edges[axis]);
        let [x, y, z]: [usize; 3] = std::array::from_fn(|axis| first[axis] / shard[axis]);
        let mut file = NewFile::create(&self.folder.join(format!("c/{z}/{y}/{x}")))?;
        let mut index = vec![0xff; 16 * shard.iter().product::<usize>()];
        for number in chunks_in(self.level, region) {
            let coded = self.coded(number, (samples, of), chunk);
            let [x, y, z]: [usize; 3] = std::array::from_fn(|axis| number[axis] - first[axis]);
            let entry = &mut index[16 * ((z * shard[1] + y) * shard[0] + x)..][..16];
            entry[..8].copy_from_slice(&file.length().to_le_bytes());
            entry[8..].copy_from_slice(&(coded.len() as u64).to_le_bytes());
            file.write(&coded)?;
        }
        file.write(&index)?;
        file.write(&crc32c::crc32c(&index).to_le_bytes())?;
        file.finish()
    }

    /// The stored bytes of a chunk. Places behind the ends of the level hold zeros.
    fn coded(&self, number: [usize; 3], (samples, of): (&Samples, VoxelBox), chunk: &mut Samples) -> Vec<u8> {
        let whole = self.level.whole_chunk(number);
        chunk.refill(samples.element_type(), whole.len(), 0.0);
        copy_box(samples, of, chunk, whole);
        coded(chunk, self.options)
    }
}

/// The stored bytes of samples.
pub(super) fn coded(samples: &mut Samples, options: &PyramidOptions) -> Vec<u8> {
    let size = samples.bytes_per_sample();
    let bytes = sample_bytes_mut(samples);
    if Endian::NATIVE == Endian::Big {
        swap_bytes_of(bytes, size);
    }
    let mut coded = match options.compression {
        Compression::None => bytes.to_vec(),
        Compression::Lz4 => blosc::encode(bytes, size, blosc::Compressor::Lz4),
        Compression::Zlib => blosc::encode(bytes, size, blosc::Compressor::Zlib),
    };
    if options.version == OmeVersion::V05 {
        let sum = crc32c::crc32c(&coded);
        coded.extend(sum.to_le_bytes());
    }
    coded
}
