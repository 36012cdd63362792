//! Where splats lie on a sheet: the rows and vectors of their boxes.

use fearless_simd::{f32x16, prelude::*, u32x16};

use super::sheet::{LINE, Sheet};

/// Splats that are made ready together.
pub(crate) const BATCH: usize = 16;

/// The shape of all splats of a call.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Footprint {
    /// `xx, xy, yy` of `exp(-(xx dx^2 + 2 xy dx dy + yy dy^2) / 2)`, per pixel squared.
    pub conic: [f32; 3],
    /// Half widths of the box around a splat's centre, pixels; pixels whose centres lie in it are filled.
    pub reach: [f32; 2],
}

impl Footprint {
    /// A round Gaussian of standard deviation `sigma`, cut at `radius`, pixels.
    pub fn round(sigma: f32, radius: f32) -> Self {
        let exponent = 1.0 / (sigma * sigma);
        Self {
            conic: [exponent, 0.0, exponent],
            reach: [radius; 2],
        }
    }

    /// The Gaussian of covariance `[xx, xy, yy]`, pixels squared, in the box around the ellipse at `cut` standard
    /// deviations.
    pub fn of_covariance([xx, xy, yy]: [f32; 3], cut: f32) -> Self {
        let determinant = xx * yy - xy * xy;
        Self {
            conic: [yy / determinant, -xy / determinant, xx / determinant],
            reach: [xx.sqrt() * cut, yy.sqrt() * cut],
        }
    }

    /// Exponents to base 2 of `dx^2`, `dx dy` and `dy^2`.
    pub(crate) fn exponents(&self) -> [f32; 3] {
        let [xx, xy, yy] = self.conic;
        [-0.5 * xx, -xy, -0.5 * yy].map(|e| e * std::f32::consts::LOG2_E)
    }
}

/// Splats: centres in pixels from the sheet's corner (the first pixel's centre is at 0.5), and what the channels get. The
/// shortest list counts.
#[derive(Debug, Clone, Copy)]
pub struct Splats<'a, const CHANNELS: usize> {
    /// Centres.
    pub x: &'a [f32],
    /// Centres.
    pub y: &'a [f32],
    /// Value at the centre, per channel.
    pub weights: &'a [[f32; CHANNELS]],
}

impl<const CHANNELS: usize> Splats<'_, CHANNELS> {
    pub(crate) fn len(&self) -> usize {
        self.x.len().min(self.y.len()).min(self.weights.len())
    }
}

/// What is reserved for every splat of a call: a window of whole vectors, the same for all.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Window {
    /// Windows begin at multiples of so many pixels.
    align: usize,
    channels: usize,
    /// Vectors of a row.
    pub vectors: usize,
    /// Cache lines that hold them.
    pub lines: usize,
    /// Rows that can lie inside the sheet.
    pub rows: usize,
    /// Whether places have no other rows than those in reach, or as many rows each.
    exact: bool,
    pub reach: [f32; 2],
    /// Last column where a window may begin, pixels.
    last: usize,
    /// Floats from row to row of the sheet.
    pub pitch: usize,
    height: usize,
}

impl Window {
    /// For vectors of `length` floats. None where the sheet or the footprint has no pixels.
    pub(crate) fn new<const CHANNELS: usize>(
        footprint: &Footprint,
        sheet: &Sheet<CHANNELS>,
        length: usize,
        aligned: bool,
    ) -> Option<Self> {
        let [rx, ry] = footprint.reach;
        let (pitch, [_, height]) = (sheet.pitch() / CHANNELS, sheet.size());
        if !(rx > 0.0 && ry > 0.0) || pitch == 0 || height == 0 {
            return None;
        }
        let pixels = length / CHANNELS;
        let align = if aligned { pixels } else { 1 };
        let width = points(rx).min(pitch) + align - 1;
        let vectors = width.div_ceil(pixels).min(pitch / pixels);
        Some(Self {
            align,
            channels: CHANNELS,
            vectors,
            lines: (vectors * length).div_ceil(LINE),
            rows: points(ry).min(height),
            exact: false,
            reach: footprint.reach,
            last: pitch - vectors * pixels,
            pitch: sheet.pitch(),
            height,
        })
    }

    /// With a number of rows for each splat. Otherwise all have the same number, so that a processor can foresee it, and
    /// the last one may be out of reach.
    pub(crate) fn exact(self) -> Self {
        Self { exact: true, ..self }
    }
}

