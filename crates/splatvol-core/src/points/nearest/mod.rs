//! Nearest neighbours of all places, by a tree in Morton order: sixteen places are a leaf, sixteen boxes a node.
//!
//! The places of a leaf search together. They start in their own leaf and climb from node to node, descending into
//! boxes that are nearer to one of them than its neighbours so far. This is the search of Samet, Foundations of
//! Multidimensional and Metric Data Structures, 2006, section 4.2, from the bottom up. Distances to a node's
//! sixteen boxes and a leaf's sixteen places are first measured from the bounding box of the searching places, then
//! from each of the sixteen. Rounding keeps the order of distances, so nothing nearer is left out. Among neighbours
//! at one distance the first is taken, so the result depends on the places alone.

mod found;
mod tree;

use fearless_simd::{Level, dispatch, f32x16, prelude::*, u32x16};
use rayon::prelude::*;

use found::Found;
use tree::{Bounds, LANES, Leaf, Node, Tree};

/// Most neighbours that are looked for.
pub(super) const MOST_NEIGHBORS: usize = 64;
/// The lanes' own numbers.
const LANE: [u32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
/// Neighbours that are kept in registers.
const FEW: usize = 8;
/// Leaves of one task.
const BATCH: usize = 64;
/// Most nodes above each other in a tree of fewer than 2^32 places.
const DEPTH: usize = 8;

/// The `k` nearest other places of each of these, which lie in Morton order; nearest first. More than `k` places.
pub(super) fn nearest(places: &[[f32; 3]], k: usize) -> Vec<u32> {
    nearest_by(Level::new(), places, k)
}

/// As `nearest`, with these instructions.
fn nearest_by(level: Level, places: &[[f32; 3]], k: usize) -> Vec<u32> {
    let mut neighbors = vec![0u32; places.len() * k];
    if k == 0 {
        return neighbors;
    }
    let tree = Tree::new(places);
    let batches = neighbors.par_chunks_mut(k * LANES * BATCH).enumerate();
    batches.for_each(|(batch, rows)| {
        dispatch!(level, simd => fill(simd, &tree, batch * BATCH, (k, rows)));
    });
    neighbors
}

/// The neighbours of the places of leaves from `first` on, `k` each.
#[inline(always)]
fn fill<S: Simd>(simd: S, tree: &Tree, first: usize, (k, rows): (usize, &mut [u32])) {
    // Few enough for registers, as many as the engine asks for; or as many as there are.
    match k {
        0..=FEW => fill_with::<S, FEW>(simd, (tree, first), (k, rows), FEW),
        _ => fill_with::<S, MOST_NEIGHBORS>(simd, (tree, first), (k, rows), k),
    }
}

#[inline(always)]
fn fill_with<S: Simd, const K: usize>(
    simd: S,
    (tree, first): (&Tree, usize),
    (k, rows): (usize, &mut [u32]),
    found: usize,
) {
    for (leaf, rows) in rows.chunks_mut(k * LANES).enumerate() {
        let mut search = Search::<S, K>::new(simd, tree, first + leaf, found);
        search.own();
        search.climb();
        search.found.write(k, rows);
    }
}

/// Stack of boxes to visit: distance from the searching places' bounding box, level, index.
type Stack = [(f32, u32, u32); LANES * DEPTH];

/// The places of a leaf, looking for their neighbours.
struct Search<'t, S: Simd, const K: usize> {
    simd: S,
    tree: &'t Tree,
    leaf: usize,
    places: [f32x16<S>; 3],
    /// The box around them.
    bounds: Bounds,
    found: Found<S, K>,
}

impl<'t, S: Simd, const K: usize> Search<'t, S, K> {
    #[inline(always)]
    fn new(simd: S, tree: &'t Tree, leaf: usize, found: usize) -> Self {
        // Where a leaf is not full, its first place searches again.
        let mut places = [f32x16::splat(simd, 0.0); 3];
        for (places, coordinates) in places.iter_mut().zip(&tree.leaves[leaf]) {
            let there = f32x16::simd_from(simd, *coordinates);
            let first = f32x16::splat(simd, coordinates[0]);
            *places = there.simd_lt(f32::INFINITY).select(there, first);
        }
        Self {
            simd,
            tree,
            leaf,
            places,
            bounds: tree.bounds(0, leaf),
            found: Found::new(simd, found),
        }
    }

