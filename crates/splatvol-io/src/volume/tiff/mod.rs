//! TIFF and `BigTIFF`: pages stacked into a volume, as ImageJ and OME-TIFF describe them, or simply in their order
//! (TIFF 6.0; <https://docs.openmicroscopy.org/ome-model/latest/ome-tiff/>).
//!
//! Read: strips and tiles of 8, 16, 32 and 64 bits and floats; uncompressed, LZW, deflate, `PackBits`, JPEG, zstd; several
//! channels and time points. Spacing comes from ImageJ's or OME's description only: the printing resolution that most
//! files state says nothing about it. Of palettes the samples are read, not the colours. Not read: planar colours, OME images
//! that are spread over several files, levels of detail in sub-directories.

mod chunks;
mod description;
mod ome;

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use glam::{DAffine3, DMat3};
use splatvol_scene::Samples;
use tiff::decoder::ifd::Value;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

use super::planes::{Plane, append, component_names};
use super::{
    Description, Draft, Loaded, ReadOptions, checked_dims, choose_channel, choose_time, sample_count,
};
use crate::IoError;
use crate::error::Context;
use crate::samples::{Endian, SampleBuffer, SampleType};
use crate::source::Source;
use description::Layout;

/// Best ratio of the compressions (deflate has 1032, LZW a little more on large images), and bytes that any file may
/// hold.
const RATIO: u64 = 1500;
const SLACK: u64 = 1 << 20;

/// Reads a file.
///
/// # Errors
/// See [`IoError`].
pub fn read(path: &Path, options: &ReadOptions) -> Result<Loaded, IoError> {
    let context = &Context::new("TIFF", path);
    let mut pages = Pages::open(path, context)?;
    let count = pages.count(context)?;
    let first = pages.head(0, context)?;
    let text = pages.description();
    let layout = Layout::new(text.as_deref(), count, &mut pages, options, context)?;
    let mut description = Description {
        format: layout.format.to_owned(),
        stored_type: first.stored_type(),
        orientation: layout.orientation.to_owned(),
        files: vec![path.to_owned()],
        series: layout.series.clone(),
        ..Description::default()
    };
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
    draft.set_times(layout.times, time);
    draft.world_from_voxel = DAffine3::from_mat3(DMat3::from_diagonal(layout.spacing));
    draft.unit = layout.unit;
    draft.grid(context)?;
    sample_count(draft.dims, first.components, first.sample_type, options, context)?;
    let wanted = (0..layout.slices).map(|slice| layout.page(slice, page_channel, time));
    if layout.contiguous {
        let samples = pages.contiguous(&first, wanted, context)?;
        return draft.finish(samples, context);
    }
    let mut pile: Option<Samples> = None;
    for page in wanted {
        let samples = pages.plane(page, &first, context)?.component(component);
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
    pages.plane(0, &head, context)
}

/// Form of a page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct PageHead {
    pub(super) size: [usize; 2],
    pub(super) components: usize,
    sample_type: SampleType,
    half: bool,
    /// True where samples are places in a palette.
    palette: bool,
    compression: u64,
    endian: Endian,
}

impl PageHead {
    fn bytes(&self) -> u64 {
        let [columns, rows] = self.size.map(|size| size as u64);
        let samples = columns
            .saturating_mul(rows)
            .saturating_mul(self.components as u64);
        samples.saturating_mul(self.sample_type.size() as u64)
    }

    fn stored_type(&self) -> String {
        let order = match self.endian {
            _ if self.sample_type.size() == 1 => "",
            Endian::Little => ", little-endian",
            Endian::Big => ", big-endian",
        };
        let coding = match self.compression {
            1 => "uncompressed",
            5 => "LZW",
            7 => "JPEG",
            8 | 32946 => "deflate",
            32773 => "PackBits",
            50000 => "zstd",
            _ => "compressed",
        };
        let name = if self.half { "f16" } else { self.sample_type.name() };
        let palette = if self.palette { ", places in a palette" } else { "" };
        format!("{name}{order}, {coding}{palette}")
    }
}

/// The pages of a file.
pub(super) struct Pages {
    decoder: Decoder<BufReader<File>>,
    length: u64,
    /// Bytes that the pages still to be read may have.
    budget: u64,
    current: usize,
}

