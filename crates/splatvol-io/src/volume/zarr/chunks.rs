//! The samples of a part of an array: all of three axes, one place along the others.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use splatvol_scene::Samples;

use super::array::{Array, Shard};
use super::codec;
use crate::IoError;
use crate::error::Context;
use crate::samples::SampleBuffer;
use crate::source::{Source, check_inside, read_file};

/// Samples that need no justification by files: chunks that are all fill are often left out.
const SPARSE: u64 = 64 << 20;
/// Bytes of samples that a byte in the files may decode to.
const RATIO: u64 = 1032;
/// Bytes of a chunk's offset and length in the index of a shard.
const INDEX_ENTRY: u64 = 16;
/// Chunks that are looked for, per file that exists.
const CHUNKS_PER_FILE: usize = 64;

/// The part of an array to read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Part {
    /// Place along every axis; ignored for the spatial ones.
    pub(super) place: Vec<usize>,
    /// Up to three axes that are taken whole, the slowest first.
    pub(super) spatial: Vec<usize>,
}

/// Reads the samples, the last spatial axis fastest.
pub(super) fn read(array: &Array, part: &Part, context: &Context<'_>) -> Result<Samples, IoError> {
    check_files(array, part, context)?;
    let mut reader = ChunkReader {
        array,
        part,
        context,
        shard: None,
    };
    let width = array.sample_type.size();
    let sizes: Vec<usize> = part.spatial.iter().map(|&axis| array.shape[axis]).collect();
    let layer: usize = sizes[1..].iter().product();
    let thickness = array.chunks[part.spatial[0]];
    let mut buffer = SampleBuffer::new(array.sample_type, array.endian);
    let mut start = 0;
    while start < sizes[0] {
        // One layer of chunks at a time.
        let layers = thickness.min(sizes[0] - start);
        let mut slab = array.fill.repeat(layers * layer);
        debug_assert_eq!(slab.len(), layers * layer * width);
        reader.slab(start, layers, &mut slab)?;
        buffer.read(&mut Source::from_bytes(&slab), layers * layer, context)?;
        start += layers;
    }
    let (samples, _) = buffer.finish();
    Ok(match samples {
        Samples::U16(bits) if array.half => Samples::F32(
            bits.iter()
                .map(|&bits| half::f16::from_bits(bits).to_f32())
                .collect(),
        ),
        samples => samples,
    })
}

/// Checks the claims of the metadata against the files present.
fn check_files(array: &Array, part: &Part, context: &Context<'_>) -> Result<(), IoError> {
    let (mut files, mut bytes) = (0, 0);
    count_files(&array.folder, array.shape.len() + 1, &mut files, &mut bytes);
    let product = |size: &dyn Fn(usize) -> usize| {
        let mut axes = part.spatial.iter();
        axes.try_fold(1usize, |product, &axis| product.checked_mul(size(axis)))
    };
    let chunk = array.samples_of_chunk() as u64 * array.sample_type.size() as u64;
    let wanted = product(&|axis| array.shape[axis]).unwrap_or(usize::MAX);
    let wanted = array.sample_type.byte_count(wanted).max(chunk);
    let most = SPARSE.max(RATIO.saturating_mul(bytes));
    if files == 0 || wanted > most {
        let most = if files == 0 { 0 } else { most };
        return Err(context.too_small("chunks", wanted, most));
    }
    let chunks = product(&|axis| array.shape[axis].div_ceil(array.chunks[axis]));
    // A shard lists its chunks at its end.
    let listed = usize::try_from(bytes / INDEX_ENTRY).unwrap_or(usize::MAX);
    let per_file = array.shard.as_ref().map_or(1, |shard| {
        let inner = chunks_along(array, shard);
        inner.into_iter().fold(1usize, usize::saturating_mul).min(listed)
    });
    let looked_for = CHUNKS_PER_FILE
        .saturating_mul(files)
        .saturating_mul(per_file)
        .saturating_add(10_000);
    if chunks.is_none_or(|chunks| chunks > looked_for) {
        let shown = format!("{:?} in chunks of {:?}", array.shape, array.chunks);
        return Err(context.field("shape", shown, None, format!("chunks in {files} files")));
    }
    Ok(())
}

/// Files below a folder and their bytes; links are not followed.
fn count_files(folder: &Path, depth: usize, files: &mut usize, bytes: &mut u64) {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    for entry in entries.flatten() {
        let Ok(metadata) = entry.metadata() else { continue };
        let name = entry.file_name();
        let hidden = name.to_string_lossy().starts_with('.') || name == "zarr.json";
        if metadata.is_dir() && depth > 0 {
            count_files(&entry.path(), depth - 1, files, bytes);
        } else if metadata.is_file() && !hidden {
            *files += 1;
            *bytes += metadata.len();
        }
    }
}

