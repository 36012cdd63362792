//! Large footprints: narrower ones on a coarser lattice, which cubic B-splines then interpolate.
//!
//! A cubic B-spline has a variance of 1/3 of a lattice cell squared: Gaussians that lack it are splatted to a lattice of
//! `2^k` pixels, and interpolation restores it (unser1993's direct transform left out). What differs from the Gaussian that
//! was asked for is the B-spline's fourth cumulant, -1/30: `1/30 / 24 s^4 * 3` of the peak for a standard deviation of s
//! cells along each axis, 2.6e-4 at the s = 2 that [`Lattice::coarsest`] demands. A splat's cost is that of the coarse
//! footprint, whatever the radius.

use fearless_simd::{Level, dispatch, f32x4, prelude::*};

use super::place::{Footprint, Splats};
use super::sheet::{Aligned, Sheet};
use super::{Scratch, splat};

/// Cells around the sheet whose nodes its pixels need.
const MARGIN: usize = 2;
/// Smallest standard deviation of footprints, cells.
const LEAST_SIGMA: f32 = 2.0;
/// Nodes that a cell's pixels need: four in either of its halves.
const TAPS: usize = 5;

/// A lattice of `2^k` pixels for a sheet.
#[derive(Debug)]
pub struct Lattice<const CHANNELS: usize> {
    nodes: Sheet<CHANNELS>,
    exponent: u32,
    /// Weights of the nodes around a cell, [tap][pixel of the cell].
    taps: [Vec<f32>; TAPS],
    /// Rows of nodes, columns of pixels.
    columns: Aligned,
    x: Vec<f32>,
    y: Vec<f32>,
    weights: Vec<[f32; CHANNELS]>,
}

/// The cubic B-spline at t cells from its middle.
fn cubic(t: f32) -> f32 {
    let t = t.abs();
    if t < 1.0 {
        (0.5 * t - 1.0) * t * t + 2.0 / 3.0
    } else {
        (2.0 - t).max(0.0).powi(3) / 6.0
    }
}

impl<const CHANNELS: usize> Lattice<CHANNELS> {
    /// Largest k for footprints: none of their axes is shorter than two cells.
    pub fn coarsest(footprint: &Footprint) -> u32 {
        let [xx, xy, yy] = footprint.conic;
        let largest = 0.5 * (xx + yy + (xx - yy).hypot(2.0 * xy));
        let sigma = largest.sqrt().recip();
        (sigma / LEAST_SIGMA).log2().floor().clamp(0.0, 16.0) as u32
    }

    /// A lattice of `2^exponent` pixels below a sheet of `size` pixels, all zero.
    pub fn new(size: [usize; 2], exponent: u32) -> Self {
        let step = 1usize << exponent.min(16);
        let tap = |tap: usize| {
            let weight = |pixel: usize| {
                // Nodes lie in the middle of cells.
                let along = (pixel as f32 + 0.5) / step as f32 - 0.5;
                cubic(along - (tap as f32 - MARGIN as f32))
            };
            (0..step).map(weight).collect()
        };
        Self {
            nodes: Sheet::new(size.map(|n| n.div_ceil(step) + 2 * MARGIN)),
            exponent: exponent.min(16),
            taps: [tap(0), tap(1), tap(2), tap(3), tap(4)],
            columns: Aligned::default(),
            x: Vec::new(),
            y: Vec::new(),
            weights: Vec::new(),
        }
    }

    /// What is splatted to the lattice for a footprint, and the factor of its weights. None where the footprint is too
    /// narrow for the lattice.
    pub fn coarse(&self, footprint: &Footprint) -> Option<(Footprint, f32)> {
        let cell = 0.5_f32.powi(self.exponent as i32);
        let [xx, xy, yy] = footprint.conic;
        let determinant = xx * yy - xy * xy;
        let covariance = [yy, -xy, xx].map(|v| v / determinant * cell * cell);
        let [wide_x, both, wide_y] = covariance;
        let (x, y) = (wide_x - 1.0 / 3.0, wide_y - 1.0 / 3.0);
        let area = x * y - both * both;
        if !(x > 0.0 && y > 0.0 && area > 0.0) {
            return None;
        }
        let [rx, ry] = footprint.reach;
        let coarse = Footprint {
            conic: [y / area, -both / area, x / area],
            reach: [rx * cell * (x / wide_x).sqrt(), ry * cell * (y / wide_y).sqrt()],
        };
        Some((coarse, ((wide_x * wide_y - both * both) / area).sqrt()))
    }

    /// Adds splats, given in pixels of the sheet, to the lattice. False where the footprint is too narrow for it.
    pub fn splat(
        &mut self,
        level: Level,
        footprint: &Footprint,
        splats: &Splats<'_, CHANNELS>,
        scratch: &mut Scratch,
    ) -> bool {
        let Some((coarse, gain)) = self.coarse(footprint) else {
            return false;
        };
        let cell = 0.5_f32.powi(self.exponent as i32);
        let of_pixels = |v: &f32| v.mul_add(cell, MARGIN as f32);
        self.x.clear();
        self.x.extend(splats.x.iter().map(of_pixels));
        self.y.clear();
        self.y.extend(splats.y.iter().map(of_pixels));
        self.weights.clear();
        self.weights
            .extend(splats.weights.iter().map(|weight| weight.map(|w| w * gain)));
        let moved = Splats {
            x: &self.x,
            y: &self.y,
            weights: &self.weights,
        };
        splat(level, &mut self.nodes, &coarse, &moved, scratch);
        true
    }

