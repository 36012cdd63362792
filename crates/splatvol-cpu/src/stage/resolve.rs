//! Resolve: a tile's pixels to the frame's planes.

use splatvol_core::bin::TileRect;
use splatvol_core::classification::ClassificationTable;
use splatvol_scene::{Compositing, Frame};

use super::composite::Pixel;
use crate::sheets::extremum::{Extremum, Largest, Smallest};

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

    /// A pixel that nothing was splatted to.
    pub(crate) const EMPTY: Self = Self {
        color: [0.0; 4],
        depth: f32::INFINITY,
        optical_depth: 0.0,
    };
}

/// What a pixel shows in the end. `unit_distance` (world length) is where a value takes its opacity from.
pub(crate) fn resolve(
    pixel: &Pixel,
    compositing: Compositing,
    table: &ClassificationTable,
    unit_distance: f32,
) -> Resolved {
    let pixel = match compositing {
        Compositing::Mip => extreme::<Largest>(pixel, table, unit_distance),
        Compositing::MinimumIntensity => extreme::<Smallest>(pixel, table, unit_distance),
        Compositing::Mean => mean(pixel, table, unit_distance),
        Compositing::Xray => integrated(pixel),
        _ => *pixel,
    };
    shown(&pixel)
}

/// What a pixel shows that is no maximum: itself, or the line integral that it holds.
pub(crate) fn resolve_plain(pixel: &Pixel, is_integral: bool) -> Resolved {
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

/// The largest or smallest value.
fn extreme<E: Extremum>(pixel: &Pixel, table: &ClassificationTable, unit_distance: f32) -> Pixel {
    let at = (E::rank(pixel.total), pixel.depth_sum);
    valued(pixel.depth_sum > 0.0, at, table, unit_distance)
}

/// The mean value, where the ray meets the volume.
fn mean(pixel: &Pixel, table: &ClassificationTable, unit_distance: f32) -> Pixel {
    let [value, most_coverage, _] = pixel.color;
    let at = (value / pixel.total, pixel.depth_sum / pixel.total);
    valued(most_coverage >= 0.5, at, table, unit_distance)
}

/// A value at a depth in its colour, as thick as the unit distance; nothing where there is none.
fn valued(
    is_there: bool,
    (value, depth): (f32, f32),
    table: &ClassificationTable,
    unit_distance: f32,
) -> Pixel {
    let mut shown = Pixel::EMPTY;
    if is_there {
        let [extinction, emission @ ..] = table.at(value);
        if extinction > 0.0 {
            shown.add(
                extinction * unit_distance,
                emission.map(|e| e / extinction),
                depth,
            );
        }
    }
    shown
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

/// Copies a tile's pixels (row by row) into the frame.
pub(crate) fn store(frame: &mut Frame, rect: &TileRect, pixels: &[Resolved]) {
    let width = frame.image.size().width() as usize;
    for (y, row) in (rect.y0..rect.y1).zip(pixels.chunks(rect.x1 - rect.x0)) {
        for (x, pixel) in (rect.x0..rect.x1).zip(row) {
            frame.image.pixels[y * width + x] = pixel.color;
            frame.depth[y * width + x] = pixel.depth;
            frame.optical_depth[y * width + x] = pixel.optical_depth;
        }
    }
}
