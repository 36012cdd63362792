//! Volumes that are read in chunks when they are drawn: an overview in memory, and the rest within a budget.
//!
//! These are Zarr images with levels of detail, and single Zarr arrays that are larger than an overview may be: that depends
//! on the file alone, never on memory, unless the rules say otherwise. Flat files and stacks of slices are read in memory, which is faster, unless that takes more
//! than is allowed. Looks, cameras and ranges of values are chosen from the overview: the finest level of at most [`OVERVIEW`]
//! samples, or else every n-th sample of the coarsest. So small images look as they do in memory.

use std::path::Path;
use std::sync::Arc;

use splatvol_io::Opened;
use splatvol_scene::{Budget, ChunkedVolume, LevelLayout};

use crate::input::{self, ChunkRules, Input, Reading};
use crate::keys::ItemKeys;
use crate::{DocumentError, files};

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
    let Some(rules) = reading.rules.chunks else {
        return Ok(None);
    };
    // The reader of whole volumes reports errors in its own words.
    let Ok(Some(opened)) = files::open_volume(path, &input::options(item, reading.rules)?) else {
        return Ok(None);
    };
    if item.labels == Some(true) && !opened.description.is_labels {
        // Classes of labels are averaged in memory, unless the file has levels of labels.
        return Ok(None);
    }
    let [layout, coarser @ ..] = opened.source.levels() else {
        return Ok(None);
    };
    let allowed = reading.rules.max_bytes.unwrap_or(u64::MAX).min(rules.memory);
    let holes = rules.holes && opened.is_divided;
    let is_small = match opened.is_divided && !rules.whole_if_it_fits {
        // Holes are those of volumes in chunks.
        _ if holes => false,
        true => coarser.is_empty() && layout.grid.sample_count() <= OVERVIEW,
        false => layout.bytes() <= allowed,
    };
    if is_small {
        return Ok(None);
    }
    let mut warnings = opened.description.warnings.clone();
    if !opened.is_divided {
        warnings.push(format!(
            "its samples take {} bytes, and {allowed} are allowed: they are read from the file for each picture, and an automatic look is chosen from some of them; `splatvol convert` to .ome.zarr makes pictures faster",
            layout.bytes()
        ));
    }
    let input = of_source(opened, rules).map_err(|error| error.of_item(&item.file))?;
    if input.volume.statistics().non_finite > 0 {
        // Missing samples are drawn from memory alone.
        return Ok(None);
    }
    for warning in warnings {
        reading.listener.warn(&format!("{}: {warning}", item.file));
    }
    Ok(Some(input))
}

/// Bytes of the samples of an overview: of this level, or of every n-th sample of it.
fn bytes_of_overview(level: &LevelLayout) -> u64 {
    let dims = level.grid.dims();
    let thinned = |step: usize| dims.map(|n| n.div_ceil(step)).iter().product::<usize>();
    let samples = (1..).map(thinned).find(|samples| *samples <= OVERVIEW);
    samples.unwrap_or(OVERVIEW) as u64 * level.element.size() as u64
}

impl ChunkRules {
    /// Why volumes of a file cannot be drawn.
    fn too_small_for(self, needed: u64) -> DocumentError {
        let least = (needed + Self::PROGRAM).div_ceil(1 << 20);
        let why = format!(
            "leaves {} bytes for the samples of this volume, whose overview takes {needed}: at least {least}M",
            self.memory
        );
        DocumentError::refused("memory", why)
    }
}

/// A volume whose chunks are read when they are drawn: its overview is read here.
///
/// # Errors
/// Samples that cannot be read; memory that is too small for the overview, with what is enough for it.
pub(crate) fn of_source(opened: Opened, rules: ChunkRules) -> Result<Input, DocumentError> {
    let Opened {
        source,
        unit,
        description,
        ..
    } = opened;
    let counts = source.levels().iter().map(|level| level.grid.sample_count());
    let (overview, last) = (
        counts.clone().position(|count| count <= OVERVIEW),
        counts.len() - 1,
    );
    let level = overview.unwrap_or(last);
    let needed = bytes_of_overview(&source.levels()[level]);
    let too_small = || rules.too_small_for(needed);
    let budget = Budget::new(rules.memory);
    let chunks = ChunkedVolume::new(source, unit, (budget, rules.holes)).map_err(|_| too_small())?;
    let volume = chunks
        .over(level, OVERVIEW)
        .map_err(|error| match needed > rules.memory {
            true => too_small(),
            false => error.into(),
        })?;
    Ok(Input {
        volume: Arc::new(volume),
        description,
        sample: None,
        mesh: None,
    })
}
