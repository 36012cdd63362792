//! Reads the samples that a text or binary header describes, in any of the encodings, from one or several files.

use std::io::BufRead;

use splatvol_scene::Samples;

use super::data_files::{DataFiles, Piece};
use super::flat::{Flat, Tuple};
use super::{Description, Draft, Loaded, Opened, ReadOptions, sample_count};
use crate::IoError;
use crate::error::Context;
use crate::samples::{
    Endian, HexDigits, SampleBuffer, SampleType, TextNumbers, pick_component, remaining_text,
};
use crate::source::{Codec, Rest, Source};

/// Warning where a file is longer than it should be.
pub(super) const EXCESS: &str = "there are more data than the header declares";

/// Encoding of the samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Raw,
    Gzip,
    /// zlib or, told apart by its first bytes, gzip.
    Zlib,
    Text,
    Hex,
}

impl Encoding {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Raw => "raw",
            Self::Gzip => "gzip",
            Self::Zlib => "zlib",
            Self::Text => "ascii",
            Self::Hex => "hex",
        }
    }
}

/// Selection of the samples that make up the volume.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Selection {
    /// Samples along x, y, z.
    pub(super) dims: [usize; 3],
    /// Interleaved components, and the one to take.
    pub(super) components: usize,
    pub(super) component: usize,
    /// Volumes one after the other, and the one to take.
    pub(super) volumes: usize,
    /// The number of them that differ only in time.
    pub(super) times: usize,
    pub(super) volume: usize,
}

/// Storage layout of a file's samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Layout {
    pub(super) sample_type: SampleType,
    /// Whether 16 bits are a float.
    pub(super) half: bool,
    pub(super) endian: Endian,
    pub(super) encoding: Encoding,
    /// Lines to skip, before decompression.
    pub(super) skip_lines: u64,
    /// Bytes to skip, after decompression; `None`: the data end the file.
    pub(super) skip_bytes: Option<u64>,
    /// Position of the first byte of the source in its file.
    pub(super) start: u64,
}

impl Layout {
    /// `i16, big-endian, gzip`.
    pub(super) fn describe(&self) -> String {
        let order = match self.endian {
            _ if self.sample_type.size() == 1 || self.encoding == Encoding::Text => "",
            Endian::Little => ", little-endian",
            Endian::Big => ", big-endian",
        };
        format!("{}{order}, {}", self.sample_type.name(), self.encoding.name())
    }

    pub(super) fn bytes(&self, samples: usize) -> u64 {
        self.sample_type.byte_count(samples)
    }
}

