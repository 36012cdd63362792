//! Frames from native and encapsulated pixels (PS3.5, section 8 and annexes A.4 and G) to samples.

use std::ops::Range;
use std::path::{Path, PathBuf};

use dicom_toolkit_jpeg2000::{DecodeSettings, Image};
use jpeg_decoder::{Decoder, PixelFormat};
use splatvol_scene::Samples;

use super::element::{Reader, Value, unsigned};
use super::image::{Elements, Form};
use super::syntax::{Pixels, Syntax};
use super::{contents, jpeg_ls};
use crate::IoError;
use crate::error::Context;
use crate::samples::Endian;

/// Frames up to this many bytes need no justification: a constant slice is a few bytes in most codings.
const SMALL_FRAME: u64 = 8 << 20;
/// Bytes that one compressed byte may stand for in larger ones.
const RATIO: u64 = 256;

/// Bytes that `compressed` ones may reasonably hold.
pub(super) fn plausible(compressed: usize) -> u64 {
    SMALL_FRAME.max((compressed as u64).saturating_mul(RATIO))
}

/// Collects frames of one form.
pub(super) struct SliceReader<'a> {
    form: &'a Form,
    words: Words,
    /// Frames of a file often follow each other.
    file: Option<OpenFile>,
}

/// Samples as they are stored, in native order.
enum Words {
    One(Vec<u8>),
    Two(Vec<u16>),
    Four(Vec<u32>),
}

struct OpenFile {
    path: PathBuf,
    bytes: Vec<u8>,
    syntax: Syntax,
    /// Parts of `bytes` that make up each frame.
    frames: Vec<Vec<Range<usize>>>,
}

impl OpenFile {
    fn new(path: &Path, form: &Form, context: &Context<'_>) -> Result<Self, IoError> {
        let (bytes, start, syntax) = contents(path, context)?;
        let frames = {
            let dataset = Reader::new(&bytes, start, syntax.coding(), context).image()?;
            let elements = Elements {
                dataset: &dataset,
                endian: syntax.endian(),
                context,
            };
            let count = elements
                .image(path, &syntax)?
                .map_or(0, |image| image.frames.len());
            match elements
                .pixels()
                .map(|pixels| (&pixels.value, pixels.offset as usize))
            {
                Some((Value::Bytes(_), offset)) => {
                    let frame = |i: usize| offset + i * form.bytes()..offset + (i + 1) * form.bytes();
                    (0..count).map(|i| vec![frame(i)]).collect()
                }
                Some((Value::Fragments(fragments), _)) => frames(fragments, count, &bytes, context)?,
                _ => Vec::new(),
            }
        };
        Ok(Self {
            path: path.to_owned(),
            bytes,
            syntax,
            frames,
        })
    }
}

/// Distributes fragments over frames: one frame takes all, else each takes one, else the table of offsets decides.
fn frames(
    fragments: &[Range<usize>],
    count: usize,
    bytes: &[u8],
    context: &Context<'_>,
) -> Result<Vec<Vec<Range<usize>>>, IoError> {
    let Some((table, fragments)) = fragments.split_first() else {
        return Err(context.truncated("fragments", 1, 0));
    };
    if count == 1 {
        return Ok(vec![fragments.to_vec()]);
    }
    if fragments.len() == count {
        return Ok(fragments.iter().map(|fragment| vec![fragment.clone()]).collect());
    }
    let offsets: Vec<usize> = bytes[table.clone()]
        .chunks_exact(4)
        .map(|offset| unsigned(offset, Endian::Little) as usize)
        .collect();
    // Offsets count from the first fragment's tag, eight bytes before its contents.
    let first = fragments.first().map_or(0, |fragment| fragment.start);
    let mut frames: Vec<Vec<Range<usize>>> = Vec::new();
    for fragment in fragments {
        let starts = offsets.get(frames.len()) == Some(&(fragment.start - first));
        match frames.last_mut() {
            Some(frame) if !starts => frame.push(fragment.clone()),
            _ => frames.push(vec![fragment.clone()]),
        }
    }
    match frames.len() == count {
        true => Ok(frames),
        false => Err(context.field(
            "NumberOfFrames (0028,0008)",
            count,
            None,
            format!(
                "a number that {} fragments can be distributed over",
                fragments.len()
            ),
        )),
    }
}

impl<'a> SliceReader<'a> {
    pub(super) fn new(form: &'a Form) -> Self {
        let words = match form.allocated {
            8 => Words::One(Vec::new()),
            16 => Words::Two(Vec::new()),
            _ => Words::Four(Vec::new()),
        };
        Self {
            form,
            words,
            file: None,
        }
    }

