//! Pictures as functions of two coordinates, 0 to 1 each, the origin at the top left.

use glam::Vec4;

use crate::Image;

/// Horizontal addressing beyond the left and right edge: wrap around to the other side, or clamp to the edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Across {
    Wrapped,
    Clamped,
}

/// Pixel sides joined by straight lines.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Picture {
    width: usize,
    height: usize,
    pixels: Vec<Vec4>,
    across: Across,
}

impl Picture {
    pub(super) fn new(image: &Image, across: Across) -> Self {
        Self {
            width: image.size().width() as usize,
            height: image.size().height() as usize,
            pixels: image
                .pixels
                .iter()
                .map(|&pixel| Vec4::from_array(pixel))
                .collect(),
            across,
        }
    }

    /// Its numbers in WGSL: columns, rows and whether it wraps around; then its pixels.
    pub(super) fn operands(&self) -> impl Iterator<Item = [f32; 4]> {
        let wraps = f32::from(u8::from(self.across == Across::Wrapped));
        let head = [self.width as f32, self.height as f32, wraps, 0.0];
        std::iter::once(head).chain(self.pixels.iter().map(|pixel| pixel.to_array()))
    }

    /// Columns and rows.
    pub(super) fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    pub(super) fn pixel(&self, x: usize, y: usize) -> Vec4 {
        self.pixels[y * self.width + x]
    }

    /// Slopes of a function of the pixels, per unit of u as x and of v as y: differences of a pixel's neighbours.
    pub(super) fn slopes(&self, value: impl Fn(Vec4) -> f32) -> Self {
        let values: Vec<f32> = self.pixels.iter().map(|&pixel| value(pixel)).collect();
        let [width, height] = self.size();
        let slope = |x: usize, y: usize| {
            let (left, right, apart) = match self.across {
                Across::Wrapped => ((x + width - 1) % width, (x + 1) % width, 2),
                Across::Clamped => beside(x, width),
            };
            let (top, bottom, down) = beside(y, height);
            let along = values[y * width + right] - values[y * width + left];
            let downwards = values[bottom * width + x] - values[top * width + x];
            let per =
                |difference: f32, apart: usize, count: usize| difference * count as f32 / apart.max(1) as f32;
            Vec4::new(per(along, apart, width), per(downwards, down, height), 0.0, 0.0)
        };
        Self {
            pixels: (0..width * height).map(|i| slope(i % width, i / width)).collect(),
            ..*self
        }
    }

    /// Bilinear value.
    pub(super) fn at(&self, [u, v]: [f32; 2]) -> Vec4 {
        let x = u * self.width as f32 - 0.5;
        let (left, right, along) = match self.across {
            Across::Clamped => clamped(x, self.width),
            Across::Wrapped => {
                let floor = x.floor();
                let width = self.width as i64;
                let left = (floor as i64).rem_euclid(width) as usize;
                (left, (left + 1) % self.width, x - floor)
            }
        };
        let (top, bottom, down) = clamped(v * self.height as f32 - 0.5, self.height);
        let row = |y: usize| self.pixel(left, y).lerp(self.pixel(right, y), along);
        row(top).lerp(row(bottom), down)
    }
}

/// Indices of the neighbours before and after `at` among `count`, and the distance between them.
fn beside(at: usize, count: usize) -> (usize, usize, usize) {
    let (before, behind) = (at.saturating_sub(1), (at + 1).min(count - 1));
    (before, behind, behind - before)
}

/// Neighbours of a position among `count`, and the share of the second.
fn clamped(at: f32, count: usize) -> (usize, usize, f32) {
    // A NaN becomes 0.
    let at = at.max(0.0).min(count as f32 - 1.0);
    let first = at as usize;
    (first, (first + 1).min(count - 1), at - first as f32)
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use crate::ImageSize;

    #[test]
    fn values_are_met_at_pixel_centres_and_wrap_or_end_at_the_sides() {
        let size = ImageSize::new(4, 2).unwrap();
        let pixels = (0..8).map(|i| [i as f32, 0.0, 0.0, 1.0]).collect();
        let image = Image::from_pixels(size, pixels).unwrap();
        let (wrapped, ends) = (
            Picture::new(&image, Across::Wrapped),
            Picture::new(&image, Across::Clamped),
        );
        assert_eq!(wrapped.at([0.375, 0.25]).x, 1.0);
        assert_eq!(wrapped.at([0.375, 0.75]).x, 5.0);
        assert_eq!(wrapped.at([0.5, 0.5]).x, 3.5);
        // Half way between the last column and the first.
        assert_eq!(wrapped.at([0.0, 0.0]).x, 1.5);
        assert_eq!(wrapped.at([-1.0, -3.0]).x, 1.5);
        assert_eq!(ends.at([0.0, 0.0]).x, 0.0);
        assert_eq!(ends.at([7.0, f32::NAN]).x, 3.0);
    }

    #[test]
    fn slopes_are_per_unit_of_the_picture() {
        let size = ImageSize::new(4, 3).unwrap();
        let pixels = (0..12).map(|i| [(i % 4) as f32 + 10.0 * (i / 4) as f32, 0.0, 0.0, 1.0]);
        let image = Image::from_pixels(size, pixels.collect()).unwrap();
        let slopes = |across| Picture::new(&image, across).slopes(|pixel| pixel.x);
        let (wrapped, ends) = (slopes(Across::Wrapped), slopes(Across::Clamped));
        for y in 0..3 {
            for x in 0..4 {
                assert_eq!(ends.pixel(x, y).truncate().truncate(), Vec2::new(4.0, 30.0));
            }
            // From 3 on the left, which is the other side, to 1 on the right.
            assert_eq!(wrapped.pixel(0, y).x, -4.0);
            assert_eq!(wrapped.pixel(1, y).x, 4.0);
        }
    }
}
