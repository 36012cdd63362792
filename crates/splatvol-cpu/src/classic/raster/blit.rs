//! `blit-2d`: footprints drawn beforehand, one per integer radius, sub-pixel position and section (huang2000 section 3.2).
//!
//! Centres are snapped to a grid of k x k cells per pixel and radii to whole pixels. As in the paper, a splat whose radius is
//! rounded keeps its height, so that it gains or loses mass by the square of the rounding. A *drawn footprint* holds
//! the section's value at each pixel, so that drawing a splat is adding a block of numbers. It is drawn for the first splat that needs it,
//! as a kernel has more sections than a picture cuts from it. It holds `k^2 (2 r + 1)^2` numbers of 32 bits for the
//! radius r (eq. 5 is the sum of `k^2 r^2`, in 8 bits); the paper's use of symmetry is left out.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use splatvol_core::radial::Entry;
use splatvol_core::splats::{Footprint, Warp};

use super::snap::SubpixelGrid;
use super::tables::{Block, Lookup};

/// Largest radius that is drawn beforehand, pixels; larger footprints look up their entries pixel by pixel.
const MOST: usize = 64;
/// Most memory of drawn footprints, bytes; those for which none is left look up their entries, with the same values.
const MEMORY: usize = 256 << 20;

/// Drawn footprints of all radii.
#[derive(Debug)]
pub(super) struct Blits {
    grid: SubpixelGrid,
    /// Index of the table's last entry.
    last: usize,
    /// Sections of the table.
    sections: usize,
    /// Per radius, for each section, front row by front row.
    drawn: Vec<OnceLock<Box<[Drawn]>>>,
    /// Memory of the drawn footprints.
    bytes: AtomicUsize,
}

/// Of a section, for each cell: values in units of the table's entries, row by row of `2 r + 1` pixels; empty where no memory
/// is left.
type Drawn = OnceLock<Box<[f32]>>;

impl Blits {
    /// Nothing drawn yet, with so many cells per pixel, for tables of so many entries and sections.
    pub(super) fn new(count: usize, entries: usize, sections: usize) -> Self {
        Self {
            grid: SubpixelGrid { count },
            last: entries - 1,
            sections,
            drawn: (0..=MOST).map(|_| OnceLock::new()).collect(),
            bytes: AtomicUsize::new(0),
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
            warp: Warp::Affine {
                conic: conic.map(|q| q * shrunk),
                slope,
            },
            ..footprint
        }
    }

    /// Fills a block of a section between two `depths`, rows of the table, of a circle whose radius, pixels, is a whole
    /// number up to rounding.
    pub(super) fn fill<E: Entry>(
        &self,
        (lookup, depths): (&Lookup<'_, E>, [usize; 2]),
        radius: f32,
        centre: [f32; 2],
        block: &Block,
        weights: &mut [f32],
    ) {
        let radius = radius.round().max(1.0);
        let [(px, cell_x), (py, cell_y)] = centre.map(|position| self.grid.pixel_and_cell(position));
        let [left, top] = [block.first[0] as i64 - px, block.first[1] as i64 - py];
        let whole = radius as i64;
        let drawn = self.drawn(whole as usize, [cell_x, cell_y], (lookup, depths));
        let edge = 2 * whole as usize + 1;
        for (y, row) in weights.chunks_exact_mut(block.size[0]).enumerate() {
            let place = |column: i64, line: i64| {
                let (column, line) = (usize::try_from(column).ok()?, usize::try_from(line).ok()?);
                Some(line * edge + column)
            };
            let start = place(left + whole, top + y as i64 + whole);
            let values = start.and_then(|start| drawn?.get(start..start + row.len()));
            match values {
                Some(values) => {
                    for (weight, value) in row.iter_mut().zip(values) {
                        *weight = value * lookup.scale();
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

    /// The drawn footprint of a cell, where there is one.
    fn drawn<E: Entry>(
        &self,
        radius: usize,
        [cell_x, cell_y]: [usize; 2],
        (lookup, [front, back]): (&Lookup<'_, E>, [usize; 2]),
    ) -> Option<&[f32]> {
        let rows = self.sections + 1;
        let sections = self.drawn.get(radius)?;
        let sections = sections.get_or_init(|| (0..rows * rows).map(|_| OnceLock::new()).collect());
        let drawn = sections.get(front * rows + back)?;
        let drawn = drawn.get_or_init(|| self.draw(radius, lookup));
        let size = (2 * radius + 1).pow(2);
        let cell = cell_y * self.grid.count + cell_x;
        drawn.get(cell * size..(cell + 1) * size)
    }

    /// Draws a section of a radius in each cell.
    fn draw<E: Entry>(&self, radius: usize, lookup: &Lookup<'_, E>) -> Box<[f32]> {
        let count = self.grid.count;
        let bytes = size_of::<f32>() * (count * (2 * radius + 1)).pow(2);
        let before = self.bytes.fetch_add(bytes, Ordering::Relaxed);
        if before + bytes > MEMORY {
            self.bytes.fetch_sub(bytes, Ordering::Relaxed);
            return Box::default();
        }
        let reach = -(radius as i64)..=radius as i64;
        (0..count * count)
            .flat_map(|cell| reach.clone().map(move |y| (cell, y)))
            .flat_map(|(cell, y)| reach.clone().map(move |x| (cell, [x, y])))
            .map(|(cell, pixel)| self.index(radius as f32, [cell % count, cell / count], pixel))
            .map(|index| lookup.number(index))
            .collect()
    }

    /// The entry of a pixel, relative to the centre's.
    fn index(&self, radius: f32, [cell_x, cell_y]: [usize; 2], [x, y]: [i64; 2]) -> usize {
        let (dx, dy) = (self.grid.offset(cell_x, x), self.grid.offset(cell_y, y));
        let share = (dx * dx + dy * dy) / (radius * radius);
        ((share * self.last as f32 + 0.5) as usize).min(self.last)
    }

    /// Memory of the footprints drawn so far.
    #[cfg(test)]
    pub(super) fn bytes(&self) -> usize {
        self.bytes.load(Ordering::Relaxed)
    }
}
