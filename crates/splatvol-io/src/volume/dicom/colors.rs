//! Colours (PS3.3, C.7.6.3.1): RGB, luminance and chrominance, and palettes. All become red, green and blue, of which one
//! channel is the volume's.

use super::element::unsigned;
use super::image::{Elements, Form};
use crate::IoError;
use crate::samples::Endian;

/// Meaning of the samples of a pixel (`PhotometricInterpretation`).
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Colors {
    /// One sample, grey.
    Grey,
    Rgb,
    /// Luminance and two chrominances for each pixel.
    Ybr,
    /// Two luminances, then two chrominances, for each pair of pixels.
    Ybr422,
    /// One sample, a place in tables.
    Palette(Palette),
}

impl Colors {
    /// True where there is a channel to choose.
    pub(super) fn is_colored(&self) -> bool {
        *self != Self::Grey
    }

    /// The coding of a photometric interpretation with so many samples per pixel.
    pub(super) fn of(elements: &Elements<'_, '_, '_>, name: &str, components: u32) -> Result<Self, IoError> {
        match (name, components) {
            ("PALETTE COLOR", 1) => Palette::of(elements).map(Self::Palette),
            (_, 1) => Ok(Self::Grey),
            ("RGB", 3) => Ok(Self::Rgb),
            // The codec takes care of what JPEG 2000 transforms.
            ("YBR_RCT" | "YBR_ICT", 3) => Ok(Self::Rgb),
            ("YBR_FULL", 3) => Ok(Self::Ybr),
            ("YBR_FULL_422", 3) => Ok(Self::Ybr422),
            _ => Err(elements.context.unsupported(format!(
                "pixels of {components} samples as {name}; grey values, RGB, YBR_FULL and palettes are read"
            ))),
        }
    }
}

/// Red, green and blue of each stored value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Palette {
    /// The stored value of the first entry.
    first: i64,
    /// Bits of an entry: 8 or 16.
    pub(super) bits: u32,
    entries: [Vec<u16>; 3],
}

impl Palette {
    fn of(elements: &Elements<'_, '_, '_>) -> Result<Self, IoError> {
        let mut first = 0;
        let mut bits = 16;
        let mut entries = [Vec::new(), Vec::new(), Vec::new()];
        for (channel, entries) in entries.iter_mut().enumerate() {
            let tag = 0x0028_1101 + channel as u32;
            let table = elements.table(elements.dataset, tag, tag + 0x100)?;
            (first, bits) = (table.first, if table.bits <= 8 { 8 } else { 16 });
            *entries = table.entries;
        }
        Ok(Self { first, bits, entries })
    }

    /// A channel of the entry for a stored value; the first or last one outside the table.
    pub(super) fn look_up(&self, value: i64, channel: usize) -> u16 {
        let entries = &self.entries[channel];
        let place = (value - self.first).clamp(0, entries.len() as i64 - 1);
        entries.get(place as usize).copied().unwrap_or(0)
    }
}

/// A look-up table (PS3.3, C.11.1.1): the values for stored ones from `first` on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Table {
    pub(super) first: i64,
    pub(super) bits: u32,
    pub(super) entries: Vec<u16>,
}

impl Table {
    /// The entry for a stored value; the first or last one outside the table.
    pub(super) fn look_up(&self, value: i64) -> u16 {
        let place = (value - self.first).clamp(0, self.entries.len() as i64 - 1);
        self.entries.get(place as usize).copied().unwrap_or(0)
    }
}

/// One channel of pixels that lie in little-endian words of the form's size, sample by sample.
pub(super) fn channel(words: &[u8], form: &Form, channel: usize) -> Vec<u8> {
    let size = (form.allocated / 8) as usize;
    let read = |word: &[u8]| i64::from(unsigned(word, Endian::Little));
    let write = |value: i64| (value as u32).to_le_bytes().into_iter().take(size);
    match &form.colors {
        Colors::Palette(palette) => {
            let stored = |word: &[u8]| form.value(unsigned(word, Endian::Little));
            let bytes = (palette.bits / 8) as usize;
            let entries = words
                .chunks_exact(size)
                .map(|word| palette.look_up(stored(word), channel));
            entries
                .flat_map(|entry| entry.to_le_bytes().into_iter().take(bytes))
                .collect()
        }
        Colors::Ybr | Colors::Ybr422 => {
            let pixels = words.chunks_exact(3 * size);
            let top = 1i64 << form.stored;
            let color = |pixel: &[u8]| {
                let [y, b, r] = [0, 1, 2].map(|i| read(&pixel[i * size..(i + 1) * size]));
                from_ybr([y as f64, (b - top / 2) as f64, (r - top / 2) as f64])[channel]
                    .round()
                    .clamp(0.0, (top - 1) as f64) as i64
            };
            pixels.flat_map(|pixel| write(color(pixel))).collect()
        }
        Colors::Rgb | Colors::Grey => {
            let words = words.chunks_exact(size);
            words.skip(channel).step_by(3).flatten().copied().collect()
        }
    }
}

/// PS3.3, C.7.6.3.1.2, solved for the colours.
fn from_ybr([y, b, r]: [f64; 3]) -> [f64; 3] {
    [y + 1.402 * r, y - 0.344_136 * b - 0.714_136 * r, y + 1.772 * b]
}

/// Native pixels in the order of [`channel`]: planes are interleaved, shared chrominances repeated, words turned round.
pub(super) fn interleaved(native: &[u8], form: &Form, endian: Endian) -> Vec<u8> {
    let size = (form.allocated / 8) as usize;
    let samples = form.samples();
    let word = |index: usize| &native[index * size..(index + 1) * size];
    let mut words = Vec::with_capacity(samples * form.components * size);
    for pixel in 0..samples {
        for component in 0..form.components {
            let index = match (&form.colors, component) {
                (Colors::Ybr422, 0) => pixel / 2 * 4 + pixel % 2,
                (Colors::Ybr422, _) => pixel / 2 * 4 + 1 + component,
                _ if form.planar => component * samples + pixel,
                _ => pixel * form.components + component,
            };
            let start = words.len();
            words.extend_from_slice(word(index));
            if endian == Endian::Big {
                words[start..].reverse();
            }
        }
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn luminance_and_chrominance_become_colours() {
        // The primaries of PS3.3's equation.
        for (ybr, rgb) in [
            ([76.245, -43.029, 127.5], [255.0, 0.0, 0.0]),
            ([149.685, -84.471, -106.769], [0.0, 255.0, 0.0]),
            ([255.0, 0.0, 0.0], [255.0; 3]),
        ] {
            let found = from_ybr(ybr);
            assert!(
                found.iter().zip(rgb).all(|(a, b)| (a - b).abs() < 0.01),
                "{found:?}"
            );
        }
    }

    #[test]
    fn values_outside_a_table_are_those_of_its_ends() {
        let table = Table {
            first: -2,
            bits: 8,
            entries: vec![5, 6, 7],
        };
        assert_eq!(
            [-9, -2, -1, 0, 9].map(|value| table.look_up(value)),
            [5, 5, 6, 7, 7]
        );
    }
}
