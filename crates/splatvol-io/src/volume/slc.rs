//! SLC of `VolVis`: a text header, a preview, and 8-bit slices, plain or in runs (as VTK's `vtkSLCReader` reads them).

use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};
use splatvol_scene::{LengthUnit, Samples};

use super::{Description, Draft, Loaded, ReadOptions, checked_dims, sample_count};
use crate::error::Context;
use crate::source::read_file;
use crate::{IoError, SampleType};

/// First number of every file.
pub(super) const MAGIC: &[u8] = b"11111";

/// Reads a file.
///
/// # Errors
/// See [`IoError`].
pub fn read(path: &Path, options: &ReadOptions) -> Result<Loaded, IoError> {
    let context = &Context::new("SLC", path);
    let bytes = read_file(path, context)?;
    let mut text = Text {
        bytes: &bytes,
        at: 0,
        context,
    };
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
        other => return Err(context.field("compression", other, text.at as u64, "0 or 1")),
    };
    let preview = [text.number::<u32>("preview")?, text.number::<u32>("preview")?];
    text.mark()?;
    let preview = u64::from(preview[0])
        .saturating_mul(preview[1].into())
        .saturating_mul(3);
    text.take(preview, "preview")?;
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
        files: vec![path.to_owned()],
        ..Description::default()
    };
    sample_count(dims, 1, SampleType::U8, options, context)?;
    let slice = dims[0] * dims[1];
    let mut samples = Vec::new();
    for _ in 0..dims[2] {
        if compressed {
            let length: u32 = text.number("length of a slice")?;
            text.mark()?;
            let coded = text.take(length.into(), "slice")?;
            unpack(coded, slice, &mut samples, context)?;
        } else {
            samples.extend_from_slice(text.take(slice as u64, "slice")?);
        }
    }
    draft.finish(Samples::U8(samples.into()), context)
}

/// Runs of up to 127 equal or, with the highest bit, different samples.
fn unpack(
    mut coded: &[u8],
    slice: usize,
    samples: &mut Vec<u8>,
    context: &Context<'_>,
) -> Result<(), IoError> {
    let end = samples.len() + slice;
    let short = |found: usize| context.truncated("slice", slice as u64, (found + slice - end) as u64);
    while samples.len() < end {
        let (&head, rest) = coded.split_first().ok_or_else(|| short(samples.len()))?;
        let count = usize::from(head & 0x7f).min(end - samples.len());
        let literal = head & 0x80 != 0;
        let used = if literal { usize::from(head & 0x7f) } else { 1 };
        if count == 0 || rest.len() < used {
            return Err(short(samples.len()));
        }
        if literal {
            samples.extend_from_slice(&rest[..count]);
        } else {
            samples.resize(samples.len() + count, rest[0]);
        }
        coded = &rest[used..];
    }
    Ok(())
}

/// Numbers and bytes in turn.
struct Text<'a> {
    bytes: &'a [u8],
    at: usize,
    context: &'a Context<'a>,
}

impl<'a> Text<'a> {
    fn number<T: std::str::FromStr>(&mut self, field: &str) -> Result<T, IoError> {
        let rest = &self.bytes[self.at..];
        let blank = rest.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        let length = rest[blank..]
            .iter()
            .take(40)
            .take_while(|byte| !byte.is_ascii_whitespace())
            .count();
        let word = String::from_utf8_lossy(&rest[blank..blank + length]).into_owned();
        let at = self.at as u64;
        self.at += blank + length;
        word.parse()
            .map_err(|_| self.context.field(field, word, at, "a number"))
    }

    /// The X that ends a text part.
    fn mark(&mut self) -> Result<(), IoError> {
        let rest = &self.bytes[self.at..];
        let blank = rest.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        self.at += blank + 1;
        match rest.get(blank) {
            Some(b'X') => Ok(()),
            other => {
                let shown = other.map_or(String::new(), |byte| format!("{byte:#x}"));
                Err(self.context.field("mark", shown, self.at as u64, "X"))
            }
        }
    }

    fn take(&mut self, length: u64, what: &'static str) -> Result<&'a [u8], IoError> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        match usize::try_from(length).ok().and_then(|length| rest.get(..length)) {
            Some(taken) => {
                self.at += taken.len();
                Ok(taken)
            }
            None => Err(self.context.truncated(what, length, rest.len() as u64)),
        }
    }
}
