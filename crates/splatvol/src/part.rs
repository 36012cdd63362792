//! Parts of a picture: several workers can render one frame, each some of its pixels.

use splatvol_core::bin::TileRect;
use splatvol_scene::Frame;

/// A part and the pixels next to it.
pub(crate) fn with_neighbors(part: TileRect) -> TileRect {
    TileRect {
        x0: part.x0.saturating_sub(1),
        y0: part.y0.saturating_sub(1),
        x1: part.x1.saturating_add(1),
        y1: part.y1.saturating_add(1),
    }
}

/// Clears a frame except for a part.
pub(crate) fn keep(frame: &mut Frame, part: &TileRect) {
    let width = frame.image.size().width() as usize;
    let is_outside = |i: usize| {
        let (x, y) = (i % width, i / width);
        !(part.x0..part.x1).contains(&x) || !(part.y0..part.y1).contains(&y)
    };
    for i in (0..frame.depth.len()).filter(|&i| is_outside(i)) {
        frame.image.pixels[i] = [0.0; 4];
        frame.depth[i] = f32::INFINITY;
        frame.optical_depth[i] = 0.0;
    }
}
