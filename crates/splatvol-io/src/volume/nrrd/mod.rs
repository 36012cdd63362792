//! NRRD, versions 1 to 5, attached and detached (<https://teem.sourceforge.net/nrrd/format.html>).
//!
//! Read: encodings raw, gzip, ascii and hex; data in the file itself, in one file, in a numbered series or in a list
//! of files; vector axes (one component is taken) and lists of volumes (one is taken). Not read: bzip2 and zrl,
//! samples of type "block". Not applied: `old min`/`old max`, `measurement frame`, `axis mins`/`axis maxs`.

mod axes;
mod data;
mod header;
mod space;
mod write;

use std::path::Path;

use super::{Description, Draft, Loaded, ReadOptions};
use crate::IoError;
use crate::error::Context;
use crate::samples::Endian;
use crate::source::Source;
use header::{Encoding, Header};
use space::Space;

pub use write::write;

/// Reads a `.nrrd` or `.nhdr` file.
///
/// # Errors
/// See [`IoError`].
pub fn read(path: &Path, options: &ReadOptions) -> Result<Loaded, IoError> {
    let context = Context::new("NRRD header", path);
    let mut source = Source::open(path)?;
    let header = Header::read(&mut source, &context)?;
    let space = Space::new(&header.fields, &context)?;
    let selection = axes::select(&header, &space, options, &context)?;
    let placement = space.place(&header.fields, &selection, &context)?;
    let mut draft = Draft::new(selection.dims, describe(path, &header, &placement.orientation));
    draft.world_from_voxel = placement.world_from_voxel;
    draft.unit = placement.unit;
    placement
        .warnings
        .into_iter()
        .for_each(|warning| draft.warn(warning));
    if selection.volumes > 1 {
        draft.warn(format!(
            "volume {} of {} is read",
            selection.volume, selection.volumes
        ));
    }
    draft.grid(&context)?;
    let context = Context::new("NRRD data", path);
    let samples = data::read(
        source,
        &header,
        &selection,
        options,
        &mut draft.description,
        &context,
    )?;
    draft.finish(samples, &context)
}

fn describe(path: &Path, header: &Header, orientation: &str) -> Description {
    let encoding = match header.encoding {
        Encoding::Raw => "raw",
        Encoding::Gzip => "gzip",
        Encoding::Text => "ascii",
        Encoding::Hex => "hex",
    };
    let order = match header.endian {
        _ if header.sample_type.size() == 1 || header.encoding == Encoding::Text => "",
        Endian::Little => ", little-endian",
        Endian::Big => ", big-endian",
    };
    Description {
        format: format!("NRRD000{}", header.version),
        stored_type: format!("{}{order}, {encoding}", header.sample_type.name()),
        orientation: orientation.to_owned(),
        files: vec![path.to_owned()],
        warnings: header.warnings.clone(),
    }
}
