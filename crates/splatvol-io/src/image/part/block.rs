//! Blocks of a picture, and the keys by which parts are asked for.

use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use splatvol_scene::ImageSize;

/// A block of pixels: a rectangle of a picture, written `X,Y,WIDTHxHEIGHT`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct PictureBlock {
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl PictureBlock {
    /// A picture's blocks of `edge` pixels, those at its right and lower ends smaller, row by row.
    pub fn all(size: ImageSize, edge: u32) -> Vec<Self> {
        let edge = edge.max(1);
        let starts = |length: u32| (0..length).step_by(edge as usize);
        let block = |x, y| Self {
            x,
            y,
            width: edge.min(size.width() - x),
            height: edge.min(size.height() - y),
        };
        starts(size.height())
            .flat_map(|y| starts(size.width()).map(move |x| block(x, y)))
            .collect()
    }

    /// Block `index` of `count` blocks of about the same size, as square as the number allows; `None` where the picture
    /// has no so many.
    pub fn of(size: ImageSize, index: u32, count: u32) -> Option<Self> {
        let columns = (1..=count)
            .rev()
            .find(|n| u64::from(*n).pow(2) <= u64::from(count) && count.is_multiple_of(*n))?;
        let rows = count / columns;
        let (columns, rows) = match size.width() > size.height() {
            true => (columns.max(rows), columns.min(rows)),
            false => (columns.min(rows), columns.max(rows)),
        };
        if index >= count || columns > size.width() || rows > size.height() {
            return None;
        }
        let ends = |length: u32, count: u32, at: u32| {
            let end = |at: u32| (u64::from(length) * u64::from(at) / u64::from(count)) as u32;
            [end(at), end(at + 1)]
        };
        let [x, x1] = ends(size.width(), columns, index % columns);
        let [y, y1] = ends(size.height(), rows, index / columns);
        Some(Self {
            x,
            y,
            width: x1 - x,
            height: y1 - y,
        })
    }

    /// Whether it lies within a picture.
    pub fn fits(&self, size: ImageSize) -> bool {
        let within = |first: u32, count: u32, all: u32| {
            count > 0 && first.checked_add(count).is_some_and(|end| end <= all)
        };
        within(self.x, self.width, size.width()) && within(self.y, self.height, size.height())
    }

    /// Indices of its pixels in a picture, row by row.
    pub(super) fn pixels(self, size: ImageSize) -> impl Iterator<Item = usize> {
        let width = size.width() as usize;
        let (x, y) = (self.x as usize, self.y as usize);
        (y..y + self.height as usize)
            .flat_map(move |row| row * width + x..row * width + x + self.width as usize)
    }
}

impl Display for PictureBlock {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        let Self { x, y, width, height } = self;
        write!(formatter, "{x},{y},{width}x{height}")
    }
}

impl FromStr for PictureBlock {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Option<Vec<u32>> = text.split([',', 'x']).map(|number| number.parse().ok()).collect();
        match (numbers.as_deref(), text.matches(',').count()) {
            (Some([x, y, width, height]), 2) if *width > 0 && *height > 0 => Ok(Self {
                x: *x,
                y: *y,
                width: *width,
                height: *height,
            }),
            _ => Err(format!(
                "{text:?}: expected X,Y,WIDTHxHEIGHT in pixels, such as 512,0,512x512"
            )),
        }
    }
}

/// A block of a picture, written `X,Y,WIDTHxHEIGHT`, or `I/N` for the I-th of N blocks, from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PartKey {
    /// Pixels.
    Block(PictureBlock),
    /// One of so many blocks.
    Share {
        /// Which, from 0.
        index: u32,
        /// How many there are.
        count: u32,
    },
}

impl FromStr for PartKey {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let Some((index, count)) = text.split_once('/') else {
            return text.parse().map(Self::Block);
        };
        match (index.parse(), count.parse()) {
            (Ok(index), Ok(count)) if index < count => Ok(Self::Share { index, count }),
            _ => Err(format!(
                "{text:?}: expected I/N with I from 0 to N - 1, or X,Y,WIDTHxHEIGHT"
            )),
        }
    }
}

impl PartKey {
    /// The pixels that it stands for; `None` where the picture has no such block.
    pub fn block(self, size: ImageSize) -> Option<PictureBlock> {
        match self {
            Self::Block(block) => Some(block).filter(|block| block.fits(size)),
            Self::Share { index, count } => PictureBlock::of(size, index, count),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_cover_pictures() {
        let size = ImageSize::new(100, 70).unwrap();
        for count in [1, 2, 6, 7, 12] {
            let blocks: Vec<_> = (0..count)
                .map(|i| PictureBlock::of(size, i, count).unwrap())
                .collect();
            let pixels: u32 = blocks.iter().map(|block| block.width * block.height).sum();
            assert_eq!(pixels, 7000);
            let text: PictureBlock = blocks[0].to_string().parse().unwrap();
            assert_eq!(text, blocks[0]);
        }
        assert_eq!(PictureBlock::of(size, 3, 3), None);
        for wrong in ["", "1,2,3,4", "1,2,0x3", "1,2,3", "-1,0,1x1", "1x2x3x4"] {
            assert!(wrong.parse::<PictureBlock>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn keys_are_blocks_or_shares() {
        let size = ImageSize::new(64, 32).unwrap();
        let block = |text: &str| text.parse::<PartKey>().unwrap().block(size).unwrap().to_string();
        assert_eq!(block("4,2,8x6"), "4,2,8x6");
        assert_eq!([block("0/2"), block("1/2")], ["0,0,32x32", "32,0,32x32"]);
        for outside in ["60,0,5x1", "0,0,65x32", "4294967295,0,1x1"] {
            assert_eq!(outside.parse::<PartKey>().unwrap().block(size), None, "{outside}");
        }
        for wrong in ["2/2", "a/2", "1/", "-1/3", "1,2,3"] {
            assert!(wrong.parse::<PartKey>().is_err(), "{wrong}");
        }
    }
}
