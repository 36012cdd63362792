//! Unpacking: samples that are compressed, or lie in several files or between others, become a flat file without a name,
//! from which regions are read. The system removes it with the volume, and when the program dies.

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
        let failed = |source| writing(source, folder);
        let mut file = BufWriter::new(tempfile::tempfile_in(folder).map_err(failed)?);
        let mut attached = Some(attached);
        for piece in files.pieces(total, wanted, context)? {
            let source = match files.open(piece.file, &mut draft.description, context)? {
                Some(source) => source,
                None => attached.take().ok_or_else(|| context.truncated("data", 1, 0))?,
            };
            let source = decoded(source, layout, &piece, context)?;
            let components = (selection.components, selection.component);
            let mut copy = Copying {
                layout,
                components,
                folder,
                file: &mut file,
            };
            if copy.piece(source, &piece, context)? == Rest::Excess && !files.is_followed() {
                draft.warn(EXCESS);
            }
        }
        let file = file.into_inner().map_err(|error| failed(error.into_error()))?;
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

/// Where samples are copied to.
struct Copying<'a, W> {
    layout: &'a Layout,
    /// Interleaved components, and the one to take.
    components: (usize, usize),
    folder: &'a Path,
    file: &'a mut W,
}

impl<W: Write> Copying<'_, W> {
    /// Copies the wanted samples of a file.
    fn piece(
        &mut self,
        mut source: Source<'_>,
        piece: &Piece,
        context: &Context<'_>,
    ) -> Result<Rest, IoError> {
        let (components, component) = self.components;
        let width = self.layout.sample_type.size();
        source.check_declared("samples", self.layout.bytes(piece.holds), context)?;
        source.skip(self.layout.bytes(piece.skip), context)?;
        let all = self.layout.bytes(piece.take);
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
        match piece.ends_file() {
            true => source.rest(context),
            false => Ok(Rest::Nothing),
        }
    }
}