    /// Takes the other places of the searching leaf.
    #[inline(always)]
    fn own(&mut self) {
        let leaf = &self.tree.leaves[self.leaf];
        let lanes = u32x16::simd_from(self.simd, LANE);
        let never = f32x16::splat(self.simd, f32::INFINITY);
        for lane in 0..LANES {
            if leaf[0][lane] == f32::INFINITY {
                break;
            }
            let itself = lanes.simd_eq(u32x16::splat(self.simd, lane as u32));
            let squared = itself.select(never, self.squared(leaf, lane));
            let index = self.leaf * LANES + lane;
            self.found.take(self.simd, squared, index as u32);
        }
    }

    /// From the own leaf's node to the root.
    #[inline(always)]
    fn climb(&mut self) {
        let mut stack: Stack = [(0.0, 0, 0); LANES * DEPTH];
        let mut from = self.leaf;
        for climbed in 0..self.tree.levels.len() {
            let (node, lane) = (from / LANES, from % LANES);
            let mut depth = 0;
            self.open((climbed, node), !(1 << lane), (&mut stack, &mut depth));
            while depth > 0 {
                depth -= 1;
                let (distance, level, child) = stack[depth];
                let (level, child) = (level as usize, child as usize);
                if distance > self.farthest() || !self.is_near(self.tree.bounds(level, child)) {
                    continue;
                }
                if level == 0 {
                    self.look(child);
                } else {
                    self.open((level - 1, child), !0, (&mut stack, &mut depth));
                }
            }
            from = node;
        }
    }

    /// Pushes the boxes of a node that are near enough.
    #[inline(always)]
    fn open(&self, (level, node): (usize, usize), which: u64, (stack, depth): (&mut Stack, &mut usize)) {
        let Node { low, high } = &self.tree.levels[level][node];
        let (squared, near) = self.squared_outside((low, high));
        let squared: [f32; LANES] = squared.into();
        let mut near = near & which;
        while near != 0 {
            let lane = near.trailing_zeros() as usize % LANES;
            near &= near - 1;
            stack[*depth] = (squared[lane], level as u32, (node * LANES + lane) as u32);
            *depth += 1;
        }
    }

    /// Takes the places of a leaf that are near enough.
    #[inline(always)]
    fn look(&mut self, leaf: usize) {
        let places = &self.tree.leaves[leaf];
        let (_, mut near) = self.squared_outside((places, places));
        while near != 0 {
            let lane = near.trailing_zeros() as usize % LANES;
            near &= near - 1;
            let squared = self.squared(places, lane);
            if squared.simd_le(self.found.farthest).any_true() {
                let index = leaf * LANES + lane;
                self.found.take(self.simd, squared, index as u32);
            }
        }
    }

    /// Largest distance of a last neighbour; absent places at an infinite distance are farther.
    #[inline(always)]
    fn farthest(&self) -> f32 {
        self.found.farthest.reduce_max().min(f32::MAX)
    }

    /// Squared distances of a place from the searching places.
    #[inline(always)]
    fn squared(&self, places: &Leaf, lane: usize) -> f32x16<S> {
        let x = self.places[0] - places[0][lane];
        let y = self.places[1] - places[1][lane];
        let z = self.places[2] - places[2][lane];
        x * x + y * y + z * z
    }

    /// Squared distances of boxes from the searching places' bounding box, and the boxes that are near enough.
    #[inline(always)]
    fn squared_outside(&self, (low, high): (&Leaf, &Leaf)) -> (f32x16<S>, u64) {
        let zero = f32x16::splat(self.simd, 0.0);
        let mut squared = zero;
        for axis in 0..3 {
            let [least, largest] = self.bounds[axis];
            let below = f32x16::simd_from(self.simd, low[axis]) - largest;
            let above = least - f32x16::simd_from(self.simd, high[axis]);
            let outside = below.max(above).max(zero);
            squared += outside * outside;
        }
        let farthest = f32x16::splat(self.simd, self.farthest());
        (squared, squared.simd_le(farthest).to_bitmask())
    }

