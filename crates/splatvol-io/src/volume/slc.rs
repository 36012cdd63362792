//! SLC of `VolVis`: a text header, a preview, and 8-bit slices, plain or in runs (as VTK's `vtkSLCReader` reads them).

use std::io::BufRead;
use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};
use splatvol_scene::{LengthUnit, Samples};

#[cfg(not(target_family = "wasm"))]
use super::flat::{Flat, Tuple};
#[cfg(not(target_family = "wasm"))]
use super::unpack::Unpacked;
use super::{Description, Draft, Loaded, Opened, ReadOptions, checked_dims, sample_count};
#[cfg(not(target_family = "wasm"))]
use crate::Endian;
use crate::error::Context;
use crate::source::Source;
use crate::{IoError, SampleType};

/// First number of every file.
pub(super) const MAGIC: &[u8] = b"11111";

/// Missing samples are forgiven up to this part of a slice.
const MOST_MISSING: usize = 4;

/// Digits of a number, at most.
const LONGEST_WORD: usize = 40;

/// Reads a file.
///
/// # Errors
/// See [`IoError`].
pub fn read(path: &Path, options: &ReadOptions) -> Result<Loaded, IoError> {
    let context = &Context::new("SLC", path);
    let (mut slices, mut draft) = Slices::new(Source::open(path)?, context)?;
    sample_count(draft.dims, 1, SampleType::U8, options, context)?;
    let mut samples = Vec::new();
    for _ in 0..draft.dims[2] {
        slices.append_next(&mut samples)?;
    }
    slices.end(&mut draft);
    draft.finish(Samples::U8(samples.into()), context)
}

/// Unpacks the samples beside the output of a conversion, if that is allowed: one slice is in memory meanwhile.
///
/// # Errors
/// As [`read`]; [`IoError::Write`].
#[cfg(not(target_family = "wasm"))]
pub(super) fn open(path: &Path, options: &ReadOptions) -> Result<Option<Opened>, IoError> {
    let Some(folder) = &options.unpack_in else {
        return Ok(None);
    };
    let context = &Context::new("SLC", path);
    let (mut slices, mut draft) = Slices::new(Source::open(path)?, context)?;
    let mut copy = Unpacked::new(folder)?;
    let mut samples = Vec::new();
    for _ in 0..draft.dims[2] {
        samples.clear();
        slices.append_next(&mut samples)?;
        let all = samples.len() as u64;
        copy.take(&mut Source::from_bytes(&samples), all, (1, 1, 0), context)?;
    }
    slices.end(&mut draft);
    let flat = Flat {
        path: path.to_owned(),
        position: 0,
        sample_type: SampleType::U8,
        half: false,
        tuple: Tuple::ONE,
        endian: Endian::NATIVE,
    };
    flat.of_file(copy.finish()?, draft, context).map(Some)
}

/// Nothing is unpacked where there are no files.
///
/// # Errors
/// None.
#[cfg(target_family = "wasm")]
pub(super) fn open(_: &Path, _: &ReadOptions) -> Result<Option<Opened>, IoError> {
    Ok(None)
}

/// The slices of a file, one after the other.
struct Slices<'a> {
    text: Text<'a>,
    /// Samples of a slice.
    size: usize,
    compressed: bool,
    /// Samples that the slices so far lacked.
    missing: usize,
}

impl<'a> Slices<'a> {
    /// Reads the header.
    fn new(source: Source<'a>, context: &'a Context<'a>) -> Result<(Self, Draft), IoError> {
        let mut text = Text { source, context };
        text.number::<u32>("magic number")?;
        let mut sizes = [0i64; 3];
        for size in &mut sizes {
            *size = text.number("size")?;
        }
        let bits: u32 = text.number("bits")?;
        if bits != 8 {
            return Err(context.unsupported(format!("samples of {bits} bits")));
        }
        let mut spacing = [0.0; 3];
        for step in &mut spacing {
            *step = text.number::<f64>("spacing")?;
        }
        let unit: u32 = text.number("unit")?;
        text.number::<u32>("origin of the data")?;
        text.number::<u32>("modification")?;
        let compressed = match text.number::<u32>("compression")? {
            0 => false,
            1 => true,
            other => return Err(context.field("compression", other, text.position(), "0 or 1")),
        };
        let preview = [text.number::<u32>("preview")?, text.number::<u32>("preview")?];
        text.mark()?;
        let preview = u64::from(preview[0])
            .saturating_mul(preview[1].into())
            .saturating_mul(3);
        text.source.skip(preview, context)?;
        let dims = checked_dims(&sizes, "size", 0, context)?;
        let mut draft = Draft::new(dims, Description::default());
        draft.world_from_voxel = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::from_array(spacing)));
        draft.grid(context)?;
        draft.unit = match unit {
            0 => LengthUnit::Metre,
            1 => LengthUnit::Millimetre,
            2 => LengthUnit::Micrometre,
            _ => LengthUnit::Unknown,
        };
        draft.description = Description {
            format: "SLC".to_owned(),
            stored_type: format!("u8, {}", if compressed { "runs" } else { "raw" }),
            orientation: "spacing only".to_owned(),
            files: vec![context.path.to_owned()],
            ..Description::default()
        };
        let slices = Self {
            text,
            size: dims[0] * dims[1],
            compressed,
            missing: 0,
        };
        Ok((slices, draft))
    }

    /// Adds the samples of the next slice; those that it lacks at its end are 0.
    fn append_next(&mut self, samples: &mut Vec<u8>) -> Result<(), IoError> {
        let Self { text, size, .. } = self;
        let start = samples.len();
        if self.compressed {
            let length: u32 = text.number("length of a slice")?;
            text.mark()?;
            let coded = text.source.read_bytes("slice", length.into(), text.context)?;
            unpack(&coded, *size, samples);
        } else {
            let left = usize::try_from(text.source.at_most()).unwrap_or(usize::MAX);
            samples.resize(start + left.min(*size), 0);
            text.source.fill(&mut samples[start..], text.context)?;
        }
        self.missing += start + *size - samples.len();
        // A few samples may be missing at the end; much more is another file.
        if self.missing * MOST_MISSING > *size {
            let found = *size - self.missing.min(*size);
            return Err(text.context.truncated("slice", *size as u64, found as u64));
        }
        samples.resize(start + *size, 0);
        Ok(())
    }

    /// Warns of what was missing, and of bytes behind the last slice.
    fn end(self, draft: &mut Draft) {
        let Self { text, missing, .. } = self;
        let excess = text.source.at_most();
        if missing > 0 {
            draft.warn(format!(
                "{missing} samples are missing at the ends of slices, and taken as 0"
            ));
        }
        if excess > 0 {
            draft.warn(format!("{excess} more bytes than the header declares"));
        }
    }
}

