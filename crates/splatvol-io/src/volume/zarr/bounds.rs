//! Index of smallest and largest samples: an array `splatvol/bounds/LEVEL` beside the levels, of shape
//! (2, chunks along z, y, x). It holds the smallest and the largest sample of every chunk and of the samples around it,
//! one in each direction; NaN where samples are missing.

use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;
use splatvol_scene::volume::widen;
use splatvol_scene::{ChunkBuffer, ChunkContent, Grid, LevelLayout, Rescale, with_samples};

use super::array::Array;
use super::folder::Folder;
use super::level::{ArrayLevel, Part};
use super::own;
use crate::volume::ReadOptions;

/// The index of a level.
#[derive(Debug)]
pub(super) struct Bounds {
    /// Smallest and largest samples.
    ends: [ArrayLevel; 2],
    /// Chunks of the two that were read last.
    read: Mutex<[Option<Read>; 2]>,
}

/// A chunk of an index: its number and its values, x fastest.
type Read = ([usize; 3], Arc<Vec<f64>>);

impl Bounds {
    /// The index of a level, `None` if there is none that fits.
    pub(super) fn open(
        folder: &Folder,
        level: usize,
        of: &ArrayLevel,
        options: &ReadOptions,
    ) -> Option<Self> {
        let folder = folder.join(own::BOUNDS).join(&level.to_string());
        let array = Array::open(&folder).ok()??;
        let counts = of.layout.counts();
        let attributes = match array.version {
            2 => folder.json(".zattrs").ok()?,
            _ => folder
                .json("zarr.json")
                .ok()?
                .and_then(|value| value.get("attributes").cloned()),
        };
        let [x, y, z] = of.layout.chunk;
        let fits = array.shape == [2, counts[2], counts[1], counts[0]]
            && own::chunk_of_bounds(attributes.as_ref()) == Some([z, y, x]);
        if !fits {
            return None;
        }
        let layout = LevelLayout {
            grid: Grid::centred(counts, DVec3::ONE).ok()?,
            chunk: [1; 3],
            element: array.element(),
            rescale: Rescale::default(),
            fill: 0.0,
        };
        let end = |place: usize| {
            let part = Part {
                place: vec![place, 0, 0, 0],
                spatial: vec![1, 2, 3],
            };
            ArrayLevel::new(array.clone(), part, layout.clone(), options.allow_outside)
        };
        Some(Self {
            ends: [end(0), end(1)],
            read: Mutex::default(),
        })
    }

    /// Smallest and largest sample of a chunk and around it. An index that cannot be read is as good as none.
    pub(super) fn of(&self, chunk: [usize; 3]) -> Option<[f64; 2]> {
        let low = self.end(0, chunk)?;
        let high = self.end(1, chunk)?;
        (low <= high).then_some([low, high])
    }

    fn end(&self, end: usize, chunk: [usize; 3]) -> Option<f64> {
        let layout = &self.ends[end].layout;
        let number: [usize; 3] = std::array::from_fn(|axis| chunk[axis] / layout.chunk[axis]);
        let values = self.values(end, number)?;
        let region = layout.region(number);
        let at: [usize; 3] = std::array::from_fn(|axis| chunk[axis] - region.first[axis]);
        let [nx, ny, _] = region.size;
        values.get(at[0] + nx * (at[1] + ny * at[2])).copied()
    }

    fn values(&self, end: usize, number: [usize; 3]) -> Option<Arc<Vec<f64>>> {
        let lock = || self.read.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((at, values)) = &lock()[end]
            && *at == number
        {
            return Some(Arc::clone(values));
        }
        let mut buffer = ChunkBuffer::default();
        let content = self.ends[end].read(number, &mut buffer).ok()?;
        if content != ChunkContent::Samples {
            return None;
        }
        let values: Vec<f64> =
            with_samples!(&buffer.samples, data => data.iter().map(|&value| widen(value)).collect());
        let values = Arc::new(values);
        lock()[end] = Some((number, Arc::clone(&values)));
        Some(values)
    }
}