    /// Adds what the lattice holds to a sheet of the size that it was made for, and clears the lattice.
    pub fn resolve(&mut self, level: Level, sheet: &mut Sheet<CHANNELS>) {
        dispatch!(level, simd => self.resolve_with(simd, sheet));
        self.nodes.clear();
    }

    #[inline(always)]
    fn resolve_with<S: Simd>(&mut self, simd: S, sheet: &mut Sheet<CHANNELS>) {
        let step = 1usize << self.exponent;
        let size = self.nodes.size();
        let pitch = sheet.pitch();
        self.columns.reserve(size[1] * pitch);
        self.across(simd, pitch);
        let columns = self.columns.as_slice();
        // A sheet larger than what the lattice was made for gets nothing beyond it.
        let rows = (size[1] - 2 * MARGIN) * step;
        for (y, line) in sheet.values_mut().chunks_exact_mut(pitch).enumerate().take(rows) {
            let (cell, pixel) = (y / step, y % step);
            // The upper half of a cell does not need the last tap, the lower one not the first.
            let skip = usize::from(2 * pixel >= step);
            let mut weights = [0.0; 4];
            for (weight, tap) in weights.iter_mut().zip(&self.taps[skip..]) {
                *weight = tap[pixel];
            }
            let nodes = &columns[(cell + skip) * pitch..(cell + skip + 4) * pitch];
            let (upper, lower) = nodes.split_at(2 * pitch);
            let ((a, b), (c, d)) = (upper.split_at(pitch), lower.split_at(pitch));
            let length = S::f32s::LEN;
            for (i, pixels) in line.chunks_exact_mut(length).enumerate() {
                let lanes = i * length..(i + 1) * length;
                let mut sum = S::f32s::from_slice(simd, pixels);
                sum = S::f32s::from_slice(simd, &a[lanes.clone()]).mul_add(weights[0], sum);
                sum = S::f32s::from_slice(simd, &b[lanes.clone()]).mul_add(weights[1], sum);
                sum = S::f32s::from_slice(simd, &c[lanes.clone()]).mul_add(weights[2], sum);
                sum = S::f32s::from_slice(simd, &d[lanes]).mul_add(weights[3], sum);
                sum.store_slice(pixels);
            }
        }
    }

    /// Interpolates rows of nodes to columns of pixels.
    #[inline(always)]
    fn across<S: Simd>(&mut self, simd: S, pitch: usize) {
        let step = 1usize << self.exponent;
        let nodes = self.nodes.values().chunks_exact(self.nodes.pitch());
        let lines = self.columns.as_mut_slice().chunks_exact_mut(pitch);
        let cells = self.nodes.size()[0] - 2 * MARGIN;
        for (line, nodes) in lines.zip(nodes) {
            for (cell, pixels) in line.chunks_mut(step * CHANNELS).enumerate() {
                if cell >= cells {
                    pixels.fill(0.0);
                    continue;
                }
                let nodes = &nodes[cell * CHANNELS..(cell + TAPS) * CHANNELS];
                if CHANNELS == 4 {
                    interpolate_four(simd, &self.taps, nodes, pixels);
                } else if step >= 4 {
                    interpolate(simd, &self.taps, nodes, pixels);
                } else {
                    for (i, pixel) in pixels.iter_mut().enumerate() {
                        *pixel = (0..TAPS).fold(0.0, |sum, tap| sum + nodes[tap] * self.taps[tap][i]);
                    }
                }
            }
        }
    }
}

/// A cell's pixels of one channel, four at a time.
#[inline(always)]
fn interpolate<S: Simd>(simd: S, taps: &[Vec<f32>; TAPS], nodes: &[f32], pixels: &mut [f32]) {
    for (i, pixels) in pixels.chunks_exact_mut(4).enumerate() {
        let mut sum = f32x4::splat(simd, 0.0);
        for (tap, node) in taps.iter().zip(nodes) {
            sum = f32x4::from_slice(simd, &tap[4 * i..4 * i + 4]).mul_add(*node, sum);
        }
        sum.store_slice(pixels);
    }
}

/// A cell's pixels of four channels.
#[inline(always)]
fn interpolate_four<S: Simd>(simd: S, taps: &[Vec<f32>; TAPS], nodes: &[f32], pixels: &mut [f32]) {
    for (i, pixel) in pixels.chunks_exact_mut(4).enumerate() {
        let mut sum = f32x4::splat(simd, 0.0);
        for (tap, node) in taps.iter().zip(nodes.chunks_exact(4)) {
            sum = f32x4::from_slice(simd, node).mul_add(tap[i], sum);
        }
        sum.store_slice(pixel);
    }
}
