//! NRRD, versions 1 to 5, attached and detached (<https://teem.sourceforge.net/nrrd/format.html>).
//!
//! Read: encodings raw, gzip, ascii and hex; data in the file itself, in one file, in a numbered series or in a list
//! of files; vector axes (one component is taken) and lists of volumes (one is taken). Not read: bzip2 and zrl,
//! samples of type "block". Not applied: `old min`/`old max`, `measurement frame`, `axis mins`/`axis maxs`.

mod axes;
mod header;
mod space;
mod write;

use std::path::Path;

use super::stored::{FromStored, Stored};
use super::{Description, Draft, ReadOptions};
use crate::IoError;
use crate::error::Context;
use crate::source::Source;
use header::Header;
use space::Space;

pub(in crate::volume) use write::real_values;
pub use write::write;

/// Reads a `.nrrd` or `.nhdr` file.
///
/// # Errors
/// See [`IoError`].
pub(super) fn read<T: FromStored>(path: &Path, options: &ReadOptions) -> Result<T, IoError> {
    let context = Context::new("NRRD header", path).following(options);
    let mut source = Source::open(path)?;
    let header = Header::read(&mut source, &context)?;
    let space = Space::new(&header.fields, &context)?;
    let axes = axes::select(&header, &space, options, &context)?;
    let placement = space.place(&header.fields, &axes, &context)?;
    let description = Description {
        format: format!("NRRD000{}", header.version),
        stored_type: header.layout.describe(),
        orientation: placement.orientation,
        oriented: placement.oriented,
        files: vec![path.to_owned()],
        warnings: header.warnings.clone(),
        ..Description::default()
    };
    let mut draft = Draft::new(axes.selection.dims, description);
    draft.world_from_voxel = placement.world_from_voxel;
    draft.unit = placement.unit;
    placement
        .warnings
        .into_iter()
        .for_each(|warning| draft.warn(warning));
    draft.set_times(axes.selection.times, options);
    draft.grid(&context)?;
    let stored = Stored {
        layout: header.layout,
        selection: axes.selection,
        files: header.files(&context)?,
    };
    let context = Context::new("NRRD data", path).following(options);
    T::from_stored(&stored, source, draft, (options, &context))
}
