//! Reads regions of samples into its own memory.

use splatvol_scene::volume::widen;
use splatvol_scene::{Block, Samples, SceneError, VoxelBox};

use super::lattice;
use super::level::{Failure, SourceLevel};
use crate::visibility::Histogram;

/// Reads regions of samples.
pub(super) struct Reader<'a> {
    source: &'a SourceLevel,
    failure: &'a Failure,
    memory: Option<Samples>,
    /// Region whose samples are in memory, and serve the regions within it.
    held: Option<VoxelBox>,
}

impl<'a> Reader<'a> {
    pub(super) fn new(source: &'a SourceLevel, failure: &'a Failure) -> Self {
        Self::with_memory(source, failure, None)
    }

    /// With the memory of an earlier one.
    pub(super) fn with_memory(
        source: &'a SourceLevel,
        failure: &'a Failure,
        memory: Option<Samples>,
    ) -> Self {
        Self {
            source,
            failure,
            memory,
            held: None,
        }
    }

    /// Reads a region from which all later ones are taken; `None` where that fails.
    pub(super) fn hold(&mut self, region: VoxelBox) -> Option<()> {
        self.held = None;
        self.read(region)?;
        self.held = Some(region);
        Some(())
    }

    /// Its memory.
    pub(super) fn into_memory(self) -> Option<Samples> {
        self.memory
    }

    pub(super) fn read(&mut self, region: VoxelBox) -> Option<Block<'_>> {
        if let Some(of) = self.held {
            return self.memory.as_ref().map(|samples| Block { samples, of });
        }
        self.failure.catch(self.source.read(region, &mut self.memory))
    }
}

/// Frequencies of values, from up to 65 536 evenly spread samples.
pub(super) fn histogram(source: &SourceLevel, failure: &Failure) -> Histogram {
    let mut histogram = Histogram::new(source.value_range(), source.rescale());
    match source.known() {
        Some(survey) => survey.spread.iter().for_each(|&sample| histogram.add(sample)),
        None => {
            let mut add = |sample| histogram.add(sample);
            failure.catch(for_spread(source, &mut add));
        }
    }
    histogram
}

/// Every n-th stored sample of a level, x fastest, n by [`Histogram::step`].
///
/// # Errors
/// Samples that cannot be read.
pub(crate) fn spread(source: &SourceLevel) -> Result<Vec<f64>, SceneError> {
    if let Some(survey) = source.known() {
        return Ok(survey.spread.clone());
    }
    let mut spread = Vec::new();
    for_spread(source, &mut |sample| spread.push(sample))?;
    Ok(spread)
}

fn for_spread(source: &SourceLevel, take: &mut dyn FnMut(f64)) -> Result<(), SceneError> {
    let mut memory = None;
    let [nx, ny, nz] = source.grid().dims();
    let step = Histogram::step(nx * ny * nz);
    for z in 0..nz {
        let slice = VoxelBox {
            first: [0, 0, z],
            size: [nx, ny, 1],
        };
        let block = source.read(slice, &mut memory)?;
        let from = (z * nx * ny).next_multiple_of(step);
        splatvol_scene::with_samples!(block.samples, data => {
            let data = lattice::Block::new(data, block.of);
            for at in (from..(z + 1) * nx * ny).step_by(step) {
                take(widen(data.row([at / nx % ny, z]).at(at % nx)));
            }
        });
    }
    Ok(())
}
