//! Output images: floats, linear light, premultiplied alpha.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::SceneError;

/// Width and height in pixels, each from 1 to 65536, with at most 2^30 pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "[u32; 2]", into = "[u32; 2]")]
pub struct ImageSize {
    width: u32,
    height: u32,
}

impl ImageSize {
    /// Validated size.
    ///
    /// # Errors
    /// A side of 0 or above 65536, or more than 2^30 pixels.
    pub fn new(width: u32, height: u32) -> Result<Self, SceneError> {
        let side = 1..=65_536;
        if !side.contains(&width) || !side.contains(&height) || u64::from(width) * u64::from(height) > 1 << 30
        {
            return Err(SceneError::invalid(
                "image size",
                [width, height],
                "sides of 1 to 65536, at most 2^30 pixels",
            ));
        }
        Ok(Self { width, height })
    }

    /// Pixels per row.
    pub fn width(self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(self) -> u32 {
        self.height
    }

    /// Number of pixels.
    pub fn pixel_count(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Width over height.
    pub fn aspect(self) -> f64 {
        f64::from(self.width) / f64::from(self.height)
    }
}

impl Default for ImageSize {
    fn default() -> Self {
        Self {
            width: 512,
            height: 512,
        }
    }
}

impl TryFrom<[u32; 2]> for ImageSize {
    type Error = SceneError;

    fn try_from([width, height]: [u32; 2]) -> Result<Self, SceneError> {
        Self::new(width, height)
    }
}

impl From<ImageSize> for [u32; 2] {
    fn from(size: ImageSize) -> Self {
        [size.width, size.height]
    }
}

/// A picture: rows from the top, RGBA, linear light (BT.709 primaries), premultiplied alpha.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    size: ImageSize,
    /// One RGBA per pixel, row-major.
    pub pixels: Vec<[f32; 4]>,
}

impl Image {
    /// Image of one value.
    pub fn filled(size: ImageSize, pixel: [f32; 4]) -> Self {
        Self {
            size,
            pixels: vec![pixel; size.pixel_count()],
        }
    }

    /// Image of given pixels, row-major.
    ///
    /// # Errors
    /// A pixel count that does not fit the size.
    pub fn from_pixels(size: ImageSize, pixels: Vec<[f32; 4]>) -> Result<Self, SceneError> {
        if pixels.len() != size.pixel_count() {
            return Err(SceneError::invalid("pixels", pixels.len(), "width times height"));
        }
        Ok(Self { size, pixels })
    }

    /// Width and height.
    pub fn size(&self) -> ImageSize {
        self.size
    }

    /// Pixel in column x, row y.
    ///
    /// # Panics
    /// Outside the image.
    pub fn pixel(&self, x: usize, y: usize) -> [f32; 4] {
        self.pixels[y * self.size.width as usize + x]
    }

    /// This image over a background (linear, straight alpha).
    #[must_use]
    pub fn over(&self, background: [f32; 4]) -> Self {
        let [r, g, b, a] = background;
        let under = [r * a, g * a, b * a, a];
        let over = |pixel: &[f32; 4]| std::array::from_fn(|c| pixel[c] + (1.0 - pixel[3]) * under[c]);
        Self {
            size: self.size,
            pixels: self.pixels.iter().map(over).collect(),
        }
    }
}

/// A rendered frame: the picture and the planes that go with it.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// The picture without background.
    pub image: Image,
    /// Camera depth per pixel, row-major, world length: the mean of the depths that light comes from, weighted by
    /// its share of the pixel's opacity. Infinite where alpha is 0.
    pub depth: Vec<f32>,
    /// Optical depth per pixel, row-major: `-ln` of the transmittance, exact also where alpha rounds to 1.
    pub optical_depth: Vec<f32>,
}

impl Frame {
    /// A frame of nothing.
    pub fn empty(size: ImageSize) -> Self {
        Self {
            image: Image::filled(size, [0.0; 4]),
            depth: vec![f32::INFINITY; size.pixel_count()],
            optical_depth: vec![0.0; size.pixel_count()],
        }
    }

    /// Whether all its planes have this size.
    pub fn fits(&self, size: ImageSize) -> bool {
        let count = size.pixel_count();
        self.image.size() == size
            && [
                self.image.pixels.len(),
                self.depth.len(),
                self.optical_depth.len(),
            ] == [count; 3]
    }

    /// The pixels of some columns and rows, as a frame of their own.
    ///
    /// # Errors
    /// No pixels, or some that the frame does not have.
    pub fn cut(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Self, SceneError> {
        let [width, height] = <[u32; 2]>::from(self.image.size()).map(|side| side as usize);
        if columns.end > width || rows.end > height {
            let found = [columns.end, rows.end];
            return Err(SceneError::invalid(
                "columns and rows",
                found,
                "those of the frame",
            ));
        }
        let [own_width, own_height] = [columns.len(), rows.len()].map(|side| side as u32);
        let mut part = Self::empty(ImageSize::new(own_width, own_height)?);
        for (to, y) in rows.enumerate() {
            let to = to * columns.len()..(to + 1) * columns.len();
            let from = y * width + columns.start..y * width + columns.end;
            part.image.pixels[to.clone()].copy_from_slice(&self.image.pixels[from.clone()]);
            part.depth[to.clone()].copy_from_slice(&self.depth[from.clone()]);
            part.optical_depth[to].copy_from_slice(&self.optical_depth[from]);
        }
        Ok(part)
    }

    /// Copies the pixels of some columns and rows from another frame of the same size, such as a part that another
    /// worker rendered.
    ///
    /// # Errors
    /// A frame of another size.
    pub fn paste(
        &mut self,
        other: &Self,
        columns: Range<usize>,
        rows: Range<usize>,
    ) -> Result<(), SceneError> {
        let size = self.image.size();
        if other.image.size() != size {
            let size = <[u32; 2]>::from(other.image.size());
            return Err(SceneError::invalid("size", size, "the size of the frame"));
        }
        let [width, height] = <[u32; 2]>::from(size).map(|side| side as usize);
        for y in rows.start..rows.end.min(height) {
            let row = y * width + columns.start.min(width)..y * width + columns.end.min(width);
            self.image.pixels[row.clone()].copy_from_slice(&other.image.pixels[row.clone()]);
            self.depth[row.clone()].copy_from_slice(&other.depth[row.clone()]);
            self.optical_depth[row.clone()].copy_from_slice(&other.optical_depth[row]);
        }
        Ok(())
    }
}
