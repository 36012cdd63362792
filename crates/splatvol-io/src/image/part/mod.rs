//! Parts of pictures: the pixels of a block, from a worker to whoever puts the picture together.
//!
//! A file is a line that names it, a line of JSON, and the block's pixels row by row, six little-endian floats each: red,
//! green, blue and alpha, linear and premultiplied, mean depth, optical depth. The JSON holds the whole recipe, its
//! SHA-256, the state of the files that were read, the picture's size, the block, the instruction set that made it, and the SHA-256 of the pixels. Bytes follow
//! from recipe, files and block; parts of different recipes, files, programs or instruction sets are never put together.

mod block;

use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind, Read};
use std::ops::Range;
use std::path::Path;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use splatvol_scene::{Frame, ImageSize};

pub use self::block::{PartKey, PictureBlock};
use crate::IoError;
use crate::error::Context;

/// First line of a part.
const MAGIC: &[u8] = b"splatvol part 1\n";
/// Bytes of a pixel.
const PIXEL: usize = 24;
/// Most bytes of the line of JSON.
const MOST_HEADER: usize = 16 << 20;

/// All that a part says of itself.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct PartHeader {
    /// Name and version of the program.
    pub program: String,
    /// The document with nothing left open, JSON.
    pub recipe: String,
    /// SHA-256 of the recipe.
    pub recipe_sha256: String,
    /// State of the files that were read, see [`crate::state_of_files`].
    pub files: String,
    /// Width and height of the picture.
    pub size: ImageSize,
    /// The block.
    pub block: PictureBlock,
    /// Vector instructions that made the pixels.
    pub simd: String,
    /// Lost chunks that are holes in it.
    pub holes: u64,
    /// SHA-256 of the pixels.
    pub pixels_sha256: String,
}

impl PartHeader {
    /// Reads what a file says of itself, and none of its pixels.
    ///
    /// # Errors
    /// A file that cannot be read, or that is no part.
    pub fn read(path: &Path) -> Result<Self, IoError> {
        let context = &Context::new("part", path);
        let file = File::open(path).map_err(|source| context.read(source))?;
        let mut start = BufReader::new(file).take((MAGIC.len() + MOST_HEADER) as u64);
        let mut magic = vec![0; MAGIC.len()];
        let mut line = Vec::new();
        let read = start
            .read_exact(&mut magic)
            .and_then(|()| start.read_until(b'\n', &mut line));
        match read {
            Ok(_) if magic == MAGIC && line.pop() == Some(b'\n') => Self::parse(&line, context),
            Err(source) if source.kind() != ErrorKind::UnexpectedEof => Err(context.read(source)),
            _ => Err(context.unsupported("no part of a picture of this version")),
        }
    }

    fn parse(line: &[u8], context: &Context<'_>) -> Result<Self, IoError> {
        let header: Self = serde_json::from_slice(line)
            .map_err(|error| context.unsupported(format!("its header: {error}")))?;
        if !header.block.fits(header.size) {
            let expected = "a block within the picture";
            return Err(context.field("block", header.block, None, expected));
        }
        Ok(header)
    }
}

/// What a part is made of, and by.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PartOrigin<'a> {
    /// The document with nothing left open, JSON.
    pub recipe: String,
    /// State of the files that were read, see [`crate::state_of_files`].
    pub files: String,
    /// Vector instructions that made the pixels.
    pub simd: &'a str,
    /// Lost chunks that are holes.
    pub holes: u64,
}

/// A part: what it says, and its pixels' bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// What it says.
    pub header: PartHeader,
    pixels: Vec<u8>,
}

fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes)
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

impl Part {
    /// A block of a picture of a size, and the frame of the block's pixels.
    ///
    /// # Errors
    /// A block outside the picture, or a frame of another size.
    pub fn new(
        frame: &Frame,
        (size, block): (ImageSize, PictureBlock),
        origin: PartOrigin<'_>,
    ) -> Result<Self, IoError> {
        let context = Context::new("part", Path::new("part"));
        let is_own = <[u32; 2]>::from(frame.image.size()) == [block.width, block.height];
        if !block.fits(size) || !is_own {
            let expected = "a block within the picture, and the frame of its pixels";
            return Err(context.field("block", block, None, expected));
        }
        let mut pixels = Vec::with_capacity(block.width as usize * block.height as usize * PIXEL);
        for index in 0..frame.depth.len() {
            let [r, g, b, a] = frame.image.pixels[index];
            for number in [r, g, b, a, frame.depth[index], frame.optical_depth[index]] {
                pixels.extend(number.to_le_bytes());
            }
        }
        let PartOrigin {
            recipe,
            files,
            simd,
            holes,
        } = origin;
        Ok(Self {
            header: PartHeader {
                program: concat!("splatvol ", env!("CARGO_PKG_VERSION")).to_owned(),
                recipe_sha256: sha256(recipe.as_bytes()),
                recipe,
                files,
                size,
                block,
                simd: simd.to_owned(),
                holes,
                pixels_sha256: sha256(&pixels),
            },
            pixels,
        })
    }