/// What is made of stored samples: a volume in memory, or one that is read in parts.
pub(super) trait FromStored: Sized {
    /// `attached` is the header's file, past the header.
    ///
    /// # Errors
    /// See [`IoError`].
    fn from_stored(
        stored: &Stored<'_>,
        attached: Source<'_>,
        draft: Draft,
        how: (&ReadOptions, &Context<'_>),
    ) -> Result<Self, IoError>;
}

impl FromStored for Loaded {
    fn from_stored(
        stored: &Stored<'_>,
        attached: Source<'_>,
        draft: Draft,
        how: (&ReadOptions, &Context<'_>),
    ) -> Result<Self, IoError> {
        stored.load(attached, draft, how)
    }
}

/// `None` where samples have to be unpacked, and may not be.
impl FromStored for Option<Opened> {
    fn from_stored(
        stored: &Stored<'_>,
        attached: Source<'_>,
        draft: Draft,
        how: (&ReadOptions, &Context<'_>),
    ) -> Result<Self, IoError> {
        stored.open(attached, draft, how)
    }
}

/// Stored samples, and the selection to read.
pub(super) struct Stored<'a> {
    pub(super) layout: Layout,
    pub(super) selection: Selection,
    pub(super) files: DataFiles<'a>,
}

impl Stored<'_> {
    /// Reads the selected samples; `attached` is the header's file, past the header. Files and warnings are added to
    /// `description`.
    fn read(
        &self,
        attached: Source<'_>,
        options: &ReadOptions,
        description: &mut Description,
        context: &Context<'_>,
    ) -> Result<Samples, IoError> {
        let Self {
            layout,
            selection,
            files,
        } = self;
        let one = sample_count(
            selection.dims,
            selection.components,
            layout.sample_type,
            options,
            context,
        )?;
        let too_many = || context.limit(u64::MAX, options.max_bytes);
        let total = one.checked_mul(selection.volumes).ok_or_else(too_many)?;
        let wanted = one * selection.volume..one * (selection.volume + 1);
        // Text is parsed to native numbers.
        let text = layout.encoding == Encoding::Text;
        let endian = if text { Endian::NATIVE } else { layout.endian };
        let mut buffer = SampleBuffer::new(layout.sample_type, endian);
        let mut attached = Some(attached);
        for piece in files.pieces(total, wanted, context)? {
            let source = match files.open(piece.file, description, context)? {
                Some(source) => source,
                None => attached.take().ok_or_else(|| context.truncated("data", 1, 0))?,
            };
            let rest = read_piece(source, layout, &piece, &mut buffer, context)?;
            if rest == Rest::Excess && !files.is_followed() {
                description.warnings.push(EXCESS.to_owned());
            }
        }
        let (samples, warning) = buffer.finish();
        description.warnings.extend(warning);
        description.warnings.dedup();
        Ok(match selection.components {
            1 => samples,
            components => pick_component(&samples, components, selection.component),
        })
    }
}

impl Stored<'_> {
    /// The selected samples where they are. Where they have to be decoded, or lie in several files, they are unpacked if that
    /// is allowed; else `None`. `attached` is the header's file, past the header.
    pub(super) fn open(
        &self,
        attached: Source<'_>,
        mut draft: Draft,
        (options, context): (&ReadOptions, &Context<'_>),
    ) -> Result<Option<Opened>, IoError> {
        let Self {
            layout,
            selection,
            files,
        } = self;
        let is_plain = layout.encoding == Encoding::Raw && layout.skip_lines == 0;
        if !is_plain || files.count() > 1 {
            return self.unpack(attached, draft, (options, context));
        }
        let own = files.open(0, &mut draft.description, context)?;
        let (path, source) = match (own, draft.description.files.last()) {
            (Some(own), Some(path)) => (path.clone(), own),
            _ => (context.path.to_owned(), attached),
        };
        let Some(position) = source.position() else {
            return self.unpack(source, draft, (options, context));
        };
        let sizes = selection.dims.map(|size| size as u64);
        let width = layout.sample_type.size() as u64;
        let tuple = width.saturating_mul(selection.components as u64);
        let one = sizes
            .iter()
            .fold(tuple, |bytes, size| bytes.saturating_mul(*size));
        let all = one.saturating_mul(selection.volumes as u64);
        let skipped = layout
            .skip_bytes
            .unwrap_or_else(|| source.at_most().saturating_sub(all));
        source.check_declared("samples", all.saturating_add(skipped), context)?;
        let is_last = selection.volume + 1 == selection.volumes;
        if source.at_most() - skipped > all && is_last && !files.is_followed() {
            draft.warn(EXCESS);
        }
        let flat = Flat {
            path,
            position: position + skipped + one * selection.volume as u64,
            sample_type: layout.sample_type,
            half: layout.half,
            tuple: Tuple::of(selection.components, selection.component),
            endian: layout.endian,
        };
        flat.open(draft, context).map(Some)
    }

    /// Nothing is unpacked where there are no files.
    #[cfg(target_family = "wasm")]
    fn unpack(
        &self,
        _: Source<'_>,
        _: Draft,
        _: (&ReadOptions, &Context<'_>),
    ) -> Result<Option<Opened>, IoError> {
        Ok(None)
    }

    /// The volume in memory; see [`Stored::read`].
    fn load(
        &self,
        attached: Source<'_>,
        mut draft: Draft,
        (options, context): (&ReadOptions, &Context<'_>),
    ) -> Result<Loaded, IoError> {
        let samples = self.read(attached, options, &mut draft.description, context)?;
        draft.finish(samples, context)
    }
}

/// What a file holds, decoded, from its first sample on.
pub(super) fn decoded<'a>(
    mut source: Source<'a>,
    layout: &Layout,
    piece: &Piece,
    context: &Context<'_>,
) -> Result<Source<'a>, IoError> {
    skip_lines(&mut source, layout.skip_lines, context)?;
    source = match layout.encoding {
        Encoding::Gzip => source.inflate(Codec::Gzip),
        Encoding::Zlib if source.peek(context)?.starts_with(&[0x1f, 0x8b]) => source.inflate(Codec::Gzip),
        Encoding::Zlib => source.inflate(Codec::Zlib),
        Encoding::Raw | Encoding::Text | Encoding::Hex => source,
    };
    match layout.skip_bytes {
        Some(count) => source.skip(count, context)?,
        None => {
            source.check_declared("samples", layout.bytes(piece.holds), context)?;
            source.skip(source.at_most() - layout.bytes(piece.holds), context)?;
        }
    }
    if layout.encoding == Encoding::Hex {
        let at_most = source.at_most() / 2;
        source = Source::bounded(HexDigits::new(source, layout.start), at_most);
    }
    Ok(source)
}

fn read_piece(
    source: Source<'_>,
    layout: &Layout,
    piece: &Piece,
    buffer: &mut SampleBuffer,
    context: &Context<'_>,
) -> Result<Rest, IoError> {
    let mut source = decoded(source, layout, piece, context)?;
    match layout.encoding {
        Encoding::Text => read_text(&mut source, layout, piece, buffer, context),
        Encoding::Raw | Encoding::Gzip | Encoding::Zlib | Encoding::Hex => {
            source.check_declared("samples", layout.bytes(piece.holds), context)?;
            source.skip(layout.bytes(piece.skip), context)?;
            buffer.read(&mut source, piece.take, context)?;
            match piece.ends_file() {
                true => source.rest(context),
                false => Ok(Rest::Nothing),
            }
        }
    }
}

fn read_text(
    source: &mut Source<'_>,
    layout: &Layout,
    piece: &Piece,
    buffer: &mut SampleBuffer,
    context: &Context<'_>,
) -> Result<Rest, IoError> {
    let text = remaining_text(source, context)?;
    let numbers = TextNumbers {
        text: &text,
        start: layout.start,
    };
    let used = buffer.read_text(&numbers, piece.skip, piece.take, context)?;
    match piece.ends_file() && !numbers.ends_at(used) {
        true => Ok(Rest::Excess),
        false => Ok(Rest::Nothing),
    }
}

pub(super) fn skip_lines(source: &mut Source<'_>, count: u64, context: &Context<'_>) -> Result<(), IoError> {
    for skipped in 0..count {
        if source.peek(context)?.is_empty() {
            return Err(context.truncated("skipped lines", count, skipped));
        }
        source.skip_until(b'\n').map_err(|error| context.read(error))?;
    }
    Ok(())
}
