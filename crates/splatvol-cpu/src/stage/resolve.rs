//! Resolve: a tile's pixels to the frame's planes.

use splatvol_core::bin::TileRect;
use splatvol_core::classification::ClassificationTable;
use splatvol_scene::{Compositing, Frame};

use super::composite::Pixel;

/// One finished pixel: premultiplied linear colour, depth, optical depth.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Resolved {
    color: [f32; 4],
    depth: f32,
    optical_depth: f32,
}

/// What a pixel shows in the end. `unit_distance` (world length) is where a maximum takes its opacity from.
pub(crate) fn resolve(
    pixel: &Pixel,
    compositing: Compositing,
    table: &ClassificationTable,
    unit_distance: f32,
) -> Resolved {
    let mut pixel = *pixel;
    if compositing == Compositing::Mip && pixel.maximum > f32::NEG_INFINITY {
        let depth = pixel.depth_sum;
        let [extinction, emission @ ..] = table.at(pixel.maximum);
        pixel.depth_sum = 0.0;
        if extinction > 0.0 {
            pixel.add(
                extinction * unit_distance,
                emission.map(|e| e / extinction),
                depth,
            );
        }
    }
    let [r, g, b] = pixel.color;
    let alpha = 1.0 - pixel.transmittance;
    Resolved {
        color: [r, g, b, alpha],
        depth: if alpha > 0.0 {
            pixel.depth_sum / alpha
        } else {
            f32::INFINITY
        },
        optical_depth: -pixel.transmittance.max(f32::MIN_POSITIVE).ln(),
    }
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
