//! Footprint: a voxel's blocks in the rings, by powers that follow by multiplication from column to column and from row to row
//! (`super::splat`).
//!
//! Sums of a footprint are compiled for each size of footprints, whatever the payload: a payload differs in its weights only,
//! which are prepared before, or adds derivatives, too (`gradients`, `slopes`).

use std::ops::Range;

use fearless_simd::{f32x4, f32x8, f32x16, prelude::*};
use splatvol_core::plan::SplatConstants;

use super::records::Records;
use super::ring::{Block, Row};
use super::sheet::{GroupShape, Lanes16};
use super::splat::{Stencil, load, origin_block};
use super::tile::MAX_CHANNELS;

/// Footprints of a voxel in the rings, block by block. Compiled for each size of footprints; payloads share them.
pub(crate) trait Footprint {
    /// Whether the payload's weights are used.
    const WEIGHTED: bool;

    /// Adds a voxel's footprint to each ring. `CAPACITY` is the number of blocks along the edge, or the most of these.
    fn add<S: Simd, const CAPACITY: usize, const ELLIPSES: bool>(
        simd: S,
        voxel: &Voxel<'_, S, CAPACITY>,
        rings: &mut [&mut [Row]],
    );
}

/// One footprint in every ring, times a weight for each.
pub(crate) struct Scaled;

impl Footprint for Scaled {
    const WEIGHTED: bool = true;

    #[inline(always)]
    fn add<S: Simd, const CAPACITY: usize, const ELLIPSES: bool>(
        simd: S,
        voxel: &Voxel<'_, S, CAPACITY>,
        rings: &mut [&mut [Row]],
    ) {
        for (ring, weight) in rings.iter_mut().zip(voxel.weights) {
            let Some(rows) = voxel.rows(ring) else {
                continue;
            };
            let down = voxel.down::<ELLIPSES>(simd, load(simd, weight));
            voxel.add_product::<ELLIPSES>(simd, &down, rows);
        }
    }
}

/// A voxel about to be splatted into a group of sheets.
pub(crate) struct Voxel<'a, S: Simd, const CAPACITY: usize> {
    pub records: &'a Records,
    pub index: usize,
    pub constants: &'a SplatConstants,
    pub shape: &'a GroupShape,
    pub stencil: &'a Stencil,
    /// Blocks along the footprint's edge: `CAPACITY`, but where one body is compiled for several sizes.
    pub size: usize,
    pub steps: Steps<S, CAPACITY>,
    /// The footprint at the raster point that its powers count from, and the profile in depth: four sheets, twice.
    pub lateral: f32x8<S>,
    pub depth: f32x8<S>,
    /// What the footprint is multiplied by in each ring.
    pub weights: &'a [Lanes16; MAX_CHANNELS],
    /// Column of the first block.
    pub column: usize,
}

