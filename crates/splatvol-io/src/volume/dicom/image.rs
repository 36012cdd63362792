//! Header of a DICOM image: pixel format, series, and position of each frame (PS3.3, C.7.6.2 image plane, C.7.6.3 image
//! pixel, C.11.1 modality LUT; C.7.6.16 functional groups of enhanced images).

use std::path::{Path, PathBuf};

use glam::DVec3;
use splatvol_scene::Rescale;

use super::colors::{Colors, Table};
use super::element::{Dataset, Element, PIXEL_DATA, Tag, Value, name, text, unsigned};
use super::syntax::Syntax;
use crate::IoError;
use crate::error::Context;
use crate::samples::Endian;

/// Fewest bytes of a frame in any coding; the header of run lengths alone has 64.
const LEAST_FRAME: usize = 16;

/// Layout of samples in their words. Images of different layouts do not make one volume.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Form {
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// Samples of a pixel.
    pub(super) components: usize,
    pub(super) colors: Colors,
    /// True where each component has a plane of its own.
    pub(super) planar: bool,
    /// True where the file has a bit for each sample, the first in the lowest bit, and no gap between frames.
    pub(super) packed: bool,
    /// Bits of a word: 8, 16 or 32.
    pub(super) allocated: u32,
    /// Bits of a sample, and the number of its highest.
    pub(super) stored: u32,
    pub(super) high: u32,
    pub(super) signed: bool,
    /// True where low values are bright (MONOCHROME1).
    pub(super) inverted: bool,
}

impl Form {
    pub(super) fn samples(&self) -> usize {
        self.columns * self.rows
    }

    /// Bytes of a decoded frame.
    pub(super) fn bytes(&self) -> usize {
        let sample = self.components * (self.allocated / 8) as usize;
        self.samples().saturating_mul(sample)
    }

    /// Bytes of so many frames that are not compressed.
    pub(super) fn native_bytes(&self, frames: usize) -> usize {
        let samples = self.samples().saturating_mul(frames);
        match self.colors {
            _ if self.packed => samples.div_ceil(8),
            // Two pixels share their chrominances.
            Colors::Ybr422 => self.bytes().saturating_mul(frames) / 3 * 2,
            _ => self.bytes().saturating_mul(frames),
        }
    }

    /// The stored value in a word: unused bits are dropped, the sign extended.
    pub(super) fn value(&self, word: u32) -> i64 {
        let value = i64::from(word >> (self.high + 1 - self.stored)) & ((1 << self.stored) - 1);
        match self.signed && value >> (self.stored - 1) == 1 {
            true => value - (1 << self.stored),
            false => value,
        }
    }
}

/// Identity of a series.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Series {
    pub(super) uid: String,
    pub(super) number: String,
    pub(super) description: String,
}

/// Position of a frame, in the patient's space (LPS, mm), and the meaning of its samples.
#[derive(Debug, Clone, Copy)]
pub(super) struct FrameHead {
    /// Centre of the first sample.
    pub(super) position: Option<DVec3>,
    /// Directions of rows (along x) and columns (along y).
    pub(super) orientation: Option<[DVec3; 2]>,
    /// Between columns (along x) and rows (along y).
    pub(super) spacing: Option<[f64; 2]>,
    pub(super) thickness: Option<f64>,
    pub(super) between_slices: Option<f64>,
    pub(super) rescale: Rescale,
    /// Order if there are no positions, and order in time if there are: position in time, number of
    /// acquisition, number of the image.
    pub(super) order: [i64; 3],
}

/// The header of one file.
#[derive(Debug)]
pub(super) struct ImageHead {
    pub(super) path: PathBuf,
    pub(super) syntax: String,
    /// Whether the elements are coded otherwise than the file says.
    contradicted: bool,
    pub(super) form: Form,
    pub(super) series: Series,
    pub(super) frames: Vec<FrameHead>,
    /// What stored values mean, where no straight line tells it.
    pub(super) lookup_table: Option<Table>,
}

/// Elements with the order of their bytes.
pub(super) struct Elements<'d, 'a, 'c> {
    pub(super) dataset: &'d Dataset<'a>,
    pub(super) endian: Endian,
    pub(super) context: &'c Context<'c>,
}

impl ImageHead {
    /// Oddities of the file that did not prevent reading it.
    pub(super) fn warnings(&self) -> impl Iterator<Item = String> {
        let warnings = [
            (
                self.contradicted,
                "elements lack the representations that the transfer syntax promises",
            ),
            (
                self.form.inverted,
                "MONOCHROME1: samples are turned round, so that high is bright",
            ),
        ];
        let held = warnings.into_iter().filter(|(held, _)| *held);
        held.map(|(_, warning)| warning.to_owned())
    }
}

impl<'a> Elements<'_, 'a, '_> {
    fn unsigned(&self, tag: Tag) -> Option<u32> {
        let bytes = self.dataset.bytes(tag).filter(|bytes| bytes.len() >= 2)?;
        Some(unsigned(&bytes[..2], self.endian))
    }

