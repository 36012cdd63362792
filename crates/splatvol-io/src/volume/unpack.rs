//! Unpacking: samples that are compressed, or lie in several files or between others, become a flat file without a name,
//! from which regions are read. The system removes it with the volume, and when the program dies.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use super::data_files::Piece;
use super::flat::{Flat, Tuple};
use super::stored::{EXCESS, Encoding, Layout, Stored, decoded};
use super::{Draft, Opened, ReadOptions};
use crate::error::Context;
use crate::samples::{TextNumbers, decode_text, for_each_little_endian_chunk};
use crate::source::{Rest, Source};
use crate::{Endian, IoError, SampleType};

/// Bytes that are copied at once.
const BUFFER: usize = 1 << 20;

impl Stored<'_> {
    /// The selected samples, unpacked; `None` where that is not allowed.
    pub(super) fn unpack(
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
        let Some(folder) = options.unpack_in.as_deref() else {
            return Ok(None);
        };
        if layout.encoding == Encoding::Text {
            return self.unpack_text(attached, folder, draft, context).map(Some);
        }
        let one = selection
            .dims
            .iter()
            .try_fold(selection.components, |product, &dim| product.checked_mul(dim));
        let total = one.and_then(|one| Some((one, one.checked_mul(selection.volumes)?)));
        let (one, total) = total.ok_or_else(|| context.limit(u64::MAX, u64::MAX))?;
        let wanted = one * selection.volume..one * (selection.volume + 1);
        // Components of one sample may lie in two files: then all are copied.
        let (components, component) = (selection.components, selection.component);
        let (picked, tuple) = match files.count() {
            1 => ((components, component), Tuple::ONE),
            _ => ((1, 0), Tuple::of(components, component)),
        };
        let mut copy = Unpacked::new(folder)?;
        let mut attached = Some(attached);
        for piece in files.pieces(total, wanted, context)? {
            let source = match files.open(piece.file, &mut draft.description, context)? {
                Some(source) => source,
                None => attached.take().ok_or_else(|| context.truncated("data", 1, 0))?,
            };
            let source = decoded(source, layout, &piece, context)?;
            let rest = copy.piece(source, (layout, picked), &piece, context)?;
            if rest == Rest::Excess && !files.is_followed() {
                draft.warn(EXCESS);
            }
        }
        let file = copy.finish()?;
        let flat = Flat {
            path: context.path.to_owned(),
            position: 0,
            sample_type: layout.sample_type,
            half: layout.half,
            tuple,
            endian: layout.endian,
        };
        flat.of_file(file, draft, context).map(Some)
    }
}

impl Stored<'_> {
    /// The selected numbers of texts.
    fn unpack_text(
        &self,
        attached: Source<'_>,
        folder: &Path,
        mut draft: Draft,
        context: &Context<'_>,
    ) -> Result<Opened, IoError> {
        let Self {
            layout,
            selection,
            files,
        } = self;
        let own = draft
            .grid(context)?
            .sample_count()
            .checked_mul(selection.components);
        let before = own.and_then(|own| own.checked_mul(selection.volume));
        let (Some(own), Some(before)) = (own, before) else {
            return Err(context.limit(u64::MAX, u64::MAX));
        };
        let all = own.checked_mul(selection.volumes);
        let all = all.ok_or_else(|| context.limit(u64::MAX, u64::MAX))?;
        let mut copy = Unpacked::new(folder)?;
        let mut attached = Some(attached);
        for piece in files.pieces(all, before..before + own, context)? {
            let source = match files.open(piece.file, &mut draft.description, context)? {
                Some(source) => source,
                None => attached.take().ok_or_else(|| context.truncated("data", 1, 0))?,
            };
            let source = decoded(source, layout, &piece, context)?;
            let text = (layout.sample_type, layout.start);
            let parsed = copy.numbers(source, text, (piece.skip, piece.take), context)?;
            if parsed.is_followed && piece.ends_file() && !files.is_followed() {
                draft.warn(EXCESS);
            }
            parsed.warning.into_iter().for_each(|warning| draft.warn(warning));
        }
        draft.description.warnings.dedup();
        let tuple = Tuple::of(selection.components, selection.component);
        copy.of_numbers((layout.sample_type, tuple), draft, context)
    }
}

/// Numbers that are written as text.
pub(super) struct Numbers {
    pub(super) sample_type: SampleType,
    pub(super) tuple: Tuple,
    /// Their place in the file.
    pub(super) start: u64,
    /// Whether anything may stand behind them.
    pub(super) may_be_followed: bool,
    /// Warning where the file ends with the last of them.
    pub(super) cut: Option<&'static str>,
}

/// What was found in a text.
struct Parsed {
    /// Whether more than blanks stands behind the numbers.
    is_followed: bool,
    /// Whether the text ends with the last of them.
    is_cut: bool,
    warning: Option<String>,
}

/// The volume of a text's numbers, parsed piece by piece.
///
/// # Errors
/// What is no number of the type, fewer of them than the volume has samples; [`IoError::Write`].
pub(super) fn unpack_text(
    source: Source<'_>,
    numbers: Numbers,
    folder: &Path,
    (mut draft, context): (Draft, &Context<'_>),
) -> Result<Opened, IoError> {
    let mut copy = Unpacked::new(folder)?;
    let samples = draft.grid(context)?.sample_count();
    let all = samples.checked_mul(numbers.tuple.components);
    let all = all.ok_or_else(|| context.limit(u64::MAX, u64::MAX))?;
    let text = (numbers.sample_type, numbers.start);
    let parsed = copy.numbers(source, text, (0, all), context)?;
    if let Some(cut) = numbers.cut.filter(|_| parsed.is_cut) {
        draft.warn(cut);
    }
    if parsed.is_followed && !numbers.may_be_followed {
        draft.warn(EXCESS);
    }
    parsed.warning.into_iter().for_each(|warning| draft.warn(warning));
    copy.of_numbers((numbers.sample_type, numbers.tuple), draft, context)
}

fn writing(source: std::io::Error, folder: &Path) -> IoError {
    IoError::Write {
        source,
        path: folder.to_owned(),
    }
}

/// A file without a name that samples are copied to.
pub(super) struct Unpacked<'a> {
    folder: &'a Path,
    file: BufWriter<File>,
}

