//! One side for all triangles of a surface: neighbours run through their common edge in opposite directions.
//!
//! Closed parts face outward, by the sign of their volume; open ones as most of their area does in the file. Corners at one
//! place are one corner. Edges of more than two triangles tell nothing.

use glam::DVec3;

/// Whether each triangle must be turned over.
pub(super) fn flipped(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<bool> {
    let corner = welded(positions);
    let mut edges = Vec::with_capacity(triangles.len() * 3);
    for (triangle, corners) in triangles.iter().enumerate() {
        let corners = corners.map(|c| corner[c as usize]);
        for (from, to) in [(0, 1), (1, 2), (2, 0)].map(|(a, b)| (corners[a], corners[b])) {
            if from != to {
                edges.push(([from.min(to), from.max(to)], triangle, from < to));
            }
        }
    }
    edges.sort_unstable();
    let mut parts = Parts::new(triangles.len());
    let mut open = Vec::new();
    for group in edges.chunk_by(|a, b| a.0 == b.0) {
        match group {
            [(_, first, up), (_, second, also_up)] => parts.join(*first, *second, up == also_up),
            [(_, first, _), ..] => open.push(*first),
            [] => (),
        }
    }
    // Turned with its part's first triangle, if that is.
    let found: Vec<(usize, bool)> = (0..triangles.len()).map(|index| parts.root(index)).collect();
    let mut closed = vec![true; triangles.len()];
    for triangle in open {
        closed[found[triangle].0] = false;
    }
    let mut sums = vec![0.0; triangles.len()];
    for (corners, &(root, turned)) in triangles.iter().zip(&found) {
        let first = place(positions[triangles[root][0] as usize]);
        let [a, b, c] = corners.map(|c| place(positions[c as usize]) - first);
        let sign = if turned { -1.0 } else { 1.0 };
        sums[root] += sign
            * match closed[root] {
                true => a.dot(b.cross(c)),
                false => (b - a).cross(c - a).length(),
            };
    }
    found
        .iter()
        .map(|&(root, turned)| turned != (sums[root] < 0.0))
        .collect()
}

fn place(position: [f32; 3]) -> DVec3 {
    DVec3::from_array(position.map(f64::from))
}

/// For each position, the first index in the order of positions that is at the same place.
fn welded(positions: &[[f32; 3]]) -> Vec<u32> {
    // Adding zero makes one of the two zeros.
    let key = |index: &u32| positions[*index as usize].map(|c| (c + 0.0).to_bits());
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    order.sort_unstable_by_key(|index| (key(index), *index));
    let mut first = vec![0; positions.len()];
    for same in order.chunk_by(|a, b| key(a) == key(b)) {
        for &index in same {
            first[index as usize] = same[0];
        }
    }
    first
}

/// Connected parts, as trees; each triangle knows whether it is turned against its parent (Galler and Fischer 1964).
struct Parts {
    parents: Vec<(usize, bool)>,
}

impl Parts {
    fn new(count: usize) -> Self {
        Self {
            parents: (0..count).map(|index| (index, false)).collect(),
        }
    }

    /// The root of a triangle's tree, and whether the triangle is turned against it.
    fn root(&mut self, triangle: usize) -> (usize, bool) {
        let (mut at, mut turned) = (triangle, false);
        while self.parents[at].0 != at {
            let (parent, against) = self.parents[at];
            let (grandparent, again) = self.parents[parent];
            // Halves the path, so that later searches are short.
            self.parents[at] = (grandparent, against != again);
            turned ^= against != again;
            at = grandparent;
        }
        (at, turned)
    }

    /// Joins two triangles; `against`: one must be turned if the other is not.
    fn join(&mut self, first: usize, second: usize, against: bool) {
        let (a, turned_a) = self.root(first);
        let (b, turned_b) = self.root(second);
        // The smaller index stays root: the result does not depend on the order of the edges.
        let (root, child) = (a.min(b), a.max(b));
        if root != child {
            self.parents[child] = (root, against != (turned_a != turned_b));
        }
    }
}
