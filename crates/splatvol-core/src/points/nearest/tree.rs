//! Places in leaves, boxes in nodes: a tree of sixteen branches over places in Morton order.

use rayon::prelude::*;

/// Places of a leaf, and boxes of a node.
pub(super) const LANES: usize = 16;

/// Three coordinates of sixteen places; infinite for absent ones.
pub(super) type Leaf = [[f32; LANES]; 3];
/// Least and largest coordinate along each axis.
pub(super) type Bounds = [[f32; 2]; 3];

/// Sixteen boxes; empty ones are infinitely far from everything.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    pub(super) low: Leaf,
    pub(super) high: Leaf,
}

impl Node {
    const EMPTY: Self = Self {
        low: [[f32::INFINITY; LANES]; 3],
        high: [[f32::NEG_INFINITY; LANES]; 3],
    };

    /// The box of a lane.
    #[inline(always)]
    pub(super) fn of(&self, lane: usize) -> Bounds {
        let lane = lane % LANES;
        let [x, y, z] = &self.low;
        let [u, v, w] = &self.high;
        [[x[lane], u[lane]], [y[lane], v[lane]], [z[lane], w[lane]]]
    }

    /// The box around all of them.
    fn bounds(&self) -> Bounds {
        let least = |values: [f32; LANES]| values.into_iter().fold(f32::INFINITY, f32::min);
        let greatest = |values: [f32; LANES]| values.into_iter().fold(f32::NEG_INFINITY, f32::max);
        [0, 1, 2].map(|axis| [least(self.low[axis]), greatest(self.high[axis])])
    }

    fn around(boxes: impl Iterator<Item = Bounds>) -> Self {
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
pub(super) struct Tree {
    pub(super) leaves: Vec<Leaf>,
    /// Levels of nodes, from the nodes of leaves up to the root.
    pub(super) levels: Vec<Vec<Node>>,
}

impl Tree {
    pub(super) fn new(places: &[[f32; 3]]) -> Self {
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

    /// The box of a leaf (level 0) or of a node of the level below.
    #[inline(always)]
    pub(super) fn bounds(&self, level: usize, child: usize) -> Bounds {
        self.levels[level][child / LANES].of(child)
    }
}

fn leaf(places: &[[f32; 3]]) -> Leaf {
    let mut leaf = [[f32::INFINITY; LANES]; 3];
    for (lane, place) in places.iter().enumerate() {
        for axis in 0..3 {
            leaf[axis][lane] = place[axis];
        }
    }
    leaf
}

fn bounds(places: &[[f32; 3]]) -> Bounds {
    let each = |axis: usize| places.iter().map(move |place| place[axis]);
    [0, 1, 2].map(|axis| {
        let low = each(axis).fold(f32::INFINITY, f32::min);
        [low, each(axis).fold(f32::NEG_INFINITY, f32::max)]
    })
}
