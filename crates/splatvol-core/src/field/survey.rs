//! What must be known of a level before it is drawn: the range of its values, whether samples are missing, and the
//! samples from which the background is found. An index says it at once; otherwise all chunks are read once, and one is made of them.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;
use splatvol_scene::chunks::{block_ends, spread_step};
use splatvol_scene::volume::{Statistics, widen};
use splatvol_scene::{
    ChunkSource, ChunkedVolume, MinMaxIndex, Rescale, SampleSource, SceneError, Survey, VoxelBox,
    with_samples,
};

use super::level::SourceLevel;

/// Surveys a level that is read from chunks, unless that was done before.
///
/// # Errors
/// Chunks that cannot be read, missing samples, `stop`.
pub fn survey(level: &SourceLevel, stop: &AtomicBool) -> Result<(), SceneError> {
    let (source, index) = level.of();
    let Some(chunks) = source.chunks() else {
        return Ok(());
    };
    if chunks.survey(index).is_none() {
        let found = match of_index(chunks, index) {
            Some(found) => found,
            None => of_samples(chunks, index, stop)?,
        };
        chunks.set_survey(index, found);
    }
    Ok(())
}

/// From what is known without reading the samples.
fn of_index(chunks: &ChunkedVolume, level: usize) -> Option<Survey> {
    let layout = chunks.layout(level);
    let spread = chunks.source().spread(level)?;
    let ends = chunks.source().index(level)?.whole()?;
    let statistics = Statistics {
        non_finite: 0,
        ..statistics(layout.rescale, ends, chunks.statistics(level).mean)?
    };
    Some(Survey {
        statistics,
        spread,
        index: None,
    })
}

fn statistics(rescale: Rescale, ends: [f64; 2], mean: f64) -> Option<Statistics> {
    let [a, b] = ends.map(|end| rescale.apply(end));
    let (min, max) = (a.min(b), a.max(b));
    (max - min).is_finite().then(|| Statistics {
        min,
        max,
        mean: mean.clamp(min, max),
        non_finite: 0,
    })
}

/// What is found in a chunk.
struct Found {
    sum: f64,
    spread: Vec<(usize, f64)>,
}

/// From all samples.
fn of_samples(chunks: &ChunkedVolume, level: usize, stop: &AtomicBool) -> Result<Survey, SceneError> {
    let layout = chunks.layout(level);
    let whole = VoxelBox::whole(&layout.grid);
    let index = Mutex::new(MinMaxIndex::new(layout.grid.dims(), BLOCK, 0));
    let found: Vec<Found> = regions(chunks, level)
        .into_par_iter()
        .map(|region| match stop.load(Ordering::Relaxed) {
            true => Err(SceneError::Stopped),
            false => of_region(chunks, level, region, &index),
        })
        .collect::<Result<_, _>>()?;
    let index = index.into_inner().unwrap_or_else(PoisonError::into_inner);
    let mean = found.iter().map(|own| own.sum).sum::<f64>() / whole.len() as f64;
    let mut spread: Vec<(usize, f64)> = found.into_iter().flat_map(|own| own.spread).collect();
    spread.sort_unstable_by_key(|(index, _)| *index);
    let ends = index.whole().unwrap_or([f64::NAN; 2]);
    let statistics = statistics(layout.rescale, ends, layout.rescale.apply(mean));
    Ok(Survey {
        statistics: statistics.ok_or_else(|| SceneError::invalid("value range", ends, "a finite width"))?,
        spread: spread.into_iter().map(|(_, sample)| sample).collect(),
        index: Some(Arc::new(index)),
    })
}

/// Samples of whole rows that are read at once.
const ROWS: usize = 1 << 20;

/// The regions in which a level is read: whole rows, where those cost no more than their samples, else chunks.
fn regions(chunks: &ChunkedVolume, level: usize) -> Vec<VoxelBox> {
    let layout = chunks.layout(level);
    let [nx, ny, nz] = layout.grid.dims();
    if !chunks.source().reads_regions() {
        let all = layout.chunks_of(VoxelBox::whole(&layout.grid));
        return all.map(|chunk| layout.region(chunk)).collect();
    }
    let most = (ROWS / nx).clamp(1, ny);
    let rows = |z: usize| {
        (0..ny).step_by(most).map(move |y| VoxelBox {
            first: [0, y, z],
            size: [nx, most.min(ny - y), 1],
        })
    };
    (0..nz).flat_map(rows).collect()
}

/// Blocks of the index of what is read through.
const BLOCK: [usize; 3] = [16; 3];

fn of_region(
    chunks: &ChunkedVolume,
    level: usize,
    region: VoxelBox,
    index: &Mutex<MinMaxIndex>,
) -> Result<Found, SceneError> {
    let mut memory = None;
    let block = chunks.read(level, region, &mut memory)?;
    let [nx, ny, nz] = chunks.layout(level).grid.dims();
    let step = spread_step(nx * ny * nz);
    let mut found = Found {
        sum: 0.0,
        spread: Vec::new(),
    };
    let [x, y, z] = region.first;
    let finite = with_samples!(block.samples, data => {
        let mut finite = true;
        for (row, samples) in data.chunks_exact(region.size[0]).enumerate() {
            let (y, z) = (y + row % region.size[1], z + row / region.size[1]);
            for &sample in samples {
                let value = widen(sample);
                found.sum += value;
                finite &= value.is_finite();
            }
            let first = (z * ny + y) * nx + x;
            for index in (first.next_multiple_of(step)..first + samples.len()).step_by(step) {
                found.spread.push((index, widen(samples[index - first])));
            }
        }
        let mut ends = Vec::new();
        block_ends((data, region), region, (BLOCK, 0), |block, own| ends.push((block, own)));
        let mut index = index.lock().unwrap_or_else(PoisonError::into_inner);
        ends.into_iter().for_each(|(block, own)| index.join(block, own));
        finite
    });
    match finite {
        true => Ok(found),
        false => Err(SceneError::Combination {
            what: "a volume with missing samples (NaN) in chunks",
            why: "only volumes in memory may have some; --memory allows it to be read whole where that is enough",
        }),
    }
}