impl Pages {
    fn open(path: &Path, context: &Context<'_>) -> Result<Self, IoError> {
        // Refuses anything but a regular file.
        let length = Source::open(path)?.at_most();
        let file = File::open(path).map_err(|error| context.read(error))?;
        let limits = {
            let mut limits = Limits::default();
            let bytes = usize::try_from(length.min(256 << 20)).unwrap_or(usize::MAX);
            limits.ifd_value_size = bytes;
            let most = length.saturating_mul(RATIO).saturating_add(SLACK);
            limits.decoding_buffer_size = usize::try_from(most).unwrap_or(usize::MAX);
            limits.intermediate_buffer_size = limits.decoding_buffer_size;
            limits
        };
        let decoder = Decoder::new(BufReader::new(file)).map_err(|error| bad(error, context))?;
        Ok(Self {
            decoder: decoder.with_limits(limits),
            length,
            budget: length.saturating_mul(RATIO).saturating_add(SLACK),
            current: 0,
        })
    }

    fn count(&mut self, context: &Context<'_>) -> Result<usize, IoError> {
        let mut count = 1;
        while self.decoder.more_images() {
            self.decoder.next_image().map_err(|error| bad(error, context))?;
            count += 1;
        }
        self.current = count - 1;
        Ok(count)
    }

    fn seek(&mut self, page: usize, context: &Context<'_>) -> Result<(), IoError> {
        if self.current != page {
            self.decoder
                .seek_to_image(page)
                .map_err(|error| bad(error, context))?;
            self.current = page;
        }
        Ok(())
    }

    /// The text of the current page.
    fn description(&mut self) -> Option<String> {
        let value = self.decoder.find_tag(Tag::ImageDescription).ok()??;
        value.into_string().ok()
    }

    /// World length per pixel along x and y, in the unit that a description names.
    pub(super) fn resolution(&mut self) -> [Option<f64>; 2] {
        [Tag::XResolution, Tag::YResolution].map(|tag| {
            let value = match self.decoder.find_tag(tag).ok()?? {
                Value::Rational(over, under) => f64::from(over) / f64::from(under),
                other => other.into_f64().ok()?,
            };
            Some(1.0 / value).filter(|spacing| spacing.is_finite() && *spacing > 0.0)
        })
    }

    fn head(&mut self, page: usize, context: &Context<'_>) -> Result<PageHead, IoError> {
        self.seek(page, context)?;
        let decoder = &mut self.decoder;
        let (columns, rows) = decoder.dimensions().map_err(|error| bad(error, context))?;
        let mut number = |tag| -> Result<Option<u64>, IoError> {
            let numbers = decoder
                .find_tag_unsigned_vec::<u64>(tag)
                .map_err(|error| bad(error, context))?;
            Ok(numbers.and_then(|numbers| numbers.first().copied()))
        };
        let components = number(Tag::SamplesPerPixel)?.unwrap_or(1) as usize;
        let bits = number(Tag::BitsPerSample)?.unwrap_or(1);
        let format = number(Tag::SampleFormat)?.unwrap_or(1);
        let planar = number(Tag::PlanarConfiguration)?.unwrap_or(1) == 2;
        let compression = number(Tag::Compression)?.unwrap_or(1);
        let palette = number(Tag::PhotometricInterpretation)? == Some(3);
        if planar && components > 1 {
            return Err(context.unsupported("components in planes of their own (PlanarConfiguration 2)"));
        }
        let sample_type = match (format, bits) {
            (1 | 4, 8) => SampleType::U8,
            (1 | 4, 16) => SampleType::U16,
            (1 | 4, 32) => SampleType::U32,
            (1 | 4, 64) => SampleType::U64,
            (2, 8) => SampleType::I8,
            (2, 16) => SampleType::I16,
            (2, 32) => SampleType::I32,
            (2, 64) => SampleType::I64,
            (3, 16 | 32) => SampleType::F32,
            (3, 64) => SampleType::F64,
            _ => {
                return Err(context.unsupported(format!("samples of {bits} bits in format {format}")));
            }
        };
        Ok(PageHead {
            size: [columns as usize, rows as usize],
            components,
            sample_type,
            half: (format, bits) == (3, 16),
            palette,
            compression,
            endian: match self.decoder.byte_order() {
                tiff::tags::ByteOrder::LittleEndian => Endian::Little,
                tiff::tags::ByteOrder::BigEndian => Endian::Big,
            },
        })
    }

