//! Measures for comparing pictures of textures.

use glam::DMat2;
use splatvol::Image;

/// Values of pixels, rows from the top.
#[derive(Debug, Clone)]
pub(super) struct Plane {
    pub width: usize,
    pub values: Vec<f64>,
}

impl Plane {
    /// One number per pixel.
    pub(super) fn of(image: &Image, value: impl Fn([f64; 4]) -> f64) -> Self {
        Self {
            width: image.size().width() as usize,
            values: image
                .pixels
                .iter()
                .map(|pixel| value(pixel.map(f64::from)))
                .collect(),
        }
    }

    /// The green channel, over black.
    pub(super) fn green(image: &Image) -> Self {
        Self::of(image, |pixel| pixel[1])
    }

    /// Opacity.
    pub(super) fn alpha(image: &Image) -> Self {
        Self::of(image, |pixel| pixel[3])
    }

    pub(super) fn height(&self) -> usize {
        self.values.len() / self.width.max(1)
    }

    /// Pixels from `samples` x `samples` values each, weighted by a Gaussian of `sigma` pixels; values outside count as
    /// zero.
    pub(super) fn low_passed(&self, samples: usize, sigma: f64) -> Self {
        self.filtered_along_x(samples, sigma)
            .transposed()
            .filtered_along_x(samples, sigma)
            .transposed()
    }

    fn filtered_along_x(&self, samples: usize, sigma: f64) -> Self {
        let reach = (4.0 * sigma * samples as f64).ceil() as isize;
        let middle = 0.5 * (samples as f64 - 1.0);
        let taps: Vec<(isize, f64)> = (-reach..=reach + samples as isize)
            .map(|tap| {
                let offset = (tap as f64 - middle) / samples as f64;
                (tap, (-0.5 * (offset / sigma).powi(2)).exp())
            })
            .collect();
        let total: f64 = taps.iter().map(|(_, weight)| weight).sum();
        let columns = self.width / samples;
        let values = self.values.chunks(self.width).flat_map(|row| {
            let taps = &taps;
            (0..columns).map(move |column| {
                let first = (column * samples) as isize;
                let value = |tap: isize| usize::try_from(first + tap).ok().and_then(|at| row.get(at));
                let sum: f64 = taps
                    .iter()
                    .filter_map(|&(tap, weight)| value(tap).map(|value| value * weight))
                    .sum();
                sum / total
            })
        });
        Self {
            width: columns,
            values: values.collect(),
        }
    }

    fn transposed(&self) -> Self {
        let height = self.height();
        Self {
            width: height,
            values: (0..self.values.len())
                .map(|i| self.values[i % height * self.width + i / height])
                .collect(),
        }
    }

    /// Covariance of the positions of the values, pixels squared.
    pub(super) fn moments(&self) -> DMat2 {
        let at = |index: usize| glam::DVec2::new((index % self.width) as f64, (index / self.width) as f64);
        let (mut mass, mut first) = (0.0, glam::DVec2::ZERO);
        for (index, value) in self.values.iter().enumerate() {
            mass += value;
            first += at(index) * *value;
        }
        let mean = first / mass;
        let spread = |index: usize| {
            let d = at(index) - mean;
            DMat2::from_cols(d * d.x, d * d.y)
        };
        let sum = self
            .values
            .iter()
            .enumerate()
            .filter(|(_, value)| **value != 0.0)
            .fold(DMat2::ZERO, |sum, (index, value)| sum + spread(index) * *value);
        sum * (1.0 / mass)
    }
}

/// The part of a picture that is compared: pixels whose surroundings are covered.
#[derive(Debug, Clone)]
pub(super) struct Inside(Vec<bool>);

impl Inside {
    /// Pixels at least `margin` away from the border and from pixels that are not opaque.
    pub(super) fn of(alpha: &Plane, margin: usize) -> Self {
        let (width, height) = (alpha.width, alpha.height());
        let covered = |x: usize, y: usize| {
            let around = |at: usize| at - margin..=at + margin;
            around(y).all(|y| around(x).all(|x| alpha.values[y * width + x] > 0.98))
        };
        let inner = |at: usize, side: usize| at >= margin && at + margin < side;
        Self(
            (0..width * height)
                .map(|i| (i % width, i / width))
                .map(|(x, y)| inner(x, width) && inner(y, height) && covered(x, y))
                .collect(),
        )
    }

    /// Only some rows of it, for pictures of this width.
    pub(super) fn rows(&self, width: usize, rows: std::ops::Range<usize>) -> Self {
        let keep = self.0.iter().enumerate();
        Self(
            keep.map(|(i, inside)| *inside && rows.contains(&(i / width)))
                .collect(),
        )
    }

    /// Share of all pixels.
    pub(super) fn share(&self) -> f64 {
        self.0.iter().filter(|inside| **inside).count() as f64 / self.0.len().max(1) as f64
    }

    fn mean(&self, value: impl Fn(usize) -> f64) -> f64 {
        let inside = self.0.iter().enumerate().filter(|(_, inside)| **inside);
        let (sum, count) = inside.fold((0.0, 0), |(sum, count), (index, _)| {
            (sum + value(index), count + 1)
        });
        sum / f64::from(count)
    }

    /// Root of the mean squared difference.
    pub(super) fn difference(&self, a: &Plane, b: &Plane) -> f64 {
        self.mean(|i| (a.values[i] - b.values[i]).powi(2)).sqrt()
    }

    /// Peak signal-to-noise ratio, peak 1, decibels.
    pub(super) fn psnr(&self, a: &Plane, b: &Plane) -> f64 {
        -20.0 * self.difference(a, b).log10()
    }

    /// Standard deviation.
    pub(super) fn contrast(&self, plane: &Plane) -> f64 {
        let mean = self.mean(|i| plane.values[i]);
        self.mean(|i| (plane.values[i] - mean).powi(2)).sqrt()
    }

    /// Root of the mean squared gradient, per pixel: how crisp a picture is.
    pub(super) fn crispness(&self, plane: &Plane) -> f64 {
        let step = |i: usize, by: usize| plane.values[i + by] - plane.values[i - by];
        self.mean(|i| 0.25 * (step(i, 1).powi(2) + step(i, plane.width).powi(2)))
            .sqrt()
    }
}
