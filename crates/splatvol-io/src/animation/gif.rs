//! GIF 89a: at most 256 colours per frame, pixels opaque or not.
//!
//! A frame of few colours keeps them. Otherwise its most frequent colour, which is the background's, keeps its own
//! entry, so that it does not flicker from frame to frame; the others are chosen by `NeuQuant` (Dekker, *Kohonen neural
//! networks for optimal colour quantization*, Network 5, 1994). A pixel at least half opaque is opaque.

use std::cmp::Reverse;
use std::collections::HashMap;
use std::io::Write;

use ::gif::{DisposalMethod, Encoder, EncodingError, Frame, Repeat};
use color_quant::NeuQuant;
use splatvol_scene::Image;

use super::{AnimationSettings, refused};
use crate::IoError;
use crate::image::png;

const FORMAT: &str = "GIF";
/// Entries of a palette.
const ENTRIES: usize = 256;
/// Number of pixels that `NeuQuant` learns from, approximately; it uses at least one in 10. With fewer the palette is
/// poor, more take long.
const LESSONS: usize = 100_000;

/// Writes a GIF.
pub struct GifWriter<W: Write> {
    settings: AnimationSettings,
    encoder: Encoder<W>,
    written: u32,
}

impl<W: Write> GifWriter<W> {
    /// Begins a file.
    ///
    /// # Errors
    /// [`IoError::Encode`]: no frames, less than 0.01 or more than 50 frames per second (programs slow faster ones
    /// down), sides beyond 65535 pixels, or what the sink says.
    pub fn new(sink: W, settings: AnimationSettings) -> Result<Self, IoError> {
        settings.check(FORMAT, [0.01, 50.0])?;
        let side = |pixels: u32| {
            u16::try_from(pixels)
                .map_err(|_| refused(FORMAT, format!("a side of {pixels} pixels exceeds 65535")))
        };
        let (width, height) = (side(settings.size.width())?, side(settings.size.height())?);
        let begin = || {
            let mut encoder = Encoder::new(sink, width, height, &[])?;
            encoder.set_repeat(Repeat::Infinite)?;
            Ok(encoder)
        };
        let encoder = begin().map_err(|error: EncodingError| refused(FORMAT, error))?;
        Ok(Self {
            settings,
            encoder,
            written: 0,
        })
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// [`IoError::Encode`]: a frame of another size, more frames than announced, or an error of the sink.
    pub fn write(&mut self, image: &Image) -> Result<(), IoError> {
        self.settings.check_frame(FORMAT, image, self.written)?;
        let indexed = Indexed::new(&png::srgb8(image));
        let frame = Frame {
            delay: self.delay(),
            // Transparent pixels would let the previous frame show.
            dispose: if self.settings.alpha {
                DisposalMethod::Background
            } else {
                DisposalMethod::Keep
            },
            transparent: indexed.transparent,
            width: image.size().width() as u16,
            height: image.size().height() as u16,
            palette: Some(indexed.palette),
            buffer: indexed.indices.into(),
            ..Frame::default()
        };
        self.encoder
            .write_frame(&frame)
            .map_err(|error| refused(FORMAT, error))?;
        self.written += 1;
        Ok(())
    }

    /// Ends the file.
    ///
    /// # Errors
    /// [`IoError::Encode`]: fewer frames than announced, or an error of the sink.
    pub fn finish(self) -> Result<(), IoError> {
        if self.written != self.settings.frames {
            let what = format!("{} frames of {}", self.written, self.settings.frames);
            return Err(refused(FORMAT, what));
        }
        let ended = self.encoder.into_inner();
        let mut sink = ended.map_err(|error| refused(FORMAT, error))?;
        sink.flush().map_err(|error| refused(FORMAT, error))
    }

    /// Delay of the next frame, 1/100 s: the difference of rounded times, so that the animation ends on time.
    fn delay(&self) -> u16 {
        let end = |frame: u32| (100.0 * f64::from(frame) / self.settings.fps).round();
        (end(self.written + 1) - end(self.written)) as u16
    }
}

/// A frame as indices into a palette.
struct Indexed {
    /// Red, green, blue of every entry.
    palette: Vec<u8>,
    indices: Vec<u8>,
    /// The entry that shows nothing.
    transparent: Option<u8>,
}

impl Indexed {
    fn new(codes: &[[u8; 4]]) -> Self {
        let opaque = |code: &&[u8; 4]| code[3] >= 128;
        let color = |&[r, g, b, _]: &[u8; 4]| [r, g, b];
        let mut counts: HashMap<[u8; 3], u32> = HashMap::new();
        for code in codes.iter().filter(opaque) {
            *counts.entry(color(code)).or_default() += 1;
        }
        // The last entry, so that a palette begins with its colours.
        let is_clear = codes.iter().any(|code| !opaque(&code));
        let entries = ENTRIES - usize::from(is_clear);
        let (mut palette, index_of) = if counts.len() <= entries {
            exact(&counts)
        } else {
            chosen(codes.iter().filter(opaque).map(color), &counts, entries)
        };
        let clear = palette.len() as u8;
        if is_clear {
            palette.push([0; 3]);
        }
        let index = |code: &[u8; 4]| {
            if opaque(&code) {
                index_of[&color(code)]
            } else {
                clear
            }
        };
        Self {
            indices: codes.iter().map(index).collect(),
            palette: palette.concat(),
            transparent: is_clear.then_some(clear),
        }
    }
}

type Palette = (Vec<[u8; 3]>, HashMap<[u8; 3], u8>);

/// All colours, in ascending order.
fn exact(counts: &HashMap<[u8; 3], u32>) -> Palette {
    let mut palette: Vec<[u8; 3]> = counts.keys().copied().collect();
    palette.sort_unstable();
    let index_of = palette
        .iter()
        .zip(0..=u8::MAX)
        .map(|(&color, i)| (color, i))
        .collect();
    (palette, index_of)
}

/// The most frequent colour, and what `NeuQuant` makes of the others.
fn chosen(colors: impl Iterator<Item = [u8; 3]>, counts: &HashMap<[u8; 3], u32>, entries: usize) -> Palette {
    let most = counts
        .iter()
        .max_by_key(|&(color, count)| (count, Reverse(color)));
    let frequent = most.map_or([0; 3], |(color, _)| *color);
    let others: Vec<u8> = colors
        .filter(|color| *color != frequent)
        .flat_map(|[r, g, b]| [r, g, b, 255])
        .collect();
    let sampling = (others.len() / 4 / LESSONS).clamp(1, 10) as i32;
    let quantised = NeuQuant::new(sampling, entries - 1, &others);
    let mut palette = vec![frequent];
    palette.extend(
        quantised
            .color_map_rgb()
            .chunks_exact(3)
            .map(|c| [c[0], c[1], c[2]]),
    );
    let index = |&color: &[u8; 3]| {
        let [r, g, b] = color;
        let index = if color == frequent {
            0
        } else {
            1 + quantised.index_of(&[r, g, b, 255]) as u8
        };
        (color, index)
    };
    (palette, counts.keys().map(index).collect())
}
