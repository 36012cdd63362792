//! Frames from native and encapsulated pixels (PS3.5, section 8 and annexes A.4 and G) to samples.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use hayro_jpeg2000::{DecodeSettings, DecoderContext, Image};
use jpeg_decoder::{ColorTransform, Decoder, PixelFormat};
use splatvol_scene::Samples;

use super::colors::{self, Colors};
use super::contents::Contents;
use super::element::{Value, unsigned};
use super::image::{Elements, Form};
use super::syntax::{Pixels, Syntax};
use super::{jpeg_12, jpeg_ls};
use crate::IoError;
use crate::error::Context;
use crate::samples::Endian;

/// Frames up to this many bytes need no justification: a constant slice is a few bytes in most codings.
const SMALL_FRAME: u64 = 8 << 20;
/// Bytes that one compressed byte may decode to in larger frames.
const RATIO: u64 = 256;

/// Bytes that `compressed` ones may reasonably decode to.
pub(super) fn plausible(compressed: usize) -> u64 {
    SMALL_FRAME.max((compressed as u64).saturating_mul(RATIO))
}

/// Collects frames of one form.
pub(super) struct SliceReader<'a> {
    form: &'a Form,
    /// The channel of coloured pixels that is collected.
    channel: usize,
    words: Words,
    /// Frames of a file often follow each other.
    file: Option<Arc<OpenFile>>,
}

/// Samples as they are stored, in native order.
enum Words {
    One(Vec<u8>),
    Two(Vec<u16>),
    Four(Vec<u32>),
}

/// A file, and where its frames are.
#[derive(Debug)]
pub(super) struct OpenFile {
    path: PathBuf,
    contents: Contents,
    syntax: Syntax,
    /// Byte ranges that make up each frame.
    frames: Vec<Vec<Range<usize>>>,
    /// Bytes that were written as words, the higher one first.
    swapped: Option<Range<usize>>,
}

impl OpenFile {
    fn new(path: &Path, form: &Form, context: &Context<'_>) -> Result<Self, IoError> {
        let located = |contents: &Contents, elements: &Elements<'_, '_, '_>, syntax: &Syntax| {
            let image = elements.image(path, syntax)?;
            let count = image.map_or(0, |image| image.frames.len());
            Ok(match elements.pixels().map(|pixels| &pixels.value) {
                Some(Value::Pixels(native)) => {
                    let frame = |i: usize| {
                        let start = match form.packed {
                            true => i * form.samples() / 8,
                            false => form.native_bytes(i),
                        };
                        native.start + start..native.start + form.native_bytes(i + 1)
                    };
                    // Bytes that are written as words stand in their order (PS3.5, annex A.3). The representation is eight
                    // bytes ahead.
                    let representation = native.start.saturating_sub(8)..native.start.saturating_sub(6);
                    let words = contents.start().get(representation) == Some(b"OW");
                    let is_swapped = words && syntax.endian() == Endian::Big && form.allocated == 8;
                    let frames = (0..count).map(|i| vec![frame(i)]).collect();
                    (frames, is_swapped.then(|| native.clone()))
                }
                Some(Value::Fragments(fragments)) => (frames(fragments, count, contents, context)?, None),
                _ => (Vec::new(), None),
            })
        };
        let (contents, syntax, (frames, swapped)) = Contents::open(path, context, located)?;
        Ok(Self {
            path: path.to_owned(),
            contents,
            syntax,
            frames,
            swapped,
        })
    }

    /// The bytes of a frame, in one piece.
    fn frame(&self, index: usize, context: &Context<'_>) -> Result<Vec<u8>, IoError> {
        let parts = self.frames.get(index).map_or(&[][..], Vec::as_slice);
        let mut coded = Vec::new();
        for part in parts {
            let bytes = match &self.swapped {
                Some(words) => self.of_words(part, words, context)?,
                None => self.contents.read(part.clone(), context)?,
            };
            // Most frames have one part.
            match coded.is_empty() {
                true => coded = bytes,
                false => coded.extend(bytes),
            }
        }
        Ok(coded)
    }

    /// Bytes of words, in their own order.
    fn of_words(
        &self,
        part: &Range<usize>,
        words: &Range<usize>,
        context: &Context<'_>,
    ) -> Result<Vec<u8>, IoError> {
        let before = (part.start - words.start) % 2;
        let after = (part.end - words.start) % 2;
        let whole = part.start - before..(part.end + after).min(words.end);
        let mut bytes = self.contents.read(whole, context)?;
        bytes.chunks_exact_mut(2).for_each(|pair| pair.swap(0, 1));
        bytes.drain(..before);
        bytes.truncate(part.len());
        Ok(bytes)
    }
}

