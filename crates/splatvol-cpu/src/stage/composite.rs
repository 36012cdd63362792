//! Composite: what a sheet adds to a pixel, front to back, and which blocks of pixels are finished.
//!
//! `C += T (1 - exp(-tau)) c`, `T *= exp(-tau)`: exact for a colour that is constant within the sheet, self-occlusion
//! included (zwicker2001 eq. 1), where the papers take `exp(-x) = 1 - x`.

use splatvol_core::bin::{ProjectedBrick, TileRect};

/// A pixel while its tile is rendered.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pixel {
    /// What comes through so far.
    pub transmittance: f32,
    /// Premultiplied linear colour so far; for a mean the integral of the value, and the largest coverage.
    pub color: [f32; 3],
    /// Depth weighted by what each sheet took from the transmittance.
    pub depth_sum: f32,
    /// Largest rank so far (largest or smallest value), optical depth so far (X-ray), or integral of the coverage (mean).
    pub total: f32,
    /// No sheet can change it any more.
    pub finished: bool,
}

impl Pixel {
    /// Nothing yet.
    pub(crate) const EMPTY: Self = Self {
        transmittance: 1.0,
        color: [0.0; 3],
        depth_sum: 0.0,
        total: 0.0,
        finished: false,
    };

    /// The same for a colour that runs linearly with optical depth from `mean + half_step` to `mean - half_step`: what lies
    /// in front is seen better, by `half_step ((1 + exp(-tau)) - 2 (1 - exp(-tau)) / tau)`.
    #[inline(always)]
    pub(crate) fn add_gradient(
        &mut self,
        optical_depth: f32,
        mean: [f32; 3],
        half_step: [f32; 3],
        depth: f32,
    ) {
        let before = self.transmittance;
        self.add(optical_depth, mean, depth);
        // The series tau^2 / 6 (1 - tau / 2 + 3 tau^2 / 20) where the difference would cancel.
        let tau = optical_depth;
        let advantage = if tau < 0.3 {
            tau * tau / 6.0 * (1.0 - tau * (0.5 - 0.15 * tau))
        } else {
            let through = libm::expf(-tau);
            1.0 + through - 2.0 * (1.0 - through) / tau
        };
        for (sum, step) in self.color.iter_mut().zip(half_step) {
            *sum += before * advantage * step;
        }
    }

    /// Adds what a slab holds of a line integral: optical depth, emission, and optical depth times camera depth.
    #[inline(always)]
    pub(crate) fn integrate(&mut self, optical_depth: f32, emission: [f32; 3], depth: f32) {
        self.total += optical_depth;
        self.depth_sum += depth;
        for (sum, channel) in self.color.iter_mut().zip(emission) {
            *sum += channel;
        }
    }

    /// Puts material of an optical depth and a (lit) colour at a depth behind what is there.
    #[inline(always)]
    pub(crate) fn add(&mut self, optical_depth: f32, color: [f32; 3], depth: f32) {
        let through = libm::expf(-optical_depth);
        // Thin material would lose its last digits in 1 - exp(-tau).
        let alpha = if optical_depth < 0.1 {
            -libm::expm1f(-optical_depth)
        } else {
            1.0 - through
        };
        let share = self.transmittance * alpha;
        for (sum, channel) in self.color.iter_mut().zip(color) {
            *sum += share * channel;
        }
        self.depth_sum += share * depth;
        self.transmittance *= through;
    }

    /// Puts something of an opacity and a (lit) colour at a depth behind what is there.
    #[inline(always)]
    pub(crate) fn add_opacity(&mut self, opacity: f32, color: [f32; 3], depth: f32) {
        let share = self.transmittance * opacity;
        for (sum, channel) in self.color.iter_mut().zip(color) {
            *sum += share * channel;
        }
        self.depth_sum += share * depth;
        self.transmittance *= 1.0 - opacity;
    }

    /// Puts it before what is there.
    #[inline(always)]
    pub(crate) fn cover(&mut self, opacity: f32, color: [f32; 3], depth: f32) {
        let through = 1.0 - opacity;
        for (sum, channel) in self.color.iter_mut().zip(color) {
            *sum = *sum * through + opacity * channel;
        }
        self.depth_sum = self.depth_sum * through + opacity * depth;
        self.transmittance *= through;
    }
}

