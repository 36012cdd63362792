//! The slices of a series, in order: read one by one, or all.

use std::sync::{Arc, Mutex, PoisonError};

use splatvol_scene::{Rescale, Samples, with_samples};

use super::colors::Table;
use super::image::{Form, FrameHead, ImageHead};
use super::pixels::{OpenFile, SliceReader};
use super::uneven::Uneven;
use crate::IoError;
use crate::error::Context;
use crate::volume::Draft;
use crate::volume::planes::append;
use crate::volume::stack::Slices;

/// A frame of an image.
#[derive(Debug, Clone)]
pub(super) struct Slice {
    pub(super) image: usize,
    pub(super) frame: usize,
    pub(super) head: FrameHead,
}

/// How stored samples become values.
#[derive(Debug, Clone, Copy)]
enum Scaling {
    /// All by the same line.
    Common(Rescale),
    /// Each slice by its own.
    PerSlice,
    /// By the modality look-up tables of slices that have one.
    Tables,
}

/// The slices of a volume.
#[derive(Debug)]
pub(super) struct SeriesSlices {
    images: Vec<ImageHead>,
    slices: Vec<Slice>,
    channel: usize,
    scaling: Scaling,
    /// How they are resampled, if they must be.
    uneven: Option<Uneven>,
    /// The file of several slices that was read last: its header would be read again for each slice.
    opened: Mutex<Option<Arc<OpenFile>>>,
}

impl SeriesSlices {
    /// Slices in order. `channel`: of colours.
    pub(super) fn new(
        images: Vec<ImageHead>,
        slices: Vec<Slice>,
        (channel, uneven): (usize, Option<Uneven>),
    ) -> Self {
        let first = slices[0].head.rescale;
        let scaling = if slices
            .iter()
            .any(|slice| images[slice.image].lookup_table.is_some())
        {
            Scaling::Tables
        } else if first.slope != 0.0 && slices.iter().all(|slice| slice.head.rescale == first) {
            Scaling::Common(first)
        } else {
            Scaling::PerSlice
        };
        Self {
            images,
            slices,
            channel,
            scaling,
            uneven,
            opened: Mutex::default(),
        }
    }

    /// Says what the samples are and where they lie.
    pub(super) fn describe(&self, draft: &mut Draft) {
        let description = &mut draft.description;
        for slice in &self.slices {
            let path = &self.images[slice.image].path;
            if description.files.last() != Some(path) && !description.files.contains(path) {
                description.files.push(path.clone());
            }
        }
        match self.scaling {
            Scaling::Common(rescale) => draft.rescale = rescale,
            Scaling::PerSlice => description.stored_type.push_str(", scaled per slice"),
            Scaling::Tables => description.stored_type.push_str(", by a look-up table"),
        }
    }

    fn form(&self) -> &Form {
        &self.images[self.slices[0].image].form
    }

    /// Samples of all slices, resampled if they must be.
    ///
    /// # Errors
    /// See [`IoError`].
    pub(super) fn all(&self, context: &Context<'_>) -> Result<Samples, IoError> {
        let samples = self.stored(&self.slices)?;
        match &self.uneven {
            Some(uneven) => uneven.resample(&samples, self.form().samples(), context),
            None => Ok(samples),
        }
    }

    /// Samples of some slices one after the other; real values unless all have the same scale.
    fn stored(&self, slices: &[Slice]) -> Result<Samples, IoError> {
        let form = self.form();
        let has_several = |slice: &Slice| self.images[slice.image].frames.len() > 1;
        let kept = || self.opened.lock().unwrap_or_else(PoisonError::into_inner);
        let is_kept = slices.iter().any(has_several);
        let file = if is_kept { kept().clone() } else { None };
        let mut reader = SliceReader::new(form, self.channel, file);
        for slice in slices {
            reader.append(&self.images[slice.image].path, slice.frame)?;
        }
        if is_kept {
            *kept() = reader.take_file();
        }
        let samples = reader.finish();
        let table = |slice: &Slice| self.images[slice.image].lookup_table.as_ref();
        Ok(match self.scaling {
            Scaling::Common(_) => samples,
            Scaling::PerSlice => real(&samples, slices, form, |_| None),
            Scaling::Tables => real(&samples, slices, form, table),
        })
    }
}

impl Slices for SeriesSlices {
    fn slice(&self, index: usize) -> Result<Samples, IoError> {
        let own = |index: usize| self.stored(&self.slices[index..=index]);
        let Some(uneven) = &self.uneven else {
            return own(index);
        };
        let context = &Context::new("DICOM", &self.images[self.slices[0].image].path);
        let [first, rest @ ..] = uneven.around(index);
        let mut around = own(first)?;
        for index in rest {
            append(&mut around, own(index)?, context)?;
        }
        Ok(uneven.resample_one(index, &around, self.form().samples()))
    }
}

/// Values of the modality look-up tables; of slices that have none, scaled.
fn real<'a>(
    samples: &Samples,
    slices: &[Slice],
    form: &Form,
    table: impl Fn(&Slice) -> Option<&'a Table>,
) -> Samples {
    let mut real = Vec::with_capacity(samples.len());
    with_samples!(samples, data => {
        for (slice, data) in slices.iter().zip(data.chunks_exact(form.samples())) {
            match table(slice) {
                Some(table) => look_up(data, table, form, &mut real),
                None => scale(data, slice.head.rescale, &mut real),
            }
        }
    });
    Samples::F32(real.into())
}

fn look_up<T: Copy + Into<f64>>(data: &[T], table: &Table, form: &Form, real: &mut Vec<f32>) {
    let value = |stored: i64| f32::from(table.look_up(stored));
    // Inverted samples are turned back for the table, and its values are turned round.
    let turn = (1i64 << form.stored) - 1;
    let most = f32::from(table.entries.iter().max().copied().unwrap_or(0));
    real.extend(data.iter().map(|&sample| {
        let sample = sample.into() as i64;
        match form.inverted {
            true => most - value(turn - sample),
            false => value(sample),
        }
    }));
}

fn scale<T: Copy + Into<f64>>(stored: &[T], rescale: Rescale, into: &mut Vec<f32>) {
    into.extend(stored.iter().map(|&stored| rescale.apply(stored.into()) as f32));
}
