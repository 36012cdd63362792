//! Samples of single chunks of one array.

use std::sync::atomic::{AtomicUsize, Ordering};

use splatvol_scene::{ChunkBuffer, ChunkContent, ElementType, LevelLayout, Samples, VoxelBox};

use super::array::Array;
use super::codec;
use super::files::{Failure, Files, Kind, Place};
use crate::samples::{Endian, sample_bytes_mut, swap_bytes_of, widen_samples};

/// Bytes of samples that need no justification by stored ones: chunks of one value are tiny.
pub(super) const SPARSE: u64 = 64 << 20;
/// Bytes of samples that a stored byte may decode to.
pub(super) const RATIO: u64 = 1032;

/// The part of an array that is a volume.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Part {
    /// Place along every axis; ignored for the spatial ones.
    pub(super) place: Vec<usize>,
    /// Up to three axes that are taken whole, the slowest first.
    pub(super) spatial: Vec<usize>,
}

impl Part {
    /// The axis of the array that is x, y or z of the volume.
    fn axis(&self, of_volume: usize) -> Option<usize> {
        let place = self.spatial.len().checked_sub(1 + of_volume)?;
        self.spatial.get(place).copied()
    }

    /// Sizes along x, y, z, from sizes along the axes of the array.
    pub(super) fn volume(&self, sizes: &[usize]) -> [usize; 3] {
        std::array::from_fn(|axis| self.axis(axis).map_or(1, |axis| sizes[axis]))
    }
}

/// An array, one volume of which is read chunk by chunk.
#[derive(Debug)]
pub(super) struct ArrayLevel {
    pub(super) array: Array,
    pub(super) part: Part,
    pub(super) layout: LevelLayout,
    files: Files,
    /// 64-bit integers that lost digits so far.
    inexact: AtomicUsize,
}

impl ArrayLevel {
    /// `layout` has the grid and the rescale; its other fields are those of the array.
    pub(super) fn new(array: Array, part: Part, mut layout: LevelLayout, allow_outside: bool) -> Self {
        layout.chunk = part.volume(&array.chunks);
        layout.element = array.element();
        layout.fill = array.fill_value();
        Self {
            files: Files::new(&array, allow_outside),
            array,
            part,
            layout,
            inexact: AtomicUsize::new(0),
        }
    }

    /// 64-bit integers beyond 2^53 in the chunks read so far.
    pub(super) fn inexact(&self) -> usize {
        self.inexact.load(Ordering::Relaxed)
    }

    /// Reads a chunk.
    pub(super) fn read(&self, chunk: [usize; 3], into: &mut ChunkBuffer) -> Result<ChunkContent, Failure> {
        let numbers = self.numbers(chunk);
        let (place, present) = self.files.read(&self.array, &numbers, &mut into.coded)?;
        if !present {
            return self.absent(&place);
        }
        let bytes = self.array.samples_of_chunk() * self.array.sample_type.size();
        let most = SPARSE.max(RATIO.saturating_mul(into.coded.len() as u64));
        if bytes as u64 > most {
            let reason = format!("{} bytes cannot hold the {bytes} of a chunk", into.coded.len());
            return Err(place.fault(Kind::Corrupt, None, reason));
        }
        let region = self.layout.region(chunk);
        let ChunkBuffer {
            samples,
            coded,
            decoded,
        } = into;
        samples.refill(self.layout.element, region.len(), 0.0);
        if self.is_direct(region) {
            self.decode(coded, sample_bytes_mut(samples), &place)?;
        } else {
            decoded.clear();
            decoded.resize(bytes, 0);
            self.decode(coded, decoded, &place)?;
            self.gather(decoded, region, samples);
        }
        if self.array.endian != Endian::NATIVE && self.keeps_type() {
            swap_bytes_of(sample_bytes_mut(samples), self.array.sample_type.size());
        }
        Ok(ChunkContent::Samples)
    }

    /// Tells a store which chunks are read next.
    pub(super) fn will_need(&self, chunks: impl Iterator<Item = [usize; 3]>) {
        let numbers = chunks.map(|chunk| self.numbers(chunk));
        self.files.will_read(&self.array, numbers);
    }

    fn absent(&self, place: &Place) -> Result<ChunkContent, Failure> {
        match self.array.complete {
            true => Err(place.fault(Kind::Missing, None, "the chunk is gone; it was written")),
            false => Ok(ChunkContent::Constant(self.layout.fill)),
        }
    }

    fn decode(&self, coded: &[u8], into: &mut [u8], place: &Place) -> Result<(), Failure> {
        let decoded = codec::decode(coded, &self.array.codecs, into);
        decoded.map_err(|(codec, reason)| place.fault(Kind::Corrupt, codec, reason))
    }

    /// The numbers of a chunk along the axes of the array.
    fn numbers(&self, chunk: [usize; 3]) -> Vec<usize> {
        let places = self.part.place.iter().zip(&self.array.chunks);
        let mut numbers: Vec<usize> = places.map(|(place, chunk)| place / chunk).collect();
        for (axis, number) in chunk.into_iter().enumerate() {
            if let Some(axis) = self.part.axis(axis) {
                numbers[axis] = number;
            }
        }
        numbers
    }

    /// True where samples are in memory as they are stored, but for the order of bytes.
    fn keeps_type(&self) -> bool {
        !self.array.half && self.array.sample_type.size() == self.layout.element.size() && !self.is_long()
    }

    /// True for 64-bit integers.
    fn is_long(&self) -> bool {
        self.array.sample_type.size() == 8 && self.array.sample_type.name() != ElementType::F64.name()
    }

    /// True where the samples of a chunk are those of a region, in their order and type.
    fn is_direct(&self, region: VoxelBox) -> bool {
        self.keeps_type() && self.array.order.is_sorted() && region.len() == self.array.samples_of_chunk()
    }

    /// Copies the samples of a region out of a decoded chunk.
    fn gather(&self, decoded: &[u8], region: VoxelBox, samples: &mut Samples) {
        if self.keeps_type() {
            return self.gather_bytes(decoded, region, sample_bytes_mut(samples));
        }
        let mut bytes = vec![0; region.len() * self.array.sample_type.size()];
        self.gather_bytes(decoded, region, &mut bytes);
        let inexact = widen_samples(&bytes, self.array.sample_type, self.array.endian, samples);
        self.inexact.fetch_add(inexact, Ordering::Relaxed);
    }

    fn gather_bytes(&self, decoded: &[u8], region: VoxelBox, into: &mut [u8]) {
        let (array, part) = (&self.array, &self.part);
        let width = array.sample_type.size();
        let mut strides = vec![0; array.shape.len()];
        let mut stride = width;
        for &axis in array.order.iter().rev() {
            strides[axis] = stride;
            stride *= array.chunks[axis];
        }
        let fixed = (0..array.shape.len()).filter(|axis| !part.spatial.contains(axis));
        let fixed: usize = fixed
            .map(|axis| part.place[axis] % array.chunks[axis] * strides[axis])
            .sum();
        let [sx, sy, sz] = [0, 1, 2].map(|axis| part.axis(axis).map_or(0, |axis| strides[axis]));
        let [nx, ny, _] = region.size;
        for (row, into) in into.chunks_exact_mut(nx * width).enumerate() {
            let from = fixed + row % ny * sy + row / ny * sz;
            if sx == width {
                into.copy_from_slice(&decoded[from..from + nx * width]);
                continue;
            }
            for (x, sample) in into.chunks_exact_mut(width).enumerate() {
                let at = from + x * sx;
                sample.copy_from_slice(&decoded[at..at + width]);
            }
        }
    }
}
