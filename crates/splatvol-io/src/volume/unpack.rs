//! Unpacking: samples that are compressed, or lie in several files or between others, become a flat file without a name,
//! from which regions are read. The system removes it with the volume, and when the program dies.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use super::data_files::Piece;
use super::flat::Flat;
use super::stored::{EXCESS, Encoding, Layout, Stored, decoded};
use super::{Draft, Opened, ReadOptions};
use crate::error::Context;
use crate::source::{Rest, Source};
use crate::{IoError, SampleType};

/// Bytes that are copied at once.
const BUFFER: usize = 1 << 20;

impl Stored<'_> {
    /// The selected samples, unpacked; `None` where that is not allowed, or samples have to be parsed or converted.
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
        let is_parsed = matches!(layout.encoding, Encoding::Text | Encoding::Hex);
        let is_converted = matches!(layout.sample_type, SampleType::U64 | SampleType::I64);
        // Components of one sample may lie in two files.
        let is_torn = selection.components > 1 && files.count() > 1;
        let Some(folder) = options
            .unpack_in
            .as_deref()
            .filter(|_| !is_parsed && !is_converted && !is_torn)
        else {
            return Ok(None);
        };
        let one = selection
            .dims
            .iter()
            .try_fold(selection.components, |product, &dim| product.checked_mul(dim));
        let total = one.and_then(|one| Some((one, one.checked_mul(selection.volumes)?)));
        let (one, total) = total.ok_or_else(|| context.limit(u64::MAX, u64::MAX))?;
        let wanted = one * selection.volume..one * (selection.volume + 1);
        let mut copy = Unpacked::new(folder)?;
        let mut attached = Some(attached);
        for piece in files.pieces(total, wanted, context)? {
            let source = match files.open(piece.file, &mut draft.description, context)? {
                Some(source) => source,
                None => attached.take().ok_or_else(|| context.truncated("data", 1, 0))?,
            };
            let source = decoded(source, layout, &piece, context)?;
            let components = (selection.components, selection.component);
            let rest = copy.piece(source, (layout, components), &piece, context)?;
            if rest == Rest::Excess && !files.is_followed() {
                draft.warn(EXCESS);
            }
        }
        let file = copy.finish()?;
        let flat = Flat {
            path: context.path.to_owned(),
            position: 0,
            sample_type: layout.sample_type,
            half: false,
            endian: layout.endian,
        };
        flat.of_file(file, draft, context)
    }
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