impl<'a> Unpacked<'a> {
    /// A file in a folder.
    ///
    /// # Errors
    /// [`IoError::Write`].
    pub(super) fn new(folder: &'a Path) -> Result<Self, IoError> {
        let file = tempfile::tempfile_in(folder).map_err(|error| writing(error, folder))?;
        Ok(Self {
            folder,
            file: BufWriter::new(file),
        })
    }

    /// Parses numbers of a text, of a type and from a place in its file on: as many are skipped, and taken.
    ///
    /// # Errors
    /// What is no number of the type, fewer numbers; [`IoError::Write`].
    fn numbers(
        &mut self,
        mut source: Source<'_>,
        (sample_type, mut start): (SampleType, u64),
        (skip, take): (usize, usize),
        context: &Context<'_>,
    ) -> Result<Parsed, IoError> {
        let mut text = Vec::new();
        let mut left = skip.saturating_add(take);
        let mut hidden = skip.saturating_mul(sample_type.size());
        let mut parsed = Parsed {
            is_followed: false,
            is_cut: false,
            warning: None,
        };
        while left > 0 {
            let known = text.len();
            text.resize(known + BUFFER, 0);
            let read = source.fill(&mut text[known..], context)?;
            text.truncate(known + read);
            let is_last = read < BUFFER;
            // The last number may go on in the next piece.
            let whole = match text.iter().rposition(u8::is_ascii_whitespace) {
                _ if is_last => text.len(),
                Some(blank) => blank,
                None => continue,
            };
            let own = &text[..whole];
            let count = match is_last {
                true => left,
                false => TextNumbers { text: own, start }.count().min(left),
            };
            let (samples, warning, used) = decode_text(own, sample_type, count, start, context)?;
            parsed.warning = parsed.warning.or(warning);
            parsed.is_followed = !TextNumbers { text: own, start }.ends_at(used);
            parsed.is_cut = is_last && used == own.len();
            let write = |bytes: &[u8]| {
                let (_, shown) = bytes.split_at(hidden.min(bytes.len()));
                hidden -= bytes.len() - shown.len();
                self.file.write_all(shown)
            };
            for_each_little_endian_chunk(&samples, write).map_err(|error| writing(error, self.folder))?;
            left -= count;
            start += whole as u64;
            text.drain(..whole);
        }
        Ok(parsed)
    }

    /// The volume of parsed numbers.
    ///
    /// # Errors
    /// See [`IoError`].
    fn of_numbers(
        self,
        (sample_type, tuple): (SampleType, Tuple),
        draft: Draft,
        context: &Context<'_>,
    ) -> Result<Opened, IoError> {
        let sample_type = match sample_type {
            SampleType::U64 | SampleType::I64 => SampleType::F64,
            sample_type => sample_type,
        };
        let flat = Flat {
            path: context.path.to_owned(),
            position: 0,
            sample_type,
            half: false,
            tuple,
            endian: Endian::Little,
        };
        flat.of_file(self.finish()?, draft, context)
    }

    /// The file, with all that was copied.
    ///
    /// # Errors
    /// [`IoError::Write`].
    pub(super) fn finish(self) -> Result<File, IoError> {
        let Self { folder, file } = self;
        file.into_inner()
            .map_err(|error| writing(error.into_error(), folder))
    }

    /// Copies the wanted samples of a file. `components`: interleaved ones, and the one to take.
    fn piece(
        &mut self,
        mut source: Source<'_>,
        (layout, (components, component)): (&Layout, (usize, usize)),
        piece: &Piece,
        context: &Context<'_>,
    ) -> Result<Rest, IoError> {
        source.check_declared("samples", layout.bytes(piece.holds), context)?;
        source.skip(layout.bytes(piece.skip), context)?;
        let width = layout.sample_type.size();
        self.take(
            &mut source,
            layout.bytes(piece.take),
            (width, components, component),
            context,
        )?;
        match piece.ends_file() {
            true => source.rest(context),
            false => Ok(Rest::Nothing),
        }
    }

    /// Copies this many bytes; of interleaved components of so many bytes, one.
    ///
    /// # Errors
    /// Fewer bytes than these, [`IoError::Write`].
    pub(super) fn take(
        &mut self,
        source: &mut Source<'_>,
        all: u64,
        (width, components, component): (usize, usize, usize),
        context: &Context<'_>,
    ) -> Result<(), IoError> {
        let mut buffer = vec![0; (BUFFER / (width * components)).max(1) * width * components];
        let mut copied = 0;
        while copied < all {
            let next = (all - copied).min(buffer.len() as u64) as usize;
            let read = source.fill(&mut buffer[..next], context)?;
            if read < next {
                return Err(context.truncated("samples", all, copied + read as u64));
            }
            let written = match components {
                1 => self.file.write_all(&buffer[..next]),
                _ => buffer[..next]
                    .chunks_exact(width * components)
                    .try_for_each(|sample| self.file.write_all(&sample[component * width..][..width])),
            };
            written.map_err(|error| writing(error, self.folder))?;
            copied += next as u64;
        }
        Ok(())
    }
}
