//! The layouts of PLOT3D's files, told apart by arithmetic on dimensions and length.

use std::cmp::Ordering;

use crate::error::Context;
use crate::{Endian, IoError};

/// More points along an axis are not believed.
const MOST: i32 = 1 << 24;
/// More grids are not believed.
const MOST_GRIDS: i32 = 1 << 16;

/// A file may be too long or too short by this part of its length.
const SLACK: u64 = 64;

/// Kind of file: grid or solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Content {
    /// x, y and, unless the grid is plane, z; and perhaps IBLANK.
    Grid,
    /// Four numbers of the flow, and five variables; four on a plane, whose momentum lies in it.
    Solution,
}

/// Layout of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Layout {
    pub(super) endian: Endian,
    /// True where every record stands between two counts of its bytes, as Fortran writes unformatted files.
    pub(super) records: bool,
    /// True where a number of grids comes first.
    pub(super) several: bool,
    /// True for two dimensions and coordinates instead of three.
    pub(super) plane: bool,
    /// True where the file was text, and its numbers are given here in big-endian order.
    pub(super) text: bool,
    /// True for 64-bit reals.
    pub(super) wide: bool,
    /// True where an integer per point follows the coordinates.
    pub(super) blanked: bool,
    pub(super) blocks: Vec<[usize; 3]>,
    /// Bytes of all blocks before each one.
    pub(super) before: Vec<u64>,
}

impl Layout {
    /// The layout of a whole file.
    ///
    /// Where none fits exactly, the one that fits best is taken if few bytes are missing or too many, with a warning.
    pub(super) fn of(
        bytes: &[u8],
        content: Content,
        context: &Context<'_>,
    ) -> Result<(Self, Option<String>), IoError> {
        let length = bytes.len() as u64;
        let layout = Self::near(bytes, length, content).ok_or_else(|| {
            let found = format!("{} bytes", bytes.len());
            let what = match content {
                Content::Grid => "x, y, z (or x, y) and perhaps IBLANK of the grids' dimensions",
                Content::Solution => "4 and 5 n numbers (or 4 and 4 n) of the grids' dimensions",
            };
            context.field(
                "length",
                found,
                None,
                format!("{what}, in either byte order and precision"),
            )
        })?;
        let needed = layout.length(content).unwrap_or(length);
        let warning = match needed.cmp(&length) {
            Ordering::Equal => None,
            Ordering::Less => Some(format!(
                "{} more bytes than the dimensions ask for",
                length - needed
            )),
            Ordering::Greater => Some(format!("{} bytes are missing at the end", needed - length)),
        };
        Ok((layout, warning))
    }

    /// The layout for which a file of `length` bytes is neither too long nor too short.
    pub(super) fn find(start: &[u8], length: u64, content: Content) -> Option<Self> {
        let mut layouts = Self::all(start, content);
        layouts.find(|layout| layout.length(content) == Some(length))
    }

    /// The layout that misses `length` by the fewest bytes, and by no more than a part of it; flat grids by none, because two
    /// dimensions fit too much.
    pub(super) fn near(start: &[u8], length: u64, content: Content) -> Option<Self> {
        let misses = |layout: &Self| {
            let needed = layout.length(content)?;
            let slack = if layout.is_flat() { 0 } else { length / SLACK };
            Some(needed.abs_diff(length)).filter(|missed| *missed <= slack)
        };
        let layouts = Self::all(start, content).filter_map(|layout| Some((misses(&layout)?, layout)));
        layouts
            .min_by_key(|(missed, _)| *missed)
            .map(|(_, layout)| layout)
    }

    /// The layouts whose dimensions can be read.
    fn all(start: &[u8], content: Content) -> impl Iterator<Item = Self> {
        let choices = (0..64u8).map(|bits| [0, 1, 2, 3, 4, 5].map(|bit| bits >> bit & 1 == 1));
        choices
            .filter(move |&[.., blanked, _]| !blanked || content == Content::Grid)
            .filter_map(move |[little, records, several, wide, blanked, plane]| {
                let layout = Self {
                    endian: if little { Endian::Little } else { Endian::Big },
                    records,
                    several,
                    plane,
                    text: false,
                    wide,
                    blanked,
                    blocks: Vec::new(),
                    before: Vec::new(),
                };
                layout.with_blocks(start)?.with_places(content)
            })
    }

    /// True where a grid has one point along an axis, or no such axis.
    pub(super) fn is_flat(&self) -> bool {
        self.blocks.iter().flatten().any(|&size| size == 1)
    }

    /// Coordinates of a point.
    pub(super) fn axes(&self) -> usize {
        if self.plane { 2 } else { 3 }
    }

    /// Variables of a solution: density, momentum, energy.
    pub(super) fn variables(&self) -> usize {
        2 + self.axes()
    }

