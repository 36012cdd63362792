//! Rasterise: a footprint's pixels, row by row.
//!
//! | module | what |
//! |---|---|
//! | here | evaluated pixel by pixel, or by the profile row by row |
//! | `tables` | looked up, as FastSplats |
//! | `linear`, `circle`, `ellipse`, `rlut`, `blit` | how a look-up finds its entry (huang2000 section 3) |
//! | `snap` | grids of sub-pixel positions |

mod blit;
mod circle;
mod ellipse;
mod linear;
mod rlut;
mod snap;
mod tables;
#[cfg(test)]
mod tests;

use splatvol_core::bin::TileRect;
use splatvol_core::splats::{Footprint, Moving, Profile, Warp};

pub(crate) use tables::Tables;

/// Receives rows of weights (world length).
pub(crate) trait Target {
    /// Pixels from x, y of the tile on.
    fn row(&mut self, place: (usize, usize), weights: &[f32]);
}

/// Draws footprints into a tile.
#[derive(Debug)]
pub(crate) struct Brush<'a, P> {
    pub profile: &'a P,
    /// Lookup tables of the footprints; `None` where footprints are evaluated.
    pub tables: Option<&'a Tables>,
    /// The tile's pixels.
    pub rect: TileRect,
}

/// A part of a kernel: between two camera depths.
pub(crate) type Section = [f32; 2];

/// Largest lean of a kernel's middle over its footprint, standard deviations, for which one section serves all its
/// pixels.
const UPRIGHT: f32 = 2e-3;

impl<P: Profile> Brush<'_, P> {
    /// Tile pixels that a footprint may cover: x0, y0, x1, y1, ends excluded; `None` where there are none.
    #[inline(always)]
    pub(crate) fn area(&self, footprint: &Footprint) -> Option<[usize; 4]> {
        let [x0, y0, x1, y1] = footprint.bounds;
        let TileRect {
            x0: left,
            y0: top,
            x1: right,
            y1: bottom,
        } = self.rect;
        let first = |at: f32, low: usize| (at - 0.5).ceil().max(low as f32);
        let last = |at: f32, high: usize| (at - 0.5).floor().min(high as f32 - 1.0);
        let (ax, bx) = (first(x0, left), last(x1, right));
        let (ay, by) = (first(y0, top), last(y1, bottom));
        // Also false where a bound is not a number.
        if !(ax <= bx && ay <= by) {
            return None;
        }
        Some([
            ax as usize - left,
            ay as usize - top,
            bx as usize + 1 - left,
            by as usize + 1 - top,
        ])
    }

    /// Draws a footprint, or a section of it.
    #[inline(always)]
    pub(crate) fn draw<T: Target>(
        &self,
        footprint: &Footprint,
        section: Option<Section>,
        [x0, y0, x1, y1]: [usize; 4],
        row: &mut Vec<f32>,
        target: &mut T,
    ) {
        if let Some(tables) = self.tables {
            tables.fill(footprint, section, (&self.rect, [x0, y0, x1, y1]), row);
            for (y, weights) in (y0..y1).zip(row.chunks_exact(x1 - x0)) {
                target.row((x0, y), weights);
            }
            return;
        }
        row.resize(row.len().max(x1), 0.0);
        let weights = &mut row[..x1 - x0];
        let left = (self.rect.x0 + x0) as f32 + 0.5;
        let share = self.share(footprint, section);
        for y in y0..y1 {
            let py = (self.rect.y0 + y) as f32 + 0.5;
            match (footprint.warp, share) {
                (Warp::Affine { conic, .. }, Some(share)) => {
                    squares(
                        conic,
                        [left - footprint.centre[0], py - footprint.centre[1]],
                        weights,
                    );
                    self.profile.whole_row(weights);
                    let scale = footprint.weight * share;
                    for weight in &mut *weights {
                        *weight *= scale;
                    }
                }
                (Warp::Moving(moving), _) => {
                    self.moving_row((footprint, &moving), section, [left, py], weights);
                }
                _ => self.general_row(footprint, section, [left, py], weights),
            }
            target.row((x0, y), weights);
        }
    }

    /// The share of the kernel in a section; `None` where it varies between rays.
    #[inline(always)]
    fn share(&self, footprint: &Footprint, section: Option<Section>) -> Option<f32> {
        let Some([near, far]) = footprint.section(section) else {
            return Some(1.0);
        };
        let Warp::Affine { slope, .. } = footprint.warp else {
            return None;
        };
        let [x0, y0, x1, y1] = footprint.bounds;
        let lean = slope[0].abs() * (x1 - x0) + slope[1].abs() * (y1 - y0);
        let sigma = footprint.depth_sigma;
        if !self.profile.is_separable() || lean > UPRIGHT * sigma {
            return None;
        }
        let t = |depth: f32| (depth - footprint.depth) / sigma;
        Some(self.profile.between(0.0, t(near), t(far)))
    }

    #[inline(always)]
    fn moving_row(
        &self,
        (footprint, moving): (&Footprint, &Moving),
        section: Option<Section>,
        [left, py]: [f32; 2],
        weights: &mut [f32],
    ) {
        let cut = self.profile.cut();
        for (i, weight) in weights.iter_mut().enumerate() {
            let passage = footprint.passage(moving, [left + i as f32, py]);
            let nearest = passage.nearest_squared();
            *weight = 0.0;
            if nearest >= cut * cut {
                continue;
            }
            let value = if moving.capsule {
                self.profile.whole(nearest)
            } else {
                self.profile
                    .mean_along(passage.across_squared, passage.along, passage.length)
            };
            let share = match footprint.section(section) {
                None => 1.0,
                Some([near, far]) => {
                    let [depth, depth_sigma] = passage.depth();
                    let inverse = 1.0 / depth_sigma.max(1e-20);
                    self.profile
                        .share(nearest, (near - depth) * inverse, (far - depth) * inverse)
                }
            };
            *weight = footprint.weight * passage.gain * value * share;
        }
    }

    #[inline(always)]
    fn general_row(
        &self,
        footprint: &Footprint,
        section: Option<Section>,
        [left, py]: [f32; 2],
        weights: &mut [f32],
    ) {
        for (i, weight) in weights.iter_mut().enumerate() {
            *weight = footprint.integral(self.profile, section, [left + i as f32, py]);
        }
    }
}

/// `d^T Q d` of a row of pixels, the first at this offset.
#[inline(always)]
fn squares([xx, xy, yy]: [f32; 3], [dx, dy]: [f32; 2], row: &mut [f32]) {
    let (cross, constant) = (2.0 * xy * dy, yy * dy * dy);
    for (i, squared) in row.iter_mut().enumerate() {
        let dx = dx + i as f32;
        *squared = (xx * dx + cross) * dx + constant;
    }
}