    /// Adds a frame of a file.
    pub(super) fn append(&mut self, path: &Path, frame: usize) -> Result<(), IoError> {
        let context = &Context::new("DICOM", path);
        let file = match self.file.take().filter(|file| file.path == path) {
            Some(file) => file,
            None => OpenFile::new(path, self.form, context)?,
        };
        let parts = file.frames.get(frame).map_or(&[][..], Vec::as_slice);
        let joined: Vec<u8>;
        let coded = match parts {
            [part] => &file.bytes[part.clone()],
            parts => {
                joined = parts
                    .iter()
                    .flat_map(|part| &file.bytes[part.clone()])
                    .copied()
                    .collect();
                &joined
            }
        };
        self.decode(coded, &file.syntax, context)?;
        self.file = Some(file);
        Ok(())
    }

    fn decode(&mut self, coded: &[u8], syntax: &Syntax, context: &Context<'_>) -> Result<(), IoError> {
        let form = self.form;
        let needed = form.bytes();
        if syntax.pixels == Pixels::Native {
            return self.extend(coded, syntax.endian(), context);
        }
        if needed as u64 > plausible(coded.len()) {
            return Err(context.too_small("pixels", needed as u64, plausible(coded.len())));
        }
        let bytes = match syntax.pixels {
            Pixels::Rle => rle(coded, form, context)?,
            Pixels::Jpeg => jpeg(coded, form, context)?,
            Pixels::JpegLs => widen(jpeg_ls::decode(coded, [form.columns, form.rows], context)?, form),
            Pixels::Jpeg2000 => jpeg_2000(coded, form, context)?,
            Pixels::Native | Pixels::Unknown => {
                return Err(context.unsupported(format!("pixels are coded as {}", syntax.name)));
            }
        };
        self.extend(&bytes, Endian::Little, context)
    }

    fn extend(&mut self, bytes: &[u8], endian: Endian, context: &Context<'_>) -> Result<(), IoError> {
        let needed = self.form.bytes();
        let Some(bytes) = bytes.get(..needed) else {
            return Err(context.truncated("pixels", needed as u64, bytes.len() as u64));
        };
        match &mut self.words {
            Words::One(words) => words.extend_from_slice(bytes),
            Words::Two(words) => words.extend(bytes.chunks_exact(2).map(|b| unsigned(b, endian) as u16)),
            Words::Four(words) => words.extend(bytes.chunks_exact(4).map(|b| unsigned(b, endian))),
        }
        Ok(())
    }

    /// All samples: unused bits are dropped, signs extended.
    pub(super) fn finish(self) -> Samples {
        let Form {
            allocated,
            stored,
            high,
            signed,
            inverted,
            ..
        } = *self.form;
        // To the top of the word and back: the second shift extends the sign.
        let (up, down) = (allocated - 1 - high, allocated - stored);
        macro_rules! samples {
            ($words:expr, $unsigned:ty, $signed:ty, $of_unsigned:path, $of_signed:path) => {
                if signed {
                    let sample = |word: $unsigned| {
                        let sample = ((word << up) as $signed) >> down;
                        if inverted { !sample } else { sample }
                    };
                    $of_signed($words.into_iter().map(sample).collect())
                } else {
                    let mask = <$unsigned>::MAX >> down;
                    let sample = |word: $unsigned| {
                        let sample = (word << up) >> down;
                        if inverted { mask - sample } else { sample }
                    };
                    $of_unsigned($words.into_iter().map(sample).collect())
                }
            };
        }
        match self.words {
            Words::One(words) => samples!(words, u8, i8, Samples::U8, Samples::I8),
            Words::Two(words) => samples!(words, u16, i16, Samples::U16, Samples::I16),
            Words::Four(words) => samples!(words, u32, i32, Samples::U32, Samples::I32),
        }
    }
}

/// Little-endian words of the form's size.
fn widen(samples: Vec<u16>, form: &Form) -> Vec<u8> {
    let size = (form.allocated / 8) as usize;
    let bytes = samples
        .into_iter()
        .flat_map(|sample| u32::from(sample).to_le_bytes().into_iter().take(size));
    bytes.collect()
}

