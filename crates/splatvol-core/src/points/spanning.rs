//! Spanning forest of least weight, by Borůvka's algorithm (1926): each tree takes its lightest outgoing edge,
//! until none is left. All trees search at once, and edges within a tree are dropped, so there are some ten rounds
//! over ever fewer edges. All weights differ, so there is only one such forest, whatever the threads.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

/// Key of no edge.
const NONE: u64 = u64::MAX;

/// For each of `count` places the root of its tree, and whether its sign differs from the root's. Keys of edges are
/// their weights, all of them different; `ends` returns the places that an edge joins, `differs` whether their
/// signs differ.
pub(super) fn spread(
    count: usize,
    mut keys: Vec<u64>,
    ends: impl Fn(u64) -> [usize; 2] + Sync,
    differs: impl Fn(u64) -> bool,
) -> Vec<(u32, bool)> {
    let mut trees = Trees::new(count);
    let mut roots: Vec<(u32, bool)> = (0..count as u32).map(|place| (place, false)).collect();
    let mut lightest: Vec<AtomicU64> = (0..count).map(|_| AtomicU64::new(NONE)).collect();
    while !keys.is_empty() {
        keys.par_iter().for_each(|&key| {
            for end in ends(key) {
                let own = &lightest[roots[end].0 as usize];
                if key < own.load(Ordering::Relaxed) {
                    own.fetch_min(key, Ordering::Relaxed);
                }
            }
        });
        for own in &mut lightest {
            let key = std::mem::replace(own.get_mut(), NONE);
            if key != NONE {
                let [i, j] = ends(key);
                trees.join(i, j, differs(key));
            }
        }
        roots = (0..count)
            .into_par_iter()
            .map(|place| trees.root(place))
            .collect();
        let leaves = |key: &u64| {
            let [i, j] = ends(*key);
            roots[i].0 != roots[j].0
        };
        keys = keys.into_par_iter().filter(leaves).collect();
    }
    roots
}

/// Disjoint sets whose members know their sign relative to the root (union by size, path halving).
struct Trees {
    /// Parent in the upper 31 bits, whether the sign differs from the parent's in the lowest.
    parent: Vec<u64>,
    size: Vec<u32>,
}

impl Trees {
    fn new(count: usize) -> Self {
        Self {
            parent: (0..count as u64).map(|i| i << 1).collect(),
            size: vec![1; count],
        }
    }

    /// The root of a place's set, and whether the place's sign differs from the root's.
    fn root(&self, place: usize) -> (u32, bool) {
        let (mut at, mut differs) = (place, 0);
        loop {
            let up = self.parent[at];
            let parent = (up >> 1) as usize;
            if parent == at {
                return (at as u32, differs == 1);
            }
            differs ^= up & 1;
            at = parent;
        }
    }

    /// As `root`, with path halving: every place on the way moves under its grandparent.
    fn shortened_root(&mut self, place: usize) -> (u32, bool) {
        let (mut at, mut differs) = (place, 0);
        loop {
            let up = self.parent[at];
            let parent = (up >> 1) as usize;
            if parent == at {
                return (at as u32, differs == 1);
            }
            let above = self.parent[parent];
            let shorter = (above & !1) | ((up ^ above) & 1);
            let is_root = (above >> 1) as usize == parent;
            self.parent[at] = if is_root { up } else { shorter };
            differs ^= self.parent[at] & 1;
            at = (self.parent[at] >> 1) as usize;
        }
    }

    /// Joins the sets of two places whose signs differ or not; does nothing if they are joined already.
    fn join(&mut self, i: usize, j: usize, differ: bool) {
        let ((root_i, sign_i), (root_j, sign_j)) = (self.shortened_root(i), self.shortened_root(j));
        if root_i == root_j {
            return;
        }
        let sign = u64::from(differ ^ sign_i ^ sign_j);
        let (root_i, root_j) = (root_i as usize, root_j as usize);
        let (low, high) = if self.size[root_i] < self.size[root_j] {
            (root_i, root_j)
        } else {
            (root_j, root_i)
        };
        self.parent[low] = (high as u64) << 1 | sign;
        self.size[high] += self.size[low];
    }
}

#[cfg(test)]
mod tests {
    use splatvol_testing::Random;

    use super::*;

    /// By Kruskal's algorithm: edges in the order of their weights.
    fn in_order(count: usize, edges: &[([usize; 2], bool)], mut keys: Vec<u64>) -> Vec<(u32, bool)> {
        let mut trees = Trees::new(count);
        keys.sort_unstable();
        for key in keys {
            let ([i, j], differ) = edges[(key & 0xffff) as usize];
            trees.join(i, j, differ);
        }
        (0..count).map(|place| trees.root(place)).collect()
    }

    #[test]
    fn signs_are_those_of_the_edges_in_order() {
        let mut random = Random::new(17);
        for (count, edge_count) in [(2, 1), (50, 40), (400, 3000)] {
            let mut below = |limit: usize| (random.unit() * limit as f64) as usize;
            let edges: Vec<([usize; 2], bool)> = (0..edge_count)
                .map(|_| {
                    let i = below(count);
                    ([i, (i + 1 + below(count - 1)) % count], below(2) == 1)
                })
                .collect();
            let keys: Vec<u64> = (0..edge_count)
                .map(|edge| (below(64) as u64) << 16 | edge as u64)
                .collect();
            let found = spread(
                count,
                keys.clone(),
                |key| edges[(key & 0xffff) as usize].0,
                |key| edges[(key & 0xffff) as usize].1,
            );
            let expected = in_order(count, &edges, keys);
            // Roots may be other places, so compare places of one tree with each other.
            for i in 0..count {
                for j in 0..i {
                    let same = |of: &[(u32, bool)]| (of[i].0 == of[j].0).then_some(of[i].1 == of[j].1);
                    assert_eq!(same(&found), same(&expected), "{i} {j}");
                }
            }
        }
    }
}
