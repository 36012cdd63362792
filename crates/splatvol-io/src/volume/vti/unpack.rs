//! Unpacking of files that are compressed or text, a block at a time.

use std::io::Read;
use std::ops::Range;

use super::document::{ImageFile, Place};
use super::skeleton::Skeleton;
use super::{Chosen, payload};
use crate::IoError;
use crate::error::Context;
use crate::source::Source;
use crate::volume::flat::Flat;
use crate::volume::unpack::{Numbers, Unpacked, unpack_text};
use crate::volume::{Opened, ReadOptions, vtk_array};
use crate::xml;

/// Unpacks the samples beside the output of a conversion, if that is allowed. Neither the file's text nor its blocks are in memory
/// meanwhile.
pub(super) fn unpacked(options: &ReadOptions, context: &Context<'_>) -> Result<Option<Opened>, IoError> {
    let Some(folder) = &options.unpack_in else {
        return Ok(None);
    };
    let skeleton = Skeleton::read(Source::open(context.path)?, context)?;
    let document = xml::parse(&skeleton.xml, "XML", context)?;
    let file = ImageFile::from_xml(&document, context)?;
    let chosen = Chosen::new(&file, options, context)?;
    let samples = chosen.draft.grid(context)?.sample_count();
    let (array, _) = vtk_array::choose(&file.arrays.heads, options, context)?;
    let mut texts = skeleton.texts(file.arrays.range(array));
    let text = texts.next();
    // Several long texts of one array: nobody writes that.
    let (None, Some(count)) = (texts.next(), samples.checked_mul(chosen.components)) else {
        return Ok(None);
    };
    let coding = file.coding;
    let encoded = match &chosen.place {
        Place::Ascii(short) => {
            let numbers = Numbers {
                sample_type: chosen.sample_type,
                tuple: chosen.tuple(),
                start: text.as_ref().map_or(0, |text| text.start),
                may_be_followed: false,
                cut: None,
            };
            let source = of_text(text, short, context)?;
            return unpack_text(source, numbers, folder, (chosen.draft, context)).map(Some);
        }
        Place::Base64(short) => payload::from_base64(of_text(text, short, context)?),
        Place::Appended { offset, next } => {
            let base64 = next.filter(|_| coding.appended_base64);
            coding.unwrap(appended(&skeleton, *offset, base64, context)?)
        }
    };
    let mut copy = Unpacked::new(folder)?;
    let width = chosen.sample_type.size();
    let take = |source: &mut Source<'_>, samples| {
        let bytes = chosen.sample_type.byte_count(samples);
        copy.take(source, bytes, (width, 1, 0), context)
    };
    payload::each_part(encoded, (chosen.sample_type, count), coding, (context, take))?;
    let flat = Flat {
        path: context.path.to_owned(),
        position: 0,
        sample_type: chosen.sample_type,
        half: false,
        tuple: chosen.tuple(),
        endian: coding.endian,
    };
    flat.of_file(copy.finish()?, chosen.draft, context).map(Some)
}

/// A text of the file, or a short one.
fn of_text<'a>(
    text: Option<Range<u64>>,
    short: &'a str,
    context: &Context<'_>,
) -> Result<Source<'a>, IoError> {
    match text {
        Some(text) => {
            let source = Source::open_at(context.path, text.start)?;
            Ok(part_of(source, text.end - text.start))
        }
        None => Ok(Source::from_bytes(short.as_bytes())),
    }
}

/// The appended data from an offset on, to the next one where that is given.
fn appended(
    skeleton: &Skeleton,
    offset: u64,
    next: Option<u64>,
    context: &Context<'_>,
) -> Result<Source<'static>, IoError> {
    let start = skeleton
        .appended
        .ok_or_else(|| context.field("AppendedData", "", None, "an <AppendedData> element"))?;
    let position = start.saturating_add(offset);
    let source = Source::open_at(context.path, position)?;
    if source.at_most() == 0 {
        let expected = "an offset inside the appended data";
        return Err(context.field("offset", offset, None, expected));
    }
    Ok(match next {
        Some(next) => part_of(source, next - offset),
        None => source,
    })
}

/// The first bytes of a source, as many.
fn part_of(source: Source<'static>, length: u64) -> Source<'static> {
    let at_most = length.min(source.at_most());
    Source::bounded(source.take(length), at_most)
}
