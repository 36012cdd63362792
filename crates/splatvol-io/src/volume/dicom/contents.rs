//! The bytes of a DICOM file: its first ones in memory, as many as its elements need, the pixels where they are.

use std::ops::Range;
use std::path::Path;

use flate2::bufread::DeflateDecoder;

use super::element::{Coding, Reader, text};
use super::image::Elements;
use super::pixels;
use super::syntax::Syntax;
use crate::IoError;
use crate::error::Context;
use crate::files::{File, read_at};
use crate::samples::Endian;
use crate::source::{Source, read_file};

/// First bytes that are read at once: most headers are shorter.
const START: usize = 1 << 16;
/// Growth of what is read of longer ones.
const GROWTH: usize = 4;

/// The bytes of a file, or those that were deflated in it.
#[derive(Debug)]
pub(super) struct Contents {
    start: Vec<u8>,
    /// The file, unless all is in memory.
    file: Option<File>,
    length: usize,
}

/// What [`Contents::open`] gives: the bytes, how they are coded, and what was made of the elements.
pub(super) type Opened<T> = (Contents, Syntax, T);

impl Contents {
    /// Opens a file and passes its elements on, up to the pixels.
    ///
    /// # Errors
    /// See [`IoError`].
    pub(super) fn open<T>(
        path: &Path,
        context: &Context<'_>,
        of: impl Fn(&Contents, &Elements<'_, '_, '_>, &Syntax) -> Result<T, IoError>,
    ) -> Result<Opened<T>, IoError> {
        let mut wanted = START;
        loop {
            let mut contents = Self::of_file(path, wanted, context)?;
            let (mut at, syntax) = match contents.preamble(context) {
                Ok(found) => found,
                Err((_, more)) if more > contents.start.len() => {
                    wanted = contents.more(more);
                    continue;
                }
                Err((error, _)) => return Err(error),
            };
            if syntax.deflated {
                contents = Self::inflated(path, at, context)?;
                at = 0;
            }
            let mut reader = Reader::new(&contents, at, syntax.coding(), context);
            let dataset = reader.image();
            let more = reader.wanted();
            if dataset.is_err() && more > contents.start.len() {
                wanted = contents.more(more);
                continue;
            }
            let dataset = dataset?;
            let elements = Elements {
                dataset: &dataset,
                endian: syntax.endian(),
                context,
            };
            let made = of(&contents, &elements, &syntax)?;
            drop(dataset);
            return Ok((contents, syntax, made));
        }
    }

    /// A file, of which the first bytes are read.
    fn of_file(path: &Path, wanted: usize, context: &Context<'_>) -> Result<Self, IoError> {
        let mut source = Source::open(path)?;
        let length = usize::try_from(source.at_most())
            .map_err(|_| context.limit(source.at_most(), usize::MAX as u64))?;
        let mut start = vec![0; wanted.min(length)];
        let found = source.fill(&mut start, context)?;
        if found < start.len() {
            return Err(context.truncated("contents", start.len() as u64, found as u64));
        }
        let file = File::open(path).map_err(|error| context.read(error))?;
        Ok(Self {
            start,
            file: Some(file),
            length,
        })
    }

    /// What was deflated behind the file's first bytes.
    fn inflated(path: &Path, start: usize, context: &Context<'_>) -> Result<Self, IoError> {
        let bytes = read_file(path, context)?;
        let limit = pixels::plausible(bytes.len());
        let decoder = DeflateDecoder::new(bytes.get(start..).unwrap_or_default());
        let mut source = Source::from_decoder(decoder, bytes.len() as u64, limit);
        let mut inflated = Vec::new();
        std::io::Read::read_to_end(&mut std::io::Read::take(&mut source, limit), &mut inflated)
            .map_err(|error| context.read(error))?;
        Ok(Self {
            length: inflated.len(),
            start: inflated,
            file: None,
        })
    }

    /// How many of the first bytes to read, where so many are too few.
    fn more(&self, wanted: usize) -> usize {
        wanted.max(self.start.len().saturating_mul(GROWTH))
    }

    /// The first bytes: those in front of the pixels at least.
    pub(super) fn start(&self) -> &[u8] {
        &self.start
    }

    /// How many there are in all.
    pub(super) fn length(&self) -> usize {
        self.length
    }

    /// Some of the bytes, which are within the length.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub(super) fn read(&self, range: Range<usize>, context: &Context<'_>) -> Result<Vec<u8>, IoError> {
        if let Some(bytes) = self.start.get(range.clone()) {
            return Ok(bytes.to_vec());
        }
        let Some(file) = self.file.as_ref().filter(|_| range.end <= self.length) else {
            return Err(context.truncated("contents", range.end as u64, self.length as u64));
        };
        let mut bytes = vec![0; range.len()];
        read_at(file, &mut bytes, range.start as u64).map_err(|error| context.read(error))?;
        Ok(bytes)
    }

    /// Offset of the first element, and the coding of the elements. An error comes with the number of first bytes that it is
    /// about.
    fn preamble(&self, context: &Context<'_>) -> Result<(usize, Syntax), (IoError, usize)> {
        let explicit = Coding {
            explicit: true,
            endian: Endian::Little,
        };
        let preamble = match self.start.get(128..132) {
            Some(b"DICM") => 132,
            _ => 0,
        };
        let mut reader = Reader::new(self, preamble, explicit, context);
        let meta = reader.meta().map_err(|error| (error, reader.wanted()))?;
        let position = reader.position();
        let elements = self.start.get(position..).unwrap_or_default();
        if let Some(uid) = meta.bytes(0x0002_0010) {
            let syntax = Syntax::from_uid(&text(uid));
            return Ok((position, syntax.of_elements(elements)));
        }
        // Files from before PS3.10 do not say; an explicit representation is one of a few pairs of letters.
        let explicit = elements
            .get(4..6)
            .is_some_and(|letters| letters.iter().all(u8::is_ascii_uppercase));
        Ok((position, Syntax::plain(explicit)))
    }
}
