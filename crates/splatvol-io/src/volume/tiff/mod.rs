//! TIFF and `BigTIFF`: pages stacked into a volume, as ImageJ and OME-TIFF describe them, or simply in their order
//! (TIFF 6.0; <https://docs.openmicroscopy.org/ome-model/latest/ome-tiff/>).
//!
//! Read: strips and tiles, interleaved or in planes, of 1, 2, 4, 8, 16, 32 and 64 bits and floats; uncompressed, LZW,
//! deflate, `PackBits`, JPEG, zstd; several channels and time points; OME images over several files. Spacing comes from
//! ImageJ's or OME's description only: the printing resolution that most files state says nothing about it. Of palettes
//! the samples are read, not the colours. Not read: levels of detail in sub-directories.

mod description;
mod ome;

use std::path::Path;

use crate::tiff_pages::tag;
use glam::{DAffine3, DMat3};
use splatvol_scene::Samples;

use super::planes::{Plane, append, component_names};
use super::{
    Description, Draft, Loaded, ReadOptions, checked_dims, choose_channel, choose_time, sample_count,
};
use crate::IoError;
use crate::error::Context;
use crate::tiff_pages::{PageHead, Pages};
use description::{Layout, OWN_FILE, Place};

/// Reads a file.
///
/// # Errors
/// See [`IoError`].
pub fn read(path: &Path, options: &ReadOptions) -> Result<Loaded, IoError> {
    let context = &Context::new("TIFF", path);
    let mut pages = Pages::open(path, context)?;
    let count = pages.count(context)?;
    let first = pages.head(0, context)?;
    let text = pages.text(tag::IMAGE_DESCRIPTION, context);
    let layout = Layout::new(text.as_deref(), count, &pages, options, context)?;
    let mut description = Description {
        format: layout.format.to_owned(),
        stored_type: first.stored_type(),
        orientation: layout.orientation.to_owned(),
        files: layout.files.clone(),
        series: layout.series.clone(),
        ..Description::default()
    };
    if first.white_is_zero {
        let warning =
            "white is zero in this file: samples are as stored, the brightest are dark in other programs";
        description.warnings.push(warning.to_owned());
    }
    // Channels are pages of their own or, if there are none, components of each page.
    let names = match layout.channels.len() {
        1 => component_names(first.components),
        _ => layout.channels.clone(),
    };
    let (channel, warning) = choose_channel(&names, options, context)?;
    description.warnings.extend(warning);
    if names.len() > 1 {
        description.channels = names;
    }
    let (page_channel, component) = match layout.channels.len() {
        1 => (0, channel),
        _ if first.components == 1 => (channel, 0),
        _ => return Err(context.unsupported("channels both in pages and in their samples")),
    };
    let time = choose_time(layout.times, options, context)?;
    let sizes = [first.size[0], first.size[1], layout.slices].map(|size| size as i64);
    let mut draft = Draft::new(checked_dims(&sizes, "dims", None, context)?, description);
    layout
        .warnings
        .iter()
        .for_each(|warning| draft.warn(warning.clone()));
    draft.set_times(layout.times, options);
    draft.world_from_voxel = DAffine3::from_mat3(DMat3::from_diagonal(layout.spacing));
    draft.unit = layout.unit;
    draft.grid(context)?;
    sample_count(draft.dims, first.components, first.sample_type, options, context)?;
    let wanted = (0..layout.slices).map(|slice| layout.page(slice, page_channel, time));
    if layout.contiguous {
        let samples = pages.contiguous(&first, wanted.map(|place| place.page), context)?;
        return draft.finish(samples, context);
    }
    let mut pile: Option<Samples> = None;
    let mut file = OWN_FILE;
    for Place { file: next, page } in wanted {
        if next != file {
            (file, pages) = (next, Pages::open(&layout.files[next], context)?);
        }
        let samples = plane(&mut pages, page, &first, context)?.component(component);
        match &mut pile {
            Some(pile) => append(pile, samples, context)?,
            None => pile = Some(samples),
        }
    }
    let samples = pile.ok_or_else(|| context.truncated("pages", 1, 0))?;
    draft.finish(samples, context)
}

/// The only page of a file, or its first.
pub(super) fn first_plane(path: &Path, context: &Context<'_>) -> Result<Plane, IoError> {
    let mut pages = Pages::open(path, context)?;
    let head = pages.head(0, context)?;
    plane(&mut pages, 0, &head, context)
}

/// A page of the same form as `first`.
fn plane(pages: &mut Pages, page: usize, first: &PageHead, context: &Context<'_>) -> Result<Plane, IoError> {
    let head = pages.head(page, context)?;
    let (size, components) = (head.size, head.components);
    if (size, components) != (first.size, first.components) {
        let form = |head: &PageHead| {
            let [columns, rows] = head.size;
            format!("{columns} x {rows}, {} components", head.components)
        };
        let expected = format!("{}, as before", form(first));
        return Err(context.field(format!("size of page {page}"), form(&head), None, expected));
    }
    let samples = pages.samples(&head, context)?;
    Ok(Plane {
        size,
        components,
        samples,
    })
}