    /// Reads the dimensions.
    pub(super) fn with_blocks(mut self, start: &[u8]) -> Option<Self> {
        let mark =
            |at: usize, bytes: usize| !self.records || self.try_integer(start, at) == Some(bytes as i32);
        let margin = self.margin();
        let mut grids = 1;
        if self.several {
            grids = self
                .try_integer(start, margin)
                .filter(|n| (1..=MOST_GRIDS).contains(n))? as usize;
            if !mark(0, 4) || !mark(margin + 4, 4) {
                return None;
            }
        }
        let head = self.head();
        let axes = self.axes();
        if !mark(head, 4 * axes * grids) || start.len() < head + 4 * axes * grids {
            return None;
        }
        let size = |index: usize| {
            let size = self.try_integer(start, head + margin + 4 * index)?;
            (1..=MOST).contains(&size).then_some(size as usize)
        };
        let block = |grid: usize| {
            let mut block = [1; 3];
            for (axis, place) in block.iter_mut().enumerate().take(axes) {
                *place = size(axes * grid + axis)?;
            }
            // A line of points has no layer.
            (block.iter().filter(|&&size| size > 1).count() > 1).then_some(block)
        };
        self.blocks = (0..grids).map(block).collect::<Option<_>>()?;
        Some(self)
    }

    /// Bytes before and after a record.
    fn margin(&self) -> usize {
        if self.records { 4 } else { 0 }
    }

    /// Bytes of the record that counts the grids.
    fn head(&self) -> usize {
        if self.several { 4 + 2 * self.margin() } else { 0 }
    }

    /// Bytes of a real number.
    pub(super) fn real_size(&self) -> usize {
        if self.wide { 8 } else { 4 }
    }

    /// Points of a block.
    pub(super) fn points(&self, block: usize) -> usize {
        self.blocks[block].iter().product()
    }

    /// Bytes of a block's records with their marks; `None` if they cannot be counted.
    fn block_length(&self, block: usize, content: Content) -> Option<u64> {
        let points = self.blocks[block]
            .iter()
            .try_fold(1u64, |n, &size| n.checked_mul(size as u64))?;
        let (real, margin) = (self.real_size() as u64, self.margin() as u64);
        let (axes, variables) = (self.axes() as u64, self.variables() as u64);
        match content {
            Content::Grid => {
                let blanks = if self.blanked { 4 } else { 0 };
                points.checked_mul(axes * real + blanks)?.checked_add(2 * margin)
            }
            Content::Solution => points
                .checked_mul(variables * real)?
                .checked_add(4 * real + 4 * margin),
        }
    }

    fn blocks_start(&self) -> usize {
        self.head() + 4 * self.axes() * self.blocks.len() + 2 * self.margin()
    }

    /// Adds up the lengths of the blocks.
    pub(super) fn with_places(mut self, content: Content) -> Option<Self> {
        let mut sum = 0u64;
        for block in 0..self.blocks.len() {
            self.before.push(sum);
            sum = sum.checked_add(self.block_length(block, content)?)?;
        }
        Some(self)
    }

    pub(super) fn length(&self, content: Content) -> Option<u64> {
        let last = self.blocks.len().checked_sub(1)?;
        let blocks = self.before[last].checked_add(self.block_length(last, content)?)?;
        blocks.checked_add(self.blocks_start() as u64)
    }

    /// Offset of a block's arrays, in a file whose length has been checked.
    pub(super) fn start(&self, block: usize, content: Content) -> usize {
        let flow = match content {
            Content::Grid => 0,
            Content::Solution => 4 * self.real_size() + 2 * self.margin(),
        };
        self.blocks_start() + self.before[block] as usize + flow + self.margin()
    }

    /// Real number `index` after `start`; NaN past the end.
    pub(super) fn real(&self, bytes: &[u8], start: usize, index: usize) -> f64 {
        let at = start + index * self.real_size();
        match self.wide {
            true => self.word::<8>(bytes, at).map_or(f64::NAN, f64::from_be_bytes),
            false => self
                .word::<4>(bytes, at)
                .map_or(f64::NAN, |word| f32::from_be_bytes(word).into()),
        }
    }

    /// The integer at a byte; 0 past the end.
    pub(super) fn integer(&self, bytes: &[u8], at: usize) -> i32 {
        self.try_integer(bytes, at).unwrap_or(0)
    }

    fn try_integer(&self, bytes: &[u8], at: usize) -> Option<i32> {
        self.word::<4>(bytes, at).map(i32::from_be_bytes)
    }

    /// Bytes in big-endian order.
    fn word<const N: usize>(&self, bytes: &[u8], at: usize) -> Option<[u8; N]> {
        let mut word: [u8; N] = bytes.get(at..at.checked_add(N)?)?.try_into().ok()?;
        if self.endian == Endian::Little {
            word.reverse();
        }
        Some(word)
    }
}
