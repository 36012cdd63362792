//! `blit-2d`: precomputed footprints, one per integer radius and sub-pixel position (huang2000 section 3.2).
//!
//! Centres are snapped to a grid of k x k cells per pixel and radii to whole pixels; a splat whose radius is
//! rounded keeps its mass. A precomputed footprint is a *rasterisation map*: it holds the table index of each
//! pixel. So one map serves all sections of the kernel, where the paper needs a footprint for each. A map is made
//! for the first splat that needs it. It holds `k^2 (2 r + 1)^2` numbers of 16 bits for the radius r (eq. 5 is the
//! sum of `k^2 r^2`); the paper's use of symmetry is left out.

use std::sync::OnceLock;

use splatvol_core::radial::Entry;
use splatvol_core::splats::{Footprint, Warp};

use super::snap::SubpixelGrid;
use super::tables::{Block, Lookup};

/// Largest radius with maps, pixels; larger footprints look up their entries pixel by pixel.
const MOST: usize = 64;

/// Maps of all radii.
#[derive(Debug)]
pub(super) struct Blits {
    grid: SubpixelGrid,
    /// Index of the table's last entry.
    last: usize,
    /// Per radius, for each cell: entries, row by row of `2 r + 1` pixels.
    maps: Vec<OnceLock<Vec<u16>>>,
}

impl Blits {
    /// Empty maps, with so many cells per pixel and table entries.
    pub(super) fn new(count: usize, entries: usize) -> Self {
        Self {
            grid: SubpixelGrid { count },
            last: entries - 1,
            maps: (0..=MOST).map(|_| OnceLock::new()).collect(),
        }
    }

    /// Rounds a circle's centre and radius. `cut`: the radius in standard deviations.
    #[inline]
    pub(super) fn snap(&self, footprint: Footprint, cut: f32) -> Footprint {
        let Warp::Affine { conic, slope } = footprint.warp else {
            return footprint;
        };
        let radius = cut / conic[0].sqrt();
        let whole = radius.round().max(1.0);
        let shrunk = (radius / whole).powi(2);
        let [x, y] = footprint.centre.map(|position| self.grid.snap(position));
        Footprint {
            centre: [x, y],
            bounds: [x - whole, y - whole, x + whole, y + whole],
            weight: footprint.weight * shrunk,
            warp: Warp::Affine {
                conic: conic.map(|q| q * shrunk),
                slope,
            },
            ..footprint
        }
    }

    /// Fills a block of a circle whose radius, pixels, is a whole number up to rounding.
    pub(super) fn fill<E: Entry>(
        &self,
        lookup: &Lookup<'_, E>,
        radius: f32,
        centre: [f32; 2],
        block: &Block,
        weights: &mut [f32],
    ) {
        let radius = radius.round().max(1.0);
        let [(px, cell_x), (py, cell_y)] = centre.map(|position| self.grid.pixel_and_cell(position));
        let [left, top] = [block.first[0] as i64 - px, block.first[1] as i64 - py];
        let whole = radius as i64;
        let map = self.map(whole as usize, [cell_x, cell_y]);
        let edge = 2 * whole as usize + 1;
        for (y, row) in weights.chunks_exact_mut(block.size[0]).enumerate() {
            let place = |column: i64, line: i64| {
                let (column, line) = (usize::try_from(column).ok()?, usize::try_from(line).ok()?);
                Some(line * edge + column)
            };
            let start = place(left + whole, top + y as i64 + whole);
            let drawn = start.and_then(|start| map?.get(start..start + row.len()));
            match drawn {
                Some(entries) => {
                    for (weight, &entry) in row.iter_mut().zip(entries) {
                        *weight = lookup.entry(usize::from(entry));
                    }
                }
                None => {
                    for (x, weight) in row.iter_mut().enumerate() {
                        let pixel = [left + x as i64, top + y as i64];
                        *weight = lookup.entry(self.index(radius, [cell_x, cell_y], pixel));
                    }
                }
            }
        }
    }

    /// The map of a cell, where the radius has maps.
    fn map(&self, radius: usize, [cell_x, cell_y]: [usize; 2]) -> Option<&[u16]> {
        let count = self.grid.count;
        let maps = self.maps.get(radius)?.get_or_init(|| {
            let reach = -(radius as i64)..=radius as i64;
            (0..count * count)
                .flat_map(|cell| reach.clone().map(move |y| (cell, y)))
                .flat_map(|(cell, y)| reach.clone().map(move |x| (cell, [x, y])))
                .map(|(cell, pixel)| self.index(radius as f32, [cell % count, cell / count], pixel) as u16)
                .collect()
        });
        let size = (2 * radius + 1).pow(2);
        let cell = cell_y * count + cell_x;
        maps.get(cell * size..(cell + 1) * size)
    }

    /// The entry of a pixel, relative to the centre's.
    fn index(&self, radius: f32, [cell_x, cell_y]: [usize; 2], [x, y]: [i64; 2]) -> usize {
        let (dx, dy) = (self.grid.offset(cell_x, x), self.grid.offset(cell_y, y));
        let share = (dx * dx + dy * dy) / (radius * radius);
        ((share * self.last as f32 + 0.5) as usize).min(self.last)
    }

    /// Memory of the maps made so far.
    #[cfg(test)]
    pub(super) fn bytes(&self) -> usize {
        let of_map = |map: &Vec<u16>| size_of_val(map.as_slice());
        self.maps.iter().filter_map(OnceLock::get).map(of_map).sum()
    }
}
