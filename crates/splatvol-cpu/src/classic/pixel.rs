//! Pixel: contributions of sheets and splats, and the final colour.
//!
//! `C += T (1 - exp(-tau)) c`, `T *= exp(-tau)`: exact for a colour that is constant within the sheet, self-occlusion
//! included (zwicker2001 eq. 1), where the papers take `exp(-x) = 1 - x`.

use splatvol_core::bin::TileRect;
use splatvol_scene::{Absorption, Frame};

use super::levels::Levels;

/// Optical depth below which material would lose its last digits in `1 - exp(-tau)`.
const THIN: f32 = 0.1;

/// A pixel while its tile is rendered.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pixel {
    /// Transmittance so far.
    pub transmittance: f32,
    /// Premultiplied linear colour so far.
    pub color: [f32; 3],
    /// Sum of depths weighted by the decrease of transmittance in each sheet.
    pub depth_sum: f32,
    /// Optical depth so far (X-ray).
    pub total: f32,
}

impl Pixel {
    /// An empty pixel.
    pub(crate) const EMPTY: Self = Self {
        transmittance: 1.0,
        color: [0.0; 3],
        depth_sum: 0.0,
        total: 0.0,
    };

    /// Adds a slab's share of a line integral: optical depth, emission, and optical depth times camera depth.
    #[inline(always)]
    pub(crate) fn integrate(&mut self, optical_depth: f32, emission: [f32; 3], depth: f32) {
        self.total += optical_depth;
        self.depth_sum += depth;
        for (sum, channel) in self.color.iter_mut().zip(emission) {
            *sum += channel;
        }
    }

    /// Composites material of an optical depth and a (lit) colour, at a depth, behind the pixel.
    #[inline(always)]
    pub(crate) fn add(&mut self, optical_depth: f32, color: [f32; 3], depth: f32) {
        let through = libm::expf(-optical_depth);
        let alpha = if optical_depth < THIN {
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

    /// Composites an opacity and a (lit) colour, at a depth, behind the pixel.
    #[inline(always)]
    pub(crate) fn add_opacity(&mut self, opacity: f32, color: [f32; 3], depth: f32) {
        let share = self.transmittance * opacity;
        for (sum, channel) in self.color.iter_mut().zip(color) {
            *sum += share * channel;
        }
        self.depth_sum += share * depth;
        self.transmittance *= 1.0 - opacity;
    }

    /// Composites a sheet's optical depth and (lit) colour, at a depth, behind the pixel, whose numbers may have levels.
    #[inline(always)]
    pub(crate) fn composite(
        &mut self,
        (optical_depth, absorption): (f32, Absorption),
        color: [f32; 3],
        depth: f32,
        levels: Option<Levels>,
    ) {
        match (absorption, levels) {
            (Absorption::Exp, None) => self.add(optical_depth, color, depth),
            (Absorption::Linear, None) => self.add_opacity(optical_depth.min(1.0), color, depth),
            (_, Some(levels)) => {
                let opacity = match absorption {
                    Absorption::Exp => -libm::expm1f(-optical_depth),
                    Absorption::Linear => optical_depth.min(1.0),
                };
                let share = self.transmittance * opacity;
                for (sum, channel) in self.color.iter_mut().zip(color) {
                    *sum = levels.add(*sum, share * channel);
                }
                self.depth_sum += share * depth;
                self.transmittance = 1.0 - levels.add(1.0 - self.transmittance, share);
            }
        }
    }

    /// As [`Self::add_opacity`], in front of the pixel.
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

/// One finished pixel: premultiplied linear colour, depth, optical depth.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Resolved {
    color: [f32; 4],
    depth: f32,
    optical_depth: f32,
}

impl Resolved {
    /// Linear premultiplied colours.
    pub(crate) fn colors(pixels: &[Self]) -> Vec<[f32; 4]> {
        pixels.iter().map(|pixel| pixel.color).collect()
    }
}

/// Final result of a pixel: the pixel itself, or the line integral that it holds.
pub(crate) fn resolve(pixel: &Pixel, is_integral: bool) -> Resolved {
    if is_integral {
        shown(&integrated(pixel))
    } else {
        shown(pixel)
    }
}

fn shown(pixel: &Pixel) -> Resolved {
    let [r, g, b] = pixel.color;
    let alpha = 1.0 - pixel.transmittance;
    Resolved {
        color: [r, g, b, alpha],
        depth: if alpha > 0.0 {
            pixel.depth_sum / alpha
        } else {
            f32::INFINITY
        },
        optical_depth: -libm::logf(pixel.transmittance.max(f32::MIN_POSITIVE)),
    }
}

/// A line integral as one homogeneous slab.
fn integrated(pixel: &Pixel) -> Pixel {
    let mut shown = Pixel::EMPTY;
    let total = pixel.total;
    if total > 0.0 {
        shown.add(total, pixel.color.map(|e| e / total), pixel.depth_sum / total);
    }
    shown
}

/// Copies a tile's pixels (row by row) into the frame, as far as it holds them.
pub(crate) fn store((frame, held): (&mut Frame, &TileRect), rect: &TileRect, pixels: &[Resolved]) {
    let width = frame.image.size().width() as usize;
    let own = rect.overlap(held);
    for y in own.y0..own.y1 {
        let row = &pixels[(y - rect.y0) * (rect.x1 - rect.x0)..];
        for x in own.x0..own.x1 {
            let (pixel, target) = (&row[x - rect.x0], (y - held.y0) * width + x - held.x0);
            frame.image.pixels[target] = pixel.color;
            frame.depth[target] = pixel.depth;
            frame.optical_depth[target] = pixel.optical_depth;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
