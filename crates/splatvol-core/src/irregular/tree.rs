//! Which kernels reach a place: a tree of boxes around them (Goldsmith and Salmon, Automatic creation of object hierarchies
//! for ray tracing, 1987), halved at the median of their centres along the longest side.

use glam::DVec3;

use super::Sample;
use super::normalise::REACH_SQUARED;

/// Kernels of a box that is not halved.
const LEAF: usize = 8;

/// Boxes, each before its halves.
pub(super) struct Tree {
    nodes: Vec<Node>,
    /// Kernels in the order of the leaves.
    order: Vec<u32>,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    low: DVec3,
    high: DVec3,
    /// The second half, or where a leaf's kernels begin.
    next: u32,
    /// Kernels of a leaf; 0 for a box with halves, the first of which follows it.
    count: u32,
}

impl Tree {
    pub(super) fn new(samples: &[Sample]) -> Self {
        let valid = |&index: &u32| samples[index as usize].valid;
        let mut order: Vec<u32> = (0..samples.len() as u32).filter(valid).collect();
        let mut nodes = Vec::with_capacity(order.len() / 2 + 1);
        if !order.is_empty() {
            build(samples, &mut order, 0, &mut nodes);
        }
        Self { nodes, order }
    }

    /// Calls `visit` for the kernels in whose box a place is.
    #[inline(always)]
    pub(super) fn each(&self, at: DVec3, mut visit: impl FnMut(usize)) {
        // Median halves: no tree of 2^32 kernels is deeper.
        let mut stack = [0u32; 64];
        let mut depth = usize::from(!self.nodes.is_empty());
        while depth > 0 {
            depth -= 1;
            let index = stack[depth];
            let node = &self.nodes[index as usize];
            if at.cmplt(node.low).any() || at.cmpgt(node.high).any() {
                continue;
            }
            if node.count > 0 {
                let own = node.next as usize..(node.next + node.count) as usize;
                for &kernel in &self.order[own] {
                    visit(kernel as usize);
                }
            } else {
                stack[depth] = node.next;
                stack[depth + 1] = index + 1;
                depth += 2;
            }
        }
    }
}

/// Adds the box of `order`, which begins at `first` of all, and its halves.
fn build(samples: &[Sample], order: &mut [u32], first: usize, nodes: &mut Vec<Node>) {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (mut least, mut greatest) = (low, high);
    for &index in &*order {
        let sample = &samples[index as usize];
        let v = &sample.covariance;
        let variances = DVec3::new(v.x_axis.x, v.y_axis.y, v.z_axis.z).max(DVec3::ZERO);
        let reach = (variances * REACH_SQUARED).map(f64::sqrt);
        (low, high) = (
            low.min(sample.position - reach),
            high.max(sample.position + reach),
        );
        (least, greatest) = (least.min(sample.position), greatest.max(sample.position));
    }
    let place = nodes.len();
    let is_leaf = order.len() <= LEAF;
    nodes.push(Node {
        low,
        high,
        next: first as u32,
        count: if is_leaf { order.len() as u32 } else { 0 },
    });
    if is_leaf {
        return;
    }
    let axis = (greatest - least).max_position();
    let middle = order.len() / 2;
    order.select_nth_unstable_by(middle, |&a, &b| {
        let at = |index: u32| samples[index as usize].position[axis];
        at(a).total_cmp(&at(b)).then(a.cmp(&b))
    });
    let (front, back) = order.split_at_mut(middle);
    build(samples, front, first, nodes);
    nodes[place].next = nodes.len() as u32;
    build(samples, back, first + middle, nodes);
}