/// Distributes fragments over frames: one frame takes all, else each takes one, else the table of offsets decides.
fn frames(
    fragments: &[Range<usize>],
    count: usize,
    contents: &Contents,
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
    let offsets: Vec<usize> = contents
        .read(table.clone(), context)?
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
    /// `file`: one that is open already.
    pub(super) fn new(form: &'a Form, channel: usize, file: Option<Arc<OpenFile>>) -> Self {
        let words = match bits_of_values(form) {
            8 => Words::One(Vec::new()),
            16 => Words::Two(Vec::new()),
            _ => Words::Four(Vec::new()),
        };
        Self {
            form,
            channel,
            words,
            file,
        }
    }

    /// The file that was read last.
    pub(super) fn take_file(&mut self) -> Option<Arc<OpenFile>> {
        self.file.take()
    }

    /// Adds a frame of a file.
    pub(super) fn append(&mut self, path: &Path, frame: usize) -> Result<(), IoError> {
        let context = &Context::new("DICOM", path);
        let file = match self.file.take().filter(|file| file.path == path) {
            Some(file) => file,
            None => Arc::new(OpenFile::new(path, self.form, context)?),
        };
        let coded = file.frame(frame, context)?;
        self.decode((&coded, frame), &file.syntax, context)?;
        self.file = Some(file);
        Ok(())
    }

    fn decode(
        &mut self,
        (coded, frame): (&[u8], usize),
        syntax: &Syntax,
        context: &Context<'_>,
    ) -> Result<(), IoError> {
        let form = self.form;
        if syntax.pixels == Pixels::Native {
            let needed = form.native_bytes(1);
            let offset = if form.packed {
                frame * form.samples() % 8
            } else {
                0
            };
            if coded.len() < (form.packed as usize * (offset + form.samples()).div_ceil(8)).max(needed) {
                return Err(context.truncated("pixels", needed as u64, coded.len() as u64));
            }
            return match form.colors {
                _ if form.packed => {
                    let bit = |i: usize| coded[(offset + i) / 8] >> ((offset + i) % 8) & 1;
                    let bytes: Vec<u8> = (0..form.samples()).map(bit).collect();
                    self.extend(&bytes, Endian::Little, context)
                }
                Colors::Grey => self.extend(coded, syntax.endian(), context),
                _ => self.extend_colored(&colors::interleaved(coded, form, syntax.endian()), context),
            };
        }
        let needed = form.bytes();
        if needed as u64 > plausible(coded.len()) {
            return Err(context.too_small("pixels", needed as u64, plausible(coded.len())));
        }
        if form.packed {
            return Err(context.unsupported("samples of one bit that are compressed"));
        }
        let bytes = match syntax.pixels {
            Pixels::Rle => rle(coded, form, context)?,
            Pixels::Jpeg => jpeg(coded, form, context)?,
            Pixels::JpegLs => {
                let samples = jpeg_ls::decode(coded, [form.columns, form.rows, form.components], context)?;
                widen(samples, form, context)?
            }
            Pixels::Jpeg2000 => jpeg_2000(coded, form, context)?,
            Pixels::Native | Pixels::Unknown => {
                return Err(context.unsupported(format!("pixels are coded as {}", syntax.name)));
            }
        };
        match form.colors {
            Colors::Grey => self.extend(&bytes, Endian::Little, context),
            _ => self.extend_colored(&bytes, context),
        }
    }

    /// Adds the chosen channel of decoded pixels, which are interleaved words.
    fn extend_colored(&mut self, pixels: &[u8], context: &Context<'_>) -> Result<(), IoError> {
        let needed = self.form.bytes();
        let Some(pixels) = pixels.get(..needed) else {
            return Err(context.truncated("pixels", needed as u64, pixels.len() as u64));
        };
        let channel = colors::channel(pixels, self.form, self.channel);
        self.extend(&channel, Endian::Little, context)
    }

    fn extend(&mut self, bytes: &[u8], endian: Endian, context: &Context<'_>) -> Result<(), IoError> {
        let needed = self.form.samples() * (bits_of_values(self.form) / 8) as usize;
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
        if let Colors::Palette(_) = self.form.colors {
            return match self.words {
                Words::One(words) => Samples::U8(words.into()),
                Words::Two(words) => Samples::U16(words.into()),
                Words::Four(words) => Samples::U32(words.into()),
            };
        }
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

/// Bits of the words that are collected.
fn bits_of_values(form: &Form) -> u32 {
    match &form.colors {
        Colors::Palette(palette) => palette.bits,
        _ => form.allocated,
    }
}

/// Little-endian words of the form's size, into which all samples must fit.
fn widen(samples: Vec<u16>, form: &Form, context: &Context<'_>) -> Result<Vec<u8>, IoError> {
    let size = (form.allocated / 8) as usize;
    // Decoders give negative samples as codes of 8 bits or as words.
    let fits =
        |&sample: &u16| sample <= u16::from(u8::MAX) || form.signed && i8::try_from(sample as i16).is_ok();
    if let Some(sample) = samples.iter().find(|sample| size == 1 && !fits(sample)) {
        let expected = "BitsAllocated (0028,0100) = 16 for such samples, not 8";
        return Err(context.field("compressed sample", sample, None, expected));
    }
    let bytes = samples
        .into_iter()
        .flat_map(|sample| u32::from(sample).to_le_bytes().into_iter().take(size));
    Ok(bytes.collect())
}

/// Planes of bytes, the highest first, each packed in runs (PS3.5, annex G).
fn rle(coded: &[u8], form: &Form, context: &Context<'_>) -> Result<Vec<u8>, IoError> {
    let word = |i: usize| {
        coded
            .get(i * 4..i * 4 + 4)
            .map(|bytes| unsigned(bytes, Endian::Little) as usize)
    };
    let word_size = (form.allocated / 8) as usize;
    let planes = word_size * form.components;
    if word(0) != Some(planes) {
        let found = word(0).unwrap_or(0);
        return Err(context.field(
            "RLE segments",
            found,
            None,
            format!(
                "{planes}, for {} samples of {} bits",
                form.components, form.allocated
            ),
        ));
    }
    let mut bytes = vec![0; form.bytes()];
    for plane in 0..planes {
        let start = word(plane + 1).filter(|&start| start >= 64);
        let Some(mut rest) = start.and_then(|start| coded.get(start..)) else {
            let shown = word(plane + 1).unwrap_or(0);
            return Err(context.field("RLE offset", shown, None, "an offset inside the frame"));
        };
        // Component by component, the highest byte of each first.
        let (component, byte) = (plane / word_size, plane % word_size);
        let place = component * word_size + word_size - 1 - byte;
        let mut targets = bytes.iter_mut().skip(place).step_by(planes);
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

/// Baseline, extended, progressive and lossless JPEG. Coloured pixels become red, green and blue where the file says that they are, and
/// stay as they are otherwise.
fn jpeg(coded: &[u8], form: &Form, context: &Context<'_>) -> Result<Vec<u8>, IoError> {
    if jpeg_12::is_12_bit(coded) && form.components == 1 {
        let samples = jpeg_12::decode(coded, [form.columns, form.rows], context)?;
        return widen(samples, form, context);
    }
    let mut decoder = Decoder::new(coded);
    decoder.set_max_decoding_buffer_size(form.samples() * 2 * form.components);
    if form.components == 3 {
        decoder.set_color_transform(match (&form.colors, marked_ybr(coded)) {
            (Colors::Rgb, Some(true)) => ColorTransform::YCbCr,
            // As they are: `None` would give one component after the other.
            _ => ColorTransform::RGB,
        });
    }
    decoder.read_info().map_err(|error| corrupt(context, error))?;
    let info = decoder.info().ok_or_else(|| context.truncated("JPEG", 1, 0))?;
    check_size([info.width.into(), info.height.into()], form, context)?;
    let decoded = match (info.pixel_format, form.components) {
        (PixelFormat::L8 | PixelFormat::L16, 1) | (PixelFormat::RGB24, 3) => {
            crate::jpeg::decode(&mut decoder, context)?
        }
        (other, _) => return Err(context.unsupported(format!("JPEG samples of format {other:?}"))),
    };
    let samples = match info.pixel_format {
        PixelFormat::L16 => decoded
            .chunks_exact(2)
            .map(|b| u16::from_ne_bytes([b[0], b[1]]))
            .collect(),
        _ => decoded.into_iter().map(u16::from).collect(),
    };
    widen(samples, form, context)
}

/// Whether the markers of a JPEG say that it holds luminance and chrominance; `None` where they say nothing. Some writers call
/// the colours RGB that a decoder makes of it.
fn marked_ybr(coded: &[u8]) -> Option<bool> {
    let mut rest = coded.get(2..)?;
    while let [0xff, marker, high, low, ..] = *rest {
        let length = usize::from(u16::from_be_bytes([high, low]));
        let body = rest.get(4..2 + length)?;
        match (marker, body) {
            (0xe0, [b'J', b'F', b'I', b'F', ..]) => return Some(true),
            (0xee, [b'A', b'd', b'o', b'b', b'e', ..]) => {
                return Some(body.get(11).is_some_and(|&kind| kind == 1));
            }
            // A frame or a scan: no more markers of applications.
            (0xc0..=0xc3 | 0xda, _) => return None,
            _ => rest = rest.get(2 + length..)?,
        }
    }
    None
}

/// The codestream in a JP2 file (ISO 15444-1, annex I), which some writers store whole; others stay as they are.
fn codestream(coded: &[u8]) -> &[u8] {
    const SIGNATURE: &[u8] = b"\0\0\0\x0cjP  ";
    let mut rest = coded;
    while let (true, [a, b, c, d, kind @ ..]) = (coded.starts_with(SIGNATURE), rest) {
        let length = match u32::from_be_bytes([*a, *b, *c, *d]) as usize {
            // The last box ends with the file.
            0 => rest.len(),
            length => length,
        };
        if kind.starts_with(b"jp2c") {
            return rest.get(8..length).unwrap_or(coded);
        }
        match rest.get(length.max(8)..) {
            Some(next) => rest = next,
            None => break,
        }
    }
    coded
}

/// JPEG 2000 codestreams. Bits that were cut off are put in the middle of their interval (ISO 15444-1, E.1.1.2: r = 0.5), as
/// other decoders do.
fn jpeg_2000(coded: &[u8], form: &Form, context: &Context<'_>) -> Result<Vec<u8>, IoError> {
    /// Place of the first component's precision and sign: SOC (2 bytes), then SIZ up to Ssiz (A.5.1).
    const SSIZ: usize = 42;
    let coded = codestream(coded);
    let starts = coded.starts_with(&[0xff, 0x4f, 0xff, 0x51]);
    let Some(&precision) = coded.get(SSIZ).filter(|_| starts) else {
        return Err(context.unsupported("JPEG 2000 pixels that are no codestream"));
    };
    let image = Image::new(coded, &DecodeSettings::default()).map_err(|error| corrupt(context, error))?;
    check_size([image.width() as usize, image.height() as usize], form, context)?;
    let bits = u32::from(image.original_bit_depth());
    let components = usize::from(image.color_space().num_channels());
    if !(1..=16).contains(&bits) || image.has_alpha() || components != form.components {
        return Err(context.unsupported(format!("JPEG 2000 samples of {bits} bits, or of colours")));
    }
    let mut memory = DecoderContext::default();
    let decoded = image
        .decode(&mut memory)
        .map_err(|error| corrupt(context, error))?;
    // The decoder adds half the range to signed samples, too (G.1.2).
    let half = if precision & 0x80 != 0 {
        1u16 << (bits - 1)
    } else {
        0
    };
    let largest = ((1u32 << bits) - 1) as f32;
    let sample = |value: f32| (value.round().clamp(0.0, largest) as u16).wrapping_sub(half);
    let planes = decoded.components();
    let short = planes
        .iter()
        .map(|plane| plane.samples().len())
        .min()
        .unwrap_or(0);
    if planes.len() != components || short < form.samples() {
        return Err(context.truncated("JPEG 2000 samples", form.samples() as u64, short as u64));
    }
    let pixels = (0..form.samples()).flat_map(|pixel| planes.iter().map(move |plane| plane.samples()[pixel]));
    widen(pixels.map(sample).collect(), form, context)
}