/// Pixels that are not finished, per 8 x 8 block of a tile.
#[derive(Debug, Clone, Default)]
pub(crate) struct OpenBlocks {
    counts: Vec<u32>,
    columns: usize,
    left: u32,
}

impl OpenBlocks {
    const EDGE: usize = 8;

    /// All pixels of a tile are open.
    pub(crate) fn reset(&mut self, rect: &TileRect) {
        let (width, height) = (rect.x1 - rect.x0, rect.y1 - rect.y0);
        self.columns = width.div_ceil(Self::EDGE);
        self.left = (width * height) as u32;
        self.counts.clear();
        for y in (0..height).step_by(Self::EDGE) {
            for x in (0..width).step_by(Self::EDGE) {
                self.counts
                    .push(((width - x).min(Self::EDGE) * (height - y).min(Self::EDGE)) as u32);
            }
        }
    }

    /// Notes that the pixel at tile position x, y is finished.
    #[inline(always)]
    pub(crate) fn finish(&mut self, x: usize, y: usize) {
        self.counts[y / Self::EDGE * self.columns + x / Self::EDGE] -= 1;
        self.left -= 1;
    }

    /// True when the tile is finished.
    pub(crate) fn none_left(&self) -> bool {
        self.left == 0
    }

    /// True where every pixel that a brick can touch in this tile is finished.
    pub(crate) fn hide(&self, brick: &ProjectedBrick, rect: &TileRect) -> bool {
        let block = |pixel: f32, low: usize, high: usize| {
            (pixel.clamp(low as f32, high as f32 - 1.0) as usize - low) / Self::EDGE
        };
        let [x0, y0, x1, y1] = brick.rect;
        let columns = block(x0, rect.x0, rect.x1)..=block(x1, rect.x0, rect.x1);
        let mut rows = block(y0, rect.y0, rect.y1)..=block(y1, rect.y0, rect.y1);
        rows.all(|row| {
            columns
                .clone()
                .all(|column| self.counts[row * self.columns + column] == 0)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use splatvol_core::brick::ActiveBrick;

    #[test]
    fn a_thousand_thin_sheets_are_one_thick_one() {
        let (mut thin, mut thick) = (Pixel::EMPTY, Pixel::EMPTY);
        thick.add(2.0, [1.0, 0.5, 0.25], 7.0);
        for _ in 0..1000 {
            thin.add(0.002, [1.0, 0.5, 0.25], 7.0);
        }
        assert!((thin.transmittance - (-2.0f32).exp()).abs() < 1e-5);
        assert!((thin.color[1] - thick.color[1]).abs() < 1e-5);
        assert!((thin.depth_sum - thick.depth_sum).abs() < 1e-4);
    }

    #[test]
    fn a_colour_gradient_is_that_of_many_sheets() {
        for tau in [0.02f32, 0.29, 0.31, 1.5, 6.0] {
            let (mut fine, mut one) = (Pixel::EMPTY, Pixel::EMPTY);
            let steps = 4000;
            for i in 0..steps {
                let t = (i as f32 + 0.5) / steps as f32;
                fine.add(tau / steps as f32, [0.9 - 0.8 * t, 0.1 + 0.8 * t, 0.5], 1.0);
            }
            one.add_gradient(tau, [0.5, 0.5, 0.5], [0.4, -0.4, 0.0], 1.0);
            for channel in 0..3 {
                let error = (fine.color[channel] - one.color[channel]).abs();
                assert!(error < 2e-5, "{tau}: {:?} {:?}", fine.color, one.color);
            }
        }
    }

    #[test]
    fn blocks_at_the_border_hold_fewer_pixels() {
        let rect = TileRect {
            x0: 64,
            y0: 0,
            x1: 75,
            y1: 9,
        };
        let mut open = OpenBlocks::default();
        open.reset(&rect);
        let brick = |rect| ProjectedBrick {
            active: ActiveBrick {
                brick: 0,
                blocks: 255,
            },
            front_sheet: 0,
            rect,
        };
        for y in 0..9 {
            for x in 8..11 {
                open.finish(x, y);
            }
        }
        assert!(open.hide(&brick([72.0, -5.0, 900.0, 900.0]), &rect));
        assert!(!open.hide(&brick([71.0, 0.0, 74.0, 3.0]), &rect));
        assert!(!open.none_left());
    }
}