impl<S: Simd, const CAPACITY: usize> Voxel<'_, S, CAPACITY> {
    /// Rows of a ring that the footprint touches.
    #[inline(always)]
    pub(crate) fn rows<'r>(&self, ring: &'r mut [Row]) -> Option<&'r mut [Row]> {
        let row = self.records.row[self.index] as usize;
        ring.get_mut(row..row + self.size)
    }

    /// Columns of a ring that the footprint touches.
    #[inline(always)]
    pub(crate) fn columns(&self) -> Range<usize> {
        self.column..self.column + self.size
    }

    /// Whether a block is left out.
    #[inline(always)]
    pub(crate) fn lacks<const ELLIPSES: bool>(&self, row: usize, column: usize) -> bool {
        self.stencil.needed.lacks::<ELLIPSES>(self.size, [row, column])
    }

    /// Powers of the rows, times a weight.
    #[inline(always)]
    pub(crate) fn down<const ELLIPSES: bool>(&self, simd: S, weight: f32x16<S>) -> [f32x16<S>; CAPACITY] {
        let Self {
            steps, stencil, size, ..
        } = self;
        let origin = origin_block(*size, ELLIPSES);
        let mut down = [steps.origin * weight; CAPACITY];
        for r in origin + 1..*size {
            down[r] = down[r - 1] * steps.forward;
        }
        for r in (0..origin).rev() {
            down[r] = down[r + 1] * steps.back;
        }
        if !ELLIPSES {
            for b in 0..*size {
                down[b] *= load(simd, &stencil.rows[b]);
            }
        }
        down
    }

    /// Adds the product of columns and rows, of ellipses times their stencil, to the blocks from the first column on.
    #[inline(always)]
    fn add_product<const ELLIPSES: bool>(&self, simd: S, down: &[f32x16<S>; CAPACITY], rows: &mut [Row]) {
        // Slices of one length: no test of an index is left in the inner loop.
        let size = self.size;
        let (across, rows, down) = (&self.steps.across[..size], &mut rows[..size], &down[..size]);
        for r in 0..size {
            let line = &mut rows[r].0[self.columns()][..size];
            let stencil = &self.stencil.blocks[r][..size];
            for c in 0..size {
                if self.lacks::<ELLIPSES>(r, c) {
                    continue;
                }
                let weights = if ELLIPSES {
                    across[c] * load(simd, &stencil[c])
                } else {
                    across[c]
                };
                accumulate(simd, weights * down[r], &mut line[c]);
            }
        }
    }
}

/// Powers of a voxel's columns, and the factors from row to row.
pub(crate) struct Steps<S: Simd, const CAPACITY: usize> {
    pub across: [f32x16<S>; CAPACITY],
    /// Factors of the rows in the block from which they are counted.
    origin: f32x16<S>,
    forward: f32x16<S>,
    back: f32x16<S>,
}

/// Four numbers in all quarters of a vector.
#[inline(always)]
fn four_times<S: Simd>(four: f32x4<S>) -> f32x16<S> {
    let both = four.combine(four);
    both.combine(both)
}

impl<S: Simd, const CAPACITY: usize> Steps<S, CAPACITY> {
    #[inline(always)]
    pub(super) fn of_round(simd: S, size: usize, bases: f32x8<S>, stencil: &Stencil) -> Self {
        let (p, q) = bases.split();
        let one = f32x4::splat(simd, 1.0);
        let columns = one.combine(p);
        let mut across = [columns.combine(columns); CAPACITY];
        let p = four_times(p);
        let forward = p * p;
        for b in 1..size {
            across[b] = across[b - 1] * forward;
        }
        for b in 0..size {
            across[b] *= load(simd, &stencil.columns[b]);
        }
        let origin = one.combine(one).combine(q.combine(q));
        let q = four_times(q);
        Self {
            across,
            origin,
            forward: q * q,
            back: q,
        }
    }

    #[inline(always)]
    pub(super) fn of_ellipse(simd: S, size: usize, bases: f32x8<S>) -> Self {
        let origin = origin_block(size, true);
        let (p, q) = bases.split();
        let inverse = f32x8::splat(simd, 1.0) / bases;
        let (p_back, q_back) = (inverse * inverse).split();
        let one = f32x4::splat(simd, 1.0);
        let columns = one.combine(p);
        let mut across = [columns.combine(columns); CAPACITY];
        let p = four_times(p);
        let (forward, back) = (p * p, four_times(p_back));
        for b in origin + 1..size {
            across[b] = across[b - 1] * forward;
        }
        for b in (0..origin).rev() {
            across[b] = across[b + 1] * back;
        }
        let rows = one.combine(one).combine(q.combine(q));
        let q = four_times(q);
        Self {
            across,
            origin: rows,
            forward: q * q,
            back: four_times(q_back),
        }
    }
}

/// Adds to a block.
#[inline(always)]
pub(crate) fn accumulate<S: Simd>(simd: S, weights: f32x16<S>, block: &mut Block) {
    (weights + f32x16::from_slice(simd, &block.0)).store_slice(&mut block.0);
}
