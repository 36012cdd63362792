//! Resolve: tiles to the frame.

use std::ops::Range;

use rayon::prelude::*;
use splatvol_core::bin::{TileGrid, TileRect};
use splatvol_scene::Frame;

use super::canvas::Canvas;
use super::tiles::{Tile, lock};

/// Copies the tiles' pixels to the frame, which holds those of the slots; only those within a rectangle of whole tiles, if
/// one is given.
pub(crate) fn resolve(
    (grid, slots): (&TileGrid, &Slots),
    tiles: &[Tile],
    frame: &mut Frame,
    only: Option<TileRect>,
) {
    let held = slots.window;
    let width = frame.image.size().width() as usize;
    let (first, last) = (slots.rows.start, slots.rows.end);
    // The first row of tiles may begin above the frame.
    let head = (((first + 1) * grid.edge).min(held.y1) - held.y0) * width;
    let (pixels, more_pixels) = frame.image.pixels.split_at_mut(head);
    let (depths, more_depths) = frame.depth.split_at_mut(head);
    let (optical_depths, more_optical_depths) = frame.optical_depth.split_at_mut(head);
    let band = |row: usize, mut planes: Planes<'_>| {
        for column in slots.columns.clone() {
            let index = row * grid.columns + column;
            let rect = grid.rect(index);
            if only.is_none_or(|only| only.meets(&rect)) {
                let (canvas, _) = &*lock(&tiles[slots.of(index, grid)]);
                copy(canvas, (rect, held), &mut planes, width);
            }
        }
    };
    let length = width * grid.edge;
    let behind = more_pixels
        .par_chunks_mut(length)
        .zip(more_depths.par_chunks_mut(length))
        .zip(more_optical_depths.par_chunks_mut(length))
        .zip(first + 1..last)
        .with_max_len(1);
    rayon::join(
        || band(first, (pixels, depths, optical_depths)),
        || {
            behind.for_each(|(((pixels, depths), optical_depths), row)| {
                band(row, (pixels, depths, optical_depths));
            });
        },
    );
}

/// Rows of colours, depths and optical depths.
type Planes<'a> = (&'a mut [[f32; 4]], &'a mut [f32], &'a mut [f32]);

/// Copies a tile's pixels to the rows of a frame, which begin where the tile does, or where the frame does.
fn copy(
    canvas: &Canvas,
    (rect, held): (TileRect, TileRect),
    (pixels, depths, optical_depths): &mut Planes<'_>,
    width: usize,
) {
    let own = rect.overlap(&held);
    for (to, y) in (own.y0 - rect.y0..own.y1 - rect.y0).enumerate() {
        let target = to * width + own.x0 - held.x0..to * width + own.x1 - held.x0;
        let source = y * canvas.pitch + own.x0 - rect.x0;
        row_of(
            (canvas, source),
            &mut pixels[target.clone()],
            &mut depths[target.clone()],
            &mut optical_depths[target],
        );
    }
}

/// Where the tiles are kept whose pixels a frame holds.
#[derive(Debug, Clone)]
pub(crate) struct Slots {
    window: TileRect,
    columns: Range<usize>,
    rows: Range<usize>,
}

impl Slots {
    /// Of a frame that holds these pixels.
    pub(crate) fn new(window: TileRect, grid: &TileGrid) -> Self {
        let [columns, rows] = grid.tiles_of(&window);
        Self {
            window,
            columns,
            rows,
        }
    }

    /// Number of tiles.
    pub(crate) fn len(&self) -> usize {
        self.columns.len() * self.rows.len()
    }

    /// Whether the frame has pixels of a tile.
    pub(crate) fn holds(&self, tile: usize, grid: &TileGrid) -> bool {
        self.columns.contains(&(tile % grid.columns)) && self.rows.contains(&(tile / grid.columns))
    }

    /// Place of one of these tiles.
    pub(crate) fn of(&self, tile: usize, grid: &TileGrid) -> usize {
        let (column, row) = (tile % grid.columns, tile / grid.columns);
        (row - self.rows.start) * self.columns.len() + column - self.columns.start
    }
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

/// Pixels of a row of a tile, from one on.
fn row_of(
    (canvas, first): (&Canvas, usize),
    pixels: &mut [[f32; 4]],
    depths: &mut [f32],
    optical_depths: &mut [f32],
) {
    let source = first..first + pixels.len();
    let [r, g, b] = &canvas.color;
    let (r, g, b) = (&r[source.clone()], &g[source.clone()], &b[source.clone()]);
    let (through, depth_sum) = (
        &canvas.transmittance[source.clone()],
        &canvas.depth_sum[source.clone()],
    );
    let integral = canvas.optical_depth.get(source);
    for x in 0..pixels.len() {
        let alpha = 1.0 - through[x];
        pixels[x] = [r[x], g[x], b[x], alpha];
        let optical_depth = || match integral {
            Some(integral) => integral[x],
            None => -libm::logf(through[x].max(f32::MIN_POSITIVE)),
        };
        (depths[x], optical_depths[x]) = if alpha > 0.0 {
            (depth_sum[x] / alpha, optical_depth())
        } else {
            (f32::INFINITY, 0.0)
        };
    }
}