/// The open file of a shard, with offset and length of every chunk in it.
struct OpenShard {
    path: PathBuf,
    file: File,
    length: u64,
    chunks: Vec<(u64, u64)>,
}

impl OpenShard {
    /// `None` where all of it is fill, so that there is no file.
    fn open(path: PathBuf, count: u64, shard: &Shard) -> Result<Option<Self>, IoError> {
        if !path.exists() {
            return Ok(None);
        }
        let context = &Context::new("Zarr shard", &path);
        let length = Source::open(&path)?.at_most();
        let mut file = File::open(&path).map_err(|error| context.read(error))?;
        let chunks = shard_index(&mut file, length, count, shard, context)?;
        Ok(Some(Self {
            path,
            file,
            length,
            chunks,
        }))
    }

    /// The bytes of a chunk.
    fn bytes(&mut self, place: usize) -> Result<Option<Vec<u8>>, IoError> {
        let entry = self.chunks.get(place).copied();
        let Some((offset, bytes)) = entry.filter(|&entry| entry != (u64::MAX, u64::MAX)) else {
            return Ok(None);
        };
        let context = &Context::new("Zarr shard", &self.path);
        let left = self.length.saturating_sub(offset);
        if bytes > left {
            return Err(context.truncated("chunk", bytes, left));
        }
        let sought = self.file.seek(SeekFrom::Start(offset));
        sought.map_err(|error| context.read(error))?;
        let mut source = Source::from_reader((&self.file).take(bytes), bytes);
        source.read_bytes("chunk", bytes, context).map(Some)
    }
}

/// Chunks along each axis of a shard.
fn chunks_along(array: &Array, shard: &Shard) -> Vec<usize> {
    let sizes = shard.shape.iter().zip(&array.chunks);
    sizes.map(|(outer, inner)| outer / inner).collect()
}

struct ChunkReader<'a> {
    array: &'a Array,
    part: &'a Part,
    context: &'a Context<'a>,
    /// The shard that was looked for last, by its numbers along the axes.
    shard: Option<(Vec<usize>, Option<OpenShard>)>,
}

