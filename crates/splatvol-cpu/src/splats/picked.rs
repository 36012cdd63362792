//! Picked: the splats of a range that are projected, sixteen at a time, whether they are neighbours in it or not.

use fearless_simd::{f32x16, prelude::*};

use super::project::LANES;

/// Most splats that a thread projects at a time.
pub(crate) const RANGE: usize = 4096;

/// Indices of the splats of a range that are kept, ascending.
#[derive(Debug)]
pub(crate) struct Kept {
    /// There is room for sixteen more.
    indices: [u32; RANGE + LANES],
    count: usize,
}

impl Kept {
    pub(crate) fn new() -> Self {
        Self {
            indices: [0; RANGE + LANES],
            count: 0,
        }
    }

    /// Keeps those of the sixteen splats from `first` on whose bits are set.
    #[inline(always)]
    pub(crate) fn add(&mut self, first: usize, lanes: u32) {
        // Each is written, and overwritten unless it is counted: no branch that a processor would have to foresee.
        for lane in 0..LANES {
            self.indices[self.count] = (first + lane) as u32;
            self.count += (lanes >> lane & 1) as usize;
        }
    }

    /// All that are kept, sixteen at a time.
    #[inline(always)]
    pub(crate) fn picked(&mut self) -> impl Iterator<Item = Picked<'_>> {
        let count = self.count;
        let last = self.indices[count.saturating_sub(1)];
        self.indices[count..count + LANES].fill(last);
        let (all, _) = self.indices.as_chunks();
        all[..count.div_ceil(LANES)]
            .iter()
            .enumerate()
            .map(move |(number, indices)| Picked {
                indices,
                count: LANES.min(count - number * LANES),
            })
    }
}

/// One to sixteen splats, ascending. Lanes without one repeat the last.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Picked<'a> {
    indices: &'a [u32; LANES],
    count: usize,
}

impl Picked<'_> {
    /// The lanes that have a splat of their own, as bits.
    #[inline(always)]
    pub(crate) fn lanes(&self) -> u32 {
        (1 << self.count) - 1
    }

    /// The index of a lane's splat in its source.
    #[inline(always)]
    pub(crate) fn index(&self, lane: usize) -> usize {
        self.indices[lane] as usize
    }

    /// The index of the last splat.
    #[inline(always)]
    pub(crate) fn last(&self) -> usize {
        self.index(LANES - 1)
    }

    /// Component `k` of the splats' rows, one per lane.
    #[inline(always)]
    pub(crate) fn columns<S: Simd, const N: usize>(&self, simd: S, rows: &[[f32; N]]) -> [f32x16<S>; N] {
        let mut lanes = [[0.0; LANES]; N];
        for lane in 0..LANES {
            let row = rows[self.index(lane)];
            for k in 0..N {
                lanes[k][lane] = row[k];
            }
        }
        vectors(simd, &lanes)
    }
}

/// Component `k` of up to sixteen rows, one per lane, then zeros.
#[inline(always)]
pub(crate) fn columns<S: Simd, const N: usize>(simd: S, rows: &[[f32; N]]) -> [f32x16<S>; N] {
    let mut lanes = [[0.0; LANES]; N];
    for (lane, row) in rows.iter().enumerate().take(LANES) {
        for k in 0..N {
            lanes[k][lane] = row[k];
        }
    }
    vectors(simd, &lanes)
}

#[inline(always)]
fn vectors<S: Simd, const N: usize>(simd: S, lanes: &[[f32; LANES]; N]) -> [f32x16<S>; N] {
    let mut vectors = [f32x16::splat(simd, 0.0); N];
    for k in 0..N {
        vectors[k] = f32x16::simd_from(simd, lanes[k]);
    }
    vectors
}