    /// Whether a box may hold a neighbour of a searching place.
    #[inline(always)]
    fn is_near(&self, bounds: Bounds) -> bool {
        let zero = f32x16::splat(self.simd, 0.0);
        let mut squared = zero;
        for (axis, [low, high]) in bounds.into_iter().enumerate() {
            let below = low - self.places[axis];
            let above = self.places[axis] - high;
            let outside = below.max(above).max(zero);
            squared += outside * outside;
        }
        squared.simd_le(self.found.farthest).any_true()
    }
}

#[cfg(test)]
mod tests {
    use splatvol_testing::Random;

    use super::*;

    fn by_brute_force(places: &[[f32; 3]], k: usize) -> Vec<u32> {
        let of = |index: usize| {
            let squared = |other: &[f32; 3]| {
                let [x, y, z] = [0, 1, 2].map(|axis| other[axis] - places[index][axis]);
                x * x + y * y + z * z
            };
            let mut all: Vec<(f32, u32)> = places.iter().map(squared).zip(0..).collect();
            all.remove(index);
            all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            all.into_iter()
                .take(k)
                .map(|(_, other)| other)
                .collect::<Vec<_>>()
        };
        (0..places.len()).flat_map(of).collect()
    }

    #[test]
    fn neighbours_are_those_of_a_search_through_all() {
        let mut random = Random::new(8);
        // On a lattice, where many are equally far; strewn; in two clumps that are far apart.
        let lattice = (0..600).map(|n| [n % 10, n / 10 % 10, n / 100].map(|c| c as f32 / 8.0));
        let strewn = (0..1500).map(|_| [0; 3].map(|_| 2.0 * random.unit() as f32 - 1.0));
        let strewn: Vec<[f32; 3]> = strewn.collect();
        let clumps = strewn.iter().enumerate().map(|(n, p)| {
            let far = if n % 2 == 0 { 0.9 } else { -0.9 };
            p.map(|c| 1e-3 * c + far)
        });
        for mut places in [lattice.collect(), clumps.collect(), strewn] {
            places.sort_by_key(|place: &[f32; 3]| super::super::neighbors::morton(*place));
            for k in [1, 8, 9, 64] {
                let expected = by_brute_force(&places, k);
                for level in [Level::new(), Level::baseline()] {
                    assert!(nearest_by(level, &places, k) == expected, "{k} {level:?}");
                }
            }
        }
    }

    #[test]
    fn clouds_that_are_hardly_any_have_neighbours_too() {
        let mut random = Random::new(13);
        let mut unit = || 2.0 * random.unit() as f32 - 1.0;
        let line: Vec<[f32; 3]> = (0..500).map(|_| [unit(); 3]).collect();
        let plane: Vec<[f32; 3]> = (0..500).map(|_| [unit(), unit(), 0.25]).collect();
        let repeated: Vec<[f32; 3]> = (0..500).map(|n| plane[n / 7]).collect();
        let one_place = vec![[0.5, -0.5, 0.0]; 100];
        // So close that squares of their distances are zero, or nearly.
        let close: Vec<[f32; 3]> = (0..300).map(|_| [1e-22 * unit(), 1e-30 * unit(), 0.0]).collect();
        for mut places in [line, plane, repeated, one_place, close] {
            places.sort_by_key(|place: &[f32; 3]| super::super::neighbors::morton(*place));
            for k in [1, 5, 8, 17] {
                assert!(nearest(&places, k) == by_brute_force(&places, k), "{k}");
            }
        }
    }

    #[test]
    fn few_places_have_the_others_as_neighbours() {
        let places = [[-0.5, 0.0, 0.0], [0.0, 0.0, 0.1], [0.2, 0.3, 0.9]];
        assert_eq!(nearest(&places, 2), [1, 2, 0, 2, 1, 0]);
        assert_eq!(nearest(&places[..2], 1), [1, 0]);
        assert!(nearest(&places[..1], 0).is_empty());
    }
}