/// Runs of up to 127 equal or, with the highest bit, different samples, to the end of the slice, of the bytes, or to an
/// empty run.
fn unpack(mut coded: &[u8], slice: usize, samples: &mut Vec<u8>) {
    let end = samples.len() + slice;
    while let Some((&head, rest)) = coded.split_first() {
        let count = usize::from(head & 0x7f);
        let taken = count.min(end - samples.len());
        if taken == 0 {
            return;
        }
        if head & 0x80 != 0 {
            samples.extend_from_slice(&rest[..taken.min(rest.len())]);
            coded = rest.get(count..).unwrap_or_default();
        } else {
            let Some((&value, rest)) = rest.split_first() else {
                return;
            };
            samples.resize(samples.len() + taken, value);
            coded = rest;
        }
    }
}

/// Numbers and bytes in turn.
struct Text<'a> {
    source: Source<'a>,
    context: &'a Context<'a>,
}

impl Text<'_> {
    fn position(&self) -> u64 {
        self.source.position().unwrap_or(0)
    }

    /// The next byte, if there is one.
    fn byte(&mut self) -> Result<Option<u8>, IoError> {
        let byte = self.source.peek(self.context)?.first().copied();
        self.source.consume(usize::from(byte.is_some()));
        Ok(byte)
    }

    /// The first byte that is no blank.
    fn first(&mut self) -> Result<Option<u8>, IoError> {
        loop {
            match self.byte()? {
                Some(byte) if byte.is_ascii_whitespace() => (),
                byte => return Ok(byte),
            }
        }
    }

    /// The next word as a number; the blank behind it is taken, too.
    fn number<T: std::str::FromStr>(&mut self, field: &str) -> Result<T, IoError> {
        let mut word = Vec::new();
        let mut next = self.first()?;
        let at = self.position().saturating_sub(1);
        while let Some(byte) = next.filter(|byte| !byte.is_ascii_whitespace() && word.len() < LONGEST_WORD) {
            word.push(byte);
            next = self.byte()?;
        }
        let word = String::from_utf8_lossy(&word).into_owned();
        word.parse()
            .map_err(|_| self.context.field(field, word, at, "a number"))
    }

    /// The X that ends a text part.
    fn mark(&mut self) -> Result<(), IoError> {
        match self.first()? {
            Some(b'X') => Ok(()),
            other => {
                let shown = other.map_or(String::new(), |byte| format!("{byte:#x}"));
                Err(self.context.field("mark", shown, self.position(), "X"))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read_volume;

    fn read(compressed: bool, data: &[u8], strict: bool) -> Result<Loaded, IoError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.slc");
        let header = format!("11111 4 4 2 8 1 1 1 1 0 0 {} 0 0 X", u8::from(compressed));
        std::fs::write(&path, [header.as_bytes(), data].concat()).unwrap();
        let options = ReadOptions {
            strict,
            ..ReadOptions::default()
        };
        read_volume(&path, &options)
    }

    #[test]
    fn a_missing_or_an_extra_byte_is_a_warning_and_strictly_an_error() {
        let samples: Vec<u8> = (1..=32).collect();
        // The first slice has 15 samples in runs, the second 15 of 16 different ones.
        let runs =
            b"5 X\x09\x03\x06\x04\x0016 X\x90\x01\x02\x03\x04\x05\x06\x07\x08\x09\x0a\x0b\x0c\x0d\x0e\x0f";
        for (compressed, data, last, words) in [
            (false, samples[..31].to_vec(), 0, "1 samples are missing"),
            (false, [&samples[..], b"x"].concat(), 32, "1 more bytes"),
            (true, runs.to_vec(), 0, "2 samples are missing"),
        ] {
            let loaded = read(compressed, &data, false).unwrap();
            assert!(
                loaded.description.warnings[0].starts_with(words),
                "{:?}",
                loaded.description
            );
            assert_eq!(loaded.volume.grid().dims(), [4, 4, 2]);
            let Samples::U8(found) = loaded.volume.samples() else {
                panic!("not bytes");
            };
            assert_eq!(found[31], last, "{words}");
            let error = read(compressed, &data, true).unwrap_err();
            assert!(matches!(error, IoError::Strict { .. }), "{error}");
        }
        assert!(matches!(
            read(false, &samples[..20], false),
            Err(IoError::Truncated { .. })
        ));
    }
}
