//! The nearest neighbours of all places: sixteen places in Morton order are a leaf, sixteen boxes in that order a node.
//!
//! The search of a place begins in its own leaf and climbs from node to node, going down into what is nearer than the
//! neighbours found so far (Samet, Foundations of Multidimensional and Metric Data Structures, 2006, section 4.2, from the
//! bottom up). Distances to sixteen places or boxes are found at once. Of neighbours at one distance the first is taken, so
//! that the result depends on the places alone.

use fearless_simd::{Level, dispatch, f32x16, prelude::*};
use rayon::prelude::*;

/// Places of a leaf, and boxes of a node.
const LANES: usize = 16;
/// Most neighbours that are looked for.
pub(super) const MOST_NEIGHBORS: usize = 64;
/// Searches of one task.
const BATCH: usize = 1024;
/// Nodes above each other: of fewer than 2^32 places no tree has more.
const DEPTH: usize = 8;

/// Three coordinates of sixteen places.
type Leaf = [[f32; LANES]; 3];

/// Sixteen boxes.
#[derive(Debug, Clone, Copy)]
struct Node {
    low: Leaf,
    high: Leaf,
}

impl Node {
    const EMPTY: Self = Self {
        low: [[f32::INFINITY; LANES]; 3],
        high: [[f32::NEG_INFINITY; LANES]; 3],
    };

    /// The box around all of them.
    fn bounds(&self) -> [[f32; 2]; 3] {
        let least = |values: [f32; LANES]| values.into_iter().fold(f32::INFINITY, f32::min);
        let greatest = |values: [f32; LANES]| values.into_iter().fold(f32::NEG_INFINITY, f32::max);
        [0, 1, 2].map(|axis| [least(self.low[axis]), greatest(self.high[axis])])
    }

    fn around(boxes: impl Iterator<Item = [[f32; 2]; 3]>) -> Self {
        let mut node = Self::EMPTY;
        for (lane, bounds) in boxes.enumerate() {
            for (axis, [low, high]) in bounds.into_iter().enumerate() {
                (node.low[axis][lane], node.high[axis][lane]) = (low, high);
            }
        }
        node
    }
}

/// Places in leaves and nodes.
struct Tree {
    leaves: Vec<Leaf>,
    /// Nodes of leaves, nodes of those, and so on to one.
    levels: Vec<Vec<Node>>,
}

/// The `k` nearest other places of each of these, which lie in Morton order; nearest first. More than `k` places.
pub(super) fn nearest(places: &[[f32; 3]], k: usize) -> Vec<u32> {
    let mut neighbors = vec![0u32; places.len() * k];
    if k == 0 {
        return neighbors;
    }
    let tree = Tree::new(places);
    let level = Level::new();
    let batches = neighbors.par_chunks_mut(k * BATCH).enumerate();
    batches.for_each(|(batch, rows)| {
        dispatch!(level, simd => tree.fill(simd, (places, batch * BATCH), (k, rows)));
    });
    neighbors
}

impl Tree {
    fn new(places: &[[f32; 3]]) -> Self {
        let leaf = |places: &[[f32; 3]]| {
            let mut leaf = [[f32::INFINITY; LANES]; 3];
            for (lane, place) in places.iter().enumerate() {
                for axis in 0..3 {
                    leaf[axis][lane] = place[axis];
                }
            }
            leaf
        };
        let bounds = |places: &[[f32; 3]]| {
            let each = |axis: usize| places.iter().map(move |place| place[axis]);
            [0, 1, 2].map(|axis| {
                let low = each(axis).fold(f32::INFINITY, f32::min);
                [low, each(axis).fold(f32::NEG_INFINITY, f32::max)]
            })
        };
        let of_leaves = |places: &[[f32; 3]]| Node::around(places.chunks(LANES).map(bounds));
        let mut levels: Vec<Vec<Node>> = vec![places.par_chunks(LANES * LANES).map(of_leaves).collect()];
        while let Some(last) = levels.last().filter(|last| last.len() > 1) {
            let of_nodes = |nodes: &[Node]| Node::around(nodes.iter().map(Node::bounds));
            let next = last.par_chunks(LANES).map(of_nodes).collect();
            levels.push(next);
        }
        Self {
            leaves: places.par_chunks(LANES).map(leaf).collect(),
            levels,
        }
    }

    /// The neighbours of places from `first` on, `k` each.
    #[inline(always)]
    fn fill<S: Simd>(&self, simd: S, (places, first): (&[[f32; 3]], usize), (k, rows): (usize, &mut [u32])) {
        let mut found = Found::new(k);
        for (row, neighbors) in rows.chunks_exact_mut(k).enumerate() {
            let index = first + row;
            found.clear(index);
            self.search(simd, places[index], &mut found);
            for (neighbor, key) in neighbors.iter_mut().zip(found.keys) {
                *neighbor = key as u32;
            }
        }
    }

