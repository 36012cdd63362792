//! Regions of the samples of structured blocks: the half cells around a point, or a cell.

use glam::{DMat3, DVec3};

use super::Sample;
use super::gradation::Neighbours;
use super::lattice_kernels::LatticeKernels;
use super::normalise::Correction;
use super::pieces::{Hexahedron, LONGEST, Node, UNCUT, count, lengths};
use super::resample::{Cut, Regions};
use super::structured::{BlockLattice, index_of};

/// Both halves of a region along an axis are one piece if they are together no longer than this, in spacings...
const WHOLE: f64 = 1.25;
/// ...and neither is longer than this.
const HALF: f64 = 0.75;

/// A block with its samples before normalisation.
pub(super) struct LatticeRegions<'a> {
    pub(super) lattice: &'a BlockLattice,
    pub(super) samples: &'a [Sample],
    pub(super) kernels: &'a LatticeKernels<'a>,
    /// Derivative of space by the index.
    pub(super) steps: &'a [DMat3],
    /// The samples' masses.
    pub(super) masses: &'a [f64],
}

impl Neighbours for LatticeRegions<'_> {
    fn each_neighbour(&self, index: usize, visit: &mut dyn FnMut(usize)) {
        let dims = self.lattice.dims;
        let at = index_of(index, dims);
        let strides = [1, dims[0], dims[0] * dims[1]];
        for axis in 0..3 {
            if at[axis] > 0 {
                visit(index - strides[axis]);
            }
            if at[axis] + 1 < dims[axis] {
                visit(index + strides[axis]);
            }
        }
    }
}

impl Regions for LatticeRegions<'_> {
    const GATHERED: bool = false;

    fn cuts(&self, index: usize, spacings_from_local: &DMat3) -> Vec<Cut> {
        match self.lattice.corners_of_cell(index) {
            Some(corners) => self.cuts_of_cell(index, corners, spacings_from_local),
            None => self.cuts_of_point(index, spacings_from_local),
        }
    }

    fn beyond(&self, index: usize, places: &[Sample]) -> Vec<Correction> {
        let sums = self.kernels.sums_beyond(index, places, self.masses);
        sums.into_iter().map(Correction::Full).collect()
    }
}

impl LatticeRegions<'_> {
    fn cuts_of_cell(&self, index: usize, corners: [DVec3; 8], spacings_from_local: &DMat3) -> Vec<Cut> {
        let own = &self.samples[index];
        let mut range = [own.value; 2];
        self.each_neighbour(index, &mut |other| {
            let value = self.samples[other].value;
            range = [range[0].min(value), range[1].max(value)];
        });
        let nodes = corners.map(|corner| (corner, own.value_at(corner, range)));
        let sides = lengths(&nodes, spacings_from_local);
        match sides.iter().any(|&side| side > UNCUT) {
            true => vec![Cut {
                nodes,
                counts: sides.map(|side| count(side, LONGEST)),
            }],
            false => Vec::new(),
        }
    }

    /// The octants of a point's region, joined along axes that need no cut.
    fn cuts_of_point(&self, index: usize, spacings_from_local: &DMat3) -> Vec<Cut> {
        let mut block = self.block(index);
        let joined = std::array::from_fn(|axis| {
            let stride = 3usize.pow(axis as u32);
            let halves = [13 - stride, 13 + stride]
                .map(|end| (*spacings_from_local * (block[end].0 - block[13].0)).length());
            halves[0] + halves[1] <= WHOLE && halves[0].max(halves[1]) <= HALF
        });
        if joined == [true; 3] {
            return Vec::new();
        }
        for axis in (0..3).filter(|&axis| joined[axis]) {
            centre(&mut block, axis);
        }
        let mut cuts = Vec::new();
        for octant in 0..8usize {
            let upper = [octant & 1, octant >> 1 & 1, octant >> 2];
            if (0..3).any(|axis| joined[axis] && upper[axis] == 1) {
                continue;
            }
            let nodes: Hexahedron = std::array::from_fn(|n| {
                let along = |axis: usize| match joined[axis] {
                    true => 2 * (n >> axis & 1),
                    false => upper[axis] + (n >> axis & 1),
                };
                block[along(0) + 3 * along(1) + 9 * along(2)]
            });
            let sides = lengths(&nodes, spacings_from_local);
            let counts = std::array::from_fn(|axis| {
                if joined[axis] {
                    1
                } else {
                    count(sides[axis], LONGEST)
                }
            });
            cuts.push(Cut { nodes, counts });
        }
        cuts
    }

    /// Places and values at half indices around a point, x fastest; 13 is the point.
    fn block(&self, index: usize) -> [Node; 27] {
        let whole: [Node; 27] = std::array::from_fn(|n| self.beside(index, offset_of(n)));
        std::array::from_fn(|n| {
            let offset = offset_of(n);
            let (mut place, mut value) = (DVec3::ZERO, 0.0);
            // The mean of the corners around a half index.
            for corner in 0..8usize {
                let at: [usize; 3] =
                    std::array::from_fn(|axis| (1 + offset[axis] * (corner as i32 >> axis & 1)) as usize);
                let (p, v) = whole[at[0] + 3 * at[1] + 9 * at[2]];
                place += 0.125 * p;
                value += 0.125 * v;
            }
            (place, value)
        })
    }

    /// Position and value of the sample at an offset of up to one; beyond the border, or where there is none, the
    /// grid is extrapolated.
    fn beside(&self, index: usize, offset: [i32; 3]) -> Node {
        let dims = self.lattice.dims;
        let at = index_of(index, dims);
        let place: [i32; 3] = std::array::from_fn(|axis| at[axis] as i32 + offset[axis]);
        let inside: [usize; 3] =
            std::array::from_fn(|axis| place[axis].clamp(0, dims[axis] as i32 - 1) as usize);
        let near = inside[0] + dims[0] * (inside[1] + dims[1] * inside[2]);
        if !self.lattice.valid[near] {
            let beyond = DVec3::from_array(offset.map(f64::from));
            let place = self.lattice.positions[index] + self.steps[index] * beyond;
            return (place, f64::from(self.samples[index].value));
        }
        let beyond = std::array::from_fn(|axis| f64::from(place[axis]) - inside[axis] as f64);
        let place = self.lattice.positions[near] + self.steps[near] * DVec3::from_array(beyond);
        (place, f64::from(self.samples[near].value))
    }
}

fn offset_of(n: usize) -> [i32; 3] {
    [n % 3, n / 3 % 3, n / 9].map(|i| i as i32 - 1)
}

/// Moves the point to the middle of both halves along an axis, with its own value on all nodes: a single piece lies
/// at the point.
fn centre(block: &mut [Node; 27], axis: usize) {
    let stride = 3usize.pow(axis as u32);
    for middle in (0..27).filter(|n| n / stride % 3 == 1) {
        let half = 0.5 * (block[middle + stride].0 - block[middle - stride].0);
        let (place, value) = block[middle];
        block[middle - stride] = (place - half, value);
        block[middle + stride] = (place + half, value);
    }
}
