//! Sums of the kernels around samples of a structured block, found by index.
//!
//! Beyond the border, and in place of samples without a kernel, the block is continued by its last kernel: the
//! kernel nearest to the border, or the sample's own, repeated along its steps.

use fearless_simd::Level;
use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::Sample;
use super::packets::{Evaluated, LANES, Packet, sum_at};
use super::structured::{BlockLattice, index_of};

/// Neighbours along an axis that a kernel reaches: four of its standard deviations of 0.74 voxels.
pub(super) const REACH: usize = 3;

/// The kernels of a block.
pub(super) struct LatticeKernels<'a> {
    lattice: &'a BlockLattice,
    kernels: Vec<Evaluated>,
    /// Derivative of space by the index.
    steps: &'a [DMat3],
    /// True for samples amid others that all have kernels.
    is_amid: Vec<bool>,
    level: Level,
}

impl<'a> LatticeKernels<'a> {
    pub(super) fn new(lattice: &'a BlockLattice, samples: &[Sample], steps: &'a [DMat3]) -> Self {
        let kernels: Vec<Evaluated> = samples.par_iter().map(Evaluated::new).collect();
        let is_legal = kernels.iter().map(Evaluated::is_legal).collect();
        Self {
            lattice,
            is_amid: (0..3).fold(is_legal, |marked, axis| amid(&marked, lattice.dims, axis)),
            kernels,
            steps,
            level: Level::new(),
        }
    }

    /// The sum of all kernels at a sample, 1 where it has none.
    pub(super) fn sum(&self, around: &mut Around, index: usize, masses: &[f64]) -> f64 {
        let place = self.kernels[index].position;
        if !self.kernels[index].is_legal() {
            return 1.0;
        }
        self.gather::<true>(around, index, masses);
        sum_at(self.level, place, &around.packets, &around.weights)
    }

    /// The parts of the sums at places inside a sample's region that come from beyond the border and from blanked
    /// parts.
    pub(super) fn sums_beyond(&self, index: usize, places: &[Sample], masses: &[f64]) -> Vec<f64> {
        let (at, dims) = (index_of(index, self.lattice.dims), self.lattice.dims);
        let is_inside = (0..3).all(|axis| at[axis] >= REACH && at[axis] + REACH < dims[axis]);
        if (is_inside && self.lattice.is_whole) || self.is_amid[index] {
            return vec![0.0; places.len()];
        }
        let mut around = Around::default();
        self.gather::<false>(&mut around, index, masses);
        let sum = |place: &Sample| sum_at(self.level, place.position, &around.packets, &around.weights);
        places.iter().map(sum).collect()
    }

    /// Gathers the kernels around a sample: all of them, or only those that continue the block.
    fn gather<const ALL: bool>(&self, around: &mut Around, index: usize, masses: &[f64]) {
        let dims = self.lattice.dims;
        let at = index_of(index, dims);
        around.clear();
        let mut add = |near: usize, beyond: [i32; 3]| {
            let kernel = &self.kernels[near];
            let centre = kernel.position + self.steps[near] * DVec3::from_array(beyond.map(f64::from));
            around.push(kernel, centre, (masses[near] * kernel.peak) as f32);
        };
        let window = -(REACH as i32)..=REACH as i32;
        for dk in window.clone() {
            let (k, beyond_k) = clamped(at[2], dk, dims[2]);
            for dj in window.clone() {
                let (j, beyond_j) = clamped(at[1], dj, dims[1]);
                let row = dims[0] * (j + dims[1] * k);
                for di in window.clone() {
                    let (i, beyond_i) = clamped(at[0], di, dims[0]);
                    let (near, beyond) = (row + i, [beyond_i, beyond_j, beyond_k]);
                    if !self.kernels[near].is_legal() {
                        add(index, [di, dj, dk]);
                    } else if ALL || beyond != [0; 3] {
                        add(near, beyond);
                    }
                }
            }
        }
    }
}

/// The nearest index within a block, and the distance of the wanted one beyond it.
#[inline(always)]
fn clamped(at: usize, offset: i32, size: usize) -> (usize, i32) {
    let wanted = at as i32 + offset;
    let inside = wanted.clamp(0, size as i32 - 1);
    (inside as usize, wanted - inside)
}

/// True where all within reach along an axis are marked.
fn amid(marked: &[bool], dims: [usize; 3], axis: usize) -> Vec<bool> {
    let stride: usize = dims[..axis].iter().product();
    let of = |index: usize| {
        let at = index / stride % dims[axis];
        at >= REACH
            && at + REACH < dims[axis]
            && (0..=2 * REACH).all(|step| marked[index + step * stride - REACH * stride])
    };
    (0..marked.len()).into_par_iter().map(of).collect()
}

/// Kernels around a sample, packed.
#[derive(Default)]
pub(super) struct Around {
    packets: Vec<Packet>,
    weights: Vec<[f32; LANES]>,
    count: usize,
}

impl Around {
    fn clear(&mut self) {
        self.packets.clear();
        self.weights.clear();
        self.count = 0;
    }

    #[inline(always)]
    fn push(&mut self, kernel: &Evaluated, centre: DVec3, weight: f32) {
        let lane = self.count % LANES;
        if lane == 0 {
            self.packets.push(Packet::around(centre));
            self.weights.push([0.0; LANES]);
        }
        if let (Some(packet), Some(weights)) = (self.packets.last_mut(), self.weights.last_mut()) {
            packet.set(lane, kernel, centre);
            weights[lane] = weight;
        }
        self.count += 1;
    }
}