    #[inline(always)]
    fn search<S: Simd>(&self, simd: S, place: [f32; 3], found: &mut Found) {
        let mut stack = [(0.0f32, 0u32, 0u32); LANES * DEPTH];
        let mut from = found.own / LANES;
        self.look(simd, place, from, found);
        for climbed in 0..self.levels.len() {
            let (node, lane) = (from / LANES, from % LANES);
            let mut depth = 0;
            let near = self.near(simd, place, (climbed, node), found.farthest());
            push(&mut stack, &mut depth, near, (climbed, node), Some(lane));
            while depth > 0 {
                depth -= 1;
                let (distance, level, child) = stack[depth];
                if distance > found.farthest() {
                    continue;
                }
                let (level, child) = (level as usize, child as usize);
                if level == 0 {
                    self.look(simd, place, child, found);
                } else {
                    let near = self.near(simd, place, (level - 1, child), found.farthest());
                    push(&mut stack, &mut depth, near, (level - 1, child), None);
                }
            }
            from = node;
        }
    }

    /// Takes the places of a leaf that are near enough.
    #[inline(always)]
    fn look<S: Simd>(&self, simd: S, place: [f32; 3], leaf: usize, found: &mut Found) {
        let [x, y, z] = self.leaves[leaf];
        let x = f32x16::simd_from(simd, x) - place[0];
        let y = f32x16::simd_from(simd, y) - place[1];
        let z = f32x16::simd_from(simd, z) - place[2];
        let squared = x * x + y * y + z * z;
        let mut near = squared
            .simd_le(f32x16::splat(simd, found.farthest()))
            .to_bitmask();
        let squared: [f32; LANES] = squared.into();
        while near != 0 {
            let lane = near.trailing_zeros() as usize;
            near &= near - 1;
            found.take(squared[lane], leaf * LANES + lane);
        }
    }

    /// Squared distances to the boxes of a node, and which of them are at most `farthest`.
    #[inline(always)]
    fn near<S: Simd>(
        &self,
        simd: S,
        place: [f32; 3],
        (level, node): (usize, usize),
        farthest: f32,
    ) -> ([f32; LANES], u64) {
        let Node { low, high } = self.levels[level][node];
        let zero = f32x16::splat(simd, 0.0);
        let mut squared = zero;
        for axis in 0..3 {
            let below = f32x16::simd_from(simd, low[axis]) - place[axis];
            let above = place[axis] - f32x16::simd_from(simd, high[axis]);
            let outside = below.max(above).max(zero);
            squared += outside * outside;
        }
        let near = squared.simd_le(f32x16::splat(simd, farthest)).to_bitmask();
        (squared.into(), near)
    }
}

/// Puts the near boxes of a node on a stack, but for one.
#[inline(always)]
fn push(
    stack: &mut [(f32, u32, u32)],
    depth: &mut usize,
    (squared, near): ([f32; LANES], u64),
    (level, node): (usize, usize),
    but: Option<usize>,
) {
    let mut near = near & !but.map_or(0, |lane| 1 << lane);
    while near != 0 {
        let lane = near.trailing_zeros() as usize;
        near &= near - 1;
        stack[*depth] = (squared[lane], level as u32, (node * LANES + lane) as u32);
        *depth += 1;
    }
}

/// The nearest neighbours so far.
struct Found {
    /// Whose they are.
    own: usize,
    k: usize,
    /// Squared distance in the upper bits, whose order is that of the numbers, index in the lower; nearest first.
    keys: [u64; MOST_NEIGHBORS],
}

impl Found {
    const NONE: u64 = (f32::INFINITY.to_bits() as u64) << 32 | u32::MAX as u64;

    fn new(k: usize) -> Self {
        Self {
            own: 0,
            k,
            keys: [Self::NONE; MOST_NEIGHBORS],
        }
    }

    fn clear(&mut self, own: usize) {
        self.own = own;
        self.keys = [Self::NONE; MOST_NEIGHBORS];
    }

    /// How far the last of them is; what is not there, at an infinite distance, is farther.
    #[inline(always)]
    fn farthest(&self) -> f32 {
        f32::from_bits((self.keys[self.k - 1] >> 32) as u32).min(f32::MAX)
    }

    #[inline(always)]
    fn take(&mut self, squared: f32, index: usize) {
        let key = u64::from(squared.to_bits()) << 32 | index as u64;
        if index == self.own || key >= self.keys[self.k - 1] {
            return;
        }
        let mut at = self.k - 1;
        while at > 0 && self.keys[at - 1] > key {
            self.keys[at] = self.keys[at - 1];
            at -= 1;
        }
        self.keys[at] = key;
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
            for k in [1, 8, 64] {
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