    /// A page of the same form as `first`.
    fn plane(&mut self, page: usize, first: &PageHead, context: &Context<'_>) -> Result<Plane, IoError> {
        let head = self.head(page, context)?;
        if (head.size, head.components) != (first.size, first.components) {
            let shown = format!(
                "{} x {}, {} components",
                head.size[0], head.size[1], head.components
            );
            let expected = format!(
                "{} x {}, {}, as before",
                first.size[0], first.size[1], first.components
            );
            return Err(context.field(format!("size of page {page}"), shown, None, expected));
        }
        // Half floats take half of what is counted.
        let needed = if head.half { head.bytes() / 2 } else { head.bytes() };
        let available = if head.compression == 1 {
            self.length.min(self.budget)
        } else {
            self.budget
        };
        if needed > available {
            return Err(context.too_small("samples", needed, available));
        }
        self.budget -= needed;
        let samples = match chunks::reads(&head) {
            true => chunks::read(&mut self.decoder, &head, context)?,
            false => samples(self.decoder.read_image().map_err(|error| bad(error, context))?),
        };
        let expected = head.size[0] * head.size[1] * head.components;
        match samples.len() == expected {
            true => Ok(Plane {
                size: head.size,
                components: head.components,
                samples,
            }),
            false => Err(context.truncated("samples", expected as u64, samples.len() as u64)),
        }
    }

    /// Pages that follow the first without headers, as ImageJ writes files of more than 4 GB.
    fn contiguous(
        &mut self,
        head: &PageHead,
        pages: impl Iterator<Item = usize>,
        context: &Context<'_>,
    ) -> Result<Samples, IoError> {
        self.seek(0, context)?;
        let offsets = self
            .decoder
            .find_tag_unsigned_vec::<u64>(Tag::StripOffsets)
            .map_err(|error| bad(error, context))?;
        let start = offsets.and_then(|offsets| offsets.first().copied()).unwrap_or(0);
        if head.components != 1 || head.compression != 1 || head.half {
            return Err(context.unsupported("pages without headers that are not plain samples"));
        }
        let bytes = head.bytes();
        let count = head.size[0] * head.size[1];
        let mut buffer = SampleBuffer::new(head.sample_type, head.endian);
        for page in pages {
            let at = start.saturating_add(bytes.saturating_mul(page as u64));
            let left = self.length.saturating_sub(at);
            if left < bytes {
                return Err(context.truncated("samples", bytes, left));
            }
            let file = self.decoder.inner();
            file.seek(SeekFrom::Start(at))
                .map_err(|error| context.read(error))?;
            let mut source = Source::from_reader(file.take(bytes), bytes);
            buffer.read(&mut source, count, context)?;
        }
        Ok(buffer.finish().0)
    }
}

fn samples(result: DecodingResult) -> Samples {
    match result {
        DecodingResult::U8(data) => Samples::U8(data.into()),
        DecodingResult::U16(data) => Samples::U16(data.into()),
        DecodingResult::U32(data) => Samples::U32(data.into()),
        DecodingResult::U64(data) => Samples::F64(data.into_iter().map(|v| v as f64).collect()),
        DecodingResult::I8(data) => Samples::I8(data.into()),
        DecodingResult::I16(data) => Samples::I16(data.into()),
        DecodingResult::I32(data) => Samples::I32(data.into()),
        DecodingResult::I64(data) => Samples::F64(data.into_iter().map(|v| v as f64).collect()),
        DecodingResult::F16(data) => Samples::F32(data.into_iter().map(f32::from).collect()),
        DecodingResult::F32(data) => Samples::F32(data.into()),
        DecodingResult::F64(data) => Samples::F64(data.into()),
    }
}

fn bad(error: tiff::TiffError, context: &Context<'_>) -> IoError {
    match error {
        tiff::TiffError::IoError(error) => context.read(error),
        tiff::TiffError::UnsupportedError(error) => context.unsupported(error.to_string()),
        error => context.read(std::io::Error::new(std::io::ErrorKind::InvalidData, error)),
    }
}