    /// The bytes of its file.
    ///
    /// # Errors
    /// Never: the header is text and numbers.
    pub fn to_bytes(&self) -> Result<Vec<u8>, IoError> {
        let header = serde_json::to_string(&self.header)
            .map_err(|error| Context::new("part", Path::new("part")).unsupported(error.to_string()))?;
        let mut bytes = MAGIC.to_vec();
        bytes.extend(header.as_bytes());
        bytes.push(b'\n');
        bytes.extend(&self.pixels);
        Ok(bytes)
    }

    /// Reads and verifies a part; `path` is named in errors.
    ///
    /// # Errors
    /// Bytes that are no part, or not all of one, or not those that were written.
    pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Self, IoError> {
        let context = &Context::new("part", path);
        let rest = bytes
            .strip_prefix(MAGIC)
            .ok_or_else(|| context.unsupported("no part of a picture of this version"))?;
        let end = rest.iter().take(MOST_HEADER).position(|&byte| byte == b'\n');
        let (line, pixels) = end
            .map(|end| (&rest[..end], &rest[end + 1..]))
            .ok_or_else(|| context.unsupported("its second line does not end"))?;
        let header = PartHeader::parse(line, context)?;
        let wanted = u64::from(header.block.width) * u64::from(header.block.height) * PIXEL as u64;
        if pixels.len() as u64 != wanted {
            let found = pixels.len();
            return Err(context.unsupported(format!("{found} bytes of pixels, and its block has {wanted}")));
        }
        let sums = [
            (&header.recipe_sha256, header.recipe.as_bytes(), "recipe"),
            (&header.pixels_sha256, pixels, "pixels"),
        ];
        for (sum, bytes, what) in sums {
            if *sum != sha256(bytes) {
                return Err(context.unsupported(format!("its {what} are not those that were written")));
            }
        }
        Ok(Self {
            pixels: pixels.to_vec(),
            header,
        })
    }
}

/// A picture, or some of its rows, that is put together from parts, which may come in any order and more than once.
#[derive(Debug)]
pub struct Assembly {
    first: PartHeader,
    rows: Range<u32>,
    /// The pixels of these rows.
    frame: Frame,
    /// Which pixels are there.
    there: Vec<bool>,
    holes: u64,
}

impl Assembly {
    /// Of the recipe of a part; `path` is named in errors.
    ///
    /// # Errors
    /// A picture larger than the memory that the machine grants.
    pub fn new(part: &Part, path: &Path) -> Result<Self, IoError> {
        Self::of_rows(&part.header, 0..part.header.size.height(), path)
    }

    /// Of some rows of a part's picture; of parts that are added, only their pixels in these rows count. `path` is named in
    /// errors.
    ///
    /// # Errors
    /// No rows, or larger ones than the memory that the machine grants.
    pub fn of_rows(first: &PartHeader, rows: Range<u32>, path: &Path) -> Result<Self, IoError> {
        let context = Context::new("part", path);
        let size =
            ImageSize::new(first.size.width(), rows.len() as u32).map_err(|error| context.scene(error))?;
        let needed = size.pixel_count() as u64 * (PIXEL as u64 + 1);
        let granted = crate::memory::granted();
        if needed > granted {
            return Err(context.limit(needed, granted));
        }
        Ok(Self {
            first: first.clone(),
            rows,
            frame: Frame::empty(size),
            there: vec![false; size.pixel_count()],
            holes: 0,
        })
    }

    /// What is known, with one part more, or the picture of the first; `path` is named in errors.
    ///
    /// # Errors
    /// As [`Part::from_bytes`], [`Assembly::new`] and [`Assembly::add`].
    pub fn joined(known: Option<Self>, bytes: &[u8], path: &Path) -> Result<Self, IoError> {
        let part = Part::from_bytes(bytes, path)?;
        let mut assembly = match known {
            Some(known) => known,
            None => Self::new(&part, path)?,
        };
        assembly.add(&part, path)?;
        Ok(assembly)
    }

