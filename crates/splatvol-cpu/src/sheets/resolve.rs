//! Resolve: tiles to the frame.

use rayon::prelude::*;
use splatvol_core::bin::{TileGrid, TileRect};
use splatvol_scene::Frame;

use super::canvas::Canvas;
use super::engine::{Tile, lock};

/// Copies the tiles' pixels to the frame; only those within a rectangle of whole tiles, if one is given.
pub(crate) fn resolve(grid: &TileGrid, tiles: &[Tile], frame: &mut Frame, only: Option<TileRect>) {
    let width = frame.image.size().width() as usize;
    let band = width * grid.edge;
    let pixels = frame.image.pixels.par_chunks_mut(band);
    let rest = frame
        .depth
        .par_chunks_mut(band)
        .zip(frame.optical_depth.par_chunks_mut(band));
    pixels
        .zip(rest)
        .with_max_len(1)
        .enumerate()
        .for_each(|(row, (pixels, (depths, optical_depths)))| {
            for column in 0..grid.columns {
                let index = row * grid.columns + column;
                let rect = grid.rect(index);
                let holds =
                    |of: TileRect| (of.x0..of.x1).contains(&rect.x0) && (of.y0..of.y1).contains(&rect.y0);
                if !only.is_none_or(holds) {
                    continue;
                }
                let (canvas, _) = &*lock(&tiles[index]);
                for y in 0..rect.y1 - rect.y0 {
                    let target = y * width + rect.x0..y * width + rect.x1;
                    let (depths, optical_depths) =
                        (&mut depths[target.clone()], &mut optical_depths[target.clone()]);
                    row_of(canvas, y, &mut pixels[target], depths, optical_depths);
                }
            }
        });
}

impl Canvas {
    /// Linear premultiplied colours, row by row.
    pub(crate) fn colors(&self, width: usize) -> Vec<[f32; 4]> {
        let [r, g, b] = &self.color;
        (0..self.transmittance.len() / self.pitch)
            .flat_map(|y| y * self.pitch..y * self.pitch + width)
            .map(|i| [r[i], g[i], b[i], 1.0 - self.transmittance[i]])
            .collect()
    }
}

/// A row of a tile.
fn row_of(
    canvas: &Canvas,
    y: usize,
    pixels: &mut [[f32; 4]],
    depths: &mut [f32],
    optical_depths: &mut [f32],
) {
    let source = y * canvas.pitch..y * canvas.pitch + pixels.len();
    let [r, g, b] = &canvas.color;
    let (r, g, b) = (&r[source.clone()], &g[source.clone()], &b[source.clone()]);
    let (through, depth_sum) = (&canvas.transmittance[source.clone()], &canvas.depth_sum[source]);
    for x in 0..pixels.len() {
        let alpha = 1.0 - through[x];
        pixels[x] = [r[x], g[x], b[x], alpha];
        (depths[x], optical_depths[x]) = if alpha > 0.0 {
            (
                depth_sum[x] / alpha,
                -libm::logf(through[x].max(f32::MIN_POSITIVE)),
            )
        } else {
            (f32::INFINITY, 0.0)
        };
    }
}
