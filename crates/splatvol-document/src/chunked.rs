//! Volumes that are read in chunks when they are drawn: an overview in memory, and the rest within a budget.
//!
//! These are Zarr images with levels of detail, and single Zarr arrays that are larger than an overview may be. Which they are
//! depends on the file alone, never on memory. Looks, cameras and ranges of values are chosen from the overview: the finest
//! level of at most [`OVERVIEW`] samples, or else the coarsest. So small images look as they do in memory.

use std::path::Path;
use std::sync::Arc;

use splatvol_io::{Opened, open_volume};
use splatvol_scene::{Budget, ChunkedVolume, SceneError};

use crate::DocumentError;
use crate::input::{self, Input, Reading};
use crate::keys::ItemKeys;

/// Most samples of an overview.
const OVERVIEW: usize = 1 << 24;

/// Opens the volume of an item, if it is to be read in chunks.
///
/// # Errors
/// Files that cannot be read, memory that is too small for the overview.
pub(crate) fn open(
    item: &ItemKeys,
    path: &Path,
    reading: Reading<'_>,
) -> Result<Option<Input>, DocumentError> {
    let Some(rules) = reading.rules.chunks.filter(|_| item.labels != Some(true)) else {
        return Ok(None);
    };
    // The reader of whole volumes reports errors in its own words.
    let Ok(Some(opened)) = open_volume(path, &input::options(item, reading.rules)?) else {
        return Ok(None);
    };
    let Opened {
        source,
        unit,
        description,
    } = opened;
    // Files without chunks have no levels and no bounds: what is visible is known only when all has been read.
    if source.reads_regions() {
        return Ok(None);
    }
    let samples: Vec<usize> = source
        .levels()
        .iter()
        .map(|level| level.grid.sample_count())
        .collect();
    if samples.len() == 1 && samples[0] <= OVERVIEW {
        return Ok(None);
    }
    let overview = samples.iter().position(|&count| count <= OVERVIEW);
    let failed = |error: SceneError| DocumentError::from(error).of_item(&item.file);
    let too_small = |_| failed(SceneError::invalid("memory", rules.memory, "more bytes"));
    let budget = Budget::new(rules.memory);
    let chunks = ChunkedVolume::new(source, unit, (budget, rules.holes)).map_err(too_small)?;
    let volume = chunks
        .over(overview.unwrap_or(samples.len() - 1))
        .map_err(failed)?;
    if volume.statistics().non_finite > 0 {
        // Missing samples are drawn from memory alone.
        return Ok(None);
    }
    for warning in &description.warnings {
        reading.listener.warn(&format!("{}: {warning}", item.file));
    }
    Ok(Some(Input {
        volume: Arc::new(volume),
        description,
        sample: None,
        mesh: None,
    }))
}