    /// Adds a part; `path` is named in errors.
    ///
    /// # Errors
    /// A part of another picture, or made by another program or other instructions, or other pixels than another part
    /// has there.
    pub fn add(&mut self, part: &Part, path: &Path) -> Result<(), IoError> {
        let context = &Context::new("part", path);
        let (own, first) = (&part.header, &self.first);
        let same = [
            (&own.recipe_sha256, &first.recipe_sha256, "recipe"),
            (&own.files, &first.files, "state of files"),
            (&own.program, &first.program, "program"),
            (&own.simd, &first.simd, "instruction set"),
        ];
        for (own, first, what) in same {
            if own != first {
                return Err(
                    context.unsupported(format!("its {what}, {own}, is not that of the others, {first}"))
                );
            }
        }
        if own.size != first.size {
            return Err(context.unsupported("its picture has another size"));
        }
        let mut is_new = false;
        let pixels = part.pixels.as_chunks::<PIXEL>().0;
        for (place, pixel) in own.block.pixels(own.size).zip(pixels) {
            let Some(index) = self.index(place) else {
                continue;
            };
            let mut numbers = pixel
                .as_chunks::<4>()
                .0
                .iter()
                .map(|bytes| f32::from_le_bytes(*bytes));
            let numbers: [f32; 6] = std::array::from_fn(|_| numbers.next().unwrap_or(0.0));
            let [r, g, b, a, depth, optical_depth] = numbers;
            if self.there[index] {
                let [or, og, ob, oa] = self.frame.image.pixels[index];
                let others = [
                    or,
                    og,
                    ob,
                    oa,
                    self.frame.depth[index],
                    self.frame.optical_depth[index],
                ];
                if numbers.map(f32::to_bits) != others.map(f32::to_bits) {
                    return Err(context.unsupported("its pixels differ from those of another part"));
                }
                continue;
            }
            is_new = true;
            self.there[index] = true;
            self.frame.image.pixels[index] = [r, g, b, a];
            self.frame.depth[index] = depth;
            self.frame.optical_depth[index] = optical_depth;
        }
        if is_new {
            // Of a part that lies in several bands of rows, the first counts them.
            self.holes += match self.rows.contains(&own.block.y) {
                true => own.holes,
                false => 0,
            };
        }
        Ok(())
    }

    /// Place of a pixel of the picture among those of the rows.
    fn index(&self, place: usize) -> Option<usize> {
        let first = self.rows.start as usize * self.first.size.width() as usize;
        place.checked_sub(first).filter(|&index| index < self.there.len())
    }

    /// The picture's recipe.
    pub fn recipe(&self) -> &str {
        &self.first.recipe
    }

    /// Lost chunks that are holes, summed over the parts.
    pub fn holes(&self) -> u64 {
        self.holes
    }

    /// The picture, or its rows.
    ///
    /// # Errors
    /// Pixels of which there is no part, by the first of them.
    pub fn finish(self) -> Result<Frame, IoError> {
        let Some(index) = self.there.iter().position(|there| !there) else {
            return Ok(self.frame);
        };
        let missing = self.there.iter().filter(|there| !**there).count();
        let width = self.first.size.width() as usize;
        let (x, y) = (index % width, self.rows.start as usize + index / width);
        let what = format!("{missing} pixels have no part, the first at column {x}, row {y}");
        Err(Context::new("picture", Path::new("parts")).unsupported(what))
    }
}

#[cfg(test)]
mod tests {
    use splatvol_scene::Image;

    use super::*;

    fn frame(width: u32, height: u32) -> Frame {
        let size = ImageSize::new(width, height).unwrap();
        let count = size.pixel_count();
        let pixels = (0..count).map(|i| [i as f32, 0.1, 0.2, 0.3]).collect();
        Frame {
            image: Image::from_pixels(size, pixels).unwrap(),
            depth: (0..count)
                .map(|i| if i % 3 == 0 { f32::INFINITY } else { i as f32 })
                .collect(),
            optical_depth: vec![0.5; count],
        }
    }

    fn part(frame: &Frame, block: PictureBlock) -> Part {
        block_of(frame, block, origin("scalar", 1))
    }