/// Planes of bytes, the highest first, each packed in runs (PS3.5, annex G).
fn rle(coded: &[u8], form: &Form, context: &Context<'_>) -> Result<Vec<u8>, IoError> {
    let word = |i: usize| {
        coded
            .get(i * 4..i * 4 + 4)
            .map(|bytes| unsigned(bytes, Endian::Little) as usize)
    };
    let planes = (form.allocated / 8) as usize;
    if word(0) != Some(planes) {
        let found = word(0).unwrap_or(0);
        return Err(context.field(
            "RLE segments",
            found,
            None,
            format!("{planes}, for {} bits", form.allocated),
        ));
    }
    let mut bytes = vec![0; form.bytes()];
    for plane in 0..planes {
        let start = word(plane + 1).filter(|&start| start >= 64);
        let Some(mut rest) = start.and_then(|start| coded.get(start..)) else {
            let shown = word(plane + 1).unwrap_or(0);
            return Err(context.field("RLE offset", shown, None, "an offset inside the frame"));
        };
        let mut targets = bytes.iter_mut().skip(planes - 1 - plane).step_by(planes);
        let mut left = form.samples();
        while left > 0 {
            let Some((&count, after)) = rest.split_first() else {
                return Err(context.truncated(
                    "RLE samples",
                    form.samples() as u64,
                    (form.samples() - left) as u64,
                ));
            };
            let (count, literal) = match count {
                0..128 => (count as usize + 1, true),
                128 => {
                    rest = after;
                    continue;
                }
                count => (257 - count as usize, false),
            };
            let used = if literal { count } else { 1 };
            let Some((values, after)) = after.split_at_checked(used) else {
                return Err(context.truncated("RLE samples", count as u64, after.len() as u64));
            };
            rest = after;
            let taken = count.min(left);
            for (value, target) in values.iter().cycle().take(taken).zip(&mut targets) {
                *target = *value;
            }
            left -= taken;
        }
    }
    Ok(bytes)
}

fn corrupt(context: &Context<'_>, error: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> IoError {
    context.read(std::io::Error::new(std::io::ErrorKind::InvalidData, error))
}

fn check_size(found: [usize; 2], form: &Form, context: &Context<'_>) -> Result<(), IoError> {
    match found == [form.columns, form.rows] {
        true => Ok(()),
        false => {
            let shown = format!("{} x {}", found[0], found[1]);
            let expected = format!("{} x {}, as the header has it", form.columns, form.rows);
            Err(context.field("size of the compressed image", shown, None, expected))
        }
    }
}

/// Baseline, progressive and lossless JPEG.
fn jpeg(coded: &[u8], form: &Form, context: &Context<'_>) -> Result<Vec<u8>, IoError> {
    let mut decoder = Decoder::new(coded);
    decoder.set_max_decoding_buffer_size(form.samples() * 2);
    decoder.read_info().map_err(|error| corrupt(context, error))?;
    let info = decoder.info().ok_or_else(|| context.truncated("JPEG", 1, 0))?;
    check_size([info.width.into(), info.height.into()], form, context)?;
    let decoded = match info.pixel_format {
        PixelFormat::L8 | PixelFormat::L16 => decoder.decode().map_err(|error| corrupt(context, error))?,
        other => return Err(context.unsupported(format!("JPEG samples of format {other:?}"))),
    };
    let samples = match info.pixel_format {
        PixelFormat::L16 => decoded
            .chunks_exact(2)
            .map(|b| u16::from_ne_bytes([b[0], b[1]]))
            .collect(),
        _ => decoded.into_iter().map(u16::from).collect(),
    };
    Ok(widen(samples, form))
}

/// JPEG 2000 codestreams of one component.
///
/// The decoder treats all samples as unsigned and clips negative ones. A signed component is therefore decoded as an
/// unsigned one, which adds half its range (ISO 15444-1, G.1.2), and the offset is subtracted again.
fn jpeg_2000(coded: &[u8], form: &Form, context: &Context<'_>) -> Result<Vec<u8>, IoError> {
    /// Place of the first component's precision and sign: SOC (2 bytes), then SIZ up to Ssiz (A.5.1).
    const SSIZ: usize = 42;
    let starts = coded.starts_with(&[0xff, 0x4f, 0xff, 0x51]);
    let Some(&precision) = coded.get(SSIZ).filter(|_| starts) else {
        return Err(context.unsupported("JPEG 2000 pixels that are no codestream"));
    };
    let signed = precision & 0x80 != 0;
    let mut stream = coded.to_vec();
    stream[SSIZ] &= 0x7f;
    let image = Image::new(&stream, &DecodeSettings::default()).map_err(|error| corrupt(context, error))?;
    check_size([image.width() as usize, image.height() as usize], form, context)?;
    let bits = u32::from(image.original_bit_depth());
    if !(1..=16).contains(&bits) || image.has_alpha() || image.color_space().num_channels() != 1 {
        return Err(context.unsupported(format!("JPEG 2000 samples of {bits} bits, or of colours")));
    }
    let decoded = image.decode_native().map_err(|error| corrupt(context, error))?;
    let half = if signed { 1u16 << (bits - 1) } else { 0 };
    let samples = match decoded.bytes_per_sample {
        1 => decoded
            .data
            .iter()
            .map(|&b| u16::from(b).wrapping_sub(half))
            .collect(),
        _ => {
            let words = decoded.data.chunks_exact(2);
            words
                .map(|b| u16::from_le_bytes([b[0], b[1]]).wrapping_sub(half))
                .collect()
        }
    };
    Ok(widen(samples, form))
}
