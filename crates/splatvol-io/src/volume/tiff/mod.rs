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
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::tiff_pages::tag;
use glam::{DAffine3, DMat3};
use splatvol_scene::Samples;

use super::flat::{Flat, ROUNDED, Tuple};
use super::planes::{Plane, append, component_names};
use super::stack::{self, Slices};
use super::{
    Description, Draft, Loaded, Opened, ReadOptions, checked_dims, choose_channel, choose_time, sample_count,
};
use crate::error::Context;
use crate::tiff_pages::{PageHead, Pages};
use crate::{IoError, SampleType};
use description::{Layout, OWN_FILE, Place};

/// The pages that make a volume, all of the form of the first.
struct Stack {
    layout: Layout,
    first: PageHead,
    channel: usize,
    component: usize,
    time: usize,
}

impl Stack {
    /// The stack of an open file, and its volume.
    fn of(pages: &mut Pages, options: &ReadOptions, context: &Context<'_>) -> Result<(Self, Draft), IoError> {
        let count = pages.count(context)?;
        let first = pages.head(0, context)?;
        let text = pages.text(tag::IMAGE_DESCRIPTION, context);
        let layout = Layout::new(text.as_deref(), count, pages, options, context)?;
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
        let (channel, component) = match layout.channels.len() {
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
        let stack = Self {
            layout,
            first,
            channel,
            component,
            time,
        };
        Ok((stack, draft))
    }

    fn place(&self, slice: usize) -> Place {
        self.layout.page(slice, self.channel, self.time)
    }

    /// The page of a slice, from its file, which is open.
    fn page(&self, pages: &mut Pages, place: Place, context: &Context<'_>) -> Result<Samples, IoError> {
        Ok(plane(pages, place.page, &self.first, context)?.component(self.component))
    }
}

/// Reads a file.
///
/// # Errors
/// See [`IoError`].
pub fn read(path: &Path, options: &ReadOptions) -> Result<Loaded, IoError> {
    let context = &Context::new("TIFF", path);
    let mut pages = Pages::open(path, context)?;
    let (stack, draft) = Stack::of(&mut pages, options, context)?;
    let first = &stack.first;
    sample_count(draft.dims, first.components, first.sample_type, options, context)?;
    let wanted = (0..stack.layout.slices).map(|slice| stack.place(slice));
    if stack.layout.contiguous {
        let samples = pages.contiguous(first, wanted.map(|place| place.page), context)?;
        return draft.finish(samples, context);
    }
    let mut pile: Option<Samples> = None;
    let mut file = OWN_FILE;
    for place in wanted {
        if place.file != file {
            (file, pages) = (place.file, Pages::open(&stack.layout.files[place.file], context)?);
        }
        let samples = stack.page(&mut pages, place, context)?;
        match &mut pile {
            Some(pile) => append(pile, samples, context)?,
            None => pile = Some(samples),
        }
    }
    let samples = pile.ok_or_else(|| context.truncated("pages", 1, 0))?;
    draft.finish(samples, context)
}

/// Opens a file, whose pages are read when they are asked for. `None` where they lie
/// behind each other in another order.
///
/// # Errors
/// See [`IoError`].
pub(super) fn open(path: &Path, options: &ReadOptions) -> Result<Option<Opened>, IoError> {
    let context = &Context::new("TIFF", path);
    let mut pages = Pages::open(path, context)?;
    let (stack, mut draft) = Stack::of(&mut pages, options, context)?;
    let first = &stack.first;
    if stack.layout.contiguous {
        let start = stack.place(0).page as u64 * first.stored_bytes();
        let flat = Flat {
            path: path.to_owned(),
            position: pages.contiguous_start(first, context)?.saturating_add(start),
            sample_type: first.sample_type,
            half: false,
            tuple: Tuple::ONE,
            endian: first.endian,
        };
        let follows = |slice: usize| stack.place(slice).page == stack.place(0).page + slice;
        return match (0..stack.layout.slices).all(follows) {
            true => flat.open(draft, context).map(Some),
            false => Ok(None),
        };
    }
    if matches!(first.sample_type, SampleType::U64 | SampleType::I64) {
        draft.warn(ROUNDED);
    }
    let place = stack.place(0);
    if place.file != OWN_FILE {
        pages = Pages::open(&stack.layout.files[place.file], context)?;
    }
    let element = stack.page(&mut pages, place, context)?.element_type();
    let slices = OpenPages {
        open: Mutex::new(vec![(place.file, pages)]),
        stack,
    };
    stack::open(slices, element, (draft, context)).map(Some)
}

/// The pages of a stack, with readers of its files that nobody uses.
struct OpenPages {
    stack: Stack,
    open: Mutex<Vec<(usize, Pages)>>,
}

impl std::fmt::Debug for OpenPages {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("OpenPages").finish_non_exhaustive()
    }
}

impl OpenPages {
    fn readers(&self) -> MutexGuard<'_, Vec<(usize, Pages)>> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Slices for OpenPages {
    fn slice(&self, index: usize) -> Result<Samples, IoError> {
        let place = self.stack.place(index);
        let path = &self.stack.layout.files[place.file];
        let context = &Context::new("TIFF", path);
        let known = {
            let mut readers = self.readers();
            let at = readers.iter().position(|(file, _)| *file == place.file);
            at.map(|at| readers.swap_remove(at).1)
        };
        let mut pages = match known {
            Some(pages) => pages,
            None => Pages::open(path, context)?,
        };
        pages.read_anew();
        let samples = self.stack.page(&mut pages, place, context)?;
        let mut readers = self.readers();
        if readers.len() < READERS {
            readers.push((place.file, pages));
        }
        Ok(samples)
    }
}

/// Files that stay open at most.
const READERS: usize = 16;

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