    fn block_of(frame: &Frame, block: PictureBlock, origin: PartOrigin<'_>) -> Part {
        let columns = block.x as usize..(block.x + block.width) as usize;
        let rows = block.y as usize..(block.y + block.height) as usize;
        let own = frame.cut(columns, rows).unwrap();
        Part::new(&own, (frame.image.size(), block), origin).unwrap()
    }

    fn origin(simd: &str, holes: u64) -> PartOrigin<'_> {
        PartOrigin {
            recipe: "{}".to_owned(),
            files: "state".to_owned(),
            simd,
            holes,
        }
    }

    #[test]
    fn parts_make_the_picture_in_any_order_and_twice() {
        let frame = frame(70, 33);
        let mut blocks = PictureBlock::all(frame.image.size(), 32);
        assert_eq!(blocks.len(), 6);
        blocks.reverse();
        blocks.extend(blocks.clone());
        let parts: Vec<Part> = blocks.iter().map(|&block| part(&frame, block)).collect();
        let path = Path::new("a.part");
        let mut assembly = Assembly::new(&parts[0], path).unwrap();
        for part in &parts[..5] {
            assembly.add(part, path).unwrap();
        }
        let missing = Assembly {
            rows: 0..33,
            frame: frame.clone(),
            there: assembly.there.clone(),
            first: assembly.first.clone(),
            holes: 0,
        };
        let error = missing.finish().unwrap_err().to_string();
        assert!(
            error.contains("1024 pixels have no part, the first at column 0, row 0"),
            "{error}"
        );
        for part in &parts[5..] {
            let read = Part::from_bytes(&part.to_bytes().unwrap(), path).unwrap();
            assert_eq!(read, *part);
            assembly.add(&read, path).unwrap();
        }
        assert_eq!(assembly.holes(), 6);
        let found = assembly.finish().unwrap();
        assert_eq!(found.image.pixels, frame.image.pixels);
        assert_eq!(found.depth, frame.depth);
    }

    #[test]
    fn rows_take_what_parts_have_of_them() {
        let frame = frame(70, 33);
        let path = Path::new("a.part");
        let parts: Vec<Part> = PictureBlock::all(frame.image.size(), 32)
            .into_iter()
            .map(|block| part(&frame, block))
            .collect();
        for rows in [0..7u32, 7..33, 32..33] {
            let mut assembly = Assembly::of_rows(&parts[0].header, rows.clone(), path).unwrap();
            for part in &parts[..5] {
                assembly.add(part, path).unwrap();
            }
            if rows.end == 33 {
                let error = assembly.finish().unwrap_err().to_string();
                assert!(error.contains("the first at column 64, row 32"), "{error}");
                continue;
            }
            let expected = frame.cut(0..70, rows.start as usize..rows.end as usize).unwrap();
            assert_eq!(assembly.finish().unwrap(), expected);
        }
        assert!(Assembly::of_rows(&parts[0].header, 3..3, path).is_err());
    }

    #[test]
    fn damaged_and_foreign_parts_are_refused() {
        let path = Path::new("a.part");
        let frame = frame(8, 8);
        let block: PictureBlock = "2,0,4x8".parse().unwrap();
        let own = part(&frame, block);
        let bytes = own.to_bytes().unwrap();
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 1;
            assert_ne!(Part::from_bytes(&damaged, path).ok().as_ref(), Some(&own), "{at}");
            assert!(Part::from_bytes(&bytes[..at], path).is_err(), "{at}");
        }
        let mut assembly = Assembly::new(&own, path).unwrap();
        assembly.add(&own, path).unwrap();
        let mut other = frame.clone();
        other.image.pixels[2][0] += 1.0;
        let error = assembly.add(&part(&other, block), path).unwrap_err().to_string();
        assert!(error.contains("differ"), "{error}");
        let foreign = block_of(&frame, block, origin("avx2", 0));
        let error = assembly.add(&foreign, path).unwrap_err().to_string();
        assert!(error.contains("instruction set, avx2"), "{error}");
        let changed = PartOrigin {
            files: "another".to_owned(),
            ..origin("scalar", 1)
        };
        let changed = block_of(&frame, block, changed);
        let error = assembly.add(&changed, path).unwrap_err().to_string();
        assert!(error.contains("state of files, another"), "{error}");
        let size = frame.image.size();
        assert!(Part::new(&frame, (size, "5,0,8x8".parse().unwrap()), origin("", 0)).is_err());
        assert!(Part::new(&frame, (size, block), origin("", 0)).is_err());
    }
}