impl ChunkReader<'_> {
    /// Fills `layers` layers from `start` on.
    fn slab(&mut self, start: usize, layers: usize, slab: &mut [u8]) -> Result<(), IoError> {
        let (array, part) = (self.array, self.part);
        let mut numbers: Vec<usize> = part
            .place
            .iter()
            .zip(&array.chunks)
            .map(|(place, chunk)| place / chunk)
            .collect();
        let counts: Vec<usize> = part.spatial[1..]
            .iter()
            .map(|&axis| array.shape[axis].div_ceil(array.chunks[axis]))
            .collect();
        numbers[part.spatial[0]] = start / array.chunks[part.spatial[0]];
        for chunk in 0..counts.iter().product::<usize>() {
            let mut rest = chunk;
            for (&axis, &count) in part.spatial[1..].iter().zip(&counts).rev() {
                numbers[axis] = rest % count;
                rest /= count;
            }
            if let Some(bytes) = self.chunk(&numbers)? {
                self.place(&bytes, &numbers, layers, slab);
            }
        }
        Ok(())
    }

    /// Copies the wanted samples of a chunk to their places.
    fn place(&self, bytes: &[u8], numbers: &[usize], layers: usize, slab: &mut [u8]) {
        let (array, spatial) = (self.array, &self.part.spatial);
        let width = array.sample_type.size();
        let mut strides = vec![0; array.shape.len()];
        let mut stride = 1;
        for &axis in array.order.iter().rev() {
            strides[axis] = stride;
            stride *= array.chunks[axis];
        }
        let fixed: usize = (0..array.shape.len())
            .filter(|axis| !spatial.contains(axis))
            .map(|axis| self.part.place[axis] % array.chunks[axis] * strides[axis])
            .sum();
        // Extent of the chunk, start and size of the array, stride in the chunk: of three axes, absent ones flat.
        let axis = |i: usize| {
            (i + spatial.len()).checked_sub(3).map_or((1, 0, 1, 0), |i| {
                let axis = spatial[i];
                let start = if i == 0 {
                    0
                } else {
                    numbers[axis] * array.chunks[axis]
                };
                let size = if i == 0 { layers } else { array.shape[axis] };
                (array.chunks[axis].min(size - start), start, size, strides[axis])
            })
        };
        let [(nz, z0, _, sz), (ny, y0, rows, sy), (nx, x0, columns, sx)] = [axis(0), axis(1), axis(2)];
        for z in 0..nz {
            for y in 0..ny {
                let from = fixed + z * sz + y * sy;
                let to = (((z0 + z) * rows + y0 + y) * columns + x0) * width;
                let row = &mut slab[to..to + nx * width];
                if sx == 1 {
                    row.copy_from_slice(&bytes[from * width..(from + nx) * width]);
                    continue;
                }
                for (x, sample) in row.chunks_exact_mut(width).enumerate() {
                    let at = (from + x * sx) * width;
                    sample.copy_from_slice(&bytes[at..at + width]);
                }
            }
        }
    }

    /// The decoded bytes of a chunk, `None` where it is all fill.
    fn chunk(&mut self, numbers: &[usize]) -> Result<Option<Vec<u8>>, IoError> {
        let array = self.array;
        let (path, coded) = match &array.shard {
            None => {
                let path = array.file(numbers);
                if !path.exists() {
                    return Ok(None);
                }
                check_inside(&path, &array.folder, self.context)?;
                let coded = read_file(&path, &Context::new("Zarr chunk", &path))?;
                (path, coded)
            }
            Some(shard) => match self.sharded(numbers, shard)? {
                Some(found) => found,
                None => return Ok(None),
            },
        };
        let context = &Context::new("Zarr chunk", &path);
        let expected = array.samples_of_chunk() * array.sample_type.size();
        let most = SPARSE.max(RATIO.saturating_mul(coded.len() as u64));
        if expected as u64 > most {
            return Err(context.too_small("samples", expected as u64, most));
        }
        let decoded = codec::decode(&coded, &array.codecs, expected);
        decoded
            .map(Some)
            .map_err(|error| context.read(std::io::Error::new(std::io::ErrorKind::InvalidData, error)))
    }

    /// The bytes of a chunk inside a shard, and the shard's file.
    fn sharded(&mut self, numbers: &[usize], shard: &Shard) -> Result<Option<(PathBuf, Vec<u8>)>, IoError> {
        let array = self.array;
        let inner = chunks_along(array, shard);
        let outer: Vec<usize> = numbers
            .iter()
            .zip(&inner)
            .map(|(number, inner)| number / inner)
            .collect();
        let known = self.shard.as_ref().is_some_and(|(at, _)| *at == outer);
        if !known {
            let count = inner
                .iter()
                .fold(1u64, |product, &size| product.saturating_mul(size as u64));
            let path = array.file(&outer);
            check_inside(&path, &array.folder, self.context)?;
            let opened = OpenShard::open(path, count, shard)?;
            self.shard = Some((outer, opened));
        }
        let Some((_, Some(open))) = &mut self.shard else {
            return Ok(None);
        };
        let place = numbers
            .iter()
            .zip(&inner)
            .fold(0, |place, (number, inner)| place * inner + number % inner);
        let bytes = open.bytes(place)?;
        Ok(bytes.map(|bytes| (open.path.clone(), bytes)))
    }
}

fn shard_index(
    file: &mut File,
    length: u64,
    count: u64,
    shard: &Shard,
    context: &Context<'_>,
) -> Result<Vec<(u64, u64)>, IoError> {
    let sum = if shard.checksum { 4 } else { 0 };
    let bytes = count.saturating_mul(16).saturating_add(sum);
    if bytes > length {
        return Err(context.truncated("index", bytes, length));
    }
    let start = if shard.index_first { 0 } else { length - bytes };
    file.seek(SeekFrom::Start(start))
        .map_err(|error| context.read(error))?;
    let index = Source::from_reader(file.take(bytes), bytes).read_bytes("index", bytes, context)?;
    let (entries, check) = index.split_at((bytes - sum) as usize);
    if shard.checksum && codec::crc32c(entries).to_le_bytes() != check {
        let error = std::io::Error::new(std::io::ErrorKind::InvalidData, "a wrong checksum of the index");
        return Err(context.read(error));
    }
    let number = |bytes: &[u8]| {
        bytes
            .iter()
            .rev()
            .fold(0, |number, &byte| number << 8 | u64::from(byte))
    };
    Ok(entries
        .chunks_exact(16)
        .map(|entry| (number(&entry[..8]), number(&entry[8..])))
        .collect())
}