    /// A whole number that the image must have.
    fn required(&self, tag: Tag, what: &str) -> Result<u32, IoError> {
        self.unsigned(tag).ok_or_else(|| {
            let field = format!("{what} {}", name(tag));
            self.context.field(field, "", None, "a number, which is missing")
        })
    }

    fn text(&self, tag: Tag) -> String {
        self.dataset.bytes(tag).map(text).unwrap_or_default()
    }

    fn integer(&self, tag: Tag) -> Option<i64> {
        self.text(tag).parse().ok()
    }

    /// The frames' pixels as they are in the file.
    pub(super) fn pixels(&self) -> Option<&Element<'a>> {
        self.dataset.get(PIXEL_DATA)
    }

    /// Head of an image, or `None` where the file is DICOM but holds none.
    pub(super) fn image(&self, path: &Path, syntax: &Syntax) -> Result<Option<ImageHead>, IoError> {
        let Some(pixels) = self.pixels() else {
            return Ok(None);
        };
        let form = self.form()?;
        let count = match self.text(0x0028_0008).as_str() {
            "" => 1,
            count => count
                .parse()
                .ok()
                .filter(|&count: &usize| count > 0)
                .ok_or_else(|| {
                    let field = "NumberOfFrames (0028,0008)";
                    self.context.field(field, count, None, "a positive number")
                })?,
        };
        let (what, found, need) = match &pixels.value {
            Value::Pixels(pixels) => ("pixels", pixels.len(), form.native_bytes(count)),
            // The first fragment is the table of offsets. A frame has at least the header of its coding.
            Value::Fragments(fragments) => {
                let bytes: usize = fragments.iter().skip(1).map(ExactSizeIterator::len).sum();
                let need = count.saturating_mul(LEAST_FRAME);
                if bytes < need {
                    return Err(self.context.truncated("frames", need as u64, bytes as u64));
                }
                ("fragments", fragments.len().saturating_sub(1), count)
            }
            Value::Items(_) | Value::Bytes(_) => ("pixels", 0, 1),
        };
        if found < need {
            return Err(self.context.truncated(what, need as u64, found as u64));
        }
        Ok(Some(ImageHead {
            path: path.to_owned(),
            syntax: syntax.name.clone(),
            contradicted: syntax.contradicted,
            form,
            series: Series {
                uid: self.text(0x0020_000e),
                number: self.text(0x0020_0011),
                description: self.text(0x0008_103e),
            },
            frames: self.frames(count)?,
            lookup_table: match self.dataset.items(0x0028_3000).first() {
                Some(item) => Some(self.table(item, 0x0028_3002, 0x0028_3006)?),
                None => None,
            },
        }))
    }

    fn form(&self) -> Result<Form, IoError> {
        let photometric = self.text(0x0028_0004);
        let components = self.unsigned(0x0028_0002).unwrap_or(1);
        let colors = Colors::of(self, &photometric, components)?;
        let rows = self.required(0x0028_0010, "Rows")? as usize;
        let columns = self.required(0x0028_0011, "Columns")? as usize;
        let allocated = self.required(0x0028_0100, "BitsAllocated")?;
        let packed = allocated == 1 && components == 1;
        let allocated = if packed { 8 } else { allocated };
        let stored = self
            .unsigned(0x0028_0101)
            .unwrap_or(if packed { 1 } else { allocated });
        let high = self.unsigned(0x0028_0102).unwrap_or(stored.saturating_sub(1));
        if rows == 0 || columns == 0 {
            let expected = "a positive number of rows and columns";
            return Err(self
                .context
                .field("Rows, Columns", format!("{rows}, {columns}"), None, expected));
        }
        if ![8, 16, 32].contains(&allocated) {
            return Err(self
                .context
                .unsupported(format!("samples of {allocated} bits (BitsAllocated)")));
        }
        if colors == Colors::Ybr422 && columns % 2 == 1 {
            let expected = "an even number, for pixels that share their chrominances";
            return Err(self.context.field("Columns (0028,0011)", columns, None, expected));
        }
        if stored == 0 || high >= allocated || stored > high + 1 {
            let shown = format!("{stored} up to bit {high}");
            let expected = format!("bits that fit into {allocated}");
            return Err(self.context.field("BitsStored, HighBit", shown, None, expected));
        }
        Ok(Form {
            columns,
            rows,
            components: components as usize,
            colors,
            planar: components > 1 && self.unsigned(0x0028_0006) == Some(1),
            packed,
            allocated,
            stored,
            high,
            signed: self.unsigned(0x0028_0103) == Some(1),
            inverted: photometric == "MONOCHROME1",
        })
    }

    /// A look-up table by the tags of its descriptor (number of entries, first value, bits) and of its data.
    pub(super) fn table(&self, dataset: &Dataset<'a>, descriptor: Tag, data: Tag) -> Result<Table, IoError> {
        let numbers = |tag| {
            let words = dataset.bytes(tag).unwrap_or_default().chunks_exact(2);
            words
                .map(|word| unsigned(word, self.endian) as u16)
                .collect::<Vec<_>>()
        };
        let absent = |tag: Tag, expected: &str| self.context.field(name(tag), "", None, expected);
        let [count, first, bits] = numbers(descriptor)[..] else {
            return Err(absent(descriptor, "three numbers of a look-up table"));
        };
        // 0 stands for 65536, which does not fit.
        let count = if count == 0 { 1 << 16 } else { usize::from(count) };
        let mut entries = numbers(data);
        let bytes = dataset.bytes(data).unwrap_or_default();
        if entries.len() < count && bytes.len() >= count {
            // Two entries of 8 bits in a word.
            entries = bytes.iter().map(|&byte| u16::from(byte)).collect();
        }
        if entries.len() < count {
            let found = format!("{} entries", entries.len());
            return Err(self
                .context
                .field(name(data), found, None, format!("{count} entries")));
        }
        entries.truncate(count);
        let signed = self.unsigned(0x0028_0103) == Some(1);
        Ok(Table {
            first: if signed {
                i64::from(first as i16)
            } else {
                i64::from(first)
            },
            bits: u32::from(bits),
            entries,
        })
    }

    fn frames(&self, count: usize) -> Result<Vec<FrameHead>, IoError> {
        let shared = self.dataset.items(0x5200_9229).first();
        let own = self.dataset.items(0x5200_9230);
        (0..count)
            .map(|index| {
                let groups = [own.get(index), shared];
                self.frame(&groups.into_iter().flatten().collect::<Vec<_>>(), index)
            })
            .collect()
    }

    /// `groups` are the functional groups, the frame's own first; plain images have none.
    fn frame(&self, groups: &[&Dataset<'a>], index: usize) -> Result<FrameHead, IoError> {
        let find = |group: Tag, tag: Tag| {
            let grouped = groups
                .iter()
                .find_map(|dataset| dataset.items(group).first()?.bytes(tag));
            grouped.or_else(|| self.dataset.bytes(tag))
        };
        let numbers = |bytes: Option<&[u8]>, count, tag| self.decimals(bytes, count, tag);
        let one = |group, tag| -> Result<Option<f64>, IoError> {
            Ok(numbers(find(group, tag), 1, tag)?.map(|numbers| numbers[0]))
        };
        let vector = |numbers: &[f64]| DVec3::new(numbers[0], numbers[1], numbers[2]);
        let position = numbers(find(0x0020_9113, 0x0020_0032), 3, 0x0020_0032)?;
        let orientation = numbers(find(0x0020_9116, 0x0020_0037), 6, 0x0020_0037)?;
        let mut spacing = numbers(find(0x0028_9110, 0x0028_0030), 2, 0x0028_0030)?;
        if spacing.is_none() {
            spacing = numbers(self.dataset.bytes(0x0018_1164), 2, 0x0018_1164)?;
        }
        let positive = |number: Option<f64>| number.map(f64::abs).filter(|&number| number > 0.0);
        let content = |tag| {
            let dataset = groups.first()?.items(0x0020_9111).first()?;
            dataset
                .bytes(tag)
                .map(|bytes| i64::from(unsigned(&bytes[..bytes.len().min(4)], self.endian)))
        };
        let instance = self.integer(0x0020_0013).unwrap_or(0);
        Ok(FrameHead {
            position: position.map(|numbers| vector(&numbers)),
            orientation: orientation.map(|numbers| [vector(&numbers), vector(&numbers[3..])]),
            spacing: spacing.map(|numbers| [numbers[1], numbers[0]]),
            thickness: positive(one(0x0028_9110, 0x0018_0050)?),
            between_slices: positive(one(0x0028_9110, 0x0018_0088)?),
            rescale: Rescale {
                slope: one(0x0028_9145, 0x0028_1053)?.unwrap_or(1.0),
                intercept: one(0x0028_9145, 0x0028_1052)?.unwrap_or(0.0),
            },
            order: [
                content(0x0020_9128)
                    .or_else(|| self.integer(0x0020_0100))
                    .unwrap_or(0),
                content(0x0020_9156)
                    .or_else(|| self.integer(0x0020_0012))
                    .unwrap_or(0),
                instance.saturating_add(index as i64),
            ],
        })
    }

    /// Decimal strings; `None` where the element is absent or empty.
    fn decimals(&self, bytes: Option<&[u8]>, count: usize, tag: Tag) -> Result<Option<Vec<f64>>, IoError> {
        let text = bytes.map(text).unwrap_or_default();
        if text.is_empty() {
            return Ok(None);
        }
        let numbers: Option<Vec<f64>> = text
            .split('\\')
            .take(count)
            .map(|number| {
                number
                    .trim()
                    .parse()
                    .ok()
                    .filter(|number: &f64| number.is_finite())
            })
            .collect();
        let numbers = numbers.filter(|numbers| numbers.len() == count);
        let expected = || {
            self.context
                .field(name(tag), &text, None, format!("{count} finite numbers"))
        };
        numbers.map(Some).ok_or_else(expected)
    }
}