/// Raster points in a footprint's reach, at most: both ends are met by chance only.
pub(crate) fn points(reach: f32) -> usize {
    (2.0 * reach).ceil() as usize
}

/// Splats' places, ready to be used one by one.
#[derive(Debug, Default)]
pub(crate) struct Places {
    /// First float of the window in the sheet.
    first: [u32; BATCH],
    /// Rows inside the sheet.
    rows: [u32; BATCH],
    /// From the splat's centre to the window's first pixel.
    pub dx: [f32; BATCH],
    pub dy: [f32; BATCH],
}

/// The lane's number.
pub(crate) const LANE: [f32; BATCH] = [
    0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0,
];
/// The number of the lane's pixel, with four channels.
const LANE_OF_FOUR: [f32; BATCH] = [
    0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0, 3.0, 3.0, 3.0, 3.0,
];

/// Pixel of each lane of a cache line.
#[inline(always)]
pub(crate) fn pixel_of_lane<S: Simd>(simd: S, channels: usize) -> f32x16<S> {
    f32x16::from_slice(simd, if channels == 1 { &LANE } else { &LANE_OF_FOUR })
}

/// A splat's weight in each lane of a cache line.
#[inline(always)]
pub(crate) fn weight_of_lane<S: Simd, const CHANNELS: usize>(simd: S, weight: &[f32; CHANNELS]) -> f32x16<S> {
    match weight.first_chunk::<4>() {
        Some(four) => {
            let four = fearless_simd::f32x4::from_slice(simd, four)
                .combine(fearless_simd::f32x4::from_slice(simd, four));
            four.combine(four)
        }
        None => f32x16::splat(simd, weight[0]),
    }
}

impl Places {
    /// Places of up to sixteen splats.
    #[inline(always)]
    pub(crate) fn find<S: Simd>(&mut self, simd: S, window: &Window, x: &[f32], y: &[f32]) {
        let (mut xs, mut ys) = ([0.0; BATCH], [0.0; BATCH]);
        let count = x.len().min(y.len()).min(BATCH);
        xs[..count].copy_from_slice(&x[..count]);
        ys[..count].copy_from_slice(&y[..count]);
        let (x, y) = (f32x16::from_slice(simd, &xs), f32x16::from_slice(simd, &ys));
        let [rx, ry] = window.reach;
        let zero = f32x16::splat(simd, 0.0);
        let align = window.align as f32;
        let column = ((x - (rx + 0.5)).ceil() * (1.0 / align)).floor() * align;
        let column = column.max(zero).min(f32x16::splat(simd, window.last as f32));
        let low = (y - (ry + 0.5)).ceil();
        let height = f32x16::splat(simd, window.height as f32);
        let row = low.max(zero).min(height);
        let end = if window.exact {
            (y + (ry + 0.5)).floor()
        } else {
            low + points(ry) as f32
        };
        let end = end.max(row).min(height);
        (column - x + 0.5).store_slice(&mut self.dx);
        (row - y + 0.5).store_slice(&mut self.dy);
        let column = column.to_int::<u32x16<S>>() * window.channels as u32;
        let first = row.to_int::<u32x16<S>>() * window.pitch as u32 + column;
        first.store_slice(&mut self.first);
        (end - row).to_int::<u32x16<S>>().store_slice(&mut self.rows);
    }

    /// The rows of the n-th splat's window, and how many there are.
    #[inline(always)]
    pub(crate) fn at<'a>(&self, n: usize, window: &Window, values: &'a mut [f32]) -> (Lines<'a>, usize) {
        let rows = (self.rows[n] as usize).min(window.rows);
        let rest = values.get_mut(self.first[n] as usize..).unwrap_or_default();
        (
            Lines {
                rest,
                pitch: window.pitch,
            },
            rows,
        )
    }
}

/// Rows of a sheet from a float on. As `chunks_exact_mut`, without its division.
#[derive(Debug)]
pub(crate) struct Lines<'a> {
    rest: &'a mut [f32],
    pitch: usize,
}

impl<'a> Iterator for Lines<'a> {
    type Item = &'a mut [f32];

    #[inline(always)]
    fn next(&mut self) -> Option<&'a mut [f32]> {
        let (line, rest) = std::mem::take(&mut self.rest).split_at_mut_checked(self.pitch)?;
        self.rest = rest;
        Some(line)
    }
}
